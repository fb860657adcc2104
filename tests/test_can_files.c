/* config/hexid_node.eds, config/hexid_io.eds and config/hexid.dbc describe the program exactly:
 * every object and every signal, in both directions. */
#include "support.h"

#include <stdio.h>
#include <stdlib.h>

#include "can_node.h"
#include "channel.h"

static char *text_of(const char *path) {
    static char text[65536];
    FILE *file = fopen(path, "r");
    assert_non_null(file);
    text[fread(text, 1, sizeof text - 1, file)] = '\0';
    fclose(file);
    return text;
}

/* Returns a key's value in a section of the EDS, "" if absent. */
static const char *entry(const char *eds, const char *section, const char *key) {
    static char value[80];
    char head[48];
    snprintf(head, sizeof head, "\n[%s]\n", section);
    const char *at = strstr(eds, head);
    value[0] = '\0';
    if (!at) return value;
    const char *end = strstr(at + strlen(head), "\n[");
    snprintf(head, sizeof head, "\n%s=", key);
    at = strstr(at, head);
    if (at && (!end || at < end)) snprintf(value, sizeof value, "%.*s", (int)strcspn(at + strlen(head), "\n"), at + strlen(head));
    return value;
}

static unsigned data_type(const struct can_object *o) {
    /* CiA 301, table 44 */
    static const unsigned types[2][5] = {{0, 0x5, 0x6, 0, 0x7}, {0, 0x2, 0x3, 0, 0x4}};
    return types[o->is_signed][o->size];
}

static const struct {
    const char *path;
    const struct can_dictionary *dictionary;
} files[] = {{"config/hexid_node.eds", &can_axis}, {"config/hexid_io.eds", &can_io}};
enum { FILES = 2 };

static bool alone(const struct can_dictionary *d, const struct can_object *o) { return o->sub == 0 && can_object_find(d, o->index, 1) < 0; }

/* True for objects that the profiles allow in a PDO. */
static bool mappable(const struct can_object *o) { return o->index >= 0x6000 && o->sub && o->access != CAN_CONST; }

static void has_every_object(const char *eds, const struct can_dictionary *d) {
    static const char *const access[] = {[CAN_CONST] = "const", [CAN_RO] = "ro", [CAN_RW] = "rw", [CAN_WO] = "wo", [CAN_RWW] = "rww"};
    for (int i = 0; i < d->count; i++) {
        const struct can_object *o = &d->object[i];
        char section[40];
        snprintf(section, sizeof section, alone(d, o) ? "%04X" : "%04Xsub%X", o->index, o->sub);
        assert_string_equal(entry(eds, section, "ParameterName"), o->name);
        assert_int_equal(strtoul(entry(eds, section, "DataType"), NULL, 16), data_type(o));
        assert_string_equal(entry(eds, section, "AccessType"), access[o->access]);
        assert_int_equal(strtoul(entry(eds, section, "PDOMapping"), NULL, 0), mappable(o));
        assert_int_equal(strtoul(entry(eds, section, "LowLimit"), NULL, 0), o->low);
        assert_int_equal(strtoul(entry(eds, section, "HighLimit"), NULL, 0), o->high);
        const char *value = entry(eds, section, "DefaultValue");
        bool plus_node = !strncmp(value, "$NODEID+", 8);
        assert_int_equal(plus_node, o->plus_node);
        assert_int_equal(strtoul(value + (plus_node ? 8 : 0), NULL, 0), o->value);
    }
}

static void has_nothing_else(const char *eds, const struct can_dictionary *d) {
    int objects = 0;
    for (const char *at = eds; (at = strstr(at, "\n[")); at++) {
        unsigned index, sub = 0;
        char close;
        if (sscanf(at, "\n[%4x%c", &index, &close) != 2 || (close != ']' && sscanf(at, "\n[%4xsub%x]", &index, &sub) != 2)) continue;
        assert_true(can_object_find(d, (uint16_t)index, (uint8_t)sub) >= 0);
        if (close != ']' || alone(d, &d->object[can_object_find(d, (uint16_t)index, 0)])) objects++;
    }
    assert_int_equal(objects, d->count);
}

/* Asserts that the object lists name every index once, and that the number of sub-objects is right
 * for each record. */
static void lists_every_index_once(const char *eds, const struct can_dictionary *d) {
    static const char *const lists[] = {"MandatoryObjects", "OptionalObjects", "ManufacturerObjects"};
    int listed = 0, indices = 0;
    for (unsigned k = 0; k < 3; k++) {
        int count = atoi(entry(eds, lists[k], "SupportedObjects"));
        for (int i = 1; i <= count; i++, listed++) {
            char number[12];
            snprintf(number, sizeof number, "%d", i);
            assert_true(can_object_find(d, (uint16_t)strtoul(entry(eds, lists[k], number), NULL, 0), 0) >= 0);
        }
    }
    for (int i = 0; i < d->count; i++) {
        const struct can_object *o = &d->object[i];
        char section[8];
        int subs = 0;
        if (o->sub) continue;
        indices++;
        for (int k = i; k < d->count && d->object[k].index == o->index; k++) subs++;
        snprintf(section, sizeof section, "%04X", o->index);
        if (!alone(d, o)) assert_int_equal(atoi(entry(eds, section, "SubNumber")), subs);
    }
    assert_int_equal(listed, indices);
}

static void every_eds_has_every_object_as_the_node_serves_it(void **state) {
    (void)state;
    for (int i = 0; i < FILES; i++) has_every_object(text_of(files[i].path), files[i].dictionary);
}

static void no_eds_has_what_its_node_does_not_serve(void **state) {
    (void)state;
    for (int i = 0; i < FILES; i++) has_nothing_else(text_of(files[i].path), files[i].dictionary);
}

static void every_eds_lists_every_index_once(void **state) {
    (void)state;
    for (int i = 0; i < FILES; i++) lists_every_index_once(text_of(files[i].path), files[i].dictionary);
}

struct signal {
    unsigned cob, length, start, bits;
    char sign;
    double factor;
};

/* Finds the DBC signal of this name and the message that contains it. */
static struct signal signal_find(const char *dbc, const char *name) {
    struct signal s = {0};
    char head[48], line[40];
    snprintf(head, sizeof head, " SG_ %s :", name);
    const char *at = strstr(dbc, head), *message = dbc;
    assert_non_null(at);
    assert_int_equal(sscanf(at + strlen(head), " %u|%u@1%c (%lf,0)", &s.start, &s.bits, &s.sign, &s.factor), 4);
    for (const char *next = dbc; (next = strstr(next, "\nBO_ ")) && next < at; next++) message = next;
    assert_int_equal(sscanf(message, "\nBO_ %u %39[^:]: %u", &s.cob, line, &s.length), 3);
    return s;
}

static double decode(const struct signal *s, const struct can_frame *f) {
    assert_int_equal(f->can_id, s->cob);
    assert_int_equal(f->len, s->length);
    assert_true(s->start % 8 + s->bits <= 8 || s->start % 8 == 0);
    uint32_t raw = can_get(f->data + s->start / 8, (int)(s->bits + 7) / 8) >> s->start % 8 & (uint32_t)((1ull << s->bits) - 1);
    if (s->sign == '-' && raw >> (s->bits - 1)) return ((double)raw - (double)(1ull << s->bits)) * s->factor;
    return raw * s->factor;
}

static void dbc_decodes_what_the_codec_encodes(void **state) {
    const char *dbc = text_of("config/hexid.dbc");
    struct params p;
    uint64_t seed = 3;
    char name[40];
    (void)state;
    config_default(&p);
    for (int i = 0; i < 600; i++) {
        int leg = i % LEGS;
        struct can_tpdo t = {.position = 1000000 + random_below(&seed, 1500000),
                             .p1 = (int16_t)(random_below(&seed, 30000) - 150),
                             .p2 = (int16_t)(random_below(&seed, 30000) - 150)};
        struct can_frame f = can_frame_tpdo(leg + 1, &t);
        struct signal s = signal_find(dbc, (snprintf(name, sizeof name, "length_%d", leg + 1), name));
        /* rounding */
        assert_close(decode(&s, &f), channel_si(&p.length_channel, leg, t.position), 1e-12);
        s = signal_find(dbc, (snprintf(name, sizeof name, "p1_%d", leg + 1), name));
        assert_close(decode(&s, &f), channel_si(&p.p1_channel, leg, t.p1), 1e-6);
        s = signal_find(dbc, (snprintf(name, sizeof name, "p2_%d", leg + 1), name));
        assert_close(decode(&s, &f), channel_si(&p.p2_channel, leg, t.p2), 1e-6);
        int16_t valve[CAN_GROUP_NODES];
        for (int k = 0; k < CAN_GROUP_NODES; k++) valve[k] = (int16_t)(random_below(&seed, 65535) - 32767);
        f = can_frame_rpdo(can_group(leg + 1), valve);
        s = signal_find(dbc, (snprintf(name, sizeof name, "valve_%d", leg + 1), name));
        assert_close(decode(&s, &f), channel_si(&p.valve_channel, leg, valve[can_place(leg + 1)]), 1e-12);
    }
}

static void dbc_decodes_inputs_and_outputs(void **state) {
    static const char *const inputs[2 * INPUTS] = {"emergency_stop",      "enable",      "door",      "pressure",
                                                   "emergency_stop_open", "enable_open", "door_open", "pressure_open"};
    const char *dbc = text_of("config/hexid.dbc");
    (void)state;
    for (int i = 0; i < 256; i++) {
        struct can_tpdo t = {.inputs = (uint8_t)i};
        struct can_frame in = can_frame_tpdo(CAN_IO, &t), out = can_frame_outputs((uint8_t)i);
        for (int k = 0; k < 2 * INPUTS; k++) {
            struct signal s = signal_find(dbc, inputs[k]);
            assert_true(decode(&s, &in) == (double)(i >> k & 1));
        }
        struct signal s = signal_find(dbc, "supply");
        assert_true(decode(&s, &out) == (double)(i & OUTPUT_SUPPLY));
    }
}

static void dbc_decodes_heartbeats_emergencies_and_nmt(void **state) {
    const char *dbc = text_of("config/hexid.dbc");
    char name[40];
    (void)state;
    for (int node = 1; node <= CAN_NODES; node++) {
        struct can_frame f = can_frame_emcy(node, EMCY_RPDO_TIMEOUT, 0x11);
        struct signal s = signal_find(dbc, (snprintf(name, sizeof name, "emcy_%d_code", node), name));
        assert_true(decode(&s, &f) == EMCY_RPDO_TIMEOUT);
        s = signal_find(dbc, (snprintf(name, sizeof name, "emcy_%d_register", node), name));
        assert_true(decode(&s, &f) == 0x11);
        f = can_frame_heartbeat(node, CAN_OPERATIONAL);
        s = signal_find(dbc, (snprintf(name, sizeof name, "state_%d", node), name));
        assert_true(decode(&s, &f) == CAN_OPERATIONAL);
    }
    struct can_frame f = can_frame_nmt(NMT_START, 4);
    struct signal command = signal_find(dbc, "nmt_command"), node = signal_find(dbc, "nmt_node");
    assert_true(decode(&command, &f) == NMT_START && decode(&node, &f) == 4.0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_eds_has_every_object_as_the_node_serves_it),
        cmocka_unit_test(no_eds_has_what_its_node_does_not_serve),
        cmocka_unit_test(every_eds_lists_every_index_once),
        cmocka_unit_test(dbc_decodes_what_the_codec_encodes),
        cmocka_unit_test(dbc_decodes_inputs_and_outputs),
        cmocka_unit_test(dbc_decodes_heartbeats_emergencies_and_nmt),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
