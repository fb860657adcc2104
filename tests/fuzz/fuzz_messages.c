/* libFuzzer: any bytes as a datagram, as text, and as a message of LCM: requests, answers, events, states, results. What is
 * accepted must be something a cycle or a command can be, and a state must come out of it as it went in. */
#include <assert.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <jansson.h>

#include "bus.h"
#include "config.h"
#include "live_state.h"
#include "messages.h"
#include "printable.h"
#include "supervisor.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void request(const uint8_t *data, int size) {
    struct operator_request r = {0};
    bool good = request_decode(data, size, &r);
    assert(good == (r.renew || (r.command >= COMMAND_ENGAGE && r.command <= COMMAND_RESET)));
    const char *word = r.renew ? "renew" : command_names[r.command];
    if (good) assert(!strcmp((const char *)data + size - strlen(word) - 1, word));
}

static void answer(const uint8_t *data, int size) {
    struct answer a = {0};
    if (!answer_decode(data, size, &a)) return;
    assert(a.outcome < OUTCOMES && a.state < STATES && a.lease_s >= 0.0 && strlen(a.text) < (size_t)size);
}

/* As a datagram: what is taken lies within it. */
static void datagram(const uint8_t *data, int size) {
    struct bus_message m;
    if (!bus_parse(data, size, &m)) return;
    assert(strlen(m.channel) < BUS_CHANNEL_SIZE && m.size >= 0 && m.data + m.size == data + size && m.data > data);
}

static void event(const uint8_t *data, int size) {
    struct event e = {0};
    const char *text = NULL;
    size_t length = 0;
    if (event_decode(data, size, &e)) assert(strlen(e.kind) + strlen(e.text) + 2 <= (size_t)size);
    if (event_decode_config(data, size, &text, &length)) assert(text[length] == '\0');
}

static void state(const uint8_t *data, int size) {
    unsigned char again[STATE_MESSAGE_MAX];
    struct cycle c;
    if (!state_decode(data, size, &c)) return;
    assert(c.state < STATES && (int)c.dof >= -1 && (int)c.dof < DOFS && c.test >= -1);
    assert(state_encode(&c, again) == size && !memcmp(again, data, (size_t)size));
}

static bool within(const char *text, const uint8_t *data, int size) {
    const uint8_t *p = (const uint8_t *)text;
    return p > data && p < data + size && memchr(p, '\0', (size_t)(data + size - p));
}

static void results(const uint8_t *data, int size) {
    struct test_summary t;
    struct gap_summary g;
    if (test_result_decode(data, size, &t)) assert(within(t.dof_name, data, size));
    if (gap_decode(data, size, &g)) assert(within(g.verdict, data, size) && within(g.reason, data, size));
}

static void is_json(const struct json_text *j) {
    json_t *root = json_loadb(j->text, j->size, 0, NULL);
    assert(root && !j->failed);
    json_decref(root);
}

/* On any channel: what the live page makes of it is JSON. */
static void shown(const uint8_t *data, int size) {
    static const char *const channels[] = {CHANNEL_STATE, CHANNEL_EVENT, CHANNEL_LOOP_STATS, CHANNEL_TEST_RESULT, CHANNEL_IDENTIFICATION,
                                           CHANNEL_METHOD_C, CHANNEL_GAP};
    static struct params params;
    static struct live_state fresh, s;
    struct error error;
    if (!fresh.params) config_default(&params);
    if (!fresh.params && live_state_init(&fresh, &params, &error)) abort();
    s = fresh;
    struct bus_message m = {.data = data, .size = size};
    for (size_t i = 0; i < sizeof channels / sizeof *channels; i++) {
        strcpy(m.channel, channels[i]);
        live_state_take(&s, &m, 0);
    }
    if (s.cycles) is_json(&s.cycle[s.cycles % LIVE_CYCLES]);
    if (s.events) is_json(&s.event[s.events % LIVE_EVENTS]);
    for (int i = 0; i < LIVE_PLACES; i++)
        if (s.place[i].size) is_json(&s.place[i]);
    s.machine = (struct json_text){0}; /* the fresh one's */
    live_state_free(&s);
}

/* Any text, made printable, is at most as long, has no control characters, and is printable as it is. */
static void printable(const uint8_t *data, size_t size) {
    char text[200], out[sizeof text], again[sizeof text];
    size_t length = size < sizeof text ? size : sizeof text - 1;
    memcpy(text, data, length);
    text[length] = '\0';
    size_t printed = text_printable(text, out, sizeof out);
    assert(printed <= strlen(text) && strlen(out) == printed);
    for (size_t i = 0; i < printed; i++) assert((unsigned char)out[i] >= 0x20 && out[i] != 0x7f);
    assert(text_printable(out, again, sizeof again) == printed && !strcmp(out, again));
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    datagram(data, (int)size);
    request(data, (int)size);
    answer(data, (int)size);
    printable(data, size);
    results(data, (int)size);
    shown(data, (int)size);
    event(data, (int)size);
    state(data, (int)size);
    return 0;
}
