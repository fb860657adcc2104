/* The result of hexid gap as one page of HTML: no script, no network, pictures inside. Ordinary
 * threads; heap; gnuplot as a child. */
#ifndef HEXID_GAP_HTML_H
#define HEXID_GAP_HTML_H

#include "waves.h"

struct gap_report {
    const struct gap_result *result;
    const struct recording *measured;
    const struct waves *waves;   /* from the closed loop where the result is simulated, else from
                                  * the motion */
    const struct waves *motion;
    const char *const *measured_file; /* for the heading, one a run */
    const char *validate_file, *config_file, *model_file; /* validate_file may be NULL */
};

/* *page is to be freed by the caller. 0; -3 with the reason: without memory (*page is NULL), or the
 * page is whole but for its pictures and says so. */
int gap_html(const struct gap_report *report, char **page, struct error *error);

#endif
