#include "quality.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "kinematics.h"
#include "params.h"
#include "numeric.h"
#include "units.h"

const double quality_band_hz[QUALITY_BANDS + 1] = {0.2, 1.0, 5.0, 20.0, 50.0};

/* Largest difference of the recorded reference from the plan, over the amplitude: the plan is a
 * formula, and its rounding is far below. */
static const double REFERENCE_OFF = 1e-6;
/* Frequency of the tone from which lag, balance and turn-around are taken. */
static const double SLOW_HZ = 0.5;
/* Lag of the second differences: so long that the rounding of the lengths at the window's ends
 * stays small in the differences, and so short that the differences show motion up to 60 Hz. */
static const double LAG_S = 0.016;
/* Share of a period to either side of a reversal that belongs to it. */
static const double REVERSAL = 0.05;
/* Share of a slope's amplitude within which its two directions are compared. */
static const double SLOPE_MIDDLE = 0.5;
/* Share of the reference's displacement that the platform must cover to count as following.
 * Backlash so wide that the platform does not follow is not measured. */
static const double SLOPE_FOLLOWED = 0.5;
static const double HANN_SQUARE = 1.5; /* mean square of the Hann window 1 - cos */

int quality_record_init(struct quality_record *r, const struct quality_plan *plan, struct error *error) {
    size_t n = (size_t)plan->cycles;
    *r = (struct quality_record){.cycles = plan->cycles,
                                 .last_s = -HUGE_VAL,
                                 .pose = calloc(n, sizeof *r->pose),
                                 .ref = calloc(n, sizeof *r->ref),
                                 .length_m = calloc(n, sizeof *r->length_m),
                                 .there = calloc(n, sizeof *r->there)};
    return r->pose && r->ref && r->length_m && r->there ? STATUS_OK : error_set(error, STATUS_IO, "out of memory");
}

void quality_record_free(struct quality_record *r) {
    free(r->pose), free(r->ref), free(r->length_m), free(r->there);
    *r = (struct quality_record){0};
}

void quality_record_take(struct quality_record *r, const struct quality_plan *plan, double begin_s, const struct cycle *c) {
    double at = round(c->test_time_s / plan->step_s) - round(begin_s / plan->step_s);
    if (c->test_time_s < r->last_s) memset(r->there, 0, (size_t)r->cycles * sizeof *r->there);
    r->last_s = c->test_time_s;
    if (!(at >= 0.0 && at < r->cycles) || c->phase != PHASE_EVALUATE || c->in.flags) return;
    if (!all_finite(DOFS, c->pose) || !all_finite(DOFS, c->ref) || !all_finite(LEGS, c->in.length_m)) return;
    int n = (int)at;
    memcpy(r->pose[n], c->pose, sizeof r->pose[n]);
    memcpy(r->ref[n], c->ref, sizeof r->ref[n]);
    memcpy(r->length_m[n], c->in.length_m, sizeof r->length_m[n]);
    r->there[n] = true;
}

/* Interpolates the missing samples between `before` and `after`. At an end of the record, where one
 * of the two does not exist, it repeats the other. */
static void join(struct quality_record *r, int before, int after) {
    for (int n = before + 1; n < after; n++) {
        double share = before < 0 ? 1.0 : after == r->cycles ? 0.0 : (double)(n - before) / (after - before);
        int a = before < 0 ? after : before, b = after == r->cycles ? before : after;
        for (int i = 0; i < DOFS; i++) {
            r->pose[n][i] = (1.0 - share) * r->pose[a][i] + share * r->pose[b][i];
            r->ref[n][i] = (1.0 - share) * r->ref[a][i] + share * r->ref[b][i];
            r->length_m[n][i] = (1.0 - share) * r->length_m[a][i] + share * r->length_m[b][i];
        }
    }
}

/* Takes each piece's amplitude from the recorded reference, so that an old log keeps its meaning if
 * a later version of hexid chooses a different amplitude. */
static int take_reference(const struct quality_record *r, struct quality_plan *plan, struct error *error) {
    for (struct quality_piece *p = plan->piece; p < plan->piece + plan->pieces; p++) {
        double product = 0.0, square = 0.0, off = 0.0;
        for (int n = 0; n < p->samples && p->dof != DOF_NONE; n++) {
            double planned = r->there[p->begin + n] ? quality_piece_at(plan, p, n) : 0.0;
            product += r->ref[p->begin + n][p->dof] * planned, square += planned * planned;
        }
        double ratio = p->dof == DOF_NONE ? 1.0 : product / square;
        for (int n = 0; n < p->samples && p->dof != DOF_NONE; n++)
            if (r->there[p->begin + n])
                off = quality_worse(off, fabs(r->ref[p->begin + n][p->dof] - ratio * quality_piece_at(plan, p, n)) / p->amplitude);
        p->amplitude *= ratio;
        if (!(ratio > 0.0 && isfinite(ratio) && off <= REFERENCE_OFF * ratio))
            return error_set(
                error, STATUS_USAGE,
                "the recorded reference of %s from %.3f s of the motion on is off by %.3g of its amplitude from the motion that "
                "this hexid makes of the configuration: measure the log with the hexid that recorded it, and without -c",
                dof_names[p->dof], p->begin * plan->step_s, off);
    }
    return STATUS_OK;
}

/* Checks the evaluated samples piece by piece, because a share of missing samples that is small in
 * the whole motion may be all of a piece. */
static int check_missing(const struct quality_record *r, const struct quality_plan *plan, double most_pct, struct error *error) {
    static const char *const kinds[QUALITY_KINDS] = {"rest", "tone", "slope", "step", "long", "fast"};
    for (const struct quality_piece *p = plan->piece; p < plan->piece + plan->pieces; p++) {
        int missing = 0;
        for (int n = p->begin; n < p->begin + p->samples; n++) missing += !r->there[n];
        if (missing == p->samples || !(100.0 * missing <= most_pct * p->samples))
            return error_set(error, STATUS_USAGE,
                             "%d of %d samples of the motion are missing or flagged from %.3f s on (%s%s%s), limit %g %% "
                             "(checks.excluded_pct): it was not run to its end, or look at `hexid check`",
                             missing, p->samples, p->begin * plan->step_s, kinds[p->kind], p->dof == DOF_NONE ? "" : " of ",
                             p->dof == DOF_NONE ? "" : dof_names[p->dof], most_pct);
    }
    return STATUS_OK;
}

int quality_record_settle(struct quality_record *r, struct quality_plan *plan, double most_pct, struct error *error) {
    int before = -1;
    for (int n = 0; n < r->cycles; n++) r->missing += !r->there[n];
    int status = check_missing(r, plan, most_pct, error);
    if (status) return status;
    for (int n = 0; n <= r->cycles; n++) {
        if (n < r->cycles && !r->there[n]) continue;
        join(r, before, n);
        before = n;
    }
    return take_reference(r, plan, error);
}

/* A window of samples with the factors of its Fourier sums. */
struct window {
    int samples;
    double step_s;
    double complex *wave;
};

static bool window_init(struct window *w, const struct quality_plan *plan, int samples) {
    *w = (struct window){.samples = samples, .step_s = plan->step_s, .wave = malloc((size_t)samples * sizeof *w->wave)};
    for (int n = 0; n < samples && w->wave; n++) w->wave[n] = cexp(CMPLX(0.0, -2.0 * PI * n / samples));
    return w->wave;
}

/* Complex amplitude of the sine with this number of periods in the window, in one column of
 * rows of six. */
static double complex amplitude(const struct window *w, const double (*x)[DOFS], int channel, int periods) {
    double complex sum = 0.0;
    for (int n = 0, at = 0; n < w->samples; n++) {
        sum += w->wave[at] * x[n][channel];
        at += periods;
        if (at >= w->samples) at -= w->samples;
    }
    return 2.0 * sum / w->samples;
}

/* Index of the highest Fourier frequency (whole periods per window) that is at most hz and below
 * half the sampling rate. */
static int bin_of(const struct window *w, double hz) {
    int most = (w->samples - 1) / 2;
    double bin = hz * w->samples * w->step_s + 1e-9;
    return bin < most ? (int)bin : most;
}

static double radps_of(const struct window *w, int bin) { return 2.0 * PI * bin / (w->samples * w->step_s); }

/* Fills second differences of the piece's axis over LAG_S. They replace the pose in the Fourier
 * sums, because its slow drift through the window would spread over all bins; in second differences
 * only the drift's small curvature is left. */
static void differentiate(const struct quality_piece *p, const struct quality_record *r, int lag, double (*differences)[DOFS]) {
    for (int n = 0; n < p->samples; n++) {
        int at = p->begin + n, before = at < lag ? 0 : at - lag, after = at + lag < r->cycles ? at + lag : r->cycles - 1;
        differences[n][p->dof] = r->pose[after][p->dof] - 2.0 * r->pose[at][p->dof] + r->pose[before][p->dof];
    }
}

/* Acceleration at a bin, of second differences over `lag` samples. */
static double complex bin_acceleration(const struct window *w, const double (*differences)[DOFS], int channel, int bin, int lag) {
    double radps = radps_of(w, bin);
    return amplitude(w, differences, channel, bin) * radps * radps / (2.0 - 2.0 * cos(radps * lag * w->step_s));
}

/* Sums of squares of all bins of a response but the tone's. */
struct bins_beside {
    double low, high, noise, moved; /* of accelerations; moved: of displacements */
    double near;                    /* mean square of the displacement's bins near the tone */
};

/* Sums the squares of the bins up to QUALITY_BAND_HZ except the tone, and fills `beside` with the
 * acceleration that they make. Up to twice the tone's frequency, displacements are taken from the
 * pose's own bins: an acceleration divided by the square of a small frequency would enlarge the
 * rounding at the window's ends. */
static struct bins_beside take_bins(const struct window *w, const double (*pose)[DOFS], const double (*differences)[DOFS], int lag,
                                    const struct quality_piece *p, double *beside) {
    struct bins_beside r = {0};
    int nearby = 0, wide = p->periods > 6 ? p->periods / 2 : 3;
    memset(beside, 0, (size_t)w->samples * sizeof *beside);
    for (int bin = 1; bin <= bin_of(w, fmax(QUALITY_BAND_HZ, 1.5 * p->hz)); bin++) {
        double complex a = bin_acceleration(w, differences, p->dof, bin, lag);
        double power = square(cabs(a)), far = cabs(a) / square(radps_of(w, bin));
        double moved = square(bin <= 2 * p->periods ? cabs(amplitude(w, pose, p->dof, bin)) : far);
        int order = bin % p->periods ? 0 : bin / p->periods;
        /* true from half the tone's frequency on; displacements of lower bins do not count, because
         * the decaying transient of the ramp-in is large there */
        bool above = 2 * bin >= p->periods;
        if (!order && above && bin - p->periods <= wide) r.near += moved, nearby++;
        if (order == 1 || bin > bin_of(w, QUALITY_BAND_HZ)) continue;
        *(order == 0 ? &r.noise : order <= 3 ? &r.low : &r.high) += power;
        if (above) r.moved += moved;
        for (int n = 0, at = 0; n < w->samples; n++) {
            beside[n] += creal(a) * creal(w->wave[at]) + cimag(a) * cimag(w->wave[at]);
            at += bin;
            if (at >= w->samples) at -= w->samples;
        }
    }
    r.near /= nearby;
    return r;
}

/* Largest magnitude of the acceleration beside the tone; if `reversals`, only near reversals of the
 * response, which leads by lead_rad. */
static double peak(const struct window *w, const double *beside, const struct quality_piece *p, double lead_rad, bool reversals) {
    double most = 0.0;
    for (int n = 0; n < w->samples; n++) {
        /* time in half periods of the response, a whole number at its reversals */
        double half = 2.0 * p->periods * (double)n / w->samples + lead_rad / PI - 0.5;
        if (!reversals || fabs(half - round(half)) <= 2.0 * REVERSAL) most = fmax(most, fabs(beside[n]));
    }
    return most;
}

static bool is_near(double hz, double wanted_hz) { return fabs(hz - wanted_hz) < 0.1 * wanted_hz; }

static bool take_tone(struct quality *q, const struct quality_piece *p, int index, const struct quality_record *r) {
    struct window w;
    struct quality_tone *t = &q->tone[p->dof][index];
    const double (*pose)[DOFS] = (const double (*)[DOFS])(r->pose + p->begin);
    double *beside = malloc((size_t)p->samples * sizeof *beside), (*differences)[DOFS] = malloc((size_t)p->samples * sizeof *differences);
    int lag = (int)fmax(1.0, round(LAG_S / q->plan.step_s));
    bool fits = window_init(&w, &q->plan, p->samples) && beside && differences;
    if (fits) {
        differentiate(p, r, lag, differences);
        double complex ref = amplitude(&w, (const double (*)[DOFS])(r->ref + p->begin), p->dof, p->periods);
        *t = (struct quality_tone){.hz = p->hz, .amplitude = p->amplitude};
        for (int i = 0; i < DOFS; i++) t->gain[i] = amplitude(&w, pose, i, p->periods) / ref;
        struct bins_beside rest = take_bins(&w, pose, (const double (*)[DOFS])differences, lag, p, beside);
        double moved = cabs(t->gain[p->dof] * ref), accel = moved * square(2.0 * PI * p->hz);
        t->std = sqrt(rest.near / 2.0) / cabs(ref);
        t->coherence = moved * moved / (moved * moved + rest.moved);
        t->low = 2.0 * p->hz <= QUALITY_BAND_HZ ? sqrt(rest.low) / accel : (double)NAN;
        t->high = 4.0 * p->hz <= QUALITY_BAND_HZ ? sqrt(rest.high) / accel : (double)NAN;
        t->noise = sqrt(rest.noise) / accel;
        t->peak = 2.0 * p->hz <= QUALITY_BAND_HZ ? peak(&w, beside, p, 0.0, false) / accel : (double)NAN;
        if (is_near(p->hz, SLOW_HZ)) {
            q->axis[p->dof].turn_around = peak(&w, beside, p, carg(t->gain[p->dof]), true);
            q->axis[p->dof].lag_s = -carg(t->gain[p->dof]) / (2.0 * PI * p->hz);
        }
    }
    free(w.wave), free(beside), free(differences);
    return fits;
}

/* Acceleration at rest, band by band, under a Hann window so that drift does not spread. */
static bool take_rest(struct quality *q, const struct quality_piece *p, const struct quality_record *r) {
    struct window w;
    double (*x)[DOFS] = malloc((size_t)p->samples * sizeof *x);
    bool fits = window_init(&w, &q->plan, p->samples) && x;
    for (int i = 0; i < DOFS && fits; i++) {
        double mean = 0.0;
        for (int n = 0; n < p->samples; n++) mean += r->pose[p->begin + n][i] / p->samples;
        for (int n = 0; n < p->samples; n++) x[n][i] = (r->pose[p->begin + n][i] - mean) * (1.0 - creal(w.wave[n]));
        for (int band = 0; band < QUALITY_BANDS; band++) {
            double sum = 0.0;
            for (int bin = bin_of(&w, quality_band_hz[band]) + 1; bin <= bin_of(&w, quality_band_hz[band + 1]); bin++)
                sum += square(cabs(amplitude(&w, (const double (*)[DOFS])x, i, bin)) * square(radps_of(&w, bin)));
            q->axis[i].rest[band] = sqrt(sum / 2.0 / HANN_SQUARE);
        }
    }
    free(w.wave), free(x);
    return fits;
}

/* Mean of reference less pose, in the middle of the quarters that move upward, or downward. The
 * first and the last quarter are left out. */
static double middle_error(const struct quality_piece *p, const struct quality_record *r, bool upward) {
    double sum = 0.0;
    int count = 0, quarter = p->samples / QUALITY_QUARTERS;
    for (int n = quarter; n < p->samples - quarter; n++) {
        double ref = r->ref[p->begin + n][p->dof];
        bool up = r->ref[p->begin + n][p->dof] > r->ref[p->begin + n - 1][p->dof];
        if (up == upward && fabs(ref) <= SLOPE_MIDDLE * p->amplitude) sum += ref - r->pose[p->begin + n][p->dof], count++;
    }
    return sum / count;
}

/* True if the platform followed within the first quarter, `followed` being the reference at which
 * it began to follow, and covered at least SLOPE_FOLLOWED of the distance between two peaks. If the
 * backlash is wider than the triangle, the platform rests on one side, which looks like no backlash
 * at all. */
static bool follows(const struct quality_piece *p, const struct quality_record *r, double followed) {
    int quarter = p->samples / QUALITY_QUARTERS, up = p->begin + quarter, down = up + 2 * quarter;
    double way = r->pose[up][p->dof] - r->pose[down][p->dof];
    return followed < r->ref[up - 1][p->dof] && way >= SLOPE_FOLLOWED * 2.0 * p->amplitude;
}

static void take_slope(struct quality *q, const struct quality_piece *p, const struct quality_record *r) {
    struct quality_axis *a = &q->axis[p->dof];
    double from = 0.0;
    int quarter = p->samples / QUALITY_QUARTERS;
    for (int n = -p->ramp_in; n < 0; n++) from += r->pose[p->begin + n][p->dof] / p->ramp_in;
    a->threshold = 0.0;
    for (int n = 0; n < quarter; n++) {
        double ref = r->ref[p->begin + n][p->dof];
        if (r->pose[p->begin + n][p->dof] - from < SLOPE_FOLLOWED * ref) a->threshold = ref;
    }
    a->hysteresis = middle_error(p, r, true) - middle_error(p, r, false);
    if (!follows(p, r, a->threshold)) a->threshold = a->hysteresis = (double)NAN;
    /* in a wider loop the platform does not move yet when the reference enters the middle */
    if (a->hysteresis > SLOPE_MIDDLE * p->amplitude) a->hysteresis = (double)NAN;
    a->slope_rate = p->amplitude / (quarter * q->plan.step_s);
}

/* Time, s, from sample 0 until x first passes this share of the height, interpolated between
 * samples; NaN: it never does. */
static double passes(const struct quality_plan *plan, const double (*x)[DOFS], int dof, int count, double from, double height,
                     double share) {
    double before = 0.0;
    for (int n = 0; n < count; n++) {
        double now = (x[n][dof] - from) / height;
        if (now >= share) return (n - (n ? (now - share) / (now - before) : 0.0)) * plan->step_s;
        before = now;
    }
    return (double)NAN;
}

static void take_steps(struct quality *q, const struct quality_piece *p, const struct quality_record *r) {
    struct quality_axis *a = &q->axis[p->dof];
    static const double share[2] = {0.1, 0.5};
    double delay_s[2] = {0.0};
    int every = p->samples / QUALITY_STEPS;
    for (int step = 0; step < QUALITY_STEPS; step++) {
        int at = p->begin + step * every;
        double height = step % 2 ? -p->amplitude : p->amplitude;
        for (int i = 0; i < 2; i++)
            delay_s[i] += passes(&q->plan, (const double (*)[DOFS])(r->pose + at), p->dof, every, r->pose[at][p->dof], height, share[i]) -
                          passes(&q->plan, (const double (*)[DOFS])(r->ref + at), p->dof, every, r->ref[at][p->dof], height, share[i]);
    }
    a->dead_s = delay_s[0] / QUALITY_STEPS, a->half_s = delay_s[1] / QUALITY_STEPS;
}

/* Takes the amplitudes that a sine reached, by its fundamental. */
static bool take_reached(struct quality *q, const struct quality_piece *p, const struct quality_record *r) {
    struct window w;
    struct quality_axis *a = &q->axis[p->dof];
    if (!window_init(&w, &q->plan, p->samples)) return false;
    double radps = 2.0 * PI * p->hz, moved = cabs(amplitude(&w, (const double (*)[DOFS])(r->pose + p->begin), p->dof, p->periods));
    a->excursion = fmax(a->excursion, moved), a->rate = fmax(a->rate, radps * moved), a->accel = fmax(a->accel, radps * radps * moved);
    free(w.wave);
    return true;
}

/* Each leg's amplitude and phase in the slow tone of z, against that of its own reference. */
static bool take_legs(struct quality *q, const struct quality_piece *p, const struct quality_record *r, const struct kinematics *k) {
    struct window w;
    double (*asked)[LEGS] = malloc((size_t)p->samples * sizeof *asked);
    bool fits = window_init(&w, &q->plan, p->samples) && asked;
    for (int n = 0; n < p->samples && fits; n++) ik_lengths(k, r->ref[p->begin + n], asked[n]);
    for (int leg = 0; leg < LEGS && fits; leg++)
        q->leg[leg] = amplitude(&w, (const double (*)[LEGS])(r->length_m + p->begin), leg, p->periods) /
                      amplitude(&w, (const double (*)[LEGS])asked, leg, p->periods);
    free(w.wave), free(asked);
    return fits;
}

static bool take_piece(struct quality *q, const struct quality_piece *p, int tone, const struct quality_record *r,
                       const struct kinematics *k) {
    switch (p->kind) {
    case QUALITY_REST: return take_rest(q, p, r);
    case QUALITY_SLOPE: take_slope(q, p, r); return true;
    case QUALITY_STEP: take_steps(q, p, r); return true;
    case QUALITY_TONE:
        if (p->dof == DOF_Z && is_near(p->hz, SLOW_HZ) && !take_legs(q, p, r, k)) return false;
        return take_tone(q, p, tone, r) && take_reached(q, p, r);
    default: return take_reached(q, p, r);
    }
}

int quality_measure(struct quality *q, const struct quality_plan *plan, const struct quality_record *r, const struct params *params,
                    struct error *error) {
    struct kinematics k;
    int tones[DOFS] = {0};
    bool fits = true;
    *q = (struct quality){.plan = *plan, .missing = r->missing};
    int status = kinematics_init(&k, params, error);
    if (status) return status;
    for (const struct quality_piece *p = plan->piece; p < plan->piece + plan->pieces && fits; p++)
        fits = take_piece(q, p, p->kind == QUALITY_TONE ? tones[p->dof]++ : 0, r, &k);
    if (!fits) return error_set(error, STATUS_IO, "out of memory");
    return STATUS_OK;
}

double quality_metres(const struct quality_plan *plan, int dof) { return dof < DOF_PHI ? 1.0 : plan->arm_m; }

double quality_cross(const struct quality *q, int driven, int tone, int dof) {
    return cabs(q->tone[driven][tone].gain[dof]) * quality_metres(&q->plan, dof) / quality_metres(&q->plan, driven);
}

double quality_worse(double most, double value) { return isnan(most) || value <= most ? most : value; }

double quality_cross_most(const struct quality *q, int driven, int tone) {
    double most = 0.0;
    for (int i = 0; i < DOFS; i++)
        if (i != driven) most = quality_worse(most, quality_cross(q, driven, tone, i));
    return most;
}

double quality_phase_deg(const struct quality *q, int dof, int tone) {
    double phase = 0.0;
    for (int i = 0; i <= tone; i++) phase += remainder(carg(q->tone[dof][i].gain[dof]) - phase, 2.0 * PI);
    return deg_from_rad(phase);
}
