/* libFuzzer: any frames at any times into the master and a node. The first byte of a record picks receiver and error flag; then a frame. */
#include <stddef.h>
#include <string.h>

#include "can_master.h"
#include "config.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static struct params params;
    struct can_master master;
    struct can_node node;
    struct can_queue q = {0};
    struct hal_sample sample;
    static const double valve[LEGS] = {0.5};
    char text[200];
    if (params.can.bitrate_bps == 0.0) config_default(&params);
    can_master_init(&master, &params, 1);
    can_node_init(&node, 3, 1, &q);
    int64_t now_ns = 1;
    for (; size >= 12; data += 12, size -= 12) {
        struct can_frame f = {.can_id = (canid_t)((data[1] | data[2] << 8) & 0x7ff), .len = data[3] % 9};
        memcpy(f.data, data + 4, 8);
        if (data[0] & 1) f.can_id |= CAN_ERR_FLAG;
        now_ns += (int64_t)(data[0] >> 3) * 1000000;
        q.count = 0;
        can_master_receive(&master, &f, data[0] & 4, now_ns);
        can_node_receive(&node, &f, now_ns, &q);
        can_node_sync(&node, &(struct can_frame){.can_id = COB_SYNC}, &(struct can_tpdo){.position = (int32_t)now_ns}, &q);
        can_node_tick(&node, now_ns, &q);
        for (int i = 0; i < q.count; i++) can_master_receive(&master, &q.frame[i], false, now_ns);
        q.count = 0;
        can_master_poll(&master, now_ns, data[0] & 2, &q);
        if (data[0] & 4) can_master_command(&master, valve, &q);
        for (int i = 0; i < q.count; i++) can_node_receive(&node, &q.frame[i], now_ns, &q);
        can_master_sample(&master, &sample);
        can_condition_describe(can_master_condition(&master), &params, text, sizeof text);
        if (can_node_valve(&node) != 0 && node.state != CAN_OPERATIONAL) __builtin_trap(); /* SAFETY: the node's promise */
    }
    return 0;
}
