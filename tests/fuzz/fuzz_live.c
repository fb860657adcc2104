/* libFuzzer: any bytes as a message on each channel that the live page listens to. Its output must
 * be JSON. */
#include <assert.h>
#include <jansson.h>
#include <stdlib.h>
#include <string.h>

#include "config.h"
#include "live_state.h"
#include "messages.h"
#include "params.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void is_json(const struct json_text *j) {
    json_t *root = json_loadb(j->text, j->size, 0, NULL);
    assert(root && !j->failed);
    json_decref(root);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static const char *const channels[] = {CHANNEL_STATE,          CHANNEL_EVENT,    CHANNEL_LOOP_STATS, CHANNEL_TEST_RESULT,
                                           CHANNEL_IDENTIFICATION, CHANNEL_METHOD_C, CHANNEL_GAP};
    static struct params params;
    static struct live_state fresh, s;
    struct error error;
    if (!fresh.params) config_default(&params);
    if (!fresh.params && live_state_init(&fresh, &params, &error)) abort();
    s = fresh;
    struct bus_message m = {.data = data, .size = (int)size};
    for (size_t i = 0; i < sizeof channels / sizeof *channels; i++) {
        strcpy(m.channel, channels[i]);
        live_state_take(&s, &m, 0);
    }
    if (s.cycles) is_json(&s.cycle[s.cycles % LIVE_CYCLES]);
    if (s.events) is_json(&s.event[s.events % LIVE_EVENTS]);
    for (int i = 0; i < LIVE_PLACES; i++)
        if (s.place[i].size) is_json(&s.place[i]);
    s.machine = (struct json_text){0}; /* `fresh` owns that text */
    live_state_free(&s);
    return 0;
}
