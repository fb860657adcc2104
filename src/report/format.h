/* Splits a printf format into literal text and formatted arguments, so that a page can escape the
 * arguments and a table can show a dash for a number that is not finite. Conversions: d i u x c s e
 * f g, with flags, width, precision (both also *), l and ll; and %%. */
#ifndef HEXID_FORMAT_H
#define HEXID_FORMAT_H

#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>

enum { FORMAT_OWN = 512 };

struct format {
    const char *rest, *end;  /* the part that is not taken yet; `end` is the address after its last
                              * byte */
    va_list args;
    /* The segment taken last: literal text, or an argument as its conversion formats it. */
    const char *text;
    size_t length;
    bool argument, unknown;  /* unknown: a number that is not finite; its text is a "-" in the
                              * width of the conversion */
    char own[FORMAT_OWN];    /* text of a formatted argument, cut to this size; the text of a plain
                              * %s is not copied to here */
};

/* Takes the next segment. Returns false at the end. Before the first call, set `rest`, `end` and
 * `args` (va_start). */
bool format_next(struct format *f);

#endif
