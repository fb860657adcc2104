/* Commands from programs of this host to the daemon, and the daemon's answers, as packets of a
 * SOCK_SEQPACKET socket. Whatever came off a socket is untrusted until decoded: decode returns
 * false, and leaves its result alone, unless the packet is whole and valid. Big-endian. Ordinary
 * threads, no heap.
 *
 * Numbers in parentheses are the fields' sizes in bytes:
 * request, 16 bytes: "HEXC", version (2), command (1; enum command, 0 with renew), renew (1; 0 or
 *     1), id (4), zero (4)
 *     COMMAND_SET with new gains continues: digest of the configuration (8), gains that the client
 *     believes to be in use (5 x 8), new gains (5 x 8), IEEE 754. A COMMAND_SET without these
 *     fields changes nothing; its answer states the gains in use
 * answer, 512 bytes: "HEXA", version (2), outcome (1), state (1), id (4), lease in ms (4), text
 *     (496, ended by zeros) */
#ifndef HEXID_COMMAND_PACKET_H
#define HEXID_COMMAND_PACKET_H

#include <stddef.h>

#include "types.h"

enum {
    COMMAND_VERSION = 1,
    COMMAND_REQUEST_SIZE = 16,
    COMMAND_SET_SIZE = COMMAND_REQUEST_SIZE + 8 + 2 * 8 * LOOP_GAINS,
    COMMAND_ANSWER_SIZE = 512,
    COMMAND_TEXT_SIZE = COMMAND_ANSWER_SIZE - 16,
};

struct command_request {
    uint32_t id;          /* the client chooses it, and the answer repeats it */
    enum command command; /* the command; COMMAND_NONE if `renew` is set */
    bool renew;           /* the request renews the sender's lease */
    bool sets;            /* true: COMMAND_SET with new gains in `change`; false: COMMAND_SET that
                           * only queries the gains in use */
    struct gain_change {
        uint64_t digest;        /* config_digest() of the client's configuration */
        struct gains from, to;  /* gains that the client believes to be in use, and the new ones */
    } change;
};

/* OUTCOME_STOPPED: the lease is renewed, but somebody's stop ended the tests begun last.
 * OUTCOME_ENDED: the daemon's last packet, not an answer (id 0): nothing is driven any more, and
 * the daemon ends in this state. */
enum outcome { OUTCOME_DONE, OUTCOME_STOPPED, OUTCOME_REFUSED, OUTCOME_ENDED, OUTCOMES };

struct command_answer {
    uint32_t id;
    double lease_s; /* time without renewal after which the machine is parked; 0: no lease */
    enum outcome outcome;
    enum state state;
    char text[COMMAND_TEXT_SIZE]; /* reason for the outcome, and the remedy */
};

/* Returns the size of the packet. */
size_t command_request_encode(const struct command_request *request, unsigned char packet[COMMAND_SET_SIZE]);

/* SAFETY: accepts a stop or park from a client of any version; the first 12 bytes of a request
 * never change. */
bool command_request_decode(const unsigned char *packet, size_t size, struct command_request *request);

void command_answer_encode(const struct command_answer *answer, unsigned char packet[COMMAND_ANSWER_SIZE]);
bool command_answer_decode(const unsigned char *packet, size_t size, struct command_answer *answer);

#endif
