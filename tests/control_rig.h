/* Runs a control law on the simulated machine or another one, through six sines one after another
 * or another motion, and compares the platform's true pose with the reference. Controller and
 * machine have separate configurations, so that the controller may be wrong about the machine. */
#ifndef HEXID_TESTS_CONTROL_RIG_H
#define HEXID_TESTS_CONTROL_RIG_H

#include <string.h>

#include "params.h"
#include "plant.h"
#include "platform.h"
#include "units.h"

struct control_figures {
    bool faulted;                  /* a fault ended the run */
    uint32_t fault;
    enum state faulted_in;         /* state in which the fault came */
    double amplitude_pct[DOFS];    /* amplitude error of the tested axis's fundamental */
    double phase_deg[DOFS];        /* phase of that fundamental against the reference; negative:
                                    * late */
    double unwanted_pct[DOFS];     /* largest fundamental of any other axis; angles count as
                                    * displacements at the distance arm_m */
    double rms_m;                  /* rms distance of the true pose from the reference, angles at
                                    * the distance arm_m */
    double rms_position_m, rms_angle_rad;   /* rms distance of the origin from its reference, and
                                             * rms of the norm of the three angles' errors */
    double peak_position_m, peak_angle_rad; /* the largest of both */
    double peak_command;           /* largest valve command; like the errors, of the evaluated
                                    * part */
    double still_mps2;             /* largest unexpected acceleration: what oscillation.h finds,
                                    * less what it explains by the reference; its limit is
                                    * limits.oscillation_mps2 */
    double true_mps2;              /* the same of the platform's own acceleration: largest rms over
                                    * a quarter of a second, less OSCILLATION_ASKED times the
                                    * reference's */
    int driven_cycles, doubt_cycles; /* number of cycles in which the platform was driven, and of
                                      * those with a doubtful sample */
};

/* Sums over the evaluated part of a test: pose and reference times sine and cosine. */
struct control_sums {
    double pose[DOFS][2], ref[2], square_m2, square_rad2;
    int64_t count;
};

static inline void control_take(struct control_sums *sum, const struct cycle *c, const double pose[DOFS], double hz) {
    double angle = 2.0 * PI * hz * c->test_time_s, base[2] = {sin(angle), cos(angle)};
    for (int k = 0; k < 2; k++) {
        for (int i = 0; i < DOFS; i++) sum->pose[i][k] += pose[i] * base[k];
        if (c->dof != DOF_NONE) sum->ref[k] += c->ref[c->dof] * base[k];
    }
    for (int i = 0; i < DOFS; i++) *(i < DOF_PHI ? &sum->square_m2 : &sum->square_rad2) += pow(pose[i] - c->ref[i], 2.0);
    sum->count++;
}

static inline void control_take_peaks(struct control_figures *f, const struct cycle *c, const double pose[DOFS]) {
    double square_m2 = 0.0, square_rad2 = 0.0;
    for (int i = 0; i < DOFS; i++) *(i < DOF_PHI ? &square_m2 : &square_rad2) += pow(pose[i] - c->ref[i], 2.0);
    f->peak_position_m = fmax(f->peak_position_m, sqrt(square_m2)), f->peak_angle_rad = fmax(f->peak_angle_rad, sqrt(square_rad2));
    for (int leg = 0; leg < LEGS; leg++) f->peak_command = fmax(f->peak_command, fabs(c->out.valve[leg]));
}

/* The true pose in the controller's coordinates, whose origin is the mass centre that it knows. */
static inline void control_pose(const struct payload_params *machine, const struct payload_params *controller, double pose[DOFS]) {
    const double apart[3] = {controller->center_x_m - machine->center_x_m, controller->center_y_m - machine->center_y_m,
                             machine->center_height_m - controller->center_height_m};
    double t[3][3];
    rotation_from_angles(pose[DOF_PHI], pose[DOF_THETA], pose[DOF_PSI], t);
    for (int r = 0; r < 3; r++)
        for (int k = 0; k < 3; k++) pose[r] += (t[r][k] - (r == k)) * apart[k];
}

static inline void control_close(struct control_figures *f, const struct control_sums *sum, enum dof dof, double arm_m) {
    if (dof == DOF_NONE) return;
    double own = hypot(sum->pose[dof][0], sum->pose[dof][1]), asked = hypot(sum->ref[0], sum->ref[1]);
    double phase = atan2(sum->pose[dof][1], sum->pose[dof][0]) - atan2(sum->ref[1], sum->ref[0]);
    f->amplitude_pct[dof] = 100.0 * (own / asked - 1.0);
    f->phase_deg[dof] = 180.0 / PI * remainder(phase, 2.0 * PI);
    for (int i = 0; i < DOFS; i++) {
        double share = hypot(sum->pose[i][0], sum->pose[i][1]) * (i < DOF_PHI ? 1.0 : arm_m) / (asked * (dof < DOF_PHI ? 1.0 : arm_m));
        if (i != (int)dof) f->unwanted_pct[dof] = fmax(f->unwanted_pct[dof], 100.0 * share);
    }
}

/* Mean squares of accelerations, and what they are differences of: poses and rates in the cycle
 * before, of the platform and of the reference. */
struct control_shaking {
    double square[2], pose[2][DOFS], rate[2][DOFS];
    int cycles; /* since driving began */
};

/* Takes a driven cycle with the true pose. Returns the acceleration beyond the reference's if a
 * quarter of a second is complete, otherwise 0. */
static inline double control_shake(struct control_shaking *s, const struct cycle *c, const double pose[DOFS], double period_s,
                                   double arm_m) {
    double beyond = 0.0, square[2] = {0};
    int quarter = (int)(0.25 / period_s);
    for (int k = 0; k < 2; k++)
        for (int i = 0; i < DOFS; i++) {
            double now = k ? c->ref[i] : pose[i], rate = (now - s->pose[k][i]) / period_s;
            square[k] += pow((i < DOF_PHI ? 1.0 : arm_m) * (rate - s->rate[k][i]) / period_s, 2.0);
            s->pose[k][i] = now, s->rate[k][i] = rate;
        }
    if (s->cycles++ < 2) return 0.0; /* there are no differences yet */
    for (int k = 0; k < 2; k++) s->square[k] += square[k];
    if (s->cycles % quarter == 0) {
        beyond = sqrt(s->square[0] / quarter) - OSCILLATION_ASKED * sqrt(s->square[1] / quarter);
        s->square[0] = s->square[1] = 0.0;
    }
    return beyond;
}

/* Acceleration that the reference does not explain; 0 before the first block. */
static inline double control_unexpected_mps2(const struct oscillation *o) {
    return o->allowed_mps2 > 0.0 ? o->found_mps2 - (o->allowed_mps2 - o->limit_mps2) : 0.0;
}

/* A machine that a controller drives: hexid's plant or another one. */
struct control_machine {
    void *state;
    const struct payload_params *payload; /* its mass centre is the origin of the true pose */
    double period_s;
    void (*measure)(void *state, struct hal_sample *sample); /* lengths, pressures and inputs */
    void (*pose)(void *state, double pose[DOFS]);            /* the true pose */
    void (*step)(void *state, const double valve[LEGS]);     /* one period with these commands */
};

/* Lets the controller compute the machine's cycle number i, and returns the machine's true pose at
 * the sample. */
static inline void control_cycle(const struct control_machine *m, struct platform *platform, int64_t i, double pose[DOFS],
                                 struct cycle *c) {
    struct hal_sample sample = {.time_ns = ns_from_seconds((double)i * m->period_s), .device_seq = (uint64_t)i + 1, .inputs = INPUTS_ALL};
    m->measure(m->state, &sample);
    m->pose(m->state, pose);
    platform_step(platform, &sample, (struct request){0}, c);
}

static inline void control_act(const struct control_machine *m, const struct cycle *c) {
    m->step(m->state, c->out.enable ? c->out.valve : (const double[LEGS]){0});
}

/* Drives a machine with this controller through its tests. trajectory: NULL or the tests'
 * motion. */
static inline void control_run(const struct control_machine *machine, const struct params *controller, const struct trajectory *trajectory,
                               struct control_figures *f) {
    struct error error;
    struct platform *platform = calloc(1, sizeof *platform);
    struct control_sums sum = {0};
    struct control_shaking shaking = {0};
    struct cycle c = {.test = -1, .dof = DOF_NONE}, before = c;
    double square_m2 = 0.0, square_rad2 = 0.0, pose[DOFS];
    int64_t count = 0;
    memset(f, 0, sizeof *f);
    if (!platform || platform_init(platform, controller, &error)) {
        fprintf(stderr, "control rig: %s\n", error.text);
        exit(1);
    }
    platform->trajectory = trajectory;
    for (int64_t i = 0; i < 1000000 && c.state != STATE_FAULT; i++, before = c) {
        control_cycle(machine, platform, i, pose, &c);
        control_pose(machine->payload, &controller->payload, pose);
        if (c.test != before.test && before.test >= 0 && sum.count) {
            control_close(f, &sum, before.dof, platform->kinematics.arm_m);
            square_m2 += sum.square_m2, square_rad2 += sum.square_rad2, count += sum.count;
            sum = (struct control_sums){0};
        }
        if (c.phase == PHASE_EVALUATE) {
            control_take(&sum, &c, pose, controller->tests.hz[c.dof < 0 ? 0 : c.dof]);
            control_take_peaks(f, &c, pose);
        }
        f->still_mps2 = fmax(f->still_mps2, control_unexpected_mps2(&platform->oscillation));
        if (supervisor_drives(c.state))
            f->true_mps2 = fmax(f->true_mps2, control_shake(&shaking, &c, pose, machine->period_s, platform->kinematics.arm_m));
        f->driven_cycles += supervisor_drives(c.state), f->doubt_cycles += supervisor_drives(c.state) && platform->model.doubts != 0;
        if (c.first_fault && !f->faulted) f->faulted = true, f->fault = c.first_fault, f->faulted_in = before.state;
        if (c.state == STATE_SETTLED && before.state == STATE_PARKING) break;
        control_act(machine, &c);
    }
    double share = 1.0 / (double)(count ? count : 1);
    f->rms_position_m = sqrt(share * square_m2), f->rms_angle_rad = sqrt(share * square_rad2);
    f->rms_m = hypot(f->rms_position_m, platform->kinematics.arm_m * f->rms_angle_rad);
    free(platform);
}

static inline void control_measure_plant(void *state, struct hal_sample *sample) { plant_measure(state, sample); }

static inline void control_pose_of_plant(void *state, double pose[DOFS]) {
    struct plant_truth truth;
    plant_get_truth(state, &truth);
    memcpy(pose, truth.pose, sizeof truth.pose);
}

static inline void control_step_plant(void *state, const double valve[LEGS]) { plant_step(state, valve); }

/* Makes hexid's own plant; release it by plant_destroy(m->state). */
static inline void control_make_plant(struct control_machine *m, const struct params *machine, uint64_t seed) {
    struct error error;
    *m = (struct control_machine){plant_create(machine, seed, &error),
                                  &machine->payload,
                                  machine->loop.period_s,
                                  control_measure_plant,
                                  control_pose_of_plant,
                                  control_step_plant};
    if (m->state) return;
    fprintf(stderr, "control rig: %s\n", error.text);
    exit(1);
}

/* Drives hexid's own plant as control_run() does. */
static inline void control_drive(const struct params *machine, const struct params *controller, const struct trajectory *trajectory,
                                 uint64_t seed, struct control_figures *f) {
    struct control_machine m;
    control_make_plant(&m, machine, seed);
    control_run(&m, controller, trajectory, f);
    plant_destroy(m.state);
}

#endif
