/* `hexid doctor`: checks of the configuration, this computer and the machine, with one finding
 * each. The table of checks is in cmd_doctor.c: a new check needs a function that is declared here
 * and a row in that table.
 *
 *     FAIL   hexid cannot work like this, or somebody could be hurt
 *     WARN   it works worse than it should
 *     ?      cannot be determined from here: in a container or virtual machine, or not permitted
 *
 * Separate functions (judge_...) judge measured values, so that tests can call them with values at
 * the limits. Ordinary threads. No check commands anything, so that a working machine, bus or
 * daemon is not disturbed. */
#ifndef HEXID_DOCTOR_H
#define HEXID_DOCTOR_H

#include <jansson.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "gains_check.h"
#include "loop_check.h"
#include "status.h"

enum level { LEVEL_NONE /* does not apply to this configuration; not shown */, LEVEL_OK, LEVEL_UNKNOWN, LEVEL_WARN, LEVEL_FAIL };

struct finding {
    enum level level;
    char found[2000];  /* the finding, one or more lines; the first is printed beside the check's
                        * name */
    char remedy[400];  /* advice on what to do; "" with LEVEL_OK */
    json_t *data;    /* the values in `found` as JSON, with units in their names; NULL: none. The
                      * caller frees it. */
};

struct doctor {
    const struct params *params;
    const char *config;     /* path of the configuration; NULL: built in */
    const char *url;        /* the machine's URL, as for --hal, but without injected faults */
    const char *log;        /* argument of --log; NULL: it was not given */
    const char *root;       /* prefix of /proc and /sys; "" stands for this computer */
    double latency_s;       /* duration of the measurement of wake-ups; 0: none */
    bool machine;           /* the URL is that of a real machine, for which real time is required */
    const struct loop_check *loop; /* check of the closed loop for these parameters; NULL: each
                                    * check computes it */
    const struct gains_check *gains; /* margins of the configured gains; NULL: each check computes
                                      * them */
};

typedef struct finding doctor_check(const struct doctor *d);

/* ---- doctor.c ---- */

__attribute__((format(printf, 3, 4))) struct finding finding(enum level level, const char *remedy, const char *format, ...);
struct finding finding_none(void);

/* Returns a finding with LEVEL_UNKNOWN: `what` is not known, because the file `path` is missing. */
struct finding finding_unseen(const char *path, const char *what);

/* Returns the level of a serious weakness: LEVEL_FAIL for a real machine, which hexid then refuses
 * to drive or should not drive; LEVEL_WARN for the simulation, which runs all the same. */
enum level level_of_machine(const struct doctor *d);

/* Returns false for a machine of one axis, because hexid only reads its recordings. */
bool doctor_drives(const struct doctor *d);

/* Returns the check of the closed loop: d->loop, or computed here. */
struct loop_check doctor_loop(const struct doctor *d);

/* Returns the margins of the configured gains: d->gains, or computed here. */
struct gains_check doctor_gains(const struct doctor *d);

/* Returns the part of the machine's URL after the scheme and its colon; NULL if the URL has another
 * scheme. */
const char *doctor_address(const struct doctor *d, const char *scheme);

/* Reads a file below d->root as text, without trailing newlines and blanks. Returns false if it
 * cannot be opened or is empty. */
__attribute__((format(printf, 4, 5))) bool doctor_read(const struct doctor *d, char *text, size_t size, const char *path, ...);

/* Reads a file below d->root that contains one whole number and nothing else. Returns false if it
 * is missing or contains anything else. */
__attribute__((format(printf, 3, 4))) bool doctor_number(const struct doctor *d, int64_t *value, const char *path, ...);

/* Returns true if the processor is in a list in the kernel's format, such as "0-3,6". */
bool doctor_listed(const char *list, int cpu);

/* Lists the online processors on which the loop may run (loop.cpu), in order. Returns their number;
 * 0: unknown, or loop.cpu is not among them. */
enum { PROCESSORS_MAX = 512 };
int doctor_processors(const struct doctor *d, int cpu[PROCESSORS_MAX]);

/* Converts a text to a JSON string of valid UTF-8; each line becomes what cli_say() would print.
 * The text is at most as long as finding.found. */
json_t *doctor_text(const char *text);

double doctor_now_s(void); /* Returns the time of CLOCK_MONOTONIC, s. */

/* ---- doctor_machine.c: the configuration ---- */
doctor_check check_configuration, check_machine, check_kinematics, check_workspace, check_strokes, check_cylinders, check_payload,
    check_tests, check_blind_time, check_interlocks, check_loop, check_gains, check_feed_forward, check_moves;

/* ---- doctor_limits.c: limits against the machine's abilities ---- */
doctor_check check_limits;

/* ---- doctor_host.c: this computer ---- */
doctor_check check_kernel, check_hypervisor, check_realtime, check_locked_memory, check_governor, check_idle_states, check_isolation,
    check_siblings, check_throttling, check_clock_source;

/* ---- doctor_wakeup.c ---- */
struct wakeups;
doctor_check check_wakeups;
struct finding judge_wakeups(const struct doctor *d, const struct wakeups *w);

/* ---- doctor_lcm.c ---- */
doctor_check check_lcm_socket, check_lcm_route, check_lcm_datagram, check_lcm_buffers;

/* ---- doctor_field.c: the field buses ---- */
struct can_controller;
doctor_check check_can_load, check_can_interface, check_can_errors, check_modbus_line, check_modbus;
struct finding judge_can_interface(const struct doctor *d, const char *interface, const struct can_controller *s);
/* Judges error counters; `before` is the interface's state one second earlier. */
struct finding judge_can_errors(const char *interface, const struct can_controller *before, const struct can_controller *s);
enum { ROUND_TRIPS = 50 };
struct round_trips {
    double median_s, max_s;
    int lost;           /* number of lost requests out of ROUND_TRIPS */
    bool owned;         /* another master owns the machine */
};
struct finding judge_round_trips(const struct doctor *d, const struct round_trips *r);

/* ---- doctor_disk.c: the log's disk ---- */
struct disk {
    char directory[256];
    double room_bytes;      /* free space that this user may use */
    double speed_bytes_per_s, longest_s; /* speed of writing to the disk; longest duration of
                                          * writing and flushing one block */
};
doctor_check check_log_room, check_log_speed;
struct finding judge_log_room(const struct doctor *d, const struct disk *k);
struct finding judge_log_speed(const struct doctor *d, const struct disk *k);

/* Returns the growth of a log in bytes per second, headers included. Only the cycles' messages
 * count; they are nearly the whole log. */
double log_bytes_per_s(const struct params *params);

#endif
