/* What hexid gap leaves behind: files in a directory, and a message. A file appears under its name
 * only when it is whole. */
#ifndef HEXID_GAP_FILES_H
#define HEXID_GAP_FILES_H

#include "cli.h"
#include "output.h"
#include "recording.h"
#include "waves.h"

/* Can they be written there? Asked before time is spent on results that cannot be kept; nothing is
 * made yet. json: for o->json, prepared; not where it will be in the directory that is to be made.
 * -2, -3. */
int gap_files_check(const struct options *o, struct output *json, struct error *error);

/* model.yaml, gap.json, then report.html, in o->output; gap.json in o->json too. closed_loop: of a
 * result that is simulated. -3 when one was not written; those before it are there. Pictures that
 * could not be drawn are missing in the page and are an error, too. */
int gap_files_write(const struct options *o, struct output *json, const struct gap_result *result, const struct recording *measured,
                    const struct waves *closed_loop, struct error *error);

/* HEXID_GAP where lcm.url names a bus; without a bus a warning, for the stream is for watching. */
void gap_files_publish(const struct params *params, const struct gap_result *result);

#endif
