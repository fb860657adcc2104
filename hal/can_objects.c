#include "can_objects.h"

#define CONST(index, sub, size, value, name) {index, sub, size, CAN_CONST, false, false, value, 0, 0, name}
#define OF_NODE(index, sub, size, value, name) {index, sub, size, CAN_RO, false, true, value, 0, 0, name}
#define STATUS(index, sub, size, name) {index, sub, size, CAN_RO, false, false, 0, 0, 0, name}
#define COB_ID(index, sub, value, name) {index, sub, 4, CAN_RW, false, true, value, 0, 0, name}
#define SETTING(index, sub, size, value, name) {index, sub, size, CAN_RW, false, false, value, 0, 0, name}
#define IN_RANGE(index, sub, size, value, low, high, name) {index, sub, size, CAN_RW, false, false, value, low, high, name}
#define SECRET(index, sub, name) {index, sub, 4, CAN_WO, false, false, 0, 0, 0, name}
#define READING(index, sub, size, name) {index, sub, size, CAN_RO, true, false, 0, 0, 0, name}
#define OUTPUT(index, sub, size, is_signed, name) {index, sub, size, CAN_RWW, is_signed, false, 0, 0, 0, name}

/* Objects that every node has, in three lists; the objects of only one kind of node stand between
 * and after these lists. */
#define COMMUNICATION(device_type, product_code) \
    CONST(0x1000, 0, 4, device_type, "Device type"), \
    STATUS(0x1001, 0, 1, "Error register"), \
    SETTING(0x1003, 0, 1, 0, "Number of errors"), \
    STATUS(0x1003, 1, 4, "Standard error field 1"), \
    STATUS(0x1003, 2, 4, "Standard error field 2"), \
    STATUS(0x1003, 3, 4, "Standard error field 3"), \
    STATUS(0x1003, 4, 4, "Standard error field 4"), \
    STATUS(0x1003, 5, 4, "Standard error field 5"), \
    STATUS(0x1003, 6, 4, "Standard error field 6"), \
    STATUS(0x1003, 7, 4, "Standard error field 7"), \
    STATUS(0x1003, 8, 4, "Standard error field 8"), \
    SETTING(0x1005, 0, 4, COB_SYNC, "COB-ID SYNC"), \
    OF_NODE(0x1014, 0, 4, COB_EMCY, "COB-ID EMCY"), \
    CONST(0x1016, 0, 1, CAN_CONSUMERS, "Highest sub-index supported"), \
    SETTING(0x1016, 1, 4, (uint32_t)CAN_MASTER << 16 | 150, "Consumer heartbeat time 1"), \
    SETTING(0x1016, 2, 4, 0, "Consumer heartbeat time 2"), \
    SETTING(0x1017, 0, 2, 0, "Producer heartbeat time"), \
    CONST(0x1018, 0, 1, 4, "Highest sub-index supported"), \
    CONST(0x1018, 1, 4, CAN_VENDOR_ID, "Vendor-ID"), \
    CONST(0x1018, 2, 4, product_code, "Product code"), \
    CONST(0x1018, 3, 4, 0x00020000, "Revision number"), \
    OF_NODE(0x1018, 4, 4, 0, "Serial number"), \
    SETTING(0x1019, 0, 1, 0, "Synchronous counter overflow value"), \
    CONST(0x1029, 0, 1, 1, "Highest sub-index supported"), \
    SETTING(0x1029, 1, 1, 0, "Communication error"), \
    CONST(0x1200, 0, 1, 2, "Highest sub-index supported"), \
    OF_NODE(0x1200, 1, 4, COB_SDO, "COB-ID client to server"), \
    OF_NODE(0x1200, 2, 4, COB_SDO_REPLY, "COB-ID server to client"), \
    CONST(0x1400, 0, 1, 5, "Highest sub-index supported"), \
    COB_ID(0x1400, 1, COB_RPDO, "COB-ID used by RPDO"), \
    SETTING(0x1400, 2, 1, 1, "Transmission type"), \
    IN_RANGE(0x1400, 5, 2, 20, 1, CAN_WATCHDOG_MAX_MS, "Event timer")
#define TPDO \
    CONST(0x1800, 0, 1, 2, "Highest sub-index supported"), \
    COB_ID(0x1800, 1, COB_TPDO, "COB-ID used by TPDO"), \
    SETTING(0x1800, 2, 1, 1, "Transmission type")
#define OWNER \
    CONST(0x2000, 0, 1, 3, "Highest sub-index supported"), \
    SECRET(0x2000, 1, "Claim"), \
    SECRET(0x2000, 2, "Release"), \
    STATUS(0x2000, 3, 1, "Owned")

static const struct can_object axis[] = {
    COMMUNICATION(CAN_DEVICE_TYPE, CAN_PRODUCT_CODE),
    SETTING(0x1600, 0, 1, 1, "Number of mapped objects"),
    SETTING(0x1600, 1, 4, MAP_VALVE, "Mapped object 1"),
    SETTING(0x1600, 2, 4, MAP_DUMMY, "Mapped object 2"),
    SETTING(0x1600, 3, 4, MAP_DUMMY, "Mapped object 3"),
    TPDO,
    CONST(0x1a00, 0, 1, 3, "Number of mapped objects"),
    CONST(0x1a00, 1, 4, MAP_POSITION, "Mapped object 1"),
    CONST(0x1a00, 2, 4, MAP_P1, "Mapped object 2"),
    CONST(0x1a00, 3, 4, MAP_P2, "Mapped object 3"),
    OWNER,
    CONST(0x6020, 0, 1, 1, "Highest sub-index supported"),
    READING(0x6020, 1, 4, "Position value"),
    CONST(0x6300, 0, 1, 1, "Highest sub-index supported"),
    OUTPUT(0x6300, 1, 2, true, "vpoc_set_point"),
    CONST(0x6301, 0, 1, 1, "Highest sub-index supported"),
    READING(0x6301, 1, 2, "vpoc_actual_value"),
    CONST(0x7130, 0, 1, 2, "Highest sub-index supported"),
    READING(0x7130, 1, 2, "AI input PV P1"),
    READING(0x7130, 2, 2, "AI input PV P2"),
};

/* Objects of the I/O module (CiA 401). The mapping is the standard's for eight inputs and eight
 * outputs; SAFETY: on a communication error all outputs go to 0, and no other value can be
 * configured. */
static const struct can_object io[] = {
    COMMUNICATION(CAN_IO_DEVICE_TYPE, CAN_IO_PRODUCT_CODE),
    CONST(0x1600, 0, 1, 1, "Number of mapped objects"),
    CONST(0x1600, 1, 4, MAP_OUTPUTS, "Mapped object 1"),
    TPDO,
    CONST(0x1a00, 0, 1, 1, "Number of mapped objects"),
    CONST(0x1a00, 1, 4, MAP_INPUTS, "Mapped object 1"),
    OWNER,
    CONST(0x6000, 0, 1, 1, "Highest sub-index supported"),
    STATUS(0x6000, 1, 1, "Input 1h to 8h"),
    CONST(0x6200, 0, 1, 1, "Highest sub-index supported"),
    OUTPUT(0x6200, 1, 1, false, "Output 1h to 8h"),
    CONST(0x6206, 0, 1, 1, "Highest sub-index supported"),
    CONST(0x6206, 1, 1, 0xff, "Error mode output 1h to 8h"),
    CONST(0x6207, 0, 1, 1, "Highest sub-index supported"),
    CONST(0x6207, 1, 1, 0, "Error value output 1h to 8h"),
};

enum { AXIS_OBJECTS = sizeof axis / sizeof *axis, IO_OBJECTS = sizeof io / sizeof *io };
_Static_assert((int)AXIS_OBJECTS <= (int)CAN_OBJECTS_MAX && (int)IO_OBJECTS <= (int)CAN_OBJECTS_MAX, "raise CAN_OBJECTS_MAX");

/* CiA 401 has no object for the value in force, so 0x6200 itself has that value after the SYNC. */
const struct can_dictionary can_axis = {.object = axis, .count = AXIS_OBJECTS, .command = MAP_VALVE, .actual = 0x6301};
const struct can_dictionary can_io = {.object = io, .count = IO_OBJECTS, .command = MAP_OUTPUTS, .actual = 0x6200};

const struct can_dictionary *can_dictionary_of(int node) { return node == CAN_IO ? &can_io : &can_axis; }

int can_object_find(const struct can_dictionary *d, uint16_t index, uint8_t sub) {
    for (int i = 0; i < d->count; i++)
        if (d->object[i].index == index && d->object[i].sub == sub) return i;
    return -1;
}

bool can_object_lacks(const struct can_object *o, uint32_t value) { return o->is_signed && value == 1u << (8 * o->size - 1); }

/* True for an identifier that SYNC and PDOs must not use (restricted COB-IDs, CiA 301, 7.3.5). */
static bool can_cob_restricted(uint32_t cob) {
    return cob <= 0x07f || (cob >= 0x101 && cob <= 0x180) || (cob >= 0x581 && cob <= 0x5ff) || (cob >= 0x601 && cob <= 0x67f) ||
           (cob >= 0x6e0 && cob <= 0x6ff) || cob >= 0x701;
}

/* Returns the abort code for a COB-ID of SYNC or of a PDO; 0 if it is valid. Bits 11 to 30 must be
 * 0; bit 31 switches a PDO off and means nothing to a SYNC consumer. */
static uint32_t refuse_cob(uint32_t value) {
    bool reserved = (value & 0x7ffff800) != 0, off = value >> 31;
    return reserved || (!off && can_cob_restricted(value & CAN_SFF_MASK)) ? SDO_VALUE : 0;
}

/* Returns the abort code for an entry of the RPDO's mapping; 0 if the entry can be mapped: the
 * command, or the dummy for INTEGER16. */
static uint32_t refuse_mapping(const struct can_dictionary *d, uint32_t entry) {
    uint16_t index = can_entry_index(entry);
    if (entry == d->command || entry == MAP_DUMMY) return 0;
    /* other data types than INTEGER16 are not accepted as dummies */
    if (index >> 8 == 0 && index) return SDO_NOT_MAPPABLE;
    if (can_object_find(d, index, can_entry_sub(entry)) >= 0) return SDO_NOT_MAPPABLE;
    return can_object_find(d, index, 0) < 0 ? SDO_NO_OBJECT : SDO_NO_SUB;
}

static uint32_t refuse_value(const struct can_dictionary *d, const struct can_object *o, uint32_t value) {
    switch ((uint32_t)o->index << 8 | o->sub) {
    case 0x100300: return value == 0 ? 0 : SDO_VALUE;
    case 0x100500: return can_cob_restricted(value & CAN_SFF_MASK) ? SDO_VALUE : refuse_cob(value);
    case 0x101601:
    case 0x101602: return value >> 24 ? SDO_VALUE : 0;
    case 0x101900: return value == 1 || value > 240 ? SDO_VALUE : 0;
    /* SAFETY: 1 (stay operational) is refused as the reaction to a communication error */
    case 0x102901: return value == 0 || value == 2 ? 0 : SDO_VALUE;
    case 0x140001:
    case 0x180001: return refuse_cob(value);
    case 0x140002: return value > 240 && value < 254 ? SDO_VALUE : 0; /* reserved in CiA 301 */
    case 0x160000: return value > CAN_GROUP_NODES ? SDO_MAPPING_LENGTH : 0;
    case 0x160001:
    case 0x160002:
    case 0x160003: return refuse_mapping(d, value);
    /* only the synchronous types 0 to 240 are accepted, because readings are latched by SYNC and
     * sent without a request */
    case 0x180002: return value > 240 ? SDO_VALUE : 0;
    default: return 0;
    }
}

uint32_t can_object_refuses(const struct can_dictionary *d, const struct can_object *o, int size, uint32_t value) {
    if (o->access == CAN_CONST || o->access == CAN_RO) return SDO_READ_ONLY;
    if (size && size != o->size) return SDO_SIZE;
    if (o->high && value > o->high) return SDO_TOO_HIGH;
    if (value < o->low) return SDO_TOO_LOW;
    return refuse_value(d, o, value);
}
