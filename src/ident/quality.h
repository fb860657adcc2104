/* Quality of the motion system, measured in a recording of the motion that quality_plan.h plans:
 * the platform's pose, computed from the lengths, is compared with the reference at the same
 * instants. The quantities are those of AGARD-AR-144 and of 14 CFR 60 appendix A (3.a to 3.d),
 * defined in docs/qualify.md. The result depends on plan and samples alone; values that were not
 * measured are NaN. Ordinary threads; heap.
 *
 * Lengths and angles are m and rad; in quality_check.h's limits, and where a name says metres,
 * angles are multiplied by arm_m. */
#ifndef HEXID_QUALITY_H
#define HEXID_QUALITY_H

#include <complex.h>

#include "quality_plan.h"
#include "types.h"

/* Samples of the motion, one for each cycle of the plan. */
struct quality_record {
    int cycles;
    double (*pose)[DOFS], (*ref)[DOFS], (*length_m)[LEGS];
    bool *there;               /* false: lost or flagged */
    double last_s;             /* test time of the last cycle that was taken */
    int missing;               /* number of missing samples, set by quality_record_settle() */
};

/* Prepares an empty record. Returns -3 without memory; free it even then. */
int quality_record_init(struct quality_record *r, const struct quality_plan *plan, struct error *error);
void quality_record_free(struct quality_record *r);

/* Takes a cycle of the test; begin_s: test time at which the motion starts. If the test starts
 * again, the earlier samples are dropped. */
void quality_record_take(struct quality_record *r, const struct quality_plan *plan, double begin_s, const struct cycle *cycle);

/* Fills the gaps by linear interpolation, and sets the plan's amplitudes to the recorded ones.
 * Returns -2 if more than most_pct % of a piece's samples are missing, or if the recorded reference
 * is not the plan's motion. */
int quality_record_settle(struct quality_record *r, struct quality_plan *plan, double most_pct, struct error *error);

/* One tone of one axis. */
struct quality_tone {
    double hz, amplitude; /* frequency, and amplitude of the reference */
    double complex gain[DOFS]; /* amplitude of each axis over that of the reference of the tone's
                                * own axis, each in m or rad */
    double std; /* standard deviation of the own axis's gain, of its real and of its imaginary part;
                 * for a gain near 1 also that of its phase, rad */
    double coherence; /* share of the tone in the mean square of the response from half of the
                       * tone's frequency to QUALITY_BAND_HZ */
    /* acceleration of the response at all frequencies up to QUALITY_BAND_HZ other than the tone's,
     * divided by the acceleration at the tone. low: harmonics 2 and 3; high: higher ones; noise:
     * everything that is not a harmonic. These three are rms divided by rms. peak: peak of their
     * sum divided by the tone's amplitude. NaN: such harmonics are beyond QUALITY_BAND_HZ */
    double low, high, noise, peak;
};

enum { QUALITY_BANDS = 4 };
#define QUALITY_BAND_HZ 20.0 /* noise and harmonics in motion count up to here */
extern const double quality_band_hz[QUALITY_BANDS + 1];

struct quality_axis {
    double rest[QUALITY_BANDS]; /* rms acceleration at rest in each band, m/s^2, rad/s^2 */
    /* in a slow triangle: displacement of the reference from rest until the platform has covered
     * half of this displacement, and width of the hysteresis loop. NaN: more than the triangle can
     * show */
    double threshold, hysteresis;
    double slope_rate; /* rate of the reference in that triangle: a pure lag T appears as a
                        * threshold, and as a hysteresis, of 2 T slope_rate */
    double lag_s; /* phase lag of the 0.5 Hz tone divided by its frequency in rad/s */
    double dead_s, half_s; /* delay at a tenth and at half of a step's height */
    double excursion, rate, accel; /* largest amplitudes reached in sines */
    double turn_around; /* peak acceleration at the reversals of the 0.5 Hz tone, without that of
                         * the tone itself */
};

struct quality {
    struct quality_plan plan;
    int missing; /* samples that were interpolated */
    struct quality_tone tone[DOFS][QUALITY_TONES];
    struct quality_axis axis[DOFS];
    double complex leg[LEGS]; /* amplitude of each leg over that of its own reference, in the 0.5 Hz
                               * tone of z */
};

/* Measures all quantities. Returns -2 for impossible geometry, -3 without memory. */
int quality_measure(struct quality *q, const struct quality_plan *plan, const struct quality_record *record, const struct params *params,
                    struct error *error);

/* Factor from an axis's unit to metres: 1, or arm_m for an angle. */
double quality_metres(const struct quality_plan *plan, int dof);

/* Amplitude of an axis as a share of the reference of axis `driven`, both in metres; for dof =
 * driven it is the magnitude of the gain. */
double quality_cross(const struct quality *q, int driven, int tone, int dof);

/* The largest of quality_cross() of all other axes. */
double quality_cross_most(const struct quality *q, int driven, int tone);

/* The larger value; NaN if either is NaN, unlike fmax(), which ignores NaN. */
double quality_worse(double most, double value);

/* Phase of a tone, degrees, continued from the axis's lower tones so that it does not jump. */
double quality_phase_deg(const struct quality *q, int dof, int tone);

#endif
