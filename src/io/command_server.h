/* The daemon's end of its two command sockets (machine_name.h): connections and their packets.
 * operator.h decides on the requests. Main thread; opened before the daemon confines itself, and
 * nothing here blocks (except that before Linux 6.16 descriptors sent by a client can block a call;
 * the loop then parks: see local_socket() and loop_attend()).
 *
 * SAFETY: nothing can hold up a stop. NAME.stop has its own places. command_server_serve() takes
 * one packet from each connection and a bounded number of new connections. If all places are taken,
 * a new connection replaces one that is not needed (command_handler.needs): the one that was silent
 * for longest among those of the user with most places. Before a connection is closed, whatever the
 * reason, the stops among the first 64 packets that wait in it are taken. A client that does not
 * read its answers is disconnected. If a connection can be neither accepted nor replaced (no
 * descriptors or memory), the listener is left out of the next poll(), so that the loop does not
 * spin. */
#ifndef HEXID_COMMAND_SERVER_H
#define HEXID_COMMAND_SERVER_H

#include <poll.h>
#include <sys/types.h>

#include "command_packet.h"
#include "machine_name.h"

enum command_socket { SOCKET_STOP, SOCKET_ALL, COMMAND_SOCKETS };
enum {
    COMMAND_PLACES = 32, /* number of connections that each socket serves */
    COMMAND_POLLS = COMMAND_SOCKETS * (1 + COMMAND_PLACES),
};

/* Callbacks for requests and ended connections. A peer is a connection: a number from 1, never used
 * twice. */
struct command_handler {
    void *context;
    /* Takes a request. may_move: the request came over socket NAME, to which the kernel lets only
     * the daemon's user, root and group hexid connect. */
    void (*take)(void *context, uint64_t peer, const struct command_request *request, bool may_move);
    void (*gone)(void *context, uint64_t peer);
    /* Returns true if this peer waits for an answer or holds a lease; its connection is then not
     * closed to make room. */
    bool (*needs)(void *context, uint64_t peer);
    /* Returns true if nothing is driven any more, so that no packet matters. over may be NULL;
     * packets then always matter. */
    bool (*over)(void *context);
};

struct command_place {
    int fd; /* socket of the connection; -1: this place is free */
    uint64_t peer;
    uid_t user;
    int64_t heard; /* value of command_server.heard when this connection was accepted, or last sent
                    * a packet */
    bool closing;  /* only stops are taken any more: the client does not read its answers, or its
                    * place is given away */
};

struct command_server {
    struct machine_name machine;
    int lock, listener[COMMAND_SOCKETS]; /* descriptors of the name's lock and of the listeners; -1:
                                          * closed */
    struct {
        dev_t device;
        ino_t inode;
    } file[COMMAND_SOCKETS];       /* device and inode of the file to which each listener was bound,
                                    * by which a replaced file is noticed */
    bool rests[COMMAND_SOCKETS];   /* this listener is left out of the next poll() */
    struct command_place place[COMMAND_SOCKETS][COMMAND_PLACES];
    struct command_place passing[COMMAND_SOCKETS]; /* connection for which no place is free; it is
                                                    * closed at once, or, once
                                                    * command_handler.over() is true, kept open so
                                                    * that it gets the last words */
    uint64_t peers;                /* number of the latest peer */
    int64_t heard;                 /* count of connections and packets so far */
    const struct command_handler *handler;
};

/* Marks everything as closed, so that command_server_end() may be called before
 * command_server_open(). */
void command_server_init(struct command_server *s);

/* Calls machine_claim() and opens both sockets: NAME.stop for everybody, NAME for the daemon's user
 * and, if the daemon may give the file to that group, for group hexid. The handler must outlive the
 * server. Returns 0 or a negative status. */
int command_server_open(struct command_server *s, const char *name, const struct command_handler *handler, struct error *error);

/* Fills in the descriptors to poll; -1 for free places and for listeners that are left out. */
void command_server_polls(const struct command_server *s, struct pollfd polls[COMMAND_POLLS]);

/* Returns the first socket whose file was deleted or replaced, so that no client can connect to
 * it; COMMAND_SOCKETS: none. Looks up two paths in a local file system. */
enum command_socket command_server_missing(const struct command_server *s);

/* Returns true if a client waits for a connection for which there is no descriptor or memory. */
bool command_server_starved(const struct command_server *s);

/* Takes packets and connections, those of NAME.stop first; to be called after poll(). Returns the
 * number of packets and new connections.
 * SAFETY: once command_handler.over() is true, takes and closes nothing more, because each packet
 * can hold up this thread (command_server_end()). */
int command_server_serve(struct command_server *s, const struct pollfd polls[COMMAND_POLLS]);

/* Sends an answer. Does nothing if the peer is gone. */
void command_server_answer(struct command_server *s, uint64_t peer, const struct command_answer *answer);

/* Sends `last_words` to all connected clients, and to those that wait for a connection as far as
 * there are descriptors, and ends the connections, so that later clients find no daemon. May be
 * called again.
 * SAFETY: closes no connection and no listener, because the descriptors in the packets that wait
 * there can hold up each close() for as long as a client likes, and the log is closed only after
 * this call. At the end of the process the kernel closes them without that wait. During this call
 * four descriptors are reserved, if available, so that clients leave some for the results and the
 * log, which are written later; they are duplicates of a listener, so closing them waits for
 * nothing. */
void command_server_end(struct command_server *s, const struct command_answer *last_words);

#endif
