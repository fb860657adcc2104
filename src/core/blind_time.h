/* The blind time of a configuration: the longest time that the machine can move without a working
 * controller, from the moment at which the controller dies or loses its inputs until the valves are
 * centred. Single failures are assumed; consequences of the failure count, independent further
 * failures do not. Symbols:
 *
 *     T  loop.period_s          A  limits.sensor_age_s     B  limits.bad_cycles
 *     N  loop.overrun_limit     W  device.watchdog_s
 *     t  1 ms: interval at which a device checks its watchdog
 *
 * Transport. A command may be under way for A. CAN: command, SYNC and readings travel together, and
 * readings older than A are faults (platform.c, judge_common()). Modbus: a command that has waited
 * for A is not sent (modbus.c, due_command()), and no answer is waited for longer (timeout_s()).
 *
 * dead: the daemon is killed or stopped. Its last command reaches the device within A; the device
 * holds it for W (can_node.c, expired(); device.c, centre_ns) and checks every t.
 *     A + W + t
 *
 * deaf: readings no longer come, but commands still go. The last readings are used until they are
 * older than A; then the command is held for B cycles (supervisor_judge()) and the valves are
 * centred (loop_cycle() calls the back-end's safe()) by a command that is under way for A. The age
 * is checked once a cycle.
 *     A + (B + 1) T + A
 * Commands that cannot be written count as bad samples at once (loop.c, unwritten), and the valves
 * are then centred no later than in "dead".
 *
 * late: the loop stops for a while and comes back. After up to N - 1 deadlines missed in a row it
 * goes on, and the command jumps; the Nth is a fault in its first cycle (platform.c,
 * count_overruns()). That cycle's command is under way for A. The device's watchdog may be shorter,
 * but is not counted, since the returning loop does not know that it has expired.
 *     (N + 1) T + A
 *
 * mute: CAN only. Commands of some legs do not arrive. Their nodes centre after W and report it
 * (EMCY) within t; the following samples are bad, and the other legs are centred after B cycles,
 * effective with the next SYNC.
 *     W + t + (B + 2) T
 *
 * can.heartbeat_s is in none of the sums: a lost node or daemon is noticed by its missing PDOs
 * first. */
#ifndef HEXID_BLIND_TIME_H
#define HEXID_BLIND_TIME_H

#include <stdbool.h>

struct params;

struct blind_time {
    double s;
    const char *when;   /* the case in words: "a daemon that is killed or stopped" */
    const char *sum;    /* the sum in words, by its keys: "limits.sensor_age_s + device.watchdog_s +
                         * 1 ms" */
    bool allowed;       /* the time is within limits.blind_time_s */
};

/* Returns the longest of the four cases. */
struct blind_time blind_time(const struct params *params);

#endif
