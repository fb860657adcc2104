/* The plant with the closed-form engine, without noise. */
#ifndef HEXID_TESTS_CLOSED_FORM_RIG_H
#define HEXID_TESTS_CLOSED_FORM_RIG_H

#include "params.h"
#include "support.h"

#include "engine.h"
#include "plant.h"
#include "rigid.h"
#include "units.h"

static const double SUBSTEP_S = 2.5e-4;

static inline struct params defaults(void) {
    struct params params;
    config_default(&params);
    params.sim.engine = ENGINE_CLOSED_FORM;
    params.sensors.enabled = false;
    return params;
}

static inline struct plant *plant_at(const struct params *params, const double pose[DOFS]) {
    struct error error;
    struct plant *plant = plant_create(params, 1, &error);
    if (!plant) fail_msg("%s", error.text);
    plant_place(plant, pose);
    return plant;
}

static inline struct plant_truth truth_of(const struct plant *plant) {
    struct plant_truth truth;
    plant_get_truth(plant, &truth);
    return truth;
}

static inline void holding_forces(const struct params *params, const double pose[DOFS], double force_n[LEGS]) {
    struct rigid_model m;
    rigid_model_init(&m, params);
    assert_true(rigid_holding_forces(&m, pose, force_n));
}

#endif
