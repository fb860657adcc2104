#include "proposal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "kinematics.h"
#include "motion_check.h"
#include "params.h"
#include "admit.h"
#include "units.h"

static const double OF_OIL = 1.0 / 3.0, OF_LOOP = 0.5, LOWEST_HZ = 1.0;
static const double SPREAD = 0.65;     /* lowest frequency of a multisine, as a share of its
                                        * highest */
static const double MARGIN = 0.5;          /* share of limits.following_m, of the limit of the leg
                                            * rates and of checks.amplitude_pct that a proposal may
                                            * use */
static const double OF_PEAK = 0.75;        /* speed of the fastest leg in the proposed sines, as a
                                            * share of the highest leg speed in the survey, with
                                            * which the loop's response was measured */
static const double UNWANTED = 0.7;      /* share of checks.unwanted_pct that a proposal may use */
static const double LONGER = 4.0;          /* duration of the second prediction, as a multiple of
                                            * the shortest duration; predictions for two durations
                                            * determine how the variance depends on the duration */
static const double NEAR = 1.1;     /* standard deviation that the longest useful test reaches, as a
                                     * multiple of the floor which the standard deviation approaches
                                     * with growing duration */
static const double SHORTEST_S = 5.0, LONGEST_S[] = {[PROPOSAL_SINES] = 95.0, [PROPOSAL_MULTISINE] = 30.0};
                                           /* LONGEST_S is limited because method C uses only the
                                            * first 50000 samples of a test of an axis, 100 s at
                                            * 2 ms (analysis.h), and at most 48 segments of another
                                            * motion (motion.c) */
static const double SEARCH_S = 8.0;
static const double REACHED = 0.05; /* a predicted deviation counts as the wanted one if it differs
                                     * by less than this share, because predictions from DRAWS
                                     * random draws are no more exact */
static const double HZ_STEP = 0.01, AMPLITUDE_STEP = 1e-5, SECONDS_STEP = 0.1;
enum { SCALES = 20, CORRECTIONS = 3, DRAWS = 3, TRIALS = 16 };

struct design {
    struct proposal_watch *watch;
    const struct loop_survey *survey;
    const struct params *params;
    double leg_per_axis[DOFS];             /* largest magnitude in each axis's column of the
                                            * Jacobian, m per m or m per rad */
    double jacobian[LEGS][DOFS];
    double share[DOFS];                    /* multisine: relative share of each axis in the legs'
                                            * rate */
    struct params trial;
    struct params exact;                /* params with a joint tolerance of 0, for the search: no
                                         * excitation reduces the error that this tolerance causes,
                                         * and computing that error is slow */
};

static double round_to(double step, double x) { return step * round(x / step); }
static double floor_to(double step, double x) { return step * floor(x / step + 1e-9); }

static void tell(struct proposal_watch *w) { w->share(w->context, (double)w->done++ / w->most); }

/* Returns the shortest duration with which the sine of the lowest frequency can be evaluated. */
static double shortest_s(const struct test_params *t) {
    double lowest_hz = t->hz[0];
    for (int i = 1; i < DOFS; i++) lowest_hz = fmin(lowest_hz, t->hz[i]);
    return t->multisine ? SHORTEST_S : fmax(SHORTEST_S, ceil(RECORDING_CYCLES / lowest_hz));
}

static double highest_hz(const struct loop_survey *s) {
    double oil_hz = loop_survey_oil_hz(s), loop_hz = loop_survey_loop_hz(s);
    return isnan(loop_hz) ? OF_OIL * oil_hz : fmin(OF_OIL * oil_hz, OF_LOOP * loop_hz);
}

/* Returns the highest frequency at which the loop follows this axis well enough; if there is none,
 * the frequency at which it follows best. */
static double sine_hz(const struct loop_survey *s, const struct params *params, enum dof dof, double highest) {
    double enough = MARGIN * params->checks.amplitude_pct / 100.0, best_hz = highest, least = HUGE_VAL;
    for (double hz = highest; hz >= LOWEST_HZ; hz -= 10.0 * HZ_STEP) {
        double off = fabs(cabs(loop_survey_follow(s, dof, hz)) - 1.0);
        if (off <= enough) return floor_to(HZ_STEP, hz);
        if (off < least) least = off, best_hz = hz;
    }
    return floor_to(HZ_STEP, best_hz);
}

/* Sets the amplitudes so that the fastest leg reaches this rate: in the test of each axis, or in a
 * multisine when the peaks of all axes coincide; there the axes contribute to the rate in
 * proportion to their shares. */
static void set_amplitudes(struct design *d, double rate_mps) {
    struct test_params *t = &d->trial.tests;
    double most = 0.0;
    for (int leg = 0; leg < LEGS && t->multisine; leg++) {
        double sum = 0.0;
        for (int i = 0; i < DOFS; i++) sum += d->share[i] * fabs(d->jacobian[leg][i]) / d->leg_per_axis[i];
        most = fmax(most, sum);
    }
    for (int i = 0; i < DOFS; i++)
        t->amplitude[i] = (t->multisine ? d->share[i] / most : 1.0) * rate_mps / (2.0 * PI * t->hz[i] * d->leg_per_axis[i]);
}

/* Reduces amplitudes until the unwanted motion of each other axis, relative to that axis's own
 * amplitude, is at most UNWANTED times checks.unwanted_pct. */
static void keep_apart(struct design *d) {
    double *amplitude = d->trial.tests.amplitude, most = UNWANTED * d->params->checks.unwanted_pct / 100.0;
    /* reducing the amplitude of an axis lowers the limits of the axes that move it, so this is
     * repeated */
    for (int pass = 0; pass < DOFS; pass++)
        for (int driven = 0; driven < DOFS; driven++)
            for (int i = 0; i < DOFS; i++) {
                double moved = cabs(loop_survey_response(d->survey, (enum dof)driven, (enum dof)i, d->trial.tests.hz[driven]));
                if (i != driven) amplitude[driven] = fmin(amplitude[driven], most * amplitude[i] / moved);
            }
}

/* Returns the largest following error of a leg, m; for a multisine with the peaks of all axes
 * coinciding. */
static double following_m(const struct design *d) {
    const struct test_params *t = &d->trial.tests;
    double most = 0.0;
    for (int leg = 0; leg < LEGS; leg++) {
        double sum = 0.0;
        for (int i = 0; i < DOFS; i++) {
            double own = fabs(d->jacobian[leg][i]) * t->amplitude[i] * cabs(1.0 - loop_survey_follow(d->survey, (enum dof)i, t->hz[i]));
            sum = t->multisine ? sum + own : fmax(sum, own);
        }
        most = fmax(most, sum);
    }
    return most;
}

static void scale_amplitudes(struct design *d, double by) {
    for (int i = 0; i < DOFS; i++) d->trial.tests.amplitude[i] = floor_to(AMPLITUDE_STEP, by * d->trial.tests.amplitude[i]);
}

/* SAFETY: scales the test down until the following error is within MARGIN of its limit and
 * motion_check() accepts the motion. */
static int limit(struct design *d, struct error *error) {
    struct error refused = {0};
    double behind_m = following_m(d), most_m = MARGIN * d->params->limits.following_m;
    int status = STATUS_OK;
    scale_amplitudes(d, behind_m > most_m ? most_m / behind_m : 1.0);
    for (int i = 0; i < SCALES && (status = motion_check(&d->trial, NULL, &refused)); i++) scale_amplitudes(d, 0.85);
    if (status) *error = refused;
    return status;
}

/* Predicts the deviations for tests of SEARCH_S with amplitudes at which the fastest leg reaches
 * this rate. */
static int try_rates(struct design *d, double rate_mps, struct excitation *e, struct error *error) {
    d->trial.tests.duration_s = SEARCH_S;
    set_amplitudes(d, rate_mps);
    scale_amplitudes(d, 1.0);
    tell(d->watch);
    return excitation_predict(d->survey, &d->exact, &d->trial.tests, 1, e, error);
}

static void exchange_frequencies(struct test_params *t, enum dof dof) {
    int above = -1;
    for (int i = 0; i < DOFS; i++)
        if (t->hz[i] > t->hz[dof] && (above < 0 || t->hz[i] < t->hz[above])) above = i;
    if (above < 0) return;
    double hz = t->hz[above];
    t->hz[above] = t->hz[dof], t->hz[dof] = hz;
}

/* Makes one of four changes. 0, 1: changes the shares by a large or a small step that makes the
 * axes' deviations more alike. 2, 3: exchanges the frequency of the axis of the worst entry's row
 * or column with the next higher frequency. */
static void move_on(struct design *d, const struct excitation *now, int move) {
    static const double strength[2] = {0.5, 0.2};
    if (move >= 2) exchange_frequencies(&d->trial.tests, move % 2 ? now->column : now->row);
    for (int i = 0; i < DOFS && move < 2; i++) d->share[i] *= pow(now->axis_pct[i] / now->worst_pct, strength[move]);
}

static int search(struct design *d, double rate_mps, struct proposal *result, struct error *error) {
    struct excitation best, now;
    int status = try_rates(d, rate_mps, &best, error), failed = 0;
    result->start_pct = best.worst_pct;
    for (int i = 0; i < TRIALS && failed < 4 && !status; i++) {
        /* a trial that fails counts as no better and does not end the search, unless memory ran
         * out */
        struct error refused = {0};
        struct design before = *d;
        move_on(d, &best, failed);
        int tried = try_rates(d, rate_mps, &now, &refused);
        if (tried == STATUS_IO) *error = refused, status = tried;
        bool better = !tried && now.worst_pct < best.worst_pct;
        if (better) best = now, failed = 0;
        else *d = before, failed++;
    }
    result->best_pct = best.worst_pct;
    set_amplitudes(d, rate_mps);
    return status;
}

static double longest_s(const struct test_params *t) { return LONGEST_S[t->multisine ? PROPOSAL_MULTISINE : PROPOSAL_SINES]; }

/* Returns the predicted variance of the worst entry, %^2. */
static double predict_for(struct design *d, double duration_s, struct excitation *e, int *status, struct error *error) {
    d->trial.tests.duration_s = round_to(SECONDS_STEP, duration_s);
    if (!*status) tell(d->watch);
    if (!*status) *status = excitation_predict(d->survey, d->params, &d->trial.tests, DRAWS, e, error);
    return e->worst_pct * e->worst_pct;
}

static bool close_enough(double found, double wanted) { return fabs(sqrt(found / wanted) - 1.0) < REACHED; }

/* Reduces the amplitudes until the shortest test is only as good as wanted. The variance is taken
 * as proportional to amplitude^-n. n is 2 at first, and then follows from the predictions; usually
 * it is above 2, because dry friction matters more at lower speeds. Amplitudes that miss the wanted
 * deviation are discarded. */
static int find_amplitude(struct design *d, double wanted, double first, struct excitation *e, struct error *error) {
    struct test_params largest = d->trial.tests, best = largest;
    struct excitation of_best = *e;
    double scale = sqrt(first / wanted), found = first;
    int status = STATUS_OK;
    for (int i = 0; i < CORRECTIONS && !status && isfinite(found) && !close_enough(found, wanted); i++) {
        d->trial.tests = largest;
        scale_amplitudes(d, scale);
        found = predict_for(d, shortest_s(&d->trial.tests), e, &status, error);
        if (sqrt(found / wanted) < 1.0 + REACHED) best = d->trial.tests, of_best = *e;
        scale = pow(first / wanted, -1.0 / fmin(log(found / first) / log(scale), -1.0));
    }
    d->trial.tests = best, *e = of_best;
    return status;
}

/* Finds the duration. The predictions for a short and a longer test give the part of the variance
 * that falls with the duration and the part that stays. From these follows a duration, which is
 * tried and corrected. */
static int find_duration(struct design *d, double wanted, double first, double longer, struct excitation *e, struct error *error) {
    struct test_params *t = &d->trial.tests;
    int status = STATUS_OK;
    double least_s = shortest_s(t), noise = fmax(first - longer, 0.0) * least_s / (1.0 - 1.0 / LONGER);
    double rest = fmax(longer - noise / (LONGER * least_s), 0.0);
    /* most_s: a test longer than the second argument of fmin() would gain little, because the worst
     * entry's deviation would be less than NEAR times its floor, sqrt(rest) */
    double most_s = fmin(longest_s(t), noise / ((NEAR * NEAR - 1.0) * rest));
    double next_s = wanted > rest ? noise / (wanted - rest) : most_s;
    for (int i = 0; i < CORRECTIONS && !status; i++) {
        double found = predict_for(d, fmax(fmin(next_s, most_s), least_s), e, &status, error);
        bool at_most = t->duration_s > most_s - SECONDS_STEP && found > wanted;
        if (at_most || close_enough(found, wanted) || !(wanted > rest) || !isfinite(found)) break;
        next_s = t->duration_s * fmax(found - rest, 0.0) / (wanted - rest);
    }
    return status;
}

static int find_tests(struct design *d, double wanted_pct, struct proposal *result, struct error *error) {
    struct excitation *e = &result->predicted;
    int status = STATUS_OK;
    double wanted = wanted_pct * wanted_pct, least_s = shortest_s(&d->trial.tests);
    double longer = predict_for(d, LONGER * least_s, e, &status, error), first = predict_for(d, least_s, e, &status, error);
    if (!status) status = first < wanted ? find_amplitude(d, wanted, first, e, error) : find_duration(d, wanted, first, longer, e, error);
    result->reached = e->worst_pct < (1.0 + REACHED) * wanted_pct;
    return status;
}

static int begin(struct design *d, enum proposal_kind kind, const struct loop_survey *survey, const struct params *params,
                 struct error *error) {
    static const double neutral[DOFS] = {0};
    struct kinematics k;
    double highest = highest_hz(survey);
    *d = (struct design){.survey = survey, .params = params, .trial = *params, .exact = *params};
    d->exact.model.tolerance.joints_m = 0.0;
    if (!survey->determined) return error_set(error, STATUS_USAGE, "the lowest eigenfrequency is not determined");
    if (!(highest > LOWEST_HZ))
        return error_set(error, STATUS_USAGE, "eigenfrequencies so low leave no test above the survey's lowest tone, %g Hz", LOWEST_HZ);
    int status = kinematics_init(&k, params, error);
    ik_jacobian(&k, neutral, d->jacobian);
    d->trial.tests.count = DOFS;
    d->trial.tests.multisine = kind == PROPOSAL_MULTISINE;
    for (int i = 0; i < DOFS; i++) {
        double spaced = SPREAD + (1.0 - SPREAD) * i / (DOFS - 1);
        d->trial.tests.order[i] = (enum dof)i;
        d->share[i] = 1.0;
        for (int leg = 0; leg < LEGS; leg++) d->leg_per_axis[i] = fmax(d->leg_per_axis[i], fabs(d->jacobian[leg][i]));
        d->trial.tests.hz[i] = kind == PROPOSAL_MULTISINE ? floor_to(HZ_STEP, spaced * highest)
                                                          : sine_hz(survey, params, (enum dof)i, highest);
    }
    return status;
}

int propose(enum proposal_kind kind, const struct loop_survey *survey, const struct params *params, double wanted_pct,
            struct proposal_watch *watch, struct proposal *result, struct error *error) {
    struct design *d = malloc(sizeof *d);
    *result = (struct proposal){0};
    if (!d) return error_set(error, STATUS_IO, "out of memory");
    int status = begin(d, kind, survey, params, &result->none);
    d->watch = watch;
    watch->done = 0, watch->most = 2 + CORRECTIONS + (kind == PROPOSAL_MULTISINE ? 1 + TRIALS : 0);
    if (!status && kind == PROPOSAL_MULTISINE) status = search(d, MARGIN * multisine_rate_limit_mps(params), result, &result->none);
    else if (!status) set_amplitudes(d, OF_PEAK * survey->multisine.peak_mps), keep_apart(d);
    if (!status) status = limit(d, &result->none);
    if (!status) status = find_tests(d, wanted_pct, result, &result->none);
    result->tests = d->trial.tests;
    free(d);
    if (status == STATUS_IO) *error = result->none;
    return status == STATUS_IO ? status : STATUS_OK;
}

static int list(char *text, int size, const char *key, const double *value, int count) {
    int n = snprintf(text, (size_t)size, " --set tests.%s=", key);
    for (int i = 0; i < count && n < size; i++) n += snprintf(text + n, (size_t)(size - n), "%s%.6g", i ? "," : "", value[i]);
    return n < size ? n : size;
}

void proposal_options(const struct proposal *p, char *text, int size) {
    const struct test_params *t = &p->tests;
    int n = snprintf(text, (size_t)size, "--tests x,y,z,phi,theta,psi --set tests.multisine=%s", t->multisine ? "true" : "false");
    n += list(text + n, size - n, "frequency_hz", t->hz, DOFS);
    n += list(text + n, size - n, "amplitude_m", t->amplitude, DOF_PHI);
    n += list(text + n, size - n, "amplitude_rad", t->amplitude + DOF_PHI, DOFS - DOF_PHI);
    list(text + n, size - n, "duration_s", &t->duration_s, 1);
}
