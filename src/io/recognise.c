#include "recognise.h"

#include <dirent.h>
#include <limits.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "input.h"

enum { HEAD_SIZE = 1 << 15, CELLS_LEAST = 2 };

const char recognise_log[] = "an LCM event log";
static const char csv_words[] = "a CSV file of numbers";

static bool begins(const char *head, size_t size, const char *magic, size_t length) {
    return size >= length && !memcmp(head, magic, length);
}

/* Returns the next line that is neither empty nor a comment, without its end; NULL at the end. */
static char *next_line(char **rest) {
    for (char *line; (line = strsep(rest, "\n"));) {
        size_t length = strlen(line);
        if (length && line[length - 1] == '\r') line[--length] = '\0';
        if (length && *line != '#') return line;
    }
    return NULL;
}

static bool is_number(const char *cell) { return *cell && strspn(cell, "+-.,0123456789eE \"") == strlen(cell); }
static bool is_empty(const char *cell) { return cell[strspn(cell, " \"")] == '\0' || !strcasecmp(cell, "nan"); }

/* Returns true for a table: names of columns, then a row with the same number of cells; a header
 * with hexid's own time column suffices. A comma separates cells unless there is a tab or a
 * semicolon. */
static bool is_table(char *text) {
    if (!strncmp(text, "\xef\xbb\xbf", 3)) text += 3;
    char *names = next_line(&text), *row = next_line(&text), *cell;
    if (!names) return false;
    const char *separator = strchr(names, ';') ? ";" : strchr(names, '\t') ? "\t" : ",";
    int columns = 0, cells = 0, numbers = 0;
    bool time = false;
    for (; (cell = strsep(&names, separator)); columns++) time = time || !strcmp(cell, "t_s") || !strcmp(cell, "time_s");
    if (columns < CELLS_LEAST || time) return time && columns >= CELLS_LEAST;
    for (; row && (cell = strsep(&row, separator)); cells++) {
        if (is_number(cell) && !is_empty(cell)) numbers++;
        else if (!is_empty(cell)) return false;
    }
    return cells == columns && numbers > 0;
}

static const char *kind_of(char *head, size_t size) {
    if (begins(head, size, "\xed\xa1\xda\x01", 4)) return recognise_log;
    if (begins(head, size, "\x89MCAP", 5)) return "an MCAP file";
    if (begins(head, size, "MATLAB ", 7)) return "a MAT file";
    if (memchr(head, '\0', size)) return NULL;
    head[size] = '\0';
    return is_table(head) ? csv_words : NULL;
}

const char *recognise(const char *path) {
    char head[HEAD_SIZE + 1];
    const char *unsaid;
    struct stat s;
    if (stat(path, &s) || !S_ISREG(s.st_mode)) return NULL; /* opening a device may have effects */
    int file = input_open(path, &unsaid);
    if (file < 0) return NULL;
    ssize_t size = read(file, head, HEAD_SIZE);
    close(file);
    return size > 0 ? kind_of(head, (size_t)size) : NULL;
}

const char *recognise_in(const char *directory, int csv, char *name, unsigned long size) {
    const char *kind = NULL;
    DIR *files = opendir(directory);
    for (const struct dirent *d; !kind && files && (d = readdir(files));) {
        char path[PATH_MAX];
        if (snprintf(path, sizeof path, "%s/%s", directory, d->d_name) >= (int)sizeof path) continue;
        kind = recognise(path);
        if (kind == csv_words && !csv) kind = NULL;
        if (kind) snprintf(name, size, "%s", d->d_name);
    }
    if (files) closedir(files);
    return kind;
}
