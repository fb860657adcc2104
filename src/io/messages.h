/* Converts between the structs of include/ and LCM's wire types (lcmtypes/README.md). Data from
 * the wire or a disk are untrusted until converted: decode returns false, and leaves its result
 * alone, for a message of the wrong size or type, or with values that no cycle can have. Sensor
 * readings may be anything, even NaN, because a log must preserve samples flagged invalid.
 * Ordinary threads, no heap. */
#ifndef HEXID_MESSAGES_H
#define HEXID_MESSAGES_H

#include <stddef.h>

#include "types.h"

#define CHANNEL_STATE "HEXID_STATE"
#define CHANNEL_LOOP_STATS "HEXID_LOOP_STATS"
#define CHANNEL_TEST_RESULT "HEXID_TEST_RESULT"
#define CHANNEL_IDENTIFICATION "HEXID_IDENTIFICATION"
#define CHANNEL_METHOD_C "HEXID_METHOD_C"
#define CHANNEL_EVENT "HEXID_EVENT"
#define CHANNEL_GAP "HEXID_GAP"
#define CHANNEL_COMMAND "HEXID_COMMAND"

enum { STATE_MESSAGE_MAX = 600, COMMAND_MESSAGE_MAX = 64 };

/* Casts a constant text for a generated encoder, which only reads it but takes a char *. */
static inline char *lcm_text(const char *constant) { return (char *)(uintptr_t)constant; }

/* Encodes a cycle and returns the message's size. Decoding gives the same values, bit for bit;
 * fields that the message does not carry become 0, except `measure`, which becomes leg -1 and
 * NaN. */
int state_encode(const struct cycle *cycle, unsigned char buffer[STATE_MESSAGE_MAX]);
bool state_decode(const void *data, int size, struct cycle *cycle);

struct event {
    int64_t time_ns;
    uint64_t seq;
    const char *kind;  /* kind of the event, as listed in lcmtypes/README.md */
    const char *text;
};

/* Encodes an event. Returns the message's size, or -1 if it does not fit. */
int event_encode(int64_t time_ns, uint64_t seq, const char *kind, const char *text, unsigned char *buffer, int capacity);

/* Decodes an event; kind and text point into data. */
bool event_decode(const void *data, int size, struct event *event);

/* Returns the text of an event of kind "config", pointing into data; false for any other event. */
bool event_decode_config(const void *data, int size, const char **text, size_t *length);

/* Fields of a test's result that a monitor shows; dof_name points into data. */
struct test_summary {
    const char *dof_name;
    double amplitude_m_or_rad, achieved_m_or_rad, phase_deg;
    int64_t samples, excluded;
};
bool test_result_decode(const void *data, int size, struct test_summary *summary);

/* Fields of a result of hexid gap that a monitor shows; the strings point into data. */
struct gap_summary {
    const char *verdict, *reason;
    double held_out_before_ratio, held_out_after_ratio, noise_floor_ratio;
};
bool gap_decode(const void *data, int size, struct gap_summary *summary);

/* Encodes stop or park for CHANNEL_COMMAND (hexid_command_t); LCM carries no other commands.
 * Returns the size. */
int command_encode(enum command command, int64_t time_ns, unsigned char buffer[COMMAND_MESSAGE_MAX]);

/* Reads a command. Returns false for anything but stop and park. */
bool command_decode(const void *data, int size, enum command *command);

#endif
