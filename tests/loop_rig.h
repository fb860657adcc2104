/* The simulated machine held in a pose by the controller's own functions, for tests of the closed
 * loop: references may be moved and commands disturbed in any cycle. */
#ifndef HEXID_TESTS_LOOP_RIG_H
#define HEXID_TESTS_LOOP_RIG_H

#include "force.h"
#include "kinematics.h"
#include "modal.h"
#include "pid.h"
#include "plant.h"
#include "support.h"

struct loop_rig {
    const struct params *params;
    struct plant *plant;
    struct pid pid[LEGS];
    struct modal modal;
    struct oil_column column[LEGS];
    struct cylinder_areas areas;
    struct hal_sample now, before;
    double length_m[LEGS]; /* of the pose */
    double command[LEGS];  /* commands of the controller in the last cycle */
};

static inline void loop_rig_open(struct loop_rig *r, const struct params *p, const double pose[DOFS]) {
    struct error error;
    struct kinematics k;
    *r = (struct loop_rig){.params = p, .plant = plant_create(p, 1, &error), .areas = cylinder_areas(&p->actuator)};
    if (!r->plant) fail_msg("%s", error.text);
    plant_place(r->plant, pose);
    kinematics_place(&k, p);
    ik_lengths(&k, pose, r->length_m);
    if (modal_init(&r->modal, p, &k, &error)) fail_msg("%s", error.text);
    oil_columns_init(r->column, p, &k);
    plant_measure(r->plant, &r->now);
    for (int i = 0; i < LEGS; i++) pid_reset(&r->pid[i], r->length_m[i], leg_force(&r->areas, i, r->now.p1_pa[i], r->now.p2_pa[i]));
}

static inline void loop_rig_close(struct loop_rig *r) { plant_destroy(r->plant); }

/* Runs one cycle with off_m added to the reference lengths and `add` to the controller's
 * commands. */
static inline void loop_rig_step(struct loop_rig *r, const double off_m[LEGS], const double add[LEGS]) {
    double valve[LEGS], ref_m[LEGS], seen_m[LEGS];
    r->before = r->now;
    plant_measure(r->plant, &r->now);
    for (int i = 0; i < LEGS; i++) ref_m[i] = r->length_m[i] + off_m[i];
    modal_lengths(&r->modal, ref_m, r->now.length_m, seen_m);
    for (int i = 0; i < LEGS; i++) {
        r->pid[i].feedback_cut = oil_feedback_cut(&r->column[i], r->now.length_m[i]);
        r->command[i] = pid_step(&r->pid[i], &r->params->control, r->params->loop.period_s, ref_m[i], seen_m[i],
                                 leg_force(&r->areas, i, r->now.p1_pa[i], r->now.p2_pa[i]));
        valve[i] = r->command[i] + add[i];
    }
    plant_step(r->plant, valve);
}

enum { LOOP_BLOCKS = 8, LOOP_BLOW = 2 };

/* Runs a platform that is held in a pose and gets a blow of size_m in block LOOP_BLOW. rms_mps: rms
 * leg rate in each block of half a second. */
static inline void loop_rig_hold(const struct params *p, const double pose[DOFS], double size_m, double rms_mps[LOOP_BLOCKS]) {
    static const double blow[LEGS] = {1.0, -0.5, 0.3, -0.8, 0.6, -1.0}, none[LEGS] = {0};
    struct loop_rig r;
    int cycles = (int)(0.5 / p->loop.period_s);
    loop_rig_open(&r, p, pose);
    for (int n = 0; n < LOOP_BLOCKS * cycles; n++) {
        double off_m[LEGS] = {0};
        for (int i = 0; i < LEGS && n / cycles == LOOP_BLOW && n % cycles < 2; i++) off_m[i] = blow[i] * size_m;
        loop_rig_step(&r, off_m, none);
        if (n % cycles == 0) rms_mps[n / cycles] = 0.0;
        for (int i = 0; i < LEGS; i++) {
            double rate_mps = (r.now.length_m[i] - r.before.length_m[i]) / p->loop.period_s;
            rms_mps[n / cycles] += rate_mps * rate_mps / (LEGS * cycles);
        }
    }
    loop_rig_close(&r);
    for (int i = 0; i < LOOP_BLOCKS; i++) rms_mps[i] = sqrt(rms_mps[i]);
}

/* True if after the blow the platform moves at more than a hundred times size_m a second (it may
 * then fall against a stop and lie still). True also if in the last block it moves at more than ten
 * times size_m a second, and faster than in the block of the blow. */
static inline bool loop_rig_shakes(const struct params *p, const double pose[DOFS], double size_m) {
    double rms_mps[LOOP_BLOCKS], most = 0.0;
    loop_rig_hold(p, pose, size_m, rms_mps);
    for (int i = LOOP_BLOW + 2; i < LOOP_BLOCKS; i++) most = fmax(most, rms_mps[i]);
    double last = rms_mps[LOOP_BLOCKS - 1], first = rms_mps[LOOP_BLOW];
    assert_true(isfinite(last));
    return most > 100.0 * size_m || (last > 10.0 * size_m && last > first);
}

#endif
