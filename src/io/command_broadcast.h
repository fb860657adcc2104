/* A stop or park to several machines at once. SAFETY: one that hangs, or is too busy to be reached
 * at that moment, holds up no other: each is tried again, as long as the patience lasts, while
 * the answers of the others come in. Main thread; opens descriptors, and gives each back as soon as
 * its machine has answered. */
#ifndef HEXID_COMMAND_BROADCAST_H
#define HEXID_COMMAND_BROADCAST_H

#include "command_client.h"

/* One machine that is told. */
struct command_told {
    struct command_client client; /* begins with the machine, fd -1 and zeros */
    enum command_news news;       /* NEWS_NONE in the end: it has not answered */
    int unreached;                /* errno of why it could not be told, 0: it could */
};

/* Returns when all have answered or ended, or after so long. Connections are closed then. */
void command_broadcast(enum command command, struct command_told *told, int count, int patience_ms);

#endif
