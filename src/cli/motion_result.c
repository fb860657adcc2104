#include "motion_result.h"

#include <math.h>

#include "params.h"

void motion_take(struct motion_result *m, const struct params *params, const struct cycle *c) {
    if (c->test < 0 || c->dof != DOF_NONE) return;
    if (c->test_time_s < m->test_time_s) *m = (struct motion_result){0}; /* a new motion begins */
    m->test_time_s = c->test_time_s;
    m->cycles++;
    if (c->phase != PHASE_EVALUATE) return;
    double end_s = params->tests.ramp_s + params->tests.duration_s;
    /* complete with the last cycle of the evaluated part; 2.5 periods allow for rounding */
    m->complete = c->test_time_s > end_s - 2.5 * params->loop.period_s;
    if (c->in.flags) m->excluded++;
    else m->samples++;
    for (int i = 0; i < DOFS && !c->in.flags; i++) {
        double *off = i < DOF_PHI ? &m->off_m : &m->off_rad;
        *off = fmax(*off, fabs(c->pose[i] - c->ref[i]));
    }
}

void motion_judge(const struct motion_result *m, const struct params *params, struct verdict *v) {
    const char *name = tests_name(&params->tests, DOF_NONE);
    double all = (double)(m->samples + m->excluded), excluded_pct = all > 0.0 ? 100.0 * (double)m->excluded / all : 0.0;
    if (!m->complete)
        verdict_add(v, VERDICT_NOT_EVALUATED, "test %s excluded: %s (%lld samples)", name, refusals[REFUSED_INCOMPLETE].why,
                    (long long)m->samples);
    else if (!(excluded_pct <= params->checks.excluded_pct))
        verdict_add(v, VERDICT_FAIL, "test %s: %.2f %% of the samples excluded, limit %g %%", name, excluded_pct,
                    params->checks.excluded_pct);
}
