/* Modbus requests out of a stream of bytes, on the side of the device: the framing of TCP
 * (Messaging on TCP/IP Implementation Guide V1.0b, 3.1.3) and of serial lines in RTU mode (Serial
 * Line V1.02, 2.5.1). Pure: the caller keeps the bytes, per connection, so that nobody ever waits
 * for the rest of a request.
 *
 * libmodbus has this for neither: it blocks until a request is whole, takes any protocol
 * identifier, length and unit, and sizes requests by their function, so that a function it does not
 * know ends the connection. */
#ifndef HEXID_MODBUS_ADU_H
#define HEXID_MODBUS_ADU_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum {
    ADU_PDU_MAX = 253,  /* Application Protocol V1.1b3, 4.1 */
    ADU_MAX = 260,      /* TCP; 256 on a serial line */
    ADU_UNIT_TCP = 0xff /* the guide's recommendation where the address of the host says
                         * it all; 0 is accepted, too */
};
enum modbus_function {
    FUNCTION_READ = 3,
    FUNCTION_WRITE_ONE = 6,
    FUNCTION_WRITE = 16,
    FUNCTION_EXCHANGE = 23, /* read/write multiple registers */
    FUNCTION_FAILED = 0x80, /* the bit that marks an exception */
};

enum adu_result {
    ADU_MORE,    /* the bytes are the beginning of one: call again when there are more (RTU:
                  * or when the line is silent) */
    ADU_REQUEST, /* one, of `used` bytes */
    ADU_DISCARD, /* `used` bytes that are none for this device; no answer */
    ADU_BROKEN,  /* TCP: nobody can tell where the next one begins; the
                  * connection is of no more use */
};

struct adu {
    uint16_t transaction; /* TCP */
    uint8_t unit;
    const uint8_t *pdu;   /* function and data, within the bytes */
    size_t pdu_size;      /* 1..ADU_PDU_MAX */
    size_t used;
};

/* At most ADU_MAX bytes are looked at, and ADU_MORE is not the answer to so many. A request whose
 * length is not that of its function is discarded; a byte count that is not that of the quantity is
 * the server's to refuse (exception 3). */
enum adu_result adu_take_tcp(const uint8_t *bytes, size_t size, struct adu *adu);

/* The same on a serial line. silent: nothing has come for longer than there may be between the
 * bytes of a request; a request whose function says how long it is is taken without waiting for
 * that. What has no right checksum is discarded up to the next request that has one: a junk byte of
 * a driver that was switched on, half a request, an answer of another device do not take the good
 * request behind them along. */
enum adu_result adu_take_rtu(const uint8_t *bytes, size_t size, bool silent, struct adu *adu);

/* The answer to a request, framed as it was; returns the size. */
size_t adu_put_tcp(const struct adu *request, const uint8_t *pdu, size_t pdu_size, uint8_t bytes[ADU_MAX]);
size_t adu_put_rtu(const struct adu *request, const uint8_t *pdu, size_t pdu_size, uint8_t bytes[ADU_MAX]);

#endif
