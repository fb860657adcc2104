#!/usr/bin/env python3
"""Method C on the independent rig (tests/rig/), with laws of friction that it fits and laws that it does not.

    rig_friction.py [--seeds 8] [--first 1] [--case NAME ...] [--keep DIR] [KEY=VALUE ...]

Prints errors of the ten entries against the rig's own inertia matrix in % of the entry, with exact sensors and as rms over the seeds with
the paper's. Prints also how many of the 95 % intervals of all 21 entries contain the rig's value, and the largest mean error over the seeds
in stated deviations. --keep keeps the recordings and reuses existing ones. Environment: HEXID, RIG."""
import argparse, concurrent.futures, contextlib, json, math, os, statistics, subprocess, sys, tempfile

sys.dont_write_bytecode = True # leaves no files in the tree
sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "bench"))
import measured

HEXID = os.environ.get("HEXID", "build/hexid")
RIG = os.environ.get("RIG", "build/tests/rig/rig")
ENTRIES = {"mx": (0, 0), "my": (1, 1), "mz": (2, 2), "Ixx": (3, 3), "Iyy": (4, 4), "Izz": (5, 5), "Mt15": (0, 4), "Mt24": (1, 3)}
GROUPS = {"masses": "m", "inertias": "I", "coupling": "M"}  # groups of entries by their first letter


def coulomb(n): return {"cylinder_coulomb_friction.force_%s_n" % way: n for way in ("extend", "retract")}


def stribeck(n, mps): return {"cylinder_stribeck_friction.excess_n": n, "cylinder_stribeck_friction.velocity_mps": mps}


def lugre(n, give_um, excess_n=0, mps=.02):
    return {"bristle_friction.force_n": n, "bristle_friction.give_m": give_um * 1e-6, "bristle_friction.damping_n_s_per_m": 500,
            "bristle_friction.excess_n": excess_n, "bristle_friction.velocity_mps": mps}


CASES = {
    "none": {},
    "coulomb_100": coulomb(100),
    "coulomb_200": coulomb(200),
    "stribeck_10": coulomb(100) | stribeck(100, .01),
    "stribeck_20": coulomb(100) | stribeck(100, .02),
    "stribeck_17": coulomb(100) | stribeck(100, .017),
    "stribeck_34": coulomb(100) | stribeck(100, .034),
    "load": coulomb(50) | {"load_dependent_friction.mu": .02},
    "lugre_50": lugre(100, 50),
    "lugre_100": lugre(100, 100),
    "lugre_200": lugre(100, 200),
    "lugre_100_stribeck": lugre(100, 100, 50),
}


def called(command):
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode not in (0, 1): raise SystemExit("%s: %s" % (" ".join(command), done.stderr.strip()))
    return done.stdout


def options(flag, settings): return [x for k, v in settings.items() for x in (flag, "%s=%.9g" % (k, v))]


def run(case, seed, keep, settings):
    """Returns method C's result of one recording; seed 0: exact sensors."""
    enabled = ["--set", "sensors.enabled=" + ("true" if seed else "false")]
    more = [x for s in settings for x in ("--set", s)]
    with contextlib.ExitStack() as stack:
        work = os.path.join(keep, "%s_%d" % (case, seed)) if keep else stack.enter_context(tempfile.TemporaryDirectory())
        if not os.path.exists(work + "/measured/5.csv"):
            called([RIG, "-o", work + "/measured"] + enabled + more + (["--noise", str(seed)] if seed else []) + options("--effect", CASES[case]))
        if not os.path.exists(work + "/run.lcm"): called([HEXID, "import", work + "/measured", "-o", work + "/run.lcm"])
        called([HEXID, "identify", work + "/run.lcm", "--json", work + "/run.json"] + enabled + more)
        with open(work + "/run.json") as file: return measured.enough(json.load(file)["method_c"], "%s, seed %d: method C" % (case, seed))


def largest(error): return ["%6.2f" % max(abs(measured.finite(error[e], e)) for e in ENTRIES if e[0] == letter) for letter in GROUPS.values()]


def report(case, exact, noisy, truth):
    def errors(c): return {e: 100 * (c["Mt"][i][j] / truth[i][j] - 1) for e, (i, j) in ENTRIES.items()}
    if not noisy: return print("%-20s" % case, " / ".join(largest(errors(exact))), flush=True)
    rms = {e: math.sqrt(statistics.fmean(errors(c)[e] ** 2 for c in noisy)) for e in ENTRIES}
    off = [[(c["Mt"][i][j] - truth[i][j]) / c["std"][i][j] for i in range(6) for j in range(i, 6)] for c in noisy]
    hold = statistics.fmean(abs(x) <= 1.96 for row in off for x in row)
    bias = max(abs(statistics.fmean(column)) for column in zip(*off))
    print("%-20s" % case, " / ".join(largest(errors(exact))), "  ", " / ".join(largest(rms)), "  %5.1f  %5.2f" % (100 * hold, bias))
    print(" " * 20, " ".join("%s %+.2f (%.2f)" % (e, errors(exact)[e], rms[e]) for e in ENTRIES), flush=True)


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--seeds", type=int, default=8)
    p.add_argument("--first", type=int, default=1)
    p.add_argument("--case", action="append", choices=CASES)
    p.add_argument("--keep")
    p.add_argument("settings", nargs="*")
    a = p.parse_args()
    print(measured.build())
    truth = json.loads(called([RIG, "--inertia-matrix"] + [x for s in a.settings for x in ("--set", s)]))
    print("largest error of masses / inertias / coupling, %: exact sensors; rms of", a.seeds, "seeds; intervals that hold, %; mean, deviations")
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        futures = {case: [pool.submit(run, case, seed, a.keep, a.settings) for seed in [0, *range(a.first, a.first + a.seeds)]]
                   for case in a.case or CASES}
        for case, (exact, *noisy) in futures.items(): report(case, exact.result(), [f.result() for f in noisy], truth)


if __name__ == "__main__": main()
