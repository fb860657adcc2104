/* The machine as it is: the configuration with the effects in it. First the constants, which
 * effects change; then the laws, which they add. Everything in sim is made from this. Pure after
 * machine_init, any thread, RT. */
#ifndef HEXID_MACHINE_H
#define HEXID_MACHINE_H

#include "params.h"
#include "status.h"
#include "units.h"

/* What a sensor makes of the exact value: first the lag or delay, then
 * reading = scale value + offset. */
struct sensor_path {
    double scale, offset;
    double lag_s;   /* time constant of the first order */
    double delay_s;
};

/* The lag that a cut-off frequency stands for; from 100 kHz on none. */
static inline double sensor_lag_s(double cutoff_hz) { return cutoff_hz < 1e5 ? 1.0 / (2.0 * PI * cutoff_hz) : 0.0; }

/* Effects that are on and have a certain hook, in the table's order. */
struct active {
    int count;
    struct {
        const struct effect *effect;
        const struct effect_values *values;
    } of[EFFECTS_MAX];
};

/* Constants in groups, so that a change can be looked for in one of them; the order of
 * members has no meaning. */
struct machine {
    const struct params *params;

    struct {
        double payload_kg, payload_inertia_kg_m2[3];    /* about its mass centre, along
                                                         * the axes of {M} */
        double payload_products_kg_m2[3];               /* entries xy, xz, yz of that matrix */
        double payload_center_m[3];                     /* mass centre in {M} */
        double gravity_mps2, down[3];                   /* unit vector in {B} */
        double upper_joint_m[LEGS][3], lower_joint_m[LEGS][3]; /* in {M} and {B} */
        double upper_kg[LEGS], lower_kg[LEGS];          /* of each leg: ma, mb */
        double transverse_kg_m2[LEGS];                  /* added to ib */
        double neutral_length_m[LEGS];                  /* on one axis the middle of the stroke */
        double clearance_m[LEGS];                       /* between rod and platform, along
                                                         * the leg: machine_contact */
    } bodies;
    struct {                                            /* what all valves share */
        double pressure_pa, tank_pa;
        double resistance_pa_s_per_m3, tank_resistance_pa_s_per_m3; /* of the lines */
    } supply;
    struct {
        double bulk_modulus_pa[LEGS], leakage_m3_per_s_pa[LEGS];
    } oil;
    struct {
        double frequency_hz[LEGS];
        double rate_per_s[LEGS];                        /* greatest speed of the spool,
                                                         * of full opening */
        double bias[LEGS];                              /* spool position at zero command */
        double flow_scale[LEGS], port_ratio[LEGS];      /* of both ports; port B over port A */
    } valve;
    struct {                                            /* in the cylinder */
        double distance_m[LEGS];                        /* after some five of it they slide;
                                                         * 0: at once */
        double stiffness_n_per_m[LEGS];                 /* force over distance; twice that after
                                                         * a turn */
    } seals;
    struct {                                            /* between each port and its chamber */
        double length_m[LEGS], diameter_m[LEGS];        /* length 0: none */
    } line;
    struct {
        struct sensor_path length[LEGS], p1[LEGS], p2[LEGS];
        struct sensor_path force[LEGS];                 /* of a force sensor or a drive, where
                                                         * pressures are not measured */
    } sensors;
    struct {
        double command_delay_s[LEGS];
        double clock_ratio;                             /* recorder's time over the controller's */
    } timing;

    /* Laws. */
    struct active leg_friction, joint_friction, wrench, opening, command;
};

/* params must outlive the machine. */
void machine_init(struct machine *m, const struct params *params);

/* Can there be such a machine? 0, or -2: effects have made a mass, an inertia or
 * a viscous friction less than nothing. */
int machine_check(const struct machine *m, struct error *error);

/* Sum of every effect's friction about one axis of a universal joint of this leg. */
struct friction machine_joint_friction(const struct machine *m, int leg, double speed_radps);

/* Has the leg play at its end? Never on a single axis. Then the rod hangs on the piston, and the
 * platform feels of the leg along it what machine_contact says: the force of the rod on the
 * platform, away from the base, the rod so far ahead of where it would be in a joint without play.
 * None between the flanks. Their stiffness is no steel's, but what a substep of 0.25 ms resolves:
 * the rod rings on one at 400 Hz, comes back from it at 0.43 of its speed, and is at rest after 7
 * ms. machine_ahead: where it pushes with this force, at rest. */
bool machine_has_play(const struct machine *m, int leg);
double machine_contact(const struct machine *m, int leg, double ahead_m, double ahead_mps);
double machine_ahead(const struct machine *m, int leg, double contact_n);

/* The stiffness of a flank, N/m. */
double machine_flank(const struct machine *m, int leg);

/* Sum of every effect's wrench, added. */
void machine_wrench(const struct machine *m, const double pose[DOFS], double wrench[DOFS]);

/* How far the valve is open at a spool position. */
double machine_opening(const struct machine *m, int leg, double spool);

#endif
