/* SAFETY: checks the closed loop before anything moves, from the configuration alone
 * (loop_model.h): stability at neutral, where the platform is held and tested, and in other poses
 * down to parking and out to 80 % of the way to the strokes' ends (loop_places.h). The result is
 * only as good as the configuration. Ordinary threads. */
#ifndef HEXID_LOOP_CHECK_H
#define HEXID_LOOP_CHECK_H

#include "loop_places.h"

/* damping ratio below which hexid warns; with it an oscillation takes over three periods to decay
 * to 1/e */
#define LOOP_DAMPING_LEAST 0.05

enum loop_state {
    LOOP_UNKNOWN,        /* not computed: the supply cannot hold the platform up at neutral */
    LOOP_DAMPED,
    LOOP_UNSTABLE_AWAY,  /* damped at neutral, but unstable in another pose */
    LOOP_WEAK,           /* damped at neutral, but by less than LOOP_DAMPING_LEAST */
    LOOP_NOISY,          /* stable at neutral, but sensor noise shakes the platform with more than
                          * noise_most_mps2 */
    LOOP_UNSTABLE,       /* unstable at neutral */
};

struct loop_check {
    enum loop_state state;
    struct loop_worst neutral, away;       /* least damped pole at neutral, and in all other
                                            * poses */
    double away_pose[DOFS];                /* pose in which the pole `away` occurs */
    bool away_grows;                       /* the loop is unstable in the pose `away_pose`, whatever
                                            * `state` is */
    double noise_mps2, noise_most_mps2;    /* largest rms acceleration of the platform that sensor
                                            * noise causes, at neutral and on the way down to
                                            * parking (0 if LOOP_UNSTABLE), and its limit */
    const char *key;     /* configuration key that alone corrects the loop, "control.kpf"; NULL: no
                          * single key does, or `state` is LOOP_DAMPED or LOOP_UNKNOWN */
    double now, suits, damping;            /* current value of `key`, a suitable value, and the
                                            * damping ratio at neutral with the suitable value */
    double kff_suits, out_mps, in_mps;     /* means over the legs at neutral: the control.kff that
                                            * matches the valves, and the speeds of extension and
                                            * retraction at full opening */
};

/* Checks the closed loop. bus: the machine is on a field bus, where commands act at least one cycle
 * later. */
struct loop_check loop_check(const struct params *params, bool bus);

/* Limits of an acceptable feed-forward: largest control.kff, as a multiple of kff_suits (above it a
 * leg runs ahead of its reference), and largest loop_check_off_m(), as a share of
 * limits.following_m. The rest of that limit is left for other causes. */
#define LOOP_FEED_FORWARD_MOST 1.35
#define LOOP_FOLLOWING_SHARE 0.7

/* Returns the following error of a leg, m, that the difference of control.kff from kff_suits causes
 * in the fastest configured motion; 0 if kp is 0. */
double loop_check_off_m(const struct loop_check *c, const struct params *params);

/* Describes the result in `found`, and the remedy, which is "" for LOOP_DAMPED and LOOP_UNKNOWN. */
enum { LOOP_TEXT_SIZE = 300 };
void loop_check_describe(const struct loop_check *c, char found[LOOP_TEXT_SIZE], char remedy[LOOP_TEXT_SIZE]);

/* Returns true if `hexid run` refuses the loop: it is LOOP_UNSTABLE or, on a simulated machine,
 * LOOP_NOISY. On a field bus LOOP_NOISY only causes a warning, because the sensors' noise is known
 * only for the simulation. */
bool loop_check_refuses(const struct loop_check *c, bool bus);

/* Returns -2 if `hexid run` refuses the loop, with the mode, its frequency and damping, the key to
 * change and a suitable value; otherwise STATUS_OK. */
int loop_check_run(const struct loop_check *c, bool bus, struct error *error);

#endif
