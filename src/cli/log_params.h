/* The configuration with which a log is evaluated. One rule for all commands that read logs:
 *
 *   - The machine is that of -c; without -c that of the log's own configuration.
 *   - The tests are those of the log, whatever -c says of tests: the log's configuration states
 *     what hexid drove, or for an imported log what its files and the configuration at import
 *     state. A key of tests that the log does not state (csv.h) is taken from -c.
 *   - --set stands above both.
 *
 * Main thread. */
#ifndef HEXID_LOG_PARAMS_H
#define HEXID_LOG_PARAMS_H

#include "cli.h"
#include "params.h"

struct log_event;

/* Reads the log's own configuration from its first event. Returns -2 for an impossible
 * configuration; -3 if that event is no configuration, with a message that ends with `otherwise`
 * (the remedy, or the consequence). */
int log_params_own(const char *path, const struct log_event *event, const char *otherwise, struct params *params, struct error *error);

/* Replaces the tests of -c, which are in params, by those of the log. If the log has no
 * configuration, or one that cannot be read, which causes a warning, the tests of -c stay. Returns
 * -2 if the tests contradict the rest of the configuration. */
int log_params_tests(const struct options *o, const char *path, const struct log_event *event, struct params *params, struct error *error);

/* Finds the configuration for a log by the rule above. configured: gets the tests to write into a
 * new configuration file, which are those of -c, or without -c those of the log's configuration,
 * with --set applied; NULL: they are not needed. Returns 0, -2 or -3. */
int log_params(const struct options *o, const char *path, const struct log_event *event, struct params *params,
               struct test_params *configured, struct error *error);

/* Follows the event with which an imported log marks where the rows of the next file begin
 * (csv_stated.h): sets frequency or amplitude of a test to the value that this file states, or back
 * to that of `own` if it states none. Any other event changes nothing. A value of --set stays, and
 * cli_say_overruled() reports the file's value if it differs, unless path is NULL. */
void log_params_follow(const struct options *o, const char *path, const struct log_event *event, const struct test_params *own,
                       struct test_params *tests);

#endif
