/* The parsed command line of `hexid command`, and messages shared by its two files: moving commands
 * go to one machine (cmd_command.c), stop and park to all (command_stop.h). Main thread. */
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
    sigset_t during_waits; /* signal mask during waits for an answer, in which signals can arrive */
    struct machine_name *found; /* machines that were found; room for MACHINES_MAX */
};

/* Reports that no answer came: the daemon has ended, regularly or not, or it hangs. `may_move`:
 * the supply was on according to the last answer, or that is not known. `also`: a sentence to
 * append. STATUS_OK if the daemon has ended with the supply off. */
int report_silent(const struct command_client *c, enum command_news news, bool may_move, const char *also, struct error *error);

/* Reports that no such machine was found, and where it was looked for. Returns STATUS_IO. */
int report_nobody(const struct asked *q, const struct error *doubt, const char *also, struct error *error);

/* Lists in `names` the first machines of q->found, as many as fit: "hexid (/run/hexid), hexid-2
 * (/run/hexid)". */
void report_names(const struct asked *q, int count, char names[NAMES_SIZE]);

#endif
