/* A test for a wanted standard deviation, from what a survey found: frequencies, amplitudes and
 * duration within the limits of stroke, rate and flow.
 *
 * Frequencies are at most a third of the lowest eigenfrequency of the oil columns, where these
 * amplify by an eighth, and half of that of the lowest pole pair of the loop.
 *
 * Sines, one axis after another: each axis at the highest frequency at which its amplitude is off
 * by half of checks.amplitude_pct at most (else where it is least off), its legs as fast as the
 * survey's fastest: as fast as the loop is known to follow.
 *
 * Multisine: six frequencies from 0.65 of the highest on, evenly spaced. The legs' rates, all axes'
 * peaks together, reach half of what limits.leg_rate_mps and the valve allow. How these are shared
 * out, and which axis has which frequency, is searched: shares go to the axes with the larger
 * deviations, a higher frequency to those of the worst entry, for as long as that lowers the worst
 * entry's deviation (a descent: the optimum is a local one).
 *
 * Both are scaled down until motion_check() lets them through and the loop stays within half of
 * limits.following_m. The duration of the evaluated part follows from the deviation that
 * excitation_predict() states; where even the shortest is better than wanted, the amplitudes are
 * reduced. Numbers are rounded before they are tried. Ordinary threads; heap; seconds. */
#ifndef HEXID_PROPOSAL_H
#define HEXID_PROPOSAL_H

#include "excitation.h"

struct proposal {
    struct error none;              /* why there is no proposal; status 0: there is one */
    struct test_params tests;       /* settle and ramps as configured */
    struct excitation predicted;
    double start_pct;               /* multisine: deviation of the worst entry with equal rates,
                                     * before the search, at the search's duration */
    double best_pct;                /* and after it */
    bool reached;                   /* the wanted deviation, within 5 % */
};

enum proposal_kind { PROPOSAL_SINES, PROPOSAL_MULTISINE, PROPOSALS };

/* params: as configured for the tests, not the survey's; wanted_pct as excitation.worst_pct. -3:
 * memory. Without a proposal 0, and result->none. */
int propose(enum proposal_kind kind, const struct loop_survey *survey, const struct params *params, double wanted_pct,
            struct proposal *result, struct error *error);

/* The options that run it: "--set tests.... --set ...". */
void proposal_options(const struct proposal *proposal, char *text, int size);

#endif
