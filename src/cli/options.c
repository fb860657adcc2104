#include <errno.h>
#include <fcntl.h>
#include <getopt.h>
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "bus.h"
#include "cli.h"
#include "config.h"
#include "edit_distance.h"
#include "log_runs.h"
#include "params.h"
#include "printable.h"

/* range of --std, in % of sqrt(Mii Mjj); from 20 % on method C would call the entry undetermined */
static const double STD_LEAST_PCT = 0.01, STD_MOST_PCT = 10.0;

static const struct option long_options[] = {
    {"config", required_argument, NULL, 'c'},
    {"hal", required_argument, NULL, 'H'},
    {"fast", no_argument, NULL, 'f'},
    {"rt", required_argument, NULL, 'r'},
    {"seed", required_argument, NULL, 's'},
    {"log", required_argument, NULL, 'l'},
    {"json", required_argument, NULL, 'j'},
    {"set", required_argument, NULL, 'S'},
    {"tests", required_argument, NULL, 't'},
    {"print-config", no_argument, NULL, 'p'},
    {"output", required_argument, NULL, 'o'},
    {"format", required_argument, NULL, 'F'},
    {"bus", required_argument, NULL, 'b'},
    {"modbus-map", no_argument, NULL, 'm'},
    {"failures", no_argument, NULL, 'x'},
    {"refusals", no_argument, NULL, 'e'},
    {"keys", no_argument, NULL, 'k'},
    {"measured", required_argument, NULL, 'M'},
    {"validate", required_argument, NULL, 'v'},
    {"replay", required_argument, NULL, 'R'},
    {"log-quota", required_argument, NULL, 'q'},
    {"log-part", required_argument, NULL, 'g'},
    {"map", required_argument, NULL, 'a'},
    {"trajectory", required_argument, NULL, 'T'},
    {"repeat", required_argument, NULL, 'n'},
    {"survey", no_argument, NULL, 'V'},
    {"qualify", no_argument, NULL, 'Q'},
    {"baseline", required_argument, NULL, 'z'},
    {"std", required_argument, NULL, 'd'},
    {"verbose", no_argument, NULL, 'B'},
    {"all", no_argument, NULL, 'A'},
    {"pose", required_argument, NULL, 'P'},
    {"weight", required_argument, NULL, 'w'},
    {"model", required_argument, NULL, 'O'},
    {"latency", required_argument, NULL, 'L'},
    {"http", required_argument, NULL, 'h'},
    {"machine", required_argument, NULL, 'N'},
    {"run", required_argument, NULL, 'U'},
    {"once", no_argument, NULL, '1'},
    {"json", no_argument, NULL, 'J'}, /* --json of `hexid monitor`, without a file: lines on
                                       * standard output */
    {0},
};

enum { LONG_OPTIONS = sizeof long_options / sizeof *long_options };

/* Copies long_options without the entry `kind`, because a subcommand has only one of the two kinds
 * of --json. */
static void leave_out(char kind, struct option own[LONG_OPTIONS]) {
    for (const struct option *o = long_options;; o++) {
        if (o->val != kind) *own++ = *o;
        if (!o->name) break;
    }
}

static int set_rt(struct options *o, const char *text, struct error *error) {
    static const char *const names[] = {[REALTIME_OFF] = "off", [REALTIME_TRY] = "try", [REALTIME_REQUIRE] = "require"};
    o->rt_given = true;
    for (int i = REALTIME_OFF; i <= REALTIME_REQUIRE; i++)
        if (!strcmp(text, names[i])) {
            o->rt = (enum realtime_mode)i;
            return STATUS_OK;
        }
    return error_set(error, STATUS_USAGE, "--rt %s: choose require, try or off", text);
}

static int set_seed(struct options *o, const char *text, struct error *error) {
    char *end;
    errno = 0;
    o->seed = strtoull(text, &end, 10);
    if (errno || *end || *text < '0' || *text > '9')
        return error_set(error, STATUS_USAGE, "--seed %s: not a number from 0 to 2^64-1", text);
    return STATUS_OK;
}

static int set_size(const char *option, const char *text, double *bytes, struct error *error) {
    static const double bytes_per_gb = 1e9, most_gb = 1e6;
    char *end;
    double gb = strtod(text, &end);
    if (end == text || *end || !(gb > 0.0 && gb <= most_gb))
        return error_set(error, STATUS_USAGE, "%s %.40s: not a number of gigabytes above 0, up to %.0f", option, text, most_gb);
    *bytes = gb * bytes_per_gb;
    return STATUS_OK;
}

/* Sets the size of a part of the log. It has a minimum, because each part repeats the
 * configuration. */
static int set_log_part(struct options *o, const char *text, struct error *error) {
    static const double least_bytes = 1e5;
    int status = set_size("--log-part", text, &o->log_part_bytes, error);
    if (status || o->log_part_bytes >= least_bytes) return status;
    return error_set(error, STATUS_USAGE, "--log-part %.40s: a part has at least 0.0001 GB: its configuration alone takes a sixth of that",
                     text);
}

static int add_setting(struct options *o, const char *text, struct error *error) {
    if (o->setting_count == SETTINGS_MAX) return error_set(error, STATUS_USAGE, "--set: at most %d settings; use a file", SETTINGS_MAX);
    o->settings[o->setting_count++] = text;
    return STATUS_OK;
}

static int add_measured(struct options *o, const char *path, struct error *error) {
    if (o->measured_count == LOGS_MAX)
        return error_set(error, STATUS_USAGE, "%.200s: one log too many, at most %d are taken", path, LOGS_MAX);
    o->measured[o->measured_count++] = path;
    return STATUS_OK;
}

int options_measured(struct options *o, struct error *error) {
    int status = STATUS_OK;
    for (int i = 0; i < o->operands && !status; i++) status = add_measured(o, o->operand[i], error);
    o->operands = 0;
    return status;
}

static int set_tests(struct options *o, const char *list, struct error *error) {
    if (snprintf(o->tests, sizeof o->tests, "tests.order=[%s]", list) >= (int)sizeof o->tests)
        return error_set(error, STATUS_USAGE, "--tests %s: name at most six of x,y,z,phi,theta,psi", list);
    return add_setting(o, o->tests, error);
}

static int set_trajectory(struct options *o, const char *path, struct error *error) {
    if (!*path) return error_set(error, STATUS_USAGE, "--trajectory: an empty name; name a CSV file");
    if (strlen(path) >= PARAMS_TEXT_SIZE)
        return error_set(error, STATUS_USAGE, "--trajectory %.80s...: a path of %d characters and more; name it from nearer by", path,
                         PARAMS_TEXT_SIZE);
    snprintf(o->trajectory, sizeof o->trajectory, "tests.trajectory=%s", path);
    return add_setting(o, o->trajectory, error);
}

static int set_repeat(struct options *o, const char *passes, struct error *error) {
    snprintf(o->repeat, sizeof o->repeat, "tests.repeat=%.40s", passes);
    return add_setting(o, o->repeat, error);
}

static int set_std(struct options *o, const char *text, struct error *error) {
    char *end;
    o->std_pct = strtod(text, &end);
    if (*end || end == text || !(o->std_pct >= STD_LEAST_PCT && o->std_pct <= STD_MOST_PCT))
        return error_set(error, STATUS_USAGE, "--std %.40s: a number of per cent from %g to %g", text, STD_LEAST_PCT, STD_MOST_PCT);
    return STATUS_OK;
}

static int set_run(struct options *o, const char *text, struct error *error) {
    char *end;
    long number = strtol(text, &end, 10);
    if (end == text || *end || number < 1 || number > LOG_RUNS_MAX)
        return error_set(error, STATUS_USAGE, "--run %.40s: the number of a run in the log, 1 to %d", text, LOG_RUNS_MAX);
    o->run = (int)number;
    return STATUS_OK;
}

static int set_latency(struct options *o, const char *text, struct error *error) {
    static const double most_s = 86400.0;
    char *end;
    o->latency_s = strtod(text, &end);
    if (end == text || *end || !(o->latency_s >= 0.0 && o->latency_s <= most_s))
        return error_set(error, STATUS_USAGE, "--latency %.40s: a number of seconds from 0, not at all, to %.0f", text, most_s);
    return STATUS_OK;
}

/* Takes "KG" or "KG,STD". */
static int set_weight(struct options *o, const char *text, struct error *error) {
    /* known: relative standard deviation of the weight if none is given */
    static const double most_kg = 1e5, known = 1e-3;
    char *end;
    o->weight_kg = strtod(text, &end);
    bool good = end != text && o->weight_kg > 0.0 && o->weight_kg <= most_kg;
    o->weight_std_kg = known * o->weight_kg;
    if (good && *end == ',') {
        const char *at = end + 1;
        o->weight_std_kg = strtod(at, &end);
        good = end != at && o->weight_std_kg >= 0.0 && o->weight_std_kg < o->weight_kg;
    }
    if (!good || *end)
        return error_set(error, STATUS_USAGE,
                         "--weight %.40s: the mass in kg, up to %g, and where it is known its standard deviation, as 100 or 100,0.05", text,
                         most_kg);
    return STATUS_OK;
}

static int set_pose(struct options *o, const char *text, struct error *error) {
    static const double most = 30.0; /* largest coordinate of a pose, m or rad */
    const char *at = text;
    o->pose_given = true;
    for (int i = 0; i < DOFS; i++) {
        char *end;
        o->pose[i] = strtod(at, &end);
        if (end == at || *end != (i + 1 < DOFS ? ',' : '\0') || !(fabs(o->pose[i]) <= most))
            return error_set(error, STATUS_USAGE, "--pose %.80s: six numbers x,y,z,phi,theta,psi in m and rad, as 0.1,0,-0.05,0,0.1,0",
                             text);
        at = end + 1;
    }
    return STATUS_OK;
}

static int take(struct options *o, int option, const char *value, struct error *error) {
    switch (option) {
    case 'c': o->config = value; return STATUS_OK;
    case 'H': o->hal = value; return STATUS_OK;
    case 'f': o->fast = true; return STATUS_OK;
    case 'l': o->log = value; return STATUS_OK;
    case 'j': o->json = value; return STATUS_OK;
    case 'b': o->bus = value; return STATUS_OK;
    case 'm': o->modbus_map = true; return STATUS_OK;
    case 'x': o->failures = true; return STATUS_OK;
    case 'e': o->refusals = true; return STATUS_OK;
    case 'k': o->keys = true; return STATUS_OK;
    case 'o': o->output = value; return STATUS_OK;
    case 'F': o->format = value; return STATUS_OK;
    case 'A': o->all = true; return STATUS_OK;
    case 'v': o->validate = value; return STATUS_OK;
    case 'R': o->replay = value; return STATUS_OK;
    case 'a': o->map = value; return STATUS_OK;
    case 'O': o->model = value; return STATUS_OK;
    case 'N': o->machine = value; return STATUS_OK;
    case 'p': o->print_config = true; return STATUS_OK;
    case 'V': o->survey = true; return STATUS_OK;
    case 'Q': o->qualify = true; return STATUS_OK;
    case 'z': o->baseline = value; return STATUS_OK;
    case 'B': o->verbose = true; return STATUS_OK;
    case 'h': o->http = value; return STATUS_OK;
    case '1': o->once = true; return STATUS_OK;
    case 'J': o->json_lines = true; return STATUS_OK;
    case 'd': return set_std(o, value, error);
    case 'P': return set_pose(o, value, error);
    case 'w': return set_weight(o, value, error);
    case 'L': return set_latency(o, value, error);
    case 'U': return set_run(o, value, error);
    case 'r': return set_rt(o, value, error);
    case 'q': return set_size("--log-quota", value, &o->log_quota_bytes, error);
    case 'g': return set_log_part(o, value, error);
    case 's': return set_seed(o, value, error);
    case 'T': return set_trajectory(o, value, error);
    case 'n': return set_repeat(o, value, error);
    case 'S': return add_setting(o, value, error);
    case 'M': return add_measured(o, value, error);
    default: return set_tests(o, value, error);
    }
}

/* Refuses an unknown option, and suggests the most similar option of the subcommand. */
static int unknown_option(const char *command, const char *name, const char *allowed, struct error *error) {
    const char *word = name + strspn(name, "-"), *nearest = NULL;
    int best = edit_distance_too_far(word);
    for (const struct option *o = long_options; o->name && strlen(word) > 1; o++) {
        int distance = strchr(allowed, o->val) ? edit_distance(word, o->name) : best;
        if (distance > best || (distance == best && nearest) || !strchr(allowed, o->val)) continue;
        best = distance;
        nearest = o->name;
    }
    return error_set(error, STATUS_USAGE, "`hexid %s` has no option %s%.100s; %s%s%ssee `hexid %s --help`", command,
                     *name == '-' ? "" : "--", name, nearest ? "did you mean --" : "", nearest ? nearest : "", nearest ? "? " : "",
                     command);
}

/* Returns the long name of an option, without dashes. */
static const char *name_of(const struct option *options, int option) {
    const struct option *o = options;
    while (o->name && o->val != option) o++;
    return o->name ? o->name : "";
}

int options_parse(struct options *o, int argc, char **argv, const char *allowed, int operands, struct error *error) {
    struct option own[LONG_OPTIONS];
    const char *given[128] = {NULL}; /* value of each option so far, by its letter */
    *o = (struct options){.hal = "sim:", .seed = 1, .latency_s = -1.0};
    leave_out(strchr(allowed, 'J') ? 'j' : 'J', own);
    opterr = 0;
    optind = 0;
    for (;;) {
        int index = -1, option = getopt_long(argc, argv, "+:c:o:", own, &index);
        if (option == -1 && optind < argc && strcmp(argv[optind - 1], "--") && o->operands < operands) {
            o->operand[o->operands++] = argv[optind++]; /* options may follow operands */
            continue;
        }
        if (option == -1) break;
        const char *name = argv[optind - 1];
        if (option == ':') return error_set(error, STATUS_USAGE, "%s needs a value; see `hexid %s --help`", name, argv[0]);
        if (option == '?' || !strchr(allowed, option)) return unknown_option(argv[0], index >= 0 ? own[index].name : name, allowed, error);
        /* A second file or weight is refused, because the first would be ignored without a message.
         * Most other options may be repeated, and the last value counts. SAFETY: `hexid command`
         * refuses no repetition, so that a stop is sent all the same. */
        bool twice = strchr("cljovaOzw", option) && given[option] && strcmp(argv[0], "command") != 0;
        if (twice)
            return error_set(error, STATUS_USAGE, "--%s: given twice, as %.80s and as %.80s; leave one out", name_of(own, option),
                             given[option], optarg);
        given[option] = optarg;
        int status = take(o, option, optarg, error);
        if (status) return status;
    }
    if (optind < argc && operands > 1)
        return error_set(error, STATUS_USAGE, "%s: one argument too many, `hexid %s` takes %d; see `hexid %s --help`", argv[optind],
                         argv[0], operands, argv[0]);
    if (optind < argc && !operands)
        return error_set(error, STATUS_USAGE, "%s: `hexid %s` takes nothing but options; see `hexid %s --help`", argv[optind], argv[0],
                         argv[0]);
    if (optind < argc) return error_set(error, STATUS_USAGE, "%s: one argument too many; see `hexid %s --help`", argv[optind], argv[0]);
    if (o->tests[0] && o->trajectory[0])
        return error_set(error, STATUS_USAGE, "--tests and --trajectory: one of them; a trajectory has its own axes");
    if (o->survey && o->trajectory[0])
        return error_set(error, STATUS_USAGE, "--survey and --trajectory: one of them; a survey has its own motion");
    if (o->qualify && (o->survey || o->trajectory[0] || o->tests[0]))
        return error_set(error, STATUS_USAGE, "--qualify and --%s: one of them; --qualify has its own motion",
                         o->survey          ? "survey"
                         : o->trajectory[0] ? "trajectory"
                                            : "tests");
    if (o->run && o->operands + o->measured_count != 1)
        return error_set(error, STATUS_USAGE, "--run: it says which run of a log is taken, so name one log");
    if (o->weight_kg > 0.0 && o->operands != 2)
        return error_set(error, STATUS_USAGE, "--weight: name two logs, without the weight and with it");
    if (o->std_pct > 0.0 && !o->survey)
        return error_set(error, STATUS_USAGE, "--std: the deviation that a test is proposed for; needs --survey");
    return STATUS_OK;
}

const char *options_default_config(char installed[PATH_MAX]) {
    static const char of_a_checkout[] = "config/tian2015.yaml";
    static const char *const from_the_program[] = {"/../etc/hexid/tian2015.yaml", "/../../etc/hexid/tian2015.yaml"};
    if (!access(of_a_checkout, R_OK)) return of_a_checkout;
    ssize_t length = readlink("/proc/self/exe", installed, PATH_MAX - sizeof "/../../etc/hexid/tian2015.yaml");
    if (length <= 0) return NULL;
    installed[length] = '\0';
    char *end = strrchr(installed, '/');
    for (size_t i = 0; end && i < sizeof from_the_program / sizeof *from_the_program; i++) {
        strcpy(end, from_the_program[i]);
        if (!access(installed, R_OK)) return installed;
    }
    return NULL;
}

int options_params(const struct options *o, struct params *params, struct error *error) {
    char installed[PATH_MAX];
    const char *path = o->config ? o->config : options_default_config(installed);
    return config_load(params, path, o->settings, o->setting_count, error);
}

const char *options_machine_file(const char *url) {
    static const char simulated[] = "sim:";
    const char *last = strrchr(url, ';'), *own = last ? last + 1 : url;
    size_t scheme = sizeof simulated - 1;
    return !strncmp(own, simulated, scheme) && own[scheme] ? own + scheme : NULL;
}

int options_machine(const char *url, const struct params *own, struct params *machine, struct error *error) {
    const char *file = options_machine_file(url);
    *machine = *own;
    int status = file ? config_load(machine, file, NULL, 0, error) : STATUS_OK;
    if (status || machine->loop.period_s == own->loop.period_s) return status;
    return error_set(error, STATUS_USAGE, "--hal sim:%.200s: its loop.period_s %g is not the controller's, %g: make them equal", file,
                     machine->loop.period_s, own->loop.period_s);
}

bool options_sets(const struct options *o, const char *key) { return config_sets(o->settings, o->setting_count, key); }

void cli_say_overruled(const char *path, const char *stated) {
    if (*stated) cli_say(stderr, "hexid: %.250s: --set is taken, not what a file states: %s", path, stated);
}

int options_bus(const struct options *o, struct params *params, struct bus **bus, struct error *error) {
    int status = options_params(o, params, error);
    if (status) return status;
    if (!params->lcm.url[0]) return error_set(error, STATUS_USAGE, "lcm.url is empty: this configuration has no LCM");
    return bus_open(bus, params->lcm.url, error);
}

void options_automatic(const struct options *o, bool simulated, struct params *params) {
    if (!simulated && !options_sets(o, "motion.automatic")) params->motion.automatic = false;
}

void cli_say(FILE *out, const char *format, ...) {
    char text[4000], printable[sizeof text];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    text_printable(text, printable, sizeof printable);
    fprintf(out, "%s\n", printable);
}

void cli_warn_cut(const char *path, int64_t offset) {
    cli_say(stderr, "hexid: warning: %s is cut off or damaged: read up to byte %lld", path, (long long)offset);
}

int cli_fail(const struct error *error) {
    cli_say(stderr, "hexid: %s", error->text);
    return -(int)error->status;
}
