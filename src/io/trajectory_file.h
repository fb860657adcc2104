/* A trajectory from a CSV file: a line with the names of the columns, then 3 to 500000 rows, each a
 * pose, at times that increase, evenly or not.
 *
 *     t_s,x_m,y_m,z_m,phi_rad,theta_rad,psi_rad      any of the axes, in any order; those that are
 *                                                    missing stay at neutral
 *
 * Within 10 m and pi rad, and 3600 s with all passes. Anything else is refused with file, line and
 * remedy. Main thread. */
#ifndef HEXID_TRAJECTORY_FILE_H
#define HEXID_TRAJECTORY_FILE_H

#include "status.h"
#include "trajectory.h"

/* Reads it and lays a spline through it, to be run in so many passes; with more than one it must
 * end where it begins. -2, or -3 for what cannot be read. To be freed in any case. */
int trajectory_load(struct trajectory *t, const char *path, int passes, struct error *error);
void trajectory_free(struct trajectory *t);

#endif
