#!/usr/bin/env python3
"""Method C's springs on the independent rig (tests/rig/), which has hoses of its own.

    rig_springs.py [--seeds 8] [--first 1] [--keep DIR]

Each seed draws six springs and records six tests at 4 Hz and six at 2 Hz with the paper's sensors. Prints for the
result of `hexid identify`: errors of springs and of Mt's diagonal in % and in stated deviations, rms over the seeds; how many of the 95 %
intervals of all 21 entries contain the truth; and Mt without springs in the model. Environment: HEXID, RIG."""
import argparse, concurrent.futures, contextlib, json, math, os, random, statistics, sys, tempfile

sys.dont_write_bytecode = True # leaves no files in the tree

from rig_friction import HEXID, RIG, called, measured, options

AXES, SIZE = "x y z phi theta psi".split(), [8e3] * 3 + [1.5e3] * 3
ASKED = ["--set", "model.tolerance.springs_n_per_m=1e4", "--set", "model.tolerance.springs_nm_per_rad=2e3"]


def identified(logs, work, more=()):
    called([HEXID, "identify", *logs, "--json", work + "/run.json", *more])
    with open(work + "/run.json") as file: return measured.enough(json.load(file)["combined"]["method_c"], work + ": method C")


def run(seed, keep):
    r = random.Random(seed)
    springs = [size * r.uniform(.3, 1) for size in SIZE]
    with contextlib.ExitStack() as stack:
        work = os.path.join(keep, "springs_%d" % seed) if keep else stack.enter_context(tempfile.TemporaryDirectory())
        logs = []
        for hz in (4, 2):
            logs.append("%s/%d.lcm" % (work, hz))
            if os.path.exists(logs[-1]): continue
            hidden = {"external_stiffness." + axis: k for axis, k in zip(AXES, springs)}
            called([RIG, "-o", "%s/%d" % (work, hz), "--set", "tests.frequency_hz=%d" % hz, "--noise", str(10 * seed + hz)]
                   + options("--effect", hidden))
            called([HEXID, "import", "%s/%d" % (work, hz), "-o", logs[-1]])
        return springs, identified(logs, work, ASKED), identified(logs, work)


def rms(values): return measured.finite(math.sqrt(statistics.fmean(x * x for x in values)), "rms")


def main():
    p = argparse.ArgumentParser()
    p.add_argument("--seeds", type=int, default=8)
    p.add_argument("--first", type=int, default=1)
    p.add_argument("--keep")
    a = p.parse_args()
    print(measured.build())
    truth = json.loads(called([RIG, "--inertia-matrix"]))
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        runs = list(pool.map(lambda seed: run(seed, a.keep), range(a.first, a.first + a.seeds)))
    for i, axis in enumerate(AXES):
        error = [c["springs"]["value"][i] - springs[i] for springs, c, _ in runs]
        mine = [c["Mt"][i][i] - truth[i][i] for _, c, _ in runs]
        print("%-6s spring %5.2f %% %5.2f deviations;  Mt %5.2f %% %5.2f deviations, not asked for %+6.2f %%" % (
            axis, 100 * rms(e / s[i] for e, (s, _, _) in zip(error, runs)), rms(e / c["springs"]["std"][i] for e, (_, c, _) in zip(error, runs)),
            100 * rms(m / truth[i][i] for m in mine), rms(m / c["std"][i][i] for m, (_, c, _) in zip(mine, runs)),
            100 * statistics.fmean(c["Mt"][i][i] / truth[i][i] - 1 for _, _, c in runs)))
    hold = [abs(c["Mt"][i][j] - truth[i][j]) <= 1.96 * c["std"][i][j] for _, c, _ in runs for i in range(6) for j in range(i, 6)]
    print("%.1f %% of %d intervals hold" % (100 * statistics.fmean(hold), len(hold)))


if __name__ == "__main__": main()
