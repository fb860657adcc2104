#include "nominal.h"

#include <string.h>

#include "params.h"

/*  symbol     meaning                                               unit
 *  q = T a_i  lever arm of the upper joint                          m
 *  j          row of the Jacobian of leg rates, [n', (q x n)']      -, m
 *  L          length of the leg                                     m
 *  ma, mb     masses of the leg's upper and lower part              kg
 *  ra, rb     mass centres, from the upper and the lower joint      m
 *  ia, ib     transverse inertias about these centres               kg m^2
 *  g          ma (L-ra)^2 + mb rb^2 + ia + ib, inertia of the leg   kg m^2
 *             about its lower joint
 *  b = g/L^2  mass of the leg at the upper joint, across the leg    kg
 *
 * With n the leg's direction, M_leg = ma n n' + b (I - n n') and Ja = [I, -q~]:
 *
 *  Ja' M_leg Ja = b Ja' Ja + (ma - b) j j',  Ja' Ja = [I, -q~; q~, q'q I - q q']. */

static void add_payload(const struct payload_params *p, double t[3][3], double mt[DOFS][DOFS]) {
    const double xy = p->inertia_xy_kg_m2, xz = p->inertia_xz_kg_m2, yz = p->inertia_yz_kg_m2;
    const double inertia[3][3] = {{p->inertia_xx_kg_m2, xy, xz}, {xy, p->inertia_yy_kg_m2, yz}, {xz, yz, p->inertia_zz_kg_m2}};
    for (int r = 0; r < 3; r++) {
        mt[r][r] += p->mass_kg;
        for (int c = 0; c < 3; c++)
            for (int i = 0; i < 3; i++)
                for (int j = 0; j < 3; j++) mt[3 + r][3 + c] += t[r][i] * inertia[i][j] * t[c][j];
    }
}

static double across_kg(const struct actuator_params *a, int leg, double length_m) {
    double arm = length_m - a->upper_center_m[leg];
    double g = a->upper_mass_kg[leg] * arm * arm + a->lower_mass_kg[leg] * a->lower_center_m[leg] * a->lower_center_m[leg] +
               a->upper_inertia_kg_m2[leg] + a->lower_inertia_kg_m2[leg];
    return g / (length_m * length_m);
}

static void add_point_mass(double mass_kg, const double q[3], double mt[DOFS][DOFS]) {
    const double q_cross[3][3] = {{0, -q[2], q[1]}, {q[2], 0, -q[0]}, {-q[1], q[0], 0}};
    double square = q[0] * q[0] + q[1] * q[1] + q[2] * q[2];
    for (int r = 0; r < 3; r++) {
        mt[r][r] += mass_kg;
        mt[3 + r][3 + r] += mass_kg * square;
        for (int c = 0; c < 3; c++) {
            mt[r][3 + c] -= mass_kg * q_cross[r][c];
            mt[3 + r][c] += mass_kg * q_cross[r][c];
            mt[3 + r][3 + c] -= mass_kg * q[r] * q[c];
        }
    }
}

void nominal_matrix(const struct params *params, const struct kinematics *k, const double pose[DOFS], double mt[DOFS][DOFS]) {
    double t[3][3], j[LEGS][DOFS], length_m[LEGS];
    rotation_from_angles(pose[3], pose[4], pose[5], t);
    ik_lengths(k, pose, length_m);
    ik_jacobian(k, pose, j);
    memset(mt, 0, DOFS * sizeof mt[0]);
    add_payload(&params->payload, t, mt);
    for (int i = 0; i < LEGS; i++) {
        double q[3], across = across_kg(&params->actuator, i, length_m[i]), along = params->actuator.upper_mass_kg[i];
        for (int r = 0; r < 3; r++) q[r] = t[r][0] * k->upper[i][0] + t[r][1] * k->upper[i][1] + t[r][2] * k->upper[i][2];
        add_point_mass(across, q, mt);
        for (int r = 0; r < DOFS; r++)
            for (int c = 0; c < DOFS; c++) mt[r][c] += (along - across) * j[i][r] * j[i][c];
    }
}
