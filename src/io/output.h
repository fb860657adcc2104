/* Opens all files for writing, in a way that loses nothing.
 *
 * A result (JSON, a page, a model) is written to a temporary file beside its path and renamed when
 * complete: an interrupted or failed run leaves the earlier one as it was. It never replaces a
 * recording (recognise.h). Devices, FIFOs and descriptors (/dev/stdout, /proc/self/fd/N, "-") are
 * written in place; they are opened at the beginning, and a FIFO without a reader is refused.
 *
 * A log belongs to one writer, who holds a lock on the file (flock, which ends with the process).
 * An existing file is set aside, never overwritten.
 *
 * outputs.h checks that no file of a command line is both read and written. Ordinary threads. */
#ifndef HEXID_OUTPUT_H
#define HEXID_OUTPUT_H

#include <fcntl.h>
#include <limits.h>
#include <stdbool.h>
#include <stdio.h>
#include <sys/stat.h>

#include "status.h"

/* Flags for the temporary file; confine.h lets the confined daemon use exactly these. */
enum { OUTPUT_FLAGS = O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC };

enum output_kind {
    OUTPUT_RESULT, /* a result, which replaces an earlier one */
    OUTPUT_NEW,    /* for exports: output_prepare() refuses any existing file, -3 */
};

struct output {
    const char *name;                 /* name as given by the user; NULL: no output */
    const char *path, *beside;        /* path of the output, with links followed, and of the
                                       * temporary file beside it; beside is NULL if the output is
                                       * written in place. confine() points both at its own
                                       * copies */
    unsigned rename_flags;    /* flags for renameat2(), which keep it from replacing a file that
                               * appeared meanwhile */
    int file;                        /* descriptor of an output that is written in place; else -1 */
    struct stat before;              /* state of the file to be replaced; st_ino 0: there is none */
    char path_text[PATH_MAX], beside_text[PATH_MAX];
};

/* Checks that the output can be written; opens it only if it is written in place. With name NULL
 * there is nothing to write: output_write(), output_made(), output_page() and output_discard() then
 * write nothing. Waits up to 5 s for the reader of a FIFO. Returns -2 if a recording or a disk is
 * there, -3 with the reason and the remedy otherwise. */
int output_prepare(struct output *o, const char *name, enum output_kind kind, struct error *error);

/* Writes the text and puts the file in its place; may be called once. If it returns -3 the earlier
 * file is untouched. */
int output_write(struct output *o, const char *text, struct error *error);

/* Do what output_write() does, and free the text. With text NULL output_made() returns -3, because
 * there was no memory for it. output_page() takes in `made` and *error the result of making the
 * page, such as missing pictures; it writes nothing if page is NULL, and returns `made` unless
 * writing fails. */
int output_made(struct output *o, char *text, struct error *error);
int output_page(struct output *o, int made, char *page, struct error *error);

/* Do what output_write() does in two steps, for output written in pieces, never in place.
 * output_open() returns NULL with an error of status -3, or -2 if the output is no file in a
 * directory. failure: errno of an earlier write; 0: none. output_close() closes the stream and on
 * failure removes the temporary file. */
FILE *output_open(struct output *o, struct error *error);
int output_close(struct output *o, FILE *stream, int failure, struct error *error);

/* Discards a prepared output that will not be written. */
void output_discard(struct output *o);

/* Prepares an output and writes the text to it. */
int output_text(const char *name, const char *text, struct error *error);

/* Follows symbolic links of the last component to the path where a file is or would be. *in_place
 * returns true if that path is a descriptor (a link of /proc) or not a regular file. Returns -1
 * with errno on failure. */
int output_place(const char *name, char path[PATH_MAX], bool *in_place);

/* Opens a log for writing: locked and empty. A file that is not empty is renamed to NAME.1, or the
 * next free number; `aside` returns the new name, "" if nothing was renamed. Files that are not
 * regular are written in place, a FIFO only with a reader. Returns -2 if a recording of another
 * kind or a disk is there; -3 if another process writes the log, or it cannot be opened. */
int output_log(const char *name, char aside[PATH_MAX], struct error *error);

#endif
