/* Measures and admits a recording in place, for tests that read no more of the raw one. */
#ifndef HEXID_TESTS_ADMIT_RIG_H
#define HEXID_TESTS_ADMIT_RIG_H

#include <stdlib.h>

#include "admit.h"

/* Settles and measures all runs of a recording, admits the last one, and puts in the recording's
 * place what was measured, even after an error. noise: whether
 * segments that are mostly noise are marked and a recording of noise is refused. */
static inline int admit_rig(struct recording *r, bool noise, struct error *error) {
    static struct measured_recording m;
    struct admission admission = {0};
    m = (struct measured_recording){0};
    recording_settle(r);
    int status = 0, tests = 0;
    for (int run = 1; run <= r->runs && !status; run++) {
        struct recording until = *r;
        while (tests < r->tests && r->test[tests].run < run) tests++;
        until.runs = run, until.tests = tests;
        status = measured_add(&m, &until, error);
    }
    if (!status) status = admit(r, &m, &admission, error);
    if (!status && noise) status = measured_noise(&m, error);
    if (!status && noise) status = admit_noise(&m, error);
    /* of all tests that share samples the first one owns them now, as in a raw recording */
    for (int i = 0; i < r->tests; i++) {
        int first = 0;
        while (first < m.recording.tests && m.recording.test[first].sample != r->test[i].sample) first++;
        if (first == m.recording.tests) free(r->test[i].sample);
        else m.recording.test[first].borrowed = false, m.recording.test[first].capacity = r->test[i].capacity;
        free(r->test[i].measured);
    }
    *r = m.recording;
    return status;
}

#endif
