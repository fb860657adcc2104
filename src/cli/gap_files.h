/* Writes the results of hexid gap: files in a directory, and a message. A file appears under its
 * name only when it is complete. */
#ifndef HEXID_GAP_FILES_H
#define HEXID_GAP_FILES_H

#include "cli.h"
#include "output.h"
#include "recording.h"
#include "waves.h"

/* Checks that the results can be written, before time is spent on them; creates nothing. json:
 * prepared for o->json unless that lies in the directory still to be created. Returns -2 or -3 on
 * an error. */
int gap_files_check(const struct options *o, struct output *json, struct error *error);

/* Writes model.yaml, gap.json and report.html to o->output, and gap.json also to o->json.
 * closed_loop: waveforms of a simulated result. Returns -3 if a file was not written; earlier ones
 * remain. Figures that could not be drawn are missing in the page, which is an error too. */
int gap_files_write(const struct options *o, struct output *json, const struct gap_result *result, const struct recording *measured,
                    const struct waves *closed_loop, struct error *error);

/* Sends HEXID_GAP if lcm.url names a bus; a failure is only a warning, because the stream is
 * only for watching. */
void gap_files_publish(const struct params *params, const struct gap_result *result);

#endif
