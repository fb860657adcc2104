#include "blind_time.h"

#include <math.h>

#include "params.h"

static const double tick_s = 1e-3, rounding = 1e-9;

struct blind_time blind_time(const struct params *p) {
    double period_s = p->loop.period_s, age_s = p->limits.sensor_age_s, watchdog_s = p->device.watchdog_s;
    struct blind_time cases[] = {
        {age_s + watchdog_s + tick_s, "a daemon that is killed or stopped", "limits.sensor_age_s + device.watchdog_s + 1 ms", false},
        {2 * age_s + (p->limits.bad_cycles + 1) * period_s, "readings that no longer come",
         "2 x limits.sensor_age_s + (limits.bad_cycles + 1) x loop.period_s", false},
        {(p->loop.overrun_limit + 1) * period_s + age_s, "a loop that is late",
         "(loop.overrun_limit + 1) x loop.period_s + limits.sensor_age_s", false},
        {watchdog_s + tick_s + (p->limits.bad_cycles + 2) * period_s, "commands that do not reach all legs",
         "device.watchdog_s + 1 ms + (limits.bad_cycles + 2) x loop.period_s", false},
    };
    struct blind_time *longest = cases;
    /* SAFETY: NaN counts as the longest time, so that it is not allowed. */
    for (unsigned i = 1; i < sizeof cases / sizeof *cases; i++)
        if (!isnan(longest->s) && !(cases[i].s <= longest->s)) longest = &cases[i];
    longest->allowed = longest->s <= p->limits.blind_time_s * (1 + rounding);
    return *longest;
}
