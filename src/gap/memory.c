#include "memory.h"

#include <stdio.h>
#include <stdlib.h>

#include "status.h"

void memory_end(void) {
    fputs("hexid: out of memory\n", stderr);
    _Exit(-STATUS_IO);
}

void *memory_get(size_t count, size_t size) {
    void *memory = calloc(count ? count : 1, size);
    if (!memory) memory_end();
    return memory;
}
