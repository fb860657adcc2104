/* The blind time of a configuration: the longest that the machine can move without a living
 * controller, from the instant at which the controller is gone, or has nothing to go by, to centred
 * valves. One failure at a time; what that failure breaks is counted, what else would have to break
 * with it is not. Symbols:
 *
 *     T  loop.period_s          A  limits.sensor_age_s     B  limits.bad_cycles
 *     N  loop.overrun_limit     W  device.watchdog_s
 *     t  1 ms: a device looks at its watchdog so often
 *
 * Transport. A command may be under way for A. CAN: command, SYNC and readings travel together, and
 * readings older than A are faults (platform.c, too_old()). Modbus: a command that has waited for A
 * is not sent (modbus.c, due_command()), and no answer is waited for longer (timeout_s()).
 *
 * dead: the daemon is killed or stopped. Its last command reaches the device within A, the device
 * goes on with it for W (can_node.c, expired(); device.c, centre_ns) and looks every t.
 *     A + W + t
 *
 * deaf: readings no longer come, commands still go. The last ones are acted upon until they are
 * older than A, then its command is held for B cycles (supervisor_judge()) and the valves are
 * centred (loop.c, safe()); that command is under way for A. The age is looked at once a cycle.
 *     A + (B + 1) T + A
 * Commands that cannot be written are bad samples at once (loop.c, unwritten), and
 * no more than dead.
 *
 * late: the loop is away and comes back. Up to N - 1 deadlines missed in a row it goes on as if
 * nothing had been, with the step of the command that this makes; the Nth is a fault in its first
 * cycle (platform.c, count_overruns()). That cycle's command is under way for A. The device's
 * watchdog may be the shorter one, but what comes back does not know that.
 *     (N + 1) T + A
 *
 * mute: CAN only. Commands of some legs do not arrive. Their nodes centre after W and say so (EMCY)
 * within t; that makes bad samples of the next ones, and the other legs are centred after B cycles,
 * in force with the SYNC of the next.
 *     W + t + (B + 2) T
 *
 * can.heartbeat_s is in none of them: a node or a daemon that is gone is missed
 * by its PDOs first. */
#ifndef HEXID_BLIND_TIME_H
#define HEXID_BLIND_TIME_H

#include "params.h"

struct blind_time {
    double s;
    const char *when;   /* "the daemon is killed or stopped" */
    const char *sum;    /* the keys that it is made of:
                         * "limits.sensor_age_s + device.watchdog_s + 1 ms" */
    bool allowed;       /* by limits.blind_time_s */
};

/* The longest of the four. */
struct blind_time blind_time(const struct params *params);

#endif
