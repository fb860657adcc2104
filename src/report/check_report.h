/* What hexid check found, for people, programs and browsers. */
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
    const char *const *source;   /* what was read: logs and directories */
    int sources;
    /* columns of CSV, in the words of csv_report */
    char missing[CHECK_LIST_SIZE], ignored[CHECK_LIST_SIZE], doubtful[CHECK_LIST_SIZE];
    char areas[AREAS_TEXT_SIZE]; /* areas by which pressures become forces (areas.h); "" without
                                  * pressures */
    char defaults[CONFIG_DEFAULTS_SIZE]; /* keys at a default, not this machine's own
                                          * (config_defaults()); likewise "" */
    char zero[CHECK_LIST_SIZE];  /* of CSV, in the words of csv_report */
    char left_out[CHECK_LIST_SIZE]; /* "y, phi": tests without a sample in the evaluated
                                     * part; of several logs "b.lcm: y; ..." */
    struct error gap, identify;  /* status 0: `hexid gap`, `hexid identify` would take the data, and
                                  * a text is "verdict fail: reason"; else their refusal */
};

/* How a kind is shown: SI value times scale, in unit. */
struct check_unit {
    double scale;
    const char *unit, *label;    /* label: of a picture's axis */
};
extern const struct check_unit check_units[SURVEY_KINDS];

/* Name of a kind for a reader: for a single axis the length is its "position". */
const char *check_name_of(const struct survey *s, enum survey_kind kind);

/* Unit of a kind's values: for a single axis the reference is a length, too. */
const char *check_unit_of(const struct survey *s, enum survey_kind kind);

/* What stands between "would take it" or "would refuse it" and the text. */
const char *check_answer_joint(const struct error *answer);

/* "mm" or "mrad": unit of a test's amplitude times 1e3. */
const char *check_amplitude_unit(const struct survey *s);

/* Jitter of the sampling in ms, rounded to the microsecond. */
double check_jitter_ms(const struct survey *s);

/* What is said where the evaluated part begins before the motion is steady; else "". */
enum { CHECK_RAMP_SIZE = 160 };
void check_ramp(const struct survey *s, char text[CHECK_RAMP_SIZE]);

/* Tables in 80 columns. What comes from outside is made printable. */
void check_text_print(FILE *out, const struct check_report *report);

/* hexid.check/1, to be freed; NULL without memory. What is not known is null. */
char *check_json(const struct check_report *report);

/* One page without scripts or other files; *page is to be freed. -3 without memory (*page NULL), or
 * where pictures could not be drawn (*page is there, without them). */
int check_html(const struct check_report *report, char **page, struct error *error);

#endif
