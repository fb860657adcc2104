/* The whole configuration as plain data in SI units, written once by src/io/config.c and constant
 * afterwards. Every key of the YAML file is one member here. Ranges and descriptions stand in the
 * table of src/io/config_keys.c, from which --print-config and docs/configuration.md are made. */
#ifndef HEXID_PARAMS_H
#define HEXID_PARAMS_H

#include "effect.h"
#include "types.h"

enum { PARAMS_TEXT_SIZE = 256 };  /* size of every text in the configuration */

enum mechanism_kind { MECHANISM_STEWART, MECHANISM_AXIS };

/* One vector for each leg, in the coordinates of the drawing. */
struct leg_vectors {
    bool given;
    double leg[LEGS][3];
};

struct geometry_params {          /* geometry of the legs' joints, Tian 2015 Table 1 */
    double upper_radius_m;        /* radius of the circle of the upper joints, Ra */
    double lower_radius_m;        /* radius of the circle of the lower joints, Rb */
    double height_m;              /* H: upper joint plane (z = 0 in the platform's drawing) above
                                   * the lower one (z = 0 in the base's), at neutral */
    double upper_half_angle_rad;  /* half the angle between the two upper joints of a pair, alpha */
    double lower_half_angle_rad;  /* half the angle between the two lower joints of a pair, beta */
    /* The coordinates below are those of the drawings of platform and base: x forward, y right, z
     * down. */
    struct leg_vectors upper, lower; /* positions of the joints, m; if not given, they are on a
                                      * circle, by the radii and angles above */
    struct leg_vectors upper_axis, lower_axis; /* first axis of each universal joint, fixed in
                                                * platform or base, of any length; if not given, it
                                                * is level, tangential to the joint circle */
};

struct payload_params {           /* the platform with its load, Tian 2015 Table 2 */
    double mass_kg;
    /* entries of the payload's inertia matrix about its mass centre */
    double inertia_xx_kg_m2, inertia_yy_kg_m2, inertia_zz_kg_m2;
    double inertia_xy_kg_m2, inertia_xz_kg_m2, inertia_yz_kg_m2;
    double center_height_m;       /* h: mass centre above the upper joint plane */
    double center_x_m, center_y_m;/* mass centre in the platform's drawing */
    double gravity_mps2;
};

struct axis_params {              /* cylinder or electric axis with a mass, which is leg 1; there is
                                   * no other leg */
    double mass_kg;               /* mass of all moving parts */
    double gravity_mps2;          /* component of gravity along the axis; positive: the weight
                                   * pushes the rod in */
    double middle_m;              /* position reading at mid-stroke */
    double force_offset_n;    /* constant error of the force reading; positive: it reads too much */
    double force_lag_s;     /* time constant of the first-order lag of a force sensor's amplifier */
};

struct actuator_params {          /* the legs, Tian 2015 Tables 1 and 2; inertias about each part's
                                   * own mass centre (docs/method.md, 3) */
    double piston_diameter_m[LEGS], rod_diameter_m[LEGS];
    struct {
        bool piston, rod;
    } stated;                     /* false if an axis's configuration leaves the diameter out,
                                   * because the built-in platform's does not suit an axis */
    double stroke_m[LEGS];
    double mid_stroke_m[LEGS];    /* leg length at mid-stroke less leg length at neutral */
    double upper_mass_kg[LEGS], lower_mass_kg[LEGS];      /* masses of rod (ma) and cylinder (mb) */
    double upper_inertia_kg_m2[LEGS], lower_inertia_kg_m2[LEGS]; /* transverse moments of inertia of
                                                                  * rod (ia) and cylinder (ib) */
    /* distance of the rod's mass centre from the upper joint (ra), and of the cylinder's from the
     * lower joint (rb) */
    double upper_center_m[LEGS], lower_center_m[LEGS];
};

struct hydraulics_params {
    double supply_pa, tank_pa;
    double valve_flow_m3_per_s[LEGS]; /* flow through each port at full opening and a pressure drop
                                       * of valve_drop_pa */
    double valve_drop_pa;
    double valve_frequency_hz, valve_damping[LEGS];
    double bulk_modulus_pa[LEGS];
    double dead_volume_m3[LEGS];      /* dead volume of each side at its end of the stroke */
    double dead_volume_difference_m3[LEGS]; /* dead volume of the rod side less dead_volume_m3 */
    double leakage_m3_per_s_pa[LEGS]; /* leakage across the piston */
    double viscous_n_s_per_m[LEGS];   /* viscous friction of the base model; the effect
                                       * cylinder_viscous_friction adds to it */
    double stop_stiffness_n_per_m, stop_damping_n_s_per_m; /* stiffness and damping of the end stops
                                                            * of the stroke */
};

struct sensor_params {            /* sensors of the simulated machine */
    bool enabled;                 /* false: the sensors give exact values */
    double position_resolution_m;
    double adc_bits, adc_range_v; /* bits of the converter over its range, -adc_range_v to
                                   * adc_range_v */
    double pressure_full_scale_pa;/* pressure at which the sensor gives adc_range_v */
    double pressure_noise_v;      /* noise of the pressure reading, uniform, peak to peak */
};

enum engine_kind { ENGINE_ODE, ENGINE_CLOSED_FORM };

struct sim_params {
    enum engine_kind engine;
    int substeps;                 /* integration steps per cycle; one is at most 0.25 ms long */
    double base_hz, base_mass_kg; /* the base on its springs (sim/surroundings.h); 0 Hz: the base is
                                   * rigid */
    double ripple_pa, ripple_hz;  /* amplitude and frequency of the pump's pressure ripple */
    double smooth_friction_mps;   /* 0: true stick; otherwise dry friction of the cylinders is F
                                   * tanh(v / this), as in models without stick */
};

struct control_params {           /* gains of the controller; src/core/pid.h has the exact law */
    double kp, ki, kd;            /* gains of the proportional, the integral and the derivative
                                   * part: 1/m, 1/(m s), s/m */
    double kff;                   /* gain of the reference's leg rate, s/m */
    double kpf;                   /* gain of the high-passed leg force, 1/N */
    double tf, tp;                /* time constants of the filters of derivative and force, s */
    double integral_limit;        /* largest integral part, as a share of full opening */
    double output_limit;          /* largest output, as a share of full opening */
};

struct motion_params {
    double engage_s, park_s;      /* durations of the moves up and down; longer if rate_mps or
                                   * accel_mps2 require it */
    double rate_mps, accel_mps2;  /* largest speed and acceleration in a move: of the origin, or of
                                   * the upper joints in a turn */
    double park_z_m;              /* pose z at which the platform is put down; z points down */
    double hold_s;                /* waiting time at neutral before the first test */
    bool automatic;               /* engages, tests and parks without commands */
};

struct limit_params {     /* SAFETY: beyond any of these limits the supervisor centres the valves */
    double length_min_m[LEGS], length_max_m[LEGS];
    double leg_rate_mps;
    double following_m;           /* largest |leg reference - leg length| while engaged */
    double standstill_m;          /* greatest range of a leg's reference during which its length may
                                   * stay unchanged while engaged */
    double force_n;               /* largest |A1 P1 - A2 P2| of a leg */
    double sensor_age_s;
    double pressure_min_pa, pressure_max_pa; /* range of plausible pressure readings */
    int bad_cycles;        /* leaky bucket: bad cycles less good ones at which a fault is latched */
    double blind_time_s;          /* upper limit of the result of blind_time() */
    double oscillation_mps2;      /* acceleration of the platform beyond 1.8 times what is asked
                                   * for: src/core/oscillation.h */
};

struct interlock_params {         /* SAFETY: wired inputs and outputs of the machine; others are not
                                   * watched */
    bool emergency_stop, enable, door, pressure;
    bool supply;                  /* the output that keeps the supply on */
    double pressure_s;            /* longest time until the input `pressure` closes; if it is not
                                   * wired, the waiting time itself */
    bool antivalent;              /* each input has two contacts, one inverse (interlock.h) */
    double discrepancy_s;    /* longest time for which the two contacts may contradict each other */
};

struct test_params {
    enum dof order[DOFS];         /* axes to test, in this order */
    int count;
    double hz[DOFS];              /* frequency of each axis's sinusoid */
    double amplitude[DOFS];       /* amplitude of each axis's sinusoid, m or rad */
    double settle_s, ramp_s, duration_s, ramp_out_s; /* durations of a test's parts; duration_s is
                                                      * the evaluated one */
    int harmonics;                /* number of harmonics regressed with the fundamental */
    bool multisine;               /* moves all axes of `order` at once, in one test */
    char trajectory[PARAMS_TEXT_SIZE]; /* file of poses over time, which takes the
                                        * sinusoids' place; "": none */
    int repeat;                   /* number of passes of the trajectory */
};

/* True if axes are tested one after another, each with a sinusoid, as methods A and B need.
 * Otherwise the run is one test of no axis. */
static inline bool tests_single(const struct test_params *t) { return !t->multisine && !t->trajectory[0]; }
static inline int tests_count(const struct test_params *t) { return tests_single(t) ? t->count : 1; }
static inline const char *tests_name(const struct test_params *t, enum dof dof) {
    return dof != DOF_NONE ? dof_names[dof] : t->trajectory[0] ? "trajectory" : t->multisine ? "multisine" : "none";
}

struct check_params { /* limits in percent unless a unit is named; a run beyond any of them fails */
    double amplitude_pct; /* difference between achieved and commanded amplitude, as a share of the
                           * commanded one */
    double unwanted_pct;         /* motion of another axis in a test, as a share of that axis's own
                                  * test amplitude */
    double overruns_pct;          /* share of the cycles in which the loop was late */
    double excluded_pct;          /* share of the evaluated samples that are excluded */
    double length_wander_m;       /* change of a leg length's fundamental between test periods */
    double force_wander_n;        /* change of a leg force's mean and fundamental from period to
                                   * period; of the mean also from test to test */
    double period_s;             /* longest loop.period_s; a longer one puts the command's staircase
                                  * into the matrix */
    double symmetry_pct;       /* |Mt - Mt'| divided by the root of the product of the diagonal
                                * entries */
};

struct tolerance_params {         /* tolerances of the model's parameters that hexid gap does not
                                   * count as a finding; relative, but for joints and springs */
    double mass;                  /* tolerance of every mass and inertia */
    double viscous, bulk_modulus, leakage, valve_gain;
    double joints_m;              /* tolerance of each coordinate of a joint */
    double springs_n_per_m, springs_nm_per_rad; /* stiffness of hoses and cables, on x, y, z and on
                                                 * the angles */
};

struct model_params {
    struct tolerance_params tolerance;
};

struct loop_params {
    double period_s;
    int priority;                 /* priority of the loop's thread under SCHED_FIFO */
    int cpu;                      /* processor for the loop's thread; -1: any */
    int overrun_limit;            /* number of missed deadlines in a row that is a fault */
};

struct security_params {
    bool confine;                 /* limits the daemon's rights in the system (src/rt/confine.h) */
};

struct machine_params {
    char name[PARAMS_TEXT_SIZE]; /* name on the bus (machine.h); "": the first of hexid, hexid-2,
                                  * ... that is free */
};

struct lcm_params {
    char url[PARAMS_TEXT_SIZE];   /* URL of the LCM bus; "": none. A udpm URL with ttl 0 stays on
                                   * this host */
    int state_every;      /* number of cycles from one HEXID_STATE message on the bus to the next */
    bool commands;                /* SAFETY: accept commands that move; stop and
                                   * park are always accepted */
    double lease_s;               /* SAFETY: longest time between messages of an operator who
                                   * engaged or started by command, after which the platform is
                                   * parked; 0: there is no such limit */
    char remote_stop[PARAMS_TEXT_SIZE]; /* addresses of other hosts whose stop and park are
                                         * accepted; "": none */
};

/* A kind of channel between the field and hexid, leg by leg: si = si_min + (raw - raw_min) /
 * (raw_max - raw_min) (si_max - si_min) + offset. Readings outside low..high (SI, offset included)
 * are implausible. A 4-20 mA or 0-10 V sensor behind a node only has other numbers. */
struct channel_params {
    double raw_min[LEGS], raw_max[LEGS]; /* raw values on the bus at si_min and at si_max */
    double si_min[LEGS], si_max[LEGS];
    double offset[LEGS];
    double low[LEGS], high[LEGS];
};

struct device_params {            /* settings of devices in the field; the daemon sends them if the
                                   * bus allows */
    double watchdog_s;           /* time without a command after which a device centres its valve */
};

struct can_params {
    double bitrate_bps;
    double heartbeat_s;           /* period of the heartbeats of every node and of the daemon; three
                                   * missing in a row mean that the sender is lost */
    /* Identity that the nodes below must report (0x1000, 0x1018:1, :2), rounded; -1: any. */
    double device_type, vendor_id, product_code;          /* identity of axis nodes */
    double io_device_type, io_vendor_id, io_product_code; /* identity of node 7, inputs and
                                                           * outputs */
};

struct modbus_params {
    int unit;                     /* slave address of the device */
};

struct params {
    enum mechanism_kind mechanism;
    struct geometry_params geometry;
    struct payload_params payload;
    struct axis_params axis;
    struct actuator_params actuator;
    struct hydraulics_params hydraulics;
    struct sensor_params sensors;
    struct sim_params sim;
    struct control_params control;
    struct motion_params motion;
    struct limit_params limits;
    struct interlock_params interlocks;
    struct test_params tests;
    struct check_params checks;
    struct model_params model;
    struct loop_params loop;
    struct security_params security;
    struct machine_params machine;
    struct lcm_params lcm;
    struct channel_params length_channel, p1_channel, p2_channel, valve_channel;
    struct device_params device;
    struct can_params can;
    struct modbus_params modbus;
    struct effect_values effects[EFFECTS_MAX]; /* values of all effects, in the order of
                                                * effect_table */
};

static inline int params_legs(const struct params *p) { return p->mechanism == MECHANISM_AXIS ? 1 : LEGS; }

#endif
