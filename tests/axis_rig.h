/* One axis with friction that sticks, simulated by its own equations and integrator and recorded as
 * CSV. It uses no code of hexid, so it is an independent check. */
#ifndef HEXID_TESTS_AXIS_RIG_H
#define HEXID_TESTS_AXIS_RIG_H

#include "support.h"

#include <math.h>
#include <stdio.h>

/* Motions of the rig. The CSV file states the frequency of SINE, and nothing about the other
 * motions. */
enum motion { SINE, TRIANGLE, CHIRP, STEPS, POINT_TO_POINT, MULTISINE, RESTS, MOTIONS };
static const char *const motion_names[MOTIONS] = {"sine", "triangle", "chirp", "steps", "point to point", "multisine", "sine with rests"};

/* The machine of config/axis.yaml, whose parameters differ from the file's within the model's
 * tolerances, and one hidden effect. */
struct rig {
    const char *hides;                       /* name of the hidden effect, NULL: none */
    bool electric;                           /* electric drive with a measured force, no
                                              * pressures */
    enum motion motion;
    double rate_hz, gravity_mps2;
    double coulomb_extend_n, coulomb_retract_n, viscous_n_s_per_m, stribeck_n, stribeck_mps, payload_kg, more_leakage, overlap, offset_n;
    double load_friction, spring_n_per_m;    /* friction per newton of mean pressure force on the
                                              * seals; stiffness of a spring that is relaxed at
                                              * mid-stroke */
    double lever_n, lever_m, lever_rad;      /* weight on a lever of this radius, at this angle from
                                              * hanging straight down when the rod is at
                                              * mid-stroke */
    double seal_n, seal_m;                   /* force at which the seal slides, and its deflection
                                              * at that force */
    double along_stroke;                     /* relative variation of dry friction along the stroke,
                                              * in waves of 3 cm */
    double force_lag_s, force_more;          /* lag of the force sensor; relative excess of its
                                              * reading */
    double lost_s, lost_share;               /* time around each reversal whose rows are lost; share
                                              * of rows that are lost in bursts of 3 */
};

struct body {
    double x, v, p1, p2, spool, spool_rate;
    double seal; /* deflection of the seal relative to its largest: -1 slides inwards, 1 slides
                  * outwards */
};

struct tolerances {
    double mass, viscous, bulk, leakage, gain;
};

static const double STEP_S = 2e-5, MASS_KG = 200.0, A1 = 3.1172e-3, A2 = 1.5268e-3, SUPPLY = 10e6, W = 2.0 * PI * 2.0;
static const double AMPLITUDE_M = 0.02, RAMP_S = 1.0, END_S = 13.0, ANY_END_S = 22.0;

static inline double gauss(uint64_t *state) {
    double sum = 0.0;
    for (int i = 0; i < 12; i++) sum += 0.5 * random_unit(state);
    return sum;
}

static inline double steps(double value, double step) { return step * floor(value / step + 0.5); }

static inline double root(double x) { return x < 0.0 ? -sqrt(-x) : sqrt(x); }

/* Computes the flow into each chamber through a valve that is shut within its overlap. */
static inline void oil(const struct rig *r, const struct tolerances *tol, struct body *b, double u) {
    double omega = 2.0 * PI * 100.0, o = b->spool - fmin(fmax(b->spool, -r->overlap), r->overlap);
    double k = 1.57e-3 / sqrt(5e6) * tol->gain * o, beta = 1e9 * tol->bulk;
    double leak = 3e-11 * tol->leakage * (1.0 + r->more_leakage) * (b->p1 - b->p2);
    double q1 = k * (o > 0.0 ? root(SUPPLY - b->p1) : root(b->p1)), q2 = -k * (o > 0.0 ? root(b->p2) : root(SUPPLY - b->p2));
    double v1 = 1e-4 + A1 * (0.2 + b->x), v2 = 1e-4 + A2 * (0.2 - b->x);
    b->p1 += STEP_S * beta / v1 * (q1 - A1 * b->v - leak);
    b->p2 += STEP_S * beta / v2 * (q2 + A2 * b->v + leak);
    b->spool_rate += STEP_S * (omega * omega * (u - b->spool) - 1.6 * omega * b->spool_rate);
    b->spool += STEP_S * b->spool_rate;
}

/* Force that a spring and a weight on a lever need, relative to mid-stroke. */
static inline double load_n(const struct rig *r, double x) {
    double spring_n = r->spring_n_per_m * x;
    return r->lever_m > 0.0 ? spring_n + r->lever_n * (sin(x / r->lever_m + r->lever_rad) - sin(r->lever_rad)) : spring_n;
}

/* Moves the rod by a step. Dry friction either opposes the sliding or holds the load; a seal
 * deflects before it slides. */
static inline void push(const struct rig *r, const struct tolerances *tol, struct body *b, double force_n) {
    double m = MASS_KG * tol->mass + r->payload_kg, slides = b->v != 0.0 ? b->v : force_n - m * r->gravity_mps2 - load_n(r, b->x);
    double direction = slides > 0.0 ? 1.0 : -1.0;
    double share = b->v / r->stribeck_mps, dry = (direction > 0.0 ? r->coulomb_extend_n : r->coulomb_retract_n);
    dry += r->stribeck_n > 0.0 ? r->stribeck_n * exp(-share * share) : 0.0;
    if (r->along_stroke != 0.0) dry *= 1.0 + r->along_stroke * sin(2.0 * PI * b->x / 0.03);
    dry += r->load_friction * (A1 - A2) * 0.5 * (b->p1 + b->p2);
    double free_n = force_n - m * r->gravity_mps2 - load_n(r, b->x) - (2000.0 * tol->viscous + r->viscous_n_s_per_m) * b->v;
    if (r->seal_m > 0.0) b->seal += STEP_S * (b->v - fabs(b->v) * b->seal) / r->seal_m;
    free_n -= r->seal_n * b->seal;
    if (b->v == 0.0 && fabs(free_n) <= dry) return;
    double v = b->v + STEP_S * (free_n - direction * dry) / m;
    b->v = b->v * v < 0.0 ? 0.0 : v;
    b->x += STEP_S * b->v;
}

/* Rises smoothly from 0 to 1 in takes_s. */
static inline double rise(double t_s, double takes_s) {
    double s = fmin(fmax(t_s / takes_s, 0.0), 1.0);
    return s * s * s * (10.0 - 15.0 * s + 6.0 * s * s);
}

/* Returns the position at t_s of a motion that goes to another station every every_s, and takes
 * takes_s for the way. */
static inline double stations(double t_s, double every_s, double takes_s) {
    static const double place[] = {0.0, 0.8, -0.5, 1.0, -1.0, 0.3, 0.9, -0.7, 0.0, 0.5, -0.9, 0.2, 0.0};
    int count = sizeof place / sizeof *place, i = (int)(t_s / every_s);
    double from = place[i % count], to = place[(i + 1) % count];
    return from + (to - from) * rise(t_s - i * every_s, takes_s);
}

static inline double position(enum motion motion, double t_s) {
    static const double hz[] = {0.23, 0.51, 0.83, 1.12, 1.69, 2.31};
    double sum = 0.0, pi = 0.25 * W;
    switch (motion) {
    case SINE: return rise(t_s, RAMP_S) * AMPLITUDE_M * sin(W * t_s);
    case TRIANGLE: return 2.0 * AMPLITUDE_M * 2.0 / pi * asin(0.998 * sin(0.7 * W / 4.0 * t_s + 0.2 * sin(0.3 * t_s)));
    case CHIRP: return 2.0 * AMPLITUDE_M * sin(2.0 * pi * (0.2 * t_s + 0.5 * 2.8 / ANY_END_S * t_s * t_s)) / (1.0 + t_s / 8.0);
    case STEPS: return 2.0 * AMPLITUDE_M * stations(t_s, 1.3, 0.35);
    case POINT_TO_POINT: return 2.0 * AMPLITUDE_M * stations(t_s, 1.75, 1.0);
    case MULTISINE:
        for (int i = 0; i < 6; i++) sum += sin(2.0 * pi * hz[i] * t_s + i * i) / (1.0 + 0.5 * i);
        return rise(t_s, RAMP_S) * AMPLITUDE_M * sum;
    default:
        sum = rise(t_s - 2.0, 0.8) - rise(t_s - 8.0, 0.8) + rise(t_s - 11.0, 0.8) - rise(t_s - 18.0, 0.8);
        return sum * AMPLITUDE_M * sin(W * t_s);
    }
}

/* Difference quotients of a motion's position over this many steps. */
enum { APART = 5 };

/* Returns the positions of a motion at i STEP_S. All runs of a test program share them. */
static inline const double *positions(enum motion motion) {
    static double *known[MOTIONS];
    int count = (int)(ANY_END_S / STEP_S) + APART + 2;
    if (known[motion]) return known[motion];
    known[motion] = malloc((size_t)count * sizeof *known[motion]);
    assert_non_null(known[motion]);
    for (int i = 0; i < count; i++) known[motion][i] = position(motion, i * STEP_S);
    return known[motion];
}

/* Finds position, velocity and acceleration at i STEP_S. */
static inline void reference(const double *position_m, int i, double ref[3]) {
    double h = APART * STEP_S, before = position_m[i > APART ? i - APART : 0], at = position_m[i], after = position_m[i + APART];
    ref[0] = at, ref[1] = i > APART ? (after - before) / (2.0 * h) : 0.0, ref[2] = i > APART ? (after - 2.0 * at + before) / (h * h) : 0.0;
}

static inline void row(FILE *f, const struct rig *r, const struct body *b, double t_s, double ref_m, double force_n, double u,
                       uint64_t *state) {
    double x = steps(b->x + 2e-6 * gauss(state), 1e-5);
    if (r->electric) {
        fprintf(f, "%.6f,%.7f,%.3f\n", t_s, x, steps(force_n + r->offset_n + 3.0 * gauss(state), 0.1));
        return;
    }
    double p1 = steps(b->p1 + 1e4 * gauss(state), 7812.5), p2 = steps(b->p2 + 1e4 * gauss(state), 7812.5);
    fprintf(f, "%.6f,%.7f,%.9f,%.1f,%.1f,%.6f\n", t_s, x, ref_m, p1, p2, u);
}

/* Velocity of a motion at any time; 0 at its start. */
static inline double speed(enum motion motion, double t_s) {
    double h = APART * STEP_S;
    return t_s > h ? (position(motion, t_s + h) - position(motion, fmax(t_s - h, 0.0))) / (2.0 * h) : 0.0;
}

static inline bool lost(const struct rig *r, double t_s, uint64_t *dice, int *burst) {
    bool reverses = false;
    if (r->lost_s > 0.0) {
        double from = t_s - 0.5 * r->lost_s, to = t_s + 0.5 * r->lost_s;
        reverses = speed(r->motion, from) * speed(r->motion, to) < 0.0;
    }
    if (*burst > 0) *burst -= 1;
    else if (0.5 * (1.0 + random_unit(dice)) < r->lost_share / 3.0) *burst = 3;
    return reverses || *burst > 0;
}

/* Draws parameters that differ from the model's by up to 0.9 of the tolerance, either way. */
static inline struct tolerances draw(uint64_t *state) {
    double d[5];
    for (int i = 0; i < 5; i++) d[i] = 1.0 + (i ? 0.045 : 0.009) * random_unit(state);
    return (struct tolerances){d[0], d[1], d[2], d[3], d[4]};
}

static inline void run_rig(const struct rig *r, uint64_t seed, const char *path) {
    uint64_t state = seed * 77 + 5, dice = seed;
    int burst = 0;
    struct tolerances tol = draw(&state);
    struct body b = {.p1 = 4e6, .p2 = 4e6 * A1 / A2};
    double u = 0.0, ref[3], force_n = 0.0, lagging_n = 0.0, follows = -expm1(-STEP_S / fmax(r->force_lag_s, 1e-9));
    const double *position_m = positions(r->motion);
    FILE *f = fopen(path, "w");
    assert_non_null(f);
    b.p2 = (b.p1 * A1 - MASS_KG * r->gravity_mps2) / A2;
    fprintf(f, "# mechanism: axis\n# rate_hz: %g\n%s\n%s\n", r->rate_hz, r->motion == SINE ? "# frequency_hz: 2" : "# dof: none",
            r->electric ? "t_s,position_m,force_n" : "t_s,position_m,ref_m,p1_pa,p2_pa,u");
    int every = (int)lround(1.0 / r->rate_hz / STEP_S);
    for (int i = 0; i * STEP_S < (r->motion == SINE ? END_S : ANY_END_S); i++) {
        reference(position_m, i, ref);
        if (r->electric) force_n = 2e6 * (ref[0] - b.x) + 3e4 * (ref[1] - b.v) + MASS_KG * ref[2] + 2000.0 * ref[1];
        lagging_n += follows * (force_n - lagging_n);
        if (i % every == 0) {
            u = fmin(fmax(15.0 * (ref[0] - b.x) + 2.0 * ref[1], -1.0), 1.0);
            if (!lost(r, i * STEP_S, &dice, &burst)) row(f, r, &b, i * STEP_S, ref[0], lagging_n * (1.0 + r->force_more), u, &state);
        }
        if (!r->electric) oil(r, &tol, &b, u);
        push(r, &tol, &b, r->electric ? force_n : A1 * b.p1 - A2 * b.p2);
    }
    fclose(f);
}

#endif
