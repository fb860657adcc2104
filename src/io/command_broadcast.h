/* Sends a stop or park to several machines at once. SAFETY: a machine that hangs, or is too busy to
 * be reached at once, does not delay the others: it is tried again until patience_ms have passed,
 * and meanwhile the other machines' answers are received. Main thread; opens descriptors and closes
 * each as soon as its machine has answered. */
#ifndef HEXID_COMMAND_BROADCAST_H
#define HEXID_COMMAND_BROADCAST_H

#include "command_client.h"

/* A machine to which the command is sent. */
struct command_told {
    struct command_client client; /* initialised with the machine, fd -1 and zeros */
    enum command_news news;       /* news from the machine; at the end NEWS_NONE means no answer,
                                   * and NEWS_LOST that no daemon can be reached */
    int unreached;                /* errno if the last attempt to connect failed for a reason that
                                   * may pass, such as a full queue; else 0 */
};

/* Sends the command to all these machines. Returns when all have answered or ended, or after
 * patience_ms; closes all connections. */
void command_broadcast(enum command command, struct command_told *told, int count, int patience_ms);

#endif
