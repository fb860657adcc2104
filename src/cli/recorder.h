/* The recorder: the only ordinary thread that reads the loop's ring. It writes every cycle to
 * the log, sends the stream over LCM, feeds the identifier and reports to the terminal; an
 * estimator runs method C, which takes longer (estimator.h). The order is fixed: the log of a
 * virtual-time run is the same every time, and a result always directly follows the cycle that
 * completed it. */
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
    struct log_writer *log;          /* writer of the log; NULL: there is no log */
    struct log_keeper *keeper;       /* NULL: the log is one file */
    int64_t part_bytes;              /* size at which a part ends; it may reach twice that, so as
                                      * not to split a test */
    int64_t part_due_bytes;        /* size of the current part at which the next one is requested */
    int part;                        /* number of the current part, from 1 */
    char part_path[PATH_MAX];        /* path of this part; "" for the first */
    bool over_quota;                 /* a warning has reported that the logs exceed the quota */
    const char *config;              /* the effective configuration, as text */
    char *changed;                   /* configuration with changed gains, to which `config` then
                                      * points; NULL: the gains are unchanged */
    struct bus *bus;                 /* LCM bus; NULL: there is none */
    struct progress *progress;
    const char *loop_says;           /* changes of the gains that gains_check() proposes because a
                                      * margin is missed; "": none */
    char gains_say[400];             /* present gains that differ from the configuration's, with
                                      * the configuration's values; "": none */
    struct notify notify;            /* for a service manager: ready when settled, life signs
                                      * while cycles come, stopping when the loop is to quit */
    struct analysis analysis;
    struct estimator estimator;      /* runs method C on the tests so far, for the bus */
    bool estimate_due;               /* a test has ended since the last estimate began */
    int64_t estimate_ns;             /* time of the last cycle when the current estimate began */
    int estimate_tests; /* number of tests in the current estimate; 0: none */
    _Atomic bool computes;     /* the recorder is computing, which may take longer than
                                * RECORDER_PATIENCE_S */
    uint32_t request_id;             /* id of the last request reported */
    int64_t statistics_cycles;       /* number of cycles between HEXID_LOOP_STATS messages */
    int64_t settled_cycles;          /* number of consecutive cycles in STATE_SETTLED */
    uint32_t interlocks_wrong;       /* interlocks reported last as wrong (interlock.h) */
    int64_t checked_ns, asked_ns;    /* times of the last check of the log and of the last
                                      * request for a part */
    char device[200];                /* last reported condition of the connection to the machine */
    struct error error;              /* first failure to write the log; status 0: none */
    struct error keeper_error;       /* error of the keeper when it has ended or hangs; status 0: it
                                      * works */
    struct error unattended;         /* report that the loop parked because nobody took stops;
                                      * status 0: it did not */
    pthread_t thread;
};

/* Returns the number of cycles that the ring before the recorder holds while a disk stalls: those
 * of RECORDER_RING_S, as a power of two. */
#define RECORDER_RING_S 16.0
uint64_t recorder_ring_cycles(const struct params *params);

/* Starts the recorder. `config` is the effective configuration, which becomes the first event of
 * the log and of each of its parts; it must outlive the recorder. If the log cannot be written, the
 * recorder calls loop_quit(), which parks; otherwise it does not affect the loop. Returns -2 or -3
 * on an error. */
int recorder_start(struct recorder *r, const char *config, struct error *error);

/* Waits for the last record, as long as records are taken or something is computed; after
 * RECORDER_PATIENCE_S without either it returns false, and the thread keeps using the recorder
 * until the process ends. */
enum { RECORDER_PATIENCE_S = 3 };
bool recorder_join(struct recorder *r);

#endif
