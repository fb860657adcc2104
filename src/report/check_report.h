/* Results of `hexid check` as text, JSON and HTML. */
#ifndef HEXID_CHECK_REPORT_H
#define HEXID_CHECK_REPORT_H

#include <stdio.h>

#include "areas.h"
#include "config.h"
#include "survey.h"

enum { CHECK_LIST_SIZE = 600 };

struct check_report {
    int surveys;
    struct survey *survey;
    const char *const *source;   /* logs, directories and files, as on the command line */
    int sources;
    /* Columns of CSV files that are missing, ignored, or doubtful, in the form of struct csv_report
     * (csv.h); "" if there are none. */
    char missing[CHECK_LIST_SIZE], ignored[CHECK_LIST_SIZE], doubtful[CHECK_LIST_SIZE];
    /* Areas by which pressures become forces (areas.h), in words; "" without pressures. */
    char areas[AREAS_TEXT_SIZE];
    /* Keys of cylinder, valve and oil that have the built-in machine's values although the machine
     * is another one (config_defaults()); "" if there are none, or without pressures. */
    char defaults[CONFIG_DEFAULTS_SIZE];
    char zero[CHECK_LIST_SIZE];  /* value of t_s in each CSV file at which the ramp-in begins (t =
                                  * 0), as found from the motion, in the form of struct
                                  * csv_report */
    /* Tests that `hexid gap` excludes, because their evaluated part has no sample: "y, phi"; with
     * several logs "b.lcm: y; ...". */
    char left_out[CHECK_LIST_SIZE];
    /* Results of asking whether `hexid gap` and `hexid identify` would take the data. Status 0: the
     * command would take the data; the text is "" or, from identify, "verdict fail: reason".
     * Otherwise the text says why the command would refuse the data. */
    struct error gap, identify;
};

/* Display unit of a kind of channel: an SI value times `scale` is in `unit`. */
struct check_unit {
    double scale;
    const char *unit;
};
extern const struct check_unit check_units[SURVEY_KINDS];

/* Returns the name of a kind of channel for readers; a length has the name that the mechanism gives
 * it. */
const char *check_name_of(const struct survey *s, enum survey_kind kind);

/* Returns the unit of a kind of channel for display; the reference of a mechanism without a pose is
 * a length. */
const char *check_unit_of(const struct survey *s, enum survey_kind kind);

/* Returns the words that join "would take it" or "would refuse it" to the answer's text. */
const char *check_answer_joint(const struct error *answer);

/* Returns the unit of 1000 times a test's amplitude: "mm" or "mrad". */
const char *check_amplitude_unit(const struct survey *s);

/* Returns the jitter of the sampling in ms, rounded to the microsecond. */
double check_jitter_ms(const struct survey *s);

/* Writes a warning if the evaluated part begins before the motion is steady; otherwise "". */
enum { CHECK_RAMP_SIZE = 160 };
void check_ramp(const struct survey *s, char text[CHECK_RAMP_SIZE]);

/* Prints the report as tables in 80 columns. Text from outside is made printable. */
void check_text_print(FILE *out, const struct check_report *report);

/* Returns the report as JSON, schema hexid.check/1, in which unknown values are null. The caller
 * frees the text. Returns NULL without memory. */
char *check_json(const struct check_report *report);

/* Writes the report as one page without scripts or other files; the caller frees *page. Returns -3
 * without memory (*page is NULL), or if pictures could not be drawn (*page is complete except for
 * the pictures). */
int check_html(const struct check_report *report, char **page, struct error *error);

#endif
