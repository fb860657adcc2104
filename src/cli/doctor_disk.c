#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include "doctor.h"

#include "params.h"
#include "reference.h"
#include "log.h"
#include "messages.h"

static const double HOUR_S = 3600.0;
static const double HANGS_S = 2.0;   /* time after which a stalled log parks the platform
                                      * (RECORDER_BEHIND_S, cmd_run.c) */
static const double STALLS_S = 0.5;  /* duration of a write above which `hexid doctor` warns, a
                                      * quarter of HANGS_S */
enum { BLOCK = 1 << 16, BLOCKS = 256 };

double log_bytes_per_s(const struct params *params) {
    unsigned char buffer[STATE_MESSAGE_MAX];
    struct cycle cycle = {0};
    return (double)(log_event_size(CHANNEL_STATE, state_encode(&cycle, buffer))) / params->loop.period_s;
}

struct finding judge_log_room(const struct doctor *d, const struct disk *k) {
    double rate = log_bytes_per_s(d->params), hours = k->room_bytes / rate / HOUR_S,
           run = reference_run_s(&d->params->motion, &d->params->tests);
    static const char remedy[] = "free some space, or name another directory with --log";
    struct finding f;
    if (k->room_bytes < rate * run)
        f = finding(LEVEL_FAIL, remedy, "%s: %.3g MB free, the log of the configured tests takes %.3g MB", k->directory,
                    k->room_bytes / 1e6, rate * run / 1e6);
    else if (hours < 1.0)
        f = finding(LEVEL_WARN, remedy, "%s: %.3g MB free: full after %.0f minutes, and the platform is then put down", k->directory,
                    k->room_bytes / 1e6, hours * 60.0);
    else f = finding(LEVEL_OK, "", "%s: %.3g GB free, %.3g hours of log", k->directory, k->room_bytes / 1e9, hours);
    f.data = json_pack("{so sf sf}", "directory", doctor_text(k->directory), "free_bytes", k->room_bytes, "log_bytes_per_s", rate);
    return f;
}

struct finding judge_log_speed(const struct doctor *d, const struct disk *k) {
    static const char remedy[] = "write the log to a local disk that does nothing else (not a memory card, not a network)";
    double rate = log_bytes_per_s(d->params);
    char measured[200];
    snprintf(measured, sizeof measured, "%.3g MB/s, the longest write %.0f ms; a log has %.2f MB/s", k->speed_bytes_per_s / 1e6,
             k->longest_s * 1e3, rate / 1e6);
    struct finding f;
    if (k->speed_bytes_per_s < rate) f = finding(LEVEL_FAIL, remedy, "too slow: %s", measured);
    else if (k->longest_s > HANGS_S)
        f = finding(LEVEL_FAIL, remedy, "it hangs for longer than %g s, which puts the platform down: %s", HANGS_S, measured);
    else if (k->speed_bytes_per_s < 10.0 * rate || k->longest_s > STALLS_S) f = finding(LEVEL_WARN, remedy, "slow: %s", measured);
    else f = finding(LEVEL_OK, "", "%s", measured);
    f.data = json_pack("{sf sf}", "bytes_per_s", k->speed_bytes_per_s, "longest_ms", k->longest_s * 1e3);
    return f;
}

/* Finds the directory of the log: --log if that is a directory, else the directory of the file
 * --log; without --log the current directory. */
static void log_directory(const struct doctor *d, char directory[256]) {
    struct stat s;
    const char *log = d->log ? d->log : ".", *slash = strrchr(log, '/');
    if (!stat(log, &s) && S_ISDIR(s.st_mode)) snprintf(directory, 256, "%s", log);
    else if (slash) snprintf(directory, 256, "%.*s", slash == log ? 1 : (int)(slash - log), log);
    else snprintf(directory, 256, ".");
}

/* Opens an unnamed file, which disappears with this program. If the file system has no unnamed
 * files, it creates a named file and unlinks it at once. Returns -1 with errno on failure. */
static int open_trial(const char *directory) {
    char path[300];
    int file = open(directory, O_TMPFILE | O_WRONLY | O_CLOEXEC, 0600);
    if (file >= 0 || (errno != EOPNOTSUPP && errno != EISDIR && errno != ENOENT)) return file;
    snprintf(path, sizeof path, "%s/.hexid-doctor.XXXXXX", directory);
    file = mkstemp(path);
    if (file >= 0) unlink(path);
    return file;
}

/* Writes and flushes one block after another, for about a second and at most BLOCKS blocks. The
 * first block is always written, more blocks only while all use less than a tenth of the free
 * space, because another log may be written there. Returns 0 or errno. */
static int write_trial(int file, struct disk *k) {
    static unsigned char block[BLOCK];
    double begun_s = doctor_now_s(), before_s = begun_s, written = 0.0;
    /* data that a file system cannot compress */
    for (uint32_t i = 0; i < BLOCK; i++) block[i] = (unsigned char)(i * 2654435761u >> 24);
    for (int i = 0; i < BLOCKS && before_s - begun_s < 1.0 && (i == 0 || (i + 1.0) * BLOCK < 0.1 * k->room_bytes); i++) {
        ssize_t size = write(file, block, sizeof block);
        if (size < 0 || fdatasync(file)) return errno;
        double took_s = doctor_now_s() - before_s;
        if (took_s > k->longest_s) k->longest_s = took_s;
        written += (double)size;
        before_s += took_s;
    }
    k->speed_bytes_per_s = written / (before_s - begun_s);
    return 0;
}

/* Finds the log's directory and its free space. Returns false with errno if the directory is
 * missing, is not writable or cannot be asked. */
static bool find_disk(const struct doctor *d, struct disk *k) {
    struct statvfs s;
    log_directory(d, k->directory);
    if (access(k->directory, W_OK | X_OK) || statvfs(k->directory, &s)) return false;
    k->room_bytes = (double)s.f_bavail * (double)s.f_frsize;
    return true;
}

struct finding check_log_room(const struct doctor *d) {
    struct disk k = {0};
    if (!find_disk(d, &k))
        return finding(LEVEL_FAIL, "make the directory, or give this user the right to write there", "%.200s: %s", k.directory,
                       strerror(errno));
    return judge_log_room(d, &k);
}

struct finding check_log_speed(const struct doctor *d) {
    struct disk k = {0};
    if (!find_disk(d, &k)) return finding_none(); /* check_log_room() reports this failure */
    int file = open_trial(k.directory), reason = file < 0 ? errno : write_trial(file, &k);
    if (file >= 0) close(file);
    if (reason)
        return finding(LEVEL_FAIL, "free some space, or name another directory with --log", "%.200s: cannot be written: %s", k.directory,
                       strerror(reason));
    return judge_log_speed(d, &k);
}
