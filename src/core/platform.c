#include "platform.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "gains.h"
#include "params.h"
#include "units.h"

static const double HELD = 0.1; /* largest error of any leg, as a share of limits.following_m, at
                                 * which the gains may change at neutral */

enum {
    GOOD_SAMPLES = 50,  /* number of consecutive good samples after which the sensors are trusted */
    INIT_PATIENCE = 1000,  /* level of the bucket of bad samples at which a fault is latched in
                            * STATE_INIT, which waits for the sensors */
    INIT_CYCLES = 2 * INIT_PATIENCE, /* number of cycles of STATE_INIT in which the sensors must
                                      * become good; after them a single bad sample is a fault */
};

int platform_init(struct platform *p, const struct params *params, struct error *error) {
    memset(p, 0, sizeof *p);
    p->params = params;
    p->areas = cylinder_areas(&params->actuator);
    p->good_seq = -1, p->set_seq = -1;
    p->control = params->control;
    p->automatic = params->motion.automatic;
    p->pose[DOF_Z] = params->motion.park_z_m;
    reference_hold(&p->reference, p->pose);
    int status = kinematics_init(&p->kinematics, params, error);
    if (status) return status;
    status = model_law_init(&p->model, params, &p->kinematics, error);
    if (status) return status;
    status = modal_init(&p->modal, params, &p->kinematics, error);
    if (status) return status;
    oil_columns_init(p->column, params, &p->kinematics);
    oscillation_init(&p->oscillation, params, &p->kinematics);
    return STATUS_OK;
}

uint32_t platform_wrong(const struct platform *p) {
    return interlock_wrong(&p->params->interlocks, supervisor_powers(p->supervisor.state), p->inputs);
}

/* false for NaN */
static bool inside(double x, double lo, double hi) { return x >= lo && x <= hi; }

/* SAFETY: returns SAMPLE_STALE if device_seq has not increased, else 0. A device that hangs may
 * repeat its last sample with fresh time stamps; only device_seq shows that. */
static uint32_t count_says(struct platform *p, const struct hal_sample *in) {
    if (in->flags & SAMPLE_IO) return 0;
    bool anew = in->device_seq == 0 || (int64_t)(in->device_seq - p->device_seq) > 0;
    p->device_seq = in->device_seq;
    if (anew) p->anew_seq = p->seq;
    return anew ? 0 : SAMPLE_STALE;
}

static double age_s(const struct platform *p, const struct hal_sample *in) {
    int64_t silent_ns = (p->seq - p->anew_seq) * ns_from_seconds(p->params->loop.period_s);
    return seconds_from_ns(in->age_ns < 0 || in->age_ns > silent_ns ? in->age_ns : silent_ns);
}

/* Result of judging a sample by the limits. */
struct judgement {
    uint32_t faults;              /* FAULT_... bits and the bits of their legs */
    uint32_t asked;               /* fault for which judge() puts the value furthest beyond its
                                   * limit into `measure`; 0: none */
    double beyond;           /* excess of that furthest value over its limit */
    struct fault_measure measure; /* leg, value and limit of that furthest value */
};

/* Judges one value by its limits. leg: -1 for a value that belongs to no leg. NaN counts as
 * infinitely far beyond a limit. */
static inline void judge(struct judgement *j, uint32_t fault, int leg, double value, double least, double most) {
    if (inside(value, least, most)) return;
    j->faults |= fault | (leg < 0 ? 0 : fault_leg(leg));
    double beyond = isnan(value) ? (double)INFINITY : fmax(value - most, least - value);
    if (fault != j->asked || !(beyond > j->beyond)) return;
    j->beyond = beyond;
    j->measure = (struct fault_measure){.leg = leg, .value = value, .limit = value < least ? least : most};
}

/* Returns the time since the last good sample, by the count of cycles or by the clock, whichever is
 * longer; they differ if deadlines were missed. */
static double since_good_s(const struct platform *p, const struct hal_sample *in) {
    return fmax((double)(p->seq - p->good_seq) * p->params->loop.period_s, seconds_from_ns(in->time_ns) - seconds_from_ns(p->good_ns));
}

static void judge_legs(struct judgement *j, const struct platform *p, const struct hal_sample *in) {
    const struct limit_params *l = &p->params->limits;
    bool powers = supervisor_powers(p->supervisor.state), drives = supervisor_drives(p->supervisor.state);
    double elapsed_s = since_good_s(p, in);
    for (int i = 0; i < LEGS; i++) {
        double length_m = in->length_m[i], force_n = leg_force(&p->areas, i, in->p1_pa[i], in->p2_pa[i]);
        judge(j, FAULT_SENSOR_INVALID, i, length_m, -DBL_MAX, DBL_MAX);
        judge(j, FAULT_PRESSURE_SENSOR, i, in->p1_pa[i], l->pressure_min_pa, l->pressure_max_pa);
        judge(j, FAULT_PRESSURE_SENSOR, i, in->p2_pa[i], l->pressure_min_pa, l->pressure_max_pa);
        judge(j, FAULT_STROKE, i, length_m, l->length_min_m[i], l->length_max_m[i]);
        if (p->good_seq >= 0) judge(j, FAULT_LEG_RATE, i, fabs(length_m - p->length_m[i]) / elapsed_s, 0.0, l->leg_rate_mps);
        /* the force is NaN only if a pressure is, which is a pressure fault already */
        if (!isnan(force_n)) judge(j, FAULT_FORCE, i, force_n, -l->force_n, l->force_n);
        /* SAFETY: checked whenever the supply is on, because a stuck spool moves its leg even
         * before the valves are driven */
        if (powers) judge(j, FAULT_FOLLOWING, i, fabs(p->leg_ref_m[i] - length_m), 0.0, l->following_m);
        if (drives) judge(j, FAULT_STANDSTILL, i, p->still_high_m[i] - p->still_low_m[i], 0.0, l->standstill_m);
    }
}

static void judge_common(struct judgement *j, const struct platform *p, const struct hal_sample *in) {
    /* the limit is rounded to whole nanoseconds like the age, so that an age at the limit is no
     * fault */
    double oldest_s = seconds_from_ns(ns_from_seconds(p->params->limits.sensor_age_s));
    judge(j, FAULT_SENSOR_AGE, -1, age_s(p, in), 0.0, oldest_s);
    judge(j, FAULT_OVERRUN, -1, p->overruns, 0.0, nextafter(p->params->loop.overrun_limit, 0.0));
    if (!supervisor_drives(p->supervisor.state)) return;
    judge(j, FAULT_OSCILLATION, -1, p->oscillation.found_mps2, 0.0, p->oscillation.allowed_mps2);
}

/* Judges a sample by all limits. With SAMPLE_IO the legs' readings are not judged. */
static struct judgement judge_sample(const struct platform *p, const struct hal_sample *in, uint32_t asked) {
    struct judgement j = {.asked = asked, .measure = {.leg = -1, .value = (double)NAN, .limit = (double)NAN}};
    judge_common(&j, p, in);
    if (!(in->flags & SAMPLE_IO)) judge_legs(&j, p, in);
    return j;
}

/* Returns the largest length error, m, with which forward kinematics gives up. */
static double misfit_m(const struct platform *p, const struct hal_sample *in) {
    double pose[DOFS];
    memcpy(pose, p->pose, sizeof pose);
    return fk_solve(&p->kinematics, in->length_m, pose).residual_m;
}

/* Returns value, limit and leg of a fault that was found with this sample. */
static struct fault_measure measure_of(const struct platform *p, const struct hal_sample *in, uint32_t fault) {
    struct fault_measure m = judge_sample(p, in, fault).measure;
    if (fault == FAULT_KINEMATICS) m.value = misfit_m(p, in);
    if (fault == FAULT_OSCILLATION) m.explained = p->oscillation.allowed_mps2 - p->oscillation.limit_mps2;
    if (fault == FAULT_ANTIVALENCE) m.inputs = p->contradicted;
    return m;
}

/* SAFETY: returns the faults of open interlocks. An open interlock is a fault while the supply is
 * on; otherwise it only prevents `engage`. In STATE_PRESSURISING await_pressure() judges the
 * pressure. */
static uint32_t interlock_doubts(const struct platform *p) {
    enum state state = p->supervisor.state;
    if (!supervisor_powers(state)) return 0;
    return interlock_faults(platform_wrong(p) & ~(state == STATE_PRESSURISING ? INPUT_SUPPLY : 0u));
}

/* SAFETY: decides whether the controller trusts a sample. Returns FAULT_... bits and the bits of
 * the legs concerned; 0 for a good sample. */
static uint32_t doubts(const struct platform *p, const struct hal_sample *in) {
    uint32_t suspect = in->flags & SAMPLE_FOREIGN ? FAULT_MASTER : 0;
    if (in->flags & SAMPLE_TWIN) suspect |= FAULT_TWIN | (in->twins << FAULT_LEG_SHIFT & FAULT_LEGS);
    if (p->contradicted) suspect |= FAULT_ANTIVALENCE;
    /* overruns are checked even if no sample was read */
    if (p->overruns >= p->params->loop.overrun_limit) suspect |= FAULT_OVERRUN;
    if (in->flags & SAMPLE_UNWRITTEN) suspect |= interlock_doubts(p);
    if (in->flags & SAMPLE_IO) return suspect | FAULT_IO;
    suspect |= interlock_doubts(p);
    suspect |= judge_sample(p, in, 0).faults;
    if (in->flags & SAMPLE_INVALID) suspect |= FAULT_SENSOR_INVALID;
    if (suspect & FAULT_OSCILLATION) suspect |= p->oscillation.legs;
    return suspect;
}

/* SAFETY: updates the range over which each leg's reference has moved since the reading of the
 * leg's length last changed. No other check detects a transducer whose reading is stuck: its leg
 * runs away while this reading and the other legs look right. */
static void watch_standstill(struct platform *p, const struct hal_sample *in) {
    for (int i = 0; i < LEGS && !(in->flags & SAMPLE_IO); i++) {
        double ref_m = p->leg_ref_m[i];
        bool moved = in->length_m[i] != p->still_m[i];
        if (moved || ref_m < p->still_low_m[i]) p->still_low_m[i] = ref_m;
        if (moved || ref_m > p->still_high_m[i]) p->still_high_m[i] = ref_m;
        p->still_m[i] = in->length_m[i];
    }
}

/* SAFETY: counts deadlines missed in a row, in one long delay or in several late cycles. At the
 * limit, a device's watchdog may have centred the valves without the loop's knowledge, so the loop
 * must not continue the previous command. */
static void count_overruns(struct platform *p, const struct hal_sample *in) {
    int64_t count = p->overruns + in->missed, limit = p->params->loop.overrun_limit;
    p->overruns = in->missed > 0 ? (int)(count < limit ? count : limit) : 0;
}

/* Computes the leg forces. A leg with doubtful pressures keeps its last force, so that the
 * controller's high-pass filter lets the force feedback decay to zero. */
static void observe_forces(struct platform *p, const struct hal_sample *in, uint32_t suspect) {
    for (int i = 0; i < LEGS; i++)
        if (!(suspect & fault_leg(i))) p->force_n[i] = leg_force(&p->areas, i, in->p1_pa[i], in->p2_pa[i]);
}

static void observe_inputs(struct platform *p, const struct hal_sample *in) {
    p->inputs = in->inputs;
    p->contradicted = interlock_contradicts(&p->watch, &p->params->interlocks, in->contradicted, p->params->loop.period_s);
}

/* Takes pose and leg forces from a sample, unless it has a fault that stops. Returns the faults of
 * the sample. */
static uint32_t observe(struct platform *p, const struct hal_sample *in) {
    count_overruns(p, in);
    watch_standstill(p, in);
    if (!(in->flags & SAMPLE_IO) || in->flags & SAMPLE_UNWRITTEN) observe_inputs(p, in);
    uint32_t suspect = doubts(p, in);
    if (failures_with(REACTION_STOP, suspect)) return suspect;
    double pose[DOFS];
    memcpy(pose, p->pose, sizeof pose);
    if (!fk_solve(&p->kinematics, in->length_m, pose).converged) return suspect | FAULT_KINEMATICS;
    memcpy(p->pose, pose, sizeof pose);
    memcpy(p->length_m, in->length_m, sizeof p->length_m);
    observe_forces(p, in, suspect);
    p->good_seq = p->seq;
    p->good_ns = in->time_ns;
    return suspect;
}

/* Returns the level of the leaky bucket at which bad samples become a fault. A level of 1 tolerates
 * no bad sample. SAFETY: the level is 1 for a second master, because neither master knows where the
 * platform goes next; for switches, because a person operated them on purpose; and for faults that
 * were observed for long enough before: an oscillation, contacts that contradict each other, and,
 * except in STATE_INIT, overruns. In STATE_INIT a device whose samples are alternately good and bad
 * would never fill the bucket, so after INIT_CYCLES one bad sample is enough for a fault. */
static int patience(const struct platform *p, uint32_t suspect) {
    const uint32_t means_it = FAULT_EMERGENCY_STOP | FAULT_ENABLE | FAULT_DOOR | FAULT_ANTIVALENCE;
    if (suspect & (FAULT_MASTER | FAULT_OSCILLATION | means_it)) return 1;
    if (p->supervisor.state == STATE_INIT) return p->ticks < INIT_CYCLES ? INIT_PATIENCE : 1;
    return suspect & FAULT_OVERRUN ? 1 : p->params->limits.bad_cycles;
}

static enum trigger commanded(struct platform *p, struct request request) {
    static const enum trigger of_command[COMMANDS] = {
        [COMMAND_ENGAGE] = TRIGGER_ENGAGE, [COMMAND_START] = TRIGGER_START, [COMMAND_STOP] = TRIGGER_STOP,
        [COMMAND_PARK] = TRIGGER_PARK,     [COMMAND_RESET] = TRIGGER_RESET,
    };
    if (request.id == p->supervisor.request_id || (unsigned)request.command >= COMMANDS) return TRIGGER_NONE;
    p->supervisor.request_id = request.id;
    if (command_stops(request.command)) p->automatic = false;
    return of_command[request.command];
}

static double in_state_s(const struct platform *p) { return (double)p->ticks * p->params->loop.period_s; }

/* SAFETY: closing the last interlock must not start the machine. So an automatic run ends if an
 * input is open before the supply is on, whatever else is doubtful in the sample. Lingering
 * pressure ends the run only once the platform is settled. Samples with SAMPLE_IO or SAMPLE_INVALID
 * are left out, because their inputs may be unknown. A stale sample counts, because on CAN its
 * inputs are newer than its readings. */
static void end_automatic(struct platform *p, const struct hal_sample *in) {
    uint32_t wrong = platform_wrong(p);
    if (p->supervisor.state != STATE_SETTLED) wrong &= ~(uint32_t)INPUT_LINGERS;
    if (!p->automatic || !wrong || supervisor_powers(p->supervisor.state)) return;
    if (in->flags & (SAMPLE_IO | SAMPLE_INVALID)) return;
    p->automatic = false, p->opened = wrong;
}

/* Returns the request that an automatic run makes now: engage, start or park. */
static enum trigger automatic(struct platform *p) {
    bool left = p->test < tests_count(&p->params->tests);
    if (!p->automatic) return TRIGGER_NONE;
    bool rested = in_state_s(p) >= p->params->motion.rest_s;
    if (p->supervisor.state == STATE_SETTLED) return left && rested ? TRIGGER_ENGAGE : TRIGGER_NONE;
    bool held = in_state_s(p) >= p->params->motion.hold_s;
    if (p->supervisor.state != STATE_READY || !held) return TRIGGER_NONE;
    return left ? TRIGGER_START : TRIGGER_PARK;
}

static void move_to(struct platform *p, double z_m, double duration_s) {
    const struct motion_params *m = &p->params->motion;
    const struct move_start from = {.pose = p->ref, .rate = p->ref_rate, .accel = p->ref_accel};
    const struct move_limits limits = {duration_s, m->rate_mps, m->accel_mps2, p->kinematics.arm_m};
    reference_move(&p->reference, &from, (const double[DOFS]){[DOF_Z] = z_m}, &limits);
}

/* Starts the move up without a bump: the reference starts at the measured pose. */
static void engage(struct platform *p) {
    memcpy(p->ref, p->pose, sizeof p->ref);
    memset(p->ref_rate, 0, sizeof p->ref_rate);
    memset(p->ref_accel, 0, sizeof p->ref_accel);
    for (int i = 0; i < LEGS; i++) {
        pid_reset(&p->pid[i], p->length_m[i], p->force_n[i]);
        p->leg_ref_m[i] = p->still_low_m[i] = p->still_high_m[i] = p->length_m[i];
    }
    model_law_reset(&p->model);
    oscillation_reset(&p->oscillation, p->pose);
    move_to(p, 0.0, p->params->motion.engage_s);
}

static void test_begin(struct platform *p) {
    const struct test_params *t = &p->params->tests;
    reference_test(&p->reference, tests_single(t) ? t->order[p->test] : DOF_NONE, p->trajectory, t, p->params->loop.period_s);
}

static void enter(struct platform *p, const struct transition *row) {
    p->supervisor.state = row->to;
    p->ticks = 0;
    switch (row->to) {
    case STATE_INIT: supervisor_clear(&p->supervisor); break;
    case STATE_SETTLED:
        p->automatic = p->automatic && row->from == STATE_INIT;
        /* bad samples that STATE_INIT tolerated no longer count */
        p->supervisor.bad = p->supervisor.doubtful = 0;
        break;
    case STATE_ENGAGING: engage(p); break;
    case STATE_PRESSURISING: memcpy(p->leg_ref_m, p->length_m, sizeof p->leg_ref_m); break;
    case STATE_READY: break;
    case STATE_TESTING:
        if (p->test >= tests_count(&p->params->tests)) p->test = 0;
        p->stopping = false;
        test_begin(p);
        break;
    case STATE_PARKING:
        /* if a test must be ramped out first, ended() begins the move to the parked pose */
        if (!row->ramp_out) move_to(p, p->params->motion.park_z_m, p->params->motion.park_s);
        break;
    default: p->automatic = false; break;
    }
}

/* Applies a trigger. Returns false if it has no effect in this state. */
static bool apply(struct platform *p, enum trigger trigger) {
    const struct transition *row = supervisor_find(p->supervisor.state, trigger);
    /* SAFETY: no supply while an interlock is open. */
    if (!row || (trigger == TRIGGER_ENGAGE && platform_wrong(p))) return false;
    if (row->ramp_out) reference_stop(&p->reference);
    if (row->to != row->from) enter(p, row);
    else p->stopping = row->ramp_out;
    return true;
}

/* Starts what follows when a move or a test has ended: the next test, the next move, or the next
 * state. */
static void ended(struct platform *p, enum reference_mode was) {
    switch (p->supervisor.state) {
    case STATE_TESTING:
        if (p->stopping || ++p->test >= tests_count(&p->params->tests)) apply(p, TRIGGER_TESTS_DONE);
        else test_begin(p);
        break;
    case STATE_PARKING:
        if (was == REFERENCE_TEST) move_to(p, p->params->motion.park_z_m, p->params->motion.park_s);
        else apply(p, TRIGGER_ARRIVED);
        break;
    default: apply(p, TRIGGER_ARRIVED); break;
    }
}

/* Computes this cycle's reference, and its rate and acceleration from the parabola through the
 * last three poses. */
static struct reference_sample refer(struct platform *p) {
    double dt_s = p->params->loop.period_s;
    struct reference_sample s = reference_step(&p->reference, &p->params->tests, dt_s);
    for (int i = 0; i < DOFS; i++) {
        double between = (s.pose[i] - p->ref[i]) / dt_s, before = p->ref_rate[i] - p->ref_accel[i] * dt_s / 2.0;
        p->ref_accel[i] = (between - before) / dt_s;
        p->ref_rate[i] = between + p->ref_accel[i] * dt_s / 2.0;
    }
    memcpy(p->ref, s.pose, sizeof p->ref);
    return s;
}

/* Computes a leg's valve command by the configured law. length_m: length from modal_lengths(). */
static double leg_command(struct platform *p, int leg, double length_m) {
    const struct params *c = p->params;
    if (c->control.law == CONTROL_MODEL)
        return model_law_command(&p->model, &p->control, leg, &p->pid[leg], p->leg_ref_m[leg], length_m, p->force_n[leg]);
    return pid_step(&p->pid[leg], &p->control, c->loop.period_s, p->leg_ref_m[leg], length_m, p->force_n[leg]);
}

/* SAFETY: computes the valve commands. An untrusted sample changes no command: the last one is
 * held, as long as the leaky bucket allows. */
static void control(struct platform *p, const struct hal_sample *in, uint32_t suspect) {
    bool good = !failures_with(REACTION_STOP, suspect);
    double seen_m[LEGS];
    ik_lengths(&p->kinematics, p->ref, p->leg_ref_m);
    modal_lengths(&p->modal, p->leg_ref_m, p->length_m, seen_m);
    if (!good) model_law_hold(&p->model);
    else if (p->params->control.law == CONTROL_MODEL)
        model_law_step(&p->model, &(struct model_law_input){&p->reference, in->p1_pa, in->p2_pa, suspect});
    for (int i = 0; i < LEGS; i++) {
        p->pid[i].feedback_cut = oil_feedback_cut(&p->column[i], p->length_m[i]);
        if (good) p->command.valve[i] = leg_command(p, i, seen_m[i]);
        else pid_hold(&p->pid[i], p->leg_ref_m[i]);
    }
    if (good) oscillation_step(&p->oscillation, p->pose, p->ref, p->command.valve, suspect & FAULT_PRESSURE_SENSOR ? NULL : p->force_n);
    p->command.enable = true;
}

/* SAFETY: centres the valves in every cycle in which they are not driven; the reference follows the
 * platform. */
static void rest(struct platform *p) {
    p->command = (struct hal_command){.enable = false, .supply = p->command.supply};
    memcpy(p->ref, p->pose, sizeof p->ref);
}

/* SAFETY: toggles the supply output in every cycle in which the supply is to be on. These changes
 * are the life sign; it ends when the daemon dies or a fault stops the platform. */
static void power(struct platform *p) {
    if (supervisor_powers(p->supervisor.state)) p->command.supply = !p->command.supply;
}

/* Reacts to faults: stops the platform at once if this sample's reaction is to stop; otherwise
 * parks it while a fault is latched. */
static void react(struct platform *p, enum reaction reaction) {
    if (reaction == REACTION_STOP) apply(p, TRIGGER_FAULT);
    else if (p->supervisor.faults) apply(p, TRIGGER_PARK);
}

/* Ends STATE_PRESSURISING once the supply has pressure and the sample is good. Without a wired
 * pressure switch, pressure counts as present after interlocks.pressure_s; if the supply output
 * is not wired either, at once. Returns FAULT_SUPPLY if pressure does not come in time,
 * otherwise 0. */
static uint32_t await_pressure(struct platform *p, bool good) {
    const struct interlock_params *i = &p->params->interlocks;
    bool over = in_state_s(p) >= i->pressure_s;
    if (p->supervisor.state != STATE_PRESSURISING) return 0;
    bool there = i->pressure ? p->inputs & INPUT_SUPPLY : over || !i->supply;
    if (there && good) apply(p, TRIGGER_PRESSURE);
    return over && !there ? FAULT_SUPPLY : 0;
}

/* SAFETY: returns true if gains may change: the platform is settled or held at neutral, the sample
 * is not doubtful, and no fault is latched. At neutral also no output may be saturated, and the
 * error of every leg must be at most HELD times limits.following_m. */
static bool at_rest(const struct platform *p, uint32_t suspect) {
    if (suspect || p->supervisor.faults) return false;
    if (p->supervisor.state == STATE_SETTLED) return true;
    if (p->supervisor.state != STATE_READY || p->reference.mode != REFERENCE_HOLD) return false;
    for (int i = 0; i < LEGS; i++)
        if (p->pid[i].saturated || !(fabs(p->leg_ref_m[i] - p->length_m[i]) <= HELD * p->params->limits.following_m)) return false;
    return true;
}

/* Changes the gains of all legs without a bump, or of no leg. Returns false if the gains may not
 * change now. Under the law `model` kpf feeds back only the difference from the reference force. */
static bool change_gains(struct platform *p, const struct gains *gains, uint32_t suspect) {
    struct gains from = gains_of(&p->control);
    struct control_params to = p->control;
    struct pid pid[LEGS];
    double seen_m[LEGS];
    bool soon = p->set_seq >= 0 && (double)(p->seq - p->set_seq) * p->params->loop.period_s < GAINS_REST_S;
    if (soon || gains_refused(&from, gains) != LOOP_GAINS || !at_rest(p, suspect)) return false;
    gains_apply(gains, &to);
    memcpy(pid, p->pid, sizeof pid);
    modal_lengths(&p->modal, p->leg_ref_m, p->length_m, seen_m);
    for (int i = 0; i < LEGS && p->supervisor.state == STATE_READY; i++) {
        double ref_n = p->params->control.law == CONTROL_MODEL ? p->model.share * p->model.varying_ref_n[i] : 0.0;
        const struct pid_reading reading = {seen_m[i], p->force_n[i], ref_n};
        if (!pid_change(&pid[i], &p->control, &to, p->params->loop.period_s, &reading)) return false;
    }
    memcpy(p->pid, pid, sizeof pid);
    p->control = to;
    p->set_seq = p->seq;
    return true;
}

static bool begins(enum trigger trigger) { return trigger == TRIGGER_ENGAGE || trigger == TRIGGER_START; }

void platform_step(struct platform *p, const struct hal_sample *in, struct request request, struct cycle *out) {
    struct supervisor *s = &p->supervisor;
    struct reference_sample ref = {0};

    uint32_t stale = count_says(p, in), suspect = observe(p, in);
    bool sets = request.command == COMMAND_SET && request.id != s->request_id;
    enum trigger asked = commanded(p, request);
    if (sets) p->request_taken = change_gains(p, &request.gains, suspect);
    /* SAFETY: engage and start have no effect with a doubtful sample, because its inputs are
     * doubtful, too. */
    if (asked != TRIGGER_NONE) p->request_taken = !(suspect && begins(asked)) && apply(p, asked);
    end_automatic(p, in);
    if (!suspect) apply(p, automatic(p));
    suspect |= await_pressure(p, !suspect);
    /* SAFETY: faults are judged last, so that no request of the same cycle can undo a fault
     * before it is seen. */
    uint32_t headline = s->first_fault;
    enum reaction reaction = supervisor_judge(s, suspect, patience(p, suspect));
    if (s->first_fault != headline) p->measure = measure_of(p, in, s->first_fault);
    react(p, reaction);
    if (s->good >= GOOD_SAMPLES) apply(p, TRIGGER_SENSORS_GOOD);
    /* the cause persists and has latched the fault again, so the reset had no effect */
    if (asked == TRIGGER_RESET && s->state == STATE_FAULT) p->request_taken = false;
    p->ticks++;

    int test = s->state == STATE_TESTING || s->state == STATE_PARKING ? p->test : -1;
    enum dof dof = p->reference.dof;
    if (supervisor_drives(s->state)) {
        enum reference_mode mode = p->reference.mode;
        ref = refer(p);
        control(p, in, suspect);
        if (ref.done && mode != REFERENCE_HOLD) ended(p, mode);
    }
    if (s->faults && !supervisor_drives(s->state)) apply(p, TRIGGER_FAULT);
    if (!supervisor_drives(s->state)) rest(p);
    power(p);

    *out = (struct cycle){.seq = (uint64_t)p->seq,
                          .in = *in,
                          .out = p->command,
                          .state = s->state,
                          .faults = s->faults,
                          .first_fault = s->first_fault,
                          .measure = p->measure,
                          .opened = p->opened,
                          .gains = gains_of(&p->control),
                          .law_doubts = supervisor_drives(s->state) ? p->model.doubts : 0,
                          .test = -1,
                          .dof = DOF_NONE};
    out->in.flags |= stale | (platform_wrong(p) ? SAMPLE_OPEN : 0);
    /* the identification must not use samples that the controller doubts */
    if (suspect) out->in.flags |= SAMPLE_INVALID;
    if (ref.phase != PHASE_NONE) out->test = test, out->dof = dof, out->phase = ref.phase, out->test_time_s = ref.test_time_s;
    memcpy(out->ref, p->ref, sizeof out->ref);
    memcpy(out->pose, p->pose, sizeof out->pose);
    memcpy(out->force_n, p->force_n, sizeof out->force_n);
    p->seq++;
}
