"""paced.py FAST_LOG PACED_LOG FAST_JSON PACED_JSON: equal except for the host's clock; and the stamps of the paced log
are that clock's, stretched as the result states. Needs the log's types on PYTHONPATH."""
import json, sys

import hexid, lcm

OF_THE_HOST = {"wake_late_ns", "exec_ns"}


def events(path):
    for event in lcm.EventLog(path, "r"):
        if event.channel == "HEXID_LOOP_STATS":
            continue
        if event.channel == "HEXID_STATE":
            state = hexid.state_t.decode(event.data)
            yield event.channel, [repr(getattr(state, name)) for name in state.__slots__ if name not in OF_THE_HOST]
        else:
            yield event.channel, event.data


def result(path):
    whole = json.load(open(path))
    host = {key: whole["loop"].pop(key) for key in ("wake_us", "exec_us", "pace", "stalls", "longest_stall_s")}
    return whole, host


fast, paced = list(events(sys.argv[1])), list(events(sys.argv[2]))
print(len(fast), "events,", len(paced), "paced")
differ = [n for n, (a, b) in enumerate(zip(fast, paced)) if a != b]
if differ:
    print("the first that differs:", differ[0], fast[differ[0]], paced[differ[0]])
(fast_result, none), (paced_result, host) = result(sys.argv[3]), result(sys.argv[4])
print("the host:", host)
measured = all(value is None for value in none.values()) and 0 < host["pace"] < 1 and host["stalls"] > 0
stamps = [event.timestamp for event in lcm.EventLog(sys.argv[2], "r") if event.channel == "HEXID_STATE"]
took_s, own_s = (stamps[-1] - stamps[0]) / 1e6, (len(stamps) - 1) * 0.002
longest_s = max(b - a for a, b in zip(stamps, stamps[1:])) / 1e6
print(f"the log: {own_s:.3f} s of its own time in {took_s:.3f} s, the longest step {longest_s:.3f} s")
stamped = abs(took_s - own_s / host["pace"]) < 0.005 and abs(longest_s - host["longest_stall_s"]) < 0.005
sys.exit(bool(differ) or len(fast) != len(paced) or fast_result != paced_result or not measured or not stamped)
