/* A log of one run of the daemon, or of several: what lcm-logger wrote beside two of them, or logs
 * that were joined. Cycles of a run follow each other in number and time, so one that goes back, or
 * a second configuration, begins another run. Parts of one run that are joined in their order are
 * one run. A single cycle that goes back or ahead, between two that follow each other, is damage
 * and no run. Ordinary threads. */
#ifndef HEXID_LOG_RUNS_H
#define HEXID_LOG_RUNS_H

#include <stdbool.h>
#include <stdint.h>

#include "log.h"

enum { LOG_RUNS_MAX = 32 };

struct log_run {
    int64_t begin, end;          /* bytes of the log */
    int64_t began_us;            /* the log's clock at its first cycle */
    int64_t cycles;
    uint64_t first_seq, last_seq;
    int64_t first_ns, last_ns;
    uint64_t config;             /* hash of its configuration; 0: it has none */
    int part;                    /* it begins with this part */
};

struct log_runs {
    struct log_run run[LOG_RUNS_MAX];
    int count;
    bool mixed;                  /* cycles of several daemons take turns */
    bool disordered;             /* parts of one run, not in their order */
    bool configurations;         /* they differ */
};

/* Reads the log to its end; nothing that is in it makes this fail. -3 as log_open(). */
int log_runs_find(const char *path, struct log_runs *runs, struct error *error);

/* Opens a log, or of one that holds several runs the one of this number, from 1. -3 as log_open();
 * for one that holds several where run is 0, naming them and the remedy; and for one that is mixed
 * or in disorder. -2: there is no such run. */
int log_open_run(struct log_reader **reader, const char *path, int run, struct error *error);

#endif
