/* Describes messages other than HEXID_STATE field by field, for code that converts all of them:
 * names, numbers and texts as in lcmtypes/. Messages are not trusted: their length is checked to
 * the last byte before any field is given out. Ordinary threads, no heap. */
#ifndef HEXID_MESSAGE_FIELDS_H
#define HEXID_MESSAGE_FIELDS_H

#include <stdbool.h>
#include <stdint.h>

/* ELEMENTS_MAX: largest number of elements of a FIELD_COUNTED */
enum { FIELDS_MAX = 48, FIELD_COUNTED = 0, ELEMENTS_MAX = 1000 };

enum field_kind { FIELD_INTEGER, FIELD_BOOLEAN, FIELD_REAL, FIELD_TEXT, FIELD_COUNT };

struct field {
    const char *name;
    enum field_kind kind;
    int bytes;  /* size of an element on the wire; 0: a text, which states its length */
    int count;  /* number of elements: 1; the length of an array (36: a 6 x 6 matrix, row-major); or
                 * FIELD_COUNTED, which stands for the value of the last FIELD_COUNT */
};

struct message_type {
    const char *name;            /* name of the type: "test_result" */
    const char *channel;
    int64_t (*fingerprint)(void);
    struct field field[FIELDS_MAX]; /* fields of the type, ended by one without a name */
};

enum { MESSAGE_TYPES = 8 };
extern const struct message_type message_types[MESSAGE_TYPES];

struct message_value {
    int count;
    const unsigned char *bytes; /* the field's bytes inside the message */
};

struct message {
    const struct message_type *type;
    const void *data;
    int size;
    struct message_value value[FIELDS_MAX]; /* values in the order of type->field[]; unset for a
                                             * FIELD_COUNT */
};

/* Returns true if the channel is in the table; other channels are HEXID_STATE or not hexid's. */
bool message_known(const char *channel);

/* Reads data as one whole message of the channel's type. Returns false, with *message untouched, if
 * the data are no such message. */
bool message_read(const char *channel, const void *data, int size, struct message *message);

/* Return element i, 0 .. value[field].count - 1, of a field in a message from message_read(). The
 * field must have the kind that the function's name says; booleans are integers. */
double message_real(const struct message *m, int field, int i);
int64_t message_integer(const struct message *m, int field, int i);
const char *message_text(const struct message *m, int field, int i);

#endif
