/* Result of hexid gap: where the gap between model and measurement lies, which effect of the
 * catalogue explains it, how certain that is, and how much of the gap the effect closes. The result
 * contains everything that a report needs, except waveforms (waves.h). SI units, legs 0..5. */
#ifndef HEXID_GAP_RESULT_H
#define HEXID_GAP_RESULT_H

#include "params.h"

enum { GAP_EFFECTS = 4, GAP_PLACES = 12, GAP_BASE = 128, GAP_TEXT = 2048, GAP_RIVALS = 8, GAP_WORDS = 80, GAP_STATEMENTS = 6 };

/* Least probability with which a statement or a verdict is sure. */
#define GAP_SURE 0.95

enum gap_verdict { GAP_EFFECT_NAMED, GAP_NO_GAP, GAP_AMBIGUOUS, GAP_UNKNOWN_EFFECT, GAP_PARTLY_NAMED, GAP_VERDICTS };
extern const char *const gap_verdict_names[GAP_VERDICTS]; /* effect_named, no_gap, ambiguous,
                                                           * unknown_effect, partly_named */

/* Channels in which model and measurement are compared. */
enum gap_channel { GAP_LENGTH, GAP_FORCE, GAP_P1, GAP_P2, GAP_VALVE, GAP_CHANNELS };
extern const char *const gap_channel_names[GAP_CHANNELS]; /* length, force, p1, p2, valve */
extern const char *const gap_channel_units[GAP_CHANNELS];

/* How models are compared with the log: by simulation in closed loop, or under the measured motion.
 * GAP_AS_KNOWN: in closed loop if compare_check() (compare.h) allows it, otherwise under the
 * motion. */
enum gap_replay { GAP_AS_KNOWN, GAP_CLOSED_LOOP, GAP_MOTION };

struct gap_effect {
    int effect;                           /* index in effect_table */
    int pattern;              /* legs that have the effect: -1 all with one value, -2 each with its
                               * own value, 0..5 that leg alone */
    int keys;                             /* number of keys in use, from the first on; an effect
                                           * with a key for each axis of the pose uses as many as
                                           * the mechanism has axes */
    struct effect_values values;
    struct effect_values given;           /* values in the configuration; `on`: the configuration
                                           * has the effect, too */
    double std[EFFECT_KEYS][LEGS];        /* standard deviations, larger if a gap remains; 0: the
                                           * value is at its bound, or was not fitted */
    bool bound[EFFECT_KEYS][LEGS];        /* the value is at an end of its range, so it is no
                                           * estimate */
    double share_explained;               /* share of the squared gap that the effect explains, on
                                           * held-out cycles. By the search: 1 for a single effect;
                                           * for one of several, the share of the explained gap that
                                           * disappeared when it was added, or the share that it
                                           * explains alone, whichever is larger. By sets of
                                           * effects: share of the gap above noise that the effect
                                           * explains alone */
    double z;                             /* strength of evidence. By the search: square root of the
                                           * gain in squared white residuals on all cycles, less the
                                           * penalty of the effect's priors; for one of several
                                           * effects, of the gain when it was added. By sets of
                                           * effects: square root of twice the log evidence that is
                                           * lost without the effect. For clock skew: deviation of
                                           * the ratio of the clocks, in standard deviations */
    char evidence[GAP_TEXT];
};

/* An effect that was tried in the first round, with the best choice of legs. */
struct gap_candidate {
    int effect, pattern;
    double gain;     /* gain in squared white residuals on the fitted cycles, less the penalty for
                      * its parameters */
    double z;        /* z as in gap_effect; it is too small for a trial that gained little in its
                      * first steps, because such a trial was not fitted further */
    double share_explained; /* share of the squared gap that the effect explains alone, on held-out
                             * cycles; below 0 if it enlarges the gap */
    bool unseen;     /* the search does not name the effect, because the data do not show it: a
                      * value is at a bound, or the effect is a friction that acts mostly where a
                      * leg may stick */
};

/* An effect or a family of effects, with the probability that the machine has it. The probability
 * allows for a remainder that no law explains (covariance.h). */
struct gap_statement {
    bool family;                          /* the statement is about a family of effects: one of them
                                           * is there, whatever its law */
    int which;                            /* index of the family, or of the effect in
                                           * effect_table */
    double probability;
    double share_explained;               /* as in gap_effect, for the effect alone; for a family,
                                           * for its likeliest effect */
    struct gap_effect effect;             /* the effect, or the likeliest one of the family, with
                                           * its values in the likeliest set that contains it */
};

/* Probability of a verdict among the sets of effects that were compared, and the likeliest set that
 * contradicts the verdict, with its own probability. probability NaN: not known, as for an unknown
 * effect. */
struct gap_certainty {
    double probability, other_probability;
    int others, other[GAP_EFFECTS];       /* effects of the contradicting set; none: the base
                                           * alone */
};

struct gap_place {
    int test, leg, harmonic;
    enum dof dof;
    double frequency_hz;             /* frequency of the motion, which `harmonic` (0: the constant)
                                      * multiplies; for a segment, frequency of the place, and
                                      * `harmonic` is 1 */
    double at_s, segment_s;               /* start and length of a segment of any motion;
                                           * segment_s 0: a steady sinusoid */
    enum gap_channel channel;
    const char *feature; /* motion feature that the gap follows most: static, velocity_reversal,
                          * spool_reversal, one_direction, peak_speed, peak_acceleration */
    double share;        /* share of this place in the sum of squared white residuals */
};

/* Size of a difference between model and measurement. overall: root mean square over the channels
 * of `normalised`. varying: like overall, but without the constants, which differ from run to run
 * if a valve stays shut; under the measured motion it equals overall. channel: rms in SI units.
 * normalised: channel divided by the rms of the measured variation. NaN: the channel is not
 * compared. */
struct gap_size {
    double overall, varying, channel[GAP_CHANNELS], normalised[GAP_CHANNELS];
};

/* A tone off the harmonics of the motion, as from a pump, a neighbouring machine or a loop that
 * oscillates. No effect of the catalogue explains a tone. */
struct gap_tone {
    /* hz 0: there is no tone. rms: in the unit of the channel */
    double hz, rms;
    enum gap_channel channel;
    enum dof dof;                         /* axis of the test in which the tone is strongest */
    int test;
};

/* Dry friction that is not the same in each test, as that of seals that warm up. */
struct gap_course {
    int frictions, effect; /* frictions: number of dry frictions among the effects; effect: the last
                            * of them */
    double ratio;          /* friction in the test `most`, divided by that in the test `least`; 0:
                            * it does not clearly change */
    bool at_least;         /* `ratio` is only a lower bound of the true ratio */
    struct {
        int test;
        enum dof dof;
    } most, least;
};

struct gap_base_value {
    const char *name;
    int leg; /* 0..5, or -1: the whole machine */
    /* std NaN: the value was held fixed, because an effect is parallel to it */
    double given, value, std;
    bool bound;
};

struct gap_result {
    enum gap_verdict verdict;
    char reason[GAP_TEXT];                /* the verdict's reason, one sentence for people */
    int effects;
    struct gap_effect effect[GAP_EFFECTS];/* the most certain effect first */
    int statements;                       /* number of statements: first the sure ones, which the
                                           * verdict makes if it names effects, then the likeliest
                                           * other effects; 0: the effects of the result are those
                                           * of the search, or simpler ones in their place */
    struct gap_statement statement[GAP_STATEMENTS];
    struct gap_certainty certainty;       /* certainty of the verdict */
    int ambiguous;                        /* number of effects that the data cannot distinguish from
                                           * effect[in_doubt]; ambiguous_with: their indices in
                                           * effect_table */
    bool ambiguous_together;              /* only all ambiguous_with together look like
                                           * effect[in_doubt]; false: each one alone does */
    int in_doubt;
    int ambiguous_with[GAP_RIVALS];
    bool offset_rival;                    /* a dry friction among the effects may also be a
                                           * symmetric one beside a constant force, which is no
                                           * effect of the catalogue (single axis) */
    int candidates;                       /* number of effects that were tried; the best is first */
    struct gap_candidate candidate[EFFECTS_MAX];
    int places;
    struct gap_place where[GAP_PLACES];
    /* Sizes of the gap without and with the effects, on the fitted cycles and on held-out data.
     * noise_floor: size that noise alone gives on held-out data. */
    struct gap_size before, after, noise_floor, held_out_before, held_out_after;
    bool simulated;                       /* the sizes come from simulations in closed loop; false:
                                           * from the equations under the measured motion */
    bool validated;                       /* the held-out sizes come from another log */
    char replay_fault[GAP_TEXT];          /* fault that ended the simulation with the effects; empty
                                           * if it ended without one */
    double unexplained_fraction;          /* share of the squared gap above the noise floor that is
                                           * left on held-out data, 0..1; NaN if nothing can be
                                           * compared */
    char next_experiment[GAP_TEXT];
    int base_values;
    struct gap_base_value base[GAP_BASE];
    struct gap_course course;
    struct gap_tone tone;
    bool tone_simulated;                  /* the simulation with the effects shows the tone as
                                           * well */
    bool controller_known, controller_differs;
    double one_hz;                        /* lowest frequency of the tests if each axis has one
                                           * frequency, which is the same in the validation log; 0:
                                           * an axis has several, or a motion is no sinusoid */
    double stated_hz, moved_hz;           /* stated and measured frequency of the first test in
                                           * which they differ; otherwise 0 */
    double sampled_s;                     /* time between the log's samples if it differs from the
                                           * controller's cycle; otherwise 0 */
    double controller_difference;         /* rms difference between the recorded commands and those
                                           * of the configured controller, as a share of the rms
                                           * variation of the recorded ones; NaN: not known */
    double white_before, white_after;     /* mean squared white residual on held-out cycles, without
                                           * and with the effects found; noise gives 1 */
    bool matrices;                        /* measured_mt, before_mt and after_mt are valid: inertia
                                           * matrices by method A, as measured and as simulated
                                           * without and with the effects */
    double measured_mt[DOFS][DOFS], before_mt[DOFS][DOFS], after_mt[DOFS][DOFS];
    bool repaired;                        /* repaired_mt is valid, because friction was found */
    double repaired_mt[DOFS][DOFS];       /* measured inertia matrix, less the change that the found
                                           * friction makes to the matrix in simulation */
    struct params base_model;             /* the base as fitted without effects */
    struct params model; /* the given configuration with the found effects; the base values are the
                          * given ones */
    struct params fitted;                 /* the base as fitted with the found effects; `after` was
                                           * computed with it */
    enum gap_replay replay;
    double seconds;
};

/* True if the configuration gives all legs the same value of this key. */
bool gap_given_alike(const struct gap_effect *effect, int key);

/* Standard deviation of an effect's value: its deviation by noise and the relative error of the
 * effect's law, added in quadrature. 0: the value is at its bound, or was not fitted. */
double gap_deviation(const struct gap_effect *effect, int key, int leg);

/* Name of the effect or family that a statement is about, and level of the statement, "effect" or
 * "family". */
const char *gap_statement_name(const struct gap_statement *statement);
const char *gap_statement_level(const struct gap_statement *statement);

/* Writes a probability in words, as in "0.91" or "below 0.001"; returns them. */
const char *gap_probability_words(double probability, char words[GAP_WORDS]);

/* Returns the first family that the verdict states in place of an effect; "" if it states none. */
const char *gap_family_name(const struct gap_result *result);

/* Distance of a candidate behind the likeliest one, on the scale of z: the square root of the
 * difference between the two squared z. */
double gap_short(const struct gap_result *result, const struct gap_candidate *candidate);

/* Sorts the effects, the most certain first. in_doubt is left as it was. */
void gap_sort_effects(struct gap_result *result);

/* Signature of an effect in the data. With one leg the word "leg" is left out. */
const char *gap_signature(int effect, int legs);

/* Writes "test x at 4 Hz, force of leg 2, harmonic 3" for a steady sinusoid, "at 3.21 s near 5.4
 * Hz, force of leg 2" for a segment. With one leg its number is left out. */
const char *gap_place_words(const struct gap_place *place, int legs, char words[GAP_WORDS]);

#endif
