/* The daemon's end of its two command sockets (machine.h): connections, and the packets that come
 * over them. What is asked is decided elsewhere (operator.h). Main thread; opened before the daemon
 * confines itself, and nothing here blocks.
 *
 * SAFETY: a stop passes whatever else comes. NAME.stop has places of its own; a wake takes one
 * packet of each connection and a bounded number of new connections; when all places are taken, a
 * connection of the user who has most of them makes room, the one that was silent for longest; and
 * no connection is closed before a packet that waits in it was taken. Who does not read its answers
 * is closed. Where no connection can be accepted and none makes room (descriptors or memory are
 * short), the listener is left out of the next poll(), which then ends by its time and does not
 * spin. */
#ifndef HEXID_COMMAND_SERVER_H
#define HEXID_COMMAND_SERVER_H

#include <poll.h>
#include <sys/types.h>

#include "command_packet.h"
#include "machine.h"

enum command_socket { SOCKET_STOP, SOCKET_ALL, COMMAND_SOCKETS };
enum {
    COMMAND_PLACES = 32, /* connections of each socket */
    COMMAND_POLLS = COMMAND_SOCKETS * (1 + COMMAND_PLACES),
};

/* Callbacks for what was received. A peer is one connection: a number from 1 on, never used
 * twice. */
struct command_handler {
    void *context;
    /* A request; may_move: it came over NAME, which the kernel opens to the group alone. */
    void (*take)(void *context, uint64_t peer, const struct command_request *request, bool may_move);
    void (*gone)(void *context, uint64_t peer);
    /* Tells whether this peer waits for an answer or holds a lease; then its connection is not
     * closed to make room. */
    bool (*needs)(void *context, uint64_t peer);
};

struct command_place {
    int fd; /* -1: free */
    uint64_t peer;
    uid_t user;
    int64_t heard; /* count of packets and connections when it was last heard */
    bool broken;   /* it does not read its answers */
};

struct command_server {
    struct machine machine;
    int lock, listener[COMMAND_SOCKETS]; /* -1: not open */
    struct {
        dev_t device;
        ino_t inode;
    } file[COMMAND_SOCKETS];       /* that the listener was bound to */
    bool rests[COMMAND_SOCKETS];   /* the listener, for one poll() */
    struct command_place place[COMMAND_SOCKETS][COMMAND_PLACES];
    uint64_t peers;
    int64_t heard;
    const struct command_handler *handler;
};

/* Marks everything as not open, so that close() may be called before open(). */
void command_server_init(struct command_server *s);

/* Calls machine_claim() and opens both sockets: NAME.stop for everybody, NAME for its user
 * and, if the daemon may give it to that group, for group hexid. The handler must outlive the
 * server. */
int command_server_open(struct command_server *s, const char *name, const struct command_handler *handler, struct error *error);

/* Descriptors to poll; those of free places are -1. */
void command_server_polls(const struct command_server *s, struct pollfd polls[COMMAND_POLLS]);

/* Returns the first socket whose file was deleted or replaced, so that no client can connect to it,
 * or COMMAND_SOCKETS: none. Looks two paths up, in a local file system. */
enum command_socket command_server_missing(const struct command_server *s);

/* After poll(): packets of NAME.stop first. Returns how many packets and new connections were
 * taken. */
int command_server_serve(struct command_server *s, const struct pollfd polls[COMMAND_POLLS]);

/* Sends an answer. Does nothing if the peer is gone. */
void command_server_answer(struct command_server *s, uint64_t peer, const struct command_answer *answer);

/* Sends a last answer to all who are connected or wait to be, and closes the sockets, so that
 * later clients find no daemon. */
void command_server_close(struct command_server *s, const struct command_answer *last_words);

#endif
