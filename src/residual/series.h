/* Fourier series of the values that a test's sensors read, with the sensors' errors undone. Pure.
 *
 * A steady test is never quite periodic: the controller creeps towards the mean pose, and chambers
 * whose valves hardly open take seconds to settle. The series leave this drift out. Its slopes are
 * kept separately, because a piston that creeps displaces oil: without the slopes the mean
 * pressures of pistons of 125 mm diameter that creep by 0.07 mm/s were 6 kPa off. */
#ifndef HEXID_SERIES_H
#define HEXID_SERIES_H

#include "cylinder.h"
#include "residual.h"

struct series {
    /* lengths, m, pressures, Pa, and force by a force sensor, N */
    double length[LEGS][SPECTRUM_SIZE], p1[LEGS][SPECTRUM_SIZE], p2[LEGS][SPECTRUM_SIZE], force[LEGS][SPECTRUM_SIZE];
    double ahead[LEGS][SPECTRUM_SIZE]; /* distance by which backlash puts the rods ahead of their
                                        * joints */
    double drift_mps[LEGS], drift_pa_per_s[PORTS][LEGS]; /* slopes of lengths and pressures over the
                                                          * cycles; 0 for a segment */
};

/* Fills `rows` with the series of a test's readings, with offset, scale, lag and delay of this
 * machine's sensors undone. The rods are taken to be at their joints, without backlash. */
void series_undo(const struct machine *m, const struct residual_test *t, struct series *rows);

/* Finds the series of the hydraulic force on a leg's rod, from the chambers' pressures or from the
 * force sensor, less the constant error axis.force_offset_n if the mechanism has a force sensor. */
void series_push(const struct cylinder_model *m, const struct residual_test *t, const struct series *rows, int leg,
                 double force_n[SPECTRUM_SIZE]);

/* Finds the series of the rate of change of a series. */
void series_rate(const struct residual_test *t, const double *row, double *rate);

/* Converts a series to a coefficient row of residuals. */
void series_row(const struct residual_test *t, const double *series, double row[RESIDUAL_SIZE]);

#endif
