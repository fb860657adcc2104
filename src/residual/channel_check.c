#include "channel_check.h"

#include <math.h>

#include "clipping.h"
#include "params.h"

static const double ABSURD = 1e12;       /* magnitude, in any unit, that no sensor reads */

static const size_t STRIDE = sizeof(struct recording_sample) / sizeof(double);
_Static_assert(sizeof(struct recording_sample) % sizeof(double) == 0, "samples are addressed as doubles");

static double deviation(const struct recording_test *t, const double *first) {
    double sum = 0.0, square = 0.0, zero = NAN;
    int n = 0;
    for (int i = t->first; i < t->end; i++) {
        if (t->sample[i].refused) continue;
        double value = first[(size_t)(i - t->first) * STRIDE];
        if (!n++) zero = value;
        sum += value - zero, square += (value - zero) * (value - zero);
    }
    return sqrt(fmax(square - sum * sum / n, 0.0) / n);
}

static int check_alive(const struct recording_test *t, const double *first, const char *name, int leg, struct error *error) {
    if (deviation(t, first) > 0.0) return STATUS_OK;
    return error_set(error, STATUS_USAGE, "test %s: %s of leg %d does not change: a dead sensor, or a column of zeros",
                     recording_test_name(t), name, leg + 1);
}

/* Refuses a channel of one leg that is absurd, constant, or clipped for much of the time. */
static int check_channel(const struct recording_test *t, const double *first, const char *name, int leg, struct recording_scale scale,
                         struct error *error) {
    int n = t->end - t->first;
    for (int i = 0; i < n; i++) {
        double value = first[(size_t)i * STRIDE];
        if (!t->sample[t->first + i].refused && fabs(value) > ABSURD)
            return error_set(error, STATUS_USAGE, "test %s: %s of leg %d reads %.3g: no sensor says that; leave such samples out",
                             recording_test_name(t), name, leg + 1, value);
    }
    int status = check_alive(t, first, name, leg, error);
    if (status) return status;
    int clipped = recording_clipped(t, first, &scale);
    if (clipped)
        return error_set(error, STATUS_USAGE, "test %s: %s of leg %d is clipped in %d %% of the samples", recording_test_name(t), name,
                         leg + 1, 100 * clipped / n);
    return STATUS_OK;
}

/* Refuses a command that is constant or beyond 1. A command of 1 is the full opening, and no sign
 * of a clipped channel. */
static int check_command(const struct recording_test *t, int leg, struct error *error) {
    double most = 0.0;
    for (int i = t->first; i < t->end; i++)
        if (!t->sample[i].refused) most = fmax(most, fabs(t->sample[i].valve[leg]));
    if (most <= 1.0) return check_alive(t, &t->sample[t->first].valve[leg], "valve command", leg, error);
    return error_set(error, STATUS_USAGE, "test %s: the valve command of leg %d reaches %.3g, and 1 is full opening: volts, or percent?",
                     recording_test_name(t), leg + 1, most);
}

int channel_check(const struct recording *r, const struct recording_test *t, struct error *error) {
    const struct recording_sample *s = &t->sample[t->first];
    const struct recording_measured *m = &r->measured;
    struct recording_scale length = {HUGE_VAL, r->params->sensors.position_resolution_m, true}, force = {HUGE_VAL, 0.0, false};
    struct recording_scale pressure = {r->params->sensors.pressure_full_scale_pa * 0.999, 0.0, false};
    for (int k = 0; k < params_legs(r->params); k++) {
        int status = check_channel(t, &s->length_m[k], "length", k, length, error);
        if (!status && m->pressures) status = check_channel(t, &s->p1_pa[k], "p1", k, pressure, error);
        if (!status && m->pressures) status = check_channel(t, &s->p2_pa[k], "p2", k, pressure, error);
        if (!status && !m->pressures) status = check_channel(t, &s->force_n[k], "force", k, force, error);
        if (!status && m->valve) status = check_command(t, k, error);
        if (status) return status;
    }
    return STATUS_OK;
}
