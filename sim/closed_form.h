/* Rigid bodies, hydraulics and friction as one system of first-order equations, and its RK4 step.
 * The equations are smooth over a step unless a coordinate with dry friction reverses; the engine
 * (engine_closed_form.c) handles reversals. RT. */
#ifndef HEXID_CLOSED_FORM_H
#define HEXID_CLOSED_FORM_H

#include "engine.h"
#include "hydraulics.h"
#include "joint_axes.h"
#include "rigid.h"
#include "stick.h"
#include "vec.h"

/* Coordinates with friction: the legs, then the axes of the universal joints. */
enum { COORDINATES = LEGS + JOINT_AXES };

/* Rods of the legs with backlash; these rods are bodies of their own. */
struct rods {
    double length_m[LEGS], rate_mps[LEGS]; /* length of each leg up to the rod's end, and the rate
                                            * of this length */
};

union system {
    struct {
        struct rigid_state body;
        struct hydraulics_state hydraulics;
        struct rods rods;
    };
    double value[(sizeof(struct rigid_state) + sizeof(struct hydraulics_state) + sizeof(struct rods)) / sizeof(double)];
};

/* Number of used values of `system`: without extended hydraulics and backlash, and without
 * backlash. */
enum {
    CLOSED_FORM_PLAIN = (sizeof(struct rigid_state) + LEGS * sizeof(struct cylinder_state)) / sizeof(double),
    CLOSED_FORM_NO_PLAY = (sizeof(struct rigid_state) + sizeof(struct hydraulics_state)) / sizeof(double)
};

/* Drive of the legs over a step: either valve commands, or forces that replace the hydraulics. The
 * other pointer is NULL. */
struct drive {
    const double *valve, *force_n;
};

struct closed_form {
    struct engine base;
    struct cylinder_model cylinder;
    int values;                      /* number of values of `state` that are used */
    struct rigid_model rigid;
    bool joints;                     /* the machine has joint friction */
    bool play, rods_stick;           /* play: some leg has backlash; rods_stick: dry friction can
                                      * hold the rod of such a leg */
    enum {
        SLIDES,
        STICKS,                      /* dry friction can hold the coordinate */
        ROD_STICKS                /* dry friction can hold the rod of a leg with backlash */
    } kind[COORDINATES];
    int stick[COORDINATES], sticks;  /* list of the coordinates of kind STICKS, and its length */
    union system state;
    int direction[COORDINATES];      /* direction of sliding, constant over a step: +1 or -1; 0: the
                                      * coordinate is held */
    double holding[COORDINATES];     /* friction that holds each held coordinate, N or N m */
    double rate[COORDINATES];        /* rates of the coordinates of kind STICKS at `state` */
    bool forced;       /* in the last step given forces replaced the hydraulics */
};

/* Everything that follows from the machine's state at one instant. */
struct instant {
    struct rigid_legs legs;
    struct joint_axes axes;          /* set only with joint friction */
    double friction_n[LEGS];               /* friction on the rod; without its viscous part if
                                            * forces are given; 0 if the leg is held */
    double passive_n[LEGS];                /* force of end stops and deflected seals on the rod */
    double length_m[LEGS], rate_mps[LEGS]; /* length and rate of each leg up to the rod's end */
    double rod_n[LEGS];       /* sum of the axial forces on a rod with backlash, without friction */
    struct factor6 mass;             /* Cholesky factor of the mass matrix */
    double free[DOFS];               /* whitened acceleration (stick.h) without the friction that
                                      * holds coordinates */
};

/* Computes `now` from a state. */
void closed_form_look(const struct closed_form *e, const union system *s, const struct drive *drive, struct instant *now);

/* Finds a coordinate's row (rate = row . twist), and in *bias its acceleration while the twist is
 * constant. */
void closed_form_row(const struct instant *now, int k, double row[DOFS], double *bias);

/* Finds the rates of the coordinates of kind STICKS; other elements stay unset. */
void closed_form_rates(const struct closed_form *e, const union system *s, double rate[COORDINATES]);

bool closed_form_held(const struct closed_form *e, int k);

/* Finds the basis of the held coordinates' whitened rows (stick.h). */
void closed_form_basis(const struct closed_form *e, const struct instant *now, struct stick_basis *basis);

/* Makes one RK4 step of length h; `from` and `to` may be the same. Held coordinates stay held, the
 * others keep their direction. */
void closed_form_rk4(const struct closed_form *e, const union system *from, double h, const struct drive *drive, union system *to);

#endif
