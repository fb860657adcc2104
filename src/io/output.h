/* The one way to open what is written, so that nothing is lost by writing.
 *
 * A result (JSON, a page, a model) is written beside its place and renamed when it is whole: an
 * interrupted or failed run leaves the earlier one as it was. It never takes the place of a
 * recording (recognise.h). Devices, FIFOs and descriptors (/dev/stdout, /proc/self/fd/N, "-") are
 * written in place; they are opened at the beginning, and a FIFO that nobody reads is refused.
 *
 * A log belongs to one writer, who holds a lock on the file (flock, which ends with the process). A
 * file that is there already is set aside, never overwritten.
 *
 * Which files a command line reads, and that none of them is written: outputs.h. Ordinary
 * threads. */
#ifndef HEXID_OUTPUT_H
#define HEXID_OUTPUT_H

#include <fcntl.h>
#include <limits.h>
#include <stdbool.h>
#include <stdio.h>
#include <sys/stat.h>

#include "status.h"

/* How the file beside is created; confine.h lets the confined daemon do just this. */
enum { OUTPUT_FLAGS = O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC };

enum output_kind {
    OUTPUT_RESULT, /* takes the place of an earlier result */
    OUTPUT_NEW,    /* takes no file's place: -3 for any that is there, as for an export */
};

struct output {
    const char *name;                 /* as given; NULL: nothing is to be written */
    const char *path, *beside;        /* its place, links followed, and the file beside; beside is
                                       * NULL where it is written in place. confine() moves both */
    unsigned rename_flags;            /* of renameat2(): what has come meanwhile is not replaced */
    int file;                         /* open, where it is written in place; -1 */
    struct stat before;               /* what is replaced; st_ino 0: nothing is there */
    char path_text[PATH_MAX], beside_text[PATH_MAX];
};

/* Checks that the output can be written; opens it only if it is written in place. With name NULL
 * there is nothing to write, and every call below does nothing. Waits up to 5 s for the reader of
 * a FIFO. Returns -2 if a recording is there, -3 with the reason and the remedy otherwise. */
int output_prepare(struct output *o, const char *name, enum output_kind kind, struct error *error);

/* Writes the text and puts the file in its place; may be called once. On -3 the earlier file is
 * untouched. */
int output_write(struct output *o, const char *text, struct error *error);

/* The same in two steps, for what is written piece by piece and never in place. NULL: -3.
 * failure: errno of an earlier write, 0: none. The stream is closed, and the file beside is gone
 * where that failed. */
FILE *output_open(struct output *o, struct error *error);
int output_close(struct output *o, FILE *stream, int failure, struct error *error);

/* Gives up a prepared output that is not to be written. */
void output_discard(struct output *o);

/* Prepares an output and writes the text to it. */
int output_text(const char *name, const char *text, struct error *error);

/* Follows symbolic links of the last component to the place where a file is or would be; in_place:
 * it is a descriptor (a link of /proc), or no regular file. -1: errno. */
int output_place(const char *name, char path[PATH_MAX], bool *in_place);

/* Opens a log to write: locked, empty. A file that has something in it is renamed to NAME.1, or the
 * next number that is free, and aside says so; "" otherwise. What is no regular file is written in
 * place. A FIFO as above. -2: a recording of another kind is there. -3: another process writes it,
 * or it cannot be opened. */
int output_log(const char *name, char aside[PATH_MAX], struct error *error);

#endif
