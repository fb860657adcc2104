/* The parsed command line of `hexid command`, and messages that its files share. Stop and park go
 * to the named machine or to all machines (command_stop.h), the other commands to one machine
 * (cmd_command.c, command_set.h). Main thread. */
#ifndef HEXID_COMMAND_REPORT_H
#define HEXID_COMMAND_REPORT_H

#include <signal.h>

#include "command_client.h"

struct params;

enum { ANSWER_MS = 1000, NAMES_SIZE = 500 };
#define ALARM " THE PLATFORM MAY STILL MOVE: press the emergency stop"

/* The parsed command line, and the machines that were found for it. */
struct asked {
    enum command command;
    const char *word;      /* name of the command */
    const char *name;      /* name of the machine; "": not given */
    const char *setting;   /* operand of `set`; NULL: there is none */
    const struct params *params; /* configuration of the command line */
    const char *url;       /* URL of the LCM bus; "": there is none */
    sigset_t during_waits; /* signal mask while the client waits to renew a lease, the only time at
                            * which it accepts signals */
    struct machine_name *found; /* machines that were found; room for MACHINES_MAX */
};

/* Reports why no answer came: the daemon has ended, regularly or not, or hangs. `may_move`: adds a
 * warning that the platform may still move. `also`: a sentence to append. Returns STATUS_OK if the
 * daemon has ended regularly with the supply off, else STATUS_IO. */
int report_silent(const struct command_client *c, enum command_news news, bool may_move, const char *also, struct error *error);

/* Reports that no such machine was found, and the directories that were searched. `doubt`: result
 * of machine_find(). `also`: a sentence to append. Returns STATUS_IO. */
int report_nobody(const struct asked *q, const struct error *doubt, const char *also, struct error *error);

/* Lists in `names` the first machines of q->found, as many as fit: "hexid (/run/hexid), hexid-2
 * (/run/hexid)". */
void report_names(const struct asked *q, int count, char names[NAMES_SIZE]);

#endif
