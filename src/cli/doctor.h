/* `hexid doctor`: questions about the configuration, this computer and the machine, one finding
 * each. The table of checks is in cmd_doctor.c: a new one is a function here and a row there.
 *
 *     FAIL   hexid cannot do its work like this, or somebody could be hurt
 *     WARN   it works worse than it should
 *     ?      this cannot be seen from here: in a container or virtual machine, without permission
 *
 * What is measured is judged by a function of its own (judge_...), which tests call at its limits.
 * Ordinary threads. Nothing is commanded: a machine, bus or daemon at work is not disturbed. */
#ifndef HEXID_DOCTOR_H
#define HEXID_DOCTOR_H

#include <jansson.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "params.h"
#include "status.h"

enum level { LEVEL_NONE /* does not apply to this configuration: not shown */, LEVEL_OK, LEVEL_UNKNOWN, LEVEL_WARN, LEVEL_FAIL };

struct finding {
    enum level level;
    char found[2000];  /* lines; the first stands beside the name */
    char remedy[400];  /* "" with LEVEL_OK */
    json_t *data;      /* numbers, units in their names; NULL: none. To be freed by who asked. */
};

struct doctor {
    const struct params *params;
    const char *config;     /* path, NULL: built in */
    const char *url;        /* of the machine, as for --hal, without the faults in front of it */
    const char *log;        /* --log, NULL: not given */
    const char *root;       /* stands before /proc and /sys; "" is this computer */
    double latency_s;       /* for how long wake-ups are measured, 0: not */
    bool machine;           /* that URL is no simulation: real time is required */
};

typedef struct finding doctor_check(const struct doctor *d);

/* ---- doctor.c ---- */

__attribute__((format(printf, 3, 4))) struct finding finding(enum level level, const char *remedy, const char *format, ...);
struct finding finding_none(void);

/* "cannot be seen here", with the file that is not there. */
struct finding finding_unseen(const char *path, const char *what);

/* LEVEL_FAIL for a real machine, which hexid then refuses to drive or should not; LEVEL_WARN for
 * the simulation, which runs all the same. */
enum level level_of_machine(const struct doctor *d);

/* False for a single axis: hexid reads its recordings and drives nothing. */
bool doctor_drives(const struct doctor *d);

/* What follows "can:" in the machine's URL, for scheme "can"; NULL when it begins otherwise. */
const char *doctor_address(const struct doctor *d, const char *scheme);

/* Reads a file below root as text, without its last newline. False where it is missing or empty. */
__attribute__((format(printf, 4, 5))) bool doctor_read(const struct doctor *d, char *text, size_t size, const char *path, ...);

/* Reads a file that is one whole number. */
__attribute__((format(printf, 3, 4))) bool doctor_number(const struct doctor *d, int64_t *value, const char *path, ...);

/* Is this processor in a list of the kernel's, such as "0-3,6"? */
bool doctor_listed(const char *list, int cpu);

/* The processors that are online and that the loop may run on (loop.cpu), in order. Returns how
 * many; 0: they cannot be seen, or loop.cpu is none of them. */
enum { PROCESSORS_MAX = 512 };
int doctor_processors(const struct doctor *d, int cpu[PROCESSORS_MAX]);

/* A text for JSON, which holds UTF-8 alone: line by line as it is printed. At most as long as
 * `found`. */
json_t *doctor_text(const char *text);

double doctor_now_s(void); /* CLOCK_MONOTONIC */

/* ---- doctor_machine.c: what is configured ---- */
doctor_check check_configuration, check_machine, check_kinematics, check_workspace, check_strokes, check_cylinders, check_payload,
    check_tests, check_blind_time, check_interlocks, check_loop, check_feed_forward, check_moves;

/* ---- doctor_limits.c: limits against what the machine can reach ---- */
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
/* before: a second earlier */
struct finding judge_can_errors(const char *interface, const struct can_controller *before, const struct can_controller *s);
enum { ROUND_TRIPS = 50 };
struct round_trips {
    double median_s, max_s;
    int lost;           /* of ROUND_TRIPS */
    bool owned;         /* another master has the machine */
};
struct finding judge_round_trips(const struct doctor *d, const struct round_trips *r);

/* ---- doctor_disk.c: where the log goes ---- */
struct disk {
    char directory[256];
    double room_bytes;      /* free for this user */
    double speed_bytes_per_s, longest_s; /* of writing to the disk; the longest that one write, or
                                          * the flush at the end, took */
};
doctor_check check_log_room, check_log_speed;
struct finding judge_log_room(const struct doctor *d, const struct disk *k);
struct finding judge_log_speed(const struct doctor *d, const struct disk *k);

/* What a log takes, headers included. */
double log_bytes_per_s(const struct params *params);

#endif
