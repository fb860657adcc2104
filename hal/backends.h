/* The back-ends of hal_table; one file each. */
#ifndef HEXID_BACKENDS_H
#define HEXID_BACKENDS_H

#include "hal.h"

extern const struct hal_ops hal_sim, hal_fault;

#endif
