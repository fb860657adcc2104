/* The Modbus device without its line: registers (modbus_map.h), write permissions, and answers to
 * requests (Application Protocol V1.1b3; functions 3, 6, 16 and 23, on holding registers). Pure but
 * for the simulated machine; time is an argument.
 *
 * SAFETY: one master. A client claims the machine with a token that is not 0; the claim succeeds if
 * there is no owner, if the token is the owner's, or if the owner has written nothing for the
 * watchdog's time. The owner commands over the connection of its claim; on a serial line, which has
 * no connections, with the token in every write. A write by anybody else changes nothing, is
 * answered with exception 6 (server device busy), and counts in MODBUS_FOREIGN, which the master
 * reads in every cycle. A refused claim does not count, since by claiming a second master finds out
 * that the machine is taken. */
#ifndef HEXID_MODBUS_SERVER_H
#define HEXID_MODBUS_SERVER_H

#include "device.h"
#include "modbus_adu.h"
#include "modbus_map.h"

/* Exception codes (Application Protocol V1.1b3, 7). */
enum modbus_exception {
    EXCEPTION_NONE = 0,
    EXCEPTION_FUNCTION = 1,
    EXCEPTION_ADDRESS = 2,
    EXCEPTION_VALUE = 3,
    EXCEPTION_BUSY = 6,   /* another master owns the machine, or nobody does */
    EXCEPTION_TARGET = 11 /* there is no such unit behind this address */
};

/* A client. connection: a unique number from 1 on; 0 on a serial line. ipv4: its address; 0 if it
 * has none. */
struct modbus_peer {
    uint64_t connection;
    uint32_t ipv4;
};

struct modbus_server {
    const struct params *params;
    struct device *device;
    uint16_t registers[MODBUS_END];
    uint16_t number;     /* number of the command in force */
    bool silent;         /* the watchdog keeps the valves centred */
    uint32_t token;      /* token of the owner; 0: no owner */
    uint64_t connection; /* connection over which the owner made its claim */
    int64_t heard_ns;    /* time of the owner's last claim or write */
};

/* Prepares a server; params and device must outlive it. */
void modbus_server_init(struct modbus_server *s, const struct params *params, struct device *device, int64_t now_ns);

/* Executes a request, writes the PDU of its answer and returns the PDU's size. request: a complete
 * PDU from adu_take_tcp() or adu_take_rtu(). */
size_t modbus_server_answer(struct modbus_server *s, const struct modbus_peer *from, const uint8_t *request, size_t size, int64_t now_ns,
                            uint8_t answer[ADU_PDU_MAX]);

/* Writes the PDU of an exception and returns its size. */
size_t modbus_server_refuse(uint8_t function, enum modbus_exception exception, uint8_t answer[ADU_PDU_MAX]);

/* True if this connection owns the machine. The owner's connection is served first, and is never
 * closed to make room. */
bool modbus_server_owned_by(const struct modbus_server *s, uint64_t connection);

/* SAFETY: calls device_tick(); to be called at least every millisecond. */
void modbus_server_tick(struct modbus_server *s, int64_t now_ns);

#endif
