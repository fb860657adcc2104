/* Values that one cycle of the loop reads, decides and writes, shared by every top-level folder.
 *
 * Frames (Tian 2015): {B} inertial, {M} on the platform with its origin at the payload's mass
 * centre; x forward, y right, z down; both coincide at the neutral pose. A pose is x y z [m] phi
 * theta psi [rad], rotation Rz(psi) Ry(theta) Rx(phi). A wrench is Fx Fy Fz [N] Mx My Mz [N m]
 * about the origin of {M}, in {B}. Legs are numbered 0..5 inside, 1..6 for people. */
#ifndef HEXID_TYPES_H
#define HEXID_TYPES_H

#include <stdbool.h>
#include <stdint.h>

enum { LEGS = 6, DOFS = 6 };
enum dof { DOF_X, DOF_Y, DOF_Z, DOF_PHI, DOF_THETA, DOF_PSI, DOF_NONE = -1 };
extern const char *const dof_names[DOFS + 1]; /* names of the axes, ended by NULL. src/core/names.c
                                               * defines this list, state_names and command_names */

/* Sample flags. A sample with any of them is counted and excluded from identification. */
enum {
    SAMPLE_STALE = 1u << 0,   /* the device has latched no new sample since the previous cycle:
                               * device_seq repeats or steps back */
    SAMPLE_LATE = 1u << 1,    /* the sample is more than half a period older than usual for the
                               * back-end, or the time since the previous latching differs from the
                               * period by more than half a period */
    SAMPLE_DROPPED = 1u << 2, /* one or more samples before this one were lost */
    SAMPLE_INVALID = 1u << 3, /* a value is not finite or implausible, a device reports an error, or
                               * the controller distrusts the sample */
    SAMPLE_OVERRUN = 1u << 4, /* the loop missed a deadline before this cycle, so that the previous
                               * command acted too long */
    SAMPLE_IO = 1u << 5,      /* the hardware abstraction layer could not read, or could not write
                               * the previous command */
    SAMPLE_FOREIGN = 1u << 6, /* another master commands this machine */
    SAMPLE_OPEN = 1u << 7,    /* an interlock that must be closed is open, or INPUT_LINGERS is
                               * set */
    SAMPLE_UNWRITTEN = 1u << 8, /* set together with SAMPLE_IO: the sample was read, but the
                                 * previous command was not written */
    SAMPLE_TWIN = 1u << 9,      /* two devices answer under one address (hal_sample.twins) */
    SAMPLE_FLAGS = 10,
};

/* SAFETY: inputs of the machine, a bit each; 0 if open or unknown. */
enum {
    INPUT_EMERGENCY_STOP = 1u << 0, /* the emergency stop's chain is closed */
    INPUT_ENABLE = 1u << 1,         /* the enable switch is held */
    INPUT_DOOR = 1u << 2,           /* the door is closed */
    INPUT_SUPPLY = 1u << 3,       /* the supply has pressure */
    INPUTS = 4,
    INPUTS_ALL = (1u << INPUTS) - 1,
    INPUT_LINGERS = 1u << INPUTS,   /* no input of its own, but a member of sets of wrong inputs:
                                     * the supply has pressure although it is switched off */
};

/* Sample of the hardware abstraction layer: lengths and pressures latched together at one instant,
 * time_ns. */
struct hal_sample {
    int64_t time_ns;        /* device's instant of latching, on the loop's clock; with SAMPLE_IO but
                             * not SAMPLE_UNWRITTEN the instant of the failed read */
    int64_t age_ns;         /* time from latching to reading */
    uint64_t device_seq;    /* the device's own count of samples; 0: the device does not count. A
                             * gap means that samples were lost; a repeat or a step back means that
                             * this sample is stale */
    uint32_t flags;         /* set of SAMPLE_... */
    uint32_t inputs;        /* set of INPUT_... that are closed */
    uint32_t contradicted;  /* INPUT_... whose two contacts contradict each other; they count as
                             * open */
    int64_t missed;         /* number of deadlines that the loop missed before this cycle */
    uint32_t twins;         /* with SAMPLE_TWIN: 1u << leg for each leg for which two devices
                             * answer; 0 if the twin is at the inputs, or its leg is unknown */
    double length_m[LEGS];  /* length of each leg, from joint to joint */
    double p1_pa[LEGS];     /* gauge pressure on the rodless side */
    double p2_pa[LEGS];     /* gauge pressure on the rod side */
};

/* Command to the machine. A valve's value is a share of full opening, -1..1; positive extends the
 * leg. */
struct hal_command {
    double valve[LEGS];
    bool enable; /* false: valves are centred whatever `valve` is */
    bool supply; /* SAFETY: level of the life sign. It changes in every cycle while the supply is to
                  * be on; if it stops changing, the machine's own relay cuts the supply */
};

enum state {
    STATE_INIT,
    STATE_SETTLED,
    STATE_ENGAGING,
    STATE_READY,
    STATE_TESTING,
    STATE_PARKING,
    STATE_FAULT,
    STATE_PRESSURISING,
    STATES
};
extern const char *const state_names[STATES];

/* Bits of faults. A fault stays latched until reset. The first one is the headline (first_fault),
 * unless a later fault stops a platform that the first one only parks (supervisor_judge()). */
enum {
    FAULT_SENSOR_AGE = 1u << 0,
    FAULT_SENSOR_INVALID = 1u << 1,
    FAULT_STROKE = 1u << 2,
    FAULT_LEG_RATE = 1u << 3,
    FAULT_FOLLOWING = 1u << 4,
    FAULT_FORCE = 1u << 5,
    FAULT_KINEMATICS = 1u << 6, /* forward kinematics finds no pose for these lengths: a leg's
                                 * sensor is wrong */
    FAULT_OVERRUN = 1u << 7,
    FAULT_IO = 1u << 8, /* the hardware abstraction layer reports that it cannot read or write */
    FAULT_STANDSTILL = 1u << 9, /* a length stays the same while its reference changes: the
                                 * transducer, the valve or the supply is dead */
    FAULT_MASTER = 1u << 10,    /* another master commands this machine, or has tried to */
    FAULT_EMERGENCY_STOP = 1u << 11, /* the emergency stop's chain is open */
    FAULT_ENABLE = 1u << 12,         /* the enable switch is open */
    FAULT_DOOR = 1u << 13,           /* the door is open */
    FAULT_SUPPLY = 1u << 14,         /* the supply's pressure switch is open */
    FAULT_PRESSURE_SENSOR = 1u << 15,  /* a chamber's pressure is no valid reading: the platform is
                                        * parked, and meanwhile the controller does without that
                                        * reading */
    FAULT_OSCILLATION = 1u << 22,      /* the platform shakes although the reference does not: the
                                        * loop is unstable */
    FAULT_TWIN = 1u << 23,             /* two devices answer as if they were one */
    FAULT_ANTIVALENCE = 1u << 24,      /* the two contacts of an input contradict each other */
};

/* Bits 16..21 of a fault word: the legs at which the faults were seen, 0 if no leg is known.
 * first_fault never has them. Faults take bits 0..15 and 22..30. */
enum { FAULT_LEG_SHIFT = 16, FAULT_LEGS = ((1 << LEGS) - 1) << FAULT_LEG_SHIFT, FAULT_ANY = 0x7fffffff & ~FAULT_LEGS };
static inline uint32_t fault_leg(int leg) { return 1u << (FAULT_LEG_SHIFT + leg); }

/* Value and limit of a fault when it was latched, in SI units; NaN if nothing was measured or there
 * is no limit. */
struct fault_measure {
    int leg;             /* leg furthest beyond its limit, 0..5; -1: no leg */
    double value, limit;
    double explained;    /* part of `limit` that the reference's own acceleration adds to the
                          * configured limit; only for FAULT_OSCILLATION, otherwise 0 */
    uint32_t inputs;     /* INPUT_... whose contacts contradict each other; 0 for any other fault */
};

enum command { COMMAND_NONE, COMMAND_ENGAGE, COMMAND_START, COMMAND_STOP, COMMAND_PARK, COMMAND_RESET, COMMAND_SET, COMMANDS };
static inline bool command_stops(enum command command) { return command == COMMAND_STOP || command == COMMAND_PARK; }
extern const char *const command_names[COMMANDS];

/* Gains of the controller that may be changed while it runs (src/core/gains.h). */
enum { LOOP_GAINS = 5 };
struct gains {
    double value[LOOP_GAINS];
};

/* Request from ordinary threads to the loop, through a mailbox; the loop acts on it once, when id
 * changes. */
struct request {
    uint32_t id;
    enum command command;
    struct gains gains; /* new gains; used only with COMMAND_SET */
};

enum phase { PHASE_NONE, PHASE_SETTLE, PHASE_RAMP_IN, PHASE_EVALUATE, PHASE_RAMP_OUT };

/* Everything known about one cycle. platform_step() fills it in, the ring carries it to the
 * recorder, the log keeps it and the identifier reads it. Lengths and pressures of `in` were
 * latched together at in.time_ns. `out` is computed from `in`; it takes effect at in.time_ns on
 * `sim:`, and one cycle later on a field bus with SYNC, and is held until the next command takes
 * effect. `ref` is the reference at in.time_ns. */
struct cycle {
    uint64_t seq;
    struct hal_sample in;
    struct hal_command out;
    double ref[DOFS];
    double pose[DOFS];     /* pose that forward kinematics finds for in.length_m; the last good one
                            * if `in` is not trusted */
    double force_n[LEGS];  /* force of each leg, A1 P1 - A2 P2; the last good one if the leg's
                            * pressures are not trusted */
    enum state state;
    uint32_t faults;       /* latched faults: FAULT_... and fault_leg() */
    uint32_t first_fault;  /* the fault that stands for all latched ones; 0 if there is none */
    struct fault_measure measure; /* value and limit of first_fault; no message carries them */
    uint32_t law_doubts;   /* DOUBT_... (model_law.h): why the PID drives in place of the configured
                            * law `model`; no message carries them, but an event reports them */
    uint32_t opened;       /* wrong inputs (interlock_wrong()) that ended the automatic run; 0:
                            * none; no message carries them, but an event reports them */
    uint32_t request_id;   /* id of the last request that was processed; 0: none */
    enum command request;  /* command of that request. No message carries request_id or request, but
                            * an event reports each new request */
    bool unattended;       /* the loop parks because the thread that takes stop commands is held up
                            * (loop_attend()); no message carries this, but an event reports it */
    struct gains gains;    /* gains with which `out` was computed; no message carries them, but a
                            * change is an event, after which the log has a new configuration */
    int test;              /* index of the test in the list of tests; -1 outside a test */
    enum dof dof;          /* tested axis; DOF_NONE outside a test and in a test that belongs to no
                            * axis */
    enum phase phase;
    double test_time_s;    /* time from the start of the ramp-in to in.time_ns, negative while the
                            * test settles; 0 outside a test */
    int64_t wake_late_ns;  /* time from deadline to wake-up; 0 on a virtual clock */
    int64_t exec_ns;       /* time from wake-up to writing the command; 0 on a virtual clock */
};

#endif
