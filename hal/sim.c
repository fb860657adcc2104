/* sim: the simulated platform, stepped by the loop's thread. A read first simulates the cycle that
 * has passed, with the last command, then latches lengths and pressures. So a command acts from the
 * reading that precedes it until the next reading. */
#include <stdlib.h>
#include <string.h>

#include "backends.h"
#include "params.h"
#include "plant.h"

struct sim {
    struct hal hal;
    struct plant *plant;
    uint64_t seq;
    int64_t first_ns;      /* loop time of the first reading */
    double clock_ratio;
    struct hal_command command;
};

static int sim_open(struct hal **hal, const char *address, const struct params *params, uint64_t seed, struct error *error) {
    (void)address; /* configuration file of the machine; the caller has read it into params */
    struct sim *s = calloc(1, sizeof *s);
    if (!s) return error_set(error, STATUS_IO, "sim: out of memory");
    s->hal.ops = &hal_sim;
    s->plant = plant_create(params, seed, error);
    if (!s->plant) {
        free(s);
        return error->status;
    }
    if (params->interlocks.supply) plant_add_power_unit(s->plant, params->device.watchdog_s);
    s->clock_ratio = plant_clock_ratio(s->plant);
    *hal = &s->hal;
    return STATUS_OK;
}

static int sim_read(struct hal *hal, int64_t now_ns, struct hal_sample *sample) {
    struct sim *s = (struct sim *)hal;
    plant_life_sign(s->plant, s->command.supply);
    if (s->seq++) plant_step(s->plant, s->command.valve);
    else s->first_ns = now_ns;
    plant_measure(s->plant, sample);
    sample->time_ns = s->clock_ratio == 1.0 ? now_ns : s->first_ns + (int64_t)(s->clock_ratio * (double)(now_ns - s->first_ns));
    sample->device_seq = s->seq;
    return 0;
}

static int sim_write(struct hal *hal, const struct hal_command *command) {
    ((struct sim *)hal)->command = *command;
    return 0;
}

static void sim_safe(struct hal *hal) {
    struct sim *s = (struct sim *)hal;
    for (int i = 0; i < LEGS; i++) s->command.valve[i] = 0.0;
}

static void sim_close(struct hal *hal) {
    plant_destroy(((struct sim *)hal)->plant);
    free(hal);
}

const struct hal_ops hal_sim = {
    .scheme = "sim",
    .usage =
        "sim:[FILE]                 the simulated platform (needs nothing); FILE: its configuration, where the controller's is another",
    .simulated = true,
    .open = sim_open,
    .read = sim_read,
    .write = sim_write,
    .safe = sim_safe,
    .close = sim_close,
};
