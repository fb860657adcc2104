/* A Modbus connection to a host or over a serial line; the only files that use libmodbus's client
 * API. The functions block, so a separate thread calls them.
 *
 * Time-outs are for the whole answer. libmodbus restarts its byte time-out with every byte, so that
 * an answer whose bytes come slowly would block a call for ever. So the byte time-out is switched
 * off, which makes the response time-out apply to the whole response.
 *
 * An address, as in `modbus:ADDRESS`, is tcp://HOST:PORT, or rtu:DEVICE?baud=N with 8 data bits, no
 * parity, 1 stop bit and N one of modbus_bauds. */
#ifndef HEXID_MODBUS_LINK_H
#define HEXID_MODBUS_LINK_H

#include <stdbool.h>
#include <stdint.h>

#include "status.h"

enum { MODBUS_NAME_SIZE = 128 };

struct modbus_address_parts {
    bool serial;
    char name[MODBUS_NAME_SIZE];   /* name of the host or of the serial device */
    char port[8];                  /* port of a TCP address */
    int baud;                      /* baud rate of a serial address */
};
extern const int modbus_bauds[]; /* possible baud rates, ended by 0 */

/* Parses an address. STATUS_USAGE: it is malformed; the error states the correct form or the
 * possible baud rates. */
int modbus_parse(const char *address, struct modbus_address_parts *parts, struct error *error);

/* Writes the error for a host or serial line that cannot be used, and returns STATUS_IO. The error
 * has the address, the reason (errno of opening, connecting or listening) and the remedy. */
int modbus_line_refused(const struct modbus_address_parts *parts, int reason, struct error *error);

struct modbus_link;
/* Connects. Takes at most 1 s for each address of the host, plus the time to look up its name.
 * unit: 1..247. timeout_s: for each complete answer. STATUS_IO: as in modbus_line_refused(). */
int modbus_link_open(struct modbus_link **link, const struct modbus_address_parts *parts, int unit, double timeout_s, struct error *error);
void modbus_link_close(struct modbus_link *link);
/* Changes the time-out of an answer, from the next request on. */
void modbus_link_set_timeout(struct modbus_link *link, double timeout_s);

/* Shortens the silence that a serial line keeps between the last byte and the next request, from
 * modbus_silence_s() to modbus_kept_silence_s(). Two tries test whether the device takes a request
 * after the shorter silence. STATUS_USAGE: the device misses it in both tries; the error has a
 * sufficient loop.period_s. Other failures are not reported here, because they show in
 * operation. */
int modbus_link_keep_silence(struct modbus_link *link, const struct modbus_address_parts *parts, double period_s, struct error *error);

/* Read registers, write registers, and write and then read registers. They return 0, or -1 and
 * errno. They first discard bytes received before the request, and on a serial line wait for
 * silence. */
int modbus_link_read(struct modbus_link *link, int address, int count, uint16_t *to);
int modbus_link_write(struct modbus_link *link, int address, int count, const uint16_t *from);
int modbus_link_exchange(struct modbus_link *link, int write_address, int writes, const uint16_t *from, int read_address, int reads,
                         uint16_t *to);

/* Returns the time at which the last request began to be sent, after the silence;
 * CLOCK_MONOTONIC. */
int64_t modbus_link_begun_ns(const struct modbus_link *link);

/* Returns how often an answered request was followed by enough bytes for another answer, which
 * means that a second device answers, too. */
unsigned modbus_link_unasked(const struct modbus_link *link);

/* Notes that the last answer belonged to an earlier request. The answer to the last request may
 * then still come, and is no sign of a second device. */
void modbus_link_not_answered(struct modbus_link *link);

/* Reads the identity, registers 0 and 1, into `who`. STATUS_IO: the error has the reason, the
 * likely cause and the remedy. On a serial line a failed request is repeated once, because earlier
 * bytes may have kept the device busy, but not if the line is lost or the adapter echoes. name:
 * name of the device in the error. */
int modbus_link_greet(struct modbus_link *link, const char *name, uint16_t who[2], struct error *error);

/* After a failure: true if the connection is lost and must be opened again. */
bool modbus_link_gone(int error);

/* After a failure: true if a frame was lost, late or garbled, so that the same request may be
 * answered if it is repeated. */
bool modbus_link_lost(int error);

/* After a failure: modbus_link_busy() is true if the device has another master (exception 6),
 * modbus_link_value() if the device refuses a value (exception 3). */
bool modbus_link_busy(int error);
bool modbus_link_value(int error);

/* Describes an errno value, and for a Modbus exception the cause and the remedy. Callers set
 * EBADMSG for an answer to another request, EBUSY for another master and ENOTUNIQ for an
 * unrequested answer. */
const char *modbus_link_reason(int error);

#endif
