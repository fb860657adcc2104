/* The result of `hexid gap` as one HTML page, without scripts or other files: pictures are
 * embedded. Ordinary threads; heap; gnuplot as a child process. */
#ifndef HEXID_GAP_HTML_H
#define HEXID_GAP_HTML_H

#include "waves.h"

struct gap_report {
    const struct gap_result *result;
    const struct recording *measured;
    /* waves for the report's figures: simulated in closed loop if result->simulated, otherwise
     * computed for the measured motion */
    const struct waves *waves;
    const struct waves *motion;       /* waves by waves_motion(), for the plots of force */
    const char *const *measured_file; /* [runs]: file names for the heading */
    /* validate_file: NULL without a validation log. model_file: the configuration with the effects
     * found */
    const char *validate_file, *config_file, *model_file;
};

/* Writes the page; the caller frees *page. Returns 0, or -3 with the reason: no memory (*page is
 * NULL), or the page lacks pictures and says so. */
int gap_html(const struct gap_report *report, char **page, struct error *error);

#endif
