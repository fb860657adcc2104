/* The command line: options that the subcommands share, and the subcommands. Each subcommand
 * returns the process's exit status: 0 done and all checks passed, 1 a check failed or was not
 * evaluated, 2 usage or configuration, 3 I/O or device, 4 refused for safety. */
#ifndef HEXID_CLI_H
#define HEXID_CLI_H

#include <limits.h>
#include <stdbool.h>
#include <stdio.h>

#include "params/text.h"
#include "realtime.h"
#include "status.h"
#include "types.h"

struct params;

enum { SETTINGS_MAX = 64, OPERANDS_MAX = 16, LOGS_MAX = 4 };

/* the other exit statuses are those of enum status, negated */
enum { EXIT_PASSED = 0, EXIT_CHECK_FAILED = 1 };

struct options {
    const char *config, *hal, *bus, *log, *json, *output, *format, *validate, *replay, *map, *http, *machine, *model, *baseline;
    const char *measured[LOGS_MAX];
    int measured_count;
    const char *settings[SETTINGS_MAX];
    int setting_count;
    int run; /* value of --run: number of the run in a log that contains several; 0: not given */
    double log_quota_bytes, log_part_bytes; /* values of --log-quota and --log-part; 0: no limit */
    /* --tests, --trajectory and --repeat in the form of --set, "key=value" */
    char tests[64], trajectory[PARAMS_TEXT_SIZE + 32], repeat[64];
    uint64_t seed;
    bool fast, print_config, modbus_map, failures, refusals, keys, survey, qualify, verbose, all, once, json_lines;
    double latency_s; /* value of --latency: duration of the measurement of wake-ups; negative: not
                       * given */
    /* value of --weight, and its standard deviation; 0: not given */
    double weight_kg, weight_std_kg;
    double std_pct; /* value of --std: wanted standard deviation of the survey's proposals, %; 0:
                     * not given */
    bool rt_given, pose_given;
    double pose[DOFS]; /* value of --pose: x y z phi theta psi, m and rad */
    enum realtime_mode rt;
    const char *operand[OPERANDS_MAX];
    int operands;
};

/* Reads argv[1..] of a subcommand. allowed: the options that it takes, as letters of long_options
 * in options.c; operands: largest number of operands. Returns 0 or -2. */
int options_parse(struct options *o, int argc, char **argv, const char *allowed, int operands, struct error *error);

/* Appends the operands to the logs of --measured. Returns -2 if there are more than LOGS_MAX
 * logs. */
int options_measured(struct options *o, struct error *error);

/* Returns the path of the configuration that is used without -c: config/tian2015.yaml of the
 * current directory (a checkout), else the installed one, found relative to this program: in
 * PREFIX/etc/hexid for a program in PREFIX/bin, or in /etc/hexid for one in /usr/bin. NULL: neither
 * exists, and the built-in configuration is used. `installed` is memory for the path. */
const char *options_default_config(char installed[PATH_MAX]);

/* Reads the configuration of -c, or without -c that of options_default_config(), and applies --set.
 * Returns 0 or -2. */
int options_params(const struct options *o, struct params *params, struct error *error);

/* Finds the configuration of the machine that a URL of --hal names: that in FILE for sim:FILE,
 * otherwise `own`. Returns -2 if FILE is wrong, or its loop.period_s is not that of `own`. */
int options_machine(const char *url, const struct params *own, struct params *machine, struct error *error);

/* Returns FILE of a URL sim:FILE, with or without prefixed faults; NULL if it names no file. */
const char *options_machine_file(const char *url);

/* Returns true if --set gives this key. */
bool options_sets(const struct options *o, const char *key);

/* Reports on stderr that --set overrules what the files of this path state. stated: "x:
 * frequency_hz 5" or "1_x.csv: frequency_hz 5; 2_y.csv: amplitude 0.004"; "": reports nothing. */
void cli_say_overruled(const char *path, const char *stated);

/* Calls options_params() and opens the bus of lcm.url. Returns -2 for a wrong configuration or an
 * empty lcm.url, -3 if the bus cannot be opened. */
struct bus;
int options_bus(const struct options *o, struct params *params, struct bus **bus, struct error *error);

/* SAFETY: a machine that is not simulated moves without a command only if this command line says so
 * (--set motion.automatic=true); a configuration file with that key may be a copy of the
 * simulation's file. Without that option, clears motion.automatic in params, and the platform waits
 * for `hexid command engage`. */
void options_automatic(const struct options *o, bool simulated, struct params *params);

/* Prints a line, in printable form (printable.h) because its text may come from anywhere. At most
 * 4000 bytes. */
__attribute__((format(printf, 2, 3))) void cli_say(FILE *out, const char *format, ...);

/* Prints "hexid: message" and returns the exit status. */
int cli_fail(const struct error *error);

/* Warns that a log was readable only up to the byte `offset`. */
void cli_warn_cut(const char *path, int64_t offset);

int cmd_run(int argc, char **argv);
int cmd_plant(int argc, char **argv);
int cmd_identify(int argc, char **argv);
int cmd_report(int argc, char **argv);
int cmd_check(int argc, char **argv);
int cmd_gap(int argc, char **argv);
int cmd_import(int argc, char **argv);
int cmd_export(int argc, char **argv);
int cmd_command(int argc, char **argv);
int cmd_monitor(int argc, char **argv);
int cmd_doctor(int argc, char **argv);
int cmd_effects(int argc, char **argv);
int cmd_tune(int argc, char **argv);
int cmd_qualify(int argc, char **argv);

#endif
