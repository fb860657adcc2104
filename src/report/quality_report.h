/* The result of `hexid qualify`: for people, as JSON (schema hexid.qualify/1) and as a page.
 * Ordinary threads; heap. */
#ifndef HEXID_QUALITY_REPORT_H
#define HEXID_QUALITY_REPORT_H

#include <stdio.h>

#include "quality_check.h"

struct quality_report {
    const char *version, *log, *law;    /* hexid's version, name of the log, control.law */
    const char *baseline;               /* name of the baseline; NULL: none */
    struct quality quality, before;     /* before: quality in the baseline; values that its JSON
                                         * lacks are NaN */
    struct quality_check check[QUALITY_CHECKS];
    struct qualify_params limits;
};

void quality_text(const struct quality_report *r, FILE *out);

/* Returns the result as JSON text, which the caller frees, or NULL without memory. */
char *quality_json(const struct quality_report *r);

/* Reads a file of quality_json(). Returns -2 if the file has other contents, -3 if it cannot be
 * read. */
int quality_json_read(const char *path, struct quality *q, struct error *error);

/* Makes the page; its return values are those of page_make(). */
int quality_html(const struct quality_report *r, char **page, struct error *error);

#endif
