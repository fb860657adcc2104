/* libFuzzer: any bytes as a message of LCM: commands, events, states. What is accepted must be something a cycle or a command can be, and
 * a state must come out of it as it went in. */
#include <assert.h>
#include <stddef.h>
#include <string.h>

#include "messages.h"
#include "supervisor.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void command(const uint8_t *data, int size) {
    enum command command = COMMAND_NONE;
    bool good = command_decode(data, size, &command);
    assert(good == (command >= COMMAND_ENGAGE && command <= COMMAND_RESET));
    if (good) assert(!strcmp((const char *)data + size - strlen(command_names[command]) - 1, command_names[command]));
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

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    command(data, (int)size);
    event(data, (int)size);
    state(data, (int)size);
    return 0;
}
