/* The oil columns: the stiffness of each leg with its ports shut, found in a survey's data, and the
 * eigenfrequencies that this stiffness and the platform's inertia have.
 *
 * The pressures of the two chambers obey, with v the leg's rate and x the valve's opening, which is
 * the delayed command:
 *
 *   P1' = -c1 v + g1 q1 - a1 P1 + b1 P2,   q1 =  x+ sqrt(ps - P1) + x- sqrt(P1 - pt)
 *   P2' =  c2 v + g2 q2 - a2 P2 + b2 P1,   q2 = -x+ sqrt(P2 - pt) - x- sqrt(ps - P2)
 *
 * with x+ = max(x, 0) and x- = min(x, 0). In the steady state of a periodic motion the equations
 * hold for the complex amplitudes of its tones, a derivative being a factor i w. q1 and q2 are
 * computed from the measured pressures, so a command that crosses zero makes no error. From the
 * configuration only the piston's areas and the supply and tank pressure are used. Least squares
 * finds c, g, a, b of each chamber, a null of each chamber (the valve's opening without a command;
 * prior 0 +- 2 %), and one delay for both. Its weights follow from the sensors' noise and the error
 * of the square-root law. This error is a share of the piston's flow: 2 % while the delay is looked
 * for, then as the residuals show, at most 2 %. Stiffness: k = A1 c1 + A2 c2 (= E (A1^2/V1 +
 * A2^2/V2), volumes with the hoses between valve and chamber). The leakage driven by the difference
 * of the pressures is (a + b) A / (2 c); if all leakage is across the piston, a = b.
 *
 * Rigid eigenfrequencies at neutral: Mt xddot + J' diag(k) J x = 0. Ordinary threads; heap. */
#ifndef HEXID_OIL_COLUMNS_H
#define HEXID_OIL_COLUMNS_H

#include "multisine.h"

struct oil_chamber {
    double push, push_std;  /* c of the chamber's law, Pa/m */
    double gain, own, other;/* g of the chamber's law, sqrt(Pa)/s; then a and b, 1/s */
    double flow_std;        /* relative standard deviation of g / c, the flow that moves the
                             * piston */
    /* At the mean command and pressures: open is the derivative of P' by the opening, Pa/s; sag is
     * minus the derivative of P' by the chamber's own P, 1/s. */
    double open, sag;
};

struct oil_leg {
    struct oil_chamber chamber[2];
    /* Delay from the sample of a command to its effect: the spool's delay, and half a cycle because
     * the command is held. */
    double delay_s;
    double stiffness, stiffness_std; /* stiffness of the leg with its ports shut, N/m; NaN if not
                                      * determined */
    double leakage, leakage_std; /* between the chambers, m^3/(s Pa); NaN if the stiffness is not
                                  * determined */
    double misfit;          /* rms residual of the tones' equations and of the nulls' prior, as a
                             * multiple of the standard deviation that it would have by the sensors'
                             * noise and an error of 2 % of the square-root law */
};

/* Finds the stiffness of each leg. A stiffness is not determined if its standard deviation exceeds
 * a twentieth of it, if the leg's delay exceeds 12 ms, a null 4 %, or the misfit 2. Returns -3
 * without memory. */
int oil_columns_find(const struct multisine_mean *mean, const struct params *params, struct oil_leg leg[LEGS], struct error *error);

struct oil_mode {
    double hz, hz_std;      /* eigenfrequency; NaN: not determined */
    /* Motion of the axes, m and rad, scaled so that the axis `dof` moves by 1. */
    double shape[DOFS];
    double motion[LEGS];    /* motion of the legs in that shape, m */
    /* Mass per squared motion of the legs: shape' Mt shape / sum of motion^2, kg. */
    double mass_kg;
    enum dof dof;           /* axis that moves most in the mode, angles multiplied by
                             * kinematics.arm_m */
};

/* Finds the modes, by ascending frequency. Returns false, and all frequencies NaN, if an entry of
 * Mt or a stiffness is not determined, or Mt is not positive definite. */
bool oil_columns_modes(const struct oil_leg leg[LEGS], const struct params *params, double mt[DOFS][DOFS], double mt_std[DOFS][DOFS],
                       struct oil_mode mode[DOFS]);

#endif
