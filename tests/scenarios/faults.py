"""Judges one run with a fault by its log and its JSON, for every back-end alike. Prints a row of the table in docs/validation.md; exit status 1 when
something is not as it must be. Needs the log's types: lcm-gen -p --ppath DIR lcmtypes/*.lcm, and PYTHONPATH=DIR.

    faults.py NAME FROM_S EXPECTED WITHIN LOG JSON CLEAN_JSON [STALLS]
    faults.py draw COUNT            a list of faults for faults.sh

FROM_S: when the fault begins, on the loop's clock; @US: on the system's, where something outside the daemon made it. EXPECTED, one or
several with / between them: what must see it first, within WITHIN cycles (0: however long it takes): a fault by its name; `flagged`,
samples that the identification leaves out (where it is expected, a fault that follows has all the time it wants); `verdict`, which refuses
at the end of the run; `nothing`: it does no harm.
STALLS, from stalls.py: times at which the machine under the test stalled; a fault found right after one proves nothing.
Always: valves centred with a fault and in every state that does not drive, commands within -1..1, no cycle missing in the log, and an
identification that is refused or differs from the clean run's by no more than UNHARMED."""
import json, math, random, sys

FAULTS = ("sensor_age", "sensor_invalid", "stroke", "leg_rate", "following_error", "force", "kinematics", "overrun", "io", "standstill",
          "second_master", "emergency_stop", "enable_switch", "door", "supply", "pressure_sensor")
FAULTS = dict(enumerate(FAULTS)) | {22: "oscillation", 23: "duplicate_node", 24: "input_contradiction"}
OPEN = 128  # sample flag for an open interlock; the supply's is open until it is on
PARKS = 1 << 15  # bit of first_fault: pressure_sensor
DRIVEN = (2, 3, 4, 5)  # engaging, ready, testing, parking
UNHARMED = {"m": 2.1, "I": 3.6, "M": 12.0}  # %, by the entry's first letter: 3 x the rms over 30 seeds that figures.py demands


class Failed(Exception):
    pass


def demand(holds, *words):
    if not holds:
        raise Failed(" ".join(str(word) for word in words))


def cycles_of(path):
    import hexid, lcm

    events = [event for event in lcm.EventLog(path, "r") if event.channel == "HEXID_STATE"]
    cycles = [hexid.state_t.decode(event.data) for event in events]
    return cycles, {c.seq: event.timestamp for c, event in zip(cycles, events)}  # time of the sample on the system's clock


def since(cycles, system_us, begin):
    """Returns the cycles from the fault's start on."""
    if begin.startswith("@"):
        return [c for c in cycles if system_us[c.seq] + c.age_ns / 1000 >= float(begin[1:])]
    return [c for c in cycles if c.time_ns + c.age_ns >= float(begin) * 1e9 - 1]


def check_outputs(cycles):
    for before, c in zip([None] + cycles, cycles):
        demand(before is None or c.seq == before.seq + 1, "cycles are missing before", c.seq)
        demand(c.enable == (c.state in DRIVEN), "state", c.state, "enable", c.enable, "in cycle", c.seq)
        parked = c.first_fault == PARKS and c.state == 5  # slow parking
        demand(not (c.faults and c.enable) or parked, "driven with a fault in cycle", c.seq)
        demand(all(abs(v) <= 1 for v in c.valve), "valves", c.valve, "in cycle", c.seq)  # false for NaN
        demand(c.enable or not any(c.valve), "valves not centred in cycle", c.seq)


def legs_of(c):
    return [leg + 1 for leg in range(6) if c.faults >> 16 + leg & 1]


def detection(cycles, system_us, begin):
    """Returns the first detection, the legs it names, and its delay in cycles."""
    after = since(cycles, system_us, begin)
    demand(after, "the run ended before the fault began")
    flagged = [n for n, c in enumerate(after, 1) if c.sample_flags & ~OPEN][:1]
    for n, c in enumerate(after, 1):
        if c.first_fault:
            return FAULTS.get(c.first_fault.bit_length() - 1, "another"), legs_of(c), n, flagged
    return ("flagged", [], flagged[0], flagged) if flagged else ("nothing", [], 0, flagged)


def check_stalls(stalls, during, system_us, found):
    """Demands that the machine did not stall between the fault's start and its detection."""
    first, last = (system_us[c.seq] + c.age_ns / 1000 for c in (during[0], during[-1]))
    for line in open(stalls):
        words = line.split()
        if len(words) == 2 and int(words[1]) >= 5:
            demand(not first <= int(words[0]) <= last + 5000, "the machine stood still for", words[1], "ms before", found, "was found")


def identification(result, clean):
    verdict = result["verdict"]
    if verdict["status"] != "pass":
        return False, "refused: " + (verdict["reasons"] + ["interrupted"])[0]
    most = 0.0
    for method in "method_a", "method_c":  # each method's verdict is about its own matrix
        if not result[method] or result[method]["verdict"]["status"] != "pass":
            continue
        ours, normal = result["errors_pct"][method], clean["errors_pct"][method]
        share, entry = max((abs(ours[name] - normal[name]) / UNHARMED[name[0]], name) for name in normal if ours[name] is not None)
        demand(share <= 1, f"silently wrong: {method} {entry} {ours[entry]:+.2f} %, {normal[entry]:+.2f} % in the clean run")
        most = max(most, share)
    return True, f"unharmed ({100 * most:.0f} % of the bound)"


def judge(name, from_s, expected, within, log, result, clean, stalls=None):
    cycles, system_us = cycles_of(log)
    check_outputs(cycles)
    found, legs, after, flagged = detection(cycles, system_us, from_s)
    unharmed, text = identification(json.load(open(result)), json.load(open(clean)))
    if not unharmed and (found == "nothing" or found == "flagged" and expected == "verdict"):
        found = "verdict"
    first = ""
    if flagged and found in FAULTS.values() and "flagged" in expected.split("/"):
        first, found, after = f", after {after} {found}", "flagged", flagged[0]
    named = ", leg" + "s" * (len(legs) > 1) + " " + " ".join(map(str, legs)) if legs else ""
    count = {"nothing": "-", "verdict": "end of run"}.get(found) or (f"{after} of {within}" if int(within) else str(after))
    print(f"| {name} | {found}{first}{named} | {count} | {'centred' if cycles[-1].faults else 'driven on'} | {text} |")
    demand(expected == "any" or found in expected.split("/"), "found", found, "expected", expected)
    demand(not int(within) or after <= int(within), "after", after, "cycles, not", within)
    if stalls and after and "nothing" not in expected:
        check_stalls(stalls, since(cycles, system_us, from_s)[:after], system_us, found)


# Kind, whether it takes a leg, range of its value (drawn logarithmically), whether signed.
KINDS = (("length", True, (1e-4, 0.02), True), ("drift", True, (1e-4, 0.02), True), ("noise", True, (1e-5, 2e-3), False),
         ("freeze", True, None, False), ("swap", True, None, False), ("pressure", True, (1e4, 5e6), True),
         ("pressure_drift", True, (1e3, 1e6), True), ("pressure_freeze", True, None, False), ("pressure_swap", True, None, False),
         ("mix", True, None, False), ("stuck", True, None, False), ("valve", True, (0.01, 1), True), ("flip", True, (0.01, 5), False),
         ("lag", False, (0.002, 0.05), False), ("loss", False, (0.1, 50), False))


def draw(count, seed=1):
    dice = random.Random(seed)
    for n in range(int(count)):
        kind, leg, values, signed = KINDS[n % len(KINDS)]
        begin, length = dice.uniform(1.8, 12), dice.choice((100, math.exp(dice.uniform(math.log(0.01), math.log(3)))))
        text = f"{kind}@{begin:.3f}+{length:.3f}" + f"/{dice.randint(1, 6)}" * leg
        if values:
            text += f"={math.exp(dice.uniform(*map(math.log, values))) * (dice.choice((-1, 1)) if signed else 1):.3g}"
        print(f"{n} {text}|{text}|{begin:.3f}|any|0")


if __name__ == "__main__":
    try:
        draw(*sys.argv[2:]) if sys.argv[1] == "draw" else judge(*sys.argv[1:])
    except Failed as failed:
        sys.exit(f"{sys.argv[1]}: {failed}")
