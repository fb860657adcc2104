#include "outputs.h"

#include <dirent.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "csv_format.h"
#include "params.h"
#include "recognise.h"

enum { READ_MAX = OPERANDS_MAX + LOGS_MAX + 5, WRITTEN_MAX = 6 };

struct file {
    const char *what;        /* option that gives the name, "--json", or description of an input */
    const char *name;
    char text[PATH_MAX];     /* last component of the path after links were followed; "": there is
                              * none */
    struct stat state;
    bool there, in_place;    /* the file exists; it is written in place (output_place()) */
    char folder[PATH_MAX];   /* directory of the path */
    const char *last; /* last component of the path: `text` */
};

struct use {
    struct file read[READ_MAX], written[WRITTEN_MAX];
    int reads, writes;
};

static void look(struct file *f, const char *what, const char *name) {
    char place[PATH_MAX];
    *f = (struct file){.what = what, .name = name};
    f->there = !stat(name, &f->state);
    if (output_place(name, place, &f->in_place)) *place = '\0';
    const char *slash = strrchr(place, '/');
    snprintf(f->folder, sizeof f->folder, "%.*s", slash ? (int)(slash - place) + 1 : 2, slash ? place : "./");
    snprintf(f->text, sizeof f->text, "%s", slash ? slash + 1 : place);
    f->last = f->text;
}

static void reads(struct use *u, const char *what, const char *name) {
    if (name && u->reads < READ_MAX) look(&u->read[u->reads++], what, name);
}

static void writes(struct use *u, const char *option, const char *name) {
    if (name && *name && u->writes < WRITTEN_MAX) look(&u->written[u->writes++], option, strcmp(name, "-") ? name : "/dev/stdout");
}

static bool same_file(const struct stat *a, const struct stat *b) { return a->st_dev == b->st_dev && a->st_ino == b->st_ino; }

/* Returns true for a file or pipe, which two writers would spoil; a device or terminal may have
 * several writers. */
static bool holds_data(const struct file *f) { return S_ISREG(f->state.st_mode) || S_ISFIFO(f->state.st_mode); }

static bool same(const struct file *a, const struct file *b) {
    struct stat here, there;
    if (a->there != b->there) return false;
    if (a->there) return holds_data(a) && same_file(&a->state, &b->state);
    if (!*a->last) return false; /* a path such as `dir/` names a directory, never a file */
    return !strcmp(a->last, b->last) && !stat(a->folder, &here) && !stat(b->folder, &there) && same_file(&here, &there);
}

/* Returns true if the output is also an input: one of the CSV files, or the config.yaml, of this
 * input directory. `name` gets its path there. */
static bool is_in(const struct file *written, const struct file *directory, char *name, size_t size) {
    struct dirent **files;
    struct stat s;
    bool found = false;
    if (!written->there || !directory->there || !S_ISDIR(directory->state.st_mode)) return false;
    int count = csv_list(directory->name, &files);
    for (int i = 0; i <= count && !found; i++) {
        snprintf(name, size, "%.2000s/%.300s", directory->name, i < count ? files[i]->d_name : "config.yaml");
        found = !stat(name, &s) && same_file(&s, &written->state);
    }
    csv_list_free(files, count);
    return found;
}

static int check_reads(const struct use *u, const struct file *written, struct error *error) {
    char inside[PATH_MAX];
    for (const struct file *r = u->read; r < u->read + u->reads; r++) {
        const char *name = same(written, r) ? r->name : is_in(written, r, inside, sizeof inside) ? inside : NULL;
        if (name)
            return error_set(error, STATUS_USAGE, "%s %.200s: is %s, %.200s; name another file", written->what, written->name, r->what,
                             name);
    }
    return STATUS_OK;
}

/* Returns true if a is gap.json in the directory -o, and b the file of --json: they may be one
 * file, because they have the same content. */
static bool alike(const struct file *a, const struct file *b) {
    return a->what[1] == 'o' && !strcmp(b->what, "--json") && !strcmp(a->last, "gap.json");
}

static int check_writes(const struct use *u, int written, struct error *error) {
    const struct file *a = &u->written[written];
    for (const struct file *b = u->written; b < a; b++)
        if (same(a, b) && !alike(a, b) && !alike(b, a))
            return error_set(error, STATUS_USAGE, "%s %.200s and %s %.200s: are one file; name two", b->what, b->name, a->what, a->name);
    return STATUS_OK;
}

/* Checks standard output as well: it may be redirected to an input or to another option's file. An
 * option that writes in place, as to /dev/stdout, names that file on purpose and is allowed. */
static int check_printed(const struct use *u, struct error *error) {
    struct file out;
    look(&out, "standard output", "/dev/stdout");
    if (!out.there || !S_ISREG(out.state.st_mode)) return STATUS_OK;
    int status = check_reads(u, &out, error);
    for (const struct file *w = u->written; !status && w < u->written + u->writes; w++)
        if (!w->in_place && same(w, &out))
            status = error_set(error, STATUS_USAGE, "%s %.200s: is where standard output goes; name another file", w->what, w->name);
    return status;
}

static void note_reads(struct use *u, const struct options *o, const struct params *params, char installed[PATH_MAX]) {
    reads(u, "the configuration that is read", o->config ? o->config : options_default_config(installed));
    for (int i = 0; i < o->operands; i++) reads(u, "one of the logs that are read", o->operand[i]);
    for (int i = 0; i < o->measured_count; i++) reads(u, "one of the logs that are read", o->measured[i]);
    reads(u, "the log of --validate, which is read", o->validate);
    reads(u, "the baseline that is read", o->baseline);
    reads(u, "the simulated machine's configuration", o->hal ? options_machine_file(o->hal) : NULL);
    if (params && params->tests.trajectory[0]) reads(u, "the trajectory that is read", params->tests.trajectory);
}

static void note_writes(struct use *u, const struct options *o, enum outputs_kind kind, char names[3][PATH_MAX]) {
    static const char *const model[] = {"model.yaml", "gap.json", "report.html"};
    writes(u, "--json", o->json);
    if (kind == OUTPUTS_LOG) writes(u, "--log", o->log);
    else if (kind == OUTPUTS_PAGE || kind == OUTPUTS_FILE) writes(u, o->model ? "--model" : "-o", o->output);
    for (int i = 0; i < 3 && kind == OUTPUTS_MODEL; i++) {
        snprintf(names[i], PATH_MAX, "%.4000s/%s", o->output, model[i]);
        writes(u, "-o", names[i]);
    }
}

/* Refuses a directory that contains recordings, and names one of them. */
static int check_directory(const struct options *o, enum outputs_kind kind, struct error *error) {
    char name[NAME_MAX + 1];
    const char *found = recognise_in(o->output, kind == OUTPUTS_MODEL, name, sizeof name);
    if (!found) return STATUS_OK;
    return error_set(error, STATUS_USAGE, "-o %.200s: has recordings in it, %.200s is %s; name a directory of its own", o->output, name,
                     found);
}

int outputs_open(const struct options *o, const struct params *params, enum outputs_kind kind, struct output *json, struct output *page,
                 struct error *error) {
    struct use *u = calloc(1, sizeof *u);
    char names[3][PATH_MAX], installed[PATH_MAX];
    if (!u) return error_set(error, STATUS_IO, "out of memory");
    note_reads(u, o, params, installed);
    note_writes(u, o, kind, names);
    int status = check_printed(u, error);
    for (int i = 0; i < u->writes && !status; i++) {
        status = check_reads(u, &u->written[i], error);
        if (!status) status = check_writes(u, i, error);
    }
    free(u);
    if (!status && (kind == OUTPUTS_MODEL || kind == OUTPUTS_TESTS)) status = check_directory(o, kind, error);
    if (!status && page) status = output_prepare(page, kind == OUTPUTS_PAGE ? o->output : NULL, OUTPUT_RESULT, error);
    if (!status && json) status = output_prepare(json, o->json, OUTPUT_RESULT, error);
    return status;
}
