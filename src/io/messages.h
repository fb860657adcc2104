/* Between the structs of include/ and LCM's wire types. Whatever came off the wire or a disk is untrusted until converted: decode
 * returns false for a message of the wrong size, type, or with values that no cycle can have. Ordinary threads, no heap for state. */
#ifndef HEXID_MESSAGES_H
#define HEXID_MESSAGES_H

#include "types.h"

#define CHANNEL_STATE "HEXID_STATE"
#define CHANNEL_LOOP_STATS "HEXID_LOOP_STATS"
#define CHANNEL_TEST_RESULT "HEXID_TEST_RESULT"
#define CHANNEL_IDENTIFICATION "HEXID_IDENTIFICATION"
#define CHANNEL_EVENT "HEXID_EVENT"
#define CHANNEL_COMMAND "HEXID_COMMAND"

enum { STATE_MESSAGE_MAX = 600 };

/* Returns the size. */
int state_encode(const struct cycle *cycle, unsigned char buffer[STATE_MESSAGE_MAX]);
bool state_decode(const void *data, int size, struct cycle *cycle);

/* An event of `kind` ("config", "state", "fault", "test", "note", "lost"); returns the size, or -1 when it does not fit. */
int event_encode(int64_t time_ns, uint64_t seq, const char *kind, const char *text, unsigned char *buffer, int capacity);

#endif
