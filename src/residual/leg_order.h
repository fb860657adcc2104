/* Do lengths, forces and drawing belong together? Legs that are exchanged, counted from another
 * one, or counted the other way round are found from lengths and forces alone, without reference or
 * command.
 *
 * Near neutral the forces along the legs and the legs' motion l obey
 *
 *   f = J'^-1 (M_legs + M_payload) J^-1 l" + W l + b l' + c sign(l')     (each leg its own b, c)
 *
 * with the configured J, legs and weight (W), and a payload that is any rigid body: ten numbers.
 * That is linear in 22 unknowns, and for another order of the channels only the indices change. So
 * the products of all channels, summed once over the coefficient rows of a recording, yield by one
 * least squares of 22 unknowns the share of the varying force that an order leaves unexplained. A
 * payload far from the configured one costs, too: a prior. The stated order is refuted if another
 * one explains decisively more. Ordinary threads; heap. */
#ifndef HEXID_LEG_ORDER_H
#define HEXID_LEG_ORDER_H

#include "residual.h"

enum { LEG_ORDER_TEXT = 240 };

struct leg_order {
    bool refuted;           /* another order than the stated one explains the forces */
    double stated, best;    /* share of the varying force's square that is left unexplained, 0..1,
                             * by the stated order and by the best one */
    char text[LEG_ORDER_TEXT]; /* if refuted: the best order in words, and those that explain as
                                * much */
};

/* Compares the orders for the tests of a recording from `first` on. Returns -3 without memory. */
int leg_order_find(const struct residual_data *data, const struct recording *recording, int first, struct leg_order *order,
                   struct error *error);

/* True if the lengths follow the reference in another order than the stated one, which stands in
 * `text`. product: sums of products of measured and asked lengths; measured, asked: of squares. */
bool leg_order_by_reference(const double product[LEGS][LEGS], const double measured[LEGS], const double asked[LEGS],
                            char text[LEG_ORDER_TEXT]);

/* True if these lengths at neutral are those of the drawing when the joints of the platform are in
 * another order against those of the base, which stands in `text`. */
bool leg_order_of_drawing(const struct params *params, const double length_m[LEGS], double tolerance_m, char text[LEG_ORDER_TEXT]);

/* Orders of both channels, or of the drawing, that change no length and no force of this machine:
 * "leg 1 in place 3, counted on; ..."; "" if there are none. Only a recorded reference tells such
 * orders apart. */
void leg_order_symmetries(const struct params *params, char text[LEG_ORDER_TEXT]);

#endif
