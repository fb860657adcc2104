/* Results of hexid check as text, JSON and HTML. */
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
    const char *const *source;   /* logs and directories that were read */
    int sources;
    /* Columns of a CSV file, in the words of csv_report. */
    char missing[CHECK_LIST_SIZE], ignored[CHECK_LIST_SIZE], doubtful[CHECK_LIST_SIZE];
    /* Areas by which pressures become forces (areas.h); "" without pressures. */
    char areas[AREAS_TEXT_SIZE];
    /* Keys at a default, not this machine's own (config_defaults()); "" without pressures. */
    char defaults[CONFIG_DEFAULTS_SIZE];
    char zero[CHECK_LIST_SIZE];  /* found in CSV, in the words of csv_report */
    /* Tests without a sample in the evaluated part: "y, phi"; for several logs "b.lcm: y; ...". */
    char left_out[CHECK_LIST_SIZE];
    /* Answers of `hexid gap` and `hexid identify`. Status 0: it would take the data, and a text is
     * "verdict fail: reason"; else the refusal. */
    struct error gap, identify;
};

/* Display unit of a kind: SI value times scale, in unit. */
struct check_unit {
    double scale;
    const char *unit, *label;    /* label: of a plot's axis */
};
extern const struct check_unit check_units[SURVEY_KINDS];

/* Name of a kind for readers; a single axis calls its length "position". */
const char *check_name_of(const struct survey *s, enum survey_kind kind);

/* Unit of a kind's values; the reference of a single axis is a length. */
const char *check_unit_of(const struct survey *s, enum survey_kind kind);

/* Words between "would take it" or "would refuse it" and the answer's text. */
const char *check_answer_joint(const struct error *answer);

/* Unit of a test's amplitude times 1e3: "mm" or "mrad". */
const char *check_amplitude_unit(const struct survey *s);

/* Jitter of the sampling in ms, rounded to the microsecond. */
double check_jitter_ms(const struct survey *s);

/* Warns if the evaluated part begins before the motion is steady; else "". */
enum { CHECK_RAMP_SIZE = 160 };
void check_ramp(const struct survey *s, char text[CHECK_RAMP_SIZE]);

/* Prints tables in 80 columns. Text from outside is made printable. */
void check_text_print(FILE *out, const struct check_report *report);

/* The report as hexid.check/1, to be freed; unknown values are null. NULL without memory. */
char *check_json(const struct check_report *report);

/* Writes one page without scripts or other files; free *page. Returns -3 without memory (*page is
 * NULL), or if pictures could not be drawn (*page is complete but for them). */
int check_html(const struct check_report *report, char **page, struct error *error);

#endif
