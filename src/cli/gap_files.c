#include "gap_files.h"

#include <errno.h>
#include <libgen.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "bus.h"
#include "config.h"
#include "gap_html.h"
#include "gap_json.h"
#include "gap_messages.h"
#include "messages.h"
#include "numeric.h"
#include "units.h"

enum { PATH_SIZE = 4096, MESSAGE_MAX = 65536 };

static int write_whole(const char *directory, const char *name, const char *text, struct error *error) {
    char path[PATH_SIZE];
    snprintf(path, sizeof path, "%s/%s", directory, name);
    return output_text(path, text, error);
}

static int write_page(const struct options *o, const struct gap_report *report, struct error *error) {
    char *page;
    struct error writing;
    int status = gap_html(report, &page, error);
    if (page && write_whole(o->output, "report.html", page, &writing)) *error = writing, status = writing.status;
    free(page);
    return status;
}

static int write_report(const struct options *o, const struct gap_result *r, const struct recording *measured,
                        const struct waves *closed_loop, const char *model, struct error *error) {
    struct waves motion = {0};
    struct gap_report report = {.result = r,
                                .measured = measured,
                                .motion = &motion,
                                .waves = r->simulated ? closed_loop : &motion,
                                .measured_file = o->measured,
                                .validate_file = o->validate,
                                .config_file = o->config,
                                .model_file = model};
    int status = waves_motion(&motion, r, measured, error);
    if (!status) status = write_page(o, &report, error);
    waves_free(&motion);
    return status;
}

/* Returns true for a path directly in the directory that will be created, not in a subdirectory. */
static bool is_inside(const char *path, const char *directory) {
    size_t length = strlen(directory);
    while (length > 1 && directory[length - 1] == '/') length--;
    return !strncmp(path, directory, length) && path[length] == '/' && !strchr(path + length + 1, '/');
}

int gap_files_check(const struct options *o, struct output *json, struct error *error) {
    char path[PATH_SIZE];
    *json = (struct output){.file = -1};
    if (!*o->output) return error_set(error, STATUS_USAGE, "-o: an empty name; name a directory");
    bool there = !access(o->output, F_OK);
    snprintf(path, sizeof path, there ? "%s/." : "%s", o->output); /* if o->output is a file,
                                                                    * access() then fails, because a
                                                                    * file has no "." */
    if (access(there ? path : dirname(path), W_OK | X_OK))
        return error_set(error, STATUS_IO, "%.300s: cannot be %s: %s", o->output, there ? "written" : "made", strerror(errno));
    return o->json && (there || !is_inside(o->json, o->output)) ? output_prepare(json, o->json, OUTPUT_RESULT, error) : STATUS_OK;
}

/* Writes the remark for a key of an effect that was found: the widest 95 % interval of the legs. */
static void note_key(const struct gap_effect *e, int key, struct config_note *note) {
    const struct effect *effect = effect_table[e->effect];
    double widest = 0.0;
    for (int leg = 0; leg < LEGS; leg++) widest = fmax(widest, e->std[key][leg] > 0.0 ? gap_deviation(e, key, leg) : 0.0);
    snprintf(note->key, sizeof note->key, "effects.%.40s.%.30s", effect->name, effect->keys[key].name);
    if (widest > 0.0) snprintf(note->text, sizeof note->text, "+- %.2g at most (95 %%)", NUMERIC_95 * widest);
    else snprintf(note->text, sizeof note->text, "at the end of its range: no estimate");
}

static char *model_text(const struct gap_result *r) {
    struct config_note note[GAP_EFFECTS * EFFECT_KEYS];
    char head[GAP_TEXT + 40];
    int notes = 0;
    for (int i = 0; i < r->effects; i++)
        for (int k = 0; k < r->effect[i].keys; k++) note_key(&r->effect[i], k, &note[notes++]);
    snprintf(head, sizeof head, "hexid gap, %s: %s", gap_verdict_names[r->verdict], r->reason);
    return config_text_noted(&r->model, head, note, notes);
}

int gap_files_write(const struct options *o, struct output *to, const struct gap_result *r, const struct recording *measured,
                    const struct waves *closed_loop, struct error *error) {
    char path[PATH_SIZE];
    snprintf(path, sizeof path, "%s/model.yaml", o->output);
    if (mkdir(o->output, 0777) && errno != EEXIST)
        return error_set(error, STATUS_IO, "%.300s: cannot be made: %s", o->output, strerror(errno));
    char *model = model_text(r), *json = gap_json(r, path);
    int status = write_whole(o->output, "model.yaml", model, error);
    if (!status) status = write_whole(o->output, "gap.json", json, error);
    if (!status) status = write_report(o, r, measured, closed_loop, path, error);
    struct error second;
    int copied = !json ? STATUS_OK : to->name ? output_write(to, json, status ? &second : error) : STATUS_OK;
    if (json && o->json && !to->name) copied = output_text(o->json, json, status ? &second : error);
    if (!status) status = copied;
    free(model);
    free(json);
    return status;
}

static int64_t wall_clock_ns(void) {
    struct timespec t;
    clock_gettime(CLOCK_REALTIME, &t);
    return t.tv_sec * NS_PER_S + t.tv_nsec;
}

void gap_files_publish(const struct params *params, const struct gap_result *r) {
    struct bus *bus = NULL;
    struct error error;
    unsigned char *message = params->lcm.url[0] ? malloc(MESSAGE_MAX) : NULL;
    if (!message) return;
    int size = gap_encode(r, wall_clock_ns(), message, MESSAGE_MAX);
    if (bus_open(&bus, params->lcm.url, &error)) cli_say(stderr, "hexid: warning: %s", error.text);
    else if (size < 0 || bus_publish(bus, CHANNEL_GAP, message, size))
        fprintf(stderr, "hexid: warning: %s was not published\n", CHANNEL_GAP);
    if (bus) bus_close(bus);
    free(message);
}
