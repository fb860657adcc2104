#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "cli.h"
#include "help.h"
#include "process.h"
#include "version.h"

static bool asks_for_help(const char *word) { return !strcmp(word, "--help") || !strcmp(word, "-h") || !strcmp(word, "help"); }

static int unknown(const char *name) {
    const char *nearest = help_nearest(name);
    if (nearest) cli_say(stderr, "hexid: no such subcommand: %s; did you mean %s? `hexid --help` lists them", name, nearest);
    else cli_say(stderr, "hexid: no such subcommand: %s; `hexid --help` lists them", name);
    return -STATUS_USAGE;
}

/* SAFETY: runs a subcommand. `hexid command` skips process_limits(), because a stop must work even
 * if the process's limits are too low for other subcommands. */
static int run(const struct subcommand *s, int argc, char **argv) {
    struct error error;
    if (s->run != cmd_command && process_limits(&error)) return cli_fail(&error);
    return s->run(argc, argv);
}

/* Returns the exit status. If standard output did not take all of the text, as on a full disk,
 * EXIT_PASSED becomes the status of STATUS_IO. A pipe, socket or terminal whose reader has gone is
 * no failure, because such a reader wants no more. */
static int flushed(int status) {
    struct stat to;
    errno = 0;
    bool written = !fflush(stdout) && !ferror(stdout);
    if (written || fstat(STDOUT_FILENO, &to) || S_ISFIFO(to.st_mode) || S_ISSOCK(to.st_mode)) return status;
    if (S_ISCHR(to.st_mode) && errno != ENOSPC) return status;
    cli_say(stderr, "hexid: standard output did not take all of the text%s%s; free the disk, or name another place", errno ? ": " : "",
            errno ? strerror(errno) : "");
    return status == EXIT_PASSED ? -STATUS_IO : status;
}

static int start(int argc, char **argv) {
    struct error error;
    if (process_start(&error)) return cli_fail(&error);
    if (argc < 2) {
        help_print_all(stderr);
        return -STATUS_USAGE;
    }
    if (!strcmp(argv[1], "--version")) {
        printf("hexid %s\n", version);
        return EXIT_PASSED;
    }
    bool help = asks_for_help(argv[1]);
    if (help && argc < 3) {
        help_print_all(stdout);
        return EXIT_PASSED;
    }
    const struct subcommand *s = help_find(argv[help ? 2 : 1]);
    if (!s) return unknown(argv[help ? 2 : 1]);
    help |= argc > 2 && (!strcmp(argv[2], "--help") || !strcmp(argv[2], "-h"));
    if (!help) return run(s, argc - 1, argv + 1);
    help_print(s);
    return EXIT_PASSED;
}

int main(int argc, char **argv) { return flushed(start(argc, argv)); }
