/* A machine has one master per host, whoever starts it, by whatever name, and whoever tries to
 * block it. */
#include "support.h"

#include <fcntl.h>
#include <pty.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include "host_lock.h"
#include "machine_lock.h"

enum { NOBODY = 65534, SOMEBODY = 65533 }; /* user ids */

static struct error error;

/* Returns URLs of machines that only this process uses, because other tests may run at the same
 * time. */
static const char *tcp(const char *host) {
    static char url[2][100];
    static int at;
    at = !at;
    snprintf(url[at], sizeof url[at], "modbus:tcp://%s:%d", host, 1024 + (int)getpid() % 60000);
    return url[at];
}

static const char *can(void) {
    static char url[40];
    snprintf(url, sizeof url, "can:t%d", (int)getpid());
    return url;
}

static int status_of(const char *url) {
    struct machine_lock l;
    int status = machine_lock(&l, url, &error);
    if (!status) machine_unlock(&l);
    return status;
}

/* A descriptor in a packet that nobody reads could hold up the daemon where the connection is
 * closed. */
static void the_lock_refuses_descriptors(void **unused) {
    (void)unused;
    struct machine_lock l;
    int passes = 1;
    socklen_t length = sizeof passes;
    assert_int_equal(machine_lock(&l, can(), &error), STATUS_OK);
    int known = getsockopt(l.file[0], SOL_SOCKET, 83 /* SO_PASSRIGHTS */, &passes, &length);
    machine_unlock(&l);
    if (known) skip(); /* Linux before 6.16 */
    assert_int_equal(passes, 0);
}

/* ---- names ---- */

static void all_names_of_a_serial_line_are_one(void **unused) {
    (void)unused;
    int master, slave;
    char name[100], direct[200], link[] = "/tmp/hexid-line-XXXXXX", by_link[200];
    struct machine_lock l;
    assert_int_equal(openpty(&master, &slave, name, NULL, NULL), 0);
    close(mkstemp(link));
    unlink(link);
    assert_int_equal(symlink(name, link), 0);
    snprintf(direct, sizeof direct, "modbus:rtu:%s?baud=115200", name);
    snprintf(by_link, sizeof by_link, "modbus:rtu:%s?baud=9600", link);
    assert_int_equal(machine_lock(&l, direct, &error), STATUS_OK);
    assert_int_equal(status_of(by_link), STATUS_UNSAFE);
    assert_non_null(strstr(error.text, "another hexid on this host drives this machine, process "));
    machine_unlock(&l);
    assert_int_equal(status_of(by_link), STATUS_OK);
    unlink(link);
    assert_int_equal(status_of(by_link), STATUS_IO);
    assert_non_null(strstr(error.text, "No such file"));
    close(master), close(slave);
}

static void all_spellings_of_an_address_of_this_host_are_one(void **unused) {
    (void)unused;
    static const char *const spelt[] = {"127.0.0.1", "localhost", "127.1", "2130706433", "0.0.0.0", "127.0.0.2", "[::ffff:127.0.0.1]"};
    enum { COUNT = sizeof spelt / sizeof *spelt };
    struct machine_lock l;
    for (int i = 0; i < COUNT; i++) {
        assert_int_equal(machine_lock(&l, tcp(spelt[i]), &error), STATUS_OK);
        for (int j = 0; j < COUNT; j++) assert_int_equal(status_of(tcp(spelt[j])), STATUS_UNSAFE);
        assert_int_equal(status_of(tcp("192.0.2.7")), STATUS_OK);
        machine_unlock(&l);
    }
    assert_int_equal(machine_lock(&l, tcp("127.0.0.1"), &error), STATUS_OK);
    assert_int_equal(status_of("modbus:tcp://127.0.0.1:1"), STATUS_OK); /* another port */
    assert_int_equal(status_of(can()), STATUS_OK);
    machine_unlock(&l);
}

static void what_is_put_in_front_of_a_machine_does_not_count(void **unused) {
    (void)unused;
    char url[200];
    struct machine_lock l;
    snprintf(url, sizeof url, "fault:drop=0.1;%s", can());
    assert_int_equal(machine_lock(&l, can(), &error), STATUS_OK);
    assert_int_equal(status_of(url), STATUS_UNSAFE);
    machine_unlock(&l);
    assert_int_equal(status_of("sim:"), STATUS_OK);
    assert_int_equal(machine_lock(&l, "sim:", &error), STATUS_OK);
    assert_int_equal(l.count, 0);
}

/* ---- users ---- */

/* A process of another user that occupies the first of these slots until it is ended. */
struct other {
    pid_t process;
    int end;
};

static bool bind_slot(const char *name, int slot) {
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    int length = snprintf(address.sun_path + 1, sizeof address.sun_path - 1, "hexid-machine/%s/%d", name, slot);
    int s = socket(AF_UNIX, SOCK_SEQPACKET, 0);
    return !bind(s, (struct sockaddr *)&address, (socklen_t)(offsetof(struct sockaddr_un, sun_path) + 1 + (size_t)length)) && !listen(s, 1);
}

static struct other begin(uid_t user, const char *url, const char *name, int slots) {
    int ready[2], end[2];
    char answer = 'n';
    assert_false(pipe(ready) || pipe(end));
    pid_t child = fork();
    if (child == 0) {
        struct machine_lock l;
        bool held = !setgid(user) && !setuid(user);
        close(end[1]);
        for (int i = 0; i < slots; i++) held = held && bind_slot(name, i);
        if (!slots) held = held && !machine_lock(&l, url, &error);
        if (write(ready[1], held ? "y" : "n", 1) == 1) (void)!read(end[0], &answer, 1);
        _exit(0);
    }
    assert_int_equal(read(ready[0], &answer, 1), 1);
    assert_int_equal(answer, 'y');
    close(ready[0]), close(ready[1]), close(end[0]);
    return (struct other){child, end[1]};
}

static void finish(struct other o) {
    close(o.end);
    assert_int_equal(waitpid(o.process, NULL, 0), o.process);
}

static void a_stranger_is_named_and_not_waited_for(void **unused) {
    (void)unused;
    if (geteuid()) skip_because("root alone can be several users");
    for (int slots = 1; slots <= HOST_LOCK_SLOTS; slots += HOST_LOCK_SLOTS - 1) {
        char who[60], name[40];
        struct machine_lock l;
        snprintf(name, sizeof name, "can/%s", can() + 4);
        struct other stranger = begin(NOBODY, can(), name, slots);
        snprintf(who, sizeof who, "process %ld of user nobody has the lock", (long)stranger.process);
        assert_int_equal(machine_lock(&l, can(), &error), STATUS_OK);
        assert_int_equal(l.doubt.status, STATUS_UNSAFE);
        assert_non_null(strstr(l.doubt.text, who));
        /* beside a stranger's lock our own counts */
        if (slots < HOST_LOCK_SLOTS) assert_int_equal(status_of(can()), STATUS_UNSAFE);
        machine_unlock(&l);
        finish(stranger);
    }
}

static void roots_lock_is_seen_by_all_users(void **unused) {
    (void)unused;
    if (geteuid()) skip_because("root alone can be several users");
    struct machine_lock l;
    int status;
    assert_int_equal(machine_lock(&l, can(), &error), STATUS_OK);
    const char *machine = can();
    char who[60];
    snprintf(who, sizeof who, "process %ld of user root", (long)getpid());
    pid_t child = fork();
    if (child == 0) _exit(setuid(NOBODY) || status_of(machine) != STATUS_UNSAFE || !strstr(error.text, who));
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_int_equal(status, 0);
    machine_unlock(&l);
}

static void who_may_write_a_device_has_its_lock_and_nobody_else(void **unused) {
    (void)unused;
    int master, slave;
    char name[100], url[200], key[60];
    struct machine_lock l;
    struct stat s;
    if (geteuid()) skip_because("root alone can be several users");
    assert_int_equal(openpty(&master, &slave, name, NULL, NULL), 0);
    assert_false(chown(name, NOBODY, 0) || chmod(name, 0600) || stat(name, &s));
    snprintf(url, sizeof url, "modbus:rtu:%s?baud=115200", name);
    snprintf(key, sizeof key, "tty/%u:%u", (unsigned)(s.st_rdev >> 8 & 0xfff), (unsigned)(s.st_rdev & 0xff));
    struct other owner = begin(NOBODY, url, key, 0);
    assert_int_equal(status_of(url), STATUS_UNSAFE);
    finish(owner);
    struct other stranger = begin(SOMEBODY, url, key, 1);
    assert_int_equal(machine_lock(&l, url, &error), STATUS_OK);
    assert_int_equal(l.doubt.status, STATUS_UNSAFE);
    machine_unlock(&l);
    assert_int_equal(chown(name, NOBODY, SOMEBODY) || chmod(name, 0620), 0);
    assert_int_equal(status_of(url), STATUS_UNSAFE); /* the group now permits access to the lock */
    finish(stranger);
    close(master), close(slave);
}

/* Nobody empties this queue, so the lock's holder cannot be asked for an identity. */
static void who_does_not_say_who_he_is_is_a_stranger(void **unused) {
    (void)unused;
    char name[40];
    struct machine_lock l;
    if (geteuid()) skip_because("root alone can be several users");
    snprintf(name, sizeof name, "can/%s", can() + 4);
    struct other stranger = begin(NOBODY, can(), name, 1);
    for (int i = 0; i < 4; i++) {
        assert_int_equal(machine_lock(&l, can(), &error), STATUS_OK);
        assert_int_equal(l.doubt.status, STATUS_UNSAFE);
        machine_unlock(&l);
    }
    assert_non_null(strstr(l.doubt.text, "somebody has the lock"));
    finish(stranger);
}

/* There are more attempts than the C library and the kernel allow to wait in a queue. */
static void a_lock_counts_however_often_it_is_asked_for(void **unused) {
    (void)unused;
    enum { QUEUE = 4096, BETWEEN = 64 };
    struct machine_lock l, again;
    assert_int_equal(machine_lock(&l, can(), &error), STATUS_OK);
    for (int i = 0; i < QUEUE + 2 * BETWEEN; i++) {
        int status = machine_lock(&again, can(), &error);
        if (status != STATUS_UNSAFE) fail_msg("at the %dth time: %d", i, status);
        if (i % BETWEEN == 0) machine_lock_answer(&l);
    }
    machine_unlock(&l);
}

/* ---- simultaneous starts ---- */

static void of_many_that_start_at_once_one_at_most_has_it(void **unused) {
    (void)unused;
    enum { STARTERS = 6, ROUNDS = 40 };
    const char *machine = can();
    for (int round = 0; round < ROUNDS; round++) {
        int go[2], got[2], end[2], held = 0;
        char answer;
        assert_false(pipe(go) || pipe(got) || pipe(end));
        for (int i = 0; i < STARTERS; i++)
            if (fork() == 0) {
                struct machine_lock l;
                close(go[1]), close(end[1]);
                (void)!read(go[0], &answer, 1);
                const char *said = machine_lock(&l, machine, &error) ? "n" : "y";
                if (write(got[1], said, 1) == 1) (void)!read(end[0], &answer, 1);
                _exit(0);
            }
        close(go[0]), close(go[1]), close(end[0]);
        for (int i = 0; i < STARTERS; i++) {
            assert_int_equal(read(got[0], &answer, 1), 1);
            held += answer == 'y';
        }
        close(end[1]), close(got[0]), close(got[1]);
        while (waitpid(-1, NULL, 0) > 0) continue;
        assert_true(held <= 1);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_lock_refuses_descriptors),
        cmocka_unit_test(all_names_of_a_serial_line_are_one),
        cmocka_unit_test(all_spellings_of_an_address_of_this_host_are_one),
        cmocka_unit_test(what_is_put_in_front_of_a_machine_does_not_count),
        cmocka_unit_test(a_stranger_is_named_and_not_waited_for),
        cmocka_unit_test(roots_lock_is_seen_by_all_users),
        cmocka_unit_test(who_may_write_a_device_has_its_lock_and_nobody_else),
        cmocka_unit_test(who_does_not_say_who_he_is_is_a_stranger),
        cmocka_unit_test(a_lock_counts_however_often_it_is_asked_for),
        cmocka_unit_test(of_many_that_start_at_once_one_at_most_has_it),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
