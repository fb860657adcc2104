/* The blind time of a configuration: the longest time that the machine can move without a working
 * controller, from the moment at which the controller dies or loses its inputs until the valves are
 * centred. One failure is assumed: its consequences count, a second independent failure does not.
 * Symbols:
 *
 *     T  loop.period_s          A  limits.sensor_age_s     B  limits.bad_cycles
 *     N  loop.overrun_limit     W  device.watchdog_s
 *     t  1 ms: interval at which a device checks its watchdog
 *
 * Transport. A command takes at most A to arrive. CAN: command, SYNC and readings travel together,
 * and readings older than A are faults (platform.c, judge_common()). Modbus: hexid does not send a
 * command that has waited for A (modbus.c, due_command()), and waits for an answer no longer than A
 * (timeout_s()).
 *
 * dead: the daemon is killed or stopped. Its last command reaches the device within A; the device
 * holds that command for W (can_node.c, expired(); device.c, centre_ns) and checks W every t.
 *     A + W + t
 *
 * deaf: readings no longer arrive, but commands are still sent. The last readings are used until
 * they are older than A; then the command is held for B cycles (supervisor_judge()), and the valves
 * are centred (loop_cycle() calls the back-end's safe()) by a command that takes up to A to arrive.
 * The age is checked once a cycle.
 *     A + (B + 1) T + A
 * Commands that cannot be written count as bad samples at once (loop.c, unwritten), and the valves
 * are then centred no later than in "dead".
 *
 * late: the loop stops for a while and comes back. After up to N - 1 deadlines missed in a row it
 * continues, and its command jumps; with N it finds a fault in the first cycle after the stop
 * (platform.c, count_overruns()). That cycle's command takes up to A to arrive. The device's
 * watchdog may be shorter, but is not counted, because the returning loop does not know whether it
 * has expired.
 *     (N + 1) T + A
 *
 * mute: CAN only. Commands of some legs do not arrive. The nodes of these legs centre their valves
 * after W and report it (EMCY) within t. From then on samples are bad, and the other legs are
 * centred after B cycles, with effect from the next SYNC.
 *     W + t + (B + 2) T
 *
 * can.heartbeat_s is in none of the sums, because missing PDOs reveal a lost node or daemon earlier
 * than missing heartbeats do. */
#ifndef HEXID_BLIND_TIME_H
#define HEXID_BLIND_TIME_H

#include <stdbool.h>

struct params;

struct blind_time {
    double s;
    const char *when;   /* description of the case: "a daemon that is killed or stopped" */
    const char *sum;    /* the sum, with its configuration keys: "limits.sensor_age_s +
                         * device.watchdog_s + 1 ms" */
    bool allowed;       /* the time is within limits.blind_time_s */
};

/* Returns the longest of the four cases. */
struct blind_time blind_time(const struct params *params);

#endif
