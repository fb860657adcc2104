#include <math.h>

#include "quality_report.h"
#include "units.h"
#include "words.h"

static void print_tones(const struct quality *q, FILE *out) {
    fprintf(out, "axis      Hz  amplitude    gain   phase  coherence  cross  harmonics  noise\n"
                 "                 mm, mrad            deg                  %%          %%      %%\n");
    for (int dof = 0; dof < DOFS; dof++)
        for (int i = 0; i < q->plan.tones; i++) {
            const struct quality_tone *t = &q->tone[dof][i];
            words_row(out, "%-5s %6.3g %10.3g %7.4f %7.2f %10.6f %6.2f %10.2f %6.2f\n", i ? "" : dof_names[dof], t->hz, 1e3 * t->amplitude,
                      cabs(t->gain[dof]), quality_phase_deg(q, dof, i), t->coherence, 100.0 * quality_cross_most(q, dof, i), 100.0 * t->low,
                      100.0 * t->noise);
        }
}

static void print_axes(const struct quality *q, FILE *out) {
    fprintf(out, "\naxis   noise at rest  threshold  hysteresis  dead time  turn-around    reached:\n"
                 "       mm, mrad/s^2    um, urad    um, urad         ms     m, rad/s^2  mm, mrad  m, rad/s  /s^2\n");
    for (int dof = 0; dof < DOFS; dof++) {
        const struct quality_axis *a = &q->axis[dof];
        words_row(out, "%-5s %14.2f %10.1f %11.1f %10.1f %14.4f %9.1f %9.3f %5.2f\n", dof_names[dof], 1e3 * quality_rest(q, dof),
                  1e6 * a->threshold, 1e6 * a->hysteresis, 1e3 * a->dead_s, a->turn_around, 1e3 * a->excursion, a->rate, a->accel);
    }
}

static void print_check(const struct quality_check *c, FILE *out) {
    char where[40] = "";
    if (c->dof != DOF_NONE) snprintf(where, sizeof where, isnan(c->hz) ? "  (%s)" : "  (%s, %.3g Hz)", dof_names[c->dof], c->hz);
    words_row(out, "%-13s %-26s %10.3g %s", verdict_names[c->status], c->what, c->value, c->unit);
    if (c->limit > 0.0) fprintf(out, ", limit %s%g", c->least ? "at least " : "", c->limit);
    fprintf(out, "%s%s\n", where, c->lacks && !isnan(c->value) ? "; some are not measured" : "");
}

void quality_text(const struct quality_report *r, FILE *out) {
    const struct quality *q = &r->quality;
    fprintf(out, "measured as, by %d samples, %d of them missing; control.law %s; angles as lengths at %.3f m\n", q->plan.cycles,
            q->missing, r->law, q->plan.arm_m);
    print_tones(q, out);
    print_axes(q, out);
    fprintf(out, "\nthe operator's limits (section qualify)\n");
    for (int i = 0; i < QUALITY_CHECKS; i++) print_check(&r->check[i], out);
    if (r->baseline)
        words_row(out, "against %.200s: tones differ by %.3g times their noise (rms)\n", r->baseline,
                  quality_change_of_noise(q, &r->before));
    fprintf(out, "verdict   %s\n", verdict_names[quality_verdict(r->check)]);
}
