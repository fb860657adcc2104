/* Configurations that the control benches compare: the machine, one whose payload is 30 % too
 * light, and what `hexid identify --model` finds from that one. */
#ifndef HEXID_BENCH_DRIVERS_H
#define HEXID_BENCH_DRIVERS_H

#include <stdlib.h>

#include "ident.h"
#include "machine_found.h"
#include "method_c.h"
#include "params.h"
#include "plant.h"
#include "platform.h"
#include "../admit_rig.h"

#include "machines.h"

/* Results of a run of the paper's six tests under the PID with the configuration `wrong`. */
struct found {
    struct ident ident;
    struct recording recording;
    struct method_c c;
    struct machine_found written; /* what `hexid identify --model` writes */
};

static inline void solve(const struct params *wrong, struct found *f) {
    struct error error;
    struct equations *equations = malloc(sizeof *equations);
    struct estimate *estimate = malloc(sizeof *estimate);
    if (admit_rig(&f->recording, false, &error) || method_c_equations(&f->recording, equations, &error) ||
        method_c_solve(equations, wrong, estimate, &f->c, &error))
        fail("not identified");
    machine_found(wrong, &f->c, estimate, &f->written);
    free(equations), free(estimate);
}

static inline void identify(const struct params *machine, const struct params *wrong, struct found *f) {
    struct error error;
    struct plant *plant = plant_create(machine, 1, &error);
    struct platform *platform = calloc(1, sizeof *platform);
    struct cycle c = {0};
    if (!plant || !platform || platform_init(platform, wrong, &error) || ident_init(&f->ident, wrong, &error)) fail(error.text);
    recording_init(&f->recording, wrong);
    for (int64_t i = 0; c.state != STATE_PARKING && c.state != STATE_FAULT; i++) {
        struct hal_sample sample = {.time_ns = ns_from_seconds((double)i * machine->loop.period_s), .device_seq = (uint64_t)i + 1};
        plant_measure(plant, &sample);
        platform_step(platform, &sample, (struct request){0}, &c);
        ident_feed(&f->ident, &c);
        if (recording_add(&f->recording, &c, &error)) fail(error.text);
        plant_step(plant, c.out.enable ? c.out.valve : (const double[LEGS]){0});
    }
    ident_end(&f->ident);
    if (!ident_solve(&f->ident)) fail("not identified");
    solve(wrong, f);
    plant_destroy(plant);
    free(platform);
}

/* The configuration with a payload that is 30 % too light, and without dry friction. */
static inline void make_wrong(struct params *p, const struct params *machine) {
    struct payload_params *load = &p->payload;
    *p = *machine;
    p->effects[effect_find("cylinder_coulomb_friction")].on = false;
    load->mass_kg *= 0.7, load->inertia_xx_kg_m2 *= 0.7, load->inertia_yy_kg_m2 *= 0.7, load->inertia_zz_kg_m2 *= 0.7;
}

#endif
