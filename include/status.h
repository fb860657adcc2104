/* Errors of bring-up and of files: a negative status and one line that names the thing and the
 * remedy.
 *
 * A function that can fail takes a `struct error *` last and returns 0 or a negative status. The
 * status is the process's exit status, negated (2 usage or configuration, 3 I/O or device, 4
 * refused for safety). The loop thread does not use it: run-time trouble is a fault bit
 * (types.h). */
#ifndef HEXID_STATUS_H
#define HEXID_STATUS_H

#include <stdarg.h>
#include <stdio.h>

enum status {
    STATUS_OK = 0,
    STATUS_USAGE = -2,  /* an option or the configuration is wrong */
    STATUS_IO = -3,     /* a file, bus or device fails */
    STATUS_UNSAFE = -4, /* an action was refused, because going on could hurt people */
};

struct error {
    enum status status;
    char text[1000];
};

/* Writes the message and returns the status, so that
 * `return error_set(e, STATUS_IO, "...")` is one line. */
__attribute__((format(printf, 3, 4))) static inline int error_set(struct error *e, enum status status, const char *format, ...) {
    va_list args;
    e->status = status;
    va_start(args, format);
    vsnprintf(e->text, sizeof e->text, format, args);
    va_end(args);
    return status;
}

#endif
