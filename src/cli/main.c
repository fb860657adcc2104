#include <stdio.h>
#include <string.h>

#include "cli.h"
#include "hal.h"

static const struct subcommand {
    const char *name, *usage, *purpose;
    int (*run)(int argc, char **argv);
} subcommands[] = {
    {"run", "[-c FILE] [--hal URL] [--fast] [--rt require|try|off] [--seed N] [--log FILE] [--json FILE] [--set KEY=VALUE ...]\n"
            "           [--tests LIST] [--trajectory FILE [--repeat N]] [--survey [--std PCT]] [--print-config]", "run the platform through its tests and identify it", cmd_run},
    {"plant", "--bus URL [-c FILE] [--set KEY=VALUE ...] [--seed N] [--rt require|try|off]",
     "serve the simulated platform as the devices of a bus: can:IF, modbus:tcp://HOST:PORT or modbus:rtu:DEVICE?baud=N", cmd_plant},
    {"check", "DIR|CSV|LOG [LOG ...] [-c FILE] [--set KEY=VALUE ...] [--map OURS=THEIRS[:UNIT],...] [-o PAGE.html] [--json FILE]",
     "look at a recording: sampling, pieces in time, channels, and whether gap and identify would take it", cmd_check},
    {"identify", "LOG [LOG ...] [-c FILE] [--set KEY=VALUE ...] [--json FILE]", "identify from a recorded log, or from several of one machine",
     cmd_identify},
    {"report", "LOG [LOG ...] -o PAGE.html [-c FILE] [--set KEY=VALUE ...]",
     "the identification as one page: matrix, payload, friction, tests in pictures, checks; up to six logs side by side", cmd_report},
    {"gap", "--measured LOG [--measured LOG2 ...] [--validate LOG] -c FILE -o DIR [--json FILE] [--replay closed-loop|motion] "
            "[--set KEY=VALUE ...]",
     "find the physical effect that the model lacks, add it, and show how much of the difference is gone", cmd_gap},
    {"import", "DIR|CSV -o LOG [-c FILE] [--set KEY=VALUE ...] [--map OURS=THEIRS[:UNIT],...]",
     "make a log of the CSV files of a run, or of one; --map position=Weg:mm,t=Zeit:s where their columns have other names", cmd_import},
    {"export", "LOG -o DIR | --all -o FILE | --format mat|mcap -o FILE",
     "hand a log on: a directory of CSV files, one a test, as import reads it; or all of it, every cycle of every state, as one\n"
     "           CSV table (--all), for MATLAB, Octave and scipy (mat), or for PlotJuggler and Foxglove (mcap)", cmd_export},
    {"command", "engage|start|stop|park|reset [-c FILE]", "tell a running hexid what to do, over LCM", cmd_command},
    {"monitor", "[-c FILE]", "watch a running hexid in the terminal, over LCM", cmd_monitor},
    {"doctor", "[-c FILE] [--set KEY=VALUE ...] [--modbus-map] [--failures] [--keys]",
     "check configuration, real time, field buses and LCM on this machine; print the register map, what can fail and what to do,\n"
     "           or the reference of all configuration keys", cmd_doctor},
    {"effects", "[NAME]", "list the effects that the simulated plant can have", cmd_effects},
};

enum { SUBCOMMANDS = sizeof subcommands / sizeof *subcommands };

static void help(const struct subcommand *s) {
    printf("hexid %s %s\n%s\n", s->name, s->usage, s->purpose);
    if (s->run == cmd_gap)
        printf("\n  --measured LOG   of the rig; several logs of one machine are fitted together\n"
               "  -c FILE          the model: configuration, its effects taken as given\n"
               "  -o DIR           model.yaml (the model with what was found), gap.json, report.html\n"
               "  --validate LOG   before and after are judged on this log, which no fit has seen, instead of on held-out cycles\n"
               "  --replay MODE    closed-loop: the proof is a simulation of the loop; motion: the equations under the measured motion\n"
               "                   alone, for one axis and for logs without references or valve commands\n"
               "  --json FILE      gap.json, schema hexid.gap/1, there too; - for standard output\n"
               "  --set KEY=VALUE  one key of the configuration\n"
               "\nexit status 0 whatever the verdict is: it stands in gap.json\n");
    if (s->run == cmd_check)
        printf("\n  DIR|CSV|LOG      a log, several of one machine, or CSV files as `hexid import` reads them\n"
               "  -c FILE          configuration; without it the log's own, for CSV config/tian2015.yaml\n"
               "  --set KEY=VALUE  one key of the configuration\n"
               "  --map LIST       columns of CSV by their own names: position=Weg:mm,t=Zeit:s\n"
               "  -o PAGE.html     the signals over time, one file for any browser\n"
               "  --json FILE      the same facts, schema hexid.check/1; - for standard output\n"
               "\nexit status 0 when hexid gap would take it, 1 when not: the last line has its refusal\n");
    if (s->run == cmd_report)
        printf("\n  LOG              of one run; with several, each has its column beside the others, and nothing is pooled\n"
               "  -o PAGE.html     one file for any browser, pictures inside; - for standard output\n"
               "  -c FILE          configuration, of all logs; without it each log's own\n"
               "  --set KEY=VALUE  one key of the configuration\n"
               "\nexit status as that of hexid identify: 0 when all runs passed their checks, 1 when one did not; the page is written then, too\n");
    if (s->run != cmd_run) return;
    printf("\n  -c FILE          configuration; config/tian2015.yaml without it (--print-config shows every key)\n"
           "  --hal URL        the platform, `sim:` without it:\n");
    for (int i = 0; hal_table[i]; i++) printf("                     %s\n", hal_table[i]->usage);
    printf("  --fast           virtual time, as fast as this machine can: same code, same seed, same bytes\n"
           "  --rt MODE        require: no run without SCHED_FIFO and locked memory (default on hardware); "
                            "try: warn (default on sim:); off\n"
           "  --seed N         of the simulated sensors' noise\n"
           "  --log FILE       LCM event log of every cycle\n"
           "  --json FILE      result, schema hexid.identification/1; - for standard output\n"
           "  --set KEY=VALUE  one configuration key, e.g. tests.frequency_hz=5\n"
           "  --tests LIST     axes to test, e.g. x,theta\n"
           "  --trajectory FILE\n"
           "                   drive these poses instead: CSV with t_s and any of x_m, y_m, z_m, phi_rad, theta_rad, psi_rad\n"
           "  --repeat N       passes of the trajectory\n"
           "  --survey         drive a small multisine instead, and say: the lowest eigenfrequencies of oil columns and closed loop, whether the\n"
           "                   configured tests are below them and above the sensors' floor, and which tests would do (docs/survey.md)\n"
           "  --std PCT        for this standard deviation of Mt's worst entry, in per cent of sqrt(Mii Mjj); 0.5 without it\n"
           "  --print-config   show the effective configuration and end\n");
}

static void usage(FILE *out) {
    fprintf(out, "hexid: controller and identifier of a hydraulic six-leg platform\n\n");
    for (const struct subcommand *s = subcommands; s < subcommands + SUBCOMMANDS; s++)
        fprintf(out, "  hexid %-9s%s\n           %s\n", s->name, s->usage, s->purpose);
    fprintf(out, "\nexit status: 0 all checks passed, 1 a check failed or was not evaluated, 2 usage or configuration, 3 file or device,\n"
                 "             4 refused for safety\n");
}

int main(int argc, char **argv) {
    if (argc >= 2 && (!strcmp(argv[1], "--help") || !strcmp(argv[1], "-h") || !strcmp(argv[1], "help"))) {
        usage(stdout);
        return EXIT_PASSED;
    }
    for (int i = 0; argc >= 2 && i < SUBCOMMANDS; i++) {
        if (strcmp(argv[1], subcommands[i].name)) continue;
        if (argc < 3 || (strcmp(argv[2], "--help") && strcmp(argv[2], "-h"))) return subcommands[i].run(argc - 1, argv + 1);
        help(&subcommands[i]);
        return EXIT_PASSED;
    }
    if (argc >= 2) fprintf(stderr, "hexid: no such subcommand: %s\n\n", argv[1]);
    usage(stderr);
    return -STATUS_USAGE;
}
