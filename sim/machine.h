/* The actual machine: the configuration with its effects. Effects change the constants, which come
 * first, and add the laws, which come last. All other files of sim/ take constants and laws from
 * here. Pure after machine_init(), any thread, RT. */
#ifndef HEXID_MACHINE_H
#define HEXID_MACHINE_H

#include "effect.h"
#include "status.h"
#include "units.h"

struct params;
struct sensor_errors;

/* Path from the exact value to a sensor's reading: a lag, then a delay, then reading = scale value
 * + offset. */
struct sensor_path {
    double scale, offset;
    double lag_s;   /* time constant of a first-order lag */
    double delay_s;
};

/* Returns the time constant of a lag with this cut-off frequency; 0 from 100 kHz on. */
static inline double sensor_lag_s(double cutoff_hz) { return cutoff_hz < 1e5 ? 1.0 / (2.0 * PI * cutoff_hz) : 0.0; }

/* Effects that are on and have a certain hook, in the order of effect_table. */
struct active {
    int count;
    struct {
        const struct effect *effect;
        const struct effect_values *values;
    } of[EFFECTS_MAX];
};

/* Constants, grouped by subject; the order of members has no meaning. */
struct machine {
    const struct params *params;

    struct {
        double payload_kg, payload_inertia_kg_m2[3];    /* entries xx, yy, zz of the payload's
                                                         * inertia matrix about its mass centre,
                                                         * along the axes of {M} */
        double payload_products_kg_m2[3];   /* entries xy, xz, yz of the payload's inertia matrix */
        double payload_center_m[3];                     /* payload's mass centre in {M} */
        double gravity_mps2, down[3];                   /* gravity_mps2: acceleration of gravity;
                                                         * down: its direction, a unit vector in
                                                         * {B} */
        double upper_joint_m[LEGS][3], lower_joint_m[LEGS][3]; /* joints, in {M} and in {B} */
        double upper_kg[LEGS], lower_kg[LEGS]; /* masses of each leg's rod (ma) and cylinder (mb) */
        double transverse_kg_m2[LEGS];                  /* transverse inertia that effects add to
                                                         * that of the cylinder, ib */
        double neutral_length_m[LEGS], middle_length_m[LEGS]; /* leg lengths at neutral, and in the
                                                               * middle of the stroke */
        double clearance_m[LEGS];                       /* backlash between rod and platform, along
                                                         * the leg (machine_contact) */
    } bodies;
    struct {                          /* pressures and hoses of the mains, which all valves share */
        double pressure_pa, tank_pa;
        double resistance_pa_s_per_m3, tank_resistance_pa_s_per_m3; /* flow resistances of the
                                                                     * supply hose and of the tank
                                                                     * hose */
    } supply;
    struct {
        double bulk_modulus_pa[LEGS], leakage_m3_per_s_pa[LEGS];
    } oil;
    struct {
        double frequency_hz[LEGS];
        double rate_per_s[LEGS];      /* greatest speed of the spool, in full openings per second;
                                       * infinity: no limit */
        double bias[LEGS];                              /* position of the spool at zero command */
        double flow_scale[LEGS], port_ratio[LEGS];      /* scale of the flow through both ports;
                                                         * flow gain of port B divided by that of
                                                         * port A */
    } valve;
    struct {                                            /* seals of the cylinder */
        double distance_m[LEGS];                        /* path over which the seals deflect; after
                                                         * about five times this path they slide; 0:
                                                         * they slide at once */
        double stiffness_n_per_m[LEGS];                 /* the seals' friction force divided by that
                                                         * path; after a reversal the seals are
                                                         * twice as stiff as this */
    } seals;
    struct {                                            /* hoses between valve ports and chambers */
        double length_m[LEGS], diameter_m[LEGS];        /* length and bore of the hoses; length 0:
                                                         * there is no hose */
    } hose;
    struct {
        struct sensor_path length[LEGS], p1[LEGS], p2[LEGS];
        struct sensor_path force[LEGS];                 /* reading of a force sensor or a drive,
                                                         * where no pressures are measured */
    } sensors;
    struct {
        double command_delay_s[LEGS];
        double clock_ratio;                             /* speed of the recorder's clock divided by
                                                         * that of the controller's */
    } timing;

    /* Effects that add laws. */
    struct active leg_friction, joint_friction, wrench, opening, command;
};

/* Prepares a machine; params must outlive it. */
void machine_init(struct machine *m, const struct params *params);

/* Adds systematic errors to the paths of the sensors; machine_init() has added those of params.
 * Readings without a delay belong to the instant of the commands: a positive skew delays the
 * lengths, a negative skew the pressures and forces. So the residuals have a kink where the skew
 * changes its sign. Pipes do not change the paths: a simulation has their volume (cylinder.c), but
 * not their inertia. */
void machine_add_errors(struct machine *m, const struct sensor_errors *errors);

/* Checks that the machine can exist. Returns -2 if the payload has no mass or no positive definite
 * inertia, or if effects make a leg's mass, inertia or viscous friction negative; otherwise 0. */
int machine_check(const struct machine *m, struct error *error);

/* Returns the sum of all effects' friction about one axis of a universal joint of this leg. */
struct friction machine_joint_friction(const struct machine *m, int leg, double speed_radps);

/* machine_has_play() returns true if the leg has backlash at the rod's end; a single axis never
 * has. The rod of such a leg moves with the piston, and the platform feels only the contact force
 * that machine_contact() returns: the force of the rod on the platform along the leg, positive away
 * from the base. ahead_m: distance of the rod from its place in a joint without backlash, positive
 * away from the base. Between the flanks of the joint the force is zero. The flanks are softer than
 * steel, so that a substep of 0.25 ms resolves them: a rod oscillates on a flank at 400 Hz,
 * rebounds with 0.43 of its speed and rests after 7 ms. machine_ahead() returns the ahead_m of a
 * rod at rest under this contact force. */
bool machine_has_play(const struct machine *m, int leg);
double machine_contact(const struct machine *m, int leg, double ahead_m, double ahead_mps);
double machine_ahead(const struct machine *m, int leg, double contact_n);

/* Returns the stiffness of the flank of a joint with backlash, against which the rod's end rests,
 * N/m. */
double machine_flank(const struct machine *m, int leg);

/* Adds the wrenches of all effects on the platform, about the origin of {M}, in {B}. */
void machine_wrench(const struct machine *m, const double pose[DOFS], double wrench[DOFS]);

/* Returns the opening of the valve at a spool position, both -1..1. */
double machine_opening(const struct machine *m, int leg, double spool);

#endif
