#include "mat_library.h"

#include <dlfcn.h>
#include <stdbool.h>
#include <string.h>

/* Looks up a function. dlsym() returns functions as object pointers; POSIX gives both the same
 * size. */
static void *look_up(void *handle, const char *name, void *function) {
    void *symbol = dlsym(handle, name);
    memcpy(function, &symbol, sizeof symbol);
    return symbol;
}

int mat_library_load(struct mat_library *l, struct error *error) {
    static const char name[] = "libmatio.so.11";
    void *handle = dlopen(name, RTLD_NOW | RTLD_LOCAL);
    bool there = handle && look_up(handle, "Mat_CreateVer", &l->create) && look_up(handle, "Mat_Close", &l->close) &&
                 look_up(handle, "Mat_VarCreate", &l->variable) && look_up(handle, "Mat_VarCreateStruct", &l->structure) &&
                 look_up(handle, "Mat_VarSetStructFieldByName", &l->set) && look_up(handle, "Mat_VarWrite", &l->write) &&
                 look_up(handle, "Mat_VarFree", &l->free) && look_up(handle, "Mat_Open", &l->open) &&
                 look_up(handle, "Mat_VarReadNext", &l->next) && look_up(handle, "Mat_VarGetNumberOfFields", &l->fields) &&
                 look_up(handle, "Mat_VarGetStructFieldnames", &l->names) && look_up(handle, "Mat_VarGetStructFieldByIndex", &l->field);
    return there ? STATUS_OK
                 : error_set(error, STATUS_IO,
                             "%s: cannot be loaded, so no .mat is written or read: install libmatio11, or take csv or mcap", name);
}
