/* The service manager's socket: messages, valid names, and errors for other names. */
#include "support.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "notify.h"

static char directory[] = "/tmp/notify.XXXXXX", path[64], abstract[64];

/* Opens a manager's socket with this name; "@" marks one without a file. */
static int listen_on(const char *name) {
    struct sockaddr_un at = {.sun_family = AF_UNIX};
    memcpy(at.sun_path, name, strlen(name));
    if (name[0] == '@') at.sun_path[0] = '\0';
    int file = socket(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK, 0);
    assert_int_equal(bind(file, (struct sockaddr *)&at, (socklen_t)(offsetof(struct sockaddr_un, sun_path) + strlen(name))), 0);
    setenv("NOTIFY_SOCKET", name, 1);
    return file;
}

static void hears(int manager, const char *expected) {
    char text[64];
    ssize_t length = recv(manager, text, sizeof text - 1, 0);
    if (!expected) {
        assert_int_equal(length, -1);
        assert_int_equal(errno, EAGAIN);
        return;
    }
    assert_true(length > 0);
    text[length] = '\0';
    assert_string_equal(text, expected);
}

static int fresh(void **unused) {
    (void)unused;
    unsetenv("NOTIFY_SOCKET");
    unsetenv("WATCHDOG_USEC");
    unsetenv("WATCHDOG_PID");
    unlink(path);
    return 0;
}

static void without_a_manager_nothing_is_wrong(void **unused) {
    (void)unused;
    struct notify n;
    struct error error;
    assert_int_equal(notify_open(&n, &error), STATUS_OK);
    notify_send(&n, "READY=1");
    notify_alive(&n);
    notify_close(&n);
}

static void both_kinds_of_names_are_heard(void **unused) {
    (void)unused;
    const char *const names[] = {path, abstract};
    for (int i = 0; i < 2; i++) {
        struct notify n;
        struct error error;
        int manager = listen_on(names[i]);
        assert_int_equal(notify_open(&n, &error), STATUS_OK);
        notify_send(&n, "READY=1");
        hears(manager, "READY=1");
        notify_alive(&n); /* sends nothing, because no watchdog was requested */
        hears(manager, NULL);
        notify_close(&n);
        close(manager);
    }
}

static void a_sign_of_life_comes_twice_in_the_time_allowed(void **unused) {
    (void)unused;
    struct notify n;
    struct error error;
    int manager = listen_on(path);
    setenv("WATCHDOG_USEC", "2000000", 1);
    assert_int_equal(notify_open(&n, &error), STATUS_OK);
    assert_true(n.every_ns == 1000000000);
    notify_alive(&n);
    hears(manager, "WATCHDOG=1");
    notify_alive(&n);
    hears(manager, NULL);
    n.alive_ns -= n.every_ns; /* as if the interval between two messages had passed */
    notify_alive(&n);
    hears(manager, "WATCHDOG=1");
    notify_close(&n);
    close(manager);
}

static void a_watchdog_of_another_process_or_of_no_number_is_none(void **unused) {
    (void)unused;
    struct notify n;
    struct error error;
    int manager = listen_on(path);
    setenv("WATCHDOG_USEC", "2000000", 1);
    setenv("WATCHDOG_PID", "1", 1);
    assert_int_equal(notify_open(&n, &error), STATUS_OK);
    assert_true(n.every_ns == 0);
    notify_close(&n);
    unsetenv("WATCHDOG_PID");
    const char *const wrong[] = {"", "soon", "-5", "99999999999999999999"};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        setenv("WATCHDOG_USEC", wrong[i], 1);
        assert_int_equal(notify_open(&n, &error), STATUS_OK);
        assert_true(n.every_ns == 0);
        notify_close(&n);
    }
    close(manager);
}

static void a_manager_that_takes_nothing_holds_nobody_up(void **unused) {
    (void)unused;
    struct notify n;
    struct error error;
    int manager = listen_on(path);
    assert_int_equal(notify_open(&n, &error), STATUS_OK);
    /* more messages than any socket's queue has room for */
    for (int i = 0; i < 100000; i++) notify_send(&n, "STATUS=settled");
    close(manager);
    notify_send(&n, "STATUS=settled"); /* nobody listens any more: this causes neither a signal nor
                                        * an exit */
    notify_close(&n);
}

static void a_name_that_cannot_be_is_an_error_that_names_it(void **unused) {
    (void)unused;
    char longest[200];
    memset(longest, 'x', sizeof longest);
    longest[0] = '/', longest[sizeof longest - 1] = '\0';
    const char *const wrong[] = {"relative", "/", "@", "/nowhere/notify", longest};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        struct notify n;
        struct error error;
        setenv("NOTIFY_SOCKET", wrong[i], 1);
        assert_int_equal(notify_open(&n, &error), STATUS_IO);
        assert_non_null(strstr(error.text, "NOTIFY_SOCKET="));
        assert_int_equal(n.socket, -1);
        notify_send(&n, "READY=1");
    }
}

static int make_directory(void **unused) {
    (void)unused;
    if (!mkdtemp(directory)) return -1;
    snprintf(path, sizeof path, "%s/socket", directory);
    snprintf(abstract, sizeof abstract, "@%s", directory);
    return 0;
}

static int remove_directory(void **unused) {
    fresh(unused);
    return rmdir(directory);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(without_a_manager_nothing_is_wrong, fresh),
        cmocka_unit_test_setup(both_kinds_of_names_are_heard, fresh),
        cmocka_unit_test_setup(a_sign_of_life_comes_twice_in_the_time_allowed, fresh),
        cmocka_unit_test_setup(a_watchdog_of_another_process_or_of_no_number_is_none, fresh),
        cmocka_unit_test_setup(a_manager_that_takes_nothing_holds_nobody_up, fresh),
        cmocka_unit_test_setup(a_name_that_cannot_be_is_an_error_that_names_it, fresh),
    };
    return cmocka_run_group_tests(tests, make_directory, remove_directory);
}
