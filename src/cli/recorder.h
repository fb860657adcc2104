/* The recorder: the one ordinary thread that reads the loop's ring. It keeps every cycle in the
 * log, sends the stream over LCM, feeds the identifier and reports to the terminal; method C, which
 * takes longer, it leaves to an estimator (estimator.h). Everything happens in one order: the log
 * of a virtual-time run is the same every time, and a result always stands right behind the cycle
 * that completed it. */
#ifndef HEXID_RECORDER_H
#define HEXID_RECORDER_H

#include "analysis.h"
#include "bus.h"
#include "log.h"
#include "log_keeper.h"
#include "loop.h"
#include "notify.h"
#include "progress.h"

struct recorder {
    const struct params *params;
    struct loop *loop;
    struct ring *records;
    struct log_writer *log;          /* NULL: no log */
    struct log_keeper *keeper;       /* NULL: the log is one file */
    int64_t part_bytes;              /* else parts end at this size, or later with the test under
                                      * way, at twice it at most */
    int64_t part_due_bytes;          /* size of this part at which the next is asked for */
    int part;                        /* number of this part, from 1, */
    char part_path[PATH_MAX];        /* and its path; "" for the first */
    bool over_quota;                 /* the operator was told */
    const char *config;
    struct bus *bus;                 /* NULL: nothing is sent */
    struct progress *progress;
    struct notify notify;            /* for a service manager: ready when settled, alive while
                                      * cycles come, stopping when the loop is to quit */
    struct analysis analysis;
    struct estimator estimator;      /* method C of the tests so far, for the bus */
    bool estimate_due;               /* a test has ended since the last estimate was begun */
    int64_t estimate_ns;             /* of the estimate under way: when its last test ended, and how
                                      * many tests it has; 0: none is under way */
    int estimate_tests;
    _Atomic bool computes;           /* it computes, which may take longer than
                                      * RECORDER_PATIENCE_S */
    uint32_t request_id;             /* the last request reported */
    int64_t statistics_cycles;       /* between two HEXID_LOOP_STATS */
    int64_t settled_cycles;          /* in a row */
    uint32_t interlocks_wrong;       /* as last reported (interlock.h) */
    int64_t checked_ns, asked_ns;    /* when the log was looked after, and a part asked for */
    char device[200];                /* the same of the way to the machine */
    struct error error;              /* first failure to write the log; status 0 while all is
                                      * well */
    struct error keeper_error;       /* its keeper has ended or hangs; status 0: no */
    pthread_t thread;
};

/* `config` is the effective configuration, first event of the log and of each of its parts; it must
 * outlive the recorder. The recorder has no effect on the loop but through `loop->quit` and a park
 * request when the log cannot be written. -2, -3. */
int recorder_start(struct recorder *r, const char *config, struct error *error);

/* Waits for the last record, for as long as records are taken or something is computed; gives up
 * after RECORDER_PATIENCE_S without either: false, and the recorder is in use by its thread until
 * the process ends. */
enum { RECORDER_PATIENCE_S = 3 };
bool recorder_join(struct recorder *r);

#endif
