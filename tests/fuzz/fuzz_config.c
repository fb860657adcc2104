/* libFuzzer: any bytes as a configuration file and as --set. An accepted configuration printed as
 * text reads back bit for bit. */
#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "config.h"
#include "params.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void reads_back(const struct params *params) {
    static struct params again;
    struct error error;
    char *text = config_text(params);
    assert(text && config_parse(&again, text, strlen(text), "again", &error) == STATUS_OK);
    assert(!memcmp(params, &again, sizeof again));
    free(text);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static struct params params;
    struct error error = {0};
    int status = config_parse(&params, (const char *)data, size, "fuzz", &error);
    assert(status == STATUS_OK || (status == STATUS_USAGE && error.text[0]));
    if (!status) reads_back(&params);
    if (size < 200) {
        char setting[201] = "";
        const char *settings[] = {setting};
        memcpy(setting, data, size);
        if (!config_load(&params, NULL, settings, 1, &error)) reads_back(&params);
    }
    return 0;
}
