#include "csv_input.h"

#include <limits.h>
#include <stdlib.h>
#include <unistd.h>

#include "config.h"
#include "params.h"

/* Refuses -c and --set for a directory that contains a configuration, because that configuration
 * would override them without a message. */
static int one_configuration(const struct options *o, const char *directory, struct error *error) {
    char path[PATH_MAX];
    snprintf(path, sizeof path, "%s/config.yaml", directory);
    if ((!o->config && !o->setting_count) || access(path, F_OK)) return STATUS_OK;
    return error_set(error, STATUS_USAGE, "%.300s is the run's configuration: change or remove it, or leave -c and --set out", path);
}

int csv_input_begin(struct csv_input *input, const struct options *o, const char *directory, struct error *error) {
    struct params params;
    *input = (struct csv_input){.source = {.path = directory}};
    int status = o->map ? csv_map_parse(&input->map, o->map, error) : STATUS_OK;
    if (!status) status = one_configuration(o, directory, error);
    if (!status) status = options_params(o, &params, error);
    if (status) return status;
    if (o->map) input->source.map = &input->map;
    input->source.configured = o->config;
    input->source.settings = o->settings, input->source.setting_count = o->setting_count;
    input->source.base = input->base = config_text(&params);
    return input->base ? STATUS_OK : error_set(error, STATUS_IO, "out of memory");
}

void csv_input_end(struct csv_input *input) {
    free(input->base);
    input->base = NULL;
}
