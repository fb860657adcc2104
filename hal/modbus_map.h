/* Modbus registers <-> values: one table for daemon and device, printed by `hexid doctor
 * --modbus-map`. Pure, RT.
 *
 * A cycle is one transaction, function 23 (read/write multiple registers). At one instant its
 * command comes into force, and lengths and pressures of all legs and the inputs are latched; the
 * answer contains them. The command's number is the last register written and the first one read,
 * so that an answer shows to which request it belongs. Registers have 16 bit; 32-bit values take
 * two, the upper half first. A missing reading is the most negative value of its width. */
#ifndef HEXID_MODBUS_MAP_H
#define HEXID_MODBUS_MAP_H

#include <stdio.h>

#include "types.h"

struct params;

/* Addresses of holding registers, from 0 on. */
enum modbus_address {
    MODBUS_IDENTITY = 0x0000,
    MODBUS_VERSION,
    MODBUS_OWNER,
    MODBUS_WATCHDOG_MAX_MS = MODBUS_OWNER + 2,
    MODBUS_COMMAND = 0x001f,
    MODBUS_SUPPLY = MODBUS_COMMAND - 1,
    MODBUS_VALVE = MODBUS_SUPPLY - LEGS,
    MODBUS_TOKEN = MODBUS_VALVE - 2,
    MODBUS_WATCHDOG_MS = MODBUS_TOKEN - 1,
    MODBUS_SAMPLE = 0x0020,
    MODBUS_STATUS,
    MODBUS_LENGTH,
    MODBUS_P1 = MODBUS_LENGTH + 2 * LEGS,
    MODBUS_P2 = MODBUS_P1 + LEGS,
    MODBUS_FOREIGN = MODBUS_P2 + LEGS,
    MODBUS_INPUTS,
    MODBUS_END,
    MODBUS_WRITE_FROM = MODBUS_TOKEN,
    MODBUS_READ_FROM = MODBUS_COMMAND, /* first register that a cycle reads */
};
enum {
    MODBUS_IS_HEXID = 0x4845,
    MODBUS_MAP_VERSION = 3,
    MODBUS_CLAIMED = MODBUS_VALVE - MODBUS_WATCHDOG_MS, /* number of registers that claim the
                                                         * machine: watchdog and token */
    /* number of registers that a cycle writes, and that it reads */
    MODBUS_WRITTEN = MODBUS_COMMAND + 1 - MODBUS_WRITE_FROM,
    MODBUS_READ = MODBUS_END - MODBUS_READ_FROM,
    MODBUS_SILENT = 1u << 0,                    /* status: the watchdog has centred the valves */
    MODBUS_OWNED = 1u << 1,                     /* a master owns the machine and has not been
                                                 * silent for the watchdog's time */
    MODBUS_WATCHDOG_MIN_MS = 2,                 /* shortest watchdog that the device accepts; also
                                                 * the lower limit of device.watchdog_s */
};

struct modbus_register {
    enum modbus_address address;
    int count;
    const char *type, *unit, *access, *meaning;
};
extern const struct modbus_register modbus_map[]; /* the map's rows; the last one has type NULL */

void modbus_map_print(FILE *out);

/* Encodes a claim of the machine. The token must not be 0. */
void modbus_put_claim(uint16_t watchdog_ms, uint32_t token, uint16_t claimed[MODBUS_CLAIMED]);

/* Encodes the registers that a cycle writes: the token of the claim, the number of the command, the
 * supply output and the valves, -1..1 (NAN: no command). `enable` is ignored. */
void modbus_put_command(const struct params *p, uint32_t token, uint16_t number, const struct hal_command *command,
                        uint16_t written[MODBUS_WRITTEN]);
/* Decodes valves and supply; a valve with an invalid command is centred. */
void modbus_get_command(const struct params *p, const uint16_t written[MODBUS_WRITTEN], struct hal_command *command);

struct modbus_reading {
    uint16_t number, sample, status;                 /* number: number of the command in force;
                                                      * sample: number of latches so far; status:
                                                      * flags MODBUS_SILENT and MODBUS_OWNED */
    uint16_t foreign;                               /* number of writes by clients other than the
                                                     * master */
    uint16_t inputs, contradicted;                  /* sets of INPUT_...; only modbus_get_reading()
                                                     * fills in `contradicted` */
    double length_m[LEGS], p1_pa[LEGS], p2_pa[LEGS]; /* values of the legs; NAN: missing or
                                                      * implausible */
};
void modbus_put_reading(const struct params *p, const struct modbus_reading *r, uint16_t read[MODBUS_READ]);
void modbus_get_reading(const struct params *p, const uint16_t read[MODBUS_READ], struct modbus_reading *r);

/* Return the shortest, and the recommended silence between two frames on a serial line, s. The
 * shortest is 3.5 characters of 10 bits. Above 19200 baud the standard (Serial Line V1.02, 2.5.1.1)
 * recommends 1.75 ms, which a strict device expects; up to 19200 baud it is the shortest. */
double modbus_silence_least_s(double baud);
double modbus_silence_s(double baud);

/* Time of a cycle on a serial line, to be compared with the loop's period: the bytes of both
 * frames, 10 bits each, and the silence after each frame; the shortest silence in cycle_s, the
 * recommended one in strict_cycle_s. */
struct modbus_load {
    int request_bytes, response_bytes;
    double request_s, response_s, cycle_s, strict_cycle_s;
};
struct modbus_load modbus_load(double baud);

/* Returns the silence that the host keeps: the recommended one, or the shortest one if the period
 * has no time for the recommended one. */
double modbus_kept_silence_s(double baud, double period_s);

#endif
