/* A Modbus connection, to a host or over a serial line: the only file pair with libmodbus' client
 * API. Blocking, for a thread of its own.
 *
 * Time-outs hold in truth: libmodbus starts its byte time-out again with every byte, so a peer that
 * trickles would hold a call for ever; with it switched off the response time-out is for the whole
 * response. Addresses, as in `modbus:ADDRESS`:
 *     tcp://HOST:PORT
 *     rtu:DEVICE?baud=N     (8 data bits, no parity, 1 stop bit; N of modbus_bauds) */
#ifndef HEXID_MODBUS_LINK_H
#define HEXID_MODBUS_LINK_H

#include <stdbool.h>
#include <stdint.h>

#include "status.h"

enum { MODBUS_NAME_SIZE = 128 };

struct modbus_address_parts {
    bool serial;
    char name[MODBUS_NAME_SIZE];   /* host or device */
    char port[8];                  /* TCP */
    int baud;                      /* serial */
};
extern const int modbus_bauds[]; /* ended by 0 */

/* STATUS_USAGE, with the form that is right or the baud rates that there are. */
int modbus_parse(const char *address, struct modbus_address_parts *parts, struct error *error);

/* STATUS_IO, with the address, the reason (errno of opening, connecting or
 * listening) and the remedy. */
int modbus_line_refused(const struct modbus_address_parts *parts, int reason, struct error *error);

struct modbus_link;
/* Connects, for 1 s at most per address that the host has, and however long its name takes to be
 * looked up. STATUS_IO: modbus_line_refused(). unit: 1..247. timeout_s: for each whole answer. */
int modbus_link_open(struct modbus_link **link, const struct modbus_address_parts *parts, int unit, double timeout_s, struct error *error);
void modbus_link_close(struct modbus_link *link);
/* Another time-out, from the next request on. */
void modbus_link_set_timeout(struct modbus_link *link, double timeout_s);

/* On a serial line a silence is kept between the last byte and the next request; it begins as
 * modbus_silence_s(). Shortens it to modbus_kept_silence_s(). STATUS_USAGE, with the period that
 * has room: the device misses what follows an answer so soon, twice in two tries. Any other failure
 * is left to operation. */
int modbus_link_keep_silence(struct modbus_link *link, const struct modbus_address_parts *parts, double period_s, struct error *error);

/* These return 0, or -1 and errno. They discard what was received before the request, and on a
 * serial line they first wait until there was silence. */
int modbus_link_read(struct modbus_link *link, int address, int count, uint16_t *to);
int modbus_link_write(struct modbus_link *link, int address, int count, const uint16_t *from);
int modbus_link_exchange(struct modbus_link *link, int write_address, int writes, const uint16_t *from, int read_address, int reads,
                         uint16_t *to);

/* Returns when the last request began to be sent, behind the silence; CLOCK_MONOTONIC. */
int64_t modbus_link_begun_ns(const struct modbus_link *link);

/* Counts the requests before which something as long as an answer had come although the previous
 * one was answered already: a second device answers, too. */
unsigned modbus_link_unasked(const struct modbus_link *link);

/* Tells that the last answer belonged to another request: the one to the last request may still
 * come, and is no second device's. */
void modbus_link_not_answered(struct modbus_link *link);

/* Asks who it is, registers 0 and 1: STATUS_OK, with what is there in who; otherwise the reason,
 * the likely cause and the remedy. On a serial line a second time where nothing came, for a device
 * that was still busy with what it had heard before. name: what is asked, for the error. */
int modbus_link_greet(struct modbus_link *link, const char *name, uint16_t who[2], struct error *error);

/* After a failure: the connection is gone, and only a new one helps. */
bool modbus_link_gone(int error);

/* After a failure: the device has another master (exception 6); it does not take a
 * value (exception 3). */
bool modbus_link_busy(int error);
bool modbus_link_value(int error);

/* Describes errno in words, with cause and remedy if the device itself refused. Callers set
 * EBADMSG for an answer to another request, EBUSY for another master and ENOTUNIQ for an answer
 * that nobody asked for. */
const char *modbus_link_reason(int error);

#endif
