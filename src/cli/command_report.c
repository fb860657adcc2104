#include "command_report.h"

#include "supervisor.h"

int report_silent(const struct command_client *c, enum command_news news, bool may_move, const char *also, struct error *error) {
    const char *name = c->machine.name, *state = c->answered ? state_names[c->answer.state] : "not known";
    const char *alarm = may_move ? ALARM : "";
    if (news == NEWS_LEFT && !supervisor_powers(c->answer.state)) {
        printf("hexid: %s has ended; the platform is %s\n", name, state);
        return STATUS_OK;
    }
    if (news == NEWS_LEFT) return error_set(error, STATUS_IO, "%s has ended; its last state was %s." ALARM, name, state);
    if (news == NEWS_LOST) return error_set(error, STATUS_IO, "%s ended without a word; its last state: %s.%s%s", name, state, also, alarm);
    return error_set(error, STATUS_IO, "%s did not answer within %d ms: it hangs, or is not given the processor.%s%s", name, ANSWER_MS,
                     also, alarm);
}

int report_nobody(const struct asked *q, const struct error *doubt, const char *also, struct error *error) {
    char places[300];
    machine_places(places, sizeof places);
    return error_set(error, STATUS_IO,
                     "command %s: nobody answered: no hexid%s%s is found in %s%s%.200s: is one running, and started by this user, root "
                     "or the service?%s",
                     q->word, *q->name ? " of the name " : "", q->name, places, doubt->status ? "; " : "", doubt->status ? doubt->text : "",
                     also);
}

void report_names(const struct asked *q, int count, char names[NAMES_SIZE]) {
    size_t used = 0;
    for (int i = 0; i < count && used < NAMES_SIZE; i++)
        used += (size_t)snprintf(names + used, NAMES_SIZE - used, "%s%s (%s)", i ? ", " : "", q->found[i].name, q->found[i].directory);
}
