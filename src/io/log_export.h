/* Exports a whole log for other programs: every cycle and, if the format has a place for them, the
 * messages. One pass over the log, whose content is not trusted (log.h, messages.h,
 * message_fields.h). Main thread. */
#ifndef HEXID_LOG_EXPORT_H
#define HEXID_LOG_EXPORT_H

#include "message_fields.h"
#include "status.h"
#include "types.h"

/* Functions of a format; `to` is the state of an export. open() and close() return -3 with path and
 * reason; open() returns -2 if the output is no file in a directory ("-"), or is a recording.
 * cycle() and message() ignore failures; failed() returns the first failure as an errno, or 0. */
struct export_format {
    const char *name;
    int (*open)(void **to, const char *path, struct error *error);
    /* time_s: time since the log's first cycle */
    void (*cycle)(void *to, int64_t utime_us, double time_s, const struct cycle *c);
    void (*message)(void *to, int64_t utime_us, const struct message *m);
    int (*failed)(const void *to);
    int (*close)(void *to, struct error *error); /* frees the state; after a failure it removes the
                                                  * incomplete file */
};

/* Exports CSV, with a row for each cycle: time_s, then the columns of cycle_columns.h; no messages.
 * Numbers read back bit for bit. */
extern const struct export_format export_table;

/* MCAP: topics /hexid/state and /hexid/NAME for the types of message_fields.h, as JSON with schemas
 * (mcap.h); times are the log's utime. JSON has neither NaN nor infinity: such a field is omitted,
 * and such an element of an array is null. */
extern const struct export_format export_mcap;

/* MATLAB's format 5, compressed: one struct `hexid` with time_s and each column of
 * cycle_columns.h as a column vector (integers as int64), `units` with their units, `config`
 * with the configuration as text, and a struct array NAME for each type of message_fields.h in
 * the log, with 6 x 6 matrices. Text is ASCII, with '?' for other characters. Memory: 464 bytes
 * a cycle, the messages, and the file. */
extern const struct export_format export_mat;

struct log_export_report {
    int64_t cycles, lost;  /* numbers of cycles in the log, and of cycles missing in seq */
    int64_t messages;
    int64_t unreadable;    /* number of malformed messages on hexid's channels */
    bool cut;              /* the log is cut off or damaged; it was read up to cut_offset */
    int64_t cut_offset;
};

/* Exports a log. run: number of the run in a log that contains several (log_runs.h), else 0.
 * Returns -2 if there is no such run, or if open() does; -3 with the path of the file that cannot
 * be read or written, or if the log has no cycle. No new file is left then. */
int log_export(const char *log_path, int run, const char *path, const struct export_format *format, struct log_export_report *report,
               struct error *error);

#endif
