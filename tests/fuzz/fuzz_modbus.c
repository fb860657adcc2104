/* What a Modbus device may answer: bytes through libmodbus and the register map to a reading. The first two bytes, the transaction's
 * number, are put right, or nearly all inputs would end there. */
#include <assert.h>
#include <math.h>
#include <modbus/modbus.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "config.h"
#include "modbus_link.h"
#include "modbus_map.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* In place of libmodbus': the answer is there before the request, and would be thrown away as a late one. */
int modbus_flush(modbus_t *m) {
    (void)m;
    return 0;
}

/* Whatever the registers hold: a reading is plausible or no number. */
static void look(const struct params *p, const struct modbus_reading *r) {
    for (int i = 0; i < LEGS; i++) {
        assert(isnan(r->length_m[i]) || (r->length_m[i] >= p->length_channel.low[i] && r->length_m[i] <= p->length_channel.high[i]));
        assert(isnan(r->p1_pa[i]) || (r->p1_pa[i] >= p->p1_channel.low[i] && r->p1_pa[i] <= p->p1_channel.high[i]));
        assert(isnan(r->p2_pa[i]) || (r->p2_pa[i] >= p->p2_channel.low[i] && r->p2_pa[i] <= p->p2_channel.high[i]));
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static struct params params;
    static const uint16_t written[MODBUS_WRITTEN] = {1};
    uint16_t read[MODBUS_READ];
    uint8_t answer[MODBUS_TCP_MAX_ADU_LENGTH] = {0, 1};
    struct modbus_reading reading;
    int ends[2];
    if (params.loop.period_s <= 0.0) config_default(&params);
    if (size > sizeof answer - 2 || socketpair(AF_UNIX, SOCK_STREAM, 0, ends)) return 0;
    memcpy(answer + 2, data, size);
    modbus_t *m = modbus_new_tcp("127.0.0.1", 502);
    modbus_set_socket(m, ends[0]);
    modbus_set_response_timeout(m, 0, 1);
    modbus_set_byte_timeout(m, 0, 0);
    bool filled = write(ends[1], answer, size + 2) == (ssize_t)(size + 2) && !shutdown(ends[1], SHUT_WR);
    struct modbus_link *link = (struct modbus_link *)m;
    if (filled && !modbus_link_exchange(link, MODBUS_WRITE_FROM, MODBUS_WRITTEN, written, MODBUS_READ_FROM, MODBUS_READ, read)) {
        modbus_get_reading(&params, read, &reading);
        look(&params, &reading);
    }
    close(ends[0]);
    close(ends[1]);
    modbus_free(m);
    return 0;
}
