#include "csv_propose.h"

#include <ctype.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

enum {
    WORDS = 32,
    SCORE_WORD = 100,
    SCORE_BEGINNING = 50,
    SCORE_UNIT = 60,
    SCORE_OTHER = 80,
    SCORE_LEAST = 1,
    LETTERS_LEAST = 3,
    LIST_MOST = 240
};

/* Words by which people name a channel, the clearest first. */
struct target {
    int column;
    const char *word[WORDS];
};

static const struct target targets[] = {
    {CSV_T, {"time", "timestamp", "zeit", "elapsed", "seconds", "t", "sec", "stamp", "temps", "tempo", "tid"}},
    {CSV_POSITION_COLUMN, {"position", "pos",   "displacement", "disp",   "stroke",     "extension", "weg",   "hub",
                           "travel",   "angle", "winkel",       "lvdt",   "encoder",    "theta",     "q",     "qm",
                           "q1",       "x",     "crosshead",    "length", "deflection", "velocity",  "speed", "geschwindigkeit",
                           "vel",      "d"}},
    {CSV_FORCE_COLUMN,
     {"force", "load", "kraft", "torque", "loadcell", "last", "moment", "drehmoment", "tau", "effort", "f", "fx", "fz", "axial", "current",
      "strom", "curr", "i"}},
    {CSV_P1_COLUMN, {"p1", "pa", "pressure1", "pressurea", "bore", "cap", "kolbenseite", "head", "pressure", "druck"}},
    {CSV_P2_COLUMN, {"p2", "pb", "pressure2", "pressureb", "rod", "ringseite", "stangenseite", "pressure", "druck"}},
    {CSV_POSITION_COLUMN + 1, {"reference", "ref", "setpoint", "desired", "target", "soll", "sollwert", "des", "demand"}},
};
enum { TARGETS = sizeof targets / sizeof *targets };

/* Words for a channel that is commanded or derived, not measured. */
static const char *const others[] = {"reference", "ref",     "setpoint", "desired",     "target", "soll",    "des", "error", "err",
                                     "cmd",       "command", "demand",   "temperature", "temp",   "desired", "max", "min"};

/* Reads the next word of letters and digits, in lower case. Returns false at the end. A capital
 * within a word begins another word (LoadCell). */
static bool next_word(const char **text, char word[32]) {
    size_t used = 0;
    while (**text && !isalnum((unsigned char)**text)) ++*text;
    for (; isalnum((unsigned char)**text) && used < 31; ++*text) {
        bool capital = used && isupper((unsigned char)**text) && islower((unsigned char)(*text)[-1]);
        if (capital) break;
        word[used++] = (char)tolower((unsigned char)**text);
    }
    word[used] = '\0';
    return used > 0;
}

static int word_score(const struct target *target, const char *word) {
    int best = 0;
    for (int i = 0; i < WORDS && target->word[i]; i++) {
        size_t length = strlen(target->word[i]);
        int score = !strcmp(word, target->word[i])                                       ? SCORE_WORD - i
                    : length >= LETTERS_LEAST && !strncmp(word, target->word[i], length) ? SCORE_BEGINNING - i
                                                                                         : 0;
        if (score > best) best = score;
    }
    return best;
}

static bool is_other(const char *word) {
    for (size_t i = 0; i < sizeof others / sizeof *others; i++)
        if (!strcmp(word, others[i]) || (strlen(others[i]) > 4 && !strncmp(word, others[i], strlen(others[i])))) return true;
    return false;
}

/* Returns true if the unit of a column is known, from its name or from the line of units. *wrong
 * returns whether the unit stated there is one that the quantity cannot have. */
static bool has_unit(const struct csv_reader *r, int cell, enum csv_quantity quantity, bool *wrong) {
    struct csv_unit unit;
    enum csv_named_unit named = csv_unit_of(r->name[cell], quantity, &unit);
    bool line = named == CSV_UNIT_NONE && *r->unit[cell] && csv_unit_known(r->unit[cell]);
    bool suits = line && csv_unit_parse(r->unit[cell], quantity, &unit);
    *wrong = named == CSV_UNIT_WRONG || (line && !suits);
    return named == CSV_UNIT_FOUND || suits;
}

static int score_of(const struct csv_reader *r, int cell, const struct target *target) {
    const char *text = r->name[cell];
    char word[32];
    int best = 0, less = 0;
    bool wrong, measured = target->column != CSV_T && target->column != CSV_POSITION_COLUMN + 1;
    while (next_word(&text, word)) {
        int score = word_score(target, word);
        if (score > best) best = score;
        if (measured && is_other(word)) less = SCORE_OTHER;
    }
    bool unit = has_unit(r, cell, csv_columns[target->column].quantity, &wrong);
    if (best == 0 || wrong) return 0;
    return best - less + (unit ? SCORE_UNIT : 0);
}

/* Returns the column, among those not taken yet, whose name and unit fit the target best; -1: none.
 * The time must rise; if no name fits it, the first column that rises is taken. */
static int find(const struct csv_reader *r, const struct target *target, const bool taken[CSV_CELLS_MAX]) {
    int best = -1, most = SCORE_LEAST - 1, rising = -1;
    bool time = target->column == CSV_T;
    for (int i = 0; i < r->cells; i++) {
        bool fits = r->cell[i].column < 0 && !taken[i] && (!time || r->head.rising[i]);
        int score = fits ? score_of(r, i, target) : 0;
        if (score > most) best = i, most = score;
        if (fits && time && rising < 0) rising = i;
    }
    return best < 0 ? rising : best;
}

/* Returns true if --map can give the column by its name: a printable one that no other column has.
 * Only columns of time may share a name, as several clocks. */
static bool is_plain(const struct csv_reader *r, int column, int cell) {
    const char *name = r->name[cell];
    for (int i = 0; i < r->cells && column != CSV_T; i++)
        if (i != cell && !strcmp(name, r->name[i])) return false;
    for (const char *c = name; *c; c++)
        if (strchr(",=:'#", *c) || !isprint((unsigned char)*c)) return false;
    return *name && strlen(name) < CSV_CELL_NAME - 1;
}

static void add(const struct csv_reader *r, int column, int cell, char text[CSV_PROPOSED_SIZE]) {
    char name[CSV_CELL_NAME];
    bool wrong, unit = has_unit(r, cell, csv_columns[column].quantity, &wrong);
    size_t used = strlen(text);
    if (is_plain(r, column, cell)) snprintf(name, sizeof name, "%s", r->name[cell]);
    else snprintf(name, sizeof name, "#%d", cell + 1);
    snprintf(text + used, CSV_PROPOSED_SIZE - used, "%s%.*s=%s%s", used ? "," : "", csv_stem(column), csv_columns[column].name, name,
             unit ? "" : ":?");
}

/* Lists the names of the columns that hexid does not know. */
static void list_names(const struct csv_reader *r, char text[CSV_PROPOSED_SIZE]) {
    for (int i = 0; i < r->cells; i++) {
        size_t used = strlen(text);
        if (r->cell[i].column < 0 && used + CSV_CELL_NAME + 4 < CSV_PROPOSED_SIZE)
            snprintf(text + used, CSV_PROPOSED_SIZE - used, "%s%.40s", used ? ", " : "", r->name[i]);
    }
}

static void add_unknown(int column, char text[CSV_PROPOSED_SIZE]) {
    size_t used = strlen(text);
    snprintf(text + used, CSV_PROPOSED_SIZE - used, "%s%.*s=?", used ? "," : "", csv_stem(column), csv_columns[column].name);
}

void csv_propose(const struct csv_reader *r, char text[CSV_PROPOSED_SIZE]) {
    bool taken[CSV_CELLS_MAX] = {false}, found[CSV_COLUMNS] = {false};
    char list[CSV_PROPOSED_SIZE] = "", names[CSV_PROPOSED_SIZE] = "";
    text[0] = '\0';
    for (int i = CSV_T + 1; i < CSV_FLAGS_COLUMN; i++)
        if (r->head.has[i]) return;
    for (int i = 0; i < TARGETS; i++) {
        const struct target *t = &targets[i];
        int cell = r->head.has[t->column] ? -1 : find(r, t, taken);
        found[t->column] = cell >= 0 || r->head.has[t->column];
        bool needed = t->column == CSV_POSITION_COLUMN;
        if (cell >= 0) taken[cell] = true, add(r, t->column, cell, list);
        else if (t->column == CSV_T && !found[CSV_T]) snprintf(list, sizeof list, "t=#0:? ms");
        else if (needed && !found[t->column]) add_unknown(t->column, list);
    }
    if (!found[CSV_FORCE_COLUMN] && !found[CSV_P1_COLUMN]) add_unknown(CSV_FORCE_COLUMN, list);
    list_names(r, names);
    if (strlen(list) > LIST_MOST) return; /* a map that is cut would be a wrong one */
    snprintf(text, CSV_PROPOSED_SIZE, "--map '%s'%s%s%.160s", list, strchr(list, '?') ? ", with the column or unit for each ?" : "",
             *names ? "; columns: " : "", names);
}
