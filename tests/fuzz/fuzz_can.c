/* libFuzzer: any frames at any times into the master, an axis and the I/O module. The first byte of
 * a record selects receiver and error flag; then comes a frame. */
#include <stddef.h>
#include <string.h>

#include "can_master.h"
#include "config.h"
#include "params.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static struct params params;
    struct can_master master;
    struct can_node node[2];
    struct can_queue q = {0};
    struct hal_sample sample;
    static const int ids[2] = {3, CAN_IO};
    struct hal_command command = {.valve = {0.5}, .enable = true};
    char text[200];
    if (params.can.bitrate_bps == 0.0) config_default(&params);
    can_master_init(&master, &params, 1);
    for (int k = 0; k < 2; k++) can_node_init(&node[k], ids[k], 1, &q);
    int64_t now_ns = 1;
    for (; size >= 12; data += 12, size -= 12) {
        struct can_frame f = {.can_id = (canid_t)((data[1] | data[2] << 8) & 0x7ff), .len = data[3] % 9};
        memcpy(f.data, data + 4, 8);
        if (data[0] & 1) f.can_id |= CAN_ERR_FLAG;
        now_ns += (int64_t)(data[0] >> 3) * 1000000;
        q.count = 0;
        can_master_receive(&master, &f, data[0] & 4, now_ns);
        for (int k = 0; k < 2; k++) {
            const struct can_tpdo latched = {.position = (int32_t)now_ns, .inputs = data[4]};
            can_node_receive(&node[k], &f, now_ns, &q);
            can_node_sync(&node[k], &(struct can_frame){.can_id = COB_SYNC}, &latched, &q);
            can_node_tick(&node[k], now_ns, &q);
        }
        for (int i = 0; i < q.count; i++) can_master_receive(&master, &q.frame[i], false, now_ns);
        q.count = 0;
        can_master_poll(&master, now_ns, data[0] & 2, &q);
        command.supply = !command.supply;
        if (data[0] & 4) can_master_command(&master, &command, &q);
        else if (data[0] & 1) can_master_safe(&master, &q);
        const struct can_queue sent = q;
        q.count = 0;
        for (int i = 0; i < 2 * sent.count; i++) can_node_receive(&node[i % 2], &sent.frame[i / 2], now_ns, &q);
        can_master_sample(&master, &sample);
        can_condition_describe(can_master_condition(&master), &params, text, sizeof text);
        for (int k = 0; k < 2; k++) /* SAFETY: a node that is not operational has no output */
            if (can_node_output(&node[k]) != 0 && node[k].state != CAN_OPERATIONAL) __builtin_trap();
    }
    return 0;
}
