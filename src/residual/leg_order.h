/* Checks whether lengths, forces and drawing (the positions of the joints) number the legs alike.
 * Legs that are exchanged, counted from another one, or counted backwards are found from lengths
 * and forces alone, without reference or command.
 *
 * Near neutral the forces along the legs and the legs' motion l obey
 *
 *   f = J'^-1 (M_legs + M_payload) J^-1 l" + W l + b l' + c sign(l')     (each leg its own b, c)
 *
 * with the configured J, legs and weight (W), and a payload that is any rigid body, with ten
 * inertial parameters. These equations are linear in 22 unknowns, and for another order of the
 * channels only the indices change. So the products of all channels are summed once over the
 * coefficient rows of a recording. From them a least squares fit of the 22 unknowns yields, for
 * each order, the share of the varying force that the order leaves unexplained. A prior increases
 * this share if the payload is far from the configured one. The stated order is refuted if another
 * one explains decisively more.
 *
 * The common orders (leg_places.h) are tried first. If the stated one fits badly and none of them
 * is decisive, all 720 are tried, and then lengths and forces in two different orders. Ordinary
 * threads; heap. */
#ifndef HEXID_LEG_ORDER_H
#define HEXID_LEG_ORDER_H

#include "residual.h"

enum { LEG_ORDER_TEXT = 320 };

struct leg_order {
    bool refuted;           /* another order than the stated one explains the forces */
    double stated, best;    /* share of the varying force's square that the stated order, and the
                             * best one, leave unexplained; above 1 for another machine */
    char text[LEG_ORDER_TEXT]; /* if refuted: orders in words that explain as much as the best one,
                                * at most one each for the lengths, the forces and both */
};

/* Compares the orders for the tests of a recording from index `first` on. Returns 0, or -3 without
 * memory. */
int leg_order_find(const struct residual_data *data, const struct recording *recording, int first, struct leg_order *order,
                   struct error *error);

/* True if these lengths fit the drawing at neutral only when the platform's joints are numbered in
 * another common order (leg_places.h) than those of the base; `text` receives this order.
 * tolerance_m: largest difference of a leg's length that counts as a fit. */
bool leg_order_of_drawing(const struct params *params, const double length_m[LEGS], double tolerance_m, char text[LEG_ORDER_TEXT]);

/* Lists the common orders (leg_places.h) that, applied to lengths and forces together or to the
 * drawing, change no length and no force of this machine: "leg 1 in place 3, counted on; ..."; ""
 * if there are none. Only a recorded reference distinguishes such orders. */
void leg_order_symmetries(const struct params *params, char text[LEG_ORDER_TEXT]);

#endif
