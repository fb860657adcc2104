/* The machine of the control benches: the default one, with dry friction in its cylinders. */
#ifndef HEXID_BENCH_MACHINES_H
#define HEXID_BENCH_MACHINES_H

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "config.h"
#include "params.h"

static inline void fail(const char *what) {
    fprintf(stderr, "control bench: %s\n", what);
    exit(1);
}

static inline void rub(struct params *p, const double extend_n[LEGS], const double retract_n[LEGS]) {
    struct effect_values *dry = &p->effects[effect_find("cylinder_coulomb_friction")];
    dry->on = true;
    memcpy(dry->value[0], extend_n, sizeof dry->value[0]), memcpy(dry->value[1], retract_n, sizeof dry->value[1]);
}

static inline void configure_file(struct params *p, const char *file, double dry_n) {
    struct error error;
    double all_n[LEGS];
    static const char *const settings[] = {"tests.settle_s=0.5", "tests.duration_s=3", "motion.engage_s=3", "motion.park_s=3"};
    if (config_load(p, file, settings, sizeof settings / sizeof *settings, &error)) fail(error.text);
    p->interlocks = (struct interlock_params){0};
    for (int leg = 0; leg < LEGS; leg++) all_n[leg] = dry_n;
    if (dry_n > 0.0) rub(p, all_n, all_n);
}

static inline void configure(struct params *p, double dry_n) { configure_file(p, NULL, dry_n); }

#endif
