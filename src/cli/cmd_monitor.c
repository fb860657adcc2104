/* `hexid monitor`: a running hexid in the terminal, over LCM. On a terminal the newest cycle stands below the events; elsewhere every
 * message is a line. */
#include <math.h>
#include <signal.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "bus.h"
#include "cli.h"
#include "force.h"
#include "ident.h"
#include "messages.h"
#include "supervisor.h"
#include "units.h"

enum { REDRAW_MS = 200, SILENCE_MS = 2000 };

struct monitor {
    bool terminal, heard;
    int drawn;          /* lines of the view on the screen */
    int64_t drawn_ms;
};

static int64_t now_ms(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return t.tv_sec * 1000LL + t.tv_nsec / 1000000;
}

/* Takes the view off the screen: what is printed next stands above it. */
static void erase(struct monitor *m) {
    if (m->drawn) printf("\033[%dA\r\033[J", m->drawn);
    m->drawn = 0;
    m->drawn_ms = 0;
}

static double rounded(double x, double unit) { return round(x / unit) * unit + 0.0; } /* no -0.00 */

static void headline(const struct cycle *c) {
    static const char *const phases[] = {"", "settle", "ramp in", "evaluate", "ramp out"};
    char fault[FAULT_TEXT_SIZE];
    fault_describe(c->first_fault, c->faults, fault);
    printf("%9.3f s  %-12s  %-5s %-8s  fault %s\n", seconds_from_ns(c->in.time_ns), state_names[c->state],
           c->dof >= 0 ? dof_names[c->dof] : c->test >= 0 ? "any" : "", phases[c->phase], fault);
}

static void pose(const struct cycle *c) {
    printf("     ");
    for (int i = 0; i < DOFS; i++) printf(" %s %.2f %s", dof_names[i], rounded(c->pose[i] * 1e3, 0.01), i < 3 ? "mm" : "mrad");
    printf("\n");
}

static void draw(struct monitor *m, const struct cycle *c) {
    if (m->terminal && now_ms() - m->drawn_ms < REDRAW_MS) return;
    if (m->terminal) erase(m);
    headline(c);
    pose(c);
    if (m->terminal) {
        printf("  leg   length m   P1 MPa   P2 MPa   force N    valve\n");
        for (int i = 0; i < LEGS; i++)
            printf("  %d   %10.5f %8.3f %8.3f %9.1f %+8.3f\n", i + 1, c->in.length_m[i], c->in.p1_pa[i] * 1e-6, c->in.p2_pa[i] * 1e-6,
                   c->force_n[i], c->out.valve[i]);
        m->drawn = 3 + LEGS;
        m->drawn_ms = now_ms();
    }
}

static void test_result(const void *data, int size) {
    struct test_summary t;
    if (!test_result_decode(data, size, &t)) return;
    cli_say(stdout, "             result %s: amplitude %.4g of %.4g, phase %.1f deg, %lld samples, %lld excluded", t.dof_name,
            t.achieved_m_or_rad, t.amplitude_m_or_rad, t.phase_deg, (long long)t.samples, (long long)t.excluded);
}

static void gap_result(const void *data, int size) {
    struct gap_summary g;
    if (!gap_decode(data, size, &g)) return;
    cli_say(stdout, "             gap %s: %s; %.3g -> %.3g of the variation, noise %.3g", g.verdict, g.reason, g.held_out_before_ratio,
            g.held_out_after_ratio, g.noise_floor_ratio);
}

static void show(struct monitor *m, const char *channel, const void *data, int size) {
    struct cycle c;
    struct event e;
    m->heard = true;
    if (!strcmp(channel, CHANNEL_STATE) && state_decode(data, size, &c)) {
        draw(m, &c);
    } else if (!strcmp(channel, CHANNEL_EVENT) && event_decode(data, size, &e)) {
        erase(m);
        cli_say(stdout, "%9.3f s  %s: %s", seconds_from_ns(e.time_ns), e.kind, e.text);
    } else if (!strcmp(channel, CHANNEL_TEST_RESULT)) {
        erase(m);
        test_result(data, size);
    } else if (!strcmp(channel, CHANNEL_IDENTIFICATION)) {
        erase(m);
        printf("             %s: the matrices; lcm-spy shows them (make spy)\n", channel);
    } else if (!strcmp(channel, CHANNEL_GAP)) {
        erase(m);
        gap_result(data, size);
    }
    fflush(stdout);
}

int cmd_monitor(int argc, char **argv) {
    struct options o;
    struct params params;
    struct error error;
    struct bus *bus;
    struct monitor m = {.terminal = isatty(STDOUT_FILENO) != 0};
    int status = options_parse(&o, argc, argv, "cS", 0, &error);
    if (!status) status = options_bus(&o, &params, &bus, &error);
    if (!status) status = bus_listen(bus, "HEXID_", BUS_ANYONE, &error);
    bool told = false;
    while (!status) {
        struct bus_message message;
        int waited = bus_wait(bus, SILENCE_MS);
        while (waited > 0 && (waited = bus_receive(bus, &message)) > 0)
            if (waited == 1) show(&m, message.channel, message.data, message.size);
        if (waited < 0) status = error_set(&error, STATUS_IO, "monitor: LCM is broken");
        else if (!m.heard && !told) told = fprintf(stderr, "hexid: nothing yet: waiting for a hexid on %s\n", params.lcm.url) > 0;
    }
    return cli_fail(&error);
}
