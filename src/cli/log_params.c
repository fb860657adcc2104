#include "log_params.h"

#include <math.h>
#include <string.h>

#include "config.h"
#include "csv_stated.h"
#include "log.h"
#include "messages.h"

/* Gets the text of the configuration in a log's first event. Returns false if it has none. */
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
    return config_take_tests(params, text, size, path, o->settings, o->setting_count, error);
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
    enum dof dof;
    double stated_hz;
    char stated[64];
    if (strcmp(event->channel, CHANNEL_EVENT) || !csv_stated_decode(event->data, event->size, &dof, &stated_hz)) return;
    if (!options_sets(o, "tests.frequency_hz")) {
        tests->hz[dof] = isnan(stated_hz) ? own->hz[dof] : stated_hz;
        return;
    }
    snprintf(stated, sizeof stated, "%s: frequency_hz %g", dof_names[dof], stated_hz);
    if (tests->hz[dof] != stated_hz && !isnan(stated_hz)) cli_say_overruled(path, stated);
}
