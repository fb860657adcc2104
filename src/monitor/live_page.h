/* The files of src/monitor/page/, which the Makefile compiles into the program. */
#ifndef HEXID_LIVE_PAGE_H
#define HEXID_LIVE_PAGE_H

#include <stddef.h>

struct live_file {
    const char *name; /* name of the file: "live.css" */
    const unsigned char *data;
    size_t size;
};

extern const struct live_file live_files[]; /* ended by an entry without a name */

#endif
