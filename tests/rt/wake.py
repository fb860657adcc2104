#!/usr/bin/env python3
"""Lateness of threads' wake-ups: cyclictest, hexid's loop and `hexid doctor --latency`, each for so many seconds, in the same form.

    wake.py cyclictest|loop|doctor SECONDS     p50 p99 p99.9 max [us], wake-ups a period late, wake-ups

All run at SCHED_FIFO 80 on the same processor (the last one that this process may use), with the loop's period, clock and absolute
deadlines; what else hexid has to do runs on the others, as isolcpus= would have it. Latencies of both go through a histogram of the same bins
(include/histogram.h), and cyclictest leaves the idle states of the processor as they are: it would otherwise measure another machine than
hexid gets. Environment: HEXID. Needs root, or SCHED_FIFO and locked memory."""
import json, math, os, signal, subprocess, sys, tempfile

HEXID = os.environ.get("HEXID", "build/hexid")
PRIORITY, STEPS, LATEST_US = 80, 16, 200000
MOVE_S, REST_S = 3.0, .2  # the loop's moves up and down, its rests and ramps
QUANTILES = {"p50": .5, "p99": .99, "p999": .999}
CPUS = sorted(os.sched_getaffinity(0))
CPU, OTHERS = CPUS[-1], CPUS[:-1] or CPUS
# The run must go on, and be counted, even if the machine stalls.
STALL_S, HANG_S = 5, 120
ENDURES = ["limits.blind_time_s=10", "checks.overruns_pct=100", "checks.excluded_pct=100", "lcm.url="]


def fail(text): raise SystemExit("%s: %s" % (os.path.basename(sys.argv[0]), text))


def edge_us(us):
    """Returns the upper edge of the histogram's bin, as histogram_quantile() does."""
    ns = int(us * 1e3)
    shift = max(0, ns.bit_length() - 5)
    return (((ns >> shift) + 1 << shift) - 1) / 1e3


def quantile_us(count, total, share):
    wanted, seen = int(share * total), 0
    for us in sorted(count):
        seen += count[us]
        if seen > wanted: return edge_us(us + .5)    # cyclictest rounds down
    return edge_us(max(count))


def elsewhere(command, cpus=OTHERS): return ["taskset", "-c", ",".join(map(str, cpus)), *command]


def run(command, statuses=(0,)):
    try: done = subprocess.run(command, capture_output=True, text=True, timeout=HANG_S)
    except subprocess.TimeoutExpired: fail("%s: hung for %d s" % (" ".join(command[:8]), HANG_S))
    except OSError as e: fail("%s: %s: make deps-bench" % (command[0], e.strerror))
    if done.returncode not in statuses: fail("%s: status %d: %s" % (" ".join(command[:8]), done.returncode, (done.stderr or done.stdout).strip()[-400:]))
    return done.stdout


def cyclictest(seconds, period_s=.002):
    out = run(["cyclictest", "--quiet", "--default-system", "--mlockall", "--policy=fifo", "--priority=%d" % PRIORITY, "--threads=1",
               "--affinity=%d" % CPU, "--interval=%d" % round(1e6 * period_s), "--duration=%d" % math.ceil(seconds), "--histogram=%d" % LATEST_US])
    count, most, over = {}, 0, 0
    for line in out.splitlines():
        word = line.split()
        if line[:1].isdigit() and int(word[1]): count[int(word[0])] = int(word[1])
        if line.startswith("# Max Latencies"): most = int(word[-1])
        if line.startswith("# Histogram Overflows"): over = int(word[-1])
    if not count: fail("cyclictest: not one wake-up in %g s: %s" % (seconds, out.strip()[-200:]))
    if over: count[most] = count.get(most, 0) + over
    total = sum(count.values())
    late = sum(n for us, n in count.items() if us >= 1e6 * period_s)
    return {k: quantile_us(count, total, q) for k, q in QUANTILES.items()} | {"max": float(most), "late": late, "count": total}


def loop(seconds, period_s=.002, url="sim:", settings=()):
    """Runs the loop for about `seconds`: engage, one test, park. Returns also exec_p50, exec_p99 and exec_max [us] of the whole cycle,
    back-end included."""
    test_s = max(.5, seconds - 2 * MOVE_S - 3 * REST_S)
    keys = ENDURES + ["loop.overrun_limit=%d" % (STALL_S / period_s), "loop.cpu=%d" % CPU, "loop.priority=%d" % PRIORITY, "loop.period_s=%.9g" % period_s, "checks.period_s=%.9g" % max(.003, period_s),
                      "motion.engage_s=%g" % MOVE_S, "motion.park_s=%g" % MOVE_S, "motion.hold_s=0", "motion.automatic=true", "tests.settle_s=%g" % REST_S,
                      "tests.ramp_s=%g" % REST_S, "tests.ramp_out_s=%g" % REST_S, "tests.duration_s=%.9g" % test_s, *settings]
    with tempfile.TemporaryDirectory() as work:
        command = [HEXID, "run", "--hal", url, "--rt", "require", "--tests", "x", "--log", work + "/a.lcm", "--json", work + "/a.json"]
        run(elsewhere(command + [x for k in keys for x in ("--set", k)]), (0, 1))
        with open(work + "/a.json") as file: result = json.load(file)
    l = result["loop"]
    if not l["wake_us"] or not l["cycles"]: fail("hexid run: no wake-up was timed")
    if not any(t["complete"] for t in result["tests"]): fail("hexid run --hal %s: its test was not done: %s" % (url, result["verdict"]["reasons"]))
    wake = {k: float(v) for k, v in l["wake_us"].items()}
    return wake | {"late": l["overruns"], "count": l["cycles"], "lost": l["lost_records"], **{"exec_" + k: v for k, v in l["exec_us"].items()}}


def doctor(seconds, period_s=.002):
    with tempfile.TemporaryDirectory() as work:
        run(elsewhere([HEXID, "doctor", "--latency", "%d" % math.ceil(seconds), "--json", work + "/a.json", "--set", "lcm.url=", "--set", "loop.cpu=%d" % CPU,
                       "--set", "loop.priority=%d" % PRIORITY, "--set", "loop.period_s=%.9g" % period_s]), (0, 1))
        with open(work + "/a.json") as file: data = next(f["data"] for f in json.load(file)["findings"] if f["name"] == "wake-up")
    if not data or not data["count"]: fail("hexid doctor: no wake-up was timed")
    return {k: float(data[k + "_us"]) for k in (*QUANTILES, "max")} | {"late": data["missed"], "count": data["count"]}


class Plant:
    """Runs `hexid plant` on Modbus TCP, on the other processors; `url` is where the loop finds it."""

    def __init__(self, settings=()):
        command = [HEXID, "plant", "--bus", "modbus:tcp://127.0.0.1:0", "--set", "sim.engine=closed_form"] + [x for s in settings for x in ("--set", s)]
        self.process = subprocess.Popen(elsewhere(command), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        said = []
        for line in self.process.stdout:
            said.append(line)
            if "ready on " in line: break
        else: fail("hexid plant: " + "".join(said).strip()[-400:])
        self.url = line.split("ready on ")[1].split()[0]

    def __enter__(self): return self

    def __exit__(self, *unused):
        self.process.send_signal(signal.SIGTERM)
        self.process.stdout.read()
        self.process.wait()


def main():
    of = {"cyclictest": cyclictest, "loop": loop, "doctor": doctor}
    if len(sys.argv) != 3 or sys.argv[1] not in of: fail("usage: wake.py cyclictest|loop|doctor SECONDS")
    w = of[sys.argv[1]](float(sys.argv[2]))
    print(*("%.4g" % w[k] for k in ("p50", "p99", "p999", "max")), w["late"], w["count"])


if __name__ == "__main__": main()
