#include "recording_check.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "clipping.h"
#include "force.h"
#include "frequency.h"
#include "inverse_dynamics.h"
#include "kinematics.h"
#include "leg_order.h"
#include "motion.h"
#include "numeric.h"
#include "params.h"
#include "reference_match.h"
#include "residual.h"
#include "sort.h"
#include "units.h"
#include "whiten.h"

static const double NEUTRAL_TOLERANCE_M = 0.05;
static const double TURNED_RAD = 0.3;   /* no motion has a mean pose that is turned by so much */
static const double SENSOR_SCALE = 0.06; /* a difference of force and weight may come from wrong
                                          * scales of the sensors if it is less than this share of
                                          * the sum of the chambers' forces */
static const double SUPPLY_MOST = 1.04;  /* a chamber may exceed this times the supply pressure in
                                          * at most 2 % of the samples */
/* The force works against the motion if the mean power is less than a share of rms force times rms
 * speed. The share is -WITHOUT_LOSS if force and acceleration agree, -AGAINST_SPRING if a spring
 * makes them disagree, WITH_LOSS if they look like the configured mass with the wrong sign. */
static const double WITHOUT_LOSS = 0.2, AGAINST_SPRING = 0.05, WITH_LOSS = 0.05;
static const double MIRRORED = 2.0; /* a mass looks like the configured one with the wrong sign if
                                     * their ratio is within this factor */
static const double ABSURD = 1e12;       /* magnitude, in any unit, that no sensor reads */
static const double FREQUENCY_SAME = 5e-5;  /* largest relative difference of two frequencies that
                                             * are the same: two crystals differ by less */
static const double NOISE_MOST = 0.5;       /* a test or segment is not judged if its rms noise
                                             * exceeds this share of its rms variation */

#define REFUSE(...) error_set(error, STATUS_USAGE, __VA_ARGS__)

static const char *test_name(const struct recording_test *t) { return t->dof == DOF_NONE ? "none" : dof_names[t->dof]; }

/* Returns the first test of the last run. Earlier runs were checked before. They must not be
 * averaged with the last one, which would hide a plug in the wrong socket. */
static int first_of_run(const struct recording *r) {
    int first = 0;
    while (first < r->tests - 1 && r->test[first].run < r->runs - 1) first++;
    return first;
}

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
    return REFUSE("test %s: %s of leg %d does not change: a dead sensor, or a column of zeros", test_name(t), name, leg + 1);
}

/* Refuses a channel of one leg that is absurd, constant, or clipped for much of the time. */
static int check_channel(const struct recording_test *t, const double *first, const char *name, int leg, struct recording_scale scale,
                         struct error *error) {
    int n = t->end - t->first;
    for (int i = 0; i < n; i++) {
        double value = first[(size_t)i * STRIDE];
        if (!t->sample[t->first + i].refused && fabs(value) > ABSURD)
            return REFUSE("test %s: %s of leg %d reads %.3g: no sensor says that; leave such samples out", test_name(t), name, leg + 1,
                          value);
    }
    int status = check_alive(t, first, name, leg, error);
    if (status) return status;
    int clipped = recording_clipped(t, first, &scale);
    if (clipped) return REFUSE("test %s: %s of leg %d is clipped in %d %% of the samples", test_name(t), name, leg + 1, 100 * clipped / n);
    return STATUS_OK;
}

/* Refuses a command that is constant or beyond 1. Commands are shares of the full opening, so a
 * command that stays at 1 is not clipped. */
static int check_command(const struct recording_test *t, int leg, struct error *error) {
    double most = 0.0;
    for (int i = t->first; i < t->end; i++)
        if (!t->sample[i].refused) most = fmax(most, fabs(t->sample[i].valve[leg]));
    if (most <= 1.0) return check_alive(t, &t->sample[t->first].valve[leg], "valve command", leg, error);
    return REFUSE("test %s: the valve command of leg %d reaches %.3g, and 1 is full opening: volts, or percent?", test_name(t), leg + 1,
                  most);
}

static int check_channels(const struct recording *r, const struct recording_test *t, struct error *error) {
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

/* Sets a steady sinusoid's frequency to the one at which the legs move. `any`: set to true for any
 * other motion. The stated frequency is a hint. */
static int check_frequency(struct recording_test *t, int legs, bool reference, bool *any, struct error *error) {
    double fitted_hz = t->dof == DOF_NONE ? (double)NAN : frequency_fit(t, legs, reference, t->frequency_hz),
           off = fabs(fitted_hz / t->stated_hz - 1.0);
    *any = !motion_sinusoid(t, legs, fitted_hz);
    if (*any) return STATUS_OK;
    if (off > FREQUENCY_SAME) t->frequency_hz = fitted_hz;
    if ((t->sample[t->end - 1].test_time_s - t->sample[t->first].test_time_s) * t->frequency_hz < RECORDING_CYCLES - 0.1)
        return REFUSE("test %s: %.3g s evaluated, too short: at least %d cycles of %g Hz are needed; in a run, raise tests.duration_s",
                      test_name(t), t->sample[t->end - 1].test_time_s - t->sample[t->first].test_time_s, RECORDING_CYCLES, t->frequency_hz);
    return STATUS_OK;
}

/* Guesses a missing reference as a sinusoid of the tested axis alone, with amplitude and phase
 * fitted to all legs. */
static void guess_reference(const struct recording_test *t, const struct kinematics *k, const double mean[LEGS], double wave[2]) {
    static const double small = 1e-4;
    double pose[DOFS] = {0}, moved[LEGS], w = 2.0 * PI * t->frequency_hz, square = 0.0;
    pose[t->dof] = small;
    ik_lengths(k, pose, moved);
    for (int leg = 0; leg < LEGS; leg++) square += pow((moved[leg] - k->neutral_length_m[leg]) / small, 2.0) * 0.5 * (t->end - t->first);
    for (int i = t->first; i < t->end; i++)
        for (int leg = 0; leg < LEGS && !t->sample[i].refused; leg++) {
            double x = (t->sample[i].length_m[leg] - mean[leg]) * (moved[leg] - k->neutral_length_m[leg]) / small / square;
            wave[0] += x * sin(w * t->sample[i].test_time_s), wave[1] += x * cos(w * t->sample[i].test_time_s);
        }
}

/* Adds a test's moments, which reveal wrong signs, exchanged legs and another machine. */
static void add_test(const struct recording *r, const struct recording_test *t, const struct kinematics *k, struct leg_moments *m) {
    double mean[LEGS] = {0}, sum[LEGS] = {0}, asked[LEGS], before[LEGS] = {0}, rate[LEGS], wave[2] = {0}, w = 2.0 * PI * t->frequency_hz,
           n = 0.0;
    double step_s = recording_step_s(t), last_s = -HUGE_VAL;
    for (int i = t->first; i < t->end; i++) n += !t->sample[i].refused;
    for (int i = t->first; i < t->end; i++)
        for (int leg = 0; leg < LEGS && !t->sample[i].refused; leg++) mean[leg] += t->sample[i].length_m[leg] / n;
    if (!r->measured.reference) guess_reference(t, k, mean, wave);
    for (int i = t->first; i < t->end; i++) {
        double pose[DOFS] = {0}, phase = w * t->sample[i].test_time_s;
        if (t->sample[i].refused) continue;
        if (!r->measured.reference) pose[t->dof] = wave[0] * sin(phase) + wave[1] * cos(phase);
        ik_lengths(k, r->measured.reference ? t->sample[i].ref : pose, asked);
        double since_s = t->sample[i].test_time_s - last_s;
        for (int a = 0; a < LEGS; a++) rate[a] = since_s < 1.5 * step_s ? (asked[a] - before[a]) / since_s : 0.0;
        memcpy(before, asked, sizeof before);
        last_s = t->sample[i].test_time_s;
        for (int a = 0; a < LEGS; a++) {
            double x = t->sample[i].length_m[a] - mean[a], y = asked[a] - k->neutral_length_m[a];
            sum[a] += y / n;
            m->measured[a] += x * x;
            for (int b = 0; b < LEGS; b++) {
                double other = asked[b] - k->neutral_length_m[b];
                m->product[a][b] += x * other, m->asked[a][b] += y * other;
                m->late[a][b] += x * rate[b], m->mixed[a][b] += rate[a] * other, m->rates[a][b] += rate[a] * rate[b];
            }
        }
    }
    /* The reference is taken about its mean, as the lengths are, because a segment of a motion may
     * be far from neutral. */
    for (int a = 0; a < LEGS; a++)
        for (int b = 0; b < LEGS; b++) m->asked[a][b] -= n * sum[a] * sum[b];
}

/* Refuses a reference against which all legs move; if a leg's sign were wrong, only this leg would.
 * The segments of a record are judged together, because in a single segment a weak loop may let the
 * legs move against the reference. */
static int check_reference(const struct recording *r, int first, int end, const struct kinematics *k, struct error *error) {
    const struct recording_test *t = &r->test[first];
    struct leg_moments m = {0};
    double product = 0.0, measured = 0.0, asked = 0.0;
    if (!r->measured.reference) return STATUS_OK;
    for (int i = first; i < end; i++) add_test(r, &r->test[i], k, &m);
    for (int a = 0; a < LEGS; a++) product += m.product[a][a], measured += m.measured[a], asked += m.asked[a][a];
    if (!(product < -0.5 * sqrt(measured * asked))) return STATUS_OK;
    return REFUSE("test %s: all legs move against the reference: the sign of its %s is wrong", test_name(t),
                  t->dof == DOF_NONE ? "reference" : reference_names[t->dof]);
}

/* Refuses a drawing that is turned or mirrored against the reference, which lengths and forces
 * alone cannot show, and legs that follow it in another order. */
static int check_drawing(const struct recording *r, const struct kinematics *k, struct error *error) {
    struct leg_moments m = {0};
    struct reference_match match;
    if (!r->measured.reference) return STATUS_OK;
    for (int i = first_of_run(r); i < r->tests; i++) add_test(r, &r->test[i], k, &m);
    reference_match_find(r->params, &m, &match);
    return match.refuted ? REFUSE("%s", match.text) : STATUS_OK;
}

static int check_legs(const struct recording *r, const struct kinematics *k, struct error *error) {
    struct leg_moments m = {0};
    for (int i = first_of_run(r), end; i < r->tests; i = end) {
        for (end = i + 1; end < r->tests && r->test[end].borrowed;) end++;
        int status = check_reference(r, i, end, k, error);
        if (status) return status;
    }
    for (int i = first_of_run(r); i < r->tests; i++) {
        if (r->measured.reference || !(r->test[i].segment_s > 0.0)) add_test(r, &r->test[i], k, &m);
    }
    for (int a = 0; a < LEGS; a++) {
        double own = m.product[a][a] / sqrt(m.measured[a] * m.asked[a][a]), best = own;
        int like = a;
        if (!isfinite(own)) return STATUS_OK; /* the leg or its reference is at rest */
        for (int b = 0; b < LEGS; b++) {
            double other = m.product[a][b] / sqrt(m.measured[a] * m.asked[b][b]);
            if (other > best + 0.2) best = other, like = b;
        }
        if (own < -0.5) return REFUSE("the length of leg %d moves against its reference: its sign is wrong", a + 1);
        if (like != a && best > 0.8) return REFUSE("the length of leg %d moves as leg %d should: two legs are exchanged", a + 1, like + 1);
        double scale = sqrt(m.measured[a] / m.asked[a][a]);
        if (!(scale > 0.2 && scale < 2.0)) /* the lower limit is wide, because a loop that cannot
                                            * follow moves a leg less than asked */
            return REFUSE("leg %d moves %.3g times as far as the reference asks for: other units, or another machine", a + 1, scale);
    }
    return STATUS_OK;
}

static void mean_lengths(const struct recording_test *t, double mean_m[LEGS]) {
    double n = 0.0;
    memset(mean_m, 0, LEGS * sizeof *mean_m);
    for (int i = t->first; i < t->end; i++) n += !t->sample[i].refused;
    for (int i = t->first; i < t->end; i++)
        for (int leg = 0; leg < LEGS && !t->sample[i].refused; leg++) mean_m[leg] += t->sample[i].length_m[leg] / n;
}

static int refuse_length(const struct params *p, const struct recording_test *t, int leg, const char *where, double length_m,
                         double model_m, struct error *error) {
    double mean_m[LEGS];
    char order[LEG_ORDER_TEXT], drawing[LEG_ORDER_TEXT + 80] = "";
    mean_lengths(t, mean_m);
    if (leg_order_of_drawing(p, mean_m, NEUTRAL_TOLERANCE_M, order))
        snprintf(drawing, sizeof drawing, "; or the joints of the platform are listed otherwise than those of the base: %s", order);
    return REFUSE("test %s: leg %d is %.4g m long%s, the model's %.4g: other units, or another machine%s", test_name(t), leg + 1, length_m,
                  where, model_m, drawing);
}

static int check_machine(const struct params *p, const struct recording_test *t, const struct kinematics *k, struct error *error) {
    double mean_m[LEGS];
    mean_lengths(t, mean_m);
    for (int leg = 0; leg < LEGS; leg++)
        if (fabs(mean_m[leg] - k->neutral_length_m[leg]) > NEUTRAL_TOLERANCE_M)
            return refuse_length(p, t, leg, " at its middle", mean_m[leg], k->neutral_length_m[leg], error);
    return STATUS_OK;
}

/* Refuses a drawing if no pose near neutral has the mean lengths, but the drawing would have just
 * these lengths at neutral if the joints of the platform were listed in another order than those of
 * the base. */
static int check_lists(const struct params *p, const struct recording_test *t, const struct kinematics *k, struct error *error) {
    double mean_m[LEGS], pose[DOFS] = {0}, turned = 0.0;
    char order[LEG_ORDER_TEXT];
    mean_lengths(t, mean_m);
    bool converged = fk_solve(k, mean_m, pose).converged;
    for (int i = DOF_PHI; i < DOFS; i++) turned = fmax(turned, fabs(pose[i]));
    if ((converged && turned < TURNED_RAD) || !leg_order_of_drawing(p, mean_m, NEUTRAL_TOLERANCE_M, order)) return STATUS_OK;
    return REFUSE("test %s: no pose of this drawing has these lengths: the joints of the platform are listed otherwise than those of the "
                  "base: %s",
                  test_name(t), order);
}

/* Refuses lengths more than NEUTRAL_TOLERANCE_M beyond the end stops; between the stops any motion
 * is allowed. */
static int check_reach(const struct params *p, const struct recording_test *t, const struct kinematics *k, struct error *error) {
    for (int leg = 0; leg < LEGS; leg++) {
        double stroke_m = p->actuator.stroke_m[leg], middle_m = kinematics_stroke(k, &p->actuator, leg).middle_m;
        for (int i = t->first; i < t->end; i++)
            if (!t->sample[i].refused && fabs(t->sample[i].length_m[leg] - middle_m) > 0.5 * stroke_m + NEUTRAL_TOLERANCE_M)
                return refuse_length(p, t, leg, "", t->sample[i].length_m[leg], middle_m, error);
    }
    return STATUS_OK;
}

static bool bears(double force_n, double weight_n) { return force_n > 0.2 * weight_n && force_n < 5.0 * weight_n; }

/* True if wrong scales of the sensors can explain a force that differs from the weight, because the
 * forces of the two chambers nearly cancel. Such a recording is accepted, so that the search can
 * find the scales. */
static bool within_sensors(double force_n, double weight_n, double chambers_n, double most_n) {
    return fabs(force_n - weight_n) < SENSOR_SCALE * chambers_n && chambers_n < most_n;
}

/* Refuses chambers whose pressure exceeds the supply's in more than 2 % of the samples. */
static int check_supply(const struct recording *r, struct error *error) {
    double supply_pa = r->params->hydraulics.supply_pa;
    for (int k = 0; k < params_legs(r->params); k++) {
        int n = 0, above = 0;
        for (int i = first_of_run(r); i < r->tests; i++)
            for (int j = r->test[i].first; j < r->test[i].end; j++) {
                const struct recording_sample *s = &r->test[i].sample[j];
                n += !s->refused;
                above += !s->refused && fmax(s->p1_pa[k], s->p2_pa[k]) > SUPPLY_MOST * supply_pa;
            }
        if (above > n / 50)
            return REFUSE("a chamber of leg %d has more than hydraulics.supply_pa, %.3g Pa, in %d %% of the samples: another supply, or "
                          "other units",
                          k + 1, supply_pa, 100 * above / n);
    }
    return STATUS_OK;
}

/* Compares mean forces with the weight: all legs together must carry the machine, and no leg may
 * differ from the others by as much as exchanged pressures would cause. */
static int check_pressures(const struct recording *r, struct error *error) {
    const struct params *p = r->params;
    struct cylinder_areas areas = cylinder_areas(&p->actuator);
    const struct recording_test *t = &r->test[first_of_run(r)], *last = &r->test[r->tests - 1];
    bool segments = t->segment_s > 0.0; /* segments of one record are averaged over all of it;
                                         * otherwise only the first test or segment counts */
    int from = t->first, until = segments && last->sample == t->sample ? last->end : t->end;
    double most_n = 0.0, weight = p->payload.mass_kg * p->payload.gravity_mps2, chambers = 0.0;
    double direct[LEGS] = {0}, exchanged = 0.0, sum = 0.0;
    int n = 0;
    for (int k = 0; k < LEGS; k++) {
        most_n += (areas.a1_m2[k] + areas.a2_m2[k]) * p->hydraulics.supply_pa;
        weight += p->actuator.upper_mass_kg[k] * p->payload.gravity_mps2;
    }
    for (int i = from; i < until; i++) n += !t->sample[i].refused;
    for (int i = from; i < until; i++)
        for (int k = 0; k < LEGS && !t->sample[i].refused; k++) {
            direct[k] += leg_force(&areas, k, t->sample[i].p1_pa[k], t->sample[i].p2_pa[k]) / n;
            chambers += (areas.a1_m2[k] * t->sample[i].p1_pa[k] + areas.a2_m2[k] * t->sample[i].p2_pa[k]) / n;
            exchanged += leg_force(&areas, k, t->sample[i].p2_pa[k], t->sample[i].p1_pa[k]) / n;
        }
    for (int k = 0; k < LEGS; k++) sum += direct[k];
    for (int k = 0; k < LEGS; k++) {
        double others = (sum - direct[k]) / (LEGS - 1);
        if (bears(LEGS * others, weight) && fabs(direct[k] - others) > 2.0 * weight)
            return REFUSE("the mean force of leg %d is %.3g N, the others' %.3g: p1 and p2 exchanged there, or a sign wrong", k + 1,
                          direct[k], others);
    }
    if (!bears(sum, weight) && !within_sensors(sum, weight, chambers, most_n))
        return REFUSE("the legs hold %.3g N in all, a machine of this weight needs about %.3g: %s", sum, 1.2 * weight,
                      bears(exchanged, weight) ? "p1 and p2 are exchanged" : "other units, or another machine");
    return STATUS_OK;
}

/* Refuses measured positions of a single axis that lie outside its stroke. */
static int check_stroke(const struct params *p, const struct recording_test *t, struct error *error) {
    double low = HUGE_VAL, high = -HUGE_VAL, middle = p->axis.middle_m, half = 0.5 * p->actuator.stroke_m[0];
    for (int i = t->first; i < t->end; i++) {
        if (t->sample[i].refused) continue;
        low = fmin(low, t->sample[i].length_m[0]), high = fmax(high, t->sample[i].length_m[0]);
    }
    if (low >= middle - half && high <= middle + half) return STATUS_OK;
    return REFUSE("the position runs from %.4g to %.4g m, outside a stroke of %g m about %g m (actuator.stroke_m, "
                  "axis.middle_m): other units, or another zero",
                  low, high, p->actuator.stroke_m[0], middle);
}

/* Power with which the force of a single axis drives its motion, over the evaluated parts. */
struct drive {
    /* power: sum of F v over the instants; effort: largest possible power with this rms force and
     * speed */
    double power, effort;
    double mass_kg;        /* mass that fits the force to the acceleration by least squares */
    double most_kg;       /* mass that the rms force could move with the rms acceleration */
};

/* Adds a test's sums over its phases of F v, F a, a^2, F^2 and v^2, F about its mean, from the
 * fundamental of a cycle or all harmonics of a segment. exchanged: compute them as if p1 and p2
 * were exchanged. */
static void add_drive(const struct recording *r, const struct residual_test *t, bool exchanged, double sum[5]) {
    struct cylinder_areas areas = cylinder_areas(&r->params->actuator);
    const struct spectrum *s = &t->spectrum;
    int harmonics = s->cycles ? 1 : t->harmonics;
    double force[SPECTRUM_SIZE], f_mean = 0.0;
    for (int a = 0; a < SPECTRUM_SIZE; a++)
        force[a] = exchanged ? leg_force(&areas, 0, s->mean[CHANNEL_P2][0][a], s->mean[CHANNEL_P1][0][a]) : s->mean[CHANNEL_FORCE][0][a];
    for (int pass = 0; pass < 2; pass++)
        for (int i = 0; i < t->phases; i++) {
            const double *basis = t->cycle + i * SPECTRUM_SIZE;
            double x[3], f[3];
            spectrum_at(s->mean[CHANNEL_LENGTH][0], harmonics, s->omega, basis, x);
            spectrum_at(force, harmonics, s->omega, basis, f);
            if (!pass) {
                f_mean += f[0] / t->phases;
                continue;
            }
            f[0] -= f_mean;
            sum[0] += f[0] * x[1], sum[1] += f[0] * x[2], sum[2] += x[2] * x[2], sum[3] += f[0] * f[0], sum[4] += x[1] * x[1];
        }
}

static struct drive drive_of(const struct recording *r, const struct residual_data *data, bool exchanged) {
    double sum[5] = {0};
    for (int i = 0; i < data->tests; i++)
        if (data->test[i].of >= first_of_run(r)) add_drive(r, &data->test[i], exchanged, sum);
    return (struct drive){.power = sum[0], .effort = sqrt(sum[3] * sum[4]), .mass_kg = sum[1] / sum[2], .most_kg = sqrt(sum[3] / sum[2])};
}

/* True if the force drives the motion. The true force does, whatever the friction, so the power
 * shows whether the sign of the force is right. A spring makes the mass look negative, but returns
 * its energy. Only if the mass looks like the configured one with the wrong sign must the power be
 * clearly positive. */
static bool drives(const struct drive *d, double mass_kg) {
    double least = d->mass_kg > -mass_kg / MIRRORED ? -WITHOUT_LOSS : d->mass_kg > -mass_kg * MIRRORED ? WITH_LOSS : -AGAINST_SPRING;
    return d->power > least * d->effort;
}

static int check_axis(const struct recording *r, const struct residual_data *data, struct error *error) {
    double mass_kg = r->params->axis.mass_kg;
    struct drive d = drive_of(r, data, false), other = drive_of(r, data, true);
    bool exchanged = r->measured.pressures && drives(&other, mass_kg), steady = data->test[data->tests - 1].spectrum.cycles;
    if (!drives(&d, mass_kg))
        return REFUSE("the force works against the motion, as if the mass were %.3g kg: %s", d.mass_kg,
                      exchanged ? "p1 and p2 are exchanged, or the position's sign is wrong" : "the sign of force or position is wrong");
    if (steady && (d.mass_kg > 10.0 * mass_kg || d.most_kg < 0.3 * mass_kg))
        return REFUSE("force and motion would go together if the mass were %.3g kg; the model has %.3g (axis.mass_kg): "
                      "other units, or another machine",
                      d.mass_kg > mass_kg ? d.mass_kg : d.most_kg, mass_kg);
    return STATUS_OK;
}

/* Sums over all tests of the products of one leg's measured and another leg's expected values, and
 * of the squares of both, which show signs and order of the legs. */
struct leg_likeness {
    double product[LEGS][LEGS], does[LEGS], should[LEGS];
};

static void add_likeness(int first, int end, const double *does, int leg, const double *should, int other, struct leg_likeness *l) {
    for (int a = first; a < end; a++) {
        l->product[leg][other] += does[a] * should[a];
        if (other == leg) l->does[leg] += does[a] * does[a], l->should[leg] += should[a] * should[a];
    }
}

static double likeness(const struct leg_likeness *l, int leg, int other) {
    return l->product[leg][other] / sqrt(l->does[leg] * l->should[other]);
}

static bool exchanged(const struct leg_likeness *l, int a, int b) {
    double margin = fmin(likeness(l, a, b) - likeness(l, a, a), likeness(l, b, a) - likeness(l, b, b));
    return margin > 0.2 && likeness(l, a, b) > 0.8;
}

/* Refuses exchanged legs and wrong signs. most: largest number of wrong signs that is believed. If
 * more legs move in the wrong direction, the cause acts on all of them and is no exchanged plug. */
static int check_likeness(const struct leg_likeness *l, int legs, int most, const char *what, const char *as, struct error *error) {
    for (int a = 0; a < legs; a++)
        for (int b = 0; b < a; b++)
            if (exchanged(l, a, b))
                return REFUSE("%s of leg %d goes as leg %d's should, by %s: two legs are exchanged", what, b + 1, a + 1, as);
    int against = 0;
    for (int a = 0; a < legs; a++) against += likeness(l, a, a) < -0.5;
    for (int a = 0; a < legs && against <= most; a++)
        if (likeness(l, a, a) < -0.5) return REFUSE("%s of leg %d goes against %s: its sign is wrong", what, a + 1, as);
    return STATUS_OK;
}

/* Removes the constant from a coefficient row, because the weight, which is in the force of every
 * leg, would make all legs alike. */
static void vary(const struct residual_test *t, double row[RESIDUAL_SIZE]) {
    double along = 0.0, square = 0.0;
    for (int a = 0; a < t->size; a++) along += row[a] * t->coupling[a][0], square += t->coupling[a][0] * t->coupling[a][0];
    for (int a = 0; a < t->size; a++) row[a] -= along / square * t->coupling[a][0];
}

/* Compares measured forces with the forces that the motion needs, and valve commands with the legs'
 * speeds. */
static int check_drives(const struct recording *r, const struct residual_data *data, struct error *error) {
    struct leg_likeness force = {0}, valve = {0};
    int legs = params_legs(r->params), status = STATUS_OK;
    for (int i = 0; i < data->tests && !status; i++) {
        const struct residual_test *t = &data->test[i];
        double needed[LEGS][RESIDUAL_SIZE], rate[RESIDUAL_SIZE], does[RESIDUAL_SIZE];
        int first = t->spectrum.cycles ? 1 : 0, end = t->spectrum.cycles ? 3 : t->size;
        if (t->of < first_of_run(r)) continue;
        if (!residual_required(t, r->params, needed))
            status = REFUSE("test %s: no pose of this machine has these lengths: other units, or another machine",
                            test_name(&r->test[t->of]));
        for (int b = 0; b < legs && !status; b++) {
            residual_rate(t, b, rate);
            vary(t, needed[b]);
            for (int a = 0; a < legs; a++) {
                memcpy(does, t->row[CHANNEL_FORCE][a], sizeof does);
                vary(t, does);
                add_likeness(first, end, does, a, needed[b], b, &force);
                add_likeness(first, end, t->row[CHANNEL_VALVE][a], a, rate, b, &valve);
            }
        }
    }
    const char *what = r->measured.pressures ? "the force A1 P1 - A2 P2" : "the force";
    if (!status) status = check_likeness(&force, legs, legs / 2, what, "its motion", error);
    if (!status && r->measured.valve) status = check_likeness(&valve, legs, legs, "the valve command", "its speed", error);
    return status;
}

/* Median, for an even number the lower middle value. Sorts the values. */
static double middle(int count, double *value) {
    sort_ascending(count, value);
    return value[(count - 1) / 2];
}

static const enum channel kind_channel[RESIDUALS] = {CHANNEL_FORCE, CHANNEL_P1, CHANNEL_P2};

/* Mean of a channel over the instants of a test. */
static double level_of(const struct residual_test *t, enum channel channel, int leg) {
    double sum = 0.0;
    for (int i = 0; i < t->phases; i++) {
        double value[3];
        spectrum_at(t->spectrum.mean[channel][leg], t->harmonics, t->spectrum.omega, t->cycle + i * SPECTRUM_SIZE, value);
        sum += value[0];
    }
    return sum / t->phases;
}

typedef double levels[RESIDUALS][LEGS];

/* Computes the means of the channels over all segments. A force that is constant within each
 * segment, as dry friction is in a slow stroke, varies from one segment to the next. */
static void mean_levels(const struct recording *r, const struct residual_data *data, levels mean) {
    int segments = 0;
    memset(mean, 0, sizeof(levels));
    for (int pass = 0; pass < 2; pass++)
        for (int i = 0; i < data->tests; i++) {
            const struct residual_test *t = &data->test[i];
            if (t->spectrum.cycles || t->of < first_of_run(r)) continue;
            if (!pass) segments++;
            for (int kind = 0; pass && kind < RESIDUALS; kind++)
                for (int k = 0; k < t->legs; k++) mean[kind][k] += level_of(t, kind_channel[kind], k) / segments;
        }
}

/* Share of noise in a test's mean square variation: that of the force, or with evaluated chambers
 * the median of force and both pressures, because a chamber may hardly change its pressure. mean:
 * levels; the difference of a segment's level from them counts as variation. NULL: only variation
 * within the segment counts. */
static double noise_share(const struct residual_test *t, const struct params *params, double (*mean)[LEGS], struct whitener *w) {
    int kinds = t->chambers ? RESIDUALS : 1;
    double share[RESIDUALS];
    whitener_init(w, t, params, NOISE_ALONE);
    for (int kind = 0; kind < kinds; kind++) {
        double noise = 0.0, varies = 0.0;
        for (int k = 0; k < t->legs; k++) {
            /* in a cycle the constant is left out, because it is undetermined in a chamber whose
             * valve stays shut */
            for (int a = t->spectrum.cycles ? 1 : 0; a < t->size; a++) noise += t->weight[a] * w->noise[k][a][kind];
            varies += residual_variation(t, kind_channel[kind], k);
            if (mean && !t->spectrum.cycles) varies += square(level_of(t, kind_channel[kind], k) - mean[kind][k]);
        }
        share[kind] = varies > 0.0 ? noise / varies : 1.0;
    }
    return middle(kinds, share);
}

/* Marks segments that are mostly noise, so that they are not evaluated. Returns the median share of
 * noise in the rms variation. */
static double mark_noise(struct recording *r, const struct residual_data *data, double (*mean)[LEGS], struct whitener *w) {
    double share[RECORDING_TESTS];
    int n = 0;
    for (int i = 0; i < data->tests; i++) {
        struct recording_test *t = &r->test[data->test[i].of];
        if (data->test[i].of < first_of_run(r)) continue;
        share[n] = noise_share(&data->test[i], r->params, mean, w);
        t->refused = t->segment_s > 0.0 && !(sqrt(share[n]) <= NOISE_MOST) ? REFUSED_NOISE : REFUSED_NOT;
        n++;
    }
    return n ? sqrt(middle(n, share)) : 0.0;
}

/* Refuses a log if most of its tests or segments are noise. Where strokes are so slow that the
 * force hardly varies within a segment, its variation from one segment to the next counts, too. */
static int check_noise(struct recording *r, const struct residual_data *data, struct error *error) {
    struct whitener *w = malloc(sizeof *w);
    levels mean;
    if (!w) return error_set(error, STATUS_IO, "out of memory");
    double most = mark_noise(r, data, NULL, w);
    mean_levels(r, data, mean);
    if (most > NOISE_MOST) most = mark_noise(r, data, mean, w);
    free(w);
    if (!(most > NOISE_MOST)) return STATUS_OK;
    return REFUSE("noise is %.0f %% of what varies in the %s that are evaluated, and above %.0f %% nothing can be said of them: larger or "
                  "faster motion, or finer sensors",
                  100.0 * most, r->measured.pressures ? "pressures and forces" : "forces", 100.0 * NOISE_MOST);
}

/* Stores the frequencies at which the tests moved in the run's parameters, so that the run can be
 * simulated at them. */
static void run_at(struct recording *r, int first) {
    double *hz = r->run[r->runs - 1].hz;
    for (int i = first; i < r->tests; i++) {
        const struct recording_test *t = &r->test[i];
        /* false for NaN, the frequency of a motion that is no sinusoid */
        bool other = t->dof != DOF_NONE && fabs(t->frequency_hz / hz[t->dof] - 1.0) > FREQUENCY_SAME;
        if (other) hz[t->dof] = t->frequency_hz;
    }
}

static bool has_lengths(const struct recording_test *t, int legs) {
    for (int i = t->first; i < t->end; i++) {
        int finite = 0;
        for (int k = 0; k < legs; k++) finite += isfinite(t->sample[i].length_m[k]) != 0;
        if (finite == legs) return true;
    }
    return false;
}

/* Refuses channels whose legs are not in the order of the drawing. */
static int check_order(const struct recording *r, const struct residual_data *data, struct error *error) {
    struct leg_order order;
    int status = leg_order_find(data, r, first_of_run(r), &order, error);
    if (status || !order.refuted) return status;
    return REFUSE("lengths, forces and drawing do not belong together; they would with %s (which leaves %.1f %% of the varying force "
                  "unexplained, the stated order %.0f %%)",
                  order.text, 100.0 * order.best, 100.0 * order.stated);
}

/* Removes one test and keeps the reason, so that the remaining tests are still evaluated. */
static int exclude(struct recording *r, int test, const struct error *why) {
    r->exclusion = *why;
    r->excluded++;
    recording_remove(r, test);
    return STATUS_OK;
}

/* Refuses lengths that this machine cannot have. k: NULL for a single axis; any: the motion is no
 * steady sinusoid. */
static int check_lengths(struct recording *r, const struct recording_test *t, const struct kinematics *k, bool any, struct error *error) {
    int status = k && any ? check_lists(r->params, t, k, error) : STATUS_OK;
    if (!status && !k) status = check_stroke(r->params, t, error);
    if (!status && k) status = any ? check_reach(r->params, t, k, error) : check_machine(r->params, t, k, error);
    if (status == STATUS_USAGE) r->refuted = true;
    return status;
}

/* Refuses a recording whose lengths, forces and reference are not those of the configured
 * machine. */
static int check_contradictions(struct recording *r, const struct residual_data *data, const struct kinematics *k, struct error *error) {
    bool pose = params_mechanism(r->params)->pose;
    int status = pose ? check_order(r, data, error) : STATUS_OK;
    if (!status && pose) status = check_drawing(r, k, error);
    if (!status) status = pose ? check_legs(r, k, error) : check_axis(r, data, error);
    if (status == STATUS_USAGE) r->refuted = true;
    if (!status && r->measured.pressures) status = check_supply(r, error);
    if (!status && pose && r->measured.pressures) status = check_pressures(r, error);
    return status ? status : check_drives(r, data, error);
}

int recording_check(struct recording *r, struct error *error) {
    struct kinematics k;
    bool pose = params_mechanism(r->params)->pose;
    int status = pose ? kinematics_init(&k, r->params, error) : STATUS_OK;
    if (status) return status;
    if (!r->tests) return REFUSE("no sinusoidal test in the log");
    if (!r->measured.force) return REFUSE("neither pressures nor forces in the log: there is nothing to hold against the motion");
    if (r->runs > 1 && memcmp(&r->measured, &r->measured_before, sizeof r->measured))
        return REFUSE("it has not the same channels as the log before: pressures, valve commands or reference");
    r->refuted = false;
    recording_settle(r);
    for (int i = first_of_run(r); i < r->tests; i++) {
        struct recording_test *t = &r->test[i];
        double seconds = t->first < 0 ? 0.0 : t->sample[t->end - 1].test_time_s - t->sample[t->first].test_time_s;
        int good = 0;
        bool any = false;
        for (int j = t->first; j >= 0 && j < t->end; j++) good += !t->sample[j].refused;
        if (seconds > 0.0 && !has_lengths(t, params_legs(r->params)))
            return REFUSE("test %s: no sample has the lengths of all legs: there is no motion to hold the forces against", test_name(t));
        if (seconds > 0.0 && 2 * good < t->end - t->first)
            return REFUSE("test %s: more than half of its samples are flagged, or have a value that is no number", test_name(t));
        if (!(seconds > 0.0)) return REFUSE("test %s: nothing in it is to be evaluated", test_name(t));
        status = check_channels(r, t, error);
        if (!status) status = check_frequency(t, params_legs(r->params), r->measured.reference, &any, error);
        if (!status) status = check_lengths(r, t, pose ? &k : NULL, any, error);
        if (!status && any) {
            int tests = r->tests;
            status = motion_cut(r, i, error);
            i += r->tests - tests;
            /* A test of one axis is not left out, because a matrix without it would be a different
             * result. */
            bool spare = !pose || t->dof == DOF_NONE;
            if (status == STATUS_USAGE && spare && r->tests > first_of_run(r) + 1) status = exclude(r, i--, error);
        }
        if (status) return status;
    }
    status = motion_enough(r, error);
    if (status) return status;
    run_at(r, first_of_run(r));
    struct residual_data data;
    status = residual_prepare(&data, r, CYCLES_ALL, error);
    if (!status) status = check_contradictions(r, &data, &k, error);
    residual_free(&data);
    return status;
}

int recording_check_noise(struct recording *r, struct error *error) {
    struct residual_data data;
    int status = residual_prepare(&data, r, CYCLES_ALL, error);
    if (!status) status = check_noise(r, &data, error);
    residual_free(&data);
    return status;
}
