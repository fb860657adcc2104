/* Orders of the six legs: which channel, or which joint in a list, belongs to which leg. Any
 * thread, no heap. */
#ifndef HEXID_LEG_PLACES_H
#define HEXID_LEG_PLACES_H

#include "types.h"

struct leg_places {
    int place[LEGS]; /* index, from 0, of the channel or joint that belongs to leg k */
};

enum { LEG_PLACES_COMMON = 1 + 15 + 5 + 6, LEG_PLACES_NAME = 80 };

/* Lists the most frequent orders: the stated one, place[k] = k; 15 with two legs exchanged; 5 that
 * count on from another place, place[k] = first + k modulo 6; and 6 that count backwards, place[k]
 * = first - k modulo 6. */
void leg_places_common(struct leg_places list[LEG_PLACES_COMMON]);

/* Returns `order` with the places of two legs exchanged. At most five exchanges lead from any of
 * the 720 orders to any other. */
struct leg_places leg_places_exchanged(const struct leg_places *order, int leg, int other);

bool leg_places_stated(const struct leg_places *order);

/* Returns the least number of exchanges of two legs, 0 to 5, by which the stated order becomes this
 * one. */
int leg_places_exchanges(const struct leg_places *order);

/* Writes the order in words: "as stated"; "leg 1 in place 3, counted on"; "leg 1 in place 2,
 * counted backwards"; "legs 1 and 2 exchanged, legs 3 and 4 exchanged"; "legs 1 2 3 in places
 * 2 3 1". */
void leg_places_name(const struct leg_places *order, char name[LEG_PLACES_NAME]);

#endif
