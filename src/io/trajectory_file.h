/* Reads a trajectory from a CSV file: a line with the names of the columns, then 3 to 500000 rows,
 * each a pose, at increasing times, evenly spaced or not.
 *
 *     t_s,x_m,y_m,z_m,phi_rad,theta_rad,psi_rad
 *
 * The columns may stand in any order; axes without a column stay at neutral. Limits: 10 m, pi rad,
 * and 3600 s for all passes together. Anything else is refused with file, line and remedy. Main
 * thread. */
#ifndef HEXID_TRAJECTORY_FILE_H
#define HEXID_TRAJECTORY_FILE_H

#include "status.h"
#include "trajectory.h"

/* Reads the file and fits a spline through the poses, to be run `passes` times; with more than one
 * pass it must end where it begins. Returns -2, or -3 if the file cannot be read. Call
 * trajectory_free() in any case. */
int trajectory_load(struct trajectory *t, const char *path, int passes, struct error *error);
void trajectory_free(struct trajectory *t);

#endif
