/* The Modbus device without its line: registers (modbus_map.h), who may write them, and the answer
 * to a request (Application Protocol V1.1b3; functions 3, 6, 16 and 23, on holding registers). Pure
 * but for the simulated machine; time is an argument.
 *
 * SAFETY: one master. A client claims the machine with a token that is not 0; it gets it when
 * nobody has it, or when who has it has commanded nothing for the watchdog's time. Who has it
 * commands over the connection that claimed; where there are no connections, on a serial line, with
 * the token in every write. A write of anybody else moves nothing, is answered with exception 6
 * (server device busy), and counts in MODBUS_FOREIGN, which the master reads in every cycle. A
 * claim that is refused does not count: it is how a second master asks. */
#ifndef HEXID_MODBUS_SERVER_H
#define HEXID_MODBUS_SERVER_H

#include "device.h"
#include "modbus_adu.h"
#include "modbus_map.h"

/* Application Protocol V1.1b3, 7 */
enum modbus_exception {
    EXCEPTION_NONE = 0,
    EXCEPTION_FUNCTION = 1,
    EXCEPTION_ADDRESS = 2,
    EXCEPTION_VALUE = 3,
    EXCEPTION_BUSY = 6,   /* another master has the machine, or nobody */
    EXCEPTION_TARGET = 11 /* no such unit behind this address */
};

/* Who asks. connection: another number for every connection that there ever was, from 1; 0 on a
 * serial line. ipv4: 0 where there is none. */
struct modbus_peer {
    uint64_t connection;
    uint32_t ipv4;
};

struct modbus_server {
    const struct params *params;
    struct device *device;
    uint16_t registers[MODBUS_END];
    uint16_t number;     /* of the command in force */
    bool silent;         /* the watchdog holds the valves at their centre */
    uint32_t token;      /* of who has the machine, 0: nobody */
    uint64_t connection; /* over which it was claimed */
    int64_t heard_ns;    /* when it last claimed or commanded */
};

/* params and device must outlive the server. */
void modbus_server_init(struct modbus_server *s, const struct params *params, struct device *device, int64_t now_ns);

/* Carries a request out and writes the PDU of its answer; returns its size. request: a whole PDU,
 * as adu_take_...() has it. */
size_t modbus_server_answer(struct modbus_server *s, const struct modbus_peer *from, const uint8_t *request, size_t size, int64_t now_ns,
                            uint8_t answer[ADU_PDU_MAX]);

/* The PDU of an exception; returns its size. */
size_t modbus_server_refuse(uint8_t function, enum modbus_exception exception, uint8_t answer[ADU_PDU_MAX]);

/* This connection has the machine: its requests come first, and it is not closed in favour of
 * another. */
bool modbus_server_owned_by(const struct modbus_server *s, uint64_t connection);

/* SAFETY: device_tick()'s: call at least every millisecond. */
void modbus_server_tick(struct modbus_server *s, int64_t now_ns);

#endif
