#include "method_c.h"

#include <math.h>

#include "params.h"

static const double AT_LIMIT = 0.999; /* a command is at the limit from this share of
                                       * control.output_limit on */
static const double SATURATED = 0.02; /* a valve is saturated if more than this share of its samples
                                       * is at the limit; noise makes few peaks */

static double share_at_limit(const struct recording_test *t, int leg, double limit) {
    int at = 0, n = 0;
    for (int i = t->first; i < t->end; i++)
        if (!t->sample[i].refused) at += fabs(t->sample[i].valve[leg]) >= limit, n++;
    return n ? (double)at / n : 0.0;
}

int method_c_check(const struct recording *r, struct error *error) {
    double limit = r->params->control.output_limit;
    for (int i = 0; i < r->tests && r->measured.valve; i++)
        for (int k = 0; k < LEGS; k++) {
            double share = share_at_limit(&r->test[i], k, AT_LIMIT * limit);
            if (share <= SATURATED) continue;
            return error_set(error, STATUS_USAGE,
                             "test %s: the valve of leg %d is saturated: its command is at control.output_limit, %g, in %.0f %% of "
                             "the samples; test with less amplitude or frequency",
                             tests_name(&r->params->tests, r->test[i].dof), k + 1, limit, 100.0 * share);
        }
    return STATUS_OK;
}
