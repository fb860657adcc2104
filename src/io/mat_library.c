#include "mat_library.h"

#include <dlfcn.h>
#include <stdbool.h>

#include "library.h"

int mat_library_load(struct mat_library *l, struct error *error) {
    static const char name[] = "libmatio.so.11";
    void *handle = dlopen(name, RTLD_NOW | RTLD_LOCAL);
    bool there = handle && library_function(handle, "Mat_CreateVer", &l->create) && library_function(handle, "Mat_Close", &l->close) &&
                 library_function(handle, "Mat_VarCreate", &l->variable) &&
                 library_function(handle, "Mat_VarCreateStruct", &l->structure) &&
                 library_function(handle, "Mat_VarSetStructFieldByName", &l->set) && library_function(handle, "Mat_VarWrite", &l->write) &&
                 library_function(handle, "Mat_VarFree", &l->free) && library_function(handle, "Mat_Open", &l->open) &&
                 library_function(handle, "Mat_VarReadNext", &l->next) &&
                 library_function(handle, "Mat_VarGetNumberOfFields", &l->fields) &&
                 library_function(handle, "Mat_VarGetStructFieldnames", &l->names) &&
                 library_function(handle, "Mat_VarGetStructFieldByIndex", &l->field);
    return there ? STATUS_OK
                 : error_set(error, STATUS_IO,
                             "%s: cannot be loaded, so no .mat is written or read: install libmatio11, or take csv or mcap", name);
}
