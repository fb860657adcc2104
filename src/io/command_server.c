#include "command_server.h"

#include "local_socket.h"
#include "poll_any.h"

#include <errno.h>
#include <fcntl.h>
#include <grp.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#define GROUP "hexid"

enum { BACKLOG = 512, NEW_AT_ONCE = 16, LAST_AT_ONCE = 2 * BACKLOG, PACKET_ROOM = 128, LAST_PACKETS = 64, SPARE = 4 };

void command_server_init(struct command_server *s) {
    memset(s, 0, sizeof *s);
    s->lock = s->listener[SOCKET_STOP] = s->listener[SOCKET_ALL] = -1;
    for (int k = 0; k < COMMAND_SOCKETS; k++) {
        s->passing[k].fd = -1;
        for (int i = 0; i < COMMAND_PLACES; i++) s->place[k][i].fd = -1;
    }
}

/* ---- opening ---- */

/* SAFETY: gives the socket's file to group hexid. The kernel lets only this group, the daemon's
 * user and root connect, and so set the machine in motion. If the daemon may not change the file's
 * group, the group is left out. A service runs in group hexid, so its file has that group from the
 * start. */
static bool give_to_group(const char *path) {
    struct group *group = getgrnam(GROUP);
    struct stat s;
    if (chmod(path, 0600) || lstat(path, &s)) return false;
    bool is = group && (s.st_gid == group->gr_gid || !lchown(path, (uid_t)-1, group->gr_gid));
    return !is || !chmod(path, 0660);
}

/* Binds, sets the mode, then listens, so that nobody can connect before the mode is right. */
static int listen_at(struct command_server *s, enum command_socket kind, struct error *error) {
    struct sockaddr_un address;
    struct stat file;
    machine_address(&s->machine, kind == SOCKET_STOP, &address);
    int fd = s->listener[kind] = local_socket();
    bool good = fd >= 0 && !bind(fd, (const struct sockaddr *)&address, sizeof address) &&
                (kind == SOCKET_STOP ? !chmod(address.sun_path, 0666) : give_to_group(address.sun_path)) &&
                !lstat(address.sun_path, &file) && !listen(fd, BACKLOG);
    if (good) s->file[kind].device = file.st_dev, s->file[kind].inode = file.st_ino;
    return good ? STATUS_OK : error_set(error, STATUS_IO, "%s: no socket for commands: %s", address.sun_path, strerror(errno));
}

static void close_listeners(struct command_server *s) {
    for (int k = 0; k < COMMAND_SOCKETS; k++) {
        if (s->listener[k] >= 0) close(s->listener[k]);
        s->listener[k] = -1;
    }
    if (s->lock >= 0) close(s->lock);
    s->lock = -1;
}

int command_server_open(struct command_server *s, const char *name, const struct command_handler *handler, struct error *error) {
    command_server_init(s);
    s->handler = handler;
    int status = machine_claim(name, &s->machine, &s->lock, error);
    for (int k = 0; !status && k < COMMAND_SOCKETS; k++) status = listen_at(s, (enum command_socket)k, error);
    if (status) close_listeners(s);
    return status;
}

/* Returns true only if the socket's file is certainly gone or replaced: other errors prove nothing,
 * because the confined daemon may not look into some directories. */
static bool missing(const struct command_server *s, enum command_socket kind) {
    struct sockaddr_un address;
    struct stat file;
    machine_address(&s->machine, kind == SOCKET_STOP, &address);
    if (lstat(address.sun_path, &file)) return errno == ENOENT || errno == ENOTDIR;
    return file.st_dev != s->file[kind].device || file.st_ino != s->file[kind].inode;
}

enum command_socket command_server_missing(const struct command_server *s) {
    int k = 0;
    while (k < COMMAND_SOCKETS && (s->listener[k] < 0 || !missing(s, (enum command_socket)k))) k++;
    return (enum command_socket)k;
}

/* ---- connections ---- */

/* Returns true once nothing is driven any more; from then on no packet is read and no connection is
 * closed. */
static bool over(const struct command_server *s) { return s->handler->over && s->handler->over(s->handler->context); }

static void release(struct command_server *s, struct command_place *c) {
    close(c->fd);
    c->fd = -1;
    s->handler->gone(s->handler->context, c->peer);
}

static bool hung_up(int fd) {
    struct pollfd p = {.fd = fd, .events = POLLRDHUP};
    return poll_any(&p, 1, 0, NULL) != 0;
}

enum packet { PACKET_NONE, PACKET_TAKEN, PACKET_REFUSED, PACKET_END };

/* Takes a packet from the connection if one waits.
 * SAFETY: a stop counts even if its sender has gone meanwhile; a moving command does not, because
 * nobody waits for it. */
static enum packet take_packet(struct command_server *s, struct command_place *c, enum command_socket kind) {
    unsigned char packet[PACKET_ROOM];
    struct command_request r;
    if (over(s)) return PACKET_NONE;
    ssize_t size = recv(c->fd, packet, sizeof packet, MSG_DONTWAIT);
    /* if the client closed the connection with an answer unread, recv() first fails with
     * ECONNRESET; the client's packets can still be read afterwards */
    if (size < 0 && errno == ECONNRESET) size = recv(c->fd, packet, sizeof packet, MSG_DONTWAIT);
    if (size < 0 && (errno == EAGAIN || errno == EINTR)) return PACKET_NONE;
    if (size <= 0) return PACKET_END;
    if (!command_request_decode(packet, (size_t)size, &r)) return PACKET_REFUSED;
    c->heard = ++s->heard;
    if (!command_stops(r.command) && (c->closing || hung_up(c->fd))) return PACKET_REFUSED;
    s->handler->take(s->handler->context, c->peer, &r, kind == SOCKET_ALL);
    return PACKET_TAKEN;
}

/* Takes a packet, if there is one. Returns false if the connection is to be closed. */
static bool serve(struct command_server *s, struct command_place *c, enum command_socket kind) {
    enum packet p = take_packet(s, c, kind);
    return p == PACKET_NONE || p == PACKET_TAKEN;
}

/* Closes a connection.
 * SAFETY: first takes the stops among the first LAST_PACKETS packets that wait in it; ignores all
 * commands that move. From shutdown() on, sending to it fails, so no packet is lost without an
 * error at its sender. */
static void dismiss(struct command_server *s, struct command_place *c, enum command_socket kind) {
    c->closing = true;
    shutdown(c->fd, SHUT_RD);
    /* an empty packet and the end look alike, so only the number of packets ends the loop */
    for (int i = 0; i < LAST_PACKETS; i++) take_packet(s, c, kind);
    if (!over(s)) release(s, c);
}

static int places_of(const struct command_place *place, uid_t user) {
    int count = 0;
    for (int i = 0; i < COMMAND_PLACES; i++) count += place[i].fd >= 0 && place[i].user == user;
    return count;
}

/* Returns the connection to close in order to make room, as command_server.h describes; NULL if all
 * connections are needed. */
static struct command_place *least_needed(struct command_server *s, enum command_socket kind) {
    struct command_place *place = s->place[kind], *best = NULL;
    int most = 0;
    for (int i = 0; i < COMMAND_PLACES; i++) {
        if (place[i].fd < 0) continue;
        int count = places_of(place, place[i].user);
        bool before = !best || count > most || (count == most && place[i].heard < best->heard);
        if (!before || s->handler->needs(s->handler->context, place[i].peer)) continue;
        best = &place[i];
        most = count;
    }
    return best;
}

static struct command_place *free_place(struct command_server *s, enum command_socket kind) {
    for (int i = 0; i < COMMAND_PLACES; i++)
        if (s->place[kind][i].fd < 0) return &s->place[kind][i];
    struct command_place *c = least_needed(s, kind);
    if (!c) return NULL;
    dismiss(s, c, kind);
    return c->fd < 0 ? c : NULL;
}

static bool awaited(int listener) {
    struct pollfd p = {.fd = listener, .events = POLLIN};
    return poll_any(&p, 1, 0, NULL) > 0;
}

/* Accepts a connection and takes its first packet, which has usually arrived with it. */
static bool take_connection(struct command_server *s, enum command_socket kind) {
    if (over(s)) return false;
    struct ucred peer = {.uid = (uid_t)-1};
    socklen_t length = sizeof peer;
    int fd = accept4(s->listener[kind], NULL, NULL, SOCK_NONBLOCK | SOCK_CLOEXEC), why = fd < 0 ? errno : 0;
    /* Without a free descriptor accept4() fails with EMFILE or ENFILE even if no client waits. If
     * one waits, a connection that is not needed is closed for it. */
    bool none = why == EMFILE || why == ENFILE, short_of = (none || why == ENOBUFS || why == ENOMEM) && awaited(s->listener[kind]);
    struct command_place *c = fd >= 0 ? free_place(s, kind) : none && short_of ? least_needed(s, kind) : NULL;
    bool sheds = fd < 0 && c;
    if (sheds) dismiss(s, c, kind);
    s->rests[kind] = short_of && !sheds;
    if (fd < 0) return false;
    getsockopt(fd, SOL_SOCKET, SO_PEERCRED, &peer, &length);
    struct command_place *here = c ? c : &s->passing[kind];
    *here = (struct command_place){.fd = fd, .peer = ++s->peers, .user = peer.uid, .heard = ++s->heard, .closing = !c};
    if (!serve(s, here, kind) || !c) dismiss(s, here, kind);
    return true;
}

bool command_server_starved(const struct command_server *s) { return s->rests[SOCKET_STOP] || s->rests[SOCKET_ALL]; }

void command_server_polls(const struct command_server *s, struct pollfd polls[COMMAND_POLLS]) {
    for (int k = 0; k < COMMAND_SOCKETS; k++) {
        *polls++ = (struct pollfd){.fd = s->rests[k] ? -1 : s->listener[k], .events = POLLIN};
        for (int i = 0; i < COMMAND_PLACES; i++) *polls++ = (struct pollfd){.fd = s->place[k][i].fd, .events = POLLIN};
    }
}

int command_server_serve(struct command_server *s, const struct pollfd polls[COMMAND_POLLS]) {
    int taken = 0;
    for (int k = 0; k < COMMAND_SOCKETS; k++) {
        const struct pollfd *listener = &polls[k * (1 + COMMAND_PLACES)], *one = listener + 1;
        for (int i = 0; i < COMMAND_PLACES; i++) {
            struct command_place *c = &s->place[k][i];
            bool speaks = c->fd >= 0 && c->fd == one[i].fd && one[i].revents;
            taken += speaks;
            if (c->fd >= 0 && (c->closing || (speaks && !serve(s, c, (enum command_socket)k)))) dismiss(s, c, (enum command_socket)k);
        }
        bool tries = listener->revents || (s->rests[k] && s->listener[k] >= 0);
        for (int i = 0; i < NEW_AT_ONCE && tries && take_connection(s, (enum command_socket)k); i++) taken++;
    }
    return taken;
}

static bool send_answer(int fd, const struct command_answer *answer) {
    unsigned char packet[COMMAND_ANSWER_SIZE];
    command_answer_encode(answer, packet);
    return send(fd, packet, sizeof packet, MSG_DONTWAIT | MSG_NOSIGNAL) == (ssize_t)sizeof packet;
}

void command_server_answer(struct command_server *s, uint64_t peer, const struct command_answer *answer) {
    for (int k = 0; k < COMMAND_SOCKETS; k++)
        for (int i = 0; i < COMMAND_PLACES; i++) {
            struct command_place *c = &s->place[k][i];
            if (c->fd >= 0 && c->peer == peer && !send_answer(c->fd, answer)) c->closing = true;
        }
}

static void end_connection(int fd, const struct command_answer *last_words) {
    send_answer(fd, last_words);
    shutdown(fd, SHUT_RDWR);
}

void command_server_end(struct command_server *s, const struct command_answer *last_words) {
    int spare[SPARE];
    for (int i = 0; i < SPARE; i++) spare[i] = fcntl(s->listener[SOCKET_STOP], F_DUPFD_CLOEXEC, 0);
    for (int k = 0; k < COMMAND_SOCKETS; k++) {
        for (int i = 0; i < COMMAND_PLACES; i++)
            if (s->place[k][i].fd >= 0) end_connection(s->place[k][i].fd, last_words);
        if (s->passing[k].fd >= 0) end_connection(s->passing[k].fd, last_words);
        if (s->listener[k] < 0) continue;
        shutdown(s->listener[k], SHUT_RDWR); /* no new client can connect; the ones in the queue are
                                              * accepted below */
        for (int i = 0, fd; i < LAST_AT_ONCE && (fd = accept4(s->listener[k], NULL, NULL, SOCK_NONBLOCK | SOCK_CLOEXEC)) >= 0; i++)
            end_connection(fd, last_words);
    }
    for (int i = 0; i < SPARE; i++)
        if (spare[i] >= 0) close(spare[i]);
    if (s->lock >= 0) close(s->lock);
    s->lock = -1;
}
