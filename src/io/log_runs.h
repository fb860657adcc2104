/* Finds the runs of the daemon in a log. A log has several if lcm-logger recorded them, if logs
 * were joined, or if the gains were changed (`hexid command set`). Within a run, numbers and times
 * of cycles increase, so a cycle that goes back begins another run, and so does a configuration
 * that differs from the run's. Parts of one run, joined in order, are one run. A single cycle that
 * jumps back or ahead between two consecutive ones is damage, not a run. Ordinary threads. */
#ifndef HEXID_LOG_RUNS_H
#define HEXID_LOG_RUNS_H

#include <stdbool.h>
#include <stdint.h>

#include "log.h"

enum { LOG_RUNS_MAX = 1024 };

struct log_run {
    int64_t begin, end;          /* range of bytes in the log in which the run's events begin */
    int64_t began_us;            /* utime of the run's first cycle */
    int64_t cycles;
    uint64_t first_seq, last_seq;
    int64_t first_ns, last_ns;
    uint64_t config;             /* hash of the run's configuration; 0: the run has none */
    int part;                    /* number of the part with which the run begins; 0: none */
};

/* The struct takes 80 kB, so it does not belong on the stack. */
struct log_runs {
    struct log_run run[LOG_RUNS_MAX];
    int count;
    bool more;                   /* the log has more runs than fit in `run` */
    bool mixed;                  /* cycles of several daemons are interleaved */
    bool disordered;             /* parts of one run are out of order */
    bool configurations;         /* the runs have different configurations */
};

/* Reads the whole log; its content cannot make this fail. Returns -3 as log_open() does. */
int log_runs_find(const char *path, struct log_runs *runs, struct error *error);

/* Opens a log or, in a log of several runs, the run with this number, from 1. Returns -2 if there
 * is no such run. Returns -3 as log_open() does; for run 0 of a log of several runs, with their
 * list and the remedy; and for a log that is mixed or out of order. */
int log_open_run(struct log_reader **reader, const char *path, int run, struct error *error);

#endif
