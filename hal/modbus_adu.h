/* Extracts Modbus requests from a stream of bytes on the device side: framing of TCP (Messaging on
 * TCP/IP Implementation Guide V1.0b, 3.1.3) and of serial lines in RTU mode (Serial Line V1.02,
 * 2.5.1). Pure: the caller buffers the bytes of each connection, so that nothing waits for the rest
 * of a request.
 *
 * libmodbus's server cannot be used: it blocks until a request is complete, accepts any protocol
 * identifier, length and unit, and derives the length from the function code, so that it closes the
 * connection after an unknown function. */
#ifndef HEXID_MODBUS_ADU_H
#define HEXID_MODBUS_ADU_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum {
    ADU_PDU_MAX = 253,  /* largest PDU (Application Protocol V1.1b3, 4.1) */
    ADU_MAX = 260,      /* largest frame on TCP; on a serial line it is 256 */
    ADU_UNIT_TCP = 0xff /* unit identifier that the guide prescribes for a device that its IP
                         * address alone selects; 0 is accepted, too */
};
enum modbus_function {
    FUNCTION_READ = 3,
    FUNCTION_WRITE_ONE = 6,
    FUNCTION_WRITE = 16,
    FUNCTION_EXCHANGE = 23, /* the protocol's "read/write multiple registers" */
    FUNCTION_FAILED = 0x80, /* bit that marks an exception */
};

enum adu_result {
    ADU_MORE,    /* incomplete: call again with more bytes (RTU: or when the line is silent) */
    ADU_REQUEST, /* a complete request, of `used` bytes */
    ADU_DISCARD, /* `used` bytes are no valid request; no answer */
    ADU_BROKEN,  /* TCP: the start of the next request cannot be found; the connection must be
                  * closed */
};

struct adu {
    uint16_t transaction; /* transaction identifier of TCP */
    uint8_t unit;
    const uint8_t *pdu;   /* function and data; points into the bytes of the frame */
    size_t pdu_size;      /* number of the PDU's bytes, 1..ADU_PDU_MAX */
    size_t used;          /* number of bytes to remove from the start of the buffer */
};

/* Reads and writes a number of 16 bits as Modbus sends it, high byte first. */
static inline unsigned adu_get_16(const uint8_t *from) { return (unsigned)from[0] << 8 | from[1]; }
static inline void adu_put_16(uint8_t *to, unsigned value) { to[0] = (uint8_t)(value >> 8), to[1] = (uint8_t)value; }

/* Takes a request from the beginning of the bytes. It looks at no more than ADU_MAX bytes, and with
 * ADU_MAX bytes it never returns ADU_MORE. A request that has a wrong length for its function is
 * discarded. If only its byte count contradicts its quantity, the request is returned, and the
 * server refuses it (exception 3). */
enum adu_result adu_take_tcp(const uint8_t *bytes, size_t size, struct adu *adu);

/* Does what adu_take_tcp() does, for a serial line. silent: nothing has come for longer than the
 * longest gap inside a request; this ends junk, and requests of unknown functions, whose length is
 * unknown. Bytes without a correct checksum are discarded up to the next request with a correct
 * one, so that a junk byte, half a request or another device's answer does not spoil a good
 * request. */
enum adu_result adu_take_rtu(const uint8_t *bytes, size_t size, bool silent, struct adu *adu);

/* Frames the answer in the same way as the request; returns the size. */
size_t adu_put_tcp(const struct adu *request, const uint8_t *pdu, size_t pdu_size, uint8_t bytes[ADU_MAX]);
size_t adu_put_rtu(const struct adu *request, const uint8_t *pdu, size_t pdu_size, uint8_t bytes[ADU_MAX]);

#endif
