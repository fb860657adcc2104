/* Compares the configured gains with those that `hexid tune` would give, for `hexid doctor` and
 * `hexid run`. Ordinary threads; heap. */
#ifndef HEXID_GAINS_CHECK_H
#define HEXID_GAINS_CHECK_H

#include <stdbool.h>
#include <stddef.h>

#include "loop_tune.h"

/* hexid warns of margins below this share of those that `hexid tune` keeps */
#define GAINS_SHARE 0.5

enum { GAINS_TEXT_SIZE = 240 };

struct gains_check {
    bool known;                      /* false: the platform is not held at neutral, or no memory */
    bool missed;                     /* the loop is unstable in some pose, or a margin is less than
                                      * GAINS_SHARE of what is wanted */
    struct loop_standing standing;   /* of the configured gains */
    char remedy[GAINS_TEXT_SIZE];    /* if missed, what `hexid tune` would change: "set control.kp
                                      * to 18 (now 40), ..."; "": it finds no gains */
};

/* bus: the machine is on a field bus, where commands act one cycle later. Takes up to two seconds
 * if margins are missed, else a twentieth of one. */
struct gains_check gains_check(const struct params *params, bool bus);

/* Writes the margins, and in which mode and pose each is least. */
void gains_check_describe(const struct gains_check *c, char text[GAINS_TEXT_SIZE]);

#endif
