"""Judges one run with a fault by its log and its JSON, for every back-end alike. Prints a row of the README's table; exit status 1 when
something is not as it must be. Needs the log's types: lcm-gen -p --ppath DIR lcmtypes/*.lcm, and PYTHONPATH=DIR.

    faults.py NAME FROM_S EXPECTED WITHIN LOG JSON CLEAN_JSON

FROM_S: when the fault begins, on the loop's clock. EXPECTED: what must see it first: faults, by name and with | between them, within WITHIN
cycles; `flagged`, samples that the identification leaves out; `verdict`, the end of the run; `nothing`, when it must do no harm.
Always: valves centred with a fault and in every state that does not drive, commands within -1..1, no cycle missing in the log, and an
identification that is refused or differs from the clean run's by no more than three standard deviations of the sensors' noise."""
import json, math, struct, sys

import hexid, lcm

FAULTS = ("sensor_age", "sensor_invalid", "stroke", "leg_rate", "following_error", "force", "kinematics", "overrun", "io", "standstill")
DRIVEN = (2, 3, 4, 5)  # engaging, ready, testing, parking
UNHARMED = {"m": 2.1, "I": 3.6, "M": 12.0}  # %, by the entry's first letter: 3 x the rms over 30 seeds that figures.py demands


class Failed(Exception):
    pass


def demand(holds, *words):
    if not holds:
        raise Failed(" ".join(str(word) for word in words))


def cycles_of(path):
    return [hexid.state_t.decode(event.data) for event in lcm.EventLog(path, "r") if event.channel == "HEXID_STATE"]


def check_outputs(cycles):
    for before, c in zip([None] + cycles, cycles):
        demand(before is None or c.seq == before.seq + 1, "cycles are missing before", c.seq)
        demand(c.enable == (c.state in DRIVEN), "state", c.state, "enable", c.enable, "in cycle", c.seq)
        demand(not (c.faults and c.enable), "driven with a fault in cycle", c.seq)
        demand(all(abs(v) <= 1 for v in c.valve), "valves", c.valve, "in cycle", c.seq)  # false for NaN
        demand(c.enable or not any(c.valve), "valves not centred in cycle", c.seq)


def legs_of(c):
    return [leg + 1 for leg in range(6) if c.faults >> 16 + leg & 1]


def detection(cycles, from_s):
    """What saw it first, the legs it names, and after how many cycles."""
    after = [c for c in cycles if c.time_ns + c.age_ns >= from_s * 1e9 - 1]
    demand(after, "the run ended before the fault began")
    for n, c in enumerate(after, 1):
        if c.first_fault:
            return FAULTS[c.first_fault.bit_length() - 1], legs_of(c), n
    flagged = [n for n, c in enumerate(after, 1) if c.sample_flags]
    return ("flagged", [], flagged[0]) if flagged else ("nothing", [], 0)


def identification(result, clean):
    verdict = result["verdict"]
    if verdict["status"] != "pass":
        return False, "refused: " + (verdict["reasons"] + ["interrupted"])[0]
    ours, normal = result["errors_pct"]["method_a"], clean["errors_pct"]["method_a"]
    share, entry = max((abs(ours[name] - normal[name]) / UNHARMED[name[0]], name) for name in normal)
    demand(share <= 1, f"silently wrong: {entry} {ours[entry]:+.2f} %, {normal[entry]:+.2f} % in the clean run")
    return True, f"unharmed ({100 * share:.0f} % of the bound)"


def judge(name, from_s, expected, within, log, result, clean):
    cycles = cycles_of(log)
    check_outputs(cycles)
    found, legs, after = detection(cycles, float(from_s))
    passed, text = identification(json.load(open(result)), json.load(open(clean)))
    if found == "nothing" and not passed:
        found = "verdict"
    if found == "flagged" and expected == "verdict":
        found = "verdict"
    where = f", leg {legs[0]}" if len(legs) == 1 else f", legs {' '.join(map(str, legs))}" if legs else ""
    driven = "driven on" if found in ("flagged", "nothing", "verdict") else "centred"
    count = str(after) if found not in ("nothing", "verdict") else "-" if found == "nothing" else "end of run"
    row = f"| {name} | {found}{where} | {count} of {within} | {driven} | {text} |" if int(within) else f"| {name} | {found}{where} | {count} | {driven} | {text} |"
    print(row)
    demand(found in expected.split("|"), "found", found, "expected", expected)
    demand(not int(within) or after <= int(within), "after", after, "cycles, not", within)


if __name__ == "__main__":
    try:
        judge(*sys.argv[1:])
    except Failed as failed:
        sys.exit(f"{sys.argv[1]}: {failed}")
