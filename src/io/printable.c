#include "printable.h"

#include <stdbool.h>
#include <string.h>

size_t utf8_decode(const unsigned char *p, uint32_t *point) {
    static const uint32_t least[] = {0, 0, 0x80, 0x800, 0x10000};
    size_t bytes = p[0] < 0x80 ? 1 : (p[0] & 0xe0) == 0xc0 ? 2 : (p[0] & 0xf0) == 0xe0 ? 3 : (p[0] & 0xf8) == 0xf0 ? 4 : 0;
    *point = bytes == 1 ? p[0] : p[0] & (0x7fu >> bytes);
    for (size_t i = 1; i < bytes; i++) {
        if ((p[i] & 0xc0) != 0x80) return 0;
        *point = *point << 6 | (p[i] & 0x3f);
    }
    bool exists = bytes && *point >= least[bytes] && *point <= 0x10ffff && !(*point >= 0xd800 && *point <= 0xdfff);
    return exists ? bytes : 0;
}

static bool harmless(uint32_t point) {
    bool control = point < 0x20 || (point >= 0x7f && point <= 0x9f);
    bool turns = point == 0x200e || point == 0x200f || (point >= 0x2028 && point <= 0x202e) || (point >= 0x2066 && point <= 0x2069);
    return !control && !turns;
}

size_t text_printable(const char *text, char *out, size_t size) {
    const unsigned char *p = (const unsigned char *)text;
    size_t length = 0;
    while (*p) {
        uint32_t point;
        size_t bytes = utf8_decode(p, &point);
        bool good = bytes && harmless(point);
        size_t needed = good ? bytes : 1;
        if (length + needed >= size) break;
        if (good) memcpy(out + length, p, bytes);
        else out[length] = '?';
        length += needed;
        p += bytes ? bytes : 1;
    }
    out[length] = '\0';
    return length;
}
