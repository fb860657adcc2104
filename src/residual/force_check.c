#include "force_check.h"

#include <math.h>
#include <string.h>

#include "force.h"
#include "params.h"

static const double SENSOR_SCALE = 0.06; /* wrong scales of the sensors can explain a difference of
                                          * force and weight below this share of the sum of the
                                          * chambers' forces */
static const double SUPPLY_MOST = 1.04;  /* a chamber may exceed this times the supply pressure in
                                          * at most 2 % of the samples */
/* The force works against the motion if the mean power is less than a share of rms force times rms
 * speed. This share depends on the mass that fits force and acceleration: -WITHOUT_LOSS for a
 * positive or slightly negative mass; WITH_LOSS for a mass near minus the configured one, which a
 * wrong sign of the force makes; -AGAINST_SPRING for a still more negative mass, which a spring
 * makes. */
static const double WITHOUT_LOSS = 0.2, AGAINST_SPRING = 0.05, WITH_LOSS = 0.05;
static const double MIRRORED = 2.0; /* a negative fitted mass is near minus the configured mass if
                                     * their magnitudes differ by less than this factor */

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
        for (int i = recording_first_of_run(r); i < r->tests; i++)
            for (int j = r->test[i].first; j < r->test[i].end; j++) {
                const struct recording_sample *s = &r->test[i].sample[j];
                n += !s->refused;
                above += !s->refused && fmax(s->p1_pa[k], s->p2_pa[k]) > SUPPLY_MOST * supply_pa;
            }
        if (above > n / 50)
            return error_set(error, STATUS_USAGE,
                             "a chamber of leg %d has more than hydraulics.supply_pa, %.3g Pa, in %d %% of the samples: another supply, or "
                             "other units",
                             k + 1, supply_pa, 100 * above / n);
    }
    return STATUS_OK;
}

/* Compares mean forces with the weight: all legs together must carry the machine, and no leg may
 * differ from the others by as much as exchanged pressures would cause. */
static int check_weight(const struct recording *r, struct error *error) {
    const struct params *p = r->params;
    struct cylinder_areas areas = cylinder_areas(&p->actuator);
    const struct recording_test *t = &r->test[recording_first_of_run(r)], *last = &r->test[r->tests - 1];
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
            return error_set(error, STATUS_USAGE,
                             "the mean force of leg %d is %.3g N, the others' %.3g: p1 and p2 exchanged there, or a sign wrong", k + 1,
                             direct[k], others);
    }
    if (!bears(sum, weight) && !within_sensors(sum, weight, chambers, most_n))
        return error_set(error, STATUS_USAGE, "the legs hold %.3g N in all, a machine of this weight needs about %.3g: %s", sum,
                         1.2 * weight, bears(exchanged, weight) ? "p1 and p2 are exchanged" : "other units, or another machine");
    return STATUS_OK;
}

int force_check_pressures(const struct recording *r, struct error *error) {
    int status = check_supply(r, error);
    return !status && params_mechanism(r->params)->pose ? check_weight(r, error) : status;
}

/* Power with which the force of a single axis drives its motion, over the evaluated parts. */
struct drive {
    /* power: sum of F v over the instants; effort: largest possible power with this rms force and
     * speed */
    double power, effort;
    double mass_kg;        /* mass that fits the force to the acceleration by least squares */
    double most_kg;       /* mass that the rms force could move with the rms acceleration */
};

/* Adds five sums over a test's instants to `sum`: of F v, F a, a^2, F^2 and v^2, where F is the
 * force less its mean, v the speed and a the acceleration. They come from the fundamental of a
 * steady sinusoid, or from all harmonics of a segment. exchanged: compute F as if p1 and p2 were
 * exchanged. */
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
        if (data->test[i].of >= recording_first_of_run(r)) add_drive(r, &data->test[i], exchanged, sum);
    return (struct drive){.power = sum[0], .effort = sqrt(sum[3] * sum[4]), .mass_kg = sum[1] / sum[2], .most_kg = sqrt(sum[3] / sum[2])};
}

/* True if the force drives the motion. A force of the right sign supplies the power that friction
 * dissipates, so the sign of the power shows whether the sign of the force is right. A spring makes
 * the fitted mass negative, but takes no mean power. The power must be clearly positive only if the
 * fitted mass is near minus the configured one. */
static bool drives(const struct drive *d, double mass_kg) {
    double least = d->mass_kg > -mass_kg / MIRRORED ? -WITHOUT_LOSS : d->mass_kg > -mass_kg * MIRRORED ? WITH_LOSS : -AGAINST_SPRING;
    return d->power > least * d->effort;
}

int force_check_axis(const struct recording *r, const struct residual_data *data, struct error *error) {
    double mass_kg = r->params->axis.mass_kg;
    struct drive d = drive_of(r, data, false), other = drive_of(r, data, true);
    bool exchanged = r->measured.pressures && drives(&other, mass_kg), steady = data->test[data->tests - 1].spectrum.cycles;
    if (!drives(&d, mass_kg))
        return error_set(error, STATUS_USAGE, "the force works against the motion, as if the mass were %.3g kg: %s", d.mass_kg,
                         exchanged ? "p1 and p2 are exchanged, or the position's sign is wrong" : "the sign of force or position is wrong");
    if (steady && (d.mass_kg > 10.0 * mass_kg || d.most_kg < 0.3 * mass_kg))
        return error_set(error, STATUS_USAGE,
                         "force and motion would go together if the mass were %.3g kg; the model has %.3g (axis.mass_kg): "
                         "other units, or another machine",
                         d.mass_kg > mass_kg ? d.mass_kg : d.most_kg, mass_kg);
    return STATUS_OK;
}

/* Sums over all tests, which show wrong signs and exchanged legs. product: of the values measured
 * in one leg times those expected in another. does, should: of the squares of the measured and of
 * the expected values. */
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

/* Refuses exchanged legs and wrong signs. most: wrong signs are refused only if at most this many
 * legs have one. If more legs have one, they have a common cause, which is no exchanged plug. */
static int check_likeness(const struct leg_likeness *l, int legs, int most, const char *what, const char *as, struct error *error) {
    for (int a = 0; a < legs; a++)
        for (int b = 0; b < a; b++)
            if (exchanged(l, a, b))
                return error_set(error, STATUS_USAGE, "%s of leg %d goes as leg %d's should, by %s: two legs are exchanged", what, b + 1,
                                 a + 1, as);
    int against = 0;
    for (int a = 0; a < legs; a++) against += likeness(l, a, a) < -0.5;
    for (int a = 0; a < legs && against <= most; a++)
        if (likeness(l, a, a) < -0.5)
            return error_set(error, STATUS_USAGE, "%s of leg %d goes against %s: its sign is wrong", what, a + 1, as);
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
int force_check_drives(const struct recording *r, const struct residual_data *data, struct error *error) {
    struct leg_likeness force = {0}, valve = {0};
    int legs = params_legs(r->params), status = STATUS_OK;
    for (int i = 0; i < data->tests && !status; i++) {
        const struct residual_test *t = &data->test[i];
        double needed[LEGS][RESIDUAL_SIZE], rate[RESIDUAL_SIZE], does[RESIDUAL_SIZE];
        int first = t->spectrum.cycles ? 1 : 0, end = t->spectrum.cycles ? 3 : t->size;
        if (t->of < recording_first_of_run(r)) continue;
        if (!residual_required(t, r->params, needed))
            status = error_set(error, STATUS_USAGE, "test %s: no pose of this machine has these lengths: other units, or another machine",
                               recording_test_name(&r->test[t->of]));
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
