/* `hexid doctor`: checks the configuration, this computer and its buses. */
#include <jansson.h>
#include <stdlib.h>
#include <string.h>

#include "cli.h"
#include "config.h"
#include "doctor.h"
#include "failure.h"
#include "hal.h"
#include "modbus_map.h"
#include "outputs.h"
#include "params.h"
#include "refusal.h"
#include "version.h"

/* The checks in order of execution. JSON uses their names, so the names never change. */
static const struct check {
    const char *name;
    doctor_check *ask;
} checks[] = {
    {"configuration", check_configuration},
    {"machine", check_machine},
    {"kinematics", check_kinematics},
    {"workspace", check_workspace},
    {"strokes", check_strokes},
    {"cylinders", check_cylinders},
    {"payload", check_payload},
    {"loop", check_loop},
    {"gains", check_gains},
    {"feed-forward", check_feed_forward},
    {"moves", check_moves},
    {"limits", check_limits},
    {"tests", check_tests},
    {"blind time", check_blind_time},
    {"interlocks", check_interlocks},
    {"kernel", check_kernel},
    {"hypervisor", check_hypervisor},
    {"real time", check_realtime},
    {"locked memory", check_locked_memory},
    {"governor", check_governor},
    {"idle states", check_idle_states},
    {"isolation", check_isolation},
    {"siblings", check_siblings},
    {"throttling", check_throttling},
    {"clock source", check_clock_source},
    {"LCM socket", check_lcm_socket},
    {"LCM route", check_lcm_route},
    {"LCM datagram", check_lcm_datagram},
    {"LCM buffers", check_lcm_buffers},
    {"CAN load", check_can_load},
    {"CAN interface", check_can_interface},
    {"CAN errors", check_can_errors},
    {"Modbus line", check_modbus_line},
    {"Modbus", check_modbus},
    {"log room", check_log_room},
    {"log speed", check_log_speed},
    {"wake-up", check_wakeups}, /* last, because it takes long and shows the effect of what the
                                 * checks above found */
};
enum { CHECKS = sizeof checks / sizeof *checks, LATENCY_S = 10, NAME_WIDTH = 14 };

static const char *const levels[] = {[LEVEL_OK] = "ok", [LEVEL_UNKNOWN] = "?", [LEVEL_WARN] = "WARN", [LEVEL_FAIL] = "FAIL"};
static const char *const json_levels[] = {[LEVEL_OK] = "ok", [LEVEL_UNKNOWN] = "unknown", [LEVEL_WARN] = "warn", [LEVEL_FAIL] = "fail"};

static void print(FILE *out, const char *name, const struct finding *f) {
    char text[sizeof f->found];
    snprintf(text, sizeof text, "%s", f->found);
    char *rest = text, *line = strsep(&rest, "\n");
    cli_say(out, "  %-5s %-*s %s", levels[f->level], NAME_WIDTH, name, line);
    while ((line = strsep(&rest, "\n"))) cli_say(out, "        %-*s %s", NAME_WIDTH, "", line);
    if (*f->remedy) cli_say(out, "        %-*s do: %s", NAME_WIDTH, "", f->remedy);
    fflush(out);
}

/* Appends a finding to the list, which takes over f->data. */
static void append(json_t *all, const char *name, struct finding *f) {
    json_array_append_new(all, json_pack("{ss ss so so so}", "name", name, "level", json_levels[f->level], "found", doctor_text(f->found),
                                         "remedy", doctor_text(f->remedy), "data", f->data ? f->data : json_null()));
    f->data = NULL;
}

static int write_json(struct output *to, const struct doctor *d, json_t *findings, const int count[], struct error *error) {
    json_t *root = json_pack("{ss ss so so sO sb}", "schema", "hexid.doctor/1", "version", version, "machine", doctor_text(d->url),
                             "config", d->config ? doctor_text(d->config) : json_null(), "findings", findings, "fit",
                             count[LEVEL_FAIL] == 0);
    char *text = root ? json_dumps(root, JSON_INDENT(1)) : NULL;
    json_decref(root);
    return output_made(to, text, error);
}

/* Makes all checks. Returns the exit status, or a negative status. */
static int ask_all(const struct doctor *d, struct output *json, struct error *error) {
    FILE *out = json->name && !strcmp(json->name, "-") ? stderr : stdout;
    int count[LEVEL_FAIL + 1] = {0};
    json_t *all = json_array();
    for (int i = 0; i < CHECKS; i++) {
        struct finding f = checks[i].ask(d);
        count[f.level]++;
        if (f.level != LEVEL_NONE) print(out, checks[i].name, &f);
        if (f.level != LEVEL_NONE && json->name) append(all, checks[i].name, &f);
        json_decref(f.data);
    }
    fprintf(out, "%s: %d FAIL, %d WARN, %d that cannot be seen from here\n", count[LEVEL_FAIL] ? "not fit" : "fit", count[LEVEL_FAIL],
            count[LEVEL_WARN], count[LEVEL_UNKNOWN]);
    int status = json->name ? write_json(json, d, all, count, error) : STATUS_OK;
    json_decref(all);
    return status ? status : count[LEVEL_FAIL] ? EXIT_CHECK_FAILED : EXIT_PASSED;
}

static bool reference(const struct options *o) {
    if (o->failures) failure_print(stdout);
    else if (o->refusals) refusal_print(stdout);
    else if (o->keys) config_print_keys(stdout);
    else if (o->modbus_map) modbus_map_print(stdout);
    else return false;
    return true;
}

int cmd_doctor(int argc, char **argv) {
    char installed[PATH_MAX];
    struct options o;
    struct params params;
    struct error error;
    if (options_parse(&o, argc, argv, "cHSmxekljL", 0, &error) || options_params(&o, &params, &error)) return cli_fail(&error);
    if (reference(&o)) return EXIT_PASSED;
    const char *last = strrchr(o.hal, ';');
    struct doctor d = {.params = &params,
                       .config = o.config ? o.config : options_default_config(installed),
                       .url = last ? last + 1 : o.hal,
                       .log = o.log,
                       .root = "",
                       .latency_s = o.latency_s < 0.0 ? LATENCY_S : o.latency_s};
    const struct hal_ops *ops = hal_find(d.url);
    if (!ops) {
        error_set(&error, STATUS_USAGE, "--hal %.200s: no such back-end; `hexid run --help` lists them", d.url);
        return cli_fail(&error);
    }
    d.machine = !ops->simulated;
    struct loop_check loop = {0};
    if (doctor_drives(&d)) loop = loop_check(&params, d.machine);
    d.loop = &loop;
    struct output json;
    int status = outputs_open(&o, &params, OUTPUTS_NONE, &json, NULL, &error);
    if (!status) status = ask_all(&d, &json, &error);
    return status < 0 ? cli_fail(&error) : status;
}
