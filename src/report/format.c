#include "format.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SPEC = 40 };

static void take_number(struct format *f, const char *spec) {
    double value = va_arg(f->args, double);
    f->unknown = !isfinite(value);
    if (!f->unknown) {
        snprintf(f->own, sizeof f->own, spec, value);
        return;
    }
    size_t flags = strspn(spec, "%+- #0");
    int width = atoi(spec + flags);
    snprintf(f->own, sizeof f->own, "%*s", memchr(spec, '-', flags) ? -width : width, "-");
}

static void take_integer(struct format *f, const char *spec, int longs) {
    if (longs > 1) snprintf(f->own, sizeof f->own, spec, va_arg(f->args, long long));
    else if (longs) snprintf(f->own, sizeof f->own, spec, va_arg(f->args, long));
    else snprintf(f->own, sizeof f->own, spec, va_arg(f->args, int));
}

/* Takes an argument by the conversion at f->rest. */
static void take_argument(struct format *f) {
    char spec[SPEC] = "%";
    size_t n = 1;
    int longs = 0;
    for (f->rest++; n < SPEC / 2 && !strchr("diuxcsefg", *f->rest); f->rest++) {
        longs += *f->rest == 'l';
        if (*f->rest == '*') n += (size_t)snprintf(spec + n, SPEC - n, "%d", va_arg(f->args, int));
        else spec[n++] = *f->rest;
    }
    char kind = spec[n] = *f->rest++;
    f->text = f->own;
    if (strchr("efg", kind)) take_number(f, spec);
    else if (kind != 's') take_integer(f, spec, longs);
    else if (n == 1) f->text = va_arg(f->args, const char *);
    else snprintf(f->own, sizeof f->own, spec, va_arg(f->args, const char *));
    f->length = strlen(f->text);
}

bool format_next(struct format *f) {
    f->argument = f->unknown = false;
    if (f->rest >= f->end) return false;
    if (f->rest[0] == '%' && f->rest[1] != '%') {
        f->argument = true;
        take_argument(f);
        return true;
    }
    f->text = f->rest += *f->rest == '%'; /* skips the first % of "%%"; the second is text */
    const char *next = memchr(f->rest + 1, '%', (size_t)(f->end - f->rest - 1));
    f->rest = next ? next : f->end;
    f->length = (size_t)(f->rest - f->text);
    return true;
}
