#include "loop_places.h"

#include <math.h>

#include "kinematics.h"
#include "params.h"

static const double TRIED = 0.8;           /* poses are checked up to the one in which some leg has
                                            * gone this share of its way from neutral to an end of
                                            * its stroke */
static const double SEARCH = 10.0;         /* m or rad; upper bound of the search for the pose at a
                                            * stroke's end, larger than any stroke */
enum { HALVINGS = 30 };

/* True if no leg has gone more than the share TRIED of its way from neutral to either end of its
 * stroke. */
static bool within(const struct kinematics *k, const struct params *p, const double pose[DOFS]) {
    double length_m[LEGS];
    ik_lengths(k, pose, length_m);
    for (int i = 0; i < LEGS; i++) {
        struct stroke s = kinematics_stroke(k, &p->actuator, i);
        double neutral = k->neutral_length_m[i], way = length_m[i] - neutral;
        if (!(way <= TRIED * (s.most_m - neutral) && way >= TRIED * (s.least_m - neutral))) return false;
    }
    return true;
}

static double farthest(const struct kinematics *k, const struct params *p, int dof, double sense) {
    double low = 0.0, high = SEARCH;
    for (int i = 0; i < HALVINGS; i++) {
        double middle = 0.5 * (low + high), pose[DOFS] = {0};
        pose[dof] = sense * middle;
        if (within(k, p, pose)) low = middle;
        else high = middle;
    }
    return sense * low;
}

static void add(struct loop_places *all, const struct params *p, int dof, double value, double delay_s) {
    double pose[DOFS] = {0};
    pose[dof] = value;
    if (loop_place_find(&all->place[all->count], p, pose, delay_s)) all->count++;
}

double loop_delay_s(const struct params *p, bool bus) { return fmax(bus ? p->loop.period_s : 0.0, p->control.delay_s); }

bool loop_places_find(struct loop_places *all, const struct params *p, bool bus) {
    struct kinematics k;
    double delay_s = loop_delay_s(p, bus);
    all->count = 0;
    kinematics_place(&k, p);
    add(all, p, DOF_Z, 0.0, delay_s);
    if (!all->count) return false;
    for (int i = 1; i <= LOOP_WAY; i++) add(all, p, DOF_Z, p->motion.park_z_m * i / LOOP_WAY, delay_s);
    all->way = all->count;
    for (int dof = 0; dof < DOFS; dof++)
        for (int sense = -1; sense <= 1; sense += 2) add(all, p, dof, farthest(&k, p, dof, sense), delay_s);
    return true;
}

bool loop_grows(const struct loop_worst *w) { return !w->known || !(w->pole.decay_per_s > 0.0); }

double loop_places_noise_mps2(const struct loop_places *all, const struct params *p) {
    double worst_mps2 = 0.0;
    for (int i = 0; i < all->way; i++) {
        struct loop_worst here = loop_place_worst(&all->place[i], p);
        if (!loop_grows(&here)) worst_mps2 = fmax(worst_mps2, loop_place_noise_mps2(&all->place[i], p));
    }
    return worst_mps2;
}

double loop_noise_most_mps2(const struct params *p) { return LOOP_NOISE_MOST * p->limits.oscillation_mps2; }
