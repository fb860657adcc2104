#include "command_broadcast.h"

#include <errno.h>

#include "monotonic.h"
#include "poll_any.h"

enum {
    AT_ONCE = 64, /* rest() waits for the answers of at most this many connections; turn() then
                   * looks for the answers of all */
    TURN_MS = 2,
};

/* Returns true for errors that may be temporary: the machine's queue is full, or this process has
 * no free descriptor until another machine has answered. */
static bool passes(int why) { return why == EAGAIN || why == EMFILE || why == ENFILE || why == ENOBUFS || why == ENOMEM; }

static void reach(struct command_told *t, enum command command) {
    bool reached = !command_client_reopen(&t->client, true, 0);
    t->unreached = reached || !passes(errno) ? 0 : errno;
    if (reached && command_client_send(&t->client, command, false)) command_client_close(&t->client);
    else if (!reached && !t->unreached) t->news = NEWS_LOST;
}

/* Takes one turn with a machine: connects if necessary, and looks for its answer. A connection
 * that the daemon closed to make room for others is made again in the next turn. */
static void turn(struct command_told *t, enum command command) {
    if (t->client.fd < 0) reach(t, command);
    if (t->client.fd < 0) return;
    t->news = command_client_wait(&t->client, 0, NULL);
    if (t->news == NEWS_NONE) return;
    command_client_close(&t->client);
    if (t->news == NEWS_LOST) t->news = NEWS_NONE;
}

/* Waits for a pending answer, but only briefly, because other machines may have to be reached. */
static void rest(const struct command_told *told, int count) {
    struct pollfd p[AT_ONCE];
    nfds_t due = 0;
    for (int i = 0; i < count && due < AT_ONCE; i++)
        if (told[i].client.fd >= 0) p[due++] = (struct pollfd){.fd = told[i].client.fd, .events = POLLIN};
    poll_any(p, due, TURN_MS, NULL);
}

void command_broadcast(enum command command, struct command_told *told, int count, int patience_ms) {
    int64_t end_ms = monotonic_ms() + patience_ms;
    bool last = false; /* the turn after patience_ms, which finds answers that came while this
                        * process did not run */
    for (int left = count; left > 0 && !last;) {
        last = monotonic_ms() > end_ms;
        left = 0;
        for (int i = 0; i < count; i++) {
            if (told[i].news == NEWS_NONE) turn(&told[i], command);
            left += told[i].news == NEWS_NONE;
        }
        if (left > 0 && !last) rest(told, count);
    }
    for (int i = 0; i < count; i++) command_client_close(&told[i].client);
}
