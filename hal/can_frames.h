/* CAN frames <-> values: the CANopen subset (CiA 301, predefined connection set) of the six axis
 * nodes and the I/O module. Pure, no socket, RT.
 *
 *   COB-ID       frame      bytes (little-endian)                                           from
 *   000          NMT        command, node (0: all)                                          daemon
 *   080          SYNC       none: latch readings and inputs, apply the commands             daemon
 *   080 + node   EMCY       code u16, error register u8, 5 bytes of the manufacturer        node
 *   180 + node   TPDO1      position i32 [um], P1 i16 [kPa], P2 i16 [kPa], latched by SYNC  node
 *   187          TPDO1      inputs u8, INPUT_... (types.h), latched by SYNC                 node 7
 *   201          RPDO A     valve commands i16 of nodes 1, 2, 3; +-32767 is full opening    daemon
 *   204          RPDO B     the same for nodes 4, 5, 6                                      daemon
 *   207          RPDO C     outputs u8 of node 7, OUTPUT_...                                daemon
 *   580 + node   SDO reply                                                                  node
 *   600 + node   SDO        expedited only; segments and blocks are answered with an abort  daemon
 *   700 + node   heartbeat  state; 0 is boot-up; the daemon is node 127                     both
 *
 * Node n moves leg n, 1..6; node 7 is an I/O module after CiA 401, which is expected only if an
 * input or output is wired (interlocks). One RPDO serves three axis nodes: each maps its own 16 bit
 * to its valve (0x6300:1) and the other two to CiA 301's dummy entry for INTEGER16, 0x0003. The raw
 * units above are the default scale; channels in the configuration change it. Pressures are signed,
 * because a gauge pressure can be negative. The most negative value means that the node has no
 * reading (or, in an RPDO, that there is no command). */
#ifndef HEXID_CAN_FRAMES_H
#define HEXID_CAN_FRAMES_H

#include <linux/can.h>
#include <stdbool.h>
#include <stdint.h>

#include "types.h"

struct params;

enum { CAN_IO = LEGS + 1, CAN_NODES = CAN_IO, CAN_MASTER = 127, CAN_GROUPS = 2, CAN_GROUP_NODES = 3 };

/* Identity objects of hexid's own nodes: device type 0x1000 (CiA 408; CiA 401 with digital inputs
 * and outputs), vendor 0x1018:1 (0, because CiA has assigned none) and product code 0x1018:2
 * ("HXID" and "HXIO"). */
enum {
    CAN_DEVICE_TYPE = 0x198,
    CAN_IO_DEVICE_TYPE = 0x30191,
    CAN_VENDOR_ID = 0,
    CAN_PRODUCT_CODE = 0x48584944,
    CAN_IO_PRODUCT_CODE = 0x4858494f
};

/* Bits of node 7's outputs. */
enum { OUTPUT_SUPPLY = 1u << 0 };

/* Identifiers of frames (COB-IDs) without the node's number, and the masks that select the function
 * code and the node's number. */
enum {
    COB_NMT = 0x000,
    COB_SYNC = 0x080,
    COB_EMCY = 0x080,
    COB_TPDO = 0x180,
    COB_RPDO = 0x200,
    COB_SDO_REPLY = 0x580,
    COB_SDO = 0x600,
    COB_HEARTBEAT = 0x700,
    COB_FUNCTION = 0x780,
    COB_NODE = 0x07f,
};

/* Mapping entries for PDOs. Each consists of index, sub-index and number of bits. */
enum {
    MAP_DUMMY = 0x00030010,
    MAP_INPUTS = 0x60000108,
    MAP_POSITION = 0x60200120,
    MAP_OUTPUTS = 0x62000108,
    MAP_VALVE = 0x63000110,
    MAP_P1 = 0x71300110,
    MAP_P2 = 0x71300210
};

enum can_nmt { NMT_START = 1, NMT_STOP = 2, NMT_PREOPERATIONAL = 128, NMT_RESET_NODE = 129, NMT_RESET_COMMUNICATION = 130 };

enum can_state { CAN_BOOTUP = 0, CAN_STOPPED = 4, CAN_OPERATIONAL = 5, CAN_PREOPERATIONAL = 127 };

enum {
    EMCY_NONE = 0,
    EMCY_SENSOR = 0x5000,
    EMCY_HEARTBEAT = 0x8130,
    EMCY_RPDO_SHORT = 0x8210,
    EMCY_RPDO_LONG = 0x8220,
    EMCY_SYNC_LENGTH = 0x8240,
    EMCY_RPDO_TIMEOUT = 0x8250
};

/* Content of a TPDO: position and pressures of an axis node, or inputs of node 7. */
struct can_tpdo {
    int32_t position;
    int16_t p1, p2;
    uint8_t inputs;
};

/* One object of 1, 2 or 4 bytes in an expedited SDO transfer, or an abort. */
enum can_sdo_kind { SDO_DOWNLOAD, SDO_UPLOAD, SDO_ABORT };
struct can_sdo {
    enum can_sdo_kind kind;
    uint16_t index;
    uint8_t sub;
    int size;       /* number of bytes of the value in downloads and upload replies; 0: the frame
                     * does not indicate the number */
    uint32_t value; /* the object's value, or the abort code */
};

/* Abort codes of SDO transfers (CiA 301, 7.2.4.3.17). */
enum {
    SDO_COMMAND = 0x05040001,
    SDO_WRITE_ONLY = 0x06010001,
    SDO_READ_ONLY = 0x06010002,
    SDO_NO_OBJECT = 0x06020000,
    SDO_NOT_MAPPABLE = 0x06040041,
    SDO_MAPPING_LENGTH = 0x06040042,
    SDO_INCOMPATIBLE = 0x06040043,
    SDO_SIZE = 0x06070010,
    SDO_NO_SUB = 0x06090011,
    SDO_VALUE = 0x06090030,
    SDO_TOO_HIGH = 0x06090031,
    SDO_TOO_LOW = 0x06090032,
    SDO_DENIED = 0x08000022,
    SDO_NO_DATA = 0x08000024
};

/* Returns the meaning of an abort code, such as "value out of range"; "" for a code that is not
 * listed above. */
const char *can_abort_text(uint32_t code);

struct can_frame can_frame_nmt(enum can_nmt command, int node);
struct can_frame can_frame_sync(void);
struct can_frame can_frame_heartbeat(int node, enum can_state state);
struct can_frame can_frame_emcy(int node, uint16_t code, uint8_t error_register);
struct can_frame can_frame_tpdo(int node, const struct can_tpdo *tpdo);
/* Makes the RPDO with the commands for the three nodes of a group, 0 or 1. */
struct can_frame can_frame_rpdo(int group, const int16_t valve[CAN_GROUP_NODES]);
struct can_frame can_frame_outputs(uint8_t outputs);
/* Make an SDO request to a node, and an SDO reply from a node. */
struct can_frame can_frame_sdo(int node, const struct can_sdo *sdo);
struct can_frame can_frame_sdo_reply(int node, const struct can_sdo *sdo);

/* Returns the node, 1..127, of a frame with this function (COB_TPDO, ...); 0 if the frame has
 * another function or no node number, or is a remote, extended or error frame. */
int can_frame_node(const struct can_frame *frame, unsigned function);

/* Returns the name of a frame that only a master sends ("SYNC", "SDO request"); NULL for any other
 * frame. */
const char *can_frame_of_master(const struct can_frame *frame);

/* Parse a frame whose COB-ID is known. Return false if its length, command specifier or state is
 * wrong. */
bool can_parse_tpdo(const struct can_frame *frame, struct can_tpdo *tpdo);
bool can_parse_emcy(const struct can_frame *frame, uint16_t *code, uint8_t *error_register);
bool can_parse_heartbeat(const struct can_frame *frame, enum can_state *state);
bool can_parse_sdo(const struct can_frame *frame, struct can_sdo *sdo);
bool can_parse_sdo_reply(const struct can_frame *frame, struct can_sdo *sdo);

/* Reads an unsigned integer of `size` bytes, little-endian. */
uint32_t can_get(const uint8_t *data, int size);

/* Return the group of a node (0 or 1; node 7 alone is group 2), and the node's position in its
 * group (0..2). */
static inline int can_group(int node) { return (node - 1) / CAN_GROUP_NODES; }
static inline int can_place(int node) { return (node - 1) % CAN_GROUP_NODES; }
static inline unsigned can_rpdo_cob(int group) { return COB_RPDO + 1u + (unsigned)(CAN_GROUP_NODES * group); }

/* Returns the largest number of bits on the bus of a frame with an 11-bit identifier and
 * `data_bytes` bytes of data, with worst-case bit stuffing and the interframe space. */
int can_frame_bits(int data_bytes);

/* Returns the number of expected nodes: six, and node 7 if an input or output is wired. */
int can_nodes(const struct params *params);

/* Bus load of a cycle's frames. */
struct can_load {
    int cycle_bits;       /* bits of SYNC and of all nodes' TPDOs and RPDOs */
    double heartbeat_bits;/* mean number of bits per cycle of the heartbeats of nodes and daemon */
    double share;         /* share of the cycle's time in which the bus is busy */
    double limit;         /* largest permitted share; the rest of the cycle is for the loop's
                           * computation and one unplanned frame */
};
struct can_load can_load(const struct params *params);

#endif
