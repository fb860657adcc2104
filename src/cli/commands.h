/* Receives commands for the daemon and passes them to operator.h, which decides on them. All
 * commands come through the sockets of the machine `machine.name`; stop and park also come over
 * LCM. Main thread. The sockets are opened before the daemon confines itself, and nothing blocks
 * afterwards. */
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
    struct bus *bus; /* LCM bus; NULL: there is none */
    bool listens;    /* stop and park are received from the bus, too */
    int64_t now_ns;  /* time of the current call of commands_serve() */
    int64_t look_ns; /* time of the next check of the sockets' files */
    /* socket whose file was missing at the last check; COMMAND_SOCKETS: none */
    enum command_socket missing;
    bool starved;    /* at the last check a connection could not be accepted for lack of a
                      * descriptor */
    /* Called with messages for an operator at the terminal. */
    void (*say)(void *context, const char *text);
    void *context;
};

/* Marks everything as closed, so that commands_end() may be called at any time. */
void commands_init(struct commands *c);

/* Opens the sockets of the machine params->machine.name and listens on the bus, if there is one.
 * *doubt: a problem with which hexid can run all the same (status STATUS_OK: none). STATUS_UNSAFE:
 * the name is in use, or the sockets' directory cannot be trusted; STATUS_USAGE: lcm.remote_stop is
 * wrong. */
int commands_open(struct commands *c, const struct params *params, struct bus *bus, struct error *doubt, struct error *error);

/* Connects operator.h to the loop; to be called before the first commands_serve(). say, context:
 * stored in struct commands. */
void commands_begin(struct commands *c, const struct params *params, struct loop *loop, void (*say)(void *, const char *), void *context);

void commands_polls(const struct commands *c, struct pollfd polls[COMMANDS_POLLS]);

/* Returns the longest time for which poll() may wait, ms. */
int commands_patience_ms(const struct commands *c);

/* Receives and passes on commands; to be called after poll(), with the time of CLOCK_MONOTONIC.
 * SAFETY: nothing between a received command and the loop's mailbox can block. */
void commands_serve(struct commands *c, const struct pollfd polls[COMMANDS_POLLS], int64_t now_ns);

/* Sends the loop's final state to every client and ends the connections (command_server_end()). */
void commands_end(struct commands *c);

#endif
