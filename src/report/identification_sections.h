/* Sections of an identification report below its first screen, for one log: all entries of the
 * matrix, motion and leg forces, friction over the rates of the legs, checks, configuration. */
#ifndef HEXID_IDENTIFICATION_SECTIONS_H
#define HEXID_IDENTIFICATION_SECTIONS_H

#include "identification_report.h"
#include "page.h"

/* Writes the sections of a log, given by its index in the report. */
void sections_of_log(struct page *p, const struct identification_report *report, int log);

#endif
