/* The gap between a model and a measurement: where it is, which effect of the catalogue explains
 * it, how sure that is, and how much of it is gone with that effect in the model (gap_solve). One
 * call, one result; everything that a report needs stands in it or can be computed again from it
 * (waveforms: waves.h). Ordinary threads; heap. SI units, legs 0..5. */
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

/* Closed loop where the log has what drove it, else by the measured motion; or as asked. */
enum gap_replay { GAP_AS_KNOWN, GAP_CLOSED_LOOP, GAP_MOTION };

struct gap_effect {
    int effect;                           /* its place in effect_table */
    int shape;                            /* -1 all legs alike, -2 each its own,
                                           * or the one leg 0..5 */
    int keys;                             /* its first ones: on one axis, what acts
                                           * on a pose has x alone */
    struct effect_values values;
    struct effect_values given;           /* what the configuration has of it; on: it is
                                           * there, of another size */
    double std[EFFECT_KEYS][LEGS];        /* of noise, and as large as what is left of the gap
                                           * demands; 0: at its bound */
    bool bound[EFFECT_KEYS][LEGS];        /* stuck at the end of its range: not
                                           * found, only reached for */
    double share_explained;               /* of the squared gap above the floor, held-out cycles:
                                           * alone, or what was gone when it joined others */
    double z;                             /* square root of the likelihood's gain on all cycles,
                                           * less what its values cost by their priors: the whole
                                           * of one alone, or when it joined others */
    char evidence[GAP_TEXT];
};

/* An effect tried in the first round, in its best shape. */
struct gap_candidate {
    int effect, shape;
    double gain;                          /* of the sum of white squares, fitted cycles,
                                           * less a penalty for its parameters */
    double z;                             /* as of an effect; after the first steps, where it is
                                           * small by then */
    double share_explained;
};

struct gap_place {
    int test, leg, harmonic;
    enum dof dof;
    double frequency_hz;                  /* of the motion; harmonic: of that */
    double at_s, piece_s;                 /* any motion: the piece's start and length;
                                           * 0: a steady sinusoid */
    enum gap_channel channel;
    const char *feature; /* static, velocity_reversal, spool_reversal, one_direction,
                          * peak_speed, peak_acceleration */
    double share;        /* of the squared white gap */
};

/* A difference: root mean square over channels of (rms / rms of the measured variation), and each
 * channel's in SI units and normalised. varying: overall, but of what varies alone: what is
 * constant depends on where a run began, as long as a valve stays shut. */
struct gap_size {
    double overall, varying, channel[GAP_CHANNELS], normalised[GAP_CHANNELS];
};

/* A line off the harmonics of the motion, where no effect of the catalogue is looked for: a pump, a
 * neighbour, a loop that oscillates by itself. */
struct gap_line {
    double hz, rms;                       /* 0 Hz: none */
    enum gap_channel channel;
    enum dof dof;                         /* the test where it is strongest */
    int test;
};

struct gap_base_value {
    const char *name;
    int leg; /* 0..5; -1: of the machine */
    double given, value, std; /* std NAN: held beside an effect that is parallel to it */
    bool bound;
};

struct gap_result {
    enum gap_verdict verdict;
    char reason[GAP_TEXT];                /* one sentence for people */
    int effects;
    struct gap_effect effect[GAP_EFFECTS];/* the surest first */
    int ambiguous;                        /* rivals of effect[in_doubt], by place in effect_table */
    int in_doubt;
    int ambiguous_with[GAP_RIVALS];
    bool offset_rival;                    /* so is a constant force, which is no effect of the
                                           * catalogue (one axis) */
    int candidates;                       /* all effects tried, best first */
    struct gap_candidate candidate[EFFECTS_MAX];
    int places;
    struct gap_place where[GAP_PLACES];
    struct gap_size before, after, noise_floor, held_out_before, held_out_after;
    bool simulated;                       /* the sizes are of a replay; else of
                                           * the equations alone */
    bool validated;                       /* those held out are of another log */
    char replay_fault[GAP_TEXT];          /* why the model with the effects does not get through the
                                           * tests; empty: it does */
    double unexplained_fraction;          /* held out; NaN where nothing can be compared */
    char next_experiment[GAP_TEXT];
    int base_values;
    struct gap_base_value base[GAP_BASE];
    struct gap_line line;
    bool line_simulated;                  /* the model with the effects found has it, too */
    bool controller_known, controller_differs;
    double stated_hz, moved_hz;           /* of the first test whose legs move at another frequency
                                           * than stated; else 0 */
    double sampled_s;                     /* between the log's samples, where the controller's
                                           * cycle is another; else 0 */
    double controller_difference;         /* rms of the command that the configured controller would
                                           * not have given, of its variation */
    double white_before, white_after;     /* mean white square, held-out cycles: 1 is noise */
    bool matrices;
    double measured_mt[DOFS][DOFS], before_mt[DOFS][DOFS], after_mt[DOFS][DOFS];
    bool repaired;                        /* friction was found: */
    double repaired_mt[DOFS][DOFS];       /* the measured matrix without what that does
                                           * to it, in simulation */
    struct params base_model;             /* base re-estimated, no effect added */
    struct params model;                  /* the configuration given, plus the effects
                                           * found (base as given) */
    struct params fitted;                 /* base re-estimated and effects: what
                                           * `after` was simulated with */
    enum gap_replay replay;
    double seconds;
};

struct waves;

struct gap_options {
    enum gap_replay replay;
    bool simulate;                        /* prove it by replay */
    int threads;
    void (*progress)(void *context, const char *step, double share); /* NULL: none; any thread */
    void *context;
};

/* Says so to who asked for it. */
void gap_progress(const struct gap_options *options, const char *step, double share);

/* All legs have the same value in the configuration. */
bool gap_given_alike(const struct gap_effect *effect, int key);

/* Standard deviation of a value: of noise, and of its law, which is no surer of its parameters than
 * it is exact. 0: at its bound. */
double gap_deviation(const struct gap_effect *effect, int key, int leg);

/* z by which a candidate falls short of the likeliest. */
double gap_short(const struct gap_result *result, const struct gap_candidate *candidate);

/* "test x at 4 Hz, force of leg 2, harmonic 3", or "at 3.21 s near 5.4 Hz, force of leg 2"; without
 * the leg where there is one. */
const char *gap_place_words(const struct gap_place *place, int legs, char words[GAP_WORDS]);

/* measured is checked already (recording_check); validate may be NULL. waves: filled where the
 * result is simulated, to be freed; NULL: not wanted. 0, or a negative status. */
int gap_solve(const struct params *params, const struct recording *measured, const struct recording *validate,
              const struct gap_options *options, struct gap_result *result, struct waves *waves, struct error *error);

#endif
