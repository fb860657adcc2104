/* The gap between a model and a measurement: where it lies, which effect of the catalogue
 * explains it, how certain that is, and how much of it that effect closes (gap_solve). The
 * result holds everything that a report needs; waveforms are computed from it (waves.h).
 * Ordinary threads; heap. SI units, legs 0..5. */
#ifndef HEXID_GAP_H
#define HEXID_GAP_H

#include "recording.h"

enum { GAP_EFFECTS = 4, GAP_PLACES = 12, GAP_BASE = 64, GAP_TEXT = 1024, GAP_RIVALS = 8, GAP_WORDS = 80 };

enum gap_verdict { GAP_EFFECT_NAMED, GAP_NO_GAP, GAP_AMBIGUOUS, GAP_UNKNOWN_EFFECT, GAP_VERDICTS };
extern const char *const gap_verdict_names[GAP_VERDICTS]; /* effect_named, no_gap, ambiguous,
                                                           * unknown_effect */

/* Channels in which model and measurement are compared. */
enum gap_channel { GAP_LENGTH, GAP_FORCE, GAP_P1, GAP_P2, GAP_VALVE, GAP_CHANNELS };
extern const char *const gap_channel_names[GAP_CHANNELS]; /* length, force, p1, p2, valve */
extern const char *const gap_channel_units[GAP_CHANNELS];

/* GAP_AS_KNOWN: closed loop if the log has reference, commands and pressures, else motion. */
enum gap_replay { GAP_AS_KNOWN, GAP_CLOSED_LOOP, GAP_MOTION };

struct gap_effect {
    int effect;                           /* index in effect_table */
    int shape;                /* legs: -1 all with one value, -2 each its own value, 0..5 one leg */
    int keys;                             /* number of keys in use: on a single axis, an effect
                                           * that acts on the pose has x alone */
    struct effect_values values;
    struct effect_values given;           /* values in the configuration; `on` if it has the
                                           * effect, with another size */
    double std[EFFECT_KEYS][LEGS];        /* standard deviation, enlarged by the residual gap; 0:
                                           * at its bound */
    bool bound[EFFECT_KEYS][LEGS];        /* at the end of its range, so not an estimate */
    double share_explained;               /* share of the squared gap above the noise floor on
                                           * held-out cycles; of several effects, what was gone
                                           * when it joined */
    double z;                             /* square root of the likelihood's gain on all cycles,
                                           * less its priors' penalty; of several effects, the
                                           * gain when it joined */
    char evidence[GAP_TEXT];
};

/* An effect tried in the first round, with its best choice of legs. */
struct gap_candidate {
    int effect, shape;
    double gain;     /* gain in white squares on fitted cycles, less a penalty for its parameters */
    double z;        /* as in gap_effect; if small after the first steps, it stays as it was then */
    double share_explained;
    bool unseen;     /* never named, because these data do not show it: its values are at a bound,
                      * or it is a friction only where a leg may stick */
};

struct gap_place {
    int test, leg, harmonic;
    enum dof dof;
    double frequency_hz;             /* frequency of the motion; the harmonic is a multiple of it */
    double at_s, piece_s;                 /* start and length of a segment of any motion; piece_s
                                           * 0: a steady sinusoid */
    enum gap_channel channel;
    const char *feature; /* static, velocity_reversal, spool_reversal, one_direction,
                          * peak_speed, peak_acceleration */
    double share;        /* share of the squared white gap */
};

/* Size of a difference. overall: root mean square over channels of (rms / rms of the measured
 * variation). channel: rms in SI units; normalised: each by its variation. varying: overall
 * without the constants, which depend on where a run began if a valve stays shut. */
struct gap_size {
    double overall, varying, channel[GAP_CHANNELS], normalised[GAP_CHANNELS];
};

/* A tone off the harmonics of the motion: a pump, a neighbouring machine, a loop that
 * oscillates. No effect of the catalogue explains one. */
struct gap_line {
    double hz, rms;                       /* hz 0: no tone */
    enum gap_channel channel;
    enum dof dof;                         /* the test in which it is strongest */
    int test;
};

struct gap_base_value {
    const char *name;
    int leg; /* 0..5; -1: the whole machine */
    double given, value, std; /* std NaN: held fixed, because an effect is parallel to it */
    bool bound;
};

struct gap_result {
    enum gap_verdict verdict;
    char reason[GAP_TEXT];                /* one sentence for people */
    int effects;
    struct gap_effect effect[GAP_EFFECTS];/* most certain first */
    int ambiguous;                        /* number of rivals of effect[in_doubt];
                                           * ambiguous_with: their indices in effect_table */
    int in_doubt;
    int ambiguous_with[GAP_RIVALS];
    bool offset_rival;                    /* a constant force is a rival too; it is no effect of
                                           * the catalogue (single axis) */
    int candidates;                       /* number of effects tried, best first */
    struct gap_candidate candidate[EFFECTS_MAX];
    int places;
    struct gap_place where[GAP_PLACES];
    struct gap_size before, after, noise_floor, held_out_before, held_out_after;
    bool simulated;                       /* sizes come from simulations in closed loop; false:
                                           * from the equations under the measured motion */
    bool validated;                       /* held-out sizes come from another log */
    char replay_fault[GAP_TEXT];          /* why the model with the effects did not get through
                                           * the tests; empty: it did */
    double unexplained_fraction;          /* share of the gap left on held-out data; NaN if
                                           * nothing can be compared */
    char next_experiment[GAP_TEXT];
    int base_values;
    struct gap_base_value base[GAP_BASE];
    struct gap_line line;
    bool line_simulated;                  /* the model with the effects found shows the tone too */
    bool controller_known, controller_differs;
    double stated_hz, moved_hz;           /* stated and measured frequency of the first test in
                                           * which they differ; else 0 */
    double sampled_s;                     /* time between the log's samples if it is not the
                                           * controller's cycle; else 0 */
    double controller_difference;         /* share of the command's rms variation that the
                                           * configured controller does not reproduce */
    double white_before, white_after;     /* mean white square on held-out cycles; noise gives 1 */
    bool matrices;
    double measured_mt[DOFS][DOFS], before_mt[DOFS][DOFS], after_mt[DOFS][DOFS];
    bool repaired;                        /* repaired_mt is valid: friction was found */
    double repaired_mt[DOFS][DOFS];       /* the measured matrix, less the change that the
                                           * friction found makes in simulation */
    struct params base_model;             /* base re-estimated, without effects */
    struct params model; /* the given configuration with the effects found; its base is unchanged */
    struct params fitted;                 /* base re-estimated, with the effects found; `after`
                                           * was simulated with it */
    enum gap_replay replay;
    double seconds;
};

struct waves;

struct gap_options {
    enum gap_replay replay;
    bool simulate;                        /* check the result by replay */
    int threads;
    void (*progress)(void *context, const char *step, double share); /* from any thread; may be
                                                                      * NULL */
    void *context;
};

/* Calls options->progress if there is one. */
void gap_progress(const struct gap_options *options, const char *step, double share);

/* True if the configuration gives all legs the same value of this key. */
bool gap_given_alike(const struct gap_effect *effect, int key);

/* Standard deviation of a value: noise and the relative error of the effect's law, added in
 * quadrature. 0: the value is at its bound. */
double gap_deviation(const struct gap_effect *effect, int key, int leg);

/* Distance in z of a candidate from the likeliest one. */
double gap_short(const struct gap_result *result, const struct gap_candidate *candidate);

/* "test x at 4 Hz, force of leg 2, harmonic 3", or "at 3.21 s near 5.4 Hz, force of leg 2". With
 * a single leg its number is omitted. */
const char *gap_place_words(const struct gap_place *place, int legs, char words[GAP_WORDS]);

/* Runs the whole diagnosis. measured must have passed recording_check; validate may be NULL.
 * waves: filled if the result is simulated, to be freed by the caller; may be NULL. Returns 0 or
 * a negative status. */
int gap_solve(const struct params *params, const struct recording *measured, const struct recording *validate,
              const struct gap_options *options, struct gap_result *result, struct waves *waves, struct error *error);

#endif
