/* Functions of a library that is loaded when it is needed. Ordinary threads. */
#ifndef HEXID_LIBRARY_H
#define HEXID_LIBRARY_H

#include <dlfcn.h>
#include <string.h>

/* Stores the function of this name in *function, a pointer to a function. Returns NULL if the
 * library lacks it. memcpy() converts the pointer, because ISO C has no cast from pointers to
 * objects to pointers to functions; POSIX gives both the same size. */
static inline void *library_function(void *library, const char *name, void *function) {
    void *symbol = dlsym(library, name);
    memcpy(function, &symbol, sizeof symbol);
    return symbol;
}

#endif
