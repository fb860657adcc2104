#include "replay.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "ident.h"
#include "memory.h"
#include "numeric.h"
#include "parallel.h"
#include "plant.h"
#include "platform.h"
#include "residual.h"
#include "units.h"
#include "whiten.h"

static const int64_t SLACK_CYCLES = 1000;
static const double WIDER = 4.0; /* factor on the limits of faults, so that a model that moves worse
                                  * than the machine ends in a larger gap, not in a fault */

/* Parameters of a simulated run: the tests of a recorded run in their order, with wider limits and
 * without interlocks. */
static struct params replay_params(const struct params *model, const struct recording *like, int run) {
    struct params p = *model;
    p.tests = like->run[run];
    p.tests.count = 0;
    p.tests.multisine = false, p.tests.trajectory[0] = '\0';
    for (int i = 0; i < like->tests && p.tests.count < DOFS; i++)
        if (like->test[i].run == run) p.tests.order[p.tests.count++] = like->test[i].dof;
    for (int i = p.tests.count; i < DOFS; i++) p.tests.order[i] = DOF_NONE;
    p.motion.automatic = true;
    p.limits.following_m *= WIDER, p.limits.standstill_m *= WIDER, p.limits.force_n *= WIDER;
    /* an oscillation is to show in the gap, not to end the run */
    p.limits.oscillation_mps2 *= WIDER * WIDER;
    p.sim.engine = ENGINE_CLOSED_FORM;
    p.interlocks = (struct interlock_params){0}; /* the simulated supply is always on */
    p.motion.rest_s = 0.0;
    return p;
}

static int64_t longest(const struct params *p) {
    return (int64_t)(reference_run_s(&p->motion, &p->tests) / p->loop.period_s) + SLACK_CYCLES;
}

static int drive(struct plant *plant, struct platform *platform, const struct params *p, struct recording *out, struct error *error) {
    struct hal_sample sample = {0};
    struct cycle c = {0};
    int64_t last = longest(p);
    for (int64_t i = 0; i < last; i++) {
        sample.time_ns = ns_from_seconds((double)i * p->loop.period_s);
        sample.device_seq = (uint64_t)i + 1;
        plant_measure(plant, &sample);
        platform_step(platform, &sample, (struct request){0}, &c);
        int status = recording_add(out, &c, error);
        if (status) return status;
        if (c.faults) return error_set(error, STATUS_USAGE, "the simulated run ended in a fault (%s)", fault_name(c.first_fault));
        if (c.state == STATE_PARKING) return STATUS_OK;
        plant_step(plant, c.out.enable ? c.out.valve : (const double[LEGS]){0});
    }
    return error_set(error, STATUS_USAGE, "the simulated run did not come to its end");
}

/* Simulates one run. machine: the tried model, which is the simulated plant. controller: the
 * configured machine with the tried model's controller gains, because the control law `model` must
 * not know the tried effects. */
static int replay_run(const struct params *machine, const struct params *controller, struct recording *out, struct error *error) {
    struct plant *plant = plant_create(machine, 1, error);
    struct platform *platform = memory_get(1, sizeof *platform);
    int status = plant ? platform_init(platform, controller, error) : (int)error->status;
    if (!status) status = drive(plant, platform, machine, out, error);
    plant_destroy(plant);
    free(platform);
    return status;
}

int replay_closed_loop(const struct params *model, const struct recording *like, struct recording *out, struct error *error) {
    struct params *machine = memory_get(2, sizeof *machine), *controller = machine + 1;
    int status = STATUS_OK;
    recording_init(out, like->params);
    for (int run = 0; run < like->runs && !status; run++) {
        if (run) status = recording_begin(out, &like->run[run], error);
        else out->run[0] = like->run[0];
        *machine = replay_params(model, like, run);
        *controller = replay_params(like->params, like, run);
        controller->control = machine->control;
        if (!status) status = replay_run(machine, controller, out, error);
    }
    free(machine);
    return status ? status : measured_make(out, 0, error);
}

static void replay_one(void *context, int i) {
    struct replay *r = (struct replay *)context + i;
    r->status = replay_closed_loop(r->model, r->like, &r->run, &r->error);
}

void replay_both(const struct params *before, const struct params *after, const struct recording *like, struct replay both[2]) {
    both[0] = (struct replay){.model = before, .like = like};
    both[1] = (struct replay){.model = after, .like = like};
    parallel_run(2, after ? 2 : 1, replay_one, both);
}

void replay_free(struct replay both[2]) {
    recording_free(&both[0].run);
    recording_free(&both[1].run);
}

static struct params frictionless(const struct params *model) {
    struct params p = *model;
    for (int i = 0; effect_table[i]; i++)
        if (effect_table[i]->leg_friction || effect_table[i]->joint_friction) p.effects[i].on = false;
    return p;
}

static void feed(struct ident *id, const struct recording_test *t) {
    for (int j = t->first; j >= 0 && j < t->end; j++) {
        const struct recording_sample *s = &t->sample[j];
        struct cycle c = {.test = t->test, .dof = t->dof, .phase = PHASE_EVALUATE, .test_time_s = s->test_time_s};
        c.in.flags = s->refused ? SAMPLE_INVALID : 0;
        memcpy(c.in.length_m, s->length_m, sizeof s->length_m);
        memcpy(c.in.p1_pa, s->p1_pa, sizeof s->p1_pa);
        memcpy(c.in.p2_pa, s->p2_pa, sizeof s->p2_pa);
        ident_feed(id, &c);
    }
}

bool replay_identify(const struct params *params, const struct recording *recording, double mt[DOFS][DOFS]) {
    struct error error;
    struct ident *id = memory_get(1, sizeof *id);
    struct params driven = *params;
    driven.tests = recording->run[0]; /* simulations run at the measured frequencies */
    bool ok = ident_init(id, &driven, &error) == STATUS_OK;
    for (int i = 0; i < recording->tests && ok; i++)      /* method A takes the six tests of the
                                                           * first run */
        if (!recording->test[i].run) feed(id, &recording->test[i]);
    ok = ok && (ident_end(id), ident_solve(id));
    if (ok) memcpy(mt, id->result.method_a.mt, sizeof id->result.method_a.mt);
    free(id);
    return ok;
}

/* The simulations have no sensor errors. */
bool replay_repair(const struct params *params, const struct params *model, const struct recording *measured, double mt[DOFS][DOFS]) {
    double with[DOFS][DOFS], without[DOFS][DOFS];
    struct params exact = *model, smooth;
    exact.sensors.enabled = false, exact.errors = (struct sensor_errors){0};
    smooth = frictionless(&exact);
    struct replay both[2];
    if (!replay_identify(params, measured, mt)) return false;
    replay_both(&exact, &smooth, measured, both);
    bool ok = !both[0].status && !both[1].status && replay_identify(params, &both[0].run, with) &&
              replay_identify(params, &both[1].run, without);
    for (int i = 0; i < DOFS && ok; i++)
        for (int j = 0; j < DOFS; j++) mt[i][j] -= with[i][j] - without[i][j];
    replay_free(both);
    return ok;
}

/* Sums of mean squares of each channel: of the whole signal, and of its constant part. */
struct squares {
    double whole[GAP_CHANNELS], constant[GAP_CHANNELS];
};

struct sums {
    struct squares difference, noise;
    double variation[GAP_CHANNELS];
    int rows[GAP_CHANNELS];
};

/* Mean square of a signal with these Fourier coefficients. */
static double mean_square(int size, const double *row) {
    double sum = square(row[0]);
    for (int a = 1; a < size; a++) sum += 0.5 * square(row[a]);
    return sum;
}

static void add(struct squares *squares, int channel, double whole, double constant) {
    squares->whole[channel] += whole;
    squares->constant[channel] += constant;
}

static struct gap_size size_of(const struct sums *sums, const struct squares *squares) {
    struct gap_size size = {0};
    int channels = 0;
    for (int ch = 0; ch < GAP_CHANNELS; ch++) {
        size.channel[ch] = size.normalised[ch] = NAN;
        if (!sums->rows[ch]) continue;
        size.channel[ch] = sqrt(squares->whole[ch] / sums->rows[ch]);
        size.normalised[ch] = sqrt(squares->whole[ch] / sums->variation[ch]);
        size.overall += squares->whole[ch] / sums->variation[ch];
        size.varying += fmax(squares->whole[ch] - squares->constant[ch], 0.0) / sums->variation[ch];
        channels++;
    }
    size.overall = sqrt(size.overall / channels);
    size.varying = sqrt(size.varying / channels);
    return size;
}

/* Uncertainty of a channel's constant part, as a mean square. This is the scatter of single cycles,
 * not the uncertainty of their mean, because chambers whose valve stays shut reach no steady state
 * and differ between runs. */
static double constant_left(const struct spectrum *s, int channel, int leg) { return s->cycles * square(s->std[channel][leg][0]); }

/* Mean square of the noise that remains in the varying part of a mean cycle, which has `size`
 * coefficients. */
static double varying_left(const struct spectrum *s, int size, int channel, int leg) {
    return mean_square(size, s->std[channel][leg]) - square(s->std[channel][leg][0]);
}

/* Adds the mean squares of one channel of a leg, measured (m) and simulated (s). `difference` gets
 * the difference of the mean cycles, plus the samples' noise. `noise` gets the samples' noise, the
 * part of it that both mean cycles retain, and the uncertainty of both constants. */
static void compare_rows(const struct spectrum *m, const struct spectrum *s, int ch, int leg, int gap_channel, struct sums *sums) {
    int size = 1 + 2 * (m->harmonics < s->harmonics ? m->harmonics : s->harmonics);
    const double *measured = m->mean[ch][leg];
    double difference[SPECTRUM_SIZE] = {0}, noise = square(m->noise[ch][leg]);
    double constant = constant_left(m, ch, leg) + constant_left(s, ch, leg);
    for (int a = 0; a < size; a++) difference[a] = measured[a] - s->mean[ch][leg][a];
    add(&sums->difference, gap_channel, mean_square(size, difference) + noise, square(difference[0]));
    add(&sums->noise, gap_channel, noise + varying_left(m, size, ch, leg) + varying_left(s, size, ch, leg) + constant, constant);
    sums->variation[gap_channel] += mean_square(size, measured) - square(measured[0]);
    sums->rows[gap_channel]++;
}

static void compare_test(const struct spectrum *m, const struct spectrum *s, struct sums *sums) {
    static const int channel[CHANNELS] = {[CHANNEL_LENGTH] = GAP_LENGTH,
                                          [CHANNEL_P1] = GAP_P1,
                                          [CHANNEL_P2] = GAP_P2,
                                          [CHANNEL_VALVE] = GAP_VALVE,
                                          [CHANNEL_FORCE] = GAP_FORCE};
    for (int k = 0; k < LEGS; k++)
        for (int ch = 0; ch < CHANNELS; ch++) compare_rows(m, s, ch, k, channel[ch], sums);
}

static struct replay_sizes sizes_of(const struct sums sums[2], bool second) {
    const struct sums *before = &sums[0], *after = &sums[second ? 1 : 0];
    return (struct replay_sizes){.before = size_of(before, &before->difference),
                                 .after = size_of(after, &after->difference),
                                 .noise = size_of(after, &after->noise)};
}

struct replay_sizes replay_compare(const struct recording *measured, const struct replay both[2], enum cycles which) {
    struct sums sums[2] = {0};
    for (int i = 0; i < measured->tests; i++) {
        const struct spectrum *m = measured_spectrum(&measured->test[i], which), *s;
        if (!m) continue;
        for (int k = 0; k < 2 && both[k].model; k++) {
            const struct recording_test *t = recording_find(&both[k].run, measured->test[i].run, measured->test[i].dof);
            if (t && (s = measured_spectrum(t, CYCLES_ALL))) compare_test(m, s, &sums[k]);
        }
    }
    return sizes_of(sums, both[1].model != NULL);
}

/* Adds the mean squares of one channel of a leg, from the residual of the equations. The noise of
 * the residual includes that of the measured motion. A segment's noise above its band is not known,
 * so none is added. */
static void add_rows(struct sums *sums, int gap_channel, const struct residual_test *t, int channel, int leg, int kind, const double *row,
                     const struct whitener *w) {
    double left = 0.0, left_over = 0.0;
    for (int a = 0; a < t->size; a++) {
        left += t->weight[a] * w->noise[leg][a][kind];
        left_over += t->weight[a] * square(row[a]);
    }
    if (t->spectrum.cycles) {
        double noise = square(t->spectrum.noise[channel][leg]);
        left += (t->spectrum.cycles - 1) * square(t->spectrum.std[channel][leg][0]) + noise, left_over += noise;
    }
    /* constants count, because under the measured motion they do not depend on where a run began */
    add(&sums->difference, gap_channel, left_over, 0.0);
    add(&sums->noise, gap_channel, left, 0.0);
    sums->variation[gap_channel] += residual_variation(t, channel, leg);
    sums->rows[gap_channel]++;
}

static void add_test(struct sums *sums, const struct residual_test *t, const struct params *model, struct whitener *w) {
    static const int channel[RESIDUALS] = {[RESIDUAL_FORCE] = CHANNEL_FORCE, [RESIDUAL_P1] = CHANNEL_P1, [RESIDUAL_P2] = CHANNEL_P2};
    static const int gap_channel[RESIDUALS] = {[RESIDUAL_FORCE] = GAP_FORCE, [RESIDUAL_P1] = GAP_P1, [RESIDUAL_P2] = GAP_P2};
    residual_row row;
    whitener_init(w, t, model, NOISE_ALONE);
    if (!residual_evaluate(t, model, EQUATIONS_ALL, ALL_LEGS, row)) return;
    for (int k = 0; k < t->legs; k++)
        for (int kind = 0; kind < (t->chambers ? RESIDUALS : 1); kind++)
            add_rows(sums, gap_channel[kind], t, channel[kind], k, kind, row[k][kind], w);
}

struct replay_sizes replay_motion(const struct residual_data *measured, const struct params *before, const struct params *after) {
    struct sums sums[2] = {0};
    struct whitener *w = memory_get(1, sizeof *w);
    for (int i = 0; i < measured->tests; i++) {
        add_test(&sums[0], &measured->test[i], before, w);
        if (after) add_test(&sums[1], &measured->test[i], after, w);
    }
    free(w);
    return sizes_of(sums, after != NULL);
}
