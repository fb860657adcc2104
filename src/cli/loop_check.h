/* SAFETY: checks the closed loop before anything moves, from the configuration alone
 * (loop_model.h): stability at neutral, where the platform is held and tested, and in other poses
 * down to parking and out to 80 % of the way to the strokes' ends (loop_places.h). The result is
 * only as good as the configuration. Ordinary threads. */
#ifndef HEXID_LOOP_CHECK_H
#define HEXID_LOOP_CHECK_H

#include "loop_places.h"

/* damping ratio below which hexid warns, because ringing then takes over three periods to fall to
 * 1/e */
#define LOOP_DAMPING_LEAST 0.05

enum loop_state {
    LOOP_UNKNOWN,        /* not computed: the supply cannot hold the platform up at neutral */
    LOOP_DAMPED,
    LOOP_UNSTABLE_AWAY,  /* damped at neutral, but unstable in another pose */
    LOOP_WEAK,           /* damped at neutral, but by less than LOOP_DAMPING_LEAST */
    LOOP_NOISY,          /* stable at neutral, but sensor noise shakes the platform by more than
                          * noise_most_mps2 */
    LOOP_UNSTABLE,       /* unstable at neutral */
};

struct loop_check {
    enum loop_state state;
    struct loop_worst neutral, away;       /* least damped pole at neutral, and in all other
                                            * poses */
    double away_pose[DOFS];                /* pose in which the pole `away` occurs */
    bool away_grows;                       /* the loop is unstable in that pose, whatever `state` */
    double noise_mps2, noise_most_mps2;    /* largest rms acceleration of the platform by sensor
                                            * noise, at neutral and on the way down to parking
                                            * (0 if LOOP_UNSTABLE), and its limit */
    const char *key;     /* configuration key that alone corrects the loop, "control.kpf"; NULL: no
                          * single key does, or `state` is LOOP_DAMPED or LOOP_UNKNOWN */
    double now, suits, damping;            /* current value of `key`, a suitable value, and the
                                            * damping ratio at neutral with the suitable value */
    double kff_suits, out_mps, in_mps;     /* for the mean leg at neutral: feed-forward that matches
                                            * its valve, and speeds out and in at full opening */
};

/* Checks the closed loop. bus: the machine is on a field bus, where commands act at least one cycle
 * later. */
struct loop_check loop_check(const struct params *params, bool bus);

/* Limits of an acceptable feed-forward: largest control.kff, as a multiple of kff_suits (above it a
 * leg runs ahead of its reference), and largest loop_check_off_m(), as a share of
 * limits.following_m. The remaining share is for other causes. */
#define LOOP_FEED_FORWARD_MOST 1.35
#define LOOP_FOLLOWING_SHARE 0.7

/* Returns the following error of a leg, m, that a control.kff other than kff_suits causes at the
 * fastest configured motion; 0 without kp. */
double loop_check_off_m(const struct loop_check *c, const struct params *params);

/* Writes what was found and the remedy. The remedy of LOOP_DAMPED and LOOP_UNKNOWN is "". */
enum { LOOP_TEXT_SIZE = 300 };
void loop_check_describe(const struct loop_check *c, char found[LOOP_TEXT_SIZE], char remedy[LOOP_TEXT_SIZE]);

/* Returns true if `hexid run` refuses the loop: it is LOOP_UNSTABLE or, on a simulated machine,
 * LOOP_NOISY. On a field bus a noisy loop only causes a warning, because sensor noise is known only
 * for the simulation. */
bool loop_check_refuses(const struct loop_check *c, bool bus);

/* Returns STATUS_OK, or -2 for a loop that is refused, with the mode, its frequency and damping,
 * the key to change and a suitable value. */
int loop_check_run(const struct loop_check *c, bool bus, struct error *error);

#endif
