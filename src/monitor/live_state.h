/* What the live page shows of a hexid that is heard over LCM, ready to be sent: the newest message
 * of each kind, the last events, the cycles of the last 20 s, each as JSON. Bounded, whatever
 * comes: a message larger than any of hexid's is counted and dropped. One thread. */
#ifndef HEXID_LIVE_STATE_H
#define HEXID_LIVE_STATE_H

#include "bus.h"
#include "failure.h"
#include "json_text.h"
#include "kinematics.h"
#include "params.h"

enum { LIVE_CYCLES = 1024, LIVE_EVENTS = 64, LIVE_MESSAGE_MAX = 16384 };

/* Places for what is shown until the next of its kind replaces it; a test's is its place in
 * the list of tests. */
enum live_place { LIVE_FAULT, LIVE_LOOP_STATS, LIVE_METHOD_C, LIVE_IDENTIFICATION, LIVE_GAP, LIVE_TEST, LIVE_PLACES = LIVE_TEST + DOFS };
extern const char *const live_place_names[LIVE_PLACES]; /* the type of the message, "fault" */

struct live_state {
    const struct params *params;
    struct kinematics kinematics;
    struct json_text machine;            /* what the configuration says; never changes */

    struct live_fault {
        bool there;
        uint64_t seq;                    /* of the cycle that it was told of */
        uint32_t legs;                   /* a bit each */
        char name[FAULT_TEXT_SIZE], measured[FAULT_MEASURE_SIZE], cause[FAILURE_TEXT_SIZE], remedy[FAILURE_TEXT_SIZE];
    } fault;
    struct cycle newest;
    bool heard;                          /* newest is one */
    int64_t heard_ms, kept_ns;           /* when the newest came; the time of the newest in
                                          * `cycle` */
    int64_t run;                         /* starts of a hexid that were noticed, 1 the first */
    int64_t step;                        /* cycles from one HEXID_STATE to the next */
    int64_t messages, lost, dropped;     /* HEXID_STATE that came and that are missing, in this run;
                                          * datagrams that were no message */

    struct json_text cycle[LIVE_CYCLES]; /* a ring: number n, from 1, is cycle[n % LIVE_CYCLES] */
    struct json_text event[LIVE_EVENTS]; /* likewise */
    uint64_t cycles, events;             /* so many were there, ever */
    struct json_text place[LIVE_PLACES];
    uint64_t version[LIVE_PLACES];       /* counts its changes; empty JSON:
                                          * nothing there (any more) */
};

/* `params` stays in use. -2: a geometry that cannot be drawn; -3: no memory. */
int live_state_init(struct live_state *s, const struct params *params, struct error *error);
void live_state_free(struct live_state *s);

/* now_ms: of any clock that does not stand still. */
void live_state_take(struct live_state *s, const struct bus_message *message, int64_t now_ms);

/* {"run", "messages", "lost", "dropped", "silence_s", "misfit_m"}: silence_s since the newest cycle
 * came, misfit_m by how much the lengths that its pose has in this configuration differ from its
 * own at most: much where the configuration is of another machine. */
void live_state_health(const struct live_state *s, int64_t now_ms, struct json_text *json);

#endif
