/* SAFETY: the closed loop before anything moves, from the configuration alone (loop_model.h): is it
 * stable where the platform is held and tested, at neutral; and on its way down and out to the ends
 * of the strokes? It is as good as the configuration, on a machine as in simulation. Ordinary
 * threads. */
#ifndef HEXID_LOOP_CHECK_H
#define HEXID_LOOP_CHECK_H

#include "loop_model.h"

/* Below this damping ratio the loop is warned of: a step rings for more than three periods. */
#define LOOP_DAMPING_LEAST 0.05

/* Shaking by the sensors' noise alone, of limits.oscillation_mps2: the largest rms of a quarter
 * of a second was 1.5 to 1.8 times the computed mean (tests/test_oscillation.c, kp and kd). */
#define LOOP_NOISE_MOST 0.65

enum loop_state {
    LOOP_UNKNOWN,        /* not computed: the supply does not hold the platform up at neutral */
    LOOP_DAMPED,
    LOOP_UNSTABLE_AWAY,  /* at neutral it is damped, in another pose it is not stable */
    LOOP_WEAK,           /* at neutral, a damping below LOOP_DAMPING_LEAST */
    LOOP_NOISY,          /* stable, but its gains make the sensors' noise a shaking platform */
    LOOP_UNSTABLE,       /* at neutral */
};

struct loop_check {
    enum loop_state state;
    struct loop_worst neutral, away;       /* away: the least damping of all poses, */
    double away_pose[DOFS];                /* and where */
    double noise_mps2, noise_most_mps2;    /* shaking by the sensors' noise at neutral, rms; and how
                                            * much is borne */
    const char *key;                       /* the gain that alone puts it right, as "control.kpf";
                                            * NULL: none does */
    double now, suits, damping;            /* its value, one that suits, and the damping at neutral
                                            * with it */
    double kff_suits, out_mps, in_mps;     /* of the mean leg at neutral: the feed-forward that
                                            * suits its valve, and speeds at full opening */
};

/* bus: the machine is behind a field bus, where a command is in force one cycle later. */
struct loop_check loop_check(const struct params *params, bool bus);

/* Writes the finding, and the remedy, "" if nothing need be done. */
enum { LOOP_TEXT_SIZE = 300 };
void loop_check_describe(const struct loop_check *c, char found[LOOP_TEXT_SIZE], char remedy[LOOP_TEXT_SIZE]);

/* -2 where the loop is unstable at neutral, with the mode, its frequency and damping, or noisy,
 * with the key to change and a value that suits. The sensors are those of the simulated machine:
 * behind a field bus a noisy loop is warned of. */
int loop_check_run(const struct params *params, bool bus, struct error *error);

#endif
