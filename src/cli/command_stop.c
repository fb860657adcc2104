#include "command_stop.h"

#include <stdlib.h>
#include <string.h>

#include "bus.h"
#include "cli.h"
#include "command_broadcast.h"
#include "messages.h"

enum { LCM_TRIES = 3, ALSO_SIZE = 200 };

/* Sends stop or park over LCM, too, which carries no answers. Returns a sentence about the outcome;
 * "" if no LCM bus is configured. */
static const char *by_lcm(const struct asked *q) {
    struct error error;
    struct bus *bus;
    unsigned char buffer[COMMAND_MESSAGE_MAX];
    int size = command_encode(q->command, 0, buffer), sent = 0;
    if (!*q->url) return "";
    if (bus_open(&bus, q->url, &error)) return " LCM cannot be used either.";
    for (int i = 0; i < LCM_TRIES; i++) sent += !bus_publish(bus, CHANNEL_COMMAND, buffer, size);
    bus_close(bus);
    return sent ? " It was sent over LCM, too, where nothing answers." : " LCM did not take it either.";
}

static int report_one(const struct command_told *t, const struct asked *q, bool several, const char *also) {
    const struct command_client *c = &t->client;
    const struct command_answer *a = &c->answer;
    struct error error = {0};
    if (t->news == NEWS_ANSWER && a->outcome != OUTCOME_REFUSED) {
        printf("hexid: %s%s%s done, now %s%s%s\n", several ? c->machine.name : "", several ? ": " : "", q->word, state_names[a->state],
               *a->text ? ": " : "", a->text);
        return STATUS_OK;
    }
    if (t->news == NEWS_ANSWER) error_set(&error, STATUS_UNSAFE, "%s: %s refused: %s", c->machine.name, q->word, a->text);
    else if (t->unreached)
        error_set(&error, STATUS_IO, "%s in %s could not be told to %s: %s.%s" ALARM " there", c->machine.name, c->machine.directory,
                  q->word, strerror(t->unreached), also);
    else report_silent(c, t->news, true, also, &error);
    if (error.status) cli_fail(&error);
    return error.status;
}

/* SAFETY: reports that machines may not have been found. Such a machine may still move, so the exit
 * status must not suggest that all are stopped. */
static int report_missed(const struct asked *q, const struct error *doubt, const char *also, struct error *error) {
    return error_set(error, STATUS_IO, "another machine may be there, which was not told to %s: %.400s.%s" ALARM " there", q->word,
                     doubt->text, also);
}

static int stop_found(const struct asked *q, int count, const struct error *doubt, struct error *error) {
    struct command_told *told = calloc((size_t)count, sizeof *told);
    bool all_meant = !*q->name, silent = all_meant && doubt->status;
    int worst = STATUS_OK;
    if (!told) return error_set(error, STATUS_IO, "command %s: out of memory.%s" ALARM, q->word, by_lcm(q));
    for (int i = 0; i < count; i++) told[i].client = (struct command_client){.machine = q->found[i], .fd = -1};
    command_broadcast(q->command, told, count, ANSWER_MS);
    for (int i = 0; i < count; i++) silent |= told[i].news == NEWS_NONE || told[i].news == NEWS_LOST;
    const char *also = silent ? by_lcm(q) : "";
    for (int i = 0; i < count; i++) {
        int status = report_one(&told[i], q, count > 1, also);
        /* a missing answer is worse than a refusal */
        if (status && (!worst || status > worst)) worst = status;
    }
    free(told);
    return all_meant && doubt->status ? report_missed(q, doubt, also, error) : worst;
}

/* SAFETY: reports that no machine was found. If other machines run on this host, but not the named
 * one, nothing is stopped, and nothing goes over LCM: a script may stop one of several machines
 * after that machine has ended, while the others carry people. The message lists the machines and
 * the command that stops all of them. If no other machine runs, the command still goes over LCM. */
static int stop_nobody(const struct asked *q, const struct error *doubt, struct error *error) {
    struct error other_doubt;
    char names[NAMES_SIZE], also[ALSO_SIZE];
    /* SAFETY: if a directory could not be searched, the socket of the named machine may be in it,
     * so the command goes over LCM and the doubt is reported. */
    int others = *q->name && !doubt->status ? machine_find("", q->found, &other_doubt) : 0;
    if (others == 0) {
        snprintf(also, sizeof also, "%s" ALARM, by_lcm(q));
        return report_nobody(q, doubt, also, error);
    }
    report_names(q, others, names);
    return error_set(error, STATUS_IO,
                     "command %s: nobody has the name %s: nothing was stopped. On this host %s: %s. `hexid command %s --set "
                     "machine.name=` goes to all." ALARM,
                     q->word, q->name, others > 1 ? "run" : "runs", names, q->word);
}

int command_stop(const struct asked *q, struct error *error) {
    struct error doubt;
    int count = machine_find(q->name, q->found, &doubt);
    return count > 0 ? stop_found(q, count, &doubt, error) : stop_nobody(q, &doubt, error);
}
