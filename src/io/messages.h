/* Conversion between the structs of include/ and LCM's wire types (lcmtypes/README.md). Whatever
 * came off the wire or a disk is untrusted until converted: decode returns false, and leaves its
 * result alone, for a message of the wrong size or type, or with values that no cycle can have.
 * Readings of sensors may be anything, NaN too: a sample flagged invalid must survive its log.
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
#define CHANNEL_ANSWER "HEXID_ANSWER"

enum { STATE_MESSAGE_MAX = 600, COMMAND_MESSAGE_MAX = 64 };

/* Returns the size. Encode and decode give back the same cycle, bit for bit. */
int state_encode(const struct cycle *cycle, unsigned char buffer[STATE_MESSAGE_MAX]);
bool state_decode(const void *data, int size, struct cycle *cycle);

struct event {
    int64_t time_ns;
    uint64_t seq;
    const char *kind;  /* lcmtypes/README.md lists them */
    const char *text;
};

/* Returns the size, or -1 when it does not fit. */
int event_encode(int64_t time_ns, uint64_t seq, const char *kind, const char *text, unsigned char *buffer, int capacity);

/* kind and text point into data. */
bool event_decode(const void *data, int size, struct event *event);

/* The text of an event of the kind "config", pointing into data; false for any other. */
bool event_decode_config(const void *data, int size, const char **text, size_t *length);

/* What a monitor shows of a result of one test; dof_name points into data. */
struct test_summary {
    const char *dof_name;
    double amplitude_m_or_rad, achieved_m_or_rad, phase_deg;
    int64_t samples, excluded;
};
bool test_result_decode(const void *data, int size, struct test_summary *summary);

/* What a monitor shows of a result of hexid gap; the strings point into data. */
struct gap_summary {
    const char *verdict, *reason;
    double held_out_before_ratio, held_out_after_ratio, noise_floor_ratio;
};
bool gap_decode(const void *data, int size, struct gap_summary *summary);

/* A command of an operator, on CHANNEL_COMMAND: request_t, or command_t, which has neither id nor
 * token. `renew` prolongs a lease. */
struct operator_request {
    int64_t id;          /* the sender's, returned in the answer; 0: wants no answer */
    int64_t token;       /* from an answer; 0: none yet */
    enum command command;/* COMMAND_NONE with renew */
    bool renew;
};

/* Returns the size. */
int request_encode(const struct operator_request *request, unsigned char buffer[COMMAND_MESSAGE_MAX]);

/* False for anything but engage, start, stop, park, reset and renew in either type. */
bool request_decode(const void *data, int size, struct operator_request *request);

/* The answer to a request, on CHANNEL_ANSWER. OUTCOME_STOPPED: the lease is renewed, but somebody's
 * stop ended the tests begun last. OUTCOME_TOKEN: ask again with the token that comes with it. */
enum outcome { OUTCOME_DONE, OUTCOME_STOPPED, OUTCOME_REFUSED, OUTCOME_TOKEN, OUTCOMES };
struct answer {
    int64_t id, token;   /* OUTCOME_TOKEN: for the next request; after engage, start or renew: the
                          * lease's */
    double lease_s;      /* without a renewal for so long the machine is parked; 0: no lease is
                          * needed */
    enum outcome outcome;
    enum state state;
    const char *text;    /* why, and what to do first */
};

/* Returns the size, -1 when it does not fit. */
enum { ANSWER_MESSAGE_MAX = 512 };
int answer_encode(const struct answer *answer, unsigned char buffer[ANSWER_MESSAGE_MAX]);

/* text points into data. */
bool answer_decode(const void *data, int size, struct answer *answer);

#endif
