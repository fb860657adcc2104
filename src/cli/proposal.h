/* Proposes a test for a wanted standard deviation from a survey's results: frequencies, amplitudes
 * and duration within the limits of stroke, rate and flow.
 *
 * Frequencies are at most a third of the lowest oil column's eigenfrequency, where the column
 * amplifies motion by an eighth, and at most half the frequency of the loop's lowest pole pair.
 *
 * Sines, one axis after another: each axis at the highest frequency at which its amplitude is off
 * by at most half of checks.amplitude_pct, else at the frequency at which it is least off. The
 * fastest leg moves at three quarters of the survey's highest leg speed, because the loop is known
 * to follow up to that speed; slower if other axes would move by more than 0.7 of
 * checks.unwanted_pct.
 *
 * Multisine: six evenly spaced frequencies, from 0.65 of the highest on. The legs' rates with all
 * axes' peaks together reach half of the limit of limits.leg_rate_mps and the valve. Shares of the
 * rates and the assignment of frequencies to axes are searched: axes with larger deviations get
 * larger shares, those of the worst entry higher frequencies, as long as the worst entry's
 * deviation falls (a descent to a local optimum).
 *
 * Both are scaled down until motion_check() accepts them and the loop stays within half of
 * limits.following_m. The duration of the evaluated part follows from the deviation that
 * excitation_predict() gives; if even the shortest test is better than wanted, amplitudes are
 * reduced. Numbers are rounded before they are tried. Ordinary threads; heap; takes seconds. */
#ifndef HEXID_PROPOSAL_H
#define HEXID_PROPOSAL_H

#include "excitation.h"
#include "params/tests.h"

struct proposal {
    struct error none;              /* why there is no proposal; status 0: there is one */
    struct test_params tests;       /* proposed tests; their settling and ramps are as configured */
    struct excitation predicted;
    double start_pct;               /* multisine: worst entry's deviation before the search, with
                                     * equal rates and the search's duration */
    double best_pct;                /* multisine: worst entry's deviation after the search */
    bool reached;                   /* the wanted deviation is reached, within 5 % */
};

enum proposal_kind { PROPOSAL_SINES, PROPOSAL_MULTISINE, PROPOSALS };

/* Receives the progress of a long computation: share() is called before each prediction with the
 * number of predictions made, divided by the largest number that there may be. */
struct proposal_watch {
    void (*share)(void *context, double share);
    void *context;
    int done, most;        /* number of predictions made, and the largest number */
};

/* Makes a proposal. params: as configured for the tests, not the survey's; wanted_pct: as
 * excitation.worst_pct. Returns 0 also without a proposal (result->none); -3: no memory. */
int propose(enum proposal_kind kind, const struct loop_survey *survey, const struct params *params, double wanted_pct,
            struct proposal_watch *watch, struct proposal *result, struct error *error);

/* Writes the options that run the proposed tests: "--set tests.... --set ...". */
void proposal_options(const struct proposal *proposal, char *text, int size);

#endif
