#!/usr/bin/python3 -B
"""Methods A, B and C beside other authors' methods (least_squares.py), on the same recordings of the simulated platform.

    compare.py [--dry 0,100,200] [--seeds 6] [--choice NAME=VALUE ...] [KEY=VALUE ...]

Prints the error of each entry in % of the nominal one: with exact sensors, then rms over the seeds with the paper's. Environment: HEXID."""
import argparse, concurrent.futures, json, math, os, subprocess, sys, tempfile
import least_squares

sys.dont_write_bytecode = True # leaves no files in the tree
sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "bench"))
import measured

HEXID = os.environ.get("HEXID", "build/hexid")
METHODS = ("method_a", "method_b", "method_c", "least_squares", "wavelet")
BRIEF = ("sim.engine=closed_form", "lcm.url=", "motion.park_z_m=0.35", "motion.rate_mps=0.55", "motion.engage_s=1.6", "motion.park_s=1.6", "motion.hold_s=0.1")
ENTRIES = least_squares.ENTRIES


def run(dry_n, seed, choice, more):
    """Returns the errors in % by method and entry; seed 0: exact sensors."""
    settings = list(BRIEF) + ["sensors.enabled=" + ("true" if seed else "false")]
    if dry_n: settings += ["effects.cylinder_coulomb_friction.force_%s_n=%g" % (way, dry_n) for way in ("extend", "retract")]
    with tempfile.TemporaryDirectory() as work:
        done = subprocess.run([HEXID, "run", "--fast", "--seed", str(seed or 1), "--log", work + "/log.lcm", "--json", work + "/run.json"] +
                              [x for s in settings + more for x in ("--set", s)], capture_output=True, text=True)
        if done.returncode not in (0, 1): raise SystemExit(done.stderr.strip())
        with open(work + "/run.json") as file: own = json.load(file)
        found = own | least_squares.identify(least_squares.exported(work + "/log.lcm", work + "/csv"), choice)
    truth = own["nominal"]["Mt"]
    return {m: {e: 100 * (found[m]["Mt"][i][j] / truth[i][j] - 1) for e, (i, j) in ENTRIES.items()} for m in METHODS}


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--dry", default="0,100,200")
    p.add_argument("--seeds", type=int, default=6)
    p.add_argument("--choice", action="append", default=[])
    p.add_argument("settings", nargs="*")
    a = p.parse_args()
    choice = least_squares.chosen(a.choice)
    print(measured.build(), flush=True)
    cases = [(float(dry), seeds) for seeds in ([0], range(1, a.seeds + 1)) for dry in a.dry.split(",") if seeds]
    with concurrent.futures.ProcessPoolExecutor(os.cpu_count()) as pool:
        runs = [(dry, seeds, [pool.submit(run, dry, seed, choice, a.settings) for seed in seeds]) for dry, seeds in cases]
        for dry, seeds, futures in runs:
            results = [f.result() for f in futures]
            print("\ndry friction %g N, %s" % (dry, "rms of %d seeds with sensors" % len(results) if seeds[0] else "exact sensors"))
            print("%-14s" % "error, %", *("%8s" % e for e in ENTRIES))
            for m in METHODS:
                rms = {e: math.sqrt(sum(r[m][e] ** 2 for r in results) / len(results)) for e in ENTRIES}
                print("%-14s" % m, *("%8.2f" % measured.finite(rms[e] if seeds[0] else results[0][m][e], m + " " + e) for e in ENTRIES), flush=True)


if __name__ == "__main__": main()
