/* Systematic errors of a machine's sensors and of its drawing, the configured positions of the
 * joints. Nobody knows these errors, and each is therefore an unknown of every estimate from
 * measured motion, with a normal prior of mean zero. The standard deviation of the prior is stated
 * in model.tolerance; 0 means that there is no such error, and sensors that are exact
 * (sensors.enabled false) have none.
 *
 *   gain   reading = (1 + gain) pressure, for each sensor; a force sensor has the gain of P1
 *   length reading = length + zero + gain (length - neutral length), for each leg
 *   skew   age of the lengths less age of the pressures, one value for all legs
 *   lag    first-order lag of the pressure readings: one value common to all legs, and a
 *          difference for each leg
 *   pipe   length of the oil column between pressure sensor and chamber: one value common to all
 *          legs, and a difference for each leg
 *   compliance  by which a leg gives between its position sensor and its joints, under the
 *          hydraulic force F, positive where it pushes: reading = length + compliance F; one value
 *          for all legs
 *   joint  coordinates of the joints; model.tolerance.joints_m is their greatest error, uniform
 *
 * The zero of a pressure is no unknown of method C, because a constant force of a leg is part of
 * its dry friction in both directions; hexid gap has it in its base model. Pure. */
#ifndef HEXID_SYSTEMATIC_H
#define HEXID_SYSTEMATIC_H

#include <stdbool.h>

#include "types.h"

struct cylinder_model;
struct params;
struct residual_test;
struct series;

enum { JOINT_COORDINATES = 6 * LEGS };
/* Index of the first error of each kind. */
enum {
    SYSTEMATIC_P1_GAIN,
    SYSTEMATIC_P2_GAIN = SYSTEMATIC_P1_GAIN + LEGS,
    SYSTEMATIC_LENGTH_GAIN = SYSTEMATIC_P2_GAIN + LEGS,
    SYSTEMATIC_LENGTH_ZERO = SYSTEMATIC_LENGTH_GAIN + LEGS,
    SYSTEMATIC_SKEW = SYSTEMATIC_LENGTH_ZERO + LEGS,
    SYSTEMATIC_LAG,
    SYSTEMATIC_LAG_REST,
    SYSTEMATIC_PIPE = SYSTEMATIC_LAG_REST + LEGS,
    SYSTEMATIC_PIPE_REST,
    SYSTEMATIC_JOINT = SYSTEMATIC_PIPE_REST + LEGS,
    SYSTEMATIC_COMPLIANCE = SYSTEMATIC_JOINT + JOINT_COORDINATES,
    SYSTEMATICS
};

/* Finds the prior standard deviations, in the units of the errors: gains without unit, m, s, m/N. A
 * 0 means that the error does not exist. pressures: the forces are measured by pressures. */
void systematic_priors(const struct params *params, bool pressures, double std[SYSTEMATICS]);

/* Returns the upper limit of the standard deviation of the tests' skews about the common one, s. A
 * 0 means that all tests share one skew. */
double systematic_test_skew(const struct params *params);

/* Makes the tolerances of all these errors zero. */
struct tolerance_params;
void systematic_exclude(struct tolerance_params *tolerance);

/* True if this error changes the measured motion or the joints, and not just the leg forces. An
 * error of the forces changes the motion, too, through the compliance; at 20 N/um this is 2 % of
 * the error's effect on the residuals, and is neglected. */
bool systematic_moves(int error);

/* Families of errors as they are shown to users. */
enum systematic_family {
    FAMILY_PRESSURE_GAINS,
    FAMILY_LENGTH_GAINS,
    FAMILY_LENGTH_ZEROS,
    FAMILY_SKEW,
    FAMILY_LAGS,
    FAMILY_PIPES,
    FAMILY_JOINTS,
    FAMILY_COMPLIANCE,
    FAMILIES
};
/* Words of a family: its name, the key of model.tolerance that states its prior, and the unit that
 * is shown. scale: number of these units in one SI unit. */
struct systematic_words {
    const char *name, *key, *unit;
    double scale;
};
extern const struct systematic_words systematic_families[FAMILIES];
enum systematic_family systematic_family(int error);

/* True if all legs share the error. */
bool systematic_common(int error);

/* Returns the name of a sensor error's kind, "gain of P1". first: set to the kind's first error. */
const char *systematic_kind(int error, int *first);

/* Name of an error: "gain of P1, leg 3", "skew of the lengths". */
enum { SYSTEMATIC_NAME = 64 };
void systematic_name(int error, char name[SYSTEMATIC_NAME]);

/* Moves the joints of a machine by the errors of its drawing. */
void systematic_joints(const double error[SYSTEMATICS], struct params *machine);

/* Finds a test's series and undoes what the sensors and the pipes do to the readings, so that the
 * pressures become those in the chambers. The sensors and pipes are the stated ones of machine m
 * with these errors added to them, so m must not contain the errors itself. */
void systematic_undo(const struct cylinder_model *m, const double error[SYSTEMATICS], const struct residual_test *t, struct series *rows);

/* Finds a test's series with the errors undone that the machine's params->errors state; the stated
 * pipes are not undone, because the simulation has them as hoses. */
void systematic_series(const struct cylinder_model *m, const struct residual_test *t, struct series *rows);

/* Converts a coefficient row of a leg's difference `one` P1 - `other` P2 from the chambers to the
 * gauges: divides each coefficient by the factor by which systematic_series() raises the
 * coefficient's noise. */
void systematic_read_back(const struct cylinder_model *m, const struct residual_test *t, int leg, double one, double other, double *row);

/* Mass along a leg that is equivalent to the oil in one metre of its pipes, kg/m. */
double systematic_pipe_mass(const struct cylinder_model *m, int leg);

/* Relative change of a chamber's pressure for one metre of pipe, divided by the square of the
 * pressure's frequency in rad/s; unit s^2/m. The faster the pressure varies, the larger it is in
 * the chamber than at the gauge. length_m: length of the leg. */
double systematic_pipe_gain(const struct cylinder_model *m, int leg, int port, double length_m);

#endif
