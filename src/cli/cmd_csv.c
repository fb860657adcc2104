#include <string.h>

#include "cli.h"
#include "csv_input.h"
#include "log_export.h"
#include "outputs.h"

static int named(const struct options *o, const char *command, struct error *error) {
    if (o->operands && o->output) return STATUS_OK;
    return error_set(error, STATUS_USAGE, "%s: name what to read and, with -o, what to write; see `hexid %s --help`", command, command);
}

static void warn_unreadable(int64_t messages) {
    if (messages) cli_say(stderr, "hexid: warning: %lld messages of hexid's channels could not be read", (long long)messages);
}

static void say_aside(const struct csv_report *report) {
    if (report->aside[0]) cli_say(stderr, "hexid: the log that was there is now %s", report->aside);
}

int cmd_import(int argc, char **argv) {
    struct options o;
    struct error error;
    struct csv_report report = {0};
    struct csv_input input = {0};
    int status = options_parse(&o, argc, argv, "coSa", 1, &error);
    if (!status) status = named(&o, "import", &error);
    if (!status) status = csv_input_begin(&input, &o, o.operand[0], &error);
    if (!status) status = outputs_open(&o, NULL, OUTPUTS_FILE, NULL, NULL, &error);
    if (!status) status = csv_import(&input.source, o.output, &report, &error);
    say_aside(&report);
    csv_input_end(&input);
    if (status) return cli_fail(&error);
    cli_say(stdout, "%s: %d test%s, %lld rows, %lld cycles without a row", o.output, report.files, report.files == 1 ? "" : "s",
            (long long)report.rows, (long long)report.lost);
    cli_say_overruled(o.operand[0], report.overruled);
    if (report.stated_hz > 0.0)
        cli_say(stderr, "hexid: warning: rate_hz: %g is not what t_s has, %.6g Hz: that is taken", report.stated_hz, report.rate_hz);
    if (report.zero[0])
        cli_say(stdout, "t_s does not begin near t = 0, where the ramp-in begins; by the motion t = 0 is at t_s = %s", report.zero);
    if (report.several)
        cli_say(stdout, "an axis has files of several frequencies: hexid gap takes each test at the one at which it moves, "
                        "hexid identify needs one an axis");
    if (report.empty)
        cli_say(stdout, "%lld cells have no number: rows that lack a length, a pressure, a force or a command count as lost",
                (long long)report.empty);
    if (report.notes[0]) cli_say(stdout, "%s", report.notes);
    if (report.turns)
        cli_say(stdout,
                "an axis that turns, read as at a lever of 1 m: angles in rad stand as m, torques in N m as N, and axis.mass_kg is kg m2");
    if (report.missing[0]) cli_say(stdout, "missing columns, what needs them is not evaluated: %s", report.missing);
    if (report.no_lengths)
        cli_say(stderr, "hexid: warning: a file lacks lengths (l1_m .. l6_m): without all six hexid gap and hexid identify have nothing "
                        "to evaluate; names of your own take --map l1=NAME:mm");
    if (report.no_areas) cli_say(stderr, "hexid: warning: pressures, and %s; hexid gap refuses them without", report.areas);
    else if (report.areas[0]) cli_say(stdout, "forces are A1 P1 - A2 P2, areas: %s", report.areas);
    if (report.defaults[0])
        cli_say(stdout, "as in the default configuration: %s; what is otherwise on your machine, state with -c", report.defaults);
    if (report.doubtful[0]) cli_say(stderr, "hexid: warning: units? %s", report.doubtful);
    if (report.ignored[0]) cli_say(stdout, "not understood and left out: %s", report.ignored);
    return EXIT_PASSED;
}

static int export_tests(const struct options *o, struct error *error) {
    struct csv_report report;
    int status = csv_export(o->operand[0], o->run, o->output, &report, error);
    if (report.cut) cli_warn_cut(o->operand[0], report.cut_offset);
    if (status) return status;
    cli_say(stdout, "%s: %d test%s, %lld rows, %lld cycles lost", o->output, report.files, report.files == 1 ? "" : "s",
            (long long)report.rows, (long long)report.lost);
    warn_unreadable(report.unreadable);
    return STATUS_OK;
}

static int export_all(const struct options *o, const struct export_format *format, struct error *error) {
    struct log_export_report report;
    int status = log_export(o->operand[0], o->run, o->output, format, &report, error);
    if (report.cut) cli_warn_cut(o->operand[0], report.cut_offset);
    if (status) return status;
    cli_say(stdout, "%s: %lld cycles, %lld cycles lost, %lld messages%s", o->output, (long long)report.cycles, (long long)report.lost,
            (long long)report.messages, format == &export_table ? " left out: a table has cycles alone" : "");
    warn_unreadable(report.unreadable);
    return STATUS_OK;
}

int cmd_export(int argc, char **argv) {
    static const struct export_format *const formats[] = {&export_table, &export_mat, &export_mcap};
    struct options o;
    struct error error;
    const struct export_format *format = NULL;
    int status = options_parse(&o, argc, argv, "oFAU", 1, &error);
    if (!status) status = named(&o, "export", &error);
    const char *name = !status && o.format ? o.format : export_table.name;
    for (size_t i = 0; i < sizeof formats / sizeof *formats; i++)
        if (!strcmp(name, formats[i]->name)) format = formats[i];
    if (!status && !format) status = error_set(&error, STATUS_USAGE, "--format %.80s: choose csv, mat or mcap", name);
    if (!status && o.all && format != &export_table)
        status = error_set(&error, STATUS_USAGE, "--all: for csv; %s has everything anyway", name);
    bool tests = format == &export_table && !o.all;
    if (!status) status = outputs_open(&o, NULL, tests ? OUTPUTS_TESTS : OUTPUTS_FILE, NULL, NULL, &error);
    if (!status) status = tests ? export_tests(&o, &error) : export_all(&o, format, &error);
    return status ? cli_fail(&error) : EXIT_PASSED;
}
