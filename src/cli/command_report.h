/* What `hexid command` was asked for, and the messages that both of its ways share: what moves goes
 * to one machine (cmd_command.c), stop and park go to all (command_stop.h). Main thread. */
#ifndef HEXID_COMMAND_REPORT_H
#define HEXID_COMMAND_REPORT_H

#include <signal.h>

#include "command_client.h"

enum { ANSWER_MS = 1000, NAMES_SIZE = 500 };
#define ALARM " THE PLATFORM MAY STILL MOVE: press the emergency stop"

/* The command line, read: which command, for which machine, by which ways. */
struct asked {
    enum command command;
    const char *word;      /* its name */
    const char *name;      /* of the machine, "": none was named */
    const char *url;       /* of LCM, "": none */
    sigset_t during_waits; /* the mask with which it waits for signals, too */
    struct machine *found; /* room for MACHINES_MAX */
};

/* Reports that no answer came: the daemon has ended, in good order or not, or it hangs.
 * `may_move` is true if the supply was on when it was last heard of, or if that is not known.
 * `also` is a sentence behind it. STATUS_OK if it has ended with the supply off. */
int report_silent(const struct command_client *c, enum command_news news, bool may_move, const char *also, struct error *error);

/* Reports that no such machine is found, and where it was looked for. STATUS_IO. */
int report_nobody(const struct asked *q, const struct error *doubt, const char *also, struct error *error);

/* "hexid (/run/hexid), hexid-2 (/run/hexid)": the first machines of q->found, as many as there is
 * room for. */
void report_names(const struct asked *q, int count, char names[NAMES_SIZE]);

#endif
