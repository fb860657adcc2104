#include "experiment.h"

#include <stdio.h>
#include <string.h>

static const struct effect_experiment general = {
    .record = "`--set tests.frequency_hz=2` and `--set tests.amplitude_m=0.002 --set tests.amplitude_rad=0.003`",
    .record_axis = "a test at half the frequency, and one at half the amplitude",
    .shows = "effects scale differently with speed and stroke",
};

static const struct effect_experiment *find(const struct effect *effect, const struct effect *from) {
    for (int i = 0; i < EFFECT_TIES && effect->told_apart[i].record; i++)
        if (effect->told_apart[i].from == from) return &effect->told_apart[i];
    return NULL;
}

static void say(const struct mechanism *mechanism, const struct effect_experiment *e, char text[GAP_TEXT]) {
    if (!e) e = &general;
    bool own = mechanism->refuses.run && e->record_axis;
    snprintf(text, GAP_TEXT, "%s: %s", own ? e->record_axis : e->record, e->shows);
}

void experiment_between(const struct mechanism *mechanism, const struct effect *a, const struct effect *b, char text[GAP_TEXT]) {
    const struct effect_experiment *e = find(a, b);
    say(mechanism, e ? e : find(b, a), text);
}

bool experiment_is_known(const struct effect *a, const struct effect *b) { return find(a, b) || find(b, a); }

void experiment_from_parameter(const struct mechanism *mechanism, const struct effect *effect, const char *parameter, char text[GAP_TEXT]) {
    const struct effect_experiment *e = effect->told_apart, *end = e + EFFECT_TIES;
    while (e < end && e->record && (e->from || strcmp(e->from_parameter, parameter))) e++;
    say(mechanism, e < end && e->record ? e : NULL, text);
}

void experiment_other_frequency(const struct mechanism *mechanism, double hz, char text[GAP_TEXT]) {
    char record[80];
    snprintf(record, sizeof record, "`--set tests.frequency_hz=%.3g`, and both logs", 0.5 * hz);
    const struct effect_experiment half = {
        .record = record,
        .record_axis = "a test at half the frequency, and both recordings",
        .shows = "a mass or a spring has the same value at both frequencies, a part that moves by itself has not",
    };
    say(mechanism, &half, text);
}

const char *experiment_when_warm(void) {
    return "the same tests twice, one after the other: a friction that changes with time is another one in the second run, else it "
           "is the same";
}

const char *experiment_unknown(void) {
    return "repeat the test where the gap is largest at half the frequency and at half the amplitude, and look how the gap scales";
}
