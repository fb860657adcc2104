/* The two sockets of a machine: malformed packets, priority of connections, names and directories,
 * and final messages. */
#include "support.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include "command_client.h"
#include "command_server.h"
#include "process.h"

static char directory[] = "/tmp/hexid-server.XXXXXX";
static struct command_server server;
static struct {
    int takes, stops, moves, goes;
    int ends; /* number of requests after which nothing is driven any more; 0: never */
    uint64_t peer, needed;
    struct command_request request;
    bool may_move;
} got;

static void take(void *context, uint64_t peer, const struct command_request *request, bool may_move) {
    (void)context;
    got.takes++;
    got.stops += command_stops(request->command);
    got.moves += !command_stops(request->command);
    got.peer = peer;
    got.request = *request;
    got.may_move = may_move;
}
static void gone(void *context, uint64_t peer) { (void)context, (void)peer, got.goes++; }
static bool needs(void *context, uint64_t peer) { return (void)context, peer == got.needed; }
static bool over(void *context) { return (void)context, got.ends && got.takes >= got.ends; }
static const struct command_handler handler = {.take = take, .gone = gone, .needs = needs, .over = over};

static void open_as(const char *name) {
    struct error error;
    memset(&got, 0, sizeof got);
    if (command_server_open(&server, name, &handler, &error)) fail_msg("%s", error.text);
}
static int closed_sockets;

/* Returns true if the socket is that of a listener which stays open. */
static bool of_open_listener(int fd, ino_t inode) {
    struct stat s;
    for (int k = 0; k < COMMAND_SOCKETS; k++)
        if (server.listener[k] != fd && !fstat(server.listener[k], &s) && s.st_ino == inode) return true;
    return false;
}

/* Overrides the C library's function. */
int close(int fd) {
    struct stat s;
    closed_sockets += !fstat(fd, &s) && S_ISSOCK(s.st_mode) && !of_open_listener(fd, s.st_ino);
    return (int)syscall(SYS_close, fd);
}

static void end_server(struct command_server *s) {
    command_server_end(s, &(struct command_answer){.outcome = OUTCOME_ENDED, .state = STATE_SETTLED});
}

/* Ends the server, and closes what the end of its process closes. */
static void close_all_of(struct command_server *s) {
    end_server(s);
    for (int k = 0; k < COMMAND_SOCKETS; k++) {
        for (int i = 0; i < COMMAND_PLACES; i++)
            if (s->place[k][i].fd >= 0) close(s->place[k][i].fd), s->place[k][i].fd = -1;
        if (s->passing[k].fd >= 0) close(s->passing[k].fd), s->passing[k].fd = -1;
        if (s->listener[k] >= 0) close(s->listener[k]), s->listener[k] = -1;
    }
}
static void close_all(void) { close_all_of(&server); }

static int serve(void) {
    struct pollfd p[COMMAND_POLLS];
    command_server_polls(&server, p);
    poll(p, COMMAND_POLLS, 0);
    return command_server_serve(&server, p);
}
static void serve_all(void) {
    while (serve()) continue;
}

static int client(bool stop) { return machine_connect(&server.machine, stop); }

static void say(int fd, enum command command) {
    unsigned char packet[COMMAND_SET_SIZE];
    size_t size = command_request_encode(&(struct command_request){.id = 7, .command = command}, packet);
    assert_int_equal(send(fd, packet, size, MSG_NOSIGNAL), size);
}

/* ---- packets ---- */

/* Gains come back bit by bit, and only from a packet of their size that sets gains. */
static void gains_come_back_and_of_no_other_size(void **unused) {
    (void)unused;
    unsigned char packet[COMMAND_SET_SIZE + 1] = {0};
    struct command_request r, asks = {.id = 9, .command = COMMAND_SET, .sets = true, .change = {.digest = 0xfedcba9876543210u}};
    for (int i = 0; i < LOOP_GAINS; i++) asks.change.from.value[i] = 0.1 * i, asks.change.to.value[i] = -3e-7 / (i + 1);
    assert_int_equal(command_request_encode(&asks, packet), COMMAND_SET_SIZE);
    assert_true(command_request_decode(packet, COMMAND_SET_SIZE, &r));
    assert_true(r.sets && r.command == COMMAND_SET && r.change.digest == asks.change.digest);
    assert_memory_equal(&r.change.from, &asks.change.from, sizeof r.change.from);
    assert_memory_equal(&r.change.to, &asks.change.to, sizeof r.change.to);
    for (size_t cut = 0; cut <= COMMAND_SET_SIZE + 1; cut++)
        if (cut != COMMAND_SET_SIZE && cut != COMMAND_REQUEST_SIZE) assert_false(command_request_decode(packet, cut, &r));
    /* without gains it is a question */
    assert_true(command_request_decode(packet, COMMAND_REQUEST_SIZE, &r) && !r.sets);
    packet[6] = COMMAND_START;
    assert_false(command_request_decode(packet, COMMAND_SET_SIZE, &r));
}

static void packets_come_back_and_what_is_none_is_refused(void **unused) {
    (void)unused;
    unsigned char request[COMMAND_SET_SIZE] = {0}, answer[COMMAND_ANSWER_SIZE + 1] = {0};
    struct command_request r;
    struct command_answer a = {.id = 0xfedcba98, .lease_s = 2.5, .outcome = OUTCOME_REFUSED, .state = STATE_FAULT, .text = "because"}, b;
    for (int command = COMMAND_NONE; command < COMMANDS; command++) {
        bool renew = command == COMMAND_NONE;
        command_request_encode(&(struct command_request){.id = 0xfedcba98, .command = (enum command)command, .renew = renew}, request);
        assert_true(command_request_decode(request, COMMAND_REQUEST_SIZE, &r));
        assert_true(r.id == 0xfedcba98 && (int)r.command == command && r.renew == renew);
        bool stops = command_stops(r.command);
        assert_int_equal(command_request_decode(request, COMMAND_REQUEST_SIZE + 1, &r), stops);
        assert_int_equal(command_request_decode(request, 12, &r), stops);
        for (size_t cut = 0; cut < 12; cut++) assert_false(command_request_decode(request, cut, &r));
        request[5]++; /* a later version */
        assert_int_equal(command_request_decode(request, COMMAND_REQUEST_SIZE, &r), stops);
        request[7] ^= 3; /* byte 7, `renew`, must be 0 or 1 */
        assert_false(command_request_decode(request, COMMAND_REQUEST_SIZE, &r));
        request[0]++;
        assert_false(command_request_decode(request, COMMAND_REQUEST_SIZE, &r));
    }
    command_answer_encode(&a, answer);
    assert_true(command_answer_decode(answer, COMMAND_ANSWER_SIZE, &b));
    assert_true(b.id == a.id && b.lease_s == 2.5 && b.outcome == a.outcome && b.state == a.state && !strcmp(b.text, a.text));
    assert_false(command_answer_decode(answer, COMMAND_ANSWER_SIZE + 1, &b));
    for (size_t cut = 0; cut < COMMAND_ANSWER_SIZE; cut += 7) assert_false(command_answer_decode(answer, cut, &b));
    static const struct {
        int at;
        unsigned char value;
    } wrong[] = {{0, 'h'}, {5, 2}, {6, OUTCOMES}, {7, STATES}, {12, 0xff}};
    for (int i = 0; i < 5; i++) {
        unsigned char before = answer[wrong[i].at];
        answer[wrong[i].at] = wrong[i].value;
        assert_false(command_answer_decode(answer, COMMAND_ANSWER_SIZE, &b));
        answer[wrong[i].at] = before;
    }
    memset(answer + 16, 'x', COMMAND_TEXT_SIZE); /* unterminated */
    assert_false(command_answer_decode(answer, COMMAND_ANSWER_SIZE, &b));
    memset(a.text, 'y', sizeof a.text - 1);
    command_answer_encode(&a, answer);
    assert_true(command_answer_decode(answer, COMMAND_ANSWER_SIZE, &b) && strlen(b.text) == COMMAND_TEXT_SIZE - 1);
}

/* ---- connections ---- */

static void requests_say_by_which_socket_they_came_and_are_answered(void **unused) {
    (void)unused;
    open_as("rig");
    for (int stop = 0; stop < 2; stop++) {
        struct command_client c;
        assert_int_equal(command_client_open(&c, &server.machine, stop, 0), 0);
        assert_int_equal(command_client_send(&c, COMMAND_PARK, false), 0);
        serve_all();
        assert_int_equal(got.may_move, !stop);
        assert_int_equal(command_client_wait(&c, 0, NULL), NEWS_NONE);
        command_server_answer(&server, got.peer, &(struct command_answer){.id = got.request.id, .state = STATE_PARKING});
        assert_int_equal(command_client_wait(&c, 0, NULL), NEWS_ANSWER);
        assert_int_equal(c.answer.state, STATE_PARKING);
        close_all();
        assert_int_equal(command_client_wait(&c, 0, NULL), NEWS_LEFT);
        assert_int_equal(c.answer.state, STATE_SETTLED);
        assert_int_equal(command_client_wait(&c, 0, NULL), NEWS_LOST);
        command_client_close(&c);
        open_as("rig");
    }
    close_all();
}

static void who_is_not_yet_accepted_hears_the_last_words_too(void **unused) {
    (void)unused;
    struct command_client c[3];
    open_as("");
    for (int i = 0; i < 3; i++) assert_int_equal(command_client_open(&c[i], &server.machine, i == 0, 0), 0);
    for (int i = 0; i < 2; i++) command_client_send(&c[i], COMMAND_STOP, false);
    close_all();
    for (int i = 0; i < 3; i++) {
        assert_int_equal(command_client_wait(&c[i], 0, NULL), NEWS_LEFT);
        command_client_close(&c[i]);
    }
    assert_int_equal(client(true), -1);
    assert_int_equal(errno, ECONNREFUSED);
}

/* Before Linux 6.16 a packet can hold a descriptor whose close() takes as long as its sender
 * likes. */
static void at_the_end_no_connection_is_closed_but_all_are_over(void **unused) {
    (void)unused;
    enum { CONNECTED = 20, WAITING = 30 };
    struct command_client c[CONNECTED + WAITING];
    open_as("");
    for (int i = 0; i < CONNECTED + WAITING; i++) {
        assert_int_equal(command_client_open(&c[i], &server.machine, i % 2, 0), 0);
        if (i < CONNECTED) serve_all();
        else command_client_send(&c[i], COMMAND_STOP, false);
    }
    for (int times = 0; times < 2; times++) {
        closed_sockets = 0;
        end_server(&server);
        assert_int_equal(closed_sockets, 0);
    }
    for (int i = 0; i < CONNECTED + WAITING; i++) {
        assert_int_equal(command_client_wait(&c[i], 0, NULL), NEWS_LEFT);
        assert_int_equal(command_client_wait(&c[i], 0, NULL), NEWS_LOST);
        command_client_close(&c[i]);
    }
    assert_int_equal(client(true), -1);
    assert_int_equal(errno, ECONNREFUSED);
    /* the name is free at once */
    struct command_server ended = server;
    open_as("hexid");
    close_all();
    close_all_of(&ended);
}

static void once_nothing_is_driven_the_rest_of_a_round_is_dropped(void **unused) {
    (void)unused;
    int fd[4];
    open_as("");
    for (int i = 0; i < 4; i++) fd[i] = client(true);
    serve_all();
    got.ends = 2;
    for (int i = 0; i < 4; i++) say(fd[i], COMMAND_STOP), shutdown(fd[i], SHUT_WR);
    int waits = client(true);
    say(waits, COMMAND_STOP);
    closed_sockets = 0;
    serve(), serve();
    assert_int_equal(got.takes, 2);
    assert_int_equal(got.goes, 0);
    assert_int_equal(closed_sockets, 0);
    for (int i = 0; i < 4; i++) close(fd[i]);
    close(waits);
    close_all();
}

/* The stop in the connection that is to make room ends the loop: nobody's place is given away. */
static void who_comes_when_the_loop_ends_hears_the_last_words(void **unused) {
    (void)unused;
    struct command_client c[COMMAND_PLACES + 2];
    open_as("");
    for (int i = 0; i < COMMAND_PLACES; i++) assert_int_equal(command_client_open(&c[i], &server.machine, true, 0), 0);
    serve_all();
    got.ends = 1;
    command_client_send(&c[0], COMMAND_STOP, false);
    for (int i = COMMAND_PLACES; i < COMMAND_PLACES + 2; i++) assert_int_equal(command_client_open(&c[i], &server.machine, true, 0), 0);
    struct pollfd p[COMMAND_POLLS];
    command_server_polls(&server, p);
    for (int times = 0; times < 2; times++) {
        p[0].revents = POLLIN; /* the stop arrives after poll() */
        command_server_serve(&server, p);
    }
    assert_int_equal(got.stops, 1);
    assert_int_equal(got.goes, 0);
    end_server(&server);
    for (int i = 0; i < COMMAND_PLACES + 2; i++) {
        assert_int_equal(command_client_wait(&c[i], 0, NULL), NEWS_LEFT);
        command_client_close(&c[i]);
    }
    close_all();
}

static void a_stop_passes_beside_hundreds_of_idle_connections(void **unused) {
    (void)unused;
    enum { IDLE = 400 };
    int idle[IDLE];
    open_as("");
    for (int i = 0; i < IDLE; i++) {
        assert_true((idle[i] = client(true)) >= 0);
        serve();
    }
    int mine = client(true);
    say(mine, COMMAND_STOP);
    serve_all();
    assert_int_equal(got.stops, 1);
    assert_int_equal(got.goes, IDLE + 1 - COMMAND_PLACES);
    for (int i = 0; i < IDLE; i++) close(idle[i]);
    close(mine);
    close_all();
}

static void one_that_floods_does_not_hold_another_up(void **unused) {
    (void)unused;
    open_as("");
    int flood = client(true), mine = client(true);
    for (int i = 0; i < 100; i++) say(flood, COMMAND_STOP);
    say(mine, COMMAND_PARK);
    serve(); /* the server accepts both connections and takes a packet from each */
    assert_int_equal(got.takes, 2);
    assert_int_equal(got.request.command, COMMAND_PARK);
    close(flood);
    close(mine);
    close_all();
}

static void no_connection_is_closed_over_a_stop_that_waits_in_it(void **unused) {
    (void)unused;
    int fd[COMMAND_PLACES];
    open_as("");
    for (int i = 0; i < COMMAND_PLACES; i++) fd[i] = client(true);
    serve_all();
    say(fd[0], COMMAND_ENGAGE);
    say(fd[0], COMMAND_STOP); /* both arrive after poll(), which reported only the new connection */
    int new = client(true);
    struct pollfd p[COMMAND_POLLS];
    command_server_polls(&server, p);
    p[0].revents = POLLIN;
    command_server_serve(&server, p);
    assert_int_equal(got.stops, 1);
    assert_int_equal(got.goes, 1);
    for (int i = 0; i < COMMAND_PLACES; i++) close(fd[i]);
    close(new);
    close_all();
}

static void who_is_needed_is_not_closed_and_a_stop_is_taken_without_a_place(void **unused) {
    (void)unused;
    int fd[COMMAND_PLACES + 2];
    open_as("");
    fd[0] = client(false);
    say(fd[0], COMMAND_START);
    serve_all();
    got.needed = got.peer;
    for (int i = 1; i < COMMAND_PLACES + 2; i++) {
        fd[i] = client(false);
        serve_all();
    }
    command_server_answer(&server, got.needed, &(struct command_answer){0});
    char packet[COMMAND_ANSWER_SIZE];
    assert_int_equal(recv(fd[0], packet, sizeof packet, 0), COMMAND_ANSWER_SIZE);
    for (int i = 0; i < COMMAND_PLACES + 2; i++) close(fd[i]);
    close_all();
}

static void garbage_ends_the_connection_that_it_came_by(void **unused) {
    (void)unused;
    static const char *const garbage[] = {"x", "HEXC", "HEXCxxxxxxxxxxxx", "a packet that is much longer than any that is known here"};
    open_as("");
    int mine = client(false);
    for (int i = 0; i < 4; i++) {
        int fd = client(false);
        assert_true(send(fd, garbage[i], strlen(garbage[i]), 0) > 0);
        serve_all();
        assert_int_equal(got.goes, i + 1);
        char byte;
        assert_int_equal(recv(fd, &byte, 1, 0), 0);
        close(fd);
    }
    assert_int_equal(got.takes, 0);
    say(mine, COMMAND_ENGAGE);
    serve_all();
    assert_int_equal(got.moves, 1);
    close(mine);
    close_all();
}

static void what_moves_is_not_taken_from_who_has_gone_and_a_stop_is(void **unused) {
    (void)unused;
    open_as("");
    static const enum command all[] = {COMMAND_ENGAGE, COMMAND_START, COMMAND_RESET, COMMAND_STOP, COMMAND_PARK};
    for (int i = 0; i < 5; i++) {
        int fd = client(false);
        say(fd, all[i]);
        close(fd);
    }
    serve_all();
    assert_int_equal(got.moves, 0);
    assert_int_equal(got.stops, 2);
    assert_int_equal(got.goes, 5);
    close_all();
}

static void who_does_not_read_its_answers_is_closed_and_waited_for_by_nobody(void **unused) {
    (void)unused;
    open_as("");
    int fd = client(true);
    for (int i = 0; i < 20000 && !got.goes; i++) {
        if (i % 100 == 0) say(fd, COMMAND_STOP);
        serve();
        command_server_answer(&server, got.peer, &(struct command_answer){0});
    }
    assert_int_equal(got.goes, 1);
    close(fd);
    close_all();
}

/* A connection may be closed for many reasons; none loses a stop that waits behind something
 * else. */
static void a_stop_counts_whatever_waits_before_it(void **unused) {
    (void)unused;
    open_as("");
    int fd = client(false);
    assert_true(send(fd, "garbage", 7, 0) > 0);
    say(fd, COMMAND_ENGAGE);
    say(fd, COMMAND_STOP);
    serve_all();
    assert_int_equal(got.stops, 1);
    assert_int_equal(got.moves, 0);
    close(fd);
    fd = client(false);
    say(fd, COMMAND_ENGAGE);
    say(fd, COMMAND_STOP);
    close(fd);
    serve_all();
    assert_int_equal(got.stops, 2);
    assert_int_equal(got.moves, 0);
    fd = client(false);
    send(fd, "", 0, 0), send(fd, "", 0, 0); /* empty packets, which look like the end */
    say(fd, COMMAND_STOP);
    serve_all();
    assert_int_equal(got.stops, 3);
    close(fd);
    fd = client(true);
    say(fd, COMMAND_STOP);
    serve_all(); /* the client reads no answer */
    for (int i = 0; i < 20000; i++) command_server_answer(&server, got.peer, &(struct command_answer){0});
    say(fd, COMMAND_STOP);
    say(fd, COMMAND_STOP);
    serve_all();
    assert_int_equal(got.stops, 6);
    assert_int_equal(got.goes, 4);
    close(fd);
    close_all();
}

/* Sends a packet with a descriptor, the standard input. */
static bool sends_descriptor(int fd) {
    union {
        char bytes[CMSG_SPACE(sizeof(int))];
        struct cmsghdr aligned;
    } control = {{0}};
    struct iovec packet = {.iov_base = "x", .iov_len = 1};
    struct msghdr message = {.msg_iov = &packet, .msg_iovlen = 1, .msg_control = &control, .msg_controllen = sizeof control};
    struct cmsghdr *rights = CMSG_FIRSTHDR(&message);
    rights->cmsg_level = SOL_SOCKET, rights->cmsg_type = SCM_RIGHTS, rights->cmsg_len = CMSG_LEN(sizeof(int));
    memset(CMSG_DATA(rights), 0, sizeof(int));
    return sendmsg(fd, &message, MSG_NOSIGNAL) >= 0;
}

/* A descriptor that the daemon drops could hold it up, so no packet with one arrives. */
static void descriptors_are_refused(void **unused) {
    (void)unused;
    int probe = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
    bool known = !setsockopt(probe, SOL_SOCKET, 83 /* SO_PASSRIGHTS */, &(int){0}, sizeof(int));
    close(probe);
    if (!known) skip(); /* Linux before 6.16 */
    open_as("");
    int early = client(true);
    assert_false(sends_descriptor(early)); /* before it is accepted */
    serve_all();
    assert_false(sends_descriptor(early));
    say(early, COMMAND_STOP);
    serve_all();
    assert_int_equal(got.stops, 1);
    close(early);
    close_all();
}

/* The descriptors that every hexid has at least (process.h), taken by the test. */
static struct {
    struct rlimit before;
    int fd[PROCESS_FILES], count;
} taken;

static void take_all_descriptors(void) {
    taken.count = 0;
    assert_int_equal(getrlimit(RLIMIT_NOFILE, &taken.before), 0);
    assert_int_equal(setrlimit(RLIMIT_NOFILE, &(struct rlimit){PROCESS_FILES, taken.before.rlim_max}), 0);
    for (int fd; (fd = dup(STDERR_FILENO)) >= 0;) taken.fd[taken.count++] = fd;
    assert_int_equal(errno, EMFILE);
}

static void give_descriptors_back(void) {
    while (taken.count > 0) close(taken.fd[--taken.count]);
    assert_int_equal(setrlimit(RLIMIT_NOFILE, &taken.before), 0);
}

static void without_a_descriptor_the_listener_rests_and_then_takes_who_waited(void **unused) {
    (void)unused;
    struct pollfd p[COMMAND_POLLS];
    open_as("");
    int old = client(false), late = client(true);
    say(late, COMMAND_STOP);
    take_all_descriptors();
    for (int i = 0; i < 3; i++) {
        assert_int_equal(serve(), 0); /* tries, each time */
        command_server_polls(&server, p);
        assert_int_equal(poll(p, COMMAND_POLLS, 0), 0); /* the server does not ask poll() about the
                                                         * listener, so the main thread would not
                                                         * spin */
    }
    give_descriptors_back();
    serve_all();
    assert_int_equal(got.stops, 1);
    command_server_polls(&server, p);
    assert_int_equal(p[0].fd, server.listener[SOCKET_STOP]);
    close(old);
    close(late);
    close_all();
}

static bool ended(int fd) { return poll(&(struct pollfd){.fd = fd, .events = POLLRDHUP}, 1, 0) == 1; }

/* Free places do not help if no descriptor is left. */
static void without_a_descriptor_the_silent_connection_makes_room_for_a_stop(void **unused) {
    (void)unused;
    open_as("");
    int held = client(true), silent = client(true);
    say(held, COMMAND_STOP); /* both are accepted, and the answer to this one is pending */
    serve_all();
    got.needed = got.peer;
    assert_int_equal(got.stops, 1);
    int late = client(true);
    say(late, COMMAND_STOP);
    take_all_descriptors();
    for (int i = 0; i < 5; i++) serve();
    assert_int_equal(got.stops, 2);
    assert_int_equal(got.goes, 1);
    assert_true(ended(silent) && !ended(held) && !ended(late));
    give_descriptors_back();
    int later = client(true);
    say(later, COMMAND_STOP);
    take_all_descriptors();
    got.needed = got.peer; /* the newer one is needed, so the older one goes */
    for (int i = 0; i < 5; i++) serve();
    assert_int_equal(got.stops, 3);
    assert_true(ended(held) && !ended(late) && !ended(later));
    give_descriptors_back();
    close(held), close(silent), close(late), close(later);
    close_all();
}

/* Those who wait are accepted, but what is written afterwards has descriptors. */
static void at_the_end_four_descriptors_are_left(void **unused) {
    (void)unused;
    enum { WAITING = 10, LEFT = 4, FOR_CLIENTS = 2 };
    int waits[WAITING], left = 0;
    open_as("");
    for (int i = 0; i < WAITING; i++) waits[i] = client(true);
    take_all_descriptors();
    for (int i = 0; i < LEFT + FOR_CLIENTS; i++) close(taken.fd[--taken.count]);
    command_server_end(&server, &(struct command_answer){.outcome = OUTCOME_ENDED});
    /* the name's lock, which is closed too, is one more */
    for (int fd; (fd = dup(STDERR_FILENO)) >= 0; left++) taken.fd[taken.count++] = fd;
    assert_int_equal(left, LEFT + 1);
    give_descriptors_back();
    int heard = 0;
    for (int i = 0; i < WAITING; i++) {
        unsigned char packet[COMMAND_ANSWER_SIZE];
        heard += recv(waits[i], packet, sizeof packet, MSG_DONTWAIT) == COMMAND_ANSWER_SIZE;
        close(waits[i]);
    }
    assert_int_equal(heard, FOR_CLIENTS);
    close_all();
}

/* ---- names and directories ---- */

static void a_name_is_one_daemons_and_what_it_leaves_is_removed(void **unused) {
    (void)unused;
    struct command_server second, third;
    struct machine_name list[MACHINES_MAX];
    struct error error;
    open_as("");
    assert_string_equal(server.machine.name, "hexid");
    assert_int_equal(command_server_open(&second, "", &handler, &error), STATUS_OK);
    assert_string_equal(second.machine.name, "hexid-2");
    assert_int_equal(command_server_open(&third, "hexid-2", &handler, &error), STATUS_UNSAFE);
    assert_non_null(strstr(error.text, "machine.name"));
    assert_int_equal(machine_find("", list, &error), 2);
    assert_string_equal(list[1].name, "hexid-2");
    assert_int_equal(machine_find("hexid-2", list, &error), 1);
    assert_int_equal(machine_find("nobody", list, &error), 0);
    close_all(); /* the server's sockets remain, as after a kill */
    assert_int_equal(machine_find("", list, &error), 1);
    open_as("hexid");
    assert_int_equal(machine_find("", list, &error), 2);
    close_all();
    close_all_of(&second);
}

static void a_file_that_is_no_socket_is_not_deleted(void **unused) {
    (void)unused;
    char path[64];
    struct error error;
    snprintf(path, sizeof path, "%s/notes.stop", directory);
    close(open(path, O_CREAT | O_WRONLY | O_CLOEXEC, 0600));
    assert_int_equal(command_server_open(&server, "notes", &handler, &error), STATUS_UNSAFE);
    assert_non_null(strstr(error.text, "no socket"));
    assert_int_equal(unlink(path), 0);
    open_as("notes"); /* the name is free again */
    close_all();
}

static void a_socket_that_is_deleted_moved_or_replaced_is_missed(void **unused) {
    (void)unused;
    open_as("");
    for (int k = 0; k < COMMAND_SOCKETS; k++) {
        struct sockaddr_un at;
        char aside[128];
        machine_address(&server.machine, k == SOCKET_STOP, &at);
        snprintf(aside, sizeof aside, "%s.aside", at.sun_path);
        assert_int_equal(command_server_missing(&server), COMMAND_SOCKETS);
        assert_int_equal(rename(at.sun_path, aside), 0);
        assert_int_equal(command_server_missing(&server), k);
        close(open(at.sun_path, O_CREAT | O_WRONLY | O_CLOEXEC, 0600));
        assert_int_equal(command_server_missing(&server), k);
        assert_int_equal(rename(aside, at.sun_path), 0);
    }
    close_all();
    assert_int_equal(command_server_missing(&server), COMMAND_SOCKETS); /* none is open */
}

static void what_was_not_looked_at_is_doubt(void **unused) {
    (void)unused;
    struct machine_name list[MACHINES_MAX];
    struct error doubt;
    open_as("");
    assert_int_equal(machine_find("", list, &doubt), 1);
    assert_int_equal(doubt.status, STATUS_OK);
    /* a descriptor is left for the directory, and no other for the socket */
    take_all_descriptors();
    close(taken.fd[--taken.count]);
    assert_int_equal(machine_find("", list, &doubt), 0);
    give_descriptors_back();
    assert_int_equal(doubt.status, STATUS_IO);
    assert_non_null(strstr(doubt.text, ".stop: Too many open files"));
    close_all();
}

static void names_are_short_and_of_plain_letters(void **unused) {
    (void)unused;
    static const char *const wrong[] = {"", ".", "..", "a/b", "a b", "a.stop", "\xc3\xa4", "123456789012345678901234567890123"};
    for (int i = 0; i < 8; i++) assert_false(machine_name_valid(wrong[i]));
    assert_true(machine_name_valid("Rig_2-b") && machine_name_valid("12345678901234567890123456789012"));
}

static void modes_are_for_everybody_and_for_the_group(void **unused) {
    (void)unused;
    struct sockaddr_un at;
    struct stat s;
    mode_t before = umask(077);
    open_as("");
    machine_address(&server.machine, true, &at);
    assert_int_equal(stat(at.sun_path, &s), 0);
    assert_int_equal(s.st_mode & 0777, 0666);
    machine_address(&server.machine, false, &at);
    assert_int_equal(stat(at.sun_path, &s), 0);
    /* the mode depends on whether there is a group hexid */
    assert_true((s.st_mode & 0777) == 0660 || (s.st_mode & 0777) == 0600);
    assert_int_equal(umask(before), 077);
    close_all();
}

/* Whatever the starter's umask, everybody reaches the socket for stops and nobody else can lock the
 * name (read permission suffices for a lock). */
static void everybody_may_go_through_the_directory_and_nobody_may_lock_the_name(void **unused) {
    (void)unused;
    char path[64], lock[80];
    struct stat s;
    snprintf(path, sizeof path, "%s/made", directory);
    snprintf(lock, sizeof lock, "%s/hexid.lock", path);
    setenv("HEXID_RUNTIME_DIR", path, 1);
    for (int old = 0; old < 2; old++) {
        mode_t before = umask(old ? 0 : 077);
        if (old) chmod(lock, 0644); /* an earlier version's */
        open_as("");
        assert_int_equal(stat(path, &s), 0);
        assert_int_equal(s.st_mode & 0777, 0755);
        assert_int_equal(stat(lock, &s), 0);
        assert_int_equal(s.st_mode & 0777, 0600);
        umask(before);
        close_all();
    }
    setenv("HEXID_RUNTIME_DIR", directory, 1);
}

/* A user's directory full of unserved sockets leaves room for machines elsewhere and causes no
 * delay. */
static void one_directory_does_not_crowd_out_another(void **unused) {
    (void)unused;
    int listener[2 * MACHINES_EACH];
    static struct machine_name list[MACHINES_MAX];
    struct error doubt;
    for (int i = 0; i < 2 * MACHINES_EACH; i++) {
        struct sockaddr_un at = {.sun_family = AF_UNIX};
        snprintf(at.sun_path, sizeof at.sun_path, "%s/a%d.stop", directory, i);
        listener[i] = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
        assert_int_equal(bind(listener[i], (const struct sockaddr *)&at, sizeof at), 0);
        assert_int_equal(listen(listener[i], 0), 0);
    }
    assert_int_equal(machine_find("", list, &doubt), MACHINES_EACH);
    assert_non_null(strstr(doubt.text, "more than"));
    assert_true(MACHINES_EACH < MACHINES_MAX);
    for (int i = 0; i < 2 * MACHINES_EACH; i++) {
        char path[80];
        snprintf(path, sizeof path, "%s/a%d.stop", directory, i);
        unlink(path);
        close(listener[i]);
    }
}

static void refused(const char *path, const char *words) {
    struct error error;
    struct machine_name list[MACHINES_MAX];
    setenv("HEXID_RUNTIME_DIR", path, 1);
    assert_true(command_server_open(&server, "", &handler, &error) < 0);
    if (!strstr(error.text, words)) fail_msg("%s", error.text);
    assert_int_equal(machine_find("", list, &error), 0);
    setenv("HEXID_RUNTIME_DIR", directory, 1);
}

static void a_directory_that_others_may_change_is_refused(void **unused) {
    (void)unused;
    char path[64], link[64], name[200];
    snprintf(path, sizeof path, "%s/open", directory);
    snprintf(link, sizeof link, "%s/link", directory);
    mkdir(path, 0755);
    chmod(path, 0777);
    refused(path, "others may write there");
    chmod(path, 0770);
    refused(path, "others may write there");
    chmod(path, 0700);
    assert_int_equal(symlink(path, link), 0);
    refused(link, "no directory");
    unlink(link);
    if (geteuid() == 0) {
        if (!fork()) { /* runs as nobody, another user */
            chmod(path, 0755);
            if (setgid(65534) || setuid(65534)) _exit(0);
            refused(path, "Permission denied"); /* this user may not write in root's directory */
            _exit(0);
        }
        int status;
        wait(&status);
        assert_true(WIFEXITED(status) && !WEXITSTATUS(status));
    }
    rmdir(path);
    memset(name, 'x', sizeof name - 1), name[0] = '/', name[sizeof name - 1] = '\0';
    refused(name, "longer than");
}

static int make_directory(void **unused) {
    (void)unused;
    command_server_init(&server);
    return mkdtemp(directory) ? setenv("HEXID_RUNTIME_DIR", directory, 1) : -1;
}

static int remove_directory(void **unused) {
    (void)unused;
    char command[80];
    snprintf(command, sizeof command, "rm -rf %s", directory);
    return system(command);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(gains_come_back_and_of_no_other_size),
        cmocka_unit_test(packets_come_back_and_what_is_none_is_refused),
        cmocka_unit_test(requests_say_by_which_socket_they_came_and_are_answered),
        cmocka_unit_test(who_is_not_yet_accepted_hears_the_last_words_too),
        cmocka_unit_test(at_the_end_no_connection_is_closed_but_all_are_over),
        cmocka_unit_test(once_nothing_is_driven_the_rest_of_a_round_is_dropped),
        cmocka_unit_test(who_comes_when_the_loop_ends_hears_the_last_words),
        cmocka_unit_test(a_stop_passes_beside_hundreds_of_idle_connections),
        cmocka_unit_test(one_that_floods_does_not_hold_another_up),
        cmocka_unit_test(no_connection_is_closed_over_a_stop_that_waits_in_it),
        cmocka_unit_test(who_is_needed_is_not_closed_and_a_stop_is_taken_without_a_place),
        cmocka_unit_test(garbage_ends_the_connection_that_it_came_by),
        cmocka_unit_test(what_moves_is_not_taken_from_who_has_gone_and_a_stop_is),
        cmocka_unit_test(who_does_not_read_its_answers_is_closed_and_waited_for_by_nobody),
        cmocka_unit_test(a_stop_counts_whatever_waits_before_it),
        cmocka_unit_test(descriptors_are_refused),
        cmocka_unit_test(without_a_descriptor_the_listener_rests_and_then_takes_who_waited),
        cmocka_unit_test(without_a_descriptor_the_silent_connection_makes_room_for_a_stop),
        cmocka_unit_test(at_the_end_four_descriptors_are_left),
        cmocka_unit_test(a_name_is_one_daemons_and_what_it_leaves_is_removed),
        cmocka_unit_test(a_file_that_is_no_socket_is_not_deleted),
        cmocka_unit_test(a_socket_that_is_deleted_moved_or_replaced_is_missed),
        cmocka_unit_test(what_was_not_looked_at_is_doubt),
        cmocka_unit_test(names_are_short_and_of_plain_letters),
        cmocka_unit_test(modes_are_for_everybody_and_for_the_group),
        cmocka_unit_test(everybody_may_go_through_the_directory_and_nobody_may_lock_the_name),
        cmocka_unit_test(one_directory_does_not_crowd_out_another),
        cmocka_unit_test(a_directory_that_others_may_change_is_refused),
    };
    return cmocka_run_group_tests(tests, make_directory, remove_directory);
}
