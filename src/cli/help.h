/* The subcommands and their texts for `--help`. The manual pages (config/manual.awk) and the
 * shell's completion (config/hexid.bash) are generated from these texts: each option starts a
 * line, after two blanks. */
#ifndef HEXID_HELP_H
#define HEXID_HELP_H

#include "cli.h"

struct subcommand {
    const char *name, *usage, *purpose;
    const char *options; /* text of the options, in lines; "%s" stands for the back-ends' URLs */
    const char *example; /* a command as an example */
    int (*run)(int argc, char **argv);
};

/* Returns the subcommand of this name; NULL: there is none. */
const struct subcommand *help_find(const char *name);

/* Returns the name of the subcommand that is most similar to a misspelt one; NULL if none is
 * similar. */
const char *help_nearest(const char *name);

void help_print(const struct subcommand *s);
void help_print_all(FILE *out);

#endif
