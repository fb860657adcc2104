/* The subcommands and what `--help` says of them. The manual pages (config/manual.awk) and the
 * completion of the shell (config/hexid.bash) are made of these texts: an option stands in a line
 * of its own, after two blanks. */
#ifndef HEXID_HELP_H
#define HEXID_HELP_H

#include "cli.h"

struct subcommand {
    const char *name, *usage, *purpose;
    const char *options; /* lines; "%s" stands for the back-ends' URLs */
    const char *example; /* a command */
    int (*run)(int argc, char **argv);
};

/* NULL: there is none of this name. */
const struct subcommand *help_find(const char *name);

/* The name that a misspelt one may stand for, NULL where none is near. */
const char *help_nearest(const char *name);

void help_print(const struct subcommand *s);
void help_print_all(FILE *out);

#endif
