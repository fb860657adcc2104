#include "survey_report.h"

#include <jansson.h>
#include <math.h>
#include <stdlib.h>

#include "force.h"
#include "kinematics.h"
#include "lin.h"
#include "loop_check.h"
#include "numeric.h"
#include "report_json.h"
#include "tune_report.h"
#include "units.h"
#include "words.h"

static const char *const kind_names[PROPOSALS] = {"six sines", "multisine"}, *const kind_keys[PROPOSALS] = {"sines", "multisine"};
enum { OPTIONS_SIZE = 600, DRAWS = 3 };

static double largest(const double *x) {
    double most = 0.0;
    for (int k = 0; k < LEGS; k++) most = fmax(most, x[k]);
    return most;
}

/* Returns the largest leg force, N, for an acceleration of one axis of 1 m/s^2 or 1 rad/s^2, from
 * J'^-1 Mt; NaN if the survey did not determine Mt. */
static double leg_force_per_acceleration(const struct loop_survey *s, double j[LEGS][DOFS], enum dof dof) {
    double wrench[DOFS], force[LEGS], most = 0.0;
    for (int i = 0; i < DOFS; i++) wrench[i] = s->inertia.matrix.mt[i][dof];
    lin_solve_right(LEGS, 1, j[0], wrench, force);
    for (int k = 0; k < LEGS; k++) most = fmax(most, fabs(force[k]));
    return s->determined ? most : (double)NAN;
}

static struct test_judgement judge(const struct survey_report *r, double j[LEGS][DOFS], enum dof dof) {
    static const double neutral[DOFS] = {0};
    const struct loop_survey *s = &r->survey;
    struct cylinder_areas area = cylinder_areas(&r->asked.actuator);
    struct kinematics k;
    struct error ignored;
    double noise_n[LEGS], leg = 0.0, hz = r->asked.tests.hz[dof], amplitude = r->asked.tests.amplitude[dof];
    double rounding_m = r->asked.sensors.enabled ? r->asked.sensors.position_resolution_m / sqrt(12.0) : 0.0;
    if (!kinematics_init(&k, &r->asked, &ignored)) ik_jacobian(&k, neutral, j);
    for (int i = 0; i < LEGS; i++) {
        leg = fmax(leg, fabs(j[i][dof]));
        noise_n[i] = hypot(area.a1_m2[i] * s->noise_pa[0][i], area.a2_m2[i] * s->noise_pa[1][i]);
    }
    struct test_judgement t = {.hz = hz,
                               .amplitude = amplitude,
                               .of_oil = hz / loop_survey_oil_hz(s),
                               .of_loop = hz / loop_survey_loop_hz(s),
                               .follow = cabs(loop_survey_follow(s, dof, hz)),
                               .leg_m = leg * amplitude,
                               .leg_n = leg_force_per_acceleration(s, j, dof) * amplitude * pow(2.0 * PI * hz, 2.0),
                               .noise_m = fmax(largest(s->noise_m), rounding_m),
                               .noise_n = largest(noise_n)};
    t.below = t.of_oil < 1.0 && !(t.of_loop >= 1.0);
    t.above_floor = t.leg_m > t.noise_m && t.leg_n > t.noise_n;
    return t;
}

/* Steps of the computation. from: share of the whole computing time that passes before the step, as
 * measured for the default machine. */
enum step { STEP_CONFIGURED, STEP_PROPOSAL, STEPS = STEP_PROPOSAL + PROPOSALS };
static const struct {
    const char *what;
    double from;
} steps[STEPS + 1] = {
    [STEP_CONFIGURED] = {"predicting the tests as configured", 0.0},
    [STEP_PROPOSAL + PROPOSAL_SINES] = {"looking for six sines", 0.1},
    [STEP_PROPOSAL + PROPOSAL_MULTISINE] = {"looking for a multisine", 0.6},
    [STEPS] = {NULL, 1.0},
};

/* Context of tell(), which converts the share of one step to the share of the whole. */
struct step_watch {
    const struct survey_watch *watch;
    int step;
};

static void tell(void *context, double share) {
    const struct step_watch *w = context;
    w->watch->step(w->watch->context, steps[w->step].what, steps[w->step].from + share * (steps[w->step + 1].from - steps[w->step].from));
}

int survey_report_make(struct survey_report *r, const struct multisine *multisine, const struct recording *recording,
                       const struct method_c *inertia, const struct params *asked, double wanted_pct, const struct survey_watch *watch,
                       struct error *error) {
    struct step_watch step = {.watch = watch};
    struct proposal_watch proposal = {.share = tell, .context = &step};
    double j[LEGS][DOFS] = {{0}};
    *r = (struct survey_report){.asked = *asked, .wanted_pct = wanted_pct};
    int status = loop_survey(&r->survey, multisine, recording, inertia, error);
    if (status) return status;
    for (int i = 0; i < DOFS; i++) r->test[i] = judge(r, j, (enum dof)i);
    if (!r->survey.determined) {
        error_set(&r->no_prediction, STATUS_USAGE, "the inertia or a leg's stiffness is not determined");
        for (int i = 0; i < PROPOSALS; i++) r->proposal[i].none = r->no_prediction;
        r->no_gains = r->no_prediction;
        return STATUS_OK;
    }
    tell(&step, 0.0);
    loop_tune_surveyed(&r->asked, &r->survey, &r->gains, &r->no_gains);
    status = excitation_predict(&r->survey, &r->asked, &r->asked.tests, DRAWS, &r->configured, &r->no_prediction);
    for (int i = 0; i < PROPOSALS && status != STATUS_IO; i++) {
        step.step = STEP_PROPOSAL + i;
        status = propose((enum proposal_kind)i, &r->survey, &r->asked, wanted_pct, &proposal, &r->proposal[i], &r->no_prediction);
    }
    if (status == STATUS_IO) *error = r->no_prediction;
    return status == STATUS_IO ? status : STATUS_OK;
}

/* Prints a remark, with the likely causes, if a mode of the closed loop is hardly damped. An
 * unknown damping is NaN and causes no remark. */
static void print_hardly_damped(const struct loop_survey *s, int mode, FILE *out) {
    const struct loop_mode *m = &s->loop[mode];
    if (!(m->damping < LOOP_DAMPING_LEAST)) return;
    fprintf(
        out,
        "HARDLY DAMPED: mode %d of the closed loop, mostly %s, at %.3g Hz: damping ratio %.2g, below %g. It rings after every jolt.\n"
        "  Look at control.kpf first (hexid doctor names a value that suits), then at air in the oil (a low stiffness of a leg, below),\n"
        "  at the delay (below), and at control.kp; keep tests and trajectories away from %.3g Hz.\n",
        mode + 1, s->determined ? dof_names[s->mode[mode].dof] : "-", m->hz, m->damping, LOOP_DAMPING_LEAST, m->hz);
}

static const double L_PER_MIN_MPA = 6e10; /* l/(min MPa) per m^3/(s Pa) */

static void print_modes(const struct loop_survey *s, FILE *out) {
    fprintf(out, "mode  mostly  oil columns Hz     std  closed loop Hz  damping ratio\n");
    for (int i = 0; i < DOFS; i++)
        words_row(out, "%-4d  %-6s %15.2f %7.2f %15.2f %14.2f\n", i + 1, s->determined ? dof_names[s->mode[i].dof] : "-", s->mode[i].hz,
                  s->mode[i].hz_std, s->loop[i].hz, s->loop[i].damping);
    for (int i = 0; i < DOFS; i++) print_hardly_damped(s, i, out);
    if (!s->determined) fprintf(out, "no eigenfrequency: Mt or a leg's stiffness is not determined by these data (-)\n");
    fprintf(out, "legs 1..6: stiffness   ");
    for (int k = 0; k < LEGS; k++) words_row(out, " %6.2f", s->leg[k].stiffness * 1e-6);
    fprintf(out, " N/um\n           delay       ");
    for (int k = 0; k < LEGS; k++) words_row(out, " %6.2f", s->leg[k].delay_s * 1e3);
    fprintf(out, " ms, sample to spool\n           leakage     ");
    for (int k = 0; k < LEGS; k++) words_row(out, " %6.3f", s->leg[k].leakage * L_PER_MIN_MPA);
    fprintf(out, " l/(min MPa)\n           +- 95 %%     ");
    for (int k = 0; k < LEGS; k++) words_row(out, " %6.3f", NUMERIC_95 * s->leg[k].leakage_std * L_PER_MIN_MPA);
    fprintf(out, "\n");
}

static const char *words_of(const struct test_judgement *t, double amplitude_pct) {
    if (isnan(t->of_oil)) return "not judged: no eigenfrequency";
    if (!t->below) return "NOT BELOW the lowest eigenfrequency";
    if (!(100.0 * fabs(t->follow - 1.0) <= amplitude_pct)) return "REACHED is off by more than checks.amplitude_pct";
    return t->above_floor ? "below them, above the floor" : "BELOW the sensors' floor";
}

static void print_tests(const struct survey_report *r, FILE *out) {
    const struct test_judgement *any = &r->test[0];
    fprintf(out, "\ntests as configured; the sensors' floor is %.3g um of a leg and %.3g N\n", any->noise_m * 1e6, any->noise_n);
    fprintf(out, "axis   Hz    of oil  of loop  reached  leg um  leg N\n");
    for (int i = 0; i < r->asked.tests.count; i++) {
        enum dof dof = r->asked.tests.order[i];
        const struct test_judgement *t = &r->test[dof];
        words_row(out, "%-6s %-5.3g %6.2f %8.2f %8.2f %7.0f %6.0f  %s\n", dof_names[dof], t->hz, t->of_oil, t->of_loop, t->follow,
                  t->leg_m * 1e6, t->leg_n, words_of(t, r->asked.checks.amplitude_pct));
    }
    if (r->no_prediction.status) fprintf(out, "its deviation: not predicted: %s\n", r->no_prediction.text);
    else if (isinf(r->configured.worst_pct)) fprintf(out, "some entry of Mt would not be determined\n");
    else
        fprintf(out, "worst entry Mt(%d,%d): std %.2f %% of sqrt(Mii Mjj), predicted\n", r->configured.row + 1, r->configured.column + 1,
                r->configured.worst_pct);
}

static void print_proposal(const struct proposal *p, const char *name, double wanted_pct, FILE *out) {
    char options[OPTIONS_SIZE];
    if (p->none.status) {
        fprintf(out, "%-9s none: %s\n", name, p->none.text);
        return;
    }
    proposal_options(p, options, sizeof options);
    fprintf(out, "%-9s std %.3g %% predicted, worst entry Mt(%d,%d), %g s%s evaluated\n", name, p->predicted.worst_pct,
            p->predicted.row + 1, p->predicted.column + 1, p->tests.duration_s, p->tests.multisine ? "" : " an axis");
    if (p->predicted.worst_pct > wanted_pct)
        fprintf(out, "          NOT the %.3g %% wanted%s\n", wanted_pct,
                p->reached ? ", but within 5 % of it, as near as a prediction is" : ": a longer test would come no nearer");
    if (p->tests.multisine)
        fprintf(out, "          excitation: worst entry %.3g %% with equal rates, %.3g %% as shared out\n", p->start_pct, p->best_pct);
    fprintf(out, "          hexid run %s\n", options);
}

static void print_gains(const struct survey_report *r, FILE *out) {
    const struct loop_tune *t = &r->gains;
    if (r->no_gains.status || !(t->gains.kp > 0.0)) {
        fprintf(out, "\ngains     none: %s\n", r->no_gains.status ? r->no_gains.text : "none keep the margins of hexid tune");
        return;
    }
    fprintf(out, "\ngains of the machine that was found, as hexid tune: margins of %.1f dB and %.0f degrees, now %.1f dB and %.0f\n",
            t->after.gain_db.value, t->after.phase_deg.value, t->before.gain_db.value, t->before.phase_deg.value);
    tune_report_section(out, t);
}

void survey_report_print(const struct survey_report *r, FILE *out) {
    const struct multisine *m = &r->survey.multisine;
    fprintf(out, "survey    %d tones from %g to %g Hz, legs at most %.3f m/s\n", m->tones, m->tone[0].hz, m->tone[m->tones - 1].hz,
            m->peak_mps);
    fprintf(out, "          std: one standard deviation; a 95 %% interval is 1.96 of them to either side\n");
    print_modes(&r->survey, out);
    print_tests(r, out);
    fprintf(out, "\nfor a std of %g %% of sqrt(Mii Mjj) in the worst entry of Mt\n", r->wanted_pct);
    for (int i = 0; i < PROPOSALS; i++) print_proposal(&r->proposal[i], kind_names[i], r->wanted_pct, out);
    print_gains(r, out);
    fprintf(out, "\n");
}

static json_t *modes_json(const struct loop_survey *s) {
    json_t *array = json_array();
    for (int i = 0; i < DOFS; i++)
        json_array_append_new(array,
                              json_pack("{so so so so so}", "dof", s->determined ? json_string(dof_names[s->mode[i].dof]) : json_null(),
                                        "oil_hz", report_number(s->mode[i].hz), "oil_std_hz", report_number(s->mode[i].hz_std), "loop_hz",
                                        report_number(s->loop[i].hz), "loop_damping", report_number(s->loop[i].damping)));
    return array;
}

static json_t *legs_json(const struct loop_survey *s) {
    json_t *array = json_array();
    for (int k = 0; k < LEGS; k++)
        json_array_append_new(array, json_pack("{so so so so so so so so so}", "stiffness_n_per_m", report_number(s->leg[k].stiffness),
                                               "stiffness_std_n_per_m", report_number(s->leg[k].stiffness_std), "leakage_m3_per_s_pa",
                                               report_number(s->leg[k].leakage), "leakage_std_m3_per_s_pa",
                                               report_number(s->leg[k].leakage_std), "delay_s", report_number(s->leg[k].delay_s), "misfit",
                                               report_number(s->leg[k].misfit), "noise_m", report_number(s->noise_m[k]), "noise_p1_pa",
                                               report_number(s->noise_pa[0][k]), "noise_p2_pa", report_number(s->noise_pa[1][k])));
    return array;
}

static json_t *tests_json(const struct survey_report *r) {
    json_t *object = json_object();
    for (int i = 0; i < r->asked.tests.count; i++) {
        const struct test_judgement *t = &r->test[r->asked.tests.order[i]];
        json_object_set_new(object, dof_names[r->asked.tests.order[i]],
                            json_pack("{so so so so so so so so sb sb}", "frequency_hz", report_number(t->hz), "of_oil",
                                      report_number(t->of_oil), "of_loop", report_number(t->of_loop), "reached", report_number(t->follow),
                                      "leg_m", report_number(t->leg_m), "leg_n", report_number(t->leg_n), "noise_m",
                                      report_number(t->noise_m), "noise_n", report_number(t->noise_n), "below", t->below, "above_floor",
                                      t->above_floor));
    }
    return object;
}

static json_t *proposal_json(const struct proposal *p) {
    char options[OPTIONS_SIZE];
    if (p->none.status) return json_pack("{ss}", "none", p->none.text);
    proposal_options(p, options, sizeof options);
    return json_pack("{ss so sb so so so}", "options", options, "predicted_pct", report_number(p->predicted.worst_pct), "reached",
                     p->reached, "duration_s", report_number(p->tests.duration_s), "start_pct",
                     p->tests.multisine ? report_number(p->start_pct) : json_null(), "best_pct",
                     p->tests.multisine ? report_number(p->best_pct) : json_null());
}

char *survey_report_json(const struct survey_report *r, char *identification) {
    json_t *root = identification ? json_loads(identification, 0, NULL) : NULL, *proposals = json_object();
    free(identification);
    for (int i = 0; i < PROPOSALS; i++) json_object_set_new(proposals, kind_keys[i], proposal_json(&r->proposal[i]));
    json_t *survey = json_pack(
        "{ss so so so so so so so}", "schema", "hexid.survey/1", "modes", modes_json(&r->survey), "legs", legs_json(&r->survey), "tests",
        tests_json(r), "configured_pct", report_number(r->no_prediction.status ? (double)NAN : r->configured.worst_pct), "wanted_pct",
        report_number(r->wanted_pct), "proposals", proposals, "gains", r->no_gains.status ? json_null() : tune_report_object(&r->gains));
    return report_text(report_set(root, "survey", survey));
}
