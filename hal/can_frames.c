#include "can_frames.h"

#include <string.h>

#include "interlock.h"
#include "params.h"

static struct can_frame frame_make(unsigned cob, int length) { return (struct can_frame){.can_id = cob, .len = (uint8_t)length}; }

uint32_t can_get(const uint8_t *data, int size) {
    uint32_t value = 0;
    for (int i = 0; i < size; i++) value |= (uint32_t)data[i] << 8 * i;
    return value;
}

static void can_put(uint8_t *data, int size, uint32_t value) {
    for (int i = 0; i < size; i++) data[i] = (uint8_t)(value >> 8 * i);
}

struct can_frame can_frame_nmt(enum can_nmt command, int node) {
    struct can_frame f = frame_make(COB_NMT, 2);
    f.data[0] = (uint8_t)command;
    f.data[1] = (uint8_t)node;
    return f;
}

struct can_frame can_frame_sync(void) { return frame_make(COB_SYNC, 0); }

struct can_frame can_frame_heartbeat(int node, enum can_state state) {
    struct can_frame f = frame_make(COB_HEARTBEAT + (unsigned)node, 1);
    f.data[0] = (uint8_t)state;
    return f;
}

struct can_frame can_frame_emcy(int node, uint16_t code, uint8_t error_register) {
    struct can_frame f = frame_make(COB_EMCY + (unsigned)node, 8);
    can_put(f.data, 2, code);
    f.data[2] = error_register;
    return f;
}

static int tpdo_length(int node) { return node == CAN_IO ? 1 : 8; }

struct can_frame can_frame_tpdo(int node, const struct can_tpdo *tpdo) {
    struct can_frame f = frame_make(COB_TPDO + (unsigned)node, tpdo_length(node));
    if (node == CAN_IO) {
        f.data[0] = tpdo->inputs;
        return f;
    }
    can_put(f.data, 4, (uint32_t)tpdo->position);
    can_put(f.data + 4, 2, (uint16_t)tpdo->p1);
    can_put(f.data + 6, 2, (uint16_t)tpdo->p2);
    return f;
}

struct can_frame can_frame_rpdo(int group, const int16_t valve[CAN_GROUP_NODES]) {
    struct can_frame f = frame_make(can_rpdo_cob(group), 2 * CAN_GROUP_NODES);
    for (int i = 0; i < CAN_GROUP_NODES; i++) can_put(f.data + 2 * i, 2, (uint16_t)valve[i]);
    return f;
}

struct can_frame can_frame_outputs(uint8_t outputs) {
    struct can_frame f = frame_make(can_rpdo_cob(can_group(CAN_IO)), 1);
    f.data[0] = outputs;
    return f;
}

/* SDO command specifiers (CiA 301, 7.2.4.3) of expedited transfers (e = 1) whose size is indicated
 * (s = 1); bits 2 and 3, CS_UNUSED, are n = 4 - size. Without s the size is not indicated, and n is
 * 0. */
enum { CS_DOWNLOAD = 0x23, CS_DOWNLOADED = 0x60, CS_UPLOAD = 0x40, CS_UPLOADED = 0x43, CS_ABORT = 0x80, CS_UNUSED = 0x0c, CS_SIZE = 0x01 };

static struct can_frame sdo_make(unsigned cob, int specifier, const struct can_sdo *sdo, bool value) {
    struct can_frame f = frame_make(cob, 8);
    f.data[0] = (uint8_t)specifier;
    can_put(f.data + 1, 2, sdo->index);
    f.data[3] = sdo->sub;
    if (value) can_put(f.data + 4, sdo->kind == SDO_ABORT || !sdo->size ? 4 : sdo->size, sdo->value);
    return f;
}

static int with_size(int specifier, int size) { return size ? specifier | (4 - size) << 2 : specifier & ~CS_SIZE; }

struct can_frame can_frame_sdo(int node, const struct can_sdo *sdo) {
    unsigned cob = COB_SDO + (unsigned)node;
    switch (sdo->kind) {
    case SDO_DOWNLOAD: return sdo_make(cob, with_size(CS_DOWNLOAD, sdo->size), sdo, true);
    case SDO_UPLOAD: return sdo_make(cob, CS_UPLOAD, sdo, false);
    default: return sdo_make(cob, CS_ABORT, sdo, true);
    }
}

struct can_frame can_frame_sdo_reply(int node, const struct can_sdo *sdo) {
    unsigned cob = COB_SDO_REPLY + (unsigned)node;
    switch (sdo->kind) {
    case SDO_DOWNLOAD: return sdo_make(cob, CS_DOWNLOADED, sdo, false);
    case SDO_UPLOAD: return sdo_make(cob, with_size(CS_UPLOADED, sdo->size), sdo, true);
    default: return sdo_make(cob, CS_ABORT, sdo, true);
    }
}

const char *can_abort_text(uint32_t code) {
    static const struct {
        uint32_t code;
        const char *text;
    } texts[] = {
        {SDO_COMMAND, "command not known"},     {SDO_WRITE_ONLY, "write only"},
        {SDO_READ_ONLY, "read only"},           {SDO_NO_OBJECT, "no such object"},
        {SDO_NOT_MAPPABLE, "cannot be mapped"}, {SDO_MAPPING_LENGTH, "too much for a PDO"},
        {SDO_INCOMPATIBLE, "incompatible"},     {SDO_SIZE, "length does not match"},
        {SDO_NO_SUB, "no such sub-index"},      {SDO_VALUE, "value out of range"},
        {SDO_TOO_HIGH, "value too high"},       {SDO_TOO_LOW, "value too low"},
        {SDO_DENIED, "not in this state"},      {SDO_NO_DATA, "no data"},
    };
    for (unsigned i = 0; i < sizeof texts / sizeof *texts; i++)
        if (texts[i].code == code) return texts[i].text;
    return "";
}

int can_frame_node(const struct can_frame *frame, unsigned function) {
    if (frame->can_id & ~(canid_t)CAN_SFF_MASK || (frame->can_id & COB_FUNCTION) != function) return 0;
    return (int)(frame->can_id & COB_NODE);
}

const char *can_frame_of_master(const struct can_frame *f) {
    int rpdo = can_frame_node(f, COB_RPDO), sdo = can_frame_node(f, COB_SDO);
    if (f->can_id == COB_NMT) return "NMT command";
    if (f->can_id == COB_SYNC) return "SYNC";
    if (rpdo >= 1 && rpdo <= CAN_NODES) return "RPDO";
    if (sdo >= 1 && sdo <= CAN_NODES) return "SDO request";
    return can_frame_node(f, COB_HEARTBEAT) == CAN_MASTER ? "heartbeat of a master" : NULL;
}

bool can_parse_tpdo(const struct can_frame *frame, struct can_tpdo *tpdo) {
    int node = can_frame_node(frame, COB_TPDO);
    if (frame->len != tpdo_length(node)) return false;
    if (node == CAN_IO) *tpdo = (struct can_tpdo){.inputs = frame->data[0]};
    else
        *tpdo = (struct can_tpdo){.position = (int32_t)can_get(frame->data, 4),
                                  .p1 = (int16_t)can_get(frame->data + 4, 2),
                                  .p2 = (int16_t)can_get(frame->data + 6, 2)};
    return true;
}

bool can_parse_emcy(const struct can_frame *frame, uint16_t *code, uint8_t *error_register) {
    if (frame->len != 8) return false;
    *code = (uint16_t)can_get(frame->data, 2);
    *error_register = frame->data[2];
    return true;
}

bool can_parse_heartbeat(const struct can_frame *frame, enum can_state *state) {
    if (frame->len != 1) return false;
    *state = (enum can_state)(frame->data[0] & 0x7f); /* the top bit is the toggle bit of node
                                                       * guarding */
    return *state == CAN_BOOTUP || *state == CAN_STOPPED || *state == CAN_OPERATIONAL || *state == CAN_PREOPERATIONAL;
}

/* Parses an SDO frame. Its specifier is `transfer` if it carries a value, and `bare` if it carries
 * none. The bits CS_UNUSED of the specifier are the number of unused bytes, 0 to 3. */
static bool parse_sdo(const struct can_frame *frame, int transfer, int bare, struct can_sdo *sdo) {
    if (frame->len != 8) return false;
    int specifier = frame->data[0];
    *sdo = (struct can_sdo){.index = (uint16_t)can_get(frame->data + 1, 2), .sub = frame->data[3]};
    if (specifier == CS_ABORT) {
        sdo->kind = SDO_ABORT;
        sdo->value = can_get(frame->data + 4, 4);
        return true;
    }
    bool sized = (specifier & ~CS_UNUSED) == transfer, carries = sized || specifier == (transfer & ~CS_SIZE);
    if (!carries && specifier != bare) return false;
    if (sized) sdo->size = 4 - ((specifier & CS_UNUSED) >> 2);
    if (carries) sdo->value = can_get(frame->data + 4, sized ? sdo->size : 4);
    bool upload = transfer == CS_UPLOADED ? carries : !carries;
    sdo->kind = upload ? SDO_UPLOAD : SDO_DOWNLOAD;
    return true;
}

bool can_parse_sdo(const struct can_frame *frame, struct can_sdo *sdo) { return parse_sdo(frame, CS_DOWNLOAD, CS_UPLOAD, sdo); }

bool can_parse_sdo_reply(const struct can_frame *frame, struct can_sdo *sdo) { return parse_sdo(frame, CS_UPLOADED, CS_DOWNLOADED, sdo); }

int can_frame_bits(int data_bytes) {
    /* start, identifier, RTR, control, data and CRC are subject to stuffing: at worst one stuff bit
     * after the first five bits, then one after every four */
    int stuffed = 34 + 8 * data_bytes;
    return 47 + 8 * data_bytes + (stuffed - 1) / 4;
}

int can_nodes(const struct params *params) { return interlock_any(&params->interlocks) ? CAN_NODES : LEGS; }

struct can_load can_load(const struct params *params) {
    double cycle = params->loop.period_s * params->can.bitrate_bps;
    struct can_load l = {.limit = 0.8};
    int nodes = can_nodes(params), outputs_bits = nodes >= CAN_IO ? can_frame_bits(1) : 0;
    l.cycle_bits = can_frame_bits(0) + CAN_GROUPS * can_frame_bits(2 * CAN_GROUP_NODES) + outputs_bits;
    for (int node = 1; node <= nodes; node++) l.cycle_bits += can_frame_bits(tpdo_length(node));
    l.heartbeat_bits = (nodes + 1) * can_frame_bits(1) * params->loop.period_s / params->can.heartbeat_s;
    l.share = (l.cycle_bits + l.heartbeat_bits) / cycle;
    return l;
}
