/* The result of hexid gap as one HTML page: no scripts, no network, pictures embedded. Ordinary
 * threads; heap; gnuplot as a child process. */
#ifndef HEXID_GAP_HTML_H
#define HEXID_GAP_HTML_H

#include "waves.h"

struct gap_report {
    const struct gap_result *result;
    const struct recording *measured;
    /* from the closed loop if the result is simulated, else from the measured motion */
    const struct waves *waves;
    const struct waves *motion;
    const char *const *measured_file; /* one a run, for the heading */
    const char *validate_file, *config_file, *model_file; /* validate_file may be NULL */
};

/* Writes the page; the caller frees *page. Returns 0, or -3 with the reason: without memory (*page
 * is NULL), or the page lacks its pictures and says so. */
int gap_html(const struct gap_report *report, char **page, struct error *error);

#endif
