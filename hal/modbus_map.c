#include "modbus_map.h"

#include <math.h>

#include "channel.h"
#include "interlock.h"
#include "params.h"

const struct modbus_register modbus_map[] = {
    {MODBUS_IDENTITY, 1, "u16", "-", "read", "0x4845"},
    {MODBUS_VERSION, 1, "u16", "-", "read", "of this map: 3"},
    {MODBUS_OWNER, 2, "u32", "-", "read", "IPv4 address of the master, 0: none yet, or another kind of address"},
    {MODBUS_WATCHDOG_MAX_MS, 1, "u16", "ms", "read", "the device's own watchdog: in force after its start and for a new master"},
    {MODBUS_WATCHDOG_MS, 1, "u16", "ms", "read, write", "without a new command for so long the device centres its valves; 2 to its own"},
    {MODBUS_TOKEN, 2, "u32", "-", "write", "whose the machine is: not 0; reads as 0"},
    {MODBUS_VALVE, LEGS, "i16", "1/32767", "read, write", "valve command of legs 1..6, full opening is 32767"},
    {MODBUS_SUPPLY, 1, "bit", "-", "read, write", "to be put out as it is: a relay of the machine keeps the supply on while it changes"},
    {MODBUS_COMMAND, 1, "u16", "-", "read, write", "number of the command: another one than before makes it new"},
    {MODBUS_SAMPLE, 1, "u16", "-", "read", "counts what function 23 has latched: the same again where nothing new was there"},
    {MODBUS_STATUS, 1, "bits", "-", "read", "1: the watchdog has centred the valves; 2: a master has the machine"},
    {MODBUS_LENGTH, 2 * LEGS, "i32", "um", "read", "leg length of legs 1..6, joint to joint"},
    {MODBUS_P1, LEGS, "i16", "kPa", "read", "pressure on the rodless side, gauge, of legs 1..6"},
    {MODBUS_P2, LEGS, "i16", "kPa", "read", "the same on the rod side"},
    {MODBUS_FOREIGN, 1, "u16", "-", "read", "counts writes refused because they were not the master's"},
    {MODBUS_INPUTS, 1, "bits", "-", "read",
     "1: emergency stop's chain closed; 2: enable switch held; 4: door closed; 8: supply has pressure; 16 to 128: the same, inverse"},
    {0},
};

void modbus_map_print(FILE *out) {
    fprintf(out, "%-15s %-5s %-8s %-12s %s\n", "registers", "type", "unit", "access", "meaning");
    for (const struct modbus_register *r = modbus_map; r->type; r++)
        fprintf(out, "0x%04x..0x%04x  %-5s %-8s %-12s %s\n", r->address, r->address + (unsigned)r->count - 1u, r->type, r->unit, r->access,
                r->meaning);
    fprintf(out,
            "\nA cycle: function 23 writes 0x%04x..0x%04x, then reads 0x%04x..0x%04x. Units are those of the default scale "
            "(sections *_channel).\n",
            (unsigned)MODBUS_WRITE_FROM, (unsigned)(MODBUS_WRITE_FROM + MODBUS_WRITTEN - 1), (unsigned)MODBUS_READ_FROM,
            (unsigned)(MODBUS_END - 1));
    fprintf(
        out,
        "One master: before, it claims the machine by writing 0x%04x..0x%04x, the token a random number. Exception 6: another one "
        "has it, until\nit has been silent for the watchdog's time. From then on only that connection writes, on a serial line only "
        "with that token; what\nothers write moves nothing, gets exception 6 and is counted. A watchdog becomes longer only while the "
        "valves are centred by it.\nExceptions: 1 function other than 3, 6, 16, 23; 2 register not there, or not to be written; 3 "
        "quantity, byte count, watchdog, token 0;\n11 (TCP) unit other than modbus.unit, 255, 0.\n"
        "Order: a register's upper byte first; i32 and u32 take two registers, the upper half in the first (\"ABCD\", \"big-endian\",\n"
        "\"high word first\"). Signed values are two's complement. Registers count from 0: in some manuals 0x0000 is 40001, or 1.\n"
        "A missing reading is the most negative value: 0x8000 in a pressure, 0x8000 0x0000 in a length. An input that is missing is open:\n"
        "its two bits (1 and 16, 2 and 32, 4 and 64, 8 and 128) are both 0.\n",
        (unsigned)MODBUS_WATCHDOG_MS, (unsigned)(MODBUS_VALVE - 1));
}

void modbus_put_claim(uint16_t watchdog_ms, uint32_t token, uint16_t claimed[MODBUS_CLAIMED]) {
    claimed[0] = watchdog_ms;
    claimed[MODBUS_TOKEN - MODBUS_WATCHDOG_MS] = (uint16_t)(token >> 16);
    claimed[MODBUS_TOKEN - MODBUS_WATCHDOG_MS + 1] = (uint16_t)token;
}

void modbus_put_command(const struct params *p, uint32_t token, uint16_t number, const struct hal_command *command,
                        uint16_t written[MODBUS_WRITTEN]) {
    uint16_t *valves = written + MODBUS_VALVE - MODBUS_WRITE_FROM;
    written[0] = (uint16_t)(token >> 16), written[1] = (uint16_t)token;
    written[MODBUS_COMMAND - MODBUS_WRITE_FROM] = number;
    written[MODBUS_SUPPLY - MODBUS_WRITE_FROM] = command->supply;
    for (int i = 0; i < LEGS; i++) valves[i] = (uint16_t)channel_raw(&p->valve_channel, i, command->valve[i], INT16_MAX);
}

void modbus_get_command(const struct params *p, const uint16_t written[MODBUS_WRITTEN], struct hal_command *command) {
    command->supply = written[MODBUS_SUPPLY - MODBUS_WRITE_FROM] & 1;
    for (int i = 0; i < LEGS; i++) {
        double valve = channel_si(&p->valve_channel, i, channel_from_16((int16_t)written[MODBUS_VALVE - MODBUS_WRITE_FROM + i]));
        command->valve[i] = valve >= -1.0 && valve <= 1.0 ? valve : 0.0;
    }
}

void modbus_put_reading(const struct params *p, const struct modbus_reading *r, uint16_t read[MODBUS_READ]) {
    uint16_t *length = read + MODBUS_LENGTH - MODBUS_READ_FROM;
    uint16_t *p1 = read + MODBUS_P1 - MODBUS_READ_FROM, *p2 = read + MODBUS_P2 - MODBUS_READ_FROM;
    read[0] = r->number;
    read[1] = r->sample;
    read[2] = r->status;
    read[MODBUS_FOREIGN - MODBUS_READ_FROM] = r->foreign;
    read[MODBUS_INPUTS - MODBUS_READ_FROM] = (uint16_t)interlock_bits(&p->interlocks, r->inputs);
    for (int i = 0; i < LEGS; i++) {
        uint32_t raw = (uint32_t)channel_raw(&p->length_channel, i, r->length_m[i], INT32_MAX);
        length[2 * i] = (uint16_t)(raw >> 16);
        length[2 * i + 1] = (uint16_t)raw;
        p1[i] = (uint16_t)channel_raw(&p->p1_channel, i, r->p1_pa[i], INT16_MAX);
        p2[i] = (uint16_t)channel_raw(&p->p2_channel, i, r->p2_pa[i], INT16_MAX);
    }
}

void modbus_get_reading(const struct params *p, const uint16_t read[MODBUS_READ], struct modbus_reading *r) {
    const uint16_t *length = read + MODBUS_LENGTH - MODBUS_READ_FROM;
    const uint16_t *p1 = read + MODBUS_P1 - MODBUS_READ_FROM, *p2 = read + MODBUS_P2 - MODBUS_READ_FROM;
    r->number = read[0];
    r->sample = read[1];
    r->status = read[2];
    r->foreign = read[MODBUS_FOREIGN - MODBUS_READ_FROM];
    struct interlock_reading inputs = interlock_read(&p->interlocks, read[MODBUS_INPUTS - MODBUS_READ_FROM]);
    r->inputs = (uint16_t)inputs.closed, r->contradicted = (uint16_t)inputs.contradicted;
    for (int i = 0; i < LEGS; i++) {
        uint32_t raw = (uint32_t)length[2 * i] << 16 | length[2 * i + 1];
        r->length_m[i] = channel_si(&p->length_channel, i, channel_from_32((int32_t)raw));
        r->p1_pa[i] = channel_si(&p->p1_channel, i, channel_from_16((int16_t)p1[i]));
        r->p2_pa[i] = channel_si(&p->p2_channel, i, channel_from_16((int16_t)p2[i]));
    }
}

struct modbus_load modbus_load(double baud) {
    /* request: unit, function, read address and count, write address and count, bytes, values, CRC;
     * response: unit, function, bytes, values, CRC */
    struct modbus_load l = {.request_bytes = 13 + 2 * MODBUS_WRITTEN, .response_bytes = 5 + 2 * MODBUS_READ};
    double byte_s = 10.0 / baud;
    l.request_s = l.request_bytes * byte_s;
    l.response_s = l.response_bytes * byte_s;
    l.cycle_s = l.request_s + l.response_s + 2 * modbus_silence_least_s(baud);
    l.strict_cycle_s = l.request_s + l.response_s + 2 * modbus_silence_s(baud);
    return l;
}

double modbus_silence_least_s(double baud) { return 3.5 * 10.0 / baud; }

double modbus_silence_s(double baud) { return fmax(modbus_silence_least_s(baud), baud > 19200.0 ? 1.75e-3 : 0.0); }

double modbus_kept_silence_s(double baud, double period_s) {
    return modbus_load(baud).strict_cycle_s <= 0.9 * period_s ? modbus_silence_s(baud) : modbus_silence_least_s(baud);
}
