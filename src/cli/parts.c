#include "parts.h"

#include <stdlib.h>

int parts_init(struct parts *p, struct error *error) {
    *p = (struct parts){.joined = 1};
    p->part = calloc(PARTS + 1, sizeof *p->part);
    return p->part ? estimator_start(&p->estimator, error) : error_set(error, STATUS_IO, "out of memory");
}

void parts_free(struct parts *p) {
    estimator_stop(&p->estimator);
    free(p->part);
    p->part = NULL;
}

static void join_neighbours(struct parts *p) {
    for (int i = 0; i < PARTS / 2; i++) {
        if (i) p->part[i] = p->part[2 * i];
        equations_add(&p->part[i], &p->part[2 * i + 1]);
    }
    p->count = PARTS / 2, p->joined *= 2, p->in_last = p->joined;
}

void parts_add(struct parts *p, const struct equations *e, const struct error *error) {
    p->all++;
    if (error->status) {
        if (!p->left_out++) p->why = *error;
        return;
    }
    if (!p->count || p->in_last == p->joined) {
        if (p->count == PARTS) join_neighbours(p);
        p->part[p->count++] = (struct equations){0};
        p->in_last = 0;
    }
    equations_add(&p->part[p->count - 1], e);
    p->in_last++;
}

void parts_take(struct parts *p, bool wait) {
    struct equations *taken = &p->part[PARTS];
    struct error error;
    if (!wait && !estimator_ready(&p->estimator)) return;
    if (!estimator_take(&p->estimator, wait, taken, &error)) return;
    if (!p->dropped) parts_add(p, taken, &error);
    p->dropped = false;
}

void parts_close(struct parts *p, struct recording *recording) {
    parts_take(p, true);
    p->dropped = false;
    estimator_give(&p->estimator, recording);
}

void parts_clear(struct parts *p) {
    p->dropped = true;
    p->why = (struct error){0};
    p->count = p->in_last = p->all = p->left_out = 0;
    p->joined = 1;
}

static int compare(const struct parts *p, const struct params *configured, struct agreement *agreement, struct error *error) {
    struct agreement_log log[PARTS];
    struct estimate *estimate = calloc(PARTS, sizeof *estimate);
    struct method_c *result = calloc(PARTS, sizeof *result);
    struct error none;
    int status = estimate && result ? STATUS_OK : error_set(error, STATUS_IO, "out of memory"), n = 0;
    for (int i = 0; i < p->count && !status; i++) {
        /* a part that has too little data for a solution of its own is not compared */
        if (method_c_solve(&p->part[i], configured, &estimate[i], &result[i], &none)) continue;
        log[n++] = (struct agreement_log){&p->part[i], &estimate[i], &result[i]};
    }
    agreement->logs = n;
    if (!status && n > 1) status = agreement_find(n, log, configured, agreement, error);
    free(estimate), free(result);
    return status;
}

int parts_sum(const struct parts *p, const struct params *configured, struct equations *sum, struct agreement *agreement,
              struct error *error) {
    *sum = (struct equations){0};
    if (agreement) *agreement = (struct agreement){.logs = p->count};
    if (!p->count) {
        if (p->why.status) *error = p->why;
        else error_set(error, STATUS_USAGE, "method C: no part of a motion");
        return error->status;
    }
    for (int i = 0; i < p->count; i++) equations_add(sum, &p->part[i]);
    return agreement && p->count > 1 ? compare(p, configured, agreement, error) : STATUS_OK;
}
