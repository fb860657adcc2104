/* The oil columns: how stiff each leg is with its ports shut, from a survey's data, and what the
 * platform's inertia and these springs make of it.
 *
 * Each chamber, ports and piston (v the leg's rate, x the valve's opening, a delay
 * after the command):
 *
 *   P1' = -c1 v + g1 q1 - a1 P1 + b1 P2,   q1 =  x+ sqrt(ps - P1) + x- sqrt(P1 - pt)
 *   P2' =  c2 v + g2 q2 - a2 P2 + b2 P1,   q2 = -x+ sqrt(P2 - pt) - x- sqrt(ps - P2)
 *
 * with x+ = max(x, 0) and x- = min(x, 0), in the steady state of a periodic motion: the complex
 * amplitudes of its lines, for which a derivative is a product with i w. The root law of two edges
 * takes the measured pressures, so that a command which crosses zero is no error; of the
 * configuration only the piston's areas and supply and tank pressure are used. Least squares for c,
 * g, a, b of each chamber, weighted by the sensors' noise and 2 % of the piston's flow, and over
 * the delay of both. Stiffness: k = A1 c1 + A2 c2 (= E (A1^2/V1 + A2^2/V2), lines between valve and
 * chamber counted in).
 *
 * Rigid eigenfrequencies at neutral: Mt xddot + J' diag(k) J x = 0. Ordinary threads; heap. */
#ifndef HEXID_OIL_COLUMNS_H
#define HEXID_OIL_COLUMNS_H

#include "multisine.h"

struct oil_chamber {
    double push, push_std;  /* c, Pa/m */
    double gain, own, other;/* g, sqrt(Pa)/s; a and b, 1/s */
    double open, sag;       /* at the mean command and pressures: change of P' with the opening,
                             * Pa/s, and its fall with P, a included, 1/s */
};

struct oil_leg {
    struct oil_chamber chamber[2];
    double delay_s;         /* of the spool, and half a cycle of holding, from the sample that the
                             * command was computed from */
    double stiffness, stiffness_std; /* N/m; std NaN and stiffness NaN: not determined */
    double misfit;          /* rms of what the lines leave, in units of the weights */
};

/* A stiffness whose deviation is above a twentieth, whose delay is beyond 12 ms or whose misfit is
 * above 2 is not determined. -3: memory. */
int oil_columns_find(const struct multisine_mean *mean, const struct params *params, struct oil_leg leg[LEGS], struct error *error);

struct oil_mode {
    double hz, hz_std;      /* NaN: not determined */
    double shape[DOFS];     /* m, rad; largest axis (an angle counted at the upper joints' radius)
                             * 1 */
    double motion[LEGS];    /* of the legs in that shape, m */
    double mass_kg;         /* for the square of the legs' motion: shape' Mt shape / sum of
                             * motion^2 */
    enum dof dof;           /* the largest axis */
};

/* Ascending. False, and all NaN, where an entry of Mt or a stiffness is not determined or
 * Mt is no inertia. */
bool oil_columns_modes(const struct oil_leg leg[LEGS], const struct params *params, double mt[DOFS][DOFS], double mt_std[DOFS][DOFS],
                       struct oil_mode mode[DOFS]);

#endif
