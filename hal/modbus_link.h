/* A Modbus connection to a host or over a serial line: the only pair of files with libmodbus's
 * client API. Blocking, for a separate thread.
 *
 * Time-outs are for the whole answer: libmodbus restarts its byte time-out with every byte, so that
 * an answer whose bytes come slowly would block a call for ever. The byte time-out is switched off,
 * which makes the response time-out apply to the whole response.
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

/* Writes the error for a line that cannot be used: the address, the reason (errno of opening,
 * connecting or listening) and the remedy; returns STATUS_IO. */
int modbus_line_refused(const struct modbus_address_parts *parts, int reason, struct error *error);

struct modbus_link;
/* Connects, for at most 1 s for each of the host's addresses, plus the time to look up its name.
 * STATUS_IO: modbus_line_refused(). unit: 1..247. timeout_s: for each complete answer. */
int modbus_link_open(struct modbus_link **link, const struct modbus_address_parts *parts, int unit, double timeout_s, struct error *error);
void modbus_link_close(struct modbus_link *link);
/* Changes the time-out of an answer, from the next request on. */
void modbus_link_set_timeout(struct modbus_link *link, double timeout_s);

/* A serial line is kept silent between the last byte and the next request, at first for
 * modbus_silence_s(). This call shortens the silence to modbus_kept_silence_s(). It returns
 * STATUS_USAGE, and names a sufficient loop.period_s, if in both of two tries the device misses a
 * request that follows an answer after the shorter silence. Other failures are not reported here,
 * because operation reports them. */
int modbus_link_keep_silence(struct modbus_link *link, const struct modbus_address_parts *parts, double period_s, struct error *error);

/* Read, write, and write and read registers. They return 0, or -1 and errno. They discard bytes
 * received before the request, and wait for silence first on a serial line. */
int modbus_link_read(struct modbus_link *link, int address, int count, uint16_t *to);
int modbus_link_write(struct modbus_link *link, int address, int count, const uint16_t *from);
int modbus_link_exchange(struct modbus_link *link, int write_address, int writes, const uint16_t *from, int read_address, int reads,
                         uint16_t *to);

/* Returns when sending of the last request began, after the silence; CLOCK_MONOTONIC. */
int64_t modbus_link_begun_ns(const struct modbus_link *link);

/* Returns how many times enough bytes for an answer came after the request had already been
 * answered, which means that a second device answers, too. */
unsigned modbus_link_unasked(const struct modbus_link *link);

/* Notes that the last answer belonged to an earlier request, so that the missing answer may still
 * come and does not indicate a second device. */
void modbus_link_not_answered(struct modbus_link *link);

/* Asks for the identity, registers 0 and 1. STATUS_OK with their values in who; otherwise STATUS_IO
 * with the reason, the likely cause and the remedy. On a serial line it asks once more after a
 * failure, unless the line is lost or the adapter echoes, because the device may have been busy
 * with earlier bytes. name: name of the device in the error. */
int modbus_link_greet(struct modbus_link *link, const char *name, uint16_t who[2], struct error *error);

/* After a failure: true if the connection is lost and must be opened again. */
bool modbus_link_gone(int error);

/* After a failure: true if a frame was lost, came late or was garbled, so that the same request may
 * be answered next time. */
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
