/* What one cycle of the loop reads, decides and writes: the values that every
 * top-level folder shares.
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
extern const char *const dof_names[DOFS + 1]; /* ended by NULL; all three lists of
                                               * names: src/core/names.c */

/* Sample flags. A sample with any of them is counted and kept out of identification. */
enum {
    SAMPLE_STALE = 1u << 0,   /* the same sample as in the cycle before: the
                               * device delivered nothing new */
    SAMPLE_LATE = 1u << 1,    /* latched longer ago than one period */
    SAMPLE_DROPPED = 1u << 2, /* samples are missing between the last one and this */
    SAMPLE_INVALID = 1u << 3, /* a value is not finite or outside its sensor's range */
    SAMPLE_OVERRUN = 1u << 4, /* the loop missed a deadline before this cycle: its
                               * command was held too long */
    SAMPLE_IO = 1u << 5,      /* the hardware abstraction layer could not read, or not
                               * write the command before */
    SAMPLE_FOREIGN = 1u << 6, /* another master commands this machine */
    SAMPLE_OPEN = 1u << 7,    /* an interlock that is needed is open */
    SAMPLE_UNWRITTEN = 1u << 8, /* beside SAMPLE_IO: the sample was read, the command
                                 * before was not written */
    SAMPLE_TWIN = 1u << 9,      /* two devices answer as one: hal_sample.twins */
    SAMPLE_FLAGS = 10,
};

/* SAFETY: what the machine says of itself, one bit each; 0 where it is open, and where
 * nothing is known. */
enum {
    INPUT_EMERGENCY_STOP = 1u << 0, /* its chain is closed */
    INPUT_ENABLE = 1u << 1,         /* the enable switch is held */
    INPUT_DOOR = 1u << 2,           /* closed */
    INPUT_SUPPLY = 1u << 3,       /* the supply is there */
    INPUTS = 4,
    INPUTS_ALL = (1u << INPUTS) - 1,
    INPUT_LINGERS = 1u << INPUTS,   /* no input: beside open ones, that the supply has
                                     * pressure although it is off */
};

/* What the hardware abstraction layer delivers: lengths and pressures latched together at one
 * instant, time_ns. */
struct hal_sample {
    int64_t time_ns;        /* device instant of latching, on the loop's clock; with SAMPLE_IO
                             * alone the instant of the read that failed */
    int64_t age_ns;         /* from latching to the read */
    uint64_t device_seq;    /* the device's own count, 0 where it has none: a gap is a lost sample,
                             * a repeat or a step back a stale one */
    uint32_t flags;         /* SAMPLE_... */
    uint32_t inputs;        /* INPUT_... */
    uint32_t contradicted;  /* INPUT_... whose two contacts contradict each other: open */
    uint32_t twins;         /* beside SAMPLE_TWIN: 1u << leg where two devices answer for one leg;
                             * 0 where they answer for the inputs, or no leg can be told */
    double length_m[LEGS];  /* joint to joint */
    double p1_pa[LEGS];     /* rodless side, gauge */
    double p2_pa[LEGS];     /* rod side, gauge */
};

/* What it is given. Valve -1..1: the spool's fraction of full opening, positive extends the leg. */
struct hal_command {
    double valve[LEGS];
    bool enable; /* false: valves centred whatever `valve` says */
    bool supply; /* SAFETY: the level of the charge pump, a life sign and no hydraulic pump: it
                  * changes every cycle; the machine's own relay keeps the supply on only so */
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

/* Latched until reset; the first one is the headline. */
enum {
    FAULT_SENSOR_AGE = 1u << 0,
    FAULT_SENSOR_INVALID = 1u << 1,
    FAULT_STROKE = 1u << 2,
    FAULT_LEG_RATE = 1u << 3,
    FAULT_FOLLOWING = 1u << 4,
    FAULT_FORCE = 1u << 5,
    FAULT_KINEMATICS = 1u << 6, /* forward kinematics found no pose for these
                                 * lengths: a leg's sensor lies */
    FAULT_OVERRUN = 1u << 7,
    FAULT_IO = 1u << 8, /* the hardware abstraction layer reports that it cannot read or write */
    FAULT_STANDSTILL = 1u << 9, /* a length does not change while its reference does: dead
                                 * transducer, valve or supply */
    FAULT_MASTER = 1u << 10,    /* another master commands this machine, or has tried to */
    FAULT_EMERGENCY_STOP = 1u << 11, /* an input is open: the chain, */
    FAULT_ENABLE = 1u << 12,         /* the enable switch, */
    FAULT_DOOR = 1u << 13,           /* the door, */
    FAULT_SUPPLY = 1u << 14,         /* the pressure switch of the supply */
    FAULT_PRESSURE_SENSOR = 1u << 15,  /* a chamber's pressure is no reading: the platform is
                                        * parked, control does without */
    FAULT_OSCILLATION = 1u << 22,      /* the platform shakes by what nobody asked for: the loop
                                        * is unstable */
    FAULT_TWIN = 1u << 23,             /* two devices answer as one */
    FAULT_ANTIVALENCE = 1u << 24,      /* the two contacts of an input contradict each other */
};

/* Beside the faults, which take bits 0..15 and 22..30: the legs that they were seen at, bits
 * 16..21; none if no leg can be told. Never in first_fault. */
enum { FAULT_LEG_SHIFT = 16, FAULT_LEGS = ((1 << LEGS) - 1) << FAULT_LEG_SHIFT, FAULT_ANY = 0x7fffffff & ~FAULT_LEGS };
static inline uint32_t fault_leg(int leg) { return 1u << (FAULT_LEG_SHIFT + leg); }

/* Value and limit that a fault had when it was latched, SI; NaN where nothing was measured or
 * there is no limit. */
struct fault_measure {
    int leg;             /* 0..5, the one that was furthest beyond its limit; -1: no leg */
    double value, limit;
};

enum command { COMMAND_NONE, COMMAND_ENGAGE, COMMAND_START, COMMAND_STOP, COMMAND_PARK, COMMAND_RESET, COMMANDS };
static inline bool command_stops(enum command command) { return command == COMMAND_STOP || command == COMMAND_PARK; }
extern const char *const command_names[COMMANDS];

/* World to loop, through a mailbox; acted on once, when id changes. */
struct request {
    uint32_t id;
    enum command command;
};

enum phase { PHASE_NONE, PHASE_SETTLE, PHASE_RAMP_IN, PHASE_EVALUATE, PHASE_RAMP_OUT };

/* Everything known about one cycle: what platform_step() returns, the ring carries, the log keeps
 * and the identifier reads. Instants: lengths and pressures of `in` were latched together at
 * in.time_ns. `out` is computed from them, takes effect at that same instant on `sim:` (a field
 * bus with SYNC: one cycle later) and is held until the next. `ref` is the reference at the
 * instant of `in`. */
struct cycle {
    uint64_t seq;
    struct hal_sample in;
    struct hal_command out;
    double ref[DOFS];
    double pose[DOFS];     /* from in.length_m by forward kinematics */
    double force_n[LEGS];  /* A1 P1 - A2 P2 */
    enum state state;
    uint32_t faults;       /* latched FAULT_... and fault_leg() */
    uint32_t first_fault;  /* the headline, 0 if none, */
    struct fault_measure measure; /* and what was measured of it; no message carries this */
    int test;              /* place in the list of tests, -1 outside */
    enum dof dof;          /* tested axis, DOF_NONE outside */
    enum phase phase;
    double test_time_s;    /* since the ramp-in's start (negative while settling), latching
                            * instant; 0 outside a test */
    int64_t wake_late_ns;  /* deadline to wake-up; 0 on a virtual clock */
    int64_t exec_ns;       /* wake-up to the command's write; 0 on a virtual clock */
};

#endif
