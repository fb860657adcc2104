/* Messages other than HEXID_STATE, field by field, for code that passes all of them on: names,
 * numbers and texts as in lcmtypes/, of any type in the table. The message is not trusted: its
 * parts are measured to its last byte before any of them is given out. Ordinary threads, no
 * heap. */
#ifndef HEXID_MESSAGE_FIELDS_H
#define HEXID_MESSAGE_FIELDS_H

#include <stdbool.h>
#include <stdint.h>

/* ELEMENTS_MAX: most elements of a FIELD_COUNTED */
enum { FIELDS_MAX = 48, FIELD_COUNTED = 0, ELEMENTS_MAX = 1000 };

enum field_kind { FIELD_INTEGER, FIELD_BOOLEAN, FIELD_REAL, FIELD_TEXT, FIELD_COUNT };

struct field {
    const char *name;
    enum field_kind kind;
    int bytes;  /* of an element on the wire; 0: a text, as long as it says */
    int count;  /* 1; of an array its length (36: a 6 x 6 matrix, row-major); or FIELD_COUNTED: what
                 * the last FIELD_COUNT said */
};

struct message_type {
    const char *name;            /* "test_result" */
    const char *channel;
    int64_t (*fingerprint)(void);
    struct field field[FIELDS_MAX]; /* ended by one without a name */
};

enum { MESSAGE_TYPES = 7 };
extern const struct message_type message_types[MESSAGE_TYPES];

struct message_value {
    int count;
    const unsigned char *bytes; /* points into the message */
};

struct message {
    const struct message_type *type;
    const void *data;
    int size;
    struct message_value value[FIELDS_MAX]; /* in the order of type->field[]; unset for a
                                             * FIELD_COUNT */
};

/* Is this one of the channels in the table? Others are somebody else's, or HEXID_STATE. */
bool message_known(const char *channel);

/* False, and *message untouched, unless data is one whole message of a type of this channel. */
bool message_read(const char *channel, const void *data, int size, struct message *message);

/* Element i, 0 .. value[field].count - 1, of a field of this kind, of a message that message_read()
 * took; booleans are integers. */
double message_real(const struct message *m, int field, int i);
int64_t message_integer(const struct message *m, int field, int i);
const char *message_text(const struct message *m, int field, int i);

#endif
