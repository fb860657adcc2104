/* Proposes, from a survey's results, a test that reaches a wanted standard deviation of Mt:
 * frequencies, amplitudes and duration within the limits of stroke, rate and flow.
 *
 * Frequencies are at most a third of the oil columns' lowest eigenfrequency, where the resonance
 * amplifies the motion by an eighth, and at most half the frequency of the loop's lowest pole pair.
 *
 * Sines, one axis after another. Each axis has the highest frequency at which its amplitude
 * deviates from the reference by at most half of checks.amplitude_pct, or if there is none, the
 * frequency of the smallest deviation. The fastest leg moves at three quarters of the survey's
 * highest leg speed, because the loop is known to follow at that speed, or slower if other axes
 * would move by more than 0.7 of checks.unwanted_pct.
 *
 * Multisine: six evenly spaced frequencies, from 0.65 of the highest on. When the peaks of all axes
 * coincide, the fastest leg reaches half of the rate that limits.leg_rate_mps and the valve allow.
 * A descent to a local optimum finds the axes' shares of that rate and the assignment of
 * frequencies to axes: axes with larger deviations get larger shares, and the axes of the worst
 * entry of Mt get higher frequencies, as long as the deviation of the worst entry falls.
 *
 * Both kinds of test are scaled down until motion_check() accepts them and the following error
 * stays within half of limits.following_m. The duration of the evaluated part follows from the
 * deviation that excitation_predict() predicts; if even the shortest test is better than wanted,
 * amplitudes are reduced. Frequencies, amplitudes and durations are rounded before they are tried.
 * Ordinary threads; heap; takes seconds. */
#ifndef HEXID_PROPOSAL_H
#define HEXID_PROPOSAL_H

#include "excitation.h"
#include "params/tests.h"

struct proposal {
    struct error none;              /* why there is no proposal; status 0: there is one */
    struct test_params tests;       /* proposed tests; settling and ramps are as configured */
    struct excitation predicted;
    double start_pct;               /* multisine: worst entry's deviation before the search, with
                                     * equal shares of the rate; the test has the same length as
                                     * those in the search */
    double best_pct;                /* multisine: worst entry's deviation after the search */
    bool reached;                   /* the wanted deviation is reached, within 5 % */
};

enum proposal_kind { PROPOSAL_SINES, PROPOSAL_MULTISINE, PROPOSALS };

/* Receives the progress of a long computation: before each prediction share() is called with the
 * number of predictions made over the largest possible number. */
struct proposal_watch {
    void (*share)(void *context, double share);
    void *context;
    int done, most;        /* number of predictions made, and largest possible number */
};

/* Makes a proposal. params: the configured parameters, with the configured tests, not the survey;
 * wanted_pct: wanted value of excitation.worst_pct. Returns 0 even if there is no proposal
 * (result->none); -3: no memory. */
int propose(enum proposal_kind kind, const struct loop_survey *survey, const struct params *params, double wanted_pct,
            struct proposal_watch *watch, struct proposal *result, struct error *error);

/* Writes the options that run the proposed tests: "--set tests.... --set ...". */
void proposal_options(const struct proposal *proposal, char *text, int size);

#endif
