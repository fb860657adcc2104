/* The recorder: an ordinary thread, the only reader of the loop's ring. It writes every cycle to
 * the log, sends the stream over LCM, feeds the identification and reports to the terminal; method
 * C takes longer and runs in an estimator (estimator.h). The order of the messages is fixed: a
 * result directly follows the cycle that completed it, and repeating a run in virtual time gives
 * the same log. */
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
    struct log_writer *log;          /* NULL: there is no log */
    struct log_keeper *keeper;       /* process that makes the log's parts; NULL: the log is one
                                      * file */
    int64_t part_bytes;              /* size at which a part of the log ends; a part may grow to
                                      * twice that size, so that no test is split */
    int64_t part_due_bytes;        /* size of the current part at which the next part is
                                    * requested */
    int part;                        /* number of the current part, from 1 */
    char part_path[PATH_MAX];        /* path of the current part; "" for the first part */
    bool over_quota;                 /* the logs exceed the quota, and this has been reported */
    const char *config;              /* the effective configuration, as text */
    char *changed;                   /* configuration with changed gains, to which `config` points
                                      * then; NULL: the gains were not changed */
    struct bus *bus;                 /* LCM bus; NULL: there is none */
    struct progress *progress;
    const char *loop_says;           /* changes of the gains that gains_check() proposes if a margin
                                      * is missed; "": none */
    char gains_say[400];             /* present gains that differ from the configuration's, with
                                      * the configuration's values; "": none */
    struct notify notify;            /* messages to a service manager: READY when settled, WATCHDOG
                                      * while cycles come, STOPPING when the loop is to end */
    struct analysis analysis;
    struct estimator estimator;      /* runs method C on the tests completed so far, for
                                      * HEXID_METHOD_C messages */
    bool estimate_due;               /* a test has ended since the last estimate began */
    int64_t estimate_ns;             /* time of the last cycle before the current estimate was
                                      * started */
    int estimate_tests; /* number of tests in the current estimate; 0: no estimate is running */
    _Atomic bool computes;     /* the recorder is computing something that may take longer than
                                * RECORDER_PATIENCE_S */
    int64_t statistics_cycles;       /* number of cycles between HEXID_LOOP_STATS messages */
    int64_t settled_cycles;          /* number of consecutive cycles in STATE_SETTLED */
    uint32_t interlocks_wrong;       /* interlocks that were last reported as wrong (interlock.h) */
    int64_t checked_ns, asked_ns;    /* times of the last check of the log and of the last
                                      * request for a part */
    char device[200];                /* last reported condition of the connection to the machine */
    struct error error;              /* first failure to write the log; status 0: none */
    struct error keeper_error;       /* error if the keeper has ended or hangs; status 0: it
                                      * works */
    struct error unattended;         /* first report, while the platform was up, that the thread
                                      * that takes stops was held up (loop_attend()); status 0:
                                      * there was none */
    pthread_t thread;
};

/* Returns the capacity of the ring between loop and recorder: the cycles of at least
 * RECORDER_RING_S, rounded up to a power of two. A disk may stall for that long before records are
 * lost. */
#define RECORDER_RING_S 16.0
uint64_t recorder_ring_cycles(const struct params *params);

/* Starts the recorder. `config` is the effective configuration, which becomes the first event of
 * the log and of each of its parts; the text must outlive the recorder. If the log cannot be
 * written, the recorder calls loop_quit(), which parks the platform; on the real clock it affects
 * the loop in no other way. Returns -2 or -3 on an error. */
int recorder_start(struct recorder *r, const char *config, struct error *error);

/* Waits for the end of the recorder's thread and returns true. If for RECORDER_PATIENCE_S no record
 * is taken and nothing is computed, it returns false; the thread then keeps using the recorder
 * until the process ends. */
enum { RECORDER_PATIENCE_S = 3 };
bool recorder_join(struct recorder *r);

#endif
