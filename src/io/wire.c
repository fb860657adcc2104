#include "wire.h"

#include <string.h>

const unsigned char *wire_take(struct wire *w, int size) {
    const unsigned char *taken = w->next;
    w->good = w->good && size >= 0 && size <= w->left;
    if (!w->good) return NULL;
    w->next += size;
    w->left -= size;
    return taken;
}

int64_t wire_int(struct wire *w, int size) {
    const unsigned char *bytes = wire_take(w, size);
    uint64_t value = 0;
    for (int i = 0; bytes && i < size; i++) value = value << 8 | bytes[i];
    return (int64_t)value;
}

const char *wire_string(struct wire *w) {
    int length = (int32_t)wire_int(w, 4);
    const unsigned char *bytes = wire_take(w, length);
    w->good = bytes && length > 0 && memchr(bytes, '\0', (size_t)length) == bytes + length - 1;
    return w->good ? (const char *)bytes : NULL;
}

double wire_double(struct wire *w) {
    uint64_t bits = (uint64_t)wire_int(w, sizeof bits);
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

int wire_count(struct wire *w) {
    int count = (int32_t)wire_int(w, 4);
    w->good = w->good && count >= 0 && count <= w->left;
    return w->good ? count : 0;
}

void wire_boolean(struct wire *w) {
    int64_t value = wire_int(w, 1);
    w->good = w->good && (value == 0 || value == 1);
}

struct wire wire_open(const void *data, int size, int64_t type) {
    struct wire w = {.next = data, .left = size, .good = true};
    w.good = wire_int(&w, 8) == type && w.good;
    return w;
}
