#include "doctor.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "monotonic.h"
#include "params.h"
#include "printable.h"

struct finding finding(enum level level, const char *remedy, const char *format, ...) {
    struct finding f = {.level = level};
    va_list args;
    va_start(args, format);
    vsnprintf(f.found, sizeof f.found, format, args);
    va_end(args);
    if (level > LEVEL_OK) snprintf(f.remedy, sizeof f.remedy, "%s", remedy);
    return f;
}

struct finding finding_none(void) { return (struct finding){.level = LEVEL_NONE}; }

struct finding finding_unseen(const char *path, const char *what) {
    return finding(LEVEL_UNKNOWN, "where this is a container or a virtual machine, ask its host",
                   "cannot be seen here: %s; %s is not there", what, path);
}

bool doctor_drives(const struct doctor *d) { return !params_mechanism(d->params)->refuses.run; }

struct loop_check doctor_loop(const struct doctor *d) { return d->loop ? *d->loop : loop_check(d->params, d->machine); }

struct gains_check doctor_gains(const struct doctor *d) { return d->gains ? *d->gains : gains_check(d->params, d->machine); }

enum level level_of_machine(const struct doctor *d) { return d->machine ? LEVEL_FAIL : LEVEL_WARN; }

const char *doctor_address(const struct doctor *d, const char *scheme) {
    size_t length = strlen(scheme);
    return strncmp(d->url, scheme, length) == 0 && d->url[length] == ':' ? d->url + length + 1 : NULL;
}

static bool read_file(const char *root, char *text, size_t size, const char *format, va_list args) {
    char path[PATH_MAX];
    int used = snprintf(path, sizeof path, "%s", root);
    vsnprintf(path + used, sizeof path - (size_t)used, format, args);
    int file = open(path, O_RDONLY | O_CLOEXEC);
    if (file < 0) return false;
    size_t length = 0;
    for (ssize_t got; length < size - 1 && (got = read(file, text + length, size - 1 - length)) != 0;) {
        if (got > 0) length += (size_t)got;
        else if (errno != EINTR) break;
    }
    close(file);
    while (length > 0 && (text[length - 1] == '\n' || text[length - 1] == ' ')) length--;
    text[length] = '\0';
    return length > 0;
}

bool doctor_read(const struct doctor *d, char *text, size_t size, const char *path, ...) {
    va_list args;
    va_start(args, path);
    bool there = read_file(d->root, text, size, path, args);
    va_end(args);
    return there;
}

bool doctor_number(const struct doctor *d, int64_t *value, const char *path, ...) {
    char text[32], *end;
    va_list args;
    va_start(args, path);
    bool there = read_file(d->root, text, sizeof text, path, args);
    va_end(args);
    if (!there) return false;
    errno = 0;
    *value = strtoll(text, &end, 10);
    return !errno && end != text && !*end;
}

bool doctor_listed(const char *list, int cpu) {
    for (const char *at = list; *at >= '0' && *at <= '9';) {
        char *end;
        long first = strtol(at, &end, 10), last = first;
        if (*end == '-') last = strtol(end + 1, &end, 10);
        if (cpu >= first && cpu <= last) return true;
        at = *end == ',' ? end + 1 : end;
    }
    return false;
}

int doctor_processors(const struct doctor *d, int cpu[PROCESSORS_MAX]) {
    char online[256];
    int count = 0;
    if (!doctor_read(d, online, sizeof online, "/sys/devices/system/cpu/online")) return 0;
    for (int i = 0; i < PROCESSORS_MAX; i++)
        if (doctor_listed(online, i) && (d->params->loop.cpu < 0 || d->params->loop.cpu == i)) cpu[count++] = i;
    return count;
}

double doctor_now_s(void) { return seconds_from_ns(monotonic_ns()); }

json_t *doctor_text(const char *text) {
    char line[sizeof((struct finding){0}.found)], all[sizeof line];
    size_t used = 0;
    while (*text && used < sizeof all - 2) {
        int length = (int)strcspn(text, "\n");
        snprintf(line, sizeof line, "%.*s", length, text);
        if (used > 0) all[used++] = '\n';
        used += text_printable(line, all + used, sizeof all - used);
        text += length + (text[length] == '\n');
    }
    return json_stringn(all, used);
}
