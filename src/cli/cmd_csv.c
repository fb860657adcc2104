#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "cli.h"
#include "config.h"
#include "csv.h"
#include "csv_map.h"

static int named(const struct options *o, const char *command, struct error *error) {
    if (o->operands && o->output) return STATUS_OK;
    return error_set(error, STATUS_USAGE, "%s: name what to read and, with -o, what to write; see `hexid %s --help`", command, command);
}

/* The directory's own configuration would win silently. */
static int one_configuration(const struct options *o, struct error *error) {
    char path[PATH_MAX];
    snprintf(path, sizeof path, "%s/config.yaml", o->operand[0]);
    if ((!o->config && !o->setting_count) || access(path, F_OK)) return STATUS_OK;
    return error_set(error, STATUS_USAGE, "import: %.300s is the run's configuration: change or remove it, or leave -c and --set out",
                     path);
}

int cmd_import(int argc, char **argv) {
    struct options o;
    struct error error;
    struct csv_report report;
    struct params params;
    struct csv_map map;
    int status = options_parse(&o, argc, argv, "coSa", 1, &error);
    if (!status) status = named(&o, "import", &error);
    if (!status && o.map) status = csv_map_parse(&map, o.map, &error);
    if (!status) status = one_configuration(&o, &error);
    if (!status) status = options_params(&o, &params, &error);
    char *base = status ? NULL : config_text(&params);
    struct csv_source source = {.directory = o.operand[0], .base = base, .map = o.map ? &map : NULL};
    if (!status) status = csv_import(&source, o.output, &report, &error);
    free(base);
    if (status) return cli_fail(&error);
    cli_say(stdout, "%s: %d tests, %lld rows, %lld cycles without a row", o.output, report.files, (long long)report.rows,
            (long long)report.lost);
    if (report.empty)
        cli_say(stdout, "%lld cells have no number: rows that lack a length, a pressure, a force or a command count as lost",
                (long long)report.empty);
    if (report.missing[0]) cli_say(stdout, "missing columns, what needs them is not evaluated: %s", report.missing);
    if (report.doubtful[0]) cli_say(stderr, "hexid: warning: units? %s", report.doubtful);
    if (report.ignored[0]) cli_say(stdout, "not understood and left out: %s", report.ignored);
    return EXIT_PASSED;
}

int cmd_export(int argc, char **argv) {
    struct options o;
    struct error error;
    struct csv_report report;
    int status = options_parse(&o, argc, argv, "oF", 1, &error);
    if (!status) status = named(&o, "export", &error);
    if (!status && o.format && strcmp(o.format, "csv"))
        status = error_set(&error, STATUS_USAGE, "--format %s: csv is what there is", o.format);
    if (!status) {
        status = csv_export(o.operand[0], o.output, &report, &error);
        if (report.cut) cli_warn_cut(o.operand[0], report.cut_offset);
    }
    if (status) return cli_fail(&error);
    cli_say(stdout, "%s: %d tests, %lld rows, %lld cycles lost", o.output, report.files, (long long)report.rows,
            (long long)report.lost);
    if (report.unreadable)
        cli_say(stderr, "hexid: warning: %lld messages on HEXID_STATE could not be read", (long long)report.unreadable);
    return EXIT_PASSED;
}
