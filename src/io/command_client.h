/* An operator's end of a machine's command socket: one connection, one request at a time. Waits are
 * bounded, and end at once when the daemon does. */
#ifndef HEXID_COMMAND_CLIENT_H
#define HEXID_COMMAND_CLIENT_H

#include <signal.h>

#include "command_packet.h"
#include "machine.h"

struct command_client {
    struct machine machine;
    int fd;                       /* -1: not connected */
    uint32_t id;                  /* of the last request */
    struct command_answer answer; /* the last that came: of what the platform did then */
    bool answered;                /* there is one */
};

/* Connects, trying again for so long while the daemon is not given the processor. 0, or -1 with
 * errno as machine_connect(). */
int command_client_open(struct command_client *c, const struct machine *m, bool stop, int patience_ms);

/* The same again, for one whose connection has ended or which has none: what was heard last is
 * kept. On failure nothing is changed. */
int command_client_reopen(struct command_client *c, bool stop, int patience_ms);

void command_client_close(struct command_client *c);

/* Sends a request. Returns 0, or -1 if the connection has ended. */
int command_client_send(struct command_client *c, enum command command, bool renew);

/* Result of a wait. LEFT: the daemon has ended in good order, and c->answer has its last state
 * (OUTCOME_ENDED). LOST: the connection ended without that. */
enum command_news { NEWS_NONE, NEWS_ANSWER, NEWS_LEFT, NEWS_LOST };

/* Waits at most so long for the answer to the last request, in c->answer then. With a mask: with
 * these signals blocked meanwhile (ppoll(2)), and NEWS_NONE when another one came. */
enum command_news command_client_wait(struct command_client *c, int patience_ms, const sigset_t *mask);

#endif
