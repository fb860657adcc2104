#include "combination.h"

#include "report_json.h"
#include "printable.h"

static json_t *log_json(const struct combination_log *log) {
    char path[1024];
    text_printable(log->path, path, sizeof path);
    return report_set(report_identification(log->id, log->verdicts, &log->loop), "log", json_string(path));
}

/* Returns a list for each value, by name, with one entry for each log: the deviation of the log's
 * value from that of the other logs, in standard deviations; null if the log's value is not
 * compared. */
static json_t *deviations(const struct agreement *a) {
    json_t *object = json_object();
    for (int i = 0; i < AGREEMENT_VALUES; i++) {
        char name[EQUATIONS_NAME];
        json_t *array = json_array();
        for (int l = 0; l < a->logs; l++) array = report_append(array, report_number(a->deviation[l][i]));
        equations_name(i, name);
        object = report_set(object, name, array);
    }
    return object;
}

static json_t *apart(const struct agreement *a) {
    json_t *array = json_array();
    for (int l = 0; l < a->logs; l++)
        for (int i = 0; i < AGREEMENT_VALUES; i++) {
            char name[EQUATIONS_NAME];
            equations_name(i, name);
            if (a->apart[l][i])
                array = report_append(
                    array, json_pack("{si ss so}", "log", l + 1, "value", name, "deviations", report_number(a->deviation[l][i])));
        }
    return array;
}

char *combination_json(const struct combination *c) {
    const struct agreement *a = &c->agreement;
    json_object_seed(1); /* a fixed seed keeps jansson from opening /dev/urandom */
    json_t *logs = json_array();
    for (int l = 0; l < c->logs; l++) logs = report_append(logs, log_json(&c->log[l]));
    json_t *agreement = report_set(report_set(report_agreement(a), "apart", apart(a)), "deviations", deviations(a));
    return report_text(json_pack("{ss so s{so} so so}", "schema", "hexid.identifications/1", "logs", logs, "combined", "method_c",
                                 report_method_c(&c->all, &c->common_gain, &c->method_c), "agreement", agreement, "verdict",
                                 report_verdict(&c->verdict)));
}
