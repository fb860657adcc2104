/* The ways by which commands reach the daemon, and the operator's side that decides (operator.h):
 * this machine's sockets, and stop and park over LCM. Main thread; opened before the daemon
 * confines itself, and nothing blocks afterwards. */
#ifndef HEXID_COMMANDS_H
#define HEXID_COMMANDS_H

#include "bus.h"
#include "command_server.h"
#include "operator.h"

enum { COMMANDS_POLLS = COMMAND_POLLS + 1 };

struct commands {
    struct command_server server;
    struct command_handler handler;
    struct operator operator;
    struct bus *bus; /* NULL: no LCM */
    bool listens;    /* to the bus */
    int64_t now_ns;  /* of this turn */
    int64_t look_ns; /* when to look for the sockets' files again, */
    enum command_socket missing; /* and what was missing then; COMMAND_SOCKETS: nothing */
    /* Called with what an operator at the terminal should know. */
    void (*say)(void *context, const char *text);
    void *context;
};

/* Marks everything as not open, so that commands_close() may be called at any time. */
void commands_init(struct commands *c);

/* Opens the sockets of the machine params->machine.name and listens on the bus, if there is one.
 * *doubt: what does not work though hexid may run (status STATUS_OK: nothing). STATUS_UNSAFE: the
 * name is another's; STATUS_USAGE: lcm.remote_stop. */
int commands_open(struct commands *c, const struct params *params, struct bus *bus, struct error *doubt, struct error *error);

/* Connects the operator's side to the loop, which is about to run. */
void commands_begin(struct commands *c, const struct params *params, struct loop *loop, void (*say)(void *, const char *), void *context);

void commands_polls(const struct commands *c, struct pollfd polls[COMMANDS_POLLS]);

/* Returns how long poll() may wait, ms. */
int commands_patience_ms(const struct commands *c);

/* After poll(), at this time (CLOCK_MONOTONIC). SAFETY: between what came and the loop's mailbox
 * stands nothing that can block. */
void commands_serve(struct commands *c, const struct pollfd polls[COMMANDS_POLLS], int64_t now_ns);

/* Tells every client in which state the loop has ended, and closes the sockets. */
void commands_close(struct commands *c);

#endif
