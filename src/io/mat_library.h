/* Loads libmatio only when a .mat file is asked for: it brings HDF5, curl and some twenty more
 * libraries that do not belong into a process that moves a machine. Ordinary threads. */
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
    __typeof__(&Mat_Open) open;
    __typeof__(&Mat_VarReadNext) next;
    __typeof__(&Mat_VarGetNumberOfFields) fields;
    __typeof__(&Mat_VarGetStructFieldnames) names;
    __typeof__(&Mat_VarGetStructFieldByIndex) field;
};

/* Loads the library, which then stays loaded. Returns -3 on failure. */
int mat_library_load(struct mat_library *library, struct error *error);

#endif
