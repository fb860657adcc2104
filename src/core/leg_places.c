#include "leg_places.h"

#include <stdio.h>
#include <string.h>

static int wrap(int leg) { return (leg % LEGS + LEGS) % LEGS; }

static struct leg_places counted(int first, int step) {
    struct leg_places order;
    for (int k = 0; k < LEGS; k++) order.place[k] = wrap(first + step * k);
    return order;
}

static bool same(const struct leg_places *a, const struct leg_places *b) { return !memcmp(a, b, sizeof *a); }

struct leg_places leg_places_exchanged(const struct leg_places *order, int leg, int other) {
    struct leg_places to = *order;
    to.place[leg] = order->place[other], to.place[other] = order->place[leg];
    return to;
}

void leg_places_common(struct leg_places list[LEG_PLACES_COMMON]) {
    int n = 0;
    list[n++] = counted(0, 1);
    for (int a = 0; a < LEGS; a++)
        for (int b = a + 1; b < LEGS; b++) list[n++] = leg_places_exchanged(&list[0], a, b);
    for (int first = 1; first < LEGS; first++) list[n++] = counted(first, 1);
    for (int first = 0; first < LEGS; first++) list[n++] = counted(first, -1);
}

bool leg_places_stated(const struct leg_places *order) {
    struct leg_places stated = counted(0, 1);
    return same(order, &stated);
}

int leg_places_exchanges(const struct leg_places *order) {
    struct leg_places left = *order;
    int count = 0;
    for (int k = 0; k < LEGS; k++)
        for (; left.place[k] != k; count++) left = leg_places_exchanged(&left, k, left.place[k]);
    return count;
}

/* Writes the permutation by its cycles: a cycle of two legs as an exchange, a longer cycle by its
 * legs and their places. */
static void name_cycles(const struct leg_places *order, char name[LEG_PLACES_NAME]) {
    bool done[LEGS] = {false};
    int used = 0;
    for (int k = 0; k < LEGS; k++) {
        char legs[2 * LEGS + 1] = "", places[2 * LEGS + 1] = "";
        int n = 0;
        for (int leg = k; !done[leg]; leg = order->place[leg], n++) {
            done[leg] = true;
            snprintf(legs + 2 * n, sizeof legs - (size_t)(2 * n), " %d", leg + 1);
            snprintf(places + 2 * n, sizeof places - (size_t)(2 * n), " %d", order->place[leg] + 1);
        }
        const char *before = used ? ", " : "";
        size_t left = (size_t)(LEG_PLACES_NAME - used);
        if (n == 2) used += snprintf(name + used, left, "%slegs %d and %d exchanged", before, k + 1, order->place[k] + 1);
        if (n > 2) used += snprintf(name + used, left, "%slegs%s in places%s", before, legs, places);
    }
}

void leg_places_name(const struct leg_places *order, char name[LEG_PLACES_NAME]) {
    int first = order->place[0];
    struct leg_places on = counted(first, 1), back = counted(first, -1);
    if (leg_places_stated(order)) snprintf(name, LEG_PLACES_NAME, "as stated");
    else if (same(order, &on)) snprintf(name, LEG_PLACES_NAME, "leg 1 in place %d, counted on", first + 1);
    else if (same(order, &back)) snprintf(name, LEG_PLACES_NAME, "leg 1 in place %d, counted backwards", first + 1);
    else name_cycles(order, name);
}
