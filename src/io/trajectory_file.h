/* A trajectory from a CSV file: a line with the names of the columns, then a row a pose, at times
 * that increase, evenly or not.
 *
 *     t_s,x_m,y_m,z_m,phi_rad,theta_rad,psi_rad      any of the axes, in any order; what is not
 *                                                    there stays at neutral
 *
 * Whatever is in the file is refused with file, line and remedy unless it is that. Main thread. */
#ifndef HEXID_TRAJECTORY_FILE_H
#define HEXID_TRAJECTORY_FILE_H

#include "status.h"
#include "trajectory.h"

/* Reads and bends it, for so many passes. -2, or -3 for what cannot be read. To be
 * freed in any case. */
int trajectory_load(struct trajectory *t, const char *path, int passes, struct error *error);
void trajectory_free(struct trajectory *t);

#endif
