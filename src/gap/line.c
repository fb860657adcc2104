#include "line.h"

#include "spectrum.h"

static const double LINE_POWER = 12.0;      /* of white noise, mean of six legs: 1 +- 0.4; */
static const double LINE_POWER_ONE = 30.0;  /* of one leg the strongest of 20 000 bins has 10 */

struct gap_line line_find(const struct recording *recording, double share) {
    struct gap_line found = {0};
    static const struct {
        enum channel channel;
        enum gap_channel name;
    } channels[] = {{CHANNEL_P1, GAP_P1}, {CHANNEL_P2, GAP_P2}, {CHANNEL_LENGTH, GAP_LENGTH}};
    double most = share * (params_legs(recording->params) > 1 ? LINE_POWER : LINE_POWER_ONE);
    for (int i = 0; i < recording->tests; i++) {
        struct spectrum s;
        if (!spectrum_measure(&s, &recording->test[i], CYCLES_ALL)) continue;
        for (size_t j = 0; j < sizeof channels / sizeof *channels; j++) {
            struct spectrum_line line = spectrum_find_line(&s, &recording->test[i], channels[j].channel);
            if (!(line.power > most)) continue;
            most = line.power;
            found = (struct gap_line){line.hz, line.rms, channels[j].name, recording->test[i].dof, recording->test[i].test};
        }
    }
    return found;
}
