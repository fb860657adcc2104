/* Actions that a confined process may and may not take, each in a child, which survives to
 * report. */
#include "support.h"

#include <arpa/inet.h>
#include <errno.h>
#include <fcntl.h>
#include <linux/capability.h>
#include <net/if.h>
#include <pthread.h>
#include <seccomp.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/mount.h>
#include <sys/prctl.h>
#include <sys/ptrace.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include "confine.h"
#include "notify.h"
#include "output.h"

static char directory[] = "/tmp/confine.XXXXXX", result[64], other[64];
static int listener;           /* socket that takes commands */
static struct output to;
static struct notify manager; /* opened before the process is confined, as in the daemon */

/* If set, renameat2() refuses flags as network file systems do. */
static bool no_rename_flags;
static int refuse_rename_flags(void) {
    scmp_filter_ctx filter = seccomp_init(SCMP_ACT_ALLOW);
    int failed = seccomp_rule_add(filter, SCMP_ACT_ERRNO(EINVAL), SCMP_SYS(renameat2), 1, SCMP_A4(SCMP_CMP_NE, 0));
    if (!failed) failed = seccomp_load(filter);
    seccomp_release(filter);
    return failed;
}

/* Returns true if the confined child's action succeeded. */
static bool in_child(bool (*does)(const char *path), enum hal_reopens reopens) {
    pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        struct error error;
        if (output_prepare(&to, result, OUTPUT_RESULT, &error)) _exit(2);
        if (no_rename_flags && refuse_rename_flags()) _exit(2);
        if (confine(&(struct confinement){.result = &to, .reopens = reopens}, &error)) _exit(2);
        _exit(!does(to.beside));
    }
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFEXITED(status)); /* never killed */
    assert_true(WEXITSTATUS(status) != 2);
    return WEXITSTATUS(status) == 0;
}

static bool denied(long returned) { return returned == -1 && errno == EPERM; }

static void *nothing(void *argument) { return argument; }

static bool no_program(const char *path) {
    char *none[] = {NULL};
    (void)path;
    return denied(execve("/bin/true", none, none)) && denied(syscall(SYS_execveat, -1, "/bin/true", none, none, 0)) &&
           denied(syscall(SYS_fork)) && denied(syscall(SYS_vfork)) && denied(syscall(SYS_clone, SIGCHLD, 0, 0, 0, 0));
}

static bool no_thread(const char *path) {
    pthread_t thread;
    (void)path;
    return pthread_create(&thread, NULL, nothing, NULL) == EPERM;
}

static bool no_other_file(const char *path) {
    char copy[64];
    strcpy(copy, path);
    return denied(open(other, O_WRONLY | O_CREAT | O_TRUNC, 0666)) && denied(open(other, O_RDWR)) &&
           denied(open("/etc/shadow", O_RDONLY)) && denied(open(copy, O_WRONLY | O_CREAT | O_TRUNC, 0666)) &&
           denied(open(path, O_RDWR | O_CREAT, 0666)) && denied(unlink(other)) && denied(rename(other, result)) &&
           denied(open(copy, OUTPUT_FLAGS, 0666)) && denied(open(to.path, OUTPUT_FLAGS, 0666)) && denied(unlinkat(AT_FDCWD, copy, 0)) &&
           denied(unlinkat(AT_FDCWD, to.path, 0)) && denied(renameat2(AT_FDCWD, copy, AT_FDCWD, to.path, to.rename_flags)) &&
           denied(renameat2(AT_FDCWD, to.path, AT_FDCWD, path, to.rename_flags)) &&
           denied(renameat2(AT_FDCWD, path, AT_FDCWD, to.path, RENAME_EXCHANGE)) && denied(linkat(AT_FDCWD, path, AT_FDCWD, other, 0)) &&
           denied(linkat(AT_FDCWD, copy, AT_FDCWD, to.path, 0)) && denied(linkat(AT_FDCWD, to.path, AT_FDCWD, path, 0)) &&
           denied(mkdir(other, 0777)) && denied(chmod(other, 0777)) && denied(syscall(SYS_openat2, AT_FDCWD, path, NULL, 0)) &&
           denied(syscall(SYS_creat, other, 0666));
}

static bool no_other_path(const char *path) {
    char *page = (char *)(uintptr_t)path, *second = (char *)(uintptr_t)to.path;
    struct iovec here = {.iov_base = other, .iov_len = sizeof other}, there = {.iov_base = page, .iov_len = sizeof other};
    return denied(mprotect(page, 4096, PROT_READ | PROT_WRITE)) && denied(munmap(page, 4096)) &&
           denied(mprotect(second, 4096, PROT_READ | PROT_WRITE)) && denied(munmap(second, 4096)) &&
           denied(mprotect(page - 4096, 8192, PROT_READ | PROT_WRITE)) && denied(madvise(page, 4096, MADV_DONTNEED)) &&
           mmap(page, 4096, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_FIXED, -1, 0) == MAP_FAILED && errno == EPERM &&
           mremap(page, 4096, 8192, MREMAP_MAYMOVE) == MAP_FAILED && errno == EPERM &&
           denied(process_vm_writev(getpid(), &here, 1, &there, 1, 0)) && denied(open("/proc/self/mem", O_RDWR));
}

enum { SERIAL_FLAGS = O_RDWR | O_NOCTTY | O_NONBLOCK | O_EXCL };

static bool no_file_for_writing(const char *path) {
    (void)path;
    return denied(open(other, SERIAL_FLAGS)) && denied(open("/proc/self/mem", SERIAL_FLAGS)) && denied(open(other, O_RDWR)) &&
           denied(open(other, O_WRONLY | O_CREAT, 0666));
}

static bool a_serial_device_is_opened(const char *path) {
    (void)path;
    int file = open("/dev/null", SERIAL_FLAGS);
    return file >= 0 && denied(open(other, O_RDWR)) && denied(open("/etc/passwd", O_RDONLY)) && denied(socket(AF_INET, SOCK_STREAM, 0));
}

static bool no_code(const char *path) {
    (void)path;
    void *data = mmap(NULL, 4096, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    bool ordinary = data != MAP_FAILED && !mprotect(data, 4096, PROT_READ);
    return ordinary && denied(mprotect(data, 4096, PROT_READ | PROT_EXEC)) &&
           mmap(NULL, 4096, PROT_READ | PROT_EXEC, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0) == MAP_FAILED && errno == EPERM;
}

static bool no_socket(const char *path) {
    (void)path;
    return denied(socket(AF_INET, SOCK_STREAM, 0)) && denied(socket(AF_INET, SOCK_DGRAM, 0)) && denied(socket(AF_UNIX, SOCK_STREAM, 0)) &&
           denied(socket(AF_PACKET, SOCK_RAW, 0)) && denied(socket(AF_NETLINK, SOCK_RAW, 0));
}

static bool no_other_process(const char *path) {
    (void)path;
    return denied(ptrace(PTRACE_ATTACH, getppid(), 0, 0)) && denied(ptrace(PTRACE_TRACEME, 0, 0, 0)) && denied(kill(getppid(), 0)) &&
           denied(syscall(SYS_tgkill, getppid(), getppid(), 0)) && denied(syscall(SYS_pidfd_open, getppid(), 0));
}

static bool no_rights(const char *path) {
    struct sched_param priority = {.sched_priority = 10};
    struct __user_cap_header_struct header = {.version = _LINUX_CAPABILITY_VERSION_3};
    struct __user_cap_data_struct all[2] = {{~0u, ~0u, 0}, {~0u, ~0u, 0}};
    int character = 'x';
    (void)path;
    return denied(setuid(0)) && denied(mount("none", "/mnt", "tmpfs", 0, NULL)) && denied(syscall(SYS_init_module, NULL, 0, "")) &&
           denied(syscall(SYS_bpf, 0, NULL, 0)) && denied(syscall(SYS_unshare, 0)) && denied(syscall(SYS_capset, &header, all)) &&
           denied(sched_setscheduler(0, SCHED_FIFO, &priority)) && denied(ioctl(0, TIOCSTI, &character)) &&
           denied(prctl(PR_SET_DUMPABLE, 1, 0, 0, 0)) && denied(syscall(SYS_io_uring_setup, 1, NULL));
}

static bool the_result_is_written(const char *path) {
    struct error error;
    (void)path;
    return !output_write(&to, "result", &error);
}

static bool what_is_open_works(const char *path) {
    struct timespec t = {.tv_nsec = 1000};
    void *block = malloc(1 << 20);
    (void)path;
    free(block);
    return block && clock_nanosleep(CLOCK_MONOTONIC, 0, &t, NULL) == 0 && !raise(0) && dprintf(STDERR_FILENO, "%s", "") == 0;
}

static bool the_manager_is_told(const char *path) {
    (void)path;
    manager.every_ns = 1;
    notify_send(&manager, "READY=1\n");
    notify_alive(&manager);
    return denied(socket(AF_UNIX, SOCK_DGRAM, 0));
}

/* The listening socket was open before. No other socket can be created, and none can be bound to
 * another address. */
static bool connections_are_accepted(const char *path) {
    struct sockaddr_un elsewhere = {.sun_family = AF_UNIX, .sun_path = "/tmp/hexid-nowhere"};
    char byte = 0;
    (void)path;
    int fd = accept4(listener, NULL, NULL, SOCK_NONBLOCK | SOCK_CLOEXEC);
    return fd >= 0 && recv(fd, &byte, 1, 0) == 1 && send(fd, &byte, 1, MSG_NOSIGNAL) == 1 && !close(fd) &&
           denied(syscall(SYS_accept, listener, NULL, NULL)) && denied(socket(AF_UNIX, SOCK_SEQPACKET, 0)) &&
           denied(bind(listener, (struct sockaddr *)&elsewhere, sizeof elsewhere)) && denied(listen(listener, 1)) &&
           denied(connect(listener, (struct sockaddr *)&elsewhere, sizeof elsewhere)) && denied(unlink(other));
}

static bool a_connection_is_made_again(const char *path) {
    struct sockaddr_in nobody = {.sin_family = AF_INET, .sin_addr.s_addr = htonl(INADDR_LOOPBACK), .sin_port = htons(9)};
    int tcp = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0), reached = connect(tcp, (struct sockaddr *)&nobody, sizeof nobody);
    bool tried = tcp >= 0 && (reached == 0 || errno != EPERM), read = open("/etc/passwd", O_RDONLY | O_CLOEXEC) >= 0;
    (void)path;
    return tried && read && denied(bind(tcp, (struct sockaddr *)&nobody, sizeof nobody)) && denied(listen(tcp, 1)) &&
           denied(socket(AF_UNIX, SOCK_STREAM, 0)) && denied(socket(AF_PACKET, SOCK_RAW, 0)) &&
           denied(open(other, O_WRONLY | O_CREAT | O_TRUNC, 0666)) && denied(open("/tmp", O_TMPFILE | O_RDWR, 0666));
}

#define SKIP_SANITIZED() if (SANITIZED) skip_because("sanitizer builds are not confined")

static void what_is_denied_fails_and_kills_nobody(void **unused) {
    (void)unused;
    SKIP_SANITIZED();
    static bool (*const all[])(const char *) = {no_program, no_thread, no_other_file,    no_other_path,
                                                no_code,    no_socket, no_other_process, no_rights};
    for (unsigned i = 0; i < sizeof all / sizeof *all; i++)
        if (!in_child(all[i], HAL_REOPENS_NOTHING)) fail_msg("%u of the list", i);
    static bool (*const reconnecting[])(const char *) = {no_program, no_thread,        no_other_path,
                                                         no_code,    no_other_process, no_file_for_writing};
    for (unsigned i = 0; i < sizeof reconnecting / sizeof *reconnecting; i++)
        if (!in_child(reconnecting[i], HAL_REOPENS_SOCKETS)) fail_msg("reconnecting: %u of the list", i);
    static bool (*const serial[])(const char *) = {no_program, no_thread, no_code, no_socket, no_other_process, no_rights};
    for (unsigned i = 0; i < sizeof serial / sizeof *serial; i++)
        if (!in_child(serial[i], HAL_REOPENS_SERIAL)) fail_msg("on a serial line: %u of the list", i);
}

/* True if a CAN socket can be opened, and no other. A kernel without CAN fails the call too, but
 * with another error. */
static bool a_can_socket_is_opened_again_and_no_other(const char *path) {
    struct ifreq r = {.ifr_name = "lo"};
    struct sockaddr_in nobody = {.sin_family = AF_INET, .sin_port = htons(9), .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    (void)path;
    int asks = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    if (asks < 0 || ioctl(asks, SIOCGIFINDEX, &r) || ioctl(asks, SIOCGIFFLAGS, &r)) return false;
    if (!denied(connect(asks, (struct sockaddr *)&nobody, sizeof nobody)) || !denied(ioctl(asks, SIOCSIFFLAGS, &r))) return false;
    if (denied(socket(AF_CAN, SOCK_RAW | SOCK_CLOEXEC, 1))) return false;
    return denied(socket(AF_INET, SOCK_STREAM, 0)) && denied(socket(AF_PACKET, SOCK_RAW, 0)) && denied(socket(AF_NETLINK, SOCK_RAW, 0));
}

static void a_back_end_on_can_opens_its_socket_again_and_may_do_no_more_for_it(void **unused) {
    (void)unused;
    SKIP_SANITIZED();
    static bool (*const does[])(const char *) = {no_program, no_thread, no_other_path, no_code, no_other_process, no_rights};
    assert_true(in_child(a_can_socket_is_opened_again_and_no_other, HAL_REOPENS_CAN));
    for (unsigned i = 0; i < sizeof does / sizeof *does; i++)
        if (!in_child(does[i], HAL_REOPENS_CAN)) fail_msg("%u of the list", i);
}

static void what_the_daemon_needs_works(void **unused) {
    (void)unused;
    SKIP_SANITIZED();
    char text[8] = "";
    assert_true(in_child(what_is_open_works, HAL_REOPENS_NOTHING));
    assert_true(in_child(a_connection_is_made_again, HAL_REOPENS_SOCKETS));
    assert_true(in_child(a_serial_device_is_opened, HAL_REOPENS_SERIAL));
    assert_true(in_child(the_result_is_written, HAL_REOPENS_NOTHING));
    FILE *file = fopen(result, "r");
    assert_non_null(file);
    assert_int_equal(fread(text, 1, sizeof text, file), 6);
    fclose(file);
}

static void a_result_is_written_where_a_rename_knows_no_flags(void **unused) {
    (void)unused;
    SKIP_SANITIZED();
    struct stat s;
    unlink(result);
    no_rename_flags = true;
    bool written = in_child(the_result_is_written, HAL_REOPENS_NOTHING);
    no_rename_flags = false;
    assert_true(written);
    assert_int_equal(stat(result, &s), 0);
    assert_int_equal(s.st_nlink, 1); /* one link is left, so the temporary file is gone */
}

static void a_service_manager_is_told_through_the_socket_that_was_open(void **unused) {
    (void)unused;
    SKIP_SANITIZED();
    struct sockaddr_un at = {.sun_family = AF_UNIX};
    struct error error;
    char text[16] = "";
    snprintf(at.sun_path, sizeof at.sun_path, "%s", other);
    int file = socket(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK, 0);
    assert_int_equal(bind(file, (struct sockaddr *)&at, sizeof at), 0);
    setenv("NOTIFY_SOCKET", other, 1);
    assert_int_equal(notify_open(&manager, &error), STATUS_OK);
    assert_true(in_child(the_manager_is_told, HAL_REOPENS_NOTHING));
    assert_int_equal(recv(file, text, sizeof text - 1, 0), 8);
    assert_string_equal(text, "READY=1\n");
    assert_int_equal(recv(file, text, sizeof text - 1, 0), 10);
    notify_close(&manager);
    close(file);
}

static void commands_come_through_the_sockets_that_were_open(void **unused) {
    (void)unused;
    SKIP_SANITIZED();
    struct sockaddr_un at = {.sun_family = AF_UNIX};
    char byte = 'x';
    snprintf(at.sun_path, sizeof at.sun_path, "%s", other);
    unlink(other);
    listener = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_NONBLOCK, 0);
    assert_int_equal(bind(listener, (struct sockaddr *)&at, sizeof at), 0);
    assert_int_equal(listen(listener, 1), 0);
    int client = socket(AF_UNIX, SOCK_SEQPACKET, 0);
    assert_int_equal(connect(client, (struct sockaddr *)&at, sizeof at), 0);
    assert_int_equal(send(client, &byte, 1, 0), 1);
    assert_true(in_child(connections_are_accepted, HAL_REOPENS_NOTHING));
    assert_int_equal(recv(client, &byte, 1, 0), 1);
    close(client);
    close(listener);
}

/* SECCOMP_FILTER_FLAG_TSYNC confines threads that already run; such a thread reports through a
 * pipe. */
static int to_thread[2], from_thread[2];
static void *tries(void *argument) {
    char byte = 0;
    if (read(to_thread[0], &byte, 1) == 1) byte = (char)denied(socket(AF_INET, SOCK_STREAM, 0));
    if (write(from_thread[1], &byte, 1) != 1) _exit(3);
    return argument;
}

static void threads_that_run_are_confined_too(void **unused) {
    (void)unused;
    SKIP_SANITIZED();
    pid_t child = fork();
    if (child == 0) {
        pthread_t thread;
        struct error error;
        char byte = 0;
        bool ready = !pipe(to_thread) && !pipe(from_thread) && !pthread_create(&thread, NULL, tries, NULL);
        bool confined = ready && !confine(&(struct confinement){0}, &error);
        bool told = confined && write(to_thread[1], &byte, 1) == 1 && read(from_thread[0], &byte, 1) == 1;
        _exit(!(told && byte == 1));
    }
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFEXITED(status) && WEXITSTATUS(status) == 0);
}

static int make_directory(void **unused) {
    (void)unused;
    if (!mkdtemp(directory)) return -1;
    snprintf(result, sizeof result, "%s/result", directory);
    snprintf(other, sizeof other, "%s/other", directory);
    return 0;
}

static int remove_directory(void **unused) {
    (void)unused;
    unlink(result);
    unlink(other);
    return rmdir(directory);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_denied_fails_and_kills_nobody),
        cmocka_unit_test(a_back_end_on_can_opens_its_socket_again_and_may_do_no_more_for_it),
        cmocka_unit_test(what_the_daemon_needs_works),
        cmocka_unit_test(a_result_is_written_where_a_rename_knows_no_flags),
        cmocka_unit_test(a_service_manager_is_told_through_the_socket_that_was_open),
        cmocka_unit_test(commands_come_through_the_sockets_that_were_open),
        cmocka_unit_test(threads_that_run_are_confined_too),
    };
    return cmocka_run_group_tests(tests, make_directory, remove_directory);
}
