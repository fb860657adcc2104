#include <errno.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "can_controller.h"
#include "can_frames.h"
#include "can_socket.h"
#include "doctor.h"
#include "machine_lock.h"
#include "modbus_link.h"
#include "modbus_map.h"
#include "params.h"
#include "sort.h"

/* ---- CAN ---- */

struct finding check_can_load(const struct doctor *d) {
    if (!doctor_drives(d)) return finding_none();
    struct can_load l = can_load(d->params);
    enum level too_full = doctor_address(d, "can") ? LEVEL_FAIL : LEVEL_WARN;
    struct finding f = finding(l.share <= l.limit ? LEVEL_OK : too_full, "a longer loop.period_s, or a higher can.bitrate_bps",
                               "%.1f %% of the cycle: %d bits a cycle, %.1f of heartbeats; at most %.0f %%", 100 * l.share, l.cycle_bits,
                               l.heartbeat_bits, 100 * l.limit);
    f.data = json_pack("{sf sf}", "share_pct", 100 * l.share, "limit_pct", 100 * l.limit);
    return f;
}

/* Opens and closes a socket with a filter that accepts nothing, to find out whether the interface
 * exists, is up, is a CAN interface, and may be used. */
static int try_interface(const char *interface, struct error *error) {
    struct can_socket s;
    int status = can_socket_open(&s, interface, NULL, 0, false, false, error);
    if (!status) can_socket_close(&s);
    return status;
}

struct finding judge_can_interface(const struct doctor *d, const char *interface, const struct can_controller *s) {
    char remedy[200];
    double wanted_bps = d->params->can.bitrate_bps;
    snprintf(remedy, sizeof remedy, "sudo ip link set %.16s down; sudo ip link set %.16s up type can bitrate %.0f", interface, interface,
             wanted_bps);
    if (!s->known) return finding(LEVEL_OK, "", "%s is up; %s has no controller, so no bit rate and no error counters", interface, s->kind);
    struct finding f;
    if (!s->bitrate_bps) f = finding(LEVEL_UNKNOWN, remedy, "%s is up; its driver does not tell the bit rate", interface);
    else if ((double)s->bitrate_bps != wanted_bps)
        f = finding(LEVEL_FAIL, remedy, "%s has %" PRIu32 " bit/s, can.bitrate_bps is %.0f: nodes of another rate disturb the bus",
                    interface, s->bitrate_bps, wanted_bps);
    else f = finding(LEVEL_OK, "", "%s is up, %" PRIu32 " bit/s, sample point %.1f %%", interface, s->bitrate_bps, 100.0 * s->sample_point);
    f.data = json_pack("{sI sf}", "bitrate_bps", (json_int_t)s->bitrate_bps, "sample_point", s->sample_point);
    return f;
}

struct finding check_can_interface(const struct doctor *d) {
    const char *interface = doctor_address(d, "can");
    char remedy[120];
    struct can_controller s;
    struct error error;
    if (!interface) return finding_none();
    snprintf(remedy, sizeof remedy, "sudo ip link set %.16s up type can bitrate %.0f", interface, d->params->can.bitrate_bps);
    if (try_interface(interface, &error)) return finding(LEVEL_FAIL, remedy, "%s", error.text);
    if (can_controller_read(interface, &s, &error)) return finding(LEVEL_UNKNOWN, "`ip -details link show` may tell", "%s", error.text);
    return judge_can_interface(d, interface, &s);
}

static json_t *counter_json(const struct can_controller *c, unsigned count) {
    return c->counts ? json_integer((json_int_t)count) : json_null();
}

static uint32_t errors(const struct can_controller *s) { return s->warnings + s->passives + s->bus_offs + s->bus_errors; }

/* Judges the error counters of ISO 11898-1: a node is error-passive from 128 on and bus-off from
 * 256. An unacknowledged frame adds 8 and a good frame subtracts 1, so these counters show the
 * present state. The totals count since the interface was created, so only their change in the last
 * second matters. */
struct finding judge_can_errors(const char *interface, const struct can_controller *before, const struct can_controller *s) {
    static const char wiring[] = "look at termination (120 ohm at both ends), wiring, bit rate and sample point of all nodes";
    char counters[40] = "counters not told";
    if (!s->known) return finding_none();
    if (s->counts) snprintf(counters, sizeof counters, "TEC %u, REC %u", s->tx_errors, s->rx_errors);
    bool off = s->state >= CAN_CONTROLLER_BUS_OFF, troubled = s->state != CAN_CONTROLLER_ACTIVE || s->tx_errors || s->rx_errors;
    uint32_t now = errors(s) - errors(before);
    enum level level = off ? LEVEL_FAIL : troubled || now ? LEVEL_WARN : LEVEL_OK;
    char remedy[240];
    snprintf(remedy, sizeof remedy, "%s%s%.16s%s", wiring, level == LEVEL_FAIL ? "; then sudo ip link set " : "",
             level == LEVEL_FAIL ? interface : "", level == LEVEL_FAIL ? " down, and up again" : "");
    struct finding f = finding(level, remedy,
                               "%s, %s; %" PRIu32 " errors within a second; since it was made %" PRIu32 " bus errors, %" PRIu32
                               " times error-warning, %" PRIu32 " error-passive, %" PRIu32 " bus-off, %" PRIu32
                               " restarts; arbitration lost %" PRIu32 " times",
                               can_controller_state(s->state), counters, now, s->bus_errors, s->warnings, s->passives, s->bus_offs,
                               s->restarts, s->arbitration_lost);
    f.data = json_pack("{ss so so sI sI sI sI sI sI sI}", "state", can_controller_state(s->state), "tx_errors",
                       counter_json(s, s->tx_errors), "rx_errors", counter_json(s, s->rx_errors), "errors_within_a_second", (json_int_t)now,
                       "bus_errors", (json_int_t)s->bus_errors, "error_warning", (json_int_t)s->warnings, "error_passive",
                       (json_int_t)s->passives, "bus_off", (json_int_t)s->bus_offs, "restarts", (json_int_t)s->restarts, "arbitration_lost",
                       (json_int_t)s->arbitration_lost);
    return f;
}

struct finding check_can_errors(const struct doctor *d) {
    const char *interface = doctor_address(d, "can");
    struct can_controller before, s;
    struct error error;
    if (!interface || try_interface(interface, &error) || can_controller_read(interface, &before, &error))
        return finding_none(); /* check_can_interface() reports this failure */
    if (!before.known) return judge_can_errors(interface, &before, &before);
    nanosleep(&(struct timespec){.tv_sec = 1}, NULL);
    if (can_controller_read(interface, &s, &error)) return finding(LEVEL_UNKNOWN, "run `hexid doctor` again", "%s", error.text);
    return judge_can_errors(interface, &before, &s);
}

/* ---- Modbus ---- */

/* Checks whether a cycle's exchange fits into the period on a serial line. The baud rate is in the
 * machine's URL, not in the configuration; if the URL names no serial line, the times at two usual
 * baud rates are listed. */
struct finding check_modbus_line(const struct doctor *d) {
    const char *address = doctor_address(d, "modbus");
    struct modbus_address_parts parts;
    struct error error;
    if (!doctor_drives(d)) return finding_none();
    if (address && modbus_parse(address, &parts, &error)) return finding(LEVEL_FAIL, "write the address in that form", "%s", error.text);
    struct modbus_load slow = modbus_load(address && parts.serial ? parts.baud : 115200.0), fast = modbus_load(1e6);
    double cycle_s = 0.9 * d->params->loop.period_s;
    bool fits = !address || !parts.serial || slow.cycle_s <= cycle_s;
    char line[80];
    if (address && parts.serial) snprintf(line, sizeof line, "on this line %.1f ms", slow.cycle_s * 1e3);
    else snprintf(line, sizeof line, "on a serial line %.1f ms at 115200 baud, %.1f ms at 1 Mbaud", slow.cycle_s * 1e3, fast.cycle_s * 1e3);
    if (address && parts.serial && fits && slow.strict_cycle_s > cycle_s)
        return finding(
            LEVEL_OK, "",
            "function 23: %d + %d bytes, %s; the cycle of %.1f ms leaves %.2f ms (3.5 characters) between two frames; with 1.75 ms, "
            "which the standard recommends above 19200 baud, loop.period_s is %.4f or more",
            slow.request_bytes, slow.response_bytes, line, cycle_s * 1e3, 1e3 * modbus_silence_least_s(parts.baud),
            slow.strict_cycle_s / 0.9);
    return finding(fits ? LEVEL_OK : LEVEL_FAIL, "a higher baud rate, or a longer loop.period_s",
                   "function 23: %d + %d bytes, %s; the cycle has %.1f ms", slow.request_bytes, slow.response_bytes, line, cycle_s * 1e3);
}

/* Judges the round trips of a client that only reads; a device may answer its master faster. */
struct finding judge_round_trips(const struct doctor *d, const struct round_trips *r) {
    double cycle_s = 0.9 * d->params->loop.period_s, timeout_s = d->params->limits.sensor_age_s;
    static const char remedy[] = "a network of its own for machine and computer, without switches in between; or a longer loop.period_s";
    char measured[160];
    snprintf(measured, sizeof measured,
             "one read takes %.2f ms, at most %.2f (%d of %d answered); the cycle has %.1f ms, the time-out is %.0f ms", r->median_s * 1e3,
             r->max_s * 1e3, ROUND_TRIPS - r->lost, ROUND_TRIPS, cycle_s * 1e3, timeout_s * 1e3);
    struct finding f;
    if (r->lost > ROUND_TRIPS / 2 || r->median_s > timeout_s)
        f = finding(LEVEL_FAIL, remedy, "readings would be too old to be believed: %s", measured);
    else if (r->lost || r->median_s > cycle_s)
        f = finding(LEVEL_WARN, remedy, "%s: %s", r->lost ? "answers are lost" : "too slow for every cycle", measured);
    else if (r->owned)
        f = finding(LEVEL_WARN, "end the other master before hexid is started; when it is a hexid at work, all is well",
                    "another master has the machine; %s", measured);
    else f = finding(LEVEL_OK, "", "%s", measured);
    f.data = json_pack("{sf sf si si}", "median_us", r->median_s * 1e6, "max_us", r->max_s * 1e6, "lost", r->lost, "asked", ROUND_TRIPS);
    return f;
}

/* Longest duration of the measurement, s, limited because no hexid can start while the measurement
 * holds the machine's lock. Requests that are not sent in this time count as lost. */
enum { LONGEST_TALK_S = 5 };

/* Measures round trips by reading the registers of identity and status; writes no register. */
static struct finding talk(const struct doctor *d, struct modbus_link *link, const struct modbus_address_parts *parts,
                           const char *address) {
    static const char who_remedy[] =
        "check modbus.unit, baud rate and wiring; the device must serve the map of `hexid doctor --modbus-map`";
    struct error error;
    struct round_trips r = {0};
    uint16_t who[2], status;
    double took_s[ROUND_TRIPS];
    int answers = 0;
    if (modbus_link_greet(link, address, who, &error)) return finding(LEVEL_FAIL, who_remedy, "%s", error.text);
    if (who[0] != MODBUS_IS_HEXID || who[1] != MODBUS_MAP_VERSION)
        return finding(LEVEL_FAIL, who_remedy,
                       "modbus:%.100s: registers 0 and 1 hold 0x%04x and %u, not 0x%04x and %d: another device, or another map", address,
                       who[0], who[1], MODBUS_IS_HEXID, MODBUS_MAP_VERSION);
    if (modbus_link_keep_silence(link, parts, d->params->loop.period_s, &error))
        return finding(LEVEL_FAIL, "that period, or a higher baud rate", "%s", error.text);
    r.owned = !modbus_link_read(link, MODBUS_STATUS, 1, &status) && status & MODBUS_OWNED;
    double first_s = doctor_now_s();
    for (int i = 0; i < ROUND_TRIPS && doctor_now_s() - first_s < LONGEST_TALK_S; i++) {
        double begun_s = doctor_now_s();
        if (!modbus_link_read(link, MODBUS_IDENTITY, 2, who)) took_s[answers++] = doctor_now_s() - begun_s;
        else if (modbus_link_gone(errno)) break;
    }
    r.lost = ROUND_TRIPS - answers;
    sort_ascending(answers, took_s);
    if (answers) r.median_s = took_s[answers / 2], r.max_s = took_s[answers - 1];
    return judge_round_trips(d, &r);
}

/* SAFETY: asks the device only if no hexid of this host is its master (machine_lock.h): a serial
 * line has only one master, and some devices replace their present client by a new one. */
struct finding check_modbus(const struct doctor *d) {
    const char *address = doctor_address(d, "modbus");
    struct modbus_address_parts parts;
    struct modbus_link *link;
    struct error error;
    /* check_modbus_line() reports this failure */
    if (!address || modbus_parse(address, &parts, &error)) return finding_none();
    struct machine_lock lock;
    int status = machine_lock(&lock, d->url, &error);
    if (status == STATUS_UNSAFE) return finding(LEVEL_UNKNOWN, "ask again when it has ended", "not asked: %s", error.text);
    struct finding f;
    if (status || modbus_link_open(&link, &parts, d->params->modbus.unit, 1.0, &error)) {
        f = finding(LEVEL_FAIL,
                    "look at the device, its supply and its address; a service needs IPAddressAllow= or DeviceAllow= (docs/service.md)",
                    "%s", error.text);
    } else {
        f = talk(d, link, &parts, address);
        modbus_link_close(link);
    }
    machine_unlock(&lock);
    return f;
}
