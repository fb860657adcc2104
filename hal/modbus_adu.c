#include "modbus_adu.h"

#include <string.h>

enum {
    /* MBAP is the size of the TCP header, and MBAP_... are offsets in it. The header's length field
     * counts all bytes from the unit identifier on. */
    MBAP = 7,
    MBAP_PROTOCOL = 2,
    MBAP_LENGTH = 4,
    MBAP_UNIT = 6,
    RTU_HEAD = 1,
    RTU_TAIL = 2,
};

/* Returns the fixed size of a request's PDU; if the request has a byte count, up to and including
 * that count. 0: the function is unknown. */
static size_t fixed_size(uint8_t function) {
    switch (function) {
    case FUNCTION_READ:
    case FUNCTION_WRITE_ONE: return 5;
    case FUNCTION_WRITE: return 6;
    case FUNCTION_EXCHANGE: return 10;
    default: return 0;
    }
}

static bool counts_bytes(uint8_t function) { return function == FUNCTION_WRITE || function == FUNCTION_EXCHANGE; }

/* True if the byte count matches the quantity before it. */
static bool counts_agree(const uint8_t *pdu, size_t fixed) { return pdu[fixed - 1] == 2 * adu_get_16(pdu + fixed - 3); }

static bool has_size_of_function(const uint8_t *pdu, size_t size) {
    size_t fixed = fixed_size(pdu[0]);
    if (!counts_bytes(pdu[0])) return !fixed || size == fixed;
    return size >= fixed && (!counts_agree(pdu, fixed) || size == fixed + pdu[fixed - 1]);
}

enum adu_result adu_take_tcp(const uint8_t *bytes, size_t size, struct adu *adu) {
    if (size < MBAP_UNIT) return ADU_MORE;
    size_t length = adu_get_16(bytes + MBAP_LENGTH);
    if (length < 2 || length > 1 + ADU_PDU_MAX) return ADU_BROKEN;
    if (size < MBAP_UNIT + length) return ADU_MORE;
    *adu = (struct adu){.transaction = (uint16_t)adu_get_16(bytes),
                        .unit = bytes[MBAP_UNIT],
                        .pdu = bytes + MBAP,
                        .pdu_size = length - 1,
                        .used = MBAP_UNIT + length};
    return adu_get_16(bytes + MBAP_PROTOCOL) == 0 && has_size_of_function(adu->pdu, adu->pdu_size) ? ADU_REQUEST : ADU_DISCARD;
}

static uint16_t crc(const uint8_t *bytes, size_t size) {
    uint16_t c = 0xffff;
    for (size_t i = 0; i < size; i++) {
        c ^= bytes[i];
        for (int k = 0; k < 8; k++) c = (uint16_t)(c & 1 ? c >> 1 ^ 0xa001 : c >> 1);
    }
    return c;
}

static bool checked(const uint8_t *bytes, size_t size) {
    uint16_t c = crc(bytes, size - RTU_TAIL);
    return bytes[size - 2] == (uint8_t)c && bytes[size - 1] == (uint8_t)(c >> 8);
}

/* Returns the size of the whole frame according to its function; 0: the function is unknown, or the
 * frame is too short to contain its size. */
static size_t rtu_size(const uint8_t *bytes, size_t size) {
    size_t fixed = size > RTU_HEAD ? fixed_size(bytes[RTU_HEAD]) : 0;
    if (!fixed || size < RTU_HEAD + fixed) return 0;
    return RTU_HEAD + fixed + (counts_bytes(bytes[RTU_HEAD]) ? bytes[RTU_HEAD + fixed - 1] : 0) + RTU_TAIL;
}

enum { FRAME_MIN = RTU_HEAD + 1 + RTU_TAIL, FRAME_MAX = RTU_HEAD + ADU_PDU_MAX + RTU_TAIL };

/* Returns the size of the request at the beginning of these bytes, if it is complete, with a
 * correct checksum and a known function; else 0. */
static size_t whole_request(const uint8_t *bytes, size_t size) {
    size_t frame = rtu_size(bytes, size);
    return frame && frame <= FRAME_MAX && size >= frame && checked(bytes, frame) ? frame : 0;
}

/* True if these bytes can be the beginning of a request of a known function. */
static bool may_grow(const uint8_t *bytes, size_t size) {
    if (size <= RTU_HEAD) return true;
    size_t frame = rtu_size(bytes, size);
    return fixed_size(bytes[RTU_HEAD]) && (!frame || (frame <= FRAME_MAX && size < frame));
}

/* Returns the number of bytes before the first complete request; 0 if there is no such request. */
static size_t junk_before_request(const uint8_t *bytes, size_t size) {
    for (size_t i = 1; i + FRAME_MIN <= size; i++)
        if (whole_request(bytes + i, size - i)) return i;
    return 0;
}

enum adu_result adu_take_rtu(const uint8_t *bytes, size_t size, bool silent, struct adu *adu) {
    bool over = silent || size >= ADU_MAX;
    size_t frame = whole_request(bytes, size);
    if (!frame && !over && may_grow(bytes, size)) return ADU_MORE;
    if (!frame && over && size >= FRAME_MIN && size <= FRAME_MAX && checked(bytes, size)) frame = size;
    if (!frame) {
        size_t junk = junk_before_request(bytes, size);
        if (!junk && !over) return ADU_MORE;
        *adu = (struct adu){.used = junk ? junk : size};
        return ADU_DISCARD;
    }
    *adu = (struct adu){.used = frame};
    adu->unit = bytes[0], adu->pdu = bytes + RTU_HEAD, adu->pdu_size = frame - RTU_HEAD - RTU_TAIL;
    return has_size_of_function(adu->pdu, adu->pdu_size) ? ADU_REQUEST : ADU_DISCARD;
}

size_t adu_put_tcp(const struct adu *request, const uint8_t *pdu, size_t pdu_size, uint8_t bytes[ADU_MAX]) {
    adu_put_16(bytes, request->transaction);
    adu_put_16(bytes + MBAP_PROTOCOL, 0);
    adu_put_16(bytes + MBAP_LENGTH, (unsigned)pdu_size + 1);
    bytes[MBAP_UNIT] = request->unit;
    memcpy(bytes + MBAP, pdu, pdu_size);
    return MBAP + pdu_size;
}

size_t adu_put_rtu(const struct adu *request, const uint8_t *pdu, size_t pdu_size, uint8_t bytes[ADU_MAX]) {
    bytes[0] = request->unit;
    memcpy(bytes + RTU_HEAD, pdu, pdu_size);
    uint16_t c = crc(bytes, RTU_HEAD + pdu_size);
    bytes[RTU_HEAD + pdu_size] = (uint8_t)c, bytes[RTU_HEAD + pdu_size + 1] = (uint8_t)(c >> 8);
    return RTU_HEAD + pdu_size + RTU_TAIL;
}
