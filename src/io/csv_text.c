#include "csv_text.h"

#include <errno.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

#include "input.h"

const char csv_text_mark[] = "\xef\xbb\xbf";

int csv_text_refuse(const struct csv_text *t, struct error *error, const char *format, ...) {
    char reason[600];
    va_list args;
    va_start(args, format);
    vsnprintf(reason, sizeof reason, format, args);
    va_end(args);
    return error_set(error, STATUS_USAGE, "%.180s:%d: %s", t->path, t->line, reason);
}

char *csv_text_trim(char *text) {
    text += strspn(text, " \t");
    for (size_t n = strlen(text); n > 0 && strchr(" \t\r\n", text[n - 1]); n--) text[n - 1] = '\0';
    return text;
}

/* Puts a comma in place of each run of `least` or more blanks, and one blank in place of a shorter
 * run. Brackets and semicolons count as blanks, because some programs write rows as a matrix. */
static void join_blanks(char *text, size_t least) {
    static const char blanks[] = " \t\r\n[];";
    char *to = text;
    text += strspn(text, blanks);
    while (*text) {
        size_t run = strspn(text, blanks);
        if (run && text[run]) *to++ = run < least ? ' ' : ',';
        text += run;
        if (!run) *to++ = *text++;
    }
    *to = '\0';
}

bool csv_text_normalise(char *text, char separator) {
    char *to = text, *begin = text;
    bool quoted = false;
    for (; *text; text++) {
        if (*text == '"') quoted = !quoted;
        else if (*text == separator && !quoted && separator != ' ' && separator != CSV_WIDE) *to++ = ',';
        else *to++ = *text == ',' ? '.' : *text;
    }
    *to = '\0';
    if (separator == ' ' || separator == CSV_WIDE) join_blanks(begin, separator == CSV_WIDE ? 2 : 1);
    return !quoted;
}

int csv_text_line(struct csv_text *t, char **line, struct error *error) {
    while (fgets(t->text, sizeof t->text, t->file)) {
        t->line++;
        if (!strchr(t->text, '\n') && !feof(t->file))
            return csv_text_refuse(t, error,
                                   "a line of more than %d bytes, or a zero byte: this is no CSV text, or UTF-16 (iconv -f utf16 -t utf8)",
                                   CSV_LINE_SIZE - 2);
        if (t->separator && t->text[0] == '#') continue;
        if (t->separator) strcpy(t->raw, t->text);
        if (t->separator && !csv_text_normalise(t->text, t->separator)) return csv_text_refuse(t, error, "a quote is not closed");
        *line = csv_text_trim(t->text + (t->line == 1 && strncmp(t->text, csv_text_mark, 3) == 0 ? 3 : 0));
        if (**line) return 1;
    }
    return ferror(t->file) ? error_set(error, STATUS_IO, "%.250s: cannot be read: %s", t->path, strerror(errno)) : 0;
}

char csv_text_separator(const char *line) {
    static const char separators[] = ",;\t";
    for (const char *s = separators; *s; s++) {
        bool quoted = false;
        for (const char *p = line; *p; p++) {
            quoted = quoted != (*p == '"');
            if (*p == *s && !quoted) return *s;
        }
    }
    return ',';
}

const char *csv_text_cell(const struct csv_text *t, int cell, int *length) {
    const char *begin = t->raw, *p = t->raw;
    bool quoted = false;
    for (; *p && (cell || *p != t->separator || quoted); p++) {
        if (*p == '"') quoted = !quoted;
        else if (*p == t->separator && !quoted) cell--, begin = p + 1;
    }
    while (p > begin && strchr(" \t\r\n", p[-1])) p--;
    *length = (int)(p - begin);
    return begin;
}

int csv_text_columns(struct csv_text *t, char *line, struct error *error) {
    return csv_text_separate(t, line, csv_text_separator(line), error);
}

int csv_text_separate(struct csv_text *t, char *line, char separator, struct error *error) {
    t->separator = separator;
    return csv_text_normalise(line, separator) ? STATUS_OK : csv_text_refuse(t, error, "a quote is not closed");
}

/* Reads a decimal number of up to 15 digits: digits and power of ten are exact in binary, so that a
 * single division rounds correctly. Returns NULL if the number needs strtod(). */
static char *read_plain(char *text, double *number) {
    static const double power[] = {1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15};
    char *first = text + (*text == '-'), *p = first, *point = NULL;
    int64_t digits = 0;
    for (; p < first + 16 && ((*p >= '0' && *p <= '9') || (*p == '.' && !point)); p++) {
        if (*p == '.') point = p;
        else digits = 10 * digits + (*p - '0');
    }
    if ((*p != ',' && *p != '\0') || p - first - (point != NULL) < 1 || p - first - (point != NULL) > 15) return NULL;
    *number = (double)digits / power[point ? p - point - 1 : 0];
    if (first > text) *number = -*number;
    return p;
}

/* Returns the end of a word for a missing number; NULL if there is no such word. */
static char *read_missing(char *text) {
    static const char *const words[] = {"NULL", "None", "NA", "N/A", "#N/A"};
    size_t length = strcspn(text, ",");
    while (length && text[length - 1] == ' ') length--;
    for (size_t i = 0; i < sizeof words / sizeof *words; i++)
        if (strlen(words[i]) == length && !strncasecmp(text, words[i], length)) return text + strcspn(text, ",");
    return NULL;
}

char *csv_text_time_of_day(char *text, double *seconds) {
    char *end = text + strcspn(text, ","), *colon = strchr(text, ':'), *rest;
    if (!colon || colon > end || colon == text) return NULL;
    while (colon > text && colon[-1] >= '0' && colon[-1] <= '9') colon--;
    long hours = strtol(colon, &rest, 10), minutes = *rest == ':' ? strtol(rest + 1, &rest, 10) : -1;
    double s = *rest == ':' ? strtod(rest + 1, &rest) : 0.0;
    bool noon = !strncasecmp(rest + strspn(rest, " "), "AM", 2) || !strncasecmp(rest + strspn(rest, " "), "PM", 2);
    if (noon) rest += strspn(rest, " ") + 2, hours %= 12;
    if (*rest == '+' || *rest == '-') rest += strspn(rest, "+-:0123456789"); /* a time zone */
    rest += strspn(rest, " Z");
    if (rest != end || hours < 0 || hours > 24 || minutes < 0 || minutes > 59 || !(s >= 0.0 && s < 61.0)) return NULL;
    *seconds = 3600.0 * (double)hours + 60.0 * (double)minutes + s;
    return end;
}

char *csv_text_number(char *text, double *number) {
    char *end = read_plain(text, number);
    if (end) return end;
    text += strspn(text, " \t");
    *number = strtod(text, &end);
    if (end == text) *number = (double)NAN;
    end += strspn(end, " \t");
    if (*end == ',' || *end == '\0') return end;
    *number = (double)NAN;
    return read_missing(text);
}

int csv_text_open(struct csv_text *t, const char *path, struct error *error) { return csv_text_open_as(t, path, path, error); }

int csv_text_open_as(struct csv_text *t, const char *path, const char *opened, struct error *error) {
    const char *reason = "out of memory";
    snprintf(t->path, sizeof t->path, "%s", path);
    t->line = 0, t->separator = '\0';
    int descriptor = input_open(opened, &reason);
    t->file = descriptor < 0 ? NULL : fdopen(descriptor, "r");
    if (descriptor >= 0 && !t->file) close(descriptor);
    return t->file ? STATUS_OK : error_set(error, STATUS_IO, "%.250s: cannot be read: %s", path, reason);
}

void csv_text_close(struct csv_text *t) {
    if (t->file) fclose(t->file);
}
