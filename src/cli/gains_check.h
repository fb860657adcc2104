/* Compares the configured gains with those that `hexid tune` would give, for `hexid doctor` and
 * `hexid run`. Ordinary threads; heap. */
#ifndef HEXID_GAINS_CHECK_H
#define HEXID_GAINS_CHECK_H

#include <stdbool.h>
#include <stddef.h>

#include "loop_tune.h"

/* hexid warns if a margin is below this share of the margin that `hexid tune` keeps */
#define GAINS_SHARE 0.5

enum { GAINS_TEXT_SIZE = 240 };

struct gains_check {
    bool known;                      /* false: the supply does not hold the platform at neutral, the
                                      * modal weights cannot be computed, a delay is too long
                                      * (loop_tune.h), or there was no memory */
    bool missed;                     /* the loop is unstable in some pose, or a margin is less than
                                      * GAINS_SHARE of that of `hexid tune` */
    struct loop_standing standing;   /* margins of the configured gains */
    char remedy[GAINS_TEXT_SIZE];    /* changes that `hexid tune` proposes if `missed`: "set
                                      * control.kp to 18 (now 40), ..."; "": not missed, or it finds
                                      * no gains */
};

/* Computes the margins of the configured gains. bus: the machine is on a field bus, where commands
 * act one cycle later. Takes up to 2 s if a margin is missed, else 0.05 s. */
struct gains_check gains_check(const struct params *params, bool bus);

/* Writes the margins, and the mode and pose in which each is smallest. */
void gains_check_describe(const struct gains_check *c, char text[GAINS_TEXT_SIZE]);

#endif
