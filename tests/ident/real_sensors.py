#!/usr/bin/env python3
"""Method C with sensors as real machines have them: gains, zeros, lags, skew, pipes; and with a base and a payload that are not rigid.

    real_sensors.py [-c FILE] [--truth rig|mujoco] [--machines 6] [--first 1] [--row NAME ...] [--dry N] [--jobs 1] [--recordings DIR]
                    [--hold PCT] [KEY=VALUE ...]

Each row of ROWS draws machines, records six tests of each by the independent rig (tests/rig/) or by MuJoCo's bodies (mujoco_machine.py), and
compares the result of `hexid identify` with that machine's own inertia matrix at neutral. Every machine has masses, valves, oil and viscous
friction within model.tolerance (`rig --tolerance`), its joints within model.tolerance.joints_m and --dry N of dry friction in each leg.
KEY=VALUE goes to `hexid identify` alone. Recordings in DIR are used again, so a DIR belongs to one --dry. --truth mujoco needs a Python that has
MuJoCo (`make bench-sensors TRUTH=mujoco`). Environment: HEXID, RIG."""
import argparse, concurrent.futures, contextlib, functools, json, math, os, random, re, shutil, statistics, subprocess, sys, tempfile

sys.dont_write_bytecode = True # leaves no files in the tree
HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "..", "bench"))
import measured

HEXID = os.environ.get("HEXID", "build/hexid")
MAIN = {"mx": 0, "my": 1, "mz": 2, "Ixx": 3, "Iyy": 4, "Izz": 5}
ENTRIES = [(i, k) for i in range(6) for k in range(i, 6)]
TRUTHS = { # Programs with the same options. The rig's step keeps fundamentals within 1e-6 of those at its own 0.25 ms, in 0.6 of the time.
    "rig": [os.environ.get("RIG", "build/tests/rig/rig"), "--step", ".5e-3", "--settle", "1"],
    "mujoco": [sys.executable, os.path.join(HERE, "mujoco_machine.py")],
}
TESTS = 6
BORE_M = .020     # of pipes
NO_PIPE_M = .05   # a shorter pipe is left out, because the rig's step would be below 20 us


def six(value): return [value] * 6


def scales(r, std): return {"pressure_sensor_scale.p%d" % side: [1 + r.gauss(0, std) for _ in range(6)] for side in (1, 2)}


def one_scale(r, error):
    legs = six(1)
    legs[r.randrange(6)] += r.choice((-1, 1)) * error
    return {"pressure_sensor_scale.p%d" % r.choice((1, 2)): legs}


def pipe(lengths_m, bore_m=BORE_M):
    return {"pipeline_dynamics.length_m": [x if x >= NO_PIPE_M else 0 for x in lengths_m], "pipeline_dynamics.diameter_m": six(bore_m)}


def lag(seconds): return {"pressure_sensor_lag.cutoff_hz": [1 / (2 * math.pi * x) if x > 0 else 0 for x in seconds]}


def skew(seconds):
    """Returns the effect of this skew; above zero the lengths are older than the pressures."""
    return {"%s_delay.delay_s" % ("position_sensor" if seconds > 0 else "pressure_sensor"): six(abs(seconds))}


def skew_of_tests(r, std_s):
    """Returns the effects of each test, whose skew is drawn anew for each."""
    return [skew(r.gauss(0, std_s)) for _ in range(TESTS)]


def compliance(stiffness_n_per_um): return {"leg_compliance.m_per_n": six(1e-6 / stiffness_n_per_um)}


def joints(r, most_m):
    return {"geometry_error.%s_%s_m" % (end, axis): [r.uniform(-most_m, most_m) for _ in range(6)] for end in "ab" for axis in "xyz"}


def length_scales(values): return {"position_sensor_scale.scale": values}


def zeros(lengths_m): return {"position_sensor_offset.offset_m": lengths_m}


def all_priors(r, config):
    """Draws one machine from the priors: each leg's own part, and a part in common where that is likely."""
    common_lag, common_pipe = abs(r.gauss(0, 1e-3)), abs(r.gauss(0, .3)) # neither is below zero
    pressure_pa = .005 * config["sensors.pressure_full_scale_pa"]
    return (scales(r, .005) | length_scales([1 + r.gauss(0, .001) for _ in range(6)]) | skew(r.gauss(0, .5e-3))
            | lag([max(0, common_lag + r.gauss(0, .5e-3)) for _ in range(6)])
            | pipe([max(0, common_pipe + r.gauss(0, .1)) for _ in range(6)]) | zeros([r.gauss(0, 1e-3) for _ in range(6)])
            | {"pressure_sensor_offset.p%d" % side: [r.gauss(0, pressure_pa) for _ in range(6)] for side in (1, 2)})


def base(hz): return {"base_spring.frequency_hz": six(hz)}


def payload(hz, config): return {"payload_mode.frequency_hz": six(hz), "payload_mode.mass_kg": six(.1 * config["payload.mass_kg"])}


ROWS = { # effects of each row's machine, drawn with r
    "as_modelled": lambda r, config: {},
    "gains_0.25%": lambda r, config: scales(r, .0025),
    "gains_0.5%": lambda r, config: scales(r, .005),
    "one_gain_0.5%": lambda r, config: one_scale(r, .005),
    "pipe_0.5m": lambda r, config: pipe(six(.5)),
    "pipe_0.5m_12mm": lambda r, config: pipe(six(.5), .012),
    "lag_1ms": lambda r, config: lag(six(1e-3)),
    "lag_2ms": lambda r, config: lag(six(2e-3)),
    "lag_5ms": lambda r, config: lag(six(5e-3)),
    "lengths_1ms_older": lambda r, config: skew(1e-3),
    "pressures_1ms_older": lambda r, config: skew(-1e-3),
    "skews_of_tests_0.5ms": lambda r, config: skew_of_tests(r, .5e-3),
    "skews_of_tests_2ms": lambda r, config: skew_of_tests(r, 2e-3),
    "legs_give_50N_um": lambda r, config: compliance(50),
    "legs_give_20N_um": lambda r, config: compliance(20),
    "base_15Hz": lambda r, config: base(15),
    "base_10Hz": lambda r, config: base(10),
    "payload_8Hz": lambda r, config: payload(8, config),
    "joints_2mm": lambda r, config: joints(r, 2e-3),
    "lengths_10mm": lambda r, config: zeros([r.uniform(-.01, .01) for _ in range(6)]),
    "length_gain_1%": lambda r, config: length_scales(six(1 + r.choice((-1, 1)) * .01)),
    "all_priors": all_priors,
}
NOT_RIGID = ["base_15Hz", "base_10Hz", "payload_8Hz"]


@functools.cache
def configured(file):
    """Returns the numbers and lists of the configuration, by section.key."""
    found, section = {}, []
    for line in called([HEXID, "run", "--print-config"] + (["-c", file] if file else [])).splitlines():
        key, _, value = line.split("#")[0].partition(":")
        section = section[:(len(key) - len(key.lstrip())) // 2] + [key.strip()]
        with contextlib.suppress(ValueError): found[".".join(section)] = json.loads(value)
    return measured.enough(found, "keys of the configuration")


def called(command):
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode: raise SystemExit("%s: %s" % (" ".join(command), done.stderr.strip()))
    return done.stdout


def draw(a, row, seed):
    """Draws the options of the machine, for the recording and for its matrix; a list of them where each test has its own."""
    r, config = random.Random("%s %d" % (row, seed)), configured(a.c)
    effects = joints(r, config["model.tolerance.joints_m"])
    effects |= {"cylinder_coulomb_friction.force_%s_n" % way: six(a.dry) for way in ("extend", "retract")}
    own = ROWS[row](r, config)
    return [(["-c", a.c] if a.c else []) + ["--tolerance", str(seed)] + [
        x for key, values in (effects | more).items() for x in ("--effect", "%s=%s" % (key, ",".join("%.9g" % v for v in values)))]
        for more in (own if isinstance(own, list) else [own])]


def record(a, seed, machine, directory):
    called(TRUTHS[a.truth] + ["-o", directory + "/measured", "--noise", str(seed)] + machine)


def recorded(a, row, seed, work):
    """Records the machine, unless it is there; the matrix is written last."""
    if not os.path.exists(work + "/matrix.json"):
        os.makedirs(work, exist_ok=True)
        machines = draw(a, row, seed)
        record(a, seed, machines[0], work)
        for test, machine in enumerate(machines[1:], 1): # A machine for each test: all six are recorded, and its own is kept.
            with tempfile.TemporaryDirectory() as other:
                record(a, seed, machine, other)
                shutil.copy("%s/measured/%d.csv" % (other, test), work + "/measured")
        matrix = json.loads(called(TRUTHS[a.truth] + ["--inertia-matrix"] + machines[0]))
        with open(work + "/matrix.json", "w") as file: json.dump(matrix, file)
    with open(work + "/matrix.json") as file: return json.load(file)


def identified(a, work, out):
    """Returns hexid's result; `refused` if hexid does not accept the log at all."""
    log, result = out + "/run.lcm", out + "/run.json"
    called([HEXID, "import", work + "/measured", "-o", log] + (["-c", a.c] if a.c else []))
    done = subprocess.run([HEXID, "identify", log, "--json", result] + [x for s in a.settings for x in ("--set", s)],
                          capture_output=True, text=True)
    if done.returncode > 1:
        reason = measured.enough(done.stderr.strip().splitlines(), work + ": reasons of status %d" % done.returncode)[-1]
        return {"method_c": None, "method_c_reason": None, "verdict": {"status": "refused", "reasons": [reason]}}
    with open(result) as file: return json.load(file)


def machine(a, row, seed):
    """Returns result and true matrix of one machine; nothing while only recording."""
    with tempfile.TemporaryDirectory() as out:
        config = os.path.splitext(os.path.basename(a.c))[0] if a.c else "default"
        work = os.path.join(a.recordings or out, a.truth, config, row, str(seed))
        truth = recorded(a, row, seed, work)
        return None if a.record else (identified(a, work, out), truth)


def quantile(values, share): return sorted(values)[min(len(values) - 1, math.ceil(share * len(values)) - 1)]


def verdicts(runs):
    count = {}
    for run, _ in runs: count[run["verdict"]["status"]] = count.get(run["verdict"]["status"], 0) + 1
    return ", ".join("%s %d" % pair for pair in sorted(count.items()))


def first_reason(runs):
    """Returns the most frequent reason, whatever its numbers: the first one of its kind."""
    reasons = [(run["verdict"]["reasons"] + [run["method_c_reason"]])[0] for run, _ in runs]
    reasons = [x for x in reasons if x]
    kinds = [re.sub(r"[-+]?[\d.]+", "N", x) for x in reasons]
    return reasons[kinds.index(max(kinds, key=kinds.count))] if kinds else "-"


def deviations(runs):
    """Returns the errors of all determined entries in stated deviations."""
    known = [(run["method_c"], truth) for run, truth in runs if run["method_c"]]
    return [measured.finite((c["Mt"][i][k] - truth[i][k]) / c["std"][i][k], "an entry") for c, truth in known for i, k in ENTRIES
            if c["Mt"][i][k] is not None]


def hold(off): return "%5.1f" % (100 * statistics.fmean(abs(z) <= 1.96 for z in off)) if off else "    -"


def report(row, runs):
    off, passed = deviations(runs), deviations([x for x in runs if x[0]["verdict"]["status"] == "pass"])
    rms = "%6.2f" % math.sqrt(statistics.fmean(z * z for z in off)) if off else "     -"
    print("%-20s %s %s %s %5d of %d  %s: %s" % (row, hold(off), hold(passed), rms, len(off), len(ENTRIES) * len(runs), verdicts(runs), first_reason(runs)))
    error, width = [], []
    for name, i in MAIN.items():
        cells = [(100 * abs(run["method_c"]["Mt"][i][i] / truth[i][i] - 1), 196 * run["method_c"]["std"][i][i] / truth[i][i])
                 for run, truth in runs if run["method_c"] and run["method_c"]["Mt"][i][i] is not None]
        if not cells: continue
        error.append("%s %.2f/%.2f" % (name, statistics.median(e for e, _ in cells), quantile([e for e, _ in cells], .95)))
        width.append("%s %.2f" % (name, statistics.median(w for _, w in cells)))
    print("    error", *error)
    print("    +-   ", *width, flush=True)
    return 100 * statistics.fmean(abs(z) <= 1.96 for z in passed) if passed else 0


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("-c", metavar="FILE")
    p.add_argument("--truth", choices=TRUTHS, default="rig")
    p.add_argument("--machines", type=int, default=6)
    p.add_argument("--first", type=int, default=1)
    p.add_argument("--row", action="append", choices=ROWS)
    p.add_argument("--dry", type=float, default=50)
    p.add_argument("--jobs", type=int, default=1)
    p.add_argument("--recordings", metavar="DIR")
    p.add_argument("--hold", type=float, metavar="PCT", default=0, help="an error where fewer intervals of machines that pass hold, or none passes")
    p.add_argument("--record", action="store_true", help="only record")
    p.add_argument("settings", nargs="*", metavar="KEY=VALUE")
    a = p.parse_args()
    rows = a.row or [row for row in ROWS if a.truth == "rig" or row not in NOT_RIGID]
    print("%s; truth: %s; %s" % (measured.build(), a.truth, " ".join([a.c or "the default configuration", *a.settings])))
    print("row: 95 % intervals that hold, %, and of machines that pass; rms of error/std; entries determined; verdicts: most frequent reason")
    print("     error: |error|, % of the entry, median/95th percentile; +-: median half width of its 95 % interval, %")
    short, seeds = [], measured.enough(range(a.first, a.first + a.machines), "machines")
    with concurrent.futures.ThreadPoolExecutor(a.jobs) as pool:
        futures = {row: [pool.submit(machine, a, row, seed) for seed in seeds] for row in rows}
        for row, runs in futures.items():
            runs = [f.result() for f in runs]
            if not a.record and report(row, runs) < a.hold: short.append(row)
    if short: measured.fail("%s: fewer than %g %% of the intervals of machines that pass hold" % (", ".join(short), a.hold))


if __name__ == "__main__": main()
