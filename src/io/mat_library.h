/* libmatio, loaded only when a .mat file is asked for: it brings HDF5, curl and some twenty more
 * libraries, which have no business in the process that moves a machine. Ordinary threads. */
#ifndef HEXID_MAT_LIBRARY_H
#define HEXID_MAT_LIBRARY_H

#include <matio.h>

#include "status.h"

struct mat_library {
    __typeof__(&Mat_CreateVer) create;
    __typeof__(&Mat_Close) close;
    __typeof__(&Mat_VarCreate) variable;
    __typeof__(&Mat_VarCreateStruct) structure;
    __typeof__(&Mat_VarSetStructFieldByName) set;
    __typeof__(&Mat_VarWrite) write;
    __typeof__(&Mat_VarFree) free;
};

/* -3 when it cannot be loaded. It stays loaded. */
int mat_library_load(struct mat_library *library, struct error *error);

#endif
