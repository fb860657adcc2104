/* Course of a friction over the tests: seals warm up, and a friction found over all tests is then
 * too small for the first and too large for the last. Ordinary threads; heap. */
#ifndef HEXID_COURSE_H
#define HEXID_COURSE_H

#include "diagnose.h"

/* Finds the two steady tests between which the dry friction of the cylinders differs most. Each
 * test's held-out cycles give the factor on all added dry friction that leaves the smallest
 * residual. The ratio is 0 if no two factors clearly differ. */
struct gap_course course_find(const struct diagnosis *d, const struct recording *recording);

#endif
