/* Sets of effects under a remainder. On a real machine no law is exact, so every model leaves
 * something unexplained, the remainder. A set has at most four effects. Sets are compared by their
 * evidence, under a covariance that includes the remainder. Ordinary threads; heap. */
#ifndef HEXID_SETS_H
#define HEXID_SETS_H

#include "evidence.h"

enum { SETS_MAX = 64, SETS_SIZES = 80 };

/* Largest error of a law that the covariance allows, as a share of its family's contribution. */
#define SETS_LAW_MOST 0.2

/* A set of effects, fitted. */
struct set {
    int effects;
    struct hypothesis hypothesis[GAP_EFFECTS];
    int causes; /* number of effects that the prior counts for this set; 0: as many as it has */
    struct params model;
    struct linearised linear;
    /* evidence: log of the evidence, averaged over the sizes of the remainder, plus log_prior.
     * log_evidence: at each size, without log_prior. probability: of this set among all sets that
     * are kept */
    double log_prior, evidence, probability;
    double log_evidence[SETS_SIZES];
};

/* The sets that are compared, and the sizes of the remainder over which their evidence is
 * averaged. */
struct comparison {
    struct diagnosis *d;
    bool exact;
    struct fit_data fit, held_out;  /* data with the whiteners of noise alone */
    struct covariance covariance, held_covariance;
    double *variance;               /* [values]: variances of the whiteners in d, relative to those
                                     * of noise */
    double gap;                     /* rms of the residuals without any effect, in units of the
                                     * noise */
    int sizes;
    struct covariance_size size[SETS_SIZES];
    int sets;
    struct set *set;
};

/* Begins a comparison around the model of a diagnosis. Until sets_end() the whiteners of the
 * diagnosis contain a remainder. spread: initial size of the remainder's part `spread`
 * (covariance.h). exact: true if no law is less exact than its law_error says; false if the laws of
 * a family may be off by up to SETS_LAW_MOST. */
void sets_begin(struct comparison *s, struct diagnosis *d, double spread, bool exact);
void sets_end(struct comparison *s);

/* Searches sets, the likeliest first, beginning with the base without effects. */
void sets_search(struct comparison *s, const struct params *base);

/* Fits a set and keeps it with its evidence. A set is not kept if it is known already or cannot be
 * fitted, if one of its effects gets no strength, if a sensor's error or a parameter of a law's
 * form is at the end of its range, or if SETS_MAX sets with more evidence are kept. */
void sets_keep(struct comparison *s, struct set *one);

/* Fits a set without keeping it; the caller frees its linearisation. Returns false if it cannot be
 * fitted, or if the fit leaves any of its effects without strength. */
bool sets_fit(struct comparison *s, struct set *one);

/* Finds the probabilities of all sets and sorts them, the likeliest first. A set is left out if one
 * of its limiting cases explains about as much. Returns false without a set, or if the best one
 * cannot be fitted. */
bool sets_rank(struct comparison *s);

/* True if two sets have the same effects, with the same choices of legs and of symmetry. */
bool sets_same(const struct set *a, const struct set *b);

/* Place of an effect in a set; -1: the set lacks it. */
int sets_place(const struct set *set, int effect);

/* True for effects that grow with the size of the machine: all except the errors of sensors and
 * clocks. */
bool sets_grows_with_machine(int effect);

#endif
