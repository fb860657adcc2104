/* hexid gap: logs in, diagnosis, files out. */
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "cli.h"
#include "gap.h"
#include "gap_files.h"
#include "log.h"
#include "messages.h"

static int load(const char *path, struct recording *r, struct error *error) {
    struct log_reader *log;
    struct log_event event;
    struct cycle cycle;
    int status = log_open(&log, path, error);
    if (status) return status;
    while (!status && log_next(log, &event))
        if (!strcmp(event.channel, CHANNEL_STATE) && state_decode(event.data, event.size, &cycle)) status = recording_add(r, &cycle, error);
    log_release(log);
    if (!status) status = recording_check(r, error);
    if (!status) return STATUS_OK;
    struct error reason = *error;
    return error_set(error, reason.status, "%.100s: %.280s", path, reason.text);
}

static void print_effect(const struct gap_effect *e, FILE *out) {
    const struct effect *effect = effect_table[e->effect];
    fprintf(out, "  %s explains %.1f %% of it (z %.0f)\n", effect->name, 100.0 * e->share_explained, e->z);
    for (int key = 0; key < EFFECT_KEYS && effect->keys[key].name; key++) {
        fprintf(out, "    %-24s", effect->keys[key].name);
        for (int leg = 0; leg < (e->shape == -1 ? 1 : LEGS); leg++) fprintf(out, " %.4g +- %.2g", e->values.value[key][leg], e->std[key][leg]);
        fprintf(out, " %s\n", effect->keys[key].unit);
    }
}

static void print(const struct gap_result *r, FILE *out) {
    fprintf(out, "\n%s: %s\n", gap_verdict_names[r->verdict], r->reason);
    for (int i = 0; i < r->effects; i++) print_effect(&r->effect[i], out);
    for (int i = 0; i < r->ambiguous; i++) fprintf(out, "  cannot be told from %s\n", effect_table[r->ambiguous_with[i]]->name);
    for (int i = 0, shown = 0; i < r->candidates && shown < 3; i++) {
        if (r->effects && r->candidate[i].effect == r->effect[0].effect) continue;
        fprintf(out, "  runner-up %s: %.1f %%\n", effect_table[r->candidate[i].effect]->name, 100.0 * r->candidate[i].share_explained);
        shown++;
    }
    if (r->next_experiment[0]) fprintf(out, "  next experiment: %s\n", r->next_experiment);
    fprintf(out, "\n  held out   %10s %10s %10s\n", "before", "after", "noise");
    for (int ch = 0; ch < GAP_CHANNELS; ch++)
        fprintf(out, "  %-10s %10.4g %10.4g %10.4g %s\n", gap_channel_names[ch], r->held_out_before.channel[ch], r->held_out_after.channel[ch],
                r->noise_floor.channel[ch], gap_channel_units[ch]);
    fprintf(out, "  %-10s %10.4g %10.4g %10.4g of the variation; unexplained %.1f %%\n", "overall", r->held_out_before.overall,
            r->held_out_after.overall, r->noise_floor.overall, 100.0 * r->unexplained_fraction);
    for (int i = 0; i < r->places && i < 5; i++)
        fprintf(out, "  where: test %d, %s of leg %d, harmonic %d, %s: %.1f %%\n", r->where[i].test + 1, gap_channel_names[r->where[i].channel],
                r->where[i].leg + 1, r->where[i].harmonic, r->where[i].feature, 100.0 * r->where[i].share);
    fprintf(out, "  %.1f s\n", r->seconds);
}

static void progress(void *context, const char *step, double share) {
    (void)context;
    if (isatty(STDERR_FILENO)) fprintf(stderr, "\r\033[Kgap: %3.0f %% %s%s", 100.0 * share, step, share >= 1.0 ? "\r\033[K" : "");
    else fprintf(stderr, "gap: %s\n", step);
}

static int options(struct options *o, struct gap_options *g, int argc, char **argv, struct error *error) {
    int status = options_parse(o, argc, argv, "cSjoMvR", 0, error);
    if (status) return status;
    if (!o->measured || !o->config || !o->output)
        return error_set(error, STATUS_USAGE, "`hexid gap` needs --measured LOG, -c FILE and -o DIR; see `hexid gap --help`");
    *g = (struct gap_options){.replay = GAP_CLOSED_LOOP, .simulate = true, .progress = progress};
    g->threads = (int)sysconf(_SC_NPROCESSORS_ONLN);
    if (!o->replay || !strcmp(o->replay, "closed-loop")) return STATUS_OK;
    g->replay = GAP_MOTION;
    if (!strcmp(o->replay, "motion")) return STATUS_OK;
    return error_set(error, STATUS_USAGE, "--replay %s: choose closed-loop or motion", o->replay);
}

static int run(int argc, char **argv, struct params *params, struct recording *measured, struct recording *validate, struct gap_result *result,
               struct error *error) {
    struct options o;
    struct gap_options g;
    int status = options(&o, &g, argc, argv, error);
    if (!status) status = options_params(&o, params, error);
    recording_init(measured, params);
    recording_init(validate, params);
    if (!status) status = load(o.measured, measured, error);
    if (!status && o.validate) status = load(o.validate, validate, error);
    if (!status) status = gap_solve(params, measured, o.validate ? validate : NULL, &g, result, error);
    if (status) return status;
    status = gap_files_write(&o, result, measured, error);
    gap_files_publish(params, result);
    print(result, o.json && !strcmp(o.json, "-") ? stderr : stdout);
    return status;
}

int cmd_gap(int argc, char **argv) {
    struct error error;
    struct params *params = calloc(1, sizeof *params);
    struct gap_result *result = calloc(1, sizeof *result);
    struct recording *recording = calloc(2, sizeof *recording);
    int status = error_set(&error, STATUS_IO, "out of memory");
    if (params && result && recording) status = run(argc, argv, params, &recording[0], &recording[1], result, &error);
    if (recording) recording_free(&recording[0]), recording_free(&recording[1]);
    free(params);
    free(result);
    free(recording);
    return status ? cli_fail(&error) : EXIT_PASSED;
}
