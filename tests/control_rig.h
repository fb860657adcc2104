/* Runs a control law on the simulated machine, through six sines one after another or another
 * motion, and compares the platform's true pose with the reference. Controller and machine have
 * separate configurations, so that the controller may be wrong about the machine. */
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

/* Mean squares of accelerations, and what they are differences of: rates in the cycle before. */
struct control_shaking {
    double true_square, asked_square, twist[DOFS], ref[DOFS], ref_rate[DOFS];
    int cycles; /* since driving began */
};

/* Takes a driven cycle. Returns the acceleration beyond the reference's if a quarter of a second is
 * complete, otherwise 0. */
static inline double control_shake(struct control_shaking *s, const struct cycle *c, const double twist[DOFS], double period_s,
                                   double arm_m) {
    double beyond = 0.0, square[2] = {0};
    int quarter = (int)(0.25 / period_s);
    for (int i = 0; i < DOFS; i++) {
        double arm = i < DOF_PHI ? 1.0 : arm_m, rate = (c->ref[i] - s->ref[i]) / period_s;
        square[0] += pow(arm * (twist[i] - s->twist[i]) / period_s, 2.0), square[1] += pow(arm * (rate - s->ref_rate[i]) / period_s, 2.0);
        s->twist[i] = twist[i], s->ref[i] = c->ref[i], s->ref_rate[i] = rate;
    }
    if (s->cycles++ < 2) return 0.0; /* there are no differences yet */
    s->true_square += square[0], s->asked_square += square[1];
    if (s->cycles % quarter == 0) {
        beyond = sqrt(s->true_square / quarter) - OSCILLATION_ASKED * sqrt(s->asked_square / quarter);
        s->true_square = s->asked_square = 0.0;
    }
    return beyond;
}

/* Acceleration that the reference does not explain; 0 before the first block. */
static inline double control_unexpected_mps2(const struct oscillation *o) {
    return o->allowed_mps2 > 0.0 ? o->found_mps2 - (o->allowed_mps2 - o->limit_mps2) : 0.0;
}

/* Drives the machine with this controller through its tests. trajectory: NULL or the tests'
 * motion. */
static inline void control_drive(const struct params *machine, const struct params *controller, const struct trajectory *trajectory,
                                 uint64_t seed, struct control_figures *f) {
    struct error error;
    struct plant *plant = plant_create(machine, seed, &error);
    struct platform *platform = calloc(1, sizeof *platform);
    struct control_sums sum = {0};
    struct control_shaking shaking = {0};
    struct cycle c = {.test = -1, .dof = DOF_NONE}, before = c;
    double square_m2 = 0.0, square_rad2 = 0.0, period_s = machine->loop.period_s;
    int64_t count = 0;
    memset(f, 0, sizeof *f);
    if (!plant || !platform || platform_init(platform, controller, &error)) {
        fprintf(stderr, "control rig: %s\n", error.text);
        exit(1);
    }
    platform->trajectory = trajectory;
    for (int64_t i = 0; i < 1000000 && c.state != STATE_FAULT; i++, before = c) {
        struct hal_sample sample = {.time_ns = ns_from_seconds((double)i * period_s), .device_seq = (uint64_t)i + 1, .inputs = INPUTS_ALL};
        struct plant_truth truth;
        plant_measure(plant, &sample);
        plant_get_truth(plant, &truth);
        control_pose(&machine->payload, &controller->payload, truth.pose);
        platform_step(platform, &sample, (struct request){0}, &c);
        if (c.test != before.test && before.test >= 0 && sum.count) {
            control_close(f, &sum, before.dof, platform->kinematics.arm_m);
            square_m2 += sum.square_m2, square_rad2 += sum.square_rad2, count += sum.count;
            sum = (struct control_sums){0};
        }
        if (c.phase == PHASE_EVALUATE) {
            control_take(&sum, &c, truth.pose, controller->tests.hz[c.dof < 0 ? 0 : c.dof]);
            control_take_peaks(f, &c, truth.pose);
        }
        f->still_mps2 = fmax(f->still_mps2, control_unexpected_mps2(&platform->oscillation));
        if (supervisor_drives(c.state))
            f->true_mps2 = fmax(f->true_mps2, control_shake(&shaking, &c, truth.twist, period_s, platform->kinematics.arm_m));
        f->driven_cycles += supervisor_drives(c.state), f->doubt_cycles += supervisor_drives(c.state) && platform->model.doubts != 0;
        if (c.first_fault && !f->faulted) f->faulted = true, f->fault = c.first_fault, f->faulted_in = before.state;
        if (c.state == STATE_SETTLED && before.state == STATE_PARKING) break;
        plant_step(plant, c.out.enable ? c.out.valve : (const double[LEGS]){0});
    }
    double share = 1.0 / (double)(count ? count : 1);
    f->rms_position_m = sqrt(share * square_m2), f->rms_angle_rad = sqrt(share * square_rad2);
    f->rms_m = hypot(f->rms_position_m, platform->kinematics.arm_m * f->rms_angle_rad);
    plant_destroy(plant);
    free(platform);
}

#endif
