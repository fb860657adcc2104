#include "log_params.h"

#include <math.h>
#include <string.h>

#include "config.h"
#include "csv_stated.h"
#include "log.h"
#include "messages.h"

/* Gets the text of the configuration from a log's first event. Returns false if that event is no
 * configuration. */
static bool text_of(const struct log_event *event, const char **text, size_t *size) {
    return !strcmp(event->channel, CHANNEL_EVENT) && event_decode_config(event->data, event->size, text, size);
}

int log_params_own(const char *path, const struct log_event *event, const char *otherwise, struct params *params, struct error *error) {
    const char *text;
    size_t size;
    if (!text_of(event, &text, &size))
        return error_set(error, STATUS_IO, "%.250s: its first event is no configuration: %s", path, otherwise);
    return config_parse(params, text, size, path, error);
}

int log_params_tests(const struct options *o, const char *path, const struct log_event *event, struct params *params, struct error *error) {
    const char *text = NULL;
    size_t size = 0;
    if (!text_of(event, &text, &size)) text = NULL;
    struct error unreadable;
    int status = config_take_tests(params, text, size, path, o->settings, o->setting_count, &unreadable, error);
    if (!status && unreadable.text[0])
        cli_say(stderr, "hexid: warning: the log's own configuration cannot be read: %s; the tests are those of -c and --set",
                unreadable.text);
    return status;
}

int log_params(const struct options *o, const char *path, const struct log_event *event, struct params *params,
               struct test_params *configured, struct error *error) {
    int status = o->config ? options_params(o, params, error) : log_params_own(path, event, "give one with -c FILE", params, error);
    if (!status && !o->config) status = config_override(params, path, o->settings, o->setting_count, error);
    if (status) return status;
    if (configured) *configured = params->tests;
    return o->config ? log_params_tests(o, path, event, params, error) : STATUS_OK;
}

void log_params_follow(const struct options *o, const char *path, const struct log_event *event, const struct test_params *own,
                       struct test_params *tests) {
    struct csv_stated s;
    char text[64];
    if (strcmp(event->channel, CHANNEL_EVENT) || !csv_stated_decode(event->data, event->size, &s)) return;
    bool frequency = s.key == CSV_STATED_FREQUENCY;
    if (!options_sets(o, frequency ? "tests.frequency_hz" : s.dof < DOF_PHI ? "tests.amplitude_m" : "tests.amplitude_rad")) {
        csv_stated_take(&s, own, tests);
        return;
    }
    snprintf(text, sizeof text, "%s: %s %g", dof_names[s.dof], csv_stated_name(s.key), s.value);
    if (path && !isnan(s.value) && s.value != (frequency ? tests->hz[s.dof] : tests->amplitude[s.dof])) cli_say_overruled(path, text);
}
