/* The recorder: the one ordinary thread behind the loop's ring. It keeps every cycle in the log,
 * sends the stream over LCM, feeds the identifier and tells the terminal; method C, which takes
 * longer, it leaves to an estimator (estimator.h). One order of doing things: the log of a
 * virtual-time run is the same every time, and a result always stands right behind the cycle
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
    struct log_writer *log;          /* NULL: none is kept */
    struct log_keeper *keeper;       /* NULL: the log is one file */
    int64_t part_bytes;              /* else its parts are that large, or a test larger */
    int64_t part_due_bytes;          /* of the part under way: the next is asked for */
    int part;                        /* the one under way, from 1, */
    char part_path[PATH_MAX];        /* and its path; "" for the first */
    bool over_quota;                 /* that was said */
    const char *config;
    struct bus *bus;                 /* NULL: nothing is sent */
    struct progress *progress;
    struct notify notify;            /* of a service: ready when settled, alive while cycles come,
                                      * stopping when put down to end */
    struct analysis analysis;
    struct estimator estimator;      /* method C of the tests so far, for the bus */
    bool estimate_due;               /* a test has ended since the last was begun */
    int64_t estimate_ns;             /* when it did, of the one under way; and
                                      * how many tests that has */
    int estimate_tests;
    _Atomic bool computes;           /* in between records: that may take longer
                                      * than RECORDER_PATIENCE_S */
    uint32_t request_id;             /* the last one told of */
    int64_t statistics_cycles;       /* between two HEXID_LOOP_STATS */
    int64_t settled_cycles;          /* in a row */
    uint32_t interlocks_wrong;       /* as it was last told (interlock.h) */
    struct error error;              /* first failure to write the log; status 0 while all is
                                      * well */
    pthread_t thread;
};

/* `config` is the effective configuration, first event of the log and of each of its parts; it must
 * outlive the recorder, which has no effect on the loop but through `loop->quit` and a park request
 * when the log cannot be written. */
int recorder_start(struct recorder *r, const char *config, struct error *error);

/* Waits for the last record, as long as records are taken or something is computed; given up
 * after RECORDER_PATIENCE_S without: false, and the recorder is in use by its thread until
 * the process ends. */
enum { RECORDER_PATIENCE_S = 3 };
bool recorder_join(struct recorder *r);

#endif
