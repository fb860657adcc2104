/* libFuzzer: any bytes as a datagram, as text, as an LCM message (commands, events, states,
 * results) and as a packet of a command socket. An accepted message must be a possible cycle or
 * command, and a state must be re-encoded unchanged. */
#include <assert.h>
#include <stddef.h>
#include <string.h>

#include "bus.h"
#include "command_packet.h"
#include "messages.h"
#include "printable.h"
#include "supervisor.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void command(const uint8_t *data, int size) {
    enum command c = COMMAND_NONE;
    if (!command_decode(data, size, &c)) return;
    assert(command_stops(c) && !strcmp((const char *)data + size - strlen(command_names[c]) - 1, command_names[c]));
}

/* Reads the data as packets of a command socket. Only a whole packet yields a command that moves,
 * and encoding it again gives the same packet. */
static void packets(const uint8_t *data, size_t size) {
    unsigned char packet[COMMAND_ANSWER_SIZE];
    struct command_request r;
    struct command_answer a;
    if (command_request_decode(data, size, &r)) {
        assert(r.renew ? r.command == COMMAND_NONE : r.command > COMMAND_NONE && r.command < COMMANDS);
        command_request_encode(&r, packet);
        assert(command_stops(r.command) || !memcmp(packet, data, 12));
    }
    if (command_answer_decode(data, size, &a))
        assert(a.outcome < OUTCOMES && a.state < STATES && a.lease_s >= 0.0 && strlen(a.text) < COMMAND_TEXT_SIZE);
}

/* Parses a datagram; the result must lie within it. */
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

/* Checks that text made printable is no longer than before, has no control characters, and stays
 * unchanged when made printable again. */
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
    command(data, (int)size);
    packets(data, size);
    printable(data, size);
    results(data, (int)size);
    event(data, (int)size);
    state(data, (int)size);
    return 0;
}
