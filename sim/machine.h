/* The actual machine: the configuration with its effects. First come the constants, which effects
 * change, then the laws, which they add. Every other part of sim takes its constants and laws from
 * here. Pure after machine_init, any thread, RT. */
#ifndef HEXID_MACHINE_H
#define HEXID_MACHINE_H

#include "effect.h"
#include "status.h"
#include "units.h"

struct params;
struct sensor_errors;

/* A sensor's path from the exact value: lag, then delay, then reading = scale value + offset. */
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
        double gravity_mps2, down[3];                   /* acceleration of gravity; its direction is
                                                         * the unit vector `down` in {B} */
        double upper_joint_m[LEGS][3], lower_joint_m[LEGS][3]; /* joints, in {M} and in {B} */
        double upper_kg[LEGS], lower_kg[LEGS]; /* masses of each leg's rod (ma) and cylinder (mb) */
        double transverse_kg_m2[LEGS];                  /* inertia that effects add to the
                                                         * cylinder's inertia ib */
        double neutral_length_m[LEGS], middle_length_m[LEGS]; /* leg lengths at neutral, and in the
                                                               * middle of the stroke */
        double clearance_m[LEGS];                       /* backlash between rod and platform, along
                                                         * the leg (machine_contact) */
    } bodies;
    struct {                          /* pressures and hoses of the mains, which all valves share */
        double pressure_pa, tank_pa;
        double resistance_pa_s_per_m3, tank_resistance_pa_s_per_m3; /* flow resistances of the
                                                                     * mains' hoses */
    } supply;
    struct {
        double bulk_modulus_pa[LEGS], leakage_m3_per_s_pa[LEGS];
    } oil;
    struct {
        double frequency_hz[LEGS];
        double rate_per_s[LEGS];      /* greatest speed of the spool, in full openings per second;
                                       * infinity: no limit */
        double bias[LEGS];                              /* position of the spool at zero command */
        double flow_scale[LEGS], port_ratio[LEGS];      /* scale of both ports' flow; flow gain of
                                                         * port B divided by that of port A */
    } valve;
    struct {                                            /* seals of the cylinder */
        double distance_m[LEGS];                        /* path over which the seals deflect: after
                                                         * about five times this they slide; 0: they
                                                         * slide at once */
        double stiffness_n_per_m[LEGS];                 /* the seals' force divided by the path;
                                                         * after a reversal they are twice as
                                                         * stiff */
    } seals;
    struct {                                            /* hoses between valve ports and chambers */
        double length_m[LEGS], diameter_m[LEGS];        /* dimensions of the hoses; length 0: there
                                                         * is none */
    } hose;
    struct {
        struct sensor_path length[LEGS], p1[LEGS], p2[LEGS];
        struct sensor_path force[LEGS];                 /* force sensor or drive, if pressures are
                                                         * not measured */
    } sensors;
    struct {
        double command_delay_s[LEGS];
        double clock_ratio;                             /* recorder's time divided by the
                                                         * controller's */
    } timing;

    /* Effects that add laws. */
    struct active leg_friction, joint_friction, wrench, opening, command;
};

/* Prepares a machine; params must outlive it. */
void machine_init(struct machine *m, const struct params *params);

/* Adds systematic errors to the paths of the sensors; machine_init() adds those of params. A
 * positive skew delays the lengths, a negative one the pressures and forces; readings that are not
 * delayed belong to the instant of the commands. So the residuals have a kink where the skew
 * changes its sign. Pipes do not change the paths: a simulation has their volume (cylinder.c), but
 * not their inertia. */
void machine_add_errors(struct machine *m, const struct sensor_errors *errors);

/* Checks that the machine can exist. Returns 0, or -2 if not: the payload has no mass or no
 * positive definite inertia, or effects make a leg's mass, inertia or viscous friction negative. */
int machine_check(const struct machine *m, struct error *error);

/* Returns the sum of all effects' friction about one axis of a universal joint of this leg. */
struct friction machine_joint_friction(const struct machine *m, int leg, double speed_radps);

/* machine_has_play: true if the leg has backlash at its end; never on a single axis. The rod of
 * such a leg moves with the piston, and the platform feels only the contact force that
 * machine_contact returns: force of the rod on the platform along the leg, positive away from the
 * base. ahead_m: distance of the rod ahead of its place in a joint without backlash. The force is
 * zero between the flanks. The flanks are softer than steel, so that a substep of 0.25 ms resolves
 * them: a rod oscillates on one at 400 Hz, rebounds with 0.43 of its speed and rests after 7 ms.
 * machine_ahead: distance ahead_m of a rod at rest under this contact force. */
bool machine_has_play(const struct machine *m, int leg);
double machine_contact(const struct machine *m, int leg, double ahead_m, double ahead_mps);
double machine_ahead(const struct machine *m, int leg, double contact_n);

/* Stiffness of a backlash joint's flank, against which the rod end rests, N/m. */
double machine_flank(const struct machine *m, int leg);

/* Adds the wrenches of all effects on the platform, about the origin of {M}, in {B}. */
void machine_wrench(const struct machine *m, const double pose[DOFS], double wrench[DOFS]);

/* Returns the opening of the valve at a spool position, both -1..1. */
double machine_opening(const struct machine *m, int leg, double spool);

#endif
