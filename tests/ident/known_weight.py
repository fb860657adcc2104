#!/usr/bin/env python3
"""A known weight, weighed by the legs of machines with real sensors: is the gain that all pressures have in common found, and do method C's
intervals contain the truth with it?

    known_weight.py [-c FILE] [--machines 6] [--first 1] [--share 0.3] [--dry N] [--gain PCT] [--recordings DIR] [--hold PCT] [KEY=VALUE ...]

Machines are those of the row `all_priors` of real_sensors.py: gains, zeros, skew, lags, pipes and joints of the default tolerances. Each is
recorded twice by the independent rig (tests/rig/), as it is and with a weight of --share of its payload off its middle. --gain: error of all
pressures' gains beside these, in %. The rig's zeros do not drift, and its files have no rest. KEY=VALUE goes to `hexid identify`. Environment: HEXID, RIG."""
import argparse, json, math, os, random, statistics, subprocess, sys, tempfile

sys.dont_write_bytecode = True # leaves no files in the tree
HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, HERE)
import real_sensors as sensors
import measured

NO_DRIFT = ["--set", "model.tolerance.pressure_drift_pa=0"]


def drawn(a, seed):
    """Draws the options of a machine, all of whose pressures have an additional gain in common."""
    options = sensors.draw(a, "all_priors", seed)[0]
    for i, text in enumerate(options):
        key, _, values = text.partition("=")
        if key.startswith("pressure_sensor_scale."):
            options[i] = key + "=" + ",".join("%.9g" % (float(v) * (1 + a.gain / 100)) for v in values.split(","))
    return options


def weighted(a, seed, weight_kg):
    r = random.Random("weight %d" % seed)
    size = sensors.configured(a.c)["geometry.height_m"]
    off = ["payload_center_of_mass.%s_m=%.6f" % (axis, .05 * size * r.uniform(-1, 1)) for axis in "xyz"]
    return [x for e in ["payload_mass.mass_kg=%g" % weight_kg, *off] for x in ("--effect", e)]


def recorded(a, seed, work, weight_kg):
    """Records the logs without and with the weight, and the matrix without it, which is written last."""
    logs = [work + "/%s.lcm" % name for name in ("without", "with")]
    if not os.path.exists(work + "/matrix.json"):
        os.makedirs(work, exist_ok=True)
        machine = drawn(a, seed)
        for i, (log, more) in enumerate(zip(logs, ([], weighted(a, seed, weight_kg)))):
            rows = log[:-4]
            sensors.called(sensors.TRUTHS["rig"] + ["-o", rows, "--noise", str(2 * seed + i)] + machine + more)
            sensors.called([sensors.HEXID, "import", rows, "-o", log] + (["-c", a.c] if a.c else []))
        matrix = sensors.called(sensors.TRUTHS["rig"] + ["--inertia-matrix"] + machine)
        with open(work + "/matrix.json", "w") as file: file.write(matrix)
    with open(work + "/matrix.json") as file: return logs, json.load(file)


def identified(a, logs, more):
    with tempfile.TemporaryDirectory() as out:
        result = out + "/run.json"
        done = subprocess.run([sensors.HEXID, "identify", *logs, *more, "--json", result] + [x for s in a.settings for x in ("--set", s)],
                              capture_output=True, text=True)
        if done.returncode > 1: raise SystemExit(done.stderr.strip())
        with open(result) as file: return json.load(file)


def report(name, runs):
    off = sensors.deviations(runs)
    rms = math.sqrt(statistics.fmean(z * z for z in off))
    print("%-8s %s %% of %d intervals hold, rms of error/std %.2f; %s: %s" % (name, sensors.hold(off), len(off), rms, sensors.verdicts(runs),
                                                                     sensors.first_reason(runs)))
    print("    half widths, %:", *("%s %.2f" % (axis, statistics.median(
        196 * run["method_c"]["std"][i][i] / truth[i][i] for run, truth in runs)) for axis, i in sensors.MAIN.items()))
    print("    errors, %, median/largest:", *("%s %.2f/%.2f" % (axis, statistics.median(e), max(e)) for axis, e in (
        (axis, [100 * abs(run["method_c"]["Mt"][i][i] / truth[i][i] - 1) for run, truth in runs]) for axis, i in sensors.MAIN.items())))
    return 100 * statistics.fmean(abs(z) <= 1.96 for z in off)


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("-c", metavar="FILE")
    p.add_argument("--machines", type=int, default=6)
    p.add_argument("--first", type=int, default=1)
    p.add_argument("--share", type=float, default=.3)
    p.add_argument("--dry", type=float, default=50)
    p.add_argument("--gain", type=float, default=0)
    p.add_argument("--recordings", metavar="DIR")
    p.add_argument("--hold", type=float, metavar="PCT", default=0, help="an error where fewer intervals hold, with the weight")
    p.add_argument("settings", nargs="*", metavar="KEY=VALUE")
    a = p.parse_args()
    weight_kg = float("%.3g" % (a.share * sensors.configured(a.c)["payload.mass_kg"]))
    alone, weighed = [], []
    for seed in measured.enough(range(a.first, a.first + a.machines), "machines"):
        with tempfile.TemporaryDirectory() as out:
            config = os.path.splitext(os.path.basename(a.c))[0] if a.c else "default"
            logs, truth = recorded(a, seed, os.path.join(a.recordings or out, "weight", config, str(seed)), weight_kg)
            alone.append((identified(a, logs[:1], []), truth))
            weighed.append((identified(a, logs, ["--weight", "%g,0" % weight_kg, *NO_DRIFT]), truth))
        w = weighed[-1][0]["weight"]
        print("machine %d: %g kg read %+.3f %%, std %.3f" % (seed, weight_kg, 100 * (w["reading_kg"] / weight_kg - 1),
                                                       100 * w["std_kg"] / weight_kg), flush=True)
    print("%s; %s; weight %g kg, gains %+g %%" % (measured.build(), a.c or "the default configuration", weight_kg, a.gain))
    report("alone", alone)
    if report("weighed", weighed) < a.hold: measured.fail("fewer than %g %% of the intervals hold" % a.hold)


if __name__ == "__main__": main()
