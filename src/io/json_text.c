#include "json_text.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cycle_columns.h"
#include "number_text.h"
#include "printable.h"

void json_text_free(struct json_text *j) {
    free(j->text);
    *j = (struct json_text){0};
}

void json_text_restart(struct json_text *j) {
    j->size = 0;
    j->failed = false;
}

void json_text_add(struct json_text *j, const char *text, size_t length) {
    if (j->size + length > j->capacity && !j->failed) {
        size_t capacity = 2 * (j->size + length);
        char *larger = realloc(j->text, capacity);
        j->failed = !larger;
        if (larger) j->text = larger, j->capacity = capacity;
    }
    if (j->failed) return;
    memcpy(j->text + j->size, text, length);
    j->size += length;
}

void json_text_say(struct json_text *j, const char *format, ...) {
    char text[200];
    va_list args;
    va_start(args, format);
    int length = vsnprintf(text, sizeof text, format, args);
    va_end(args);
    json_text_add(j, text, length < (int)sizeof text ? (size_t)length : sizeof text - 1);
}

void json_text_string(struct json_text *j, const char *text) {
    json_text_add(j, "\"", 1);
    for (const unsigned char *p = (const unsigned char *)text; *p;) {
        uint32_t point;
        size_t bytes = utf8_decode(p, &point);
        if (!bytes) json_text_add(j, "?", 1);
        else if (point < 0x20 || point == '"' || point == '\\' || point == 0x7f) json_text_say(j, "\\u%04x", (unsigned)point);
        else json_text_add(j, (const char *)p, bytes);
        p += bytes ? bytes : 1;
    }
    json_text_add(j, "\"", 1);
}

/* Appends a number in the shortest form that reads back bit for bit. */
static void add_real(struct json_text *j, double value) {
    char number[NUMBER_SIZE];
    const char *text = isfinite(value) ? number_shortest(value, number) : "null";
    json_text_add(j, text, strlen(text));
}

void json_text_rounded(struct json_text *j, double value, int digits) {
    if (isfinite(value)) json_text_say(j, "%.*g", digits, value);
    else json_text_add(j, "null", 4);
}

void json_text_rounded_array(struct json_text *j, const double *value, int count, int digits) {
    for (int i = 0; i < count; i++) {
        json_text_add(j, i ? "," : "[", 1);
        json_text_rounded(j, value[i], digits);
    }
    json_text_add(j, "]", 1);
}

void json_text_name(struct json_text *j, const char *name) {
    bool first = !j->size || j->text[j->size - 1] == '{';
    json_text_say(j, "%s\"%s\":", first ? "" : ",", name);
}

void json_text_cycle(struct json_text *j, const struct cycle *c) {
    json_text_add(j, "{", 1);
    for (int i = 0; i < CYCLE_COLUMNS; i++) {
        if (column_is_real(i) && !isfinite(column_real(c, i))) continue;
        json_text_name(j, cycle_columns[i].name);
        if (column_is_real(i)) add_real(j, column_real(c, i));
        else json_text_say(j, "%lld", (long long)column_integer(c, i));
    }
    json_text_add(j, "}", 1);
}

static void element(struct json_text *j, const struct message *m, int field, int i) {
    switch (m->type->field[field].kind) {
    case FIELD_REAL: add_real(j, message_real(m, field, i)); break;
    case FIELD_TEXT: json_text_string(j, message_text(m, field, i)); break;
    case FIELD_BOOLEAN: json_text_say(j, "%s", message_integer(m, field, i) ? "true" : "false"); break;
    default: json_text_say(j, "%lld", (long long)message_integer(m, field, i)); break;
    }
}

void json_text_message(struct json_text *j, const struct message *m) {
    json_text_add(j, "{", 1);
    for (int f = 0; m->type->field[f].name; f++) {
        const struct field *field = &m->type->field[f];
        bool array = field->count != 1, real = field->kind == FIELD_REAL;
        if (field->kind == FIELD_COUNT || (!array && real && !isfinite(message_real(m, f, 0)))) continue;
        json_text_name(j, field->name);
        if (array) json_text_add(j, "[", 1);
        for (int i = 0; i < m->value[f].count; i++) {
            if (i) json_text_add(j, ",", 1);
            element(j, m, f, i);
        }
        if (array) json_text_add(j, "]", 1);
    }
    json_text_add(j, "}", 1);
}
