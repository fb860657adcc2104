/* Writes the results of hexid gap: files in a directory, and a message. A file appears under its
 * name only when it is complete. */
#ifndef HEXID_GAP_FILES_H
#define HEXID_GAP_FILES_H

#include "cli.h"
#include "output.h"
#include "recording.h"
#include "waves.h"

/* Checks that the results can be written, before time is spent on computing them; creates nothing.
 * json: is prepared for o->json, unless o->json lies in a directory that is still to be created.
 * Returns -2 or -3 on an error. */
int gap_files_check(const struct options *o, struct output *json, struct error *error);

/* Writes model.yaml, gap.json and report.html to o->output, and gap.json also to o->json.
 * closed_loop: waveforms, used if the result was simulated in closed loop. Returns -3 if a file was
 * not written; earlier ones remain. If figures could not be drawn, the page is written without
 * them, and that is an error, too. */
int gap_files_write(const struct options *o, struct output *json, const struct gap_result *result, const struct recording *measured,
                    const struct waves *closed_loop, struct error *error);

/* Sends HEXID_GAP if lcm.url names a bus; a failure causes a warning only, because LCM is needed
 * for watching only. */
void gap_files_publish(const struct params *params, const struct gap_result *result);

#endif
