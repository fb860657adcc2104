#include "help.h"

#include <stdio.h>
#include <string.h>

#include "edit_distance.h"
#include "hal.h"

/* Options that several subcommands have. */
#define CONFIG "  -c FILE          configuration; without it config/tian2015.yaml here, else the installed one, else built in\n"
#define SET "  --set KEY=VALUE  one key of the configuration, e.g. tests.frequency_hz=5; `hexid doctor --keys` lists them\n"
#define SEED "  --seed N         of the simulated sensors' noise, 1 without it\n"
#define RT(defaults) "  --rt MODE        real time: require: nothing runs without SCHED_FIFO and locked memory; try: warn; off" \
    defaults "\n"
#define MAP "  --map LIST       columns by their own names: position=Weg:mm,t=Zeit:s,force=#3:85.2 N\n"

static const char run_options[] = CONFIG
    "  --hal URL        the platform, `sim:` without it:\n"
    "%s"
    "  --fast           virtual time, as fast as this machine can: same code, same seed, same bytes\n" RT(
        " (require on hardware, try on sim:)") SEED
    "  --log FILE|DIR   LCM event log of every cycle; in a directory a new file named by its number and its start\n"
    "  --log-quota GB   delete the oldest logs of earlier runs in the directory until all take no more, before the run and with each part\n"
    "  --log-part GB    go on in a new file, numbered, each so many GB, between two tests; each part is a log by itself\n"
    "  --json FILE      result, schema hexid.identification/1; - for standard output\n" SET
    "  --tests LIST     axes to test, e.g. x,theta\n"
    "  --trajectory FILE\n"
    "                   drive these poses instead: CSV with t_s and any of x_m, y_m, z_m, phi_rad, theta_rad, psi_rad\n"
    "  --repeat N       passes of the trajectory\n"
    "  --survey         drive a small multisine instead, and say: the lowest eigenfrequencies of oil columns and closed loop, whether the\n"
    "                   configured tests are below them and above the sensors' floor, and which tests would do\n"
    "  --std PCT        for this standard deviation of Mt's worst entry, in per cent of sqrt(Mii Mjj); 0.5 without it\n"
    "  --qualify        drive ten minutes of sines, slopes and steps, axis by axis, instead: hexid qualify measures its log\n"
    "  --verbose        print all of the result at the end, as hexid identify does, instead of ten lines\n"
    "  --print-config   show the effective configuration and end\n";

static const char gap_options[] =
    "  LOG              of the rig; several logs of one machine are fitted together (--measured LOG is the same)\n"
    "  -c FILE          the model: configuration, its effects taken as given\n"
    "  -o DIR           model.yaml (the model with what was found), gap.json, report.html\n"
    "  --run N          of a log that holds several runs of the daemon: take this one\n"
    "  --validate LOG   before and after are judged on this log, which no fit has seen, instead of on held-out cycles\n"
    "  --replay MODE    closed-loop: the proof is a simulation of the loop; motion: the equations under the measured motion\n"
    "                   alone; by itself closed-loop, but motion for one axis, any motion, and logs without references,\n"
    "                   pressures or valve commands\n"
    "  --json FILE      gap.json, schema hexid.gap/1, there too; - for standard output\n" SET
    "\nexit status 0 whatever the verdict is: it stands in gap.json\n";

static const char check_options[] =
    "  DIR|CSV|LOG      a log, several of one machine, or CSV files as `hexid import` reads them\n"
    "  --run N          of a log that holds several runs of the daemon: take this one\n"
    "  -c FILE          configuration, but for a log's own tests; without it all is the log's own, for CSV what `hexid run` takes\n" SET MAP
    "  -o PAGE.html     the signals over time, one file for any browser\n"
    "  --json FILE      the same facts, schema hexid.check/1; - for standard output\n"
    "\nexit status 0 when hexid gap would take it, 1 when not: the last line has its refusal\n";

static const char doctor_options[] = CONFIG
    "  --hal URL        the machine whose bus is looked at, as for hexid run; nothing is commanded. sim: without it\n"
    "  --log FILE|DIR   where logs will go: room and speed of that disk; the directory at hand without it\n"
    "  --latency S      measure the wake-ups of a thread like the loop's for S seconds; 10 without it, 0: not\n"
    "  --json FILE      the findings, schema hexid.doctor/1; - for standard output\n" SET
    "  --modbus-map     print the register map instead\n"
    "  --failures       print what can fail, and what to do\n"
    "  --refusals       print why samples and tests are excluded, and what to do\n"
    "  --keys           print the reference of all configuration keys\n"
    "\nFAIL: hexid cannot do its work like this, or somebody could be hurt; WARN: it works worse than it\n"
    "should; ?: cannot be seen from here\n"
    "exit status 0 without a FAIL, whatever is warned of; 1 with one; 2 when the configuration is invalid\n";

static const char tune_options[] = CONFIG
    "  --hal URL        the machine, as for hexid run: on a field bus each command acts a cycle later. sim: without it\n"
    "  -o FILE          the whole configuration with the gains that were found, for hexid run -c; - for standard output\n"
    "  --json FILE      modes, margins and gains before and after, schema hexid.tune/1; - for standard output\n" SET
    "\nnothing is moved and nothing simulated: the linear loop is computed in every pose where the machine may be held\n"
    "exit status 0 when the gains reach 6 dB, 45 degrees and a damping of 0.3; 1 when not: the line says which\n"
    "is missed, and by which part of the machine\n";

static const struct subcommand subcommands[] = {
    {"run",
     "[-c FILE] [--hal URL] [--fast] [--rt require|try|off] [--seed N] [--log FILE|DIR [--log-quota GB] [--log-part GB]] [--json FILE]\n"
     "           [--set KEY=VALUE ...] [--tests LIST] [--trajectory FILE [--repeat N]] [--survey [--std PCT]] [--qualify]\n"
     "           [--verbose] [--print-config]",
     "run the platform through its tests and identify it", run_options, "hexid run --fast --seed 7 --log a.lcm --json a.json", cmd_run},
    {"plant", "--bus URL [-c FILE] [--set KEY=VALUE ...] [--seed N] [--rt require|try|off]",
     "serve the simulated platform as the devices of a bus",
     "  --bus URL        can:IF, modbus:tcp://HOST:PORT or modbus:rtu:DEVICE?baud=N\n" CONFIG SET SEED RT(" (without it: try)"),
     "hexid plant --bus modbus:tcp://127.0.0.1:1502", cmd_plant},
    {"check", "DIR|CSV|LOG [LOG ...] [--run N] [-c FILE] [--set KEY=VALUE ...] [--map OURS=THEIRS[:UNIT],...] [-o PAGE.html] [--json FILE]",
     "look at a recording: sampling, pieces in time, channels, and whether gap and identify would take it", check_options,
     "hexid check a.lcm -o a.html", cmd_check},
    {"identify",
     "LOG [LOG ...] [--run N] [-c FILE] [--set KEY=VALUE ...] [--pose X,Y,Z,PHI,THETA,PSI] [--weight KG[,STD]] [-o FILE]\n"
     "           [--model FILE] [--json FILE]",
     "identify from a recorded log, or from several of one machine",
     "  LOG              of `hexid run` or `hexid import`; up to sixteen of one machine are combined, and compared\n"
     "  --run N          of a log that holds several runs of the daemon: take this one\n"
     "  -c FILE          configuration, but for the log's own tests; without it all is the log's own\n" SET
     "  --pose LIST      the matrix in this pose, too, m and rad: from the payload found and the legs as configured\n"
     "  --weight KG[,STD] two logs, without and with this weight on the platform: what it reads calibrates the first one's forces\n"
     "  -o FILE          the configuration with what was found about the sensors, for -c of later runs and logs\n"
     "  --model FILE     the same with payload and friction, and from a survey's log oil, valves' gains and delay, each with its\n"
     "                   interval: what hexid run -c FILE drives with; never where the verdict is fail\n"
     "  --json FILE      result, schema hexid.identification/1; - for standard output\n",
     "hexid identify a.lcm --json a.json", cmd_identify},
    {"report", "LOG [LOG ...] -o PAGE.html [--run N] [-c FILE] [--set KEY=VALUE ...]",
     "the identification as one page: matrix, payload, friction, tests in pictures, checks; up to six logs side by side",
     "  LOG              of one run; with several, each has its column beside the others, and nothing is pooled\n"
     "  --run N          of a log that holds several runs of the daemon: take this one\n"
     "  -o PAGE.html     one file for any browser, pictures inside; - for standard output\n"
     "  -c FILE          configuration, of all logs, but for each log's own tests; without it all is the log's own\n" SET
     "\nexit status as that of hexid identify: 0 when all runs passed their checks, 1 when one did not; the page is written then, too\n",
     "hexid report a.lcm b.lcm -o report.html", cmd_report},
    {"gap",
     "LOG [LOG2 ...] [--run N] [--validate LOG] -c FILE -o DIR [--json FILE] [--replay closed-loop|motion]\n"
     "           [--set KEY=VALUE ...]",
     "find the physical effect that the model lacks, add it, and show how much of the difference is gone", gap_options,
     "hexid gap a.lcm -c rig.yaml -o gap", cmd_gap},
    {"import", "DIR|FILE -o LOG [-c FILE] [--set KEY=VALUE ...] [--map OURS=THEIRS[:UNIT],...]",
     "make a log of the CSV, MAT or MCAP files of a run, or of one",
     "  DIR|FILE         a directory of such files, one a test, or one file\n"
     "  -o LOG           the log to write\n" CONFIG SET MAP,
     "hexid import stand.csv -c axis.yaml -o stand.lcm --map 't=Zeit:ms,position=Weg:mm,force=Kraft:kN'", cmd_import},
    {"export", "LOG [--run N] -o DIR | --all -o FILE | --format mat|mcap -o FILE",
     "convert a log: a directory of CSV files, one a test, as import reads it; or all of it, every cycle of every state",
     "  LOG              of `hexid run` or `hexid import`\n"
     "  --run N          of a log that holds several runs of the daemon: take this one\n"
     "  -o DIR           directory for one CSV file a test, with the configuration\n"
     "  --all -o FILE    one CSV table of every cycle\n"
     "  --format FORMAT  csv without it; mat: for MATLAB, Octave and scipy; mcap: for PlotJuggler and Foxglove\n",
     "hexid export a.lcm --format mat -o a.mat", cmd_export},
    {"command", "engage|start|stop|park|reset|set [KEY=VALUE] [--machine NAME] [-c FILE] [--set KEY=VALUE ...]",
     "tell a running hexid of this host what to do",
     "  engage           raise the platform to neutral, and renew the lease until it is put down; Ctrl-C parks it\n"
     "  start            run the tests\n"
     "  stop             end the test under way; a platform that rises is put down\n"
     "  park             put the platform down\n"
     "  reset            acknowledge a fault whose cause is gone\n"
     "  set [KEY=VALUE]  change a gain while the platform is held or put down, by a factor of 1.4 at most: control.kp, ki, kd,\n"
     "                   kff or kpf; refused where the loop would be unstable; without KEY=VALUE it says the gains\n"
     "  --machine NAME   the hexid with this machine.name; without it the only one that runs, but stop and park go to all that run\n"
     "  -c FILE          configuration of the running hexid: its machine.name, and its lcm.url, by which stop and park go, too\n" SET
     "\nengage and start stay until the platform is put down, or held again after the tests\n"
     "HEXID_RUNTIME_DIR in the environment replaces /run/hexid and the user's runtime directory, for both ends\n"
     "exit status 0 done; 1 ended by a park, a fault or Ctrl-C; 2 several run and none was named;\n"
     "3 nobody answered, or one of several did not; 4 refused, or the lease is lost\n",
     "hexid command park", cmd_command},
    {"monitor", "[--once] [--json] | --http [ADDRESS:]PORT  [-c FILE] [--set KEY=VALUE ...]",
     "watch a running hexid over LCM: in the terminal, as JSON, or as a live page for browsers",
     "  --once           the newest state, once; status 3 when no hexid is heard within 3 s\n"
     "  --json           every message as a JSON object, a line each; with --once the state alone\n"
     "  --http [ADDRESS:]PORT\n"
     "                   a live page there: 127.0.0.1:8321, or 8321 alone, is for browsers on this host; port 0 takes a free one\n"
     "  -c FILE          configuration of the running hexid: its lcm.url, its geometry, its tests\n" SET,
     "hexid monitor --http 127.0.0.1:8321", cmd_monitor},
    {"qualify", "LOG [--run N] [--baseline OLD.json] [-o PAGE.html] [--json FILE] [-c FILE] [--set KEY=VALUE ...]",
     "the motion system's quality from a log of `hexid run --qualify`, against your limits and an earlier measurement",
     "  LOG              of `hexid run --qualify`\n"
     "  --run N          of a log that holds several runs of the daemon: take this one\n"
     "  --baseline FILE  JSON of an earlier measurement: what has changed\n"
     "  -o PAGE.html     one file for any browser, pictures inside; - for standard output\n"
     "  --json FILE      the measurement, schema hexid.qualify/1; - for standard output\n"
     "  -c FILE          configuration; without it the log's own\n" SET
     "\nlimits stand in the section `qualify` of the configuration; without one a quantity is measured, not evaluated\n"
     "exit status 0 when every limit that is stated holds, 1 when not\n",
     "hexid qualify a.lcm --set qualify.phase_deg=45 -o a.html --json a.json", cmd_qualify},
    {"doctor",
     "[-c FILE] [--set KEY=VALUE ...] [--hal URL] [--log FILE|DIR] [--latency S] [--json FILE]\n"
     "           [--modbus-map | --failures | --refusals | --keys]",
     "check configuration, real time, field buses, LCM and disk: ok, WARN or FAIL, with the remedy", doctor_options,
     "hexid doctor -c rig.yaml --hal can:can0", cmd_doctor},
    {"tune", "[-c FILE] [--hal URL] [-o FILE] [--json FILE] [--set KEY=VALUE ...]",
     "find the first gains of a machine from its configuration alone, with the margins before and after", tune_options,
     "hexid tune -c rig.yaml -o tuned.yaml", cmd_tune},
    {"effects", "[NAME] [--json FILE]", "list the effects that the simulated plant can have",
     "  NAME             this one alone\n"
     "  --json FILE      the same, schema hexid.effects/1; - for standard output\n",
     "hexid effects cylinder_coulomb_friction", cmd_effects},
};

enum { SUBCOMMANDS = sizeof subcommands / sizeof *subcommands };

const struct subcommand *help_find(const char *name) {
    for (int i = 0; i < SUBCOMMANDS; i++)
        if (!strcmp(name, subcommands[i].name)) return &subcommands[i];
    return NULL;
}

static const char *subcommand_name(int i) { return i < SUBCOMMANDS ? subcommands[i].name : NULL; }

const char *help_nearest(const char *name) { return edit_nearest(name, subcommand_name); }

/* Prints a subcommand's options, with the back-ends' URLs under --hal. */
static void print_options(const struct subcommand *s) {
    const char *urls = strstr(s->options, "%s");
    printf("\nOptions:\n%.*s", urls ? (int)(urls - s->options) : (int)strlen(s->options), s->options);
    if (!urls) return;
    for (int i = 0; hal_table[i]; i++) printf("                     %s\n", hal_table[i]->usage);
    printf("%s", urls + 2);
}

void help_print(const struct subcommand *s) {
    printf("hexid %s %s\n%s\n", s->name, s->usage, s->purpose);
    print_options(s);
    printf("\nExample:\n  %s\n", s->example);
}

void help_print_all(FILE *out) {
    fprintf(out, "hexid: controller and identifier of a hydraulic six-leg platform\n\n");
    for (const struct subcommand *s = subcommands; s < subcommands + SUBCOMMANDS; s++)
        fprintf(out, "  hexid %-9s%s\n           %s\n", s->name, s->usage, s->purpose);
    fprintf(out, "\n  hexid --version\n\n`hexid SUBCOMMAND --help` has options and an example of each.\n"
                 "\nexit status: 0 all checks passed, 1 a check failed or was not evaluated, 2 usage or configuration, 3 file or device,\n"
                 "             4 refused for safety\n");
}
