#!/usr/bin/env python3
"""Judge of calibration.sh: what `hexid identify` found about sensors whose errors are known."""
import json, sys

sys.dont_write_bytecode = True # leaves no files in the tree
MASSES = range(3)


def load(file):
    with open(file) as f: return json.load(f)


def width(run, i): return run["method_c"]["std"][i][i] / run["method_c"]["Mt"][i][i]


def held(run):
    """Checks the diagonal against the nominal matrix, which is true here, because the configured bodies are the machine's."""
    off = [(run["method_c"]["Mt"][i][i] - run["nominal"]["Mt"][i][i]) / run["method_c"]["std"][i][i] for i in range(6)]
    print("errors of the diagonal, in their deviations:", *("%+.2f" % z for z in off))
    return max(map(abs, off)) < 3.3


def narrower(alone, found, share):
    both = [(width(alone, i), width(found, i)) for i in MASSES]
    print("deviations of the masses, %:", *("%.3f -> %.3f" % (100 * a, 100 * b) for a, b in both))
    return all(b < share * a for a, b in both)


def errors(run, name): return [e for e in run["method_c"]["systematic"] if e["error"].startswith(name)]


def lengths(stops):
    print("[%s]" % ",".join("%.6f" % x for x in load(stops)["rest"]["length_m"]))
    return True


def zeros(alone, found, setting):
    alone, found, true = load(alone), load(found), json.loads(setting.partition("=")[2])
    off = [(e["value"] - zero) / e["std"] for e, zero in zip(errors(found, "zero of the length"), true)]
    print("zeros found, off in their deviations:", *("%+.2f" % z for z in off))
    return len(off) == 6 and max(map(abs, off)) < 3.3 and held(found) and narrower(alone, found, .8)


def weight(alone, found, gain):
    alone, found, gain = load(alone), load(found), float(gain)
    w = found["weight"]
    off = (w["reading_kg"] - (1 + gain) * w["stated_kg"]) / w["std_kg"]
    print("the weight reads %.3f kg, %+.2f deviations off; tests %d" % (w["reading_kg"], off, w["tests"]))
    near = sum(abs(e["value"] - gain) < 3.3 * e["std"] for e in errors(found, "gain of P"))
    return abs(off) < 3.3 and near == 12 and held(found) and narrower(alone, found, .96)


def same(found, again):
    a, b = load(found)["method_c"], load(again)["method_c"]
    return all(abs(x - y) <= 1e-9 * abs(x) for key in ("Mt", "std") for p, q in zip(a[key], b[key]) for x, y in zip(p, q))


def fails(found, words):
    verdict = load(found)["verdict"]
    print(verdict["status"], *verdict["reasons"], sep="\n")
    return verdict["status"] == "fail" and any(words in reason for reason in verdict["reasons"])


if __name__ == "__main__":
    judges = {f.__name__: f for f in (lengths, zeros, weight, same, fails)}
    sys.exit(0 if judges[sys.argv[1]](*sys.argv[2:]) else 1)
