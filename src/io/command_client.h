/* Client end of a machine's command socket: one connection, one request at a time. Waits are
 * bounded and end at once if the daemon ends. */
#ifndef HEXID_COMMAND_CLIENT_H
#define HEXID_COMMAND_CLIENT_H

#include <signal.h>

#include "command_packet.h"
#include "machine_name.h"

struct command_client {
    struct machine_name machine;
    int fd;                       /* socket of the connection; -1: not connected */
    uint32_t id;                  /* id of the last request */
    struct command_answer answer; /* last answer received, with the platform's state at that time */
    bool answered;                /* true if `answer` is valid */
};

/* Connects to the machine's socket NAME.stop (`stop`) or NAME; retries for patience_ms while the
 * daemon is busy. Returns 0, or -1 with errno as machine_connect(). */
int command_client_open(struct command_client *c, const struct machine_name *m, bool stop, int patience_ms);

/* Replaces the connection, if any, by a new one; keeps the last answer. On failure nothing changes.
 * Returns as command_client_open(). */
int command_client_reopen(struct command_client *c, bool stop, int patience_ms);

void command_client_close(struct command_client *c);

/* Sends a request. Returns 0, or -1 if the connection does not take it, mostly because it has
 * ended. */
int command_client_send(struct command_client *c, enum command command, bool renew);
int command_client_send_gains(struct command_client *c, const struct gain_change *change);

/* Result of a wait. LEFT: the daemon has ended regularly, and c->answer has its last state
 * (OUTCOME_ENDED). LOST: the connection ended without such a last answer. */
enum command_news { NEWS_NONE, NEWS_ANSWER, NEWS_LEFT, NEWS_LOST };

/* Waits at most patience_ms for the answer to the last request; the answer is then in c->answer.
 * mask: signals blocked meanwhile (ppoll(2)); any other signal ends the wait with NEWS_NONE. With
 * mask NULL no signal ends the wait. */
enum command_news command_client_wait(struct command_client *c, int patience_ms, const sigset_t *mask);

#endif
