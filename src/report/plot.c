#include "plot.h"

#include <errno.h>
#include <fcntl.h>
#include <spawn.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

static const char remedy[] = "pictures need gnuplot (apt-get install gnuplot-nox)";

const char *const plot_colours[PLOT_COLOURS] = {PICTURE_ACCENT, "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9"};

static const char style[] = "set encoding utf8\n"
                            "set border 3 lc rgb '#777777'\n"
                            "set tics nomirror out scale 0.5 tc rgb '#444444'\n"
                            "set grid lc rgb '#e8e8e8' lt 1 lw 0.6\n"
                            "set key outside top center horizontal samplen 2.5 spacing 1 tc rgb '#444444'\n"
                            "set style line 1 lc rgb '#1a1a1a' lw 2.4\n"
                            "set style line 2 lc rgb '#8a8a8a' lw 2.2 dt (6,4)\n"
                            "set style line 3 lc rgb '" PICTURE_ACCENT "' lw 1.8\n";

void plot_begin(FILE *script, int width, int height) {
    fprintf(script, "set terminal svg noenhanced size %d,%d font 'sans-serif,12' background '#ffffff'\n%s", width, height, style);
}

void plot_axes(FILE *script, const char *x, const char *y) {
    fprintf(script, "set ylabel '%s' offset 1\n", y);
    if (x) fprintf(script, "set xlabel '%s' offset 0,0.5\n", x);
}

void plot_panels(FILE *script, double left, double x_from, double x_to) {
    fprintf(script, "set multiplot\nset lmargin at screen %g\nset rmargin at screen 0.98\nset xrange [%.7g:%.7g]\n", left, x_from, x_to);
}

void plot_panel(FILE *script, double top, double bottom, const char *x, const char *y) {
    fprintf(script, "set tmargin at screen %.5f\nset bmargin at screen %.5f\nset format x '%s'\n", top, bottom, x ? "%g" : "");
    plot_axes(script, x, y);
}

/* Files in memory for all three streams, so that no pipe can fill and nothing is left on disk. */
struct child_files {
    int in, out, err;
};

static bool files_open(struct child_files *f, const char *script, size_t size) {
    f->in = memfd_create("script", MFD_CLOEXEC);
    f->out = memfd_create("picture", MFD_CLOEXEC);
    f->err = memfd_create("errors", MFD_CLOEXEC);
    if (f->in < 0 || f->out < 0 || f->err < 0) return false;
    return write(f->in, script, size) == (ssize_t)size && lseek(f->in, 0, SEEK_SET) == 0;
}

static void files_close(const struct child_files *f) {
    if (f->in >= 0) close(f->in);
    if (f->out >= 0) close(f->out);
    if (f->err >= 0) close(f->err);
}

/* Runs gnuplot. Returns gnuplot's exit status, 128 plus the number of the signal that ended it, or
 * -1 with errno if gnuplot could not be started. */
static int run(const struct child_files *f) {
    char *argv[] = {"gnuplot", "-d", NULL}; /* -d: ignores the user's own settings */
    posix_spawn_file_actions_t actions;
    pid_t child;
    int status;
    if (posix_spawn_file_actions_init(&actions)) return -1;
    posix_spawn_file_actions_adddup2(&actions, f->in, STDIN_FILENO);
    posix_spawn_file_actions_adddup2(&actions, f->out, STDOUT_FILENO);
    posix_spawn_file_actions_adddup2(&actions, f->err, STDERR_FILENO);
    errno = posix_spawnp(&child, argv[0], &actions, NULL, argv, environ);
    posix_spawn_file_actions_destroy(&actions);
    if (errno) return -1;
    while (waitpid(child, &status, 0) < 0)
        if (errno != EINTR) return -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

static char *contents(int file, size_t *size) {
    struct stat s;
    char *text = fstat(file, &s) ? NULL : malloc((size_t)s.st_size + 1);
    if (!text) return NULL;
    ssize_t got = pread(file, text, (size_t)s.st_size, 0);
    *size = got > 0 ? (size_t)got : 0;
    text[*size] = '\0';
    return text;
}

/* Reports gnuplot's own error message, in one line. */
static void complain(int status, int file, struct error *error) {
    size_t size;
    char *said = contents(file, &size);
    for (char *c = said; c && *c; c++)
        if ((unsigned char)*c < ' ') *c = ' ';
    error_set(error, STATUS_IO, "%s; gnuplot ended with status %d:%.250s", remedy, status, said && *said ? said : " no picture");
    free(said);
}

/* Removes empty groups, which gnuplot leaves at every change of style; they make up a quarter of a
 * picture's size. */
static void drop_empty_groups(char *svg, size_t *size) {
    char *to = svg;
    for (const char *from = svg; *from;) {
        const char *inside = !strncmp(from, "<g ", 3) ? strchr(from, '>') : NULL;
        const char *end = inside ? inside + 1 + strspn(inside + 1, " \t\n") : NULL;
        if (end && !strncmp(end, "</g>", 4)) from = end + 4 + strspn(end + 4, " \t\n");
        else *to++ = *from++;
    }
    *to = '\0';
    *size = (size_t)(to - svg);
}

int plot_draw(const char *script, size_t script_size, char **svg, size_t *size, struct error *error) {
    struct child_files f = {-1, -1, -1};
    *svg = NULL;
    if (!files_open(&f, script, script_size)) error_set(error, STATUS_IO, "gnuplot: no room for its script: %s", strerror(errno));
    else {
        int status = run(&f);
        if (status < 0) error_set(error, STATUS_IO, "%s: %s", remedy, strerror(errno));
        else if (status || !(*svg = contents(f.out, size)) || !strstr(*svg, "</svg>")) {
            complain(status, f.err, error);
            free(*svg);
            *svg = NULL;
        } else drop_empty_groups(*svg, size);
    }
    files_close(&f);
    return *svg ? STATUS_OK : STATUS_IO;
}
