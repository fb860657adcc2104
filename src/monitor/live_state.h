/* State behind the live page: messages of a running hexid, received over LCM, as JSON ready to
 * send. It has the newest message of each kind, the last events, and the cycles of the last 20 s.
 * Memory is bounded whatever arrives: a message larger than any of hexid's is counted and dropped.
 * One thread. */
#ifndef HEXID_LIVE_STATE_H
#define HEXID_LIVE_STATE_H

#include "bus.h"
#include "failure.h"
#include "json_text.h"
#include "kinematics.h"

enum { LIVE_CYCLES = 1024, LIVE_EVENTS = 64, LIVE_MESSAGE_MAX = 16384 };

/* Places of the page. Each shows a message until the next message of its kind replaces it. The
 * place of a test's result is LIVE_TEST plus the test's index in the list of tests. */
enum live_place { LIVE_FAULT, LIVE_LOOP_STATS, LIVE_METHOD_C, LIVE_IDENTIFICATION, LIVE_GAP, LIVE_TEST, LIVE_PLACES = LIVE_TEST + DOFS };
extern const char *const live_place_names[LIVE_PLACES]; /* names of the places: the type of the
                                                         * message, or "fault" */

struct live_state {
    const struct params *params;
    struct kinematics kinematics;
    struct json_text machine;     /* the machine as the configuration describes it; never changes */

    struct live_fault {
        bool there;
        uint64_t seq;                    /* number of the cycle that reported the fault */
        uint32_t legs;                   /* legs of the fault, one bit each */
        char name[FAULT_TEXT_SIZE], measured[FAULT_MEASURE_SIZE], cause[FAILURE_TEXT_SIZE], remedy[FAILURE_TEXT_SIZE];
    } fault;
    struct cycle newest;
    bool heard;                          /* `newest` is valid */
    int64_t heard_ms, kept_ns; /* heard_ms: time at which `newest` arrived; kept_ns: time stamp of
                                * the newest entry of `cycle` */
    int64_t run;                         /* number of the current run, counted from 1 with each
                                          * start of hexid that was noticed */
    int64_t step;                    /* smallest number of cycles from one HEXID_STATE message to
                                      * the next in this run, which is taken for lcm.state_every; 0:
                                      * not known yet */
    int64_t messages, lost, dropped;     /* messages, lost: numbers of HEXID_STATE messages received
                                          * and missing in this run. dropped: number of messages in
                                          * all runs that were invalid, too large, or for no place
                                          * of the page */

    struct json_text cycle[LIVE_CYCLES]; /* ring buffer: entry number n, counted from 1, is cycle[n
                                          * % LIVE_CYCLES] */
    struct json_text event[LIVE_EVENTS]; /* ring buffer: entry number n, counted from 1, is event[n
                                          * % LIVE_EVENTS] */
    uint64_t cycles, events;             /* numbers of cycles and events kept so far, including
                                          * those overwritten */
    struct json_text place[LIVE_PLACES]; /* JSON of each place; empty: nothing to show */
    uint64_t version[LIVE_PLACES]; /* number of times that each place has changed */
};

/* Prepares the state; `params` must outlive it. Returns -2 for a geometry that cannot be drawn, -3
 * without memory. */
int live_state_init(struct live_state *s, const struct params *params, struct error *error);
void live_state_free(struct live_state *s);

/* Takes one message. now_ms: any monotonic clock. */
void live_state_take(struct live_state *s, const struct bus_message *message, int64_t now_ms);

/* Writes {"run", "messages", "lost", "dropped", "silence_s", "misfit_m"}. silence_s is the time
 * since the newest cycle arrived; null before the first cycle. misfit_m is the largest difference
 * between the measured lengths and those that the pose implies under this configuration; a large
 * value means that the configuration is another machine's. misfit_m is 0 for a single axis, before
 * the first cycle, and for a cycle with flags or faults. */
void live_state_health(const struct live_state *s, int64_t now_ms, struct json_text *json);

#endif
