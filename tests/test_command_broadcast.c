/* A stop to several machines on a clock of the test's own: time passes only while the client waits,
 * and then the machines act, one step a wait. */
#include "support.h"

#include <errno.h>
#include <poll.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#include "command_broadcast.h"
#include "units.h"

enum { PATIENCE_MS = 60000 };

static int64_t now_ns = NS_PER_S;
static void (*act)(void); /* function that acts as the machines during each wait */
static int steps;         /* number of waits so far */
static int unsent;        /* number of requests that cannot be sent */

int clock_gettime(clockid_t id, struct timespec *t) {
    (void)id;
    *t = (struct timespec){.tv_sec = now_ns / NS_PER_S, .tv_nsec = now_ns % NS_PER_S};
    return 0;
}

int ppoll(struct pollfd *p, nfds_t count, const struct timespec *timeout, const sigset_t *mask) {
    int64_t wait_ns = timeout->tv_sec * NS_PER_S + timeout->tv_nsec;
    struct timespec none = {0};
    (void)mask;
    if (wait_ns > 0 && act) act(), steps++;
    int ready = (int)syscall(SYS_ppoll, p, count, &none, NULL, 0);
    if (ready == 0) now_ns += wait_ns;
    return ready;
}

ssize_t send(int fd, const void *packet, size_t size, int flags) {
    if (unsent > 0) return unsent--, errno = EPIPE, -1;
    return sendto(fd, packet, size, flags, NULL, 0);
}

/* ---- machines ---- */

static char directory[] = "/tmp/hexid-broadcast.XXXXXX";
static struct {
    struct machine_name machine;
    int listener, client;
    struct command_request asked;
} m[2];

/* Opens a machine's socket for stops, with room for `room` waiting connections. */
static void machine_at(int i, int room) {
    struct sockaddr_un at;
    snprintf(m[i].machine.name, sizeof m[i].machine.name, "m%d", i);
    snprintf(m[i].machine.directory, sizeof m[i].machine.directory, "%s", directory);
    assert_true(machine_address(&m[i].machine, true, &at));
    m[i].listener = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    assert_int_equal(bind(m[i].listener, (const struct sockaddr *)&at, sizeof at), 0);
    assert_int_equal(listen(m[i].listener, room), 0);
}

/* Accepts the waiting connection and receives its request. */
static void hear(int i) {
    unsigned char packet[COMMAND_REQUEST_SIZE];
    m[i].client = accept(m[i].listener, NULL, NULL);
    assert_true(m[i].client >= 0);
    assert_int_equal(recv(m[i].client, packet, sizeof packet, MSG_DONTWAIT), COMMAND_REQUEST_SIZE);
    assert_true(command_request_decode(packet, sizeof packet, &m[i].asked));
    assert_int_equal(m[i].asked.command, COMMAND_STOP);
}

static void answer(int i) {
    unsigned char packet[COMMAND_ANSWER_SIZE];
    command_answer_encode(&(struct command_answer){.id = m[i].asked.id, .outcome = OUTCOME_DONE, .state = STATE_SETTLED}, packet);
    assert_int_equal(sendto(m[i].client, packet, sizeof packet, MSG_NOSIGNAL, NULL, 0), COMMAND_ANSWER_SIZE);
}

/* Stops the machines and closes them. Returns the number of those that answered. */
static int stop(int count, void (*meanwhile)(void)) {
    struct command_told told[2] = {0};
    int answered = 0;
    act = meanwhile, steps = 0;
    for (int i = 0; i < count; i++) told[i].client = (struct command_client){.machine = m[i].machine, .fd = -1};
    command_broadcast(COMMAND_STOP, told, count, PATIENCE_MS);
    for (int i = 0; i < count; i++) {
        struct sockaddr_un at;
        answered += told[i].news == NEWS_ANSWER && !told[i].unreached;
        assert_int_equal(told[i].client.fd, -1);
        machine_address(&m[i].machine, true, &at);
        unlink(at.sun_path);
        close(m[i].listener);
    }
    return answered;
}

/* ---- claims ---- */

static int waits; /* connection that fills the queue of the busy machine */

/* Machine 0 stays silent until machine 1, whose queue is full at first, has its stop. Then machine
 * 0 closes its connection to make room. */
static void busy_and_hanging(void) {
    switch (steps) {
    case 0: hear(0); break;
    case 5: close(accept(m[1].listener, NULL, NULL)); break;
    case 7: hear(1), answer(1); break;
    case 9: close(m[0].client); break;
    case 11: hear(0), answer(0); break;
    }
}

static void a_stop_comes_to_who_was_busy_while_another_hangs(void **unused) {
    (void)unused;
    machine_at(0, 8), machine_at(1, 0);
    waits = machine_connect(&m[1].machine, true);
    assert_true(waits >= 0);
    assert_int_equal(machine_connect(&m[1].machine, true), -1);
    assert_int_equal(errno, EAGAIN);
    assert_int_equal(stop(2, busy_and_hanging), 2);
    close(m[0].client), close(m[1].client), close(waits);
}

static void hear_first_or_anew(void) {
    int sent = accept(m[0].listener, NULL, NULL);
    unsigned char packet[COMMAND_REQUEST_SIZE];
    if (sent < 0) return;
    m[0].client = sent;
    if (recv(sent, packet, sizeof packet, MSG_DONTWAIT) != COMMAND_REQUEST_SIZE) return;
    assert_true(command_request_decode(packet, sizeof packet, &m[0].asked));
    answer(0);
}

static void a_request_that_could_not_be_sent_is_sent_anew(void **unused) {
    (void)unused;
    machine_at(0, 8);
    unsent = 1;
    assert_int_equal(stop(1, hear_first_or_anew), 1);
    assert_int_equal(unsent, 0);
    close(m[0].client);
}

/* The machine answers while the client's process gets no processor until its patience has ended. */
static void answered_during_a_stall(void) {
    hear(0), answer(0);
    now_ns += 2 * PATIENCE_MS * NS_PER_MS;
    act = NULL;
}

static void an_answer_counts_that_came_while_this_process_was_held_up(void **unused) {
    (void)unused;
    machine_at(0, 8);
    assert_int_equal(stop(1, answered_during_a_stall), 1);
    close(m[0].client);
}

static void say_nothing(void) {
    if (steps == 0) hear(0);
}

static void who_does_not_answer_is_waited_for_as_long_as_the_patience_lasts(void **unused) {
    (void)unused;
    machine_at(0, 8);
    int64_t before_ns = now_ns;
    assert_int_equal(stop(1, say_nothing), 0);
    assert_close((double)(now_ns - before_ns) / NS_PER_MS, PATIENCE_MS, 5.0); /* two turns */
    close(m[0].client);
}

static int make_directory(void **unused) {
    (void)unused;
    return mkdtemp(directory) ? setenv("HEXID_RUNTIME_DIR", directory, 1) : -1;
}

static int remove_directory(void **unused) {
    (void)unused;
    return rmdir(directory);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_stop_comes_to_who_was_busy_while_another_hangs),
        cmocka_unit_test(a_request_that_could_not_be_sent_is_sent_anew),
        cmocka_unit_test(an_answer_counts_that_came_while_this_process_was_held_up),
        cmocka_unit_test(who_does_not_answer_is_waited_for_as_long_as_the_patience_lasts),
    };
    return cmocka_run_group_tests(tests, make_directory, remove_directory);
}
