#include <string.h>

#include "bus.h"
#include "doctor.h"
#include "params.h"

static const char channel[] = "HEXID_DOCTOR"; /* channel of its own, which other programs ignore */
enum { TRIES = 3, PATIENCE_MS = 500 };

struct finding check_lcm_socket(const struct doctor *d) {
    struct error error;
    struct bus *bus;
    char remedy[200], route[160];
    bus_remedy(route, sizeof route);
    snprintf(remedy, sizeof remedy, "as root: %s", route);
    if (!d->params->lcm.url[0]) return finding(LEVEL_OK, "", "none: lcm.url is empty; nobody can watch hexid from another program");
    if (bus_open(&bus, d->params->lcm.url, &error)) return finding(LEVEL_FAIL, remedy, "%s", error.text);
    int status = bus_listen(bus, channel, BUS_ANYONE, &error);
    bus_close(bus);
    if (status) return finding(LEVEL_FAIL, remedy, "%s", error.text);
    return finding(LEVEL_OK, "", "%s sends and listens", d->params->lcm.url);
}

/* Checks where LCM's messages go. Commands on this host do not depend on LCM; watching programs
 * do. */
struct finding check_lcm_route(const struct doctor *d) {
    struct error error;
    struct bus *bus;
    /* check_lcm_socket() reports this failure */
    if (!d->params->lcm.url[0] || bus_open(&bus, d->params->lcm.url, &error)) return finding_none();
    struct bus_route r = bus_route(bus);
    bus_close(bus);
    struct finding f;
    char network[BUS_INTERFACE_SIZE], remedy[100];
    bool beside = r.loopback && bus_network(network);
    if (beside) snprintf(remedy, sizeof remedy, "sudo ip route replace 224.0.0.0/4 dev %s", network);
    if (r.ttl > 0 && r.loopback)
        f = finding(LEVEL_WARN,
                    "route the group to the network: sudo ip route replace 224.0.0.0/4 dev eth0 (its name), or say ttl=0 in lcm.url",
                    "%s by %s with ttl %d: it does not leave this host, for all its ttl", r.group, r.interface, r.ttl);
    else if (beside)
        f = finding(LEVEL_WARN, remedy,
                    "%s by %s, and the network of %s is there, too: LCM's own programs send by that and listen on %s, deaf to each other; "
                    "hexid's hear both",
                    r.group, r.interface, network, r.interface);
    else if (r.ttl == 0 && !r.loopback)
        f = finding(LEVEL_OK, "", "%s by %s, ttl 0: stays on this host; while that link is down nobody can watch, commands do not need it",
                    r.group, *r.interface ? r.interface : "a network");
    else
        f = finding(LEVEL_OK, "", "%s by %s, ttl %d: %s", r.group, r.interface, r.ttl,
                    r.ttl ? "reaches other hosts" : "stays on this host");
    f.data = json_pack("{ss si}", "interface", r.interface, "ttl", r.ttl);
    return f;
}

/* Returns the time that a message takes from one socket to the other, s; negative: it did not
 * arrive. */
static double sent_and_received(struct bus *out, struct bus *in) {
    static const char text[] = "hexid doctor";
    struct bus_message m;
    double begun_s = doctor_now_s();
    if (bus_publish(out, channel, text, sizeof text)) return -1.0;
    while (doctor_now_s() - begun_s < PATIENCE_MS * 1e-3 && bus_wait(in, PATIENCE_MS) > 0)
        for (int got; (got = bus_receive(in, &m));) {
            if (got < 0) return -1.0;
            if (got == 1 && m.size == sizeof text && !memcmp(m.data, text, sizeof text)) return doctor_now_s() - begun_s;
        }
    return -1.0;
}

/* Checks that a datagram that this program sends comes back to it. Its ttl is 0 whatever is
 * configured, because the test need not leave this host. */
struct finding check_lcm_datagram(const struct doctor *d) {
    char url[PARAMS_TEXT_SIZE];
    struct error error;
    struct bus *out, *in;
    double took_s = -1.0;
    snprintf(url, sizeof url, "%.*s", (int)strcspn(d->params->lcm.url, "?"), d->params->lcm.url);
    /* check_lcm_socket() reports this failure */
    if (!url[0] || bus_open(&out, url, &error)) return finding_none();
    int status = bus_open(&in, url, &error);
    if (!status && bus_listen(in, channel, BUS_THIS_HOST, &error)) bus_close(in), status = STATUS_IO;
    if (status) {
        bus_close(out);
        return finding_none();
    }
    for (int i = 0; i < TRIES && took_s < 0.0; i++) took_s = sent_and_received(out, in);
    bus_close(in);
    bus_close(out);
    if (took_s < 0.0)
        return finding(
            LEVEL_FAIL, "see whether a firewall drops UDP to the group (sudo nft list ruleset)",
            "what was sent did not come back within %d ms, %d times: nobody would hear hexid; commands of this host do not need it",
            PATIENCE_MS, TRIES);
    struct finding f = finding(LEVEL_OK, "", "sent and received with ttl 0 in %.0f us", took_s * 1e6);
    f.data = json_pack("{sf}", "us", took_s * 1e6);
    return f;
}

struct finding check_lcm_buffers(const struct doctor *d) {
    static const char path[] = "/proc/sys/net/core/rmem_max";
    int64_t bytes;
    if (!d->params->lcm.url[0]) return finding_none();
    if (!doctor_number(d, &bytes, "%s", path)) return finding_unseen(path, "how much the system keeps for a reader that stalls");
    struct finding f = finding(bytes < BUS_RECEIVE_BUFFER ? LEVEL_WARN : LEVEL_OK,
                               "sudo sysctl -w net.core.rmem_max=2097152 (for good in /etc/sysctl.d/)",
                               "%lld bytes are kept for a reader that stalls; hexid asks for %d%s", (long long)bytes, BUS_RECEIVE_BUFFER,
                               bytes < BUS_RECEIVE_BUFFER ? ": what comes in a burst is lost" : "");
    f.data = json_pack("{sI si}", "rmem_max_bytes", (json_int_t)bytes, "wanted_bytes", BUS_RECEIVE_BUFFER);
    return f;
}
