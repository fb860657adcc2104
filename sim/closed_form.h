/* Rigid bodies and hydraulics as one system of first-order equations, with friction, and its RK4
 * step. Smooth over a step as long as no coordinate with dry friction turns round: that is the
 * engine's part (engine_closed_form.c). RT. */
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

/* Of the legs with play the rods, bodies of their own. */
struct rods {
    double length_m[LEGS], rate_mps[LEGS]; /* of the leg up to the rod's end */
};

union system {
    struct {
        struct rigid_state body;
        struct hydraulics_state hydraulics;
        struct rods rods;
    };
    double value[(sizeof(struct rigid_state) + sizeof(struct hydraulics_state) + sizeof(struct rods)) / sizeof(double)];
};

/* Values of a state whose hydraulics are not extended; and of one without play. */
enum {
    CLOSED_FORM_PLAIN = (sizeof(struct rigid_state) + LEGS * sizeof(struct cylinder_state)) / sizeof(double),
    CLOSED_FORM_NO_PLAY = (sizeof(struct rigid_state) + sizeof(struct hydraulics_state)) / sizeof(double)
};

/* What moves the legs over a step: valve commands, or these forces instead of hydraulics. The
 * other one is NULL. */
struct drive {
    const double *valve, *force_n;
};

struct closed_form {
    struct engine base;
    struct cylinder_model cylinder;
    int values;                      /* of the state that are in use */
    struct rigid_model rigid;
    bool joints;                     /* there is joint friction */
    bool play, rods_stick;           /* some leg has play; and dry friction can hold its rod */
    enum {
        SLIDES,
        STICKS,                      /* dry friction can hold it */
        ROD_STICKS                   /* and of a leg with play the rod, not the platform */
    } kind[COORDINATES];
    int stick[COORDINATES], sticks;  /* those that STICKS, and how many */
    union system state;
    int direction[COORDINATES];      /* of what can stick: +1, -1 sliding, over a whole step;
                                      * 0 held */
    double holding[COORDINATES];     /* force that holds them */
    double rate[COORDINATES];        /* in this state */
    bool forced;                     /* the last step was one without hydraulics */
};

/* The machine at one instant. */
struct instant {
    struct rigid_legs legs;
    struct joint_axes axes;          /* only with joint friction */
    double friction_n[LEGS];               /* on the rod: dry and viscous, */
    double passive_n[LEGS];                /* of end stops and deflected seals */
    double length_m[LEGS], rate_mps[LEGS]; /* up to the rod's end */
    double rod_n[LEGS];              /* of a rod with play: all forces along it but friction */
    struct factor6 mass;             /* its Cholesky factor */
    double free[DOFS];               /* whitened acceleration (stick.h) without
                                      * the friction that holds */
};

void closed_form_look(const struct closed_form *e, const union system *s, const struct drive *drive, struct instant *now);

/* Row of a coordinate and what its rate changes by when the platform does not accelerate. */
void closed_form_row(const struct instant *now, int k, double row[DOFS], double *bias);

/* Rates of the coordinates that dry friction can hold; the others stay. */
void closed_form_rates(const struct closed_form *e, const union system *s, double rate[COORDINATES]);

bool closed_form_held(const struct closed_form *e, int k);
void closed_form_basis(const struct closed_form *e, const struct instant *now, struct stick_basis *basis);

/* from and to may be the same. What is held stays held, what slides keeps its direction. */
void closed_form_rk4(const struct closed_form *e, const union system *from, double h, const struct drive *drive, union system *to);

#endif
