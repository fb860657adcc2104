/* Sections of an identification report below its first screen, each for one log. */
#ifndef HEXID_IDENTIFICATION_SECTIONS_H
#define HEXID_IDENTIFICATION_SECTIONS_H

#include "identification_report.h"

/* A page while it is written. */
struct report_page {
    FILE *out;
    const struct identification_report *report;
    struct error picture;  /* why the first picture was not drawn; status 0: all were drawn */
};

void section_matrices(struct report_page *p, int log);
void section_tests(struct report_page *p, int log);         /* positions and leg forces over time */
void section_friction(struct report_page *p, int log);      /* friction over the rates of the
                                                             * legs */
void section_checks(struct report_page *p, int log); /* excluded samples, verdict and times of the
                                                      * loop */
void section_configuration(struct report_page *p, int log);

#endif
