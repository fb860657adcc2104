/* The device side of Modbus on TCP as `hexid plant` serves it, and clients that behave badly. */
#include "support.h"

#include <arpa/inet.h>
#include <poll.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <sys/socket.h>
#include <unistd.h>

#include "backends.h"
#include "device.h"

/* A request for registers 0 and 1. */
static const uint8_t question[] = {0, 1, 0, 0, 0, 6, 1, 3, 0, 0, 0, 2};
enum { ANSWER = 13, PATIENCE_MS = 60000 /* far beyond what any host needs */ };

struct served {
    struct params params;
    struct device *device;
    pthread_t thread;
    struct sockaddr_in at;
    _Atomic bool stop;
};

static void *serve(void *argument) {
    struct served *s = argument;
    struct error error = {0};
    char address[64];
    snprintf(address, sizeof address, "tcp://127.0.0.1:%d", ntohs(s->at.sin_port));
    if (device_modbus.serve(address, &s->params, s->device, &s->stop, &error)) print_error("%s\n", error.text);
    return NULL;
}

static void served_begin(struct served *s) {
    struct error error;
    socklen_t size = sizeof s->at;
    int reserved = socket(AF_INET, SOCK_STREAM, 0);
    config_default(&s->params);
    s->params.sim.engine = ENGINE_CLOSED_FORM;
    s->device = device_create(&s->params, 1, &error);
    assert_non_null(s->device);
    s->at = (struct sockaddr_in){.sin_family = AF_INET, .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    assert_false(bind(reserved, (struct sockaddr *)&s->at, size) || getsockname(reserved, (struct sockaddr *)&s->at, &size));
    close(reserved);
    assert_int_equal(pthread_create(&s->thread, NULL, serve, s), 0);
}

static void served_end(struct served *s) {
    s->stop = true;
    pthread_join(s->thread, NULL);
    device_destroy(s->device);
}

/* Connects as soon as the device listens. */
static int client(const struct served *s) {
    int small = 2048;
    for (;; sched_yield()) {
        int fd = socket(AF_INET, SOCK_STREAM, 0);
        setsockopt(fd, SOL_SOCKET, SO_RCVBUF, &small, sizeof small);
        if (!connect(fd, (const struct sockaddr *)&s->at, sizeof s->at)) return fd;
        close(fd);
    }
}

static bool comes(int fd, short events) {
    struct pollfd p = {.fd = fd, .events = events};
    return poll(&p, 1, PATIENCE_MS) > 0;
}

static void ask(int fd, int count) {
    for (int i = 0; i < count; i++) (void)!send(fd, question, sizeof question, MSG_NOSIGNAL);
}

/* No other client connects meanwhile, and the device does not wait for one. */
static void a_client_alone_is_answered(void **unused) {
    (void)unused;
    struct served s = {0};
    uint8_t answer[ANSWER];
    served_begin(&s);
    int fd = client(&s);
    ask(fd, 1);
    bool answered = comes(fd, POLLIN) && recv(fd, answer, sizeof answer, MSG_WAITALL) == ANSWER;
    close(fd);
    if (!answered) _exit(1); /* exits, because the device's thread would never end */
    served_end(&s);
}

/* The answers to 2000 requests are more than both buffers have room for. */
static void a_client_that_reads_no_answers_is_cut_off(void **unused) {
    (void)unused;
    struct served s = {0};
    served_begin(&s);
    int fd = client(&s);
    ask(fd, 2000);
    bool cut = comes(fd, 0); /* POLLHUP or POLLERR */
    close(fd);
    served_end(&s);
    assert_true(cut);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_client_alone_is_answered),
        cmocka_unit_test(a_client_that_reads_no_answers_is_cut_off),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
