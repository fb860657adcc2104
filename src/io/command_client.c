#include "command_client.h"

#include <errno.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include "monotonic.h"
#include "poll_any.h"

enum { AGAIN_MS = 2 };

int command_client_open(struct command_client *c, const struct machine_name *m, bool stop, int patience_ms) {
    int64_t end_ms = monotonic_ms() + patience_ms;
    *c = (struct command_client){.machine = *m};
    while ((c->fd = machine_connect(m, stop)) < 0 && errno == EAGAIN && monotonic_ms() < end_ms) poll_any(NULL, 0, AGAIN_MS, NULL);
    return c->fd < 0 ? -1 : 0;
}

int command_client_reopen(struct command_client *c, bool stop, int patience_ms) {
    struct command_client again;
    if (command_client_open(&again, &c->machine, stop, patience_ms)) return -1;
    again.answer = c->answer;
    again.answered = c->answered;
    command_client_close(c);
    *c = again;
    return 0;
}

void command_client_close(struct command_client *c) {
    if (c->fd >= 0) close(c->fd);
    c->fd = -1;
}

static int send_request(struct command_client *c, const struct command_request *request) {
    unsigned char packet[COMMAND_SET_SIZE];
    size_t size = command_request_encode(request, packet);
    return send(c->fd, packet, size, MSG_NOSIGNAL) == (ssize_t)size ? 0 : -1;
}

int command_client_send(struct command_client *c, enum command command, bool renew) {
    return send_request(c, &(struct command_request){.id = ++c->id, .command = command, .renew = renew});
}

int command_client_send_gains(struct command_client *c, const struct gain_change *change) {
    return send_request(c, &(struct command_request){.id = ++c->id, .command = COMMAND_SET, .sets = true, .change = *change});
}

/* Receives a packet. If the other end closed the connection with a request unread, the first call
 * fails with ECONNRESET; packets sent before that can still be read. */
static ssize_t receive(int fd, unsigned char packet[COMMAND_ANSWER_SIZE]) {
    ssize_t size = recv(fd, packet, COMMAND_ANSWER_SIZE, MSG_DONTWAIT);
    return size < 0 && errno == ECONNRESET ? recv(fd, packet, COMMAND_ANSWER_SIZE, MSG_DONTWAIT) : size;
}

enum command_news command_client_wait(struct command_client *c, int patience_ms, const sigset_t *mask) {
    unsigned char packet[COMMAND_ANSWER_SIZE];
    struct pollfd p = {.fd = c->fd, .events = POLLIN};
    for (int64_t end_ms = monotonic_ms() + patience_ms, left_ms = patience_ms; left_ms >= 0; left_ms = end_ms - monotonic_ms()) {
        int ready = poll_any(&p, 1, (int)left_ms, mask);
        if (ready < 0 && !mask) continue;
        if (ready <= 0) return NEWS_NONE;
        ssize_t size = receive(c->fd, packet);
        if (size < 0 && (errno == EAGAIN || errno == EINTR)) continue;
        if (size <= 0) return NEWS_LOST;
        if (!command_answer_decode(packet, (size_t)size, &c->answer)) continue;
        c->answered = true;
        if (c->answer.outcome == OUTCOME_ENDED) return NEWS_LEFT;
        if (c->answer.id == c->id) return NEWS_ANSWER;
    }
    return NEWS_NONE;
}
