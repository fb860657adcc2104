#include <string.h>

#include "cli.h"
#include "csv_input.h"

static int named(const struct options *o, const char *command, struct error *error) {
    if (o->operands && o->output) return STATUS_OK;
    return error_set(error, STATUS_USAGE, "%s: name what to read and, with -o, what to write; see `hexid %s --help`", command, command);
}

int cmd_import(int argc, char **argv) {
    struct options o;
    struct error error;
    struct csv_report report;
    struct csv_input input = {0};
    int status = options_parse(&o, argc, argv, "coSa", 1, &error);
    if (!status) status = named(&o, "import", &error);
    if (!status) status = csv_input_begin(&input, &o, o.operand[0], &error);
    if (!status) status = csv_import(&input.source, o.output, &report, &error);
    csv_input_end(&input);
    if (status) return cli_fail(&error);
    cli_say(stdout, "%s: %d tests, %lld rows, %lld cycles without a row", o.output, report.files, (long long)report.rows,
            (long long)report.lost);
    if (report.stated_hz > 0.0)
        cli_say(stderr, "hexid: warning: rate_hz: %g is not what t_s has, %.6g Hz: that is taken", report.stated_hz, report.rate_hz);
    if (report.several)
        cli_say(stdout, "an axis has files of several frequencies: hexid gap takes each test at the one at which it moves, hexid identify needs one an axis");
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
