/* JSON written as it comes, into memory that grows: a cycle or a message as an object, by the
 * thousand. Documents for people are made by jansson. A number that JSON cannot hold is left out of
 * its message, and null in an array. Ordinary threads. */
#ifndef HEXID_JSON_TEXT_H
#define HEXID_JSON_TEXT_H

#include <stdbool.h>
#include <stddef.h>

#include "message_fields.h"
#include "types.h"

struct json_text {
    char *text;              /* `size` bytes, without a zero at the end; freed by
                              * json_text_free() */
    size_t size, capacity;
    bool failed;             /* no memory: what is in `text` is no JSON */
};

void json_text_free(struct json_text *j);

/* Empty, and good again. */
void json_text_restart(struct json_text *j);

/* Bytes as they are; and names and numbers of our own, at most 200 bytes. */
void json_text_add(struct json_text *j, const char *text, size_t length);
__attribute__((format(printf, 2, 3))) void json_text_say(struct json_text *j, const char *format, ...);

/* A string from anywhere: control characters and what would end it escaped, what is no UTF-8
 * a question mark. */
void json_text_string(struct json_text *j, const char *text);

/* In the shortest form that reads back bit for bit; and with so many significant digits. */
void json_text_real(struct json_text *j, double value);
void json_text_rounded(struct json_text *j, double value, int digits);
void json_text_rounded_array(struct json_text *j, const double *value, int count, int digits);

/* `"name":`, after a comma where something stands before it in the object. */
void json_text_name(struct json_text *j, const char *name);

/* A cycle in the names of cycle_columns.h; a message in those of its type. */
void json_text_cycle(struct json_text *j, const struct cycle *cycle);
void json_text_message(struct json_text *j, const struct message *message);

#endif
