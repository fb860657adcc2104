#!/usr/bin/env python3
"""`make bench-rt`: hexid's wake-ups beside cyclictest's, in turns on the same processor in the same minutes.

    bench_rt.py [--turns 5] [--slot 7] [--rates 500,1000,2000,5000,8000,10000] [-o build/bench_rt.md] [--csv build/bench_rt.csv]

1. Idle, then with stress-ng on the other processors: cyclictest, the loop on sim:, cyclictest, the loop on Modbus TCP (a plant of its own
   on loopback), cyclictest, ... Each run of the loop is compared with the cyclictest before and the one after it (geometric mean), and
   those two with each other: the second ratio shows how exact the first one is. Medians of the turns.
2. The loop's rate, closed-form plant: the same at each rate; the rate is held where the loop's wake-ups a whole period late are no more
   than 1.5 times cyclictest's (and one in a thousand), and 99 % of the cycles take less than half a period.

3. Heap calls, locks, page faults and stack of each thread (counts.py).

On a busy machine the figures reflect the other work. Ends with an error if something was not measured; no figure is judged by
the exit status. Environment: HEXID. Needs root."""
import argparse, csv, math, os, statistics, subprocess, sys, time

sys.dont_write_bytecode = True # leaves no files in the tree
sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "bench"))
import counts, measured, wake

COLUMNS = ("p50", "p99", "p999", "max")
WANTED = {"sim:": 1.1, "modbus": 1.3}  # limits for the wake-ups' p99 relative to cyclictest's
MISSED_RATIO, MISSED_SHARE = 1.5, 1e-3


class Stress:
    """Runs stress-ng on the processors that the loop does not use: arithmetic, memory, system calls, context switches."""

    def __init__(self, on): self.on, self.process = on, None

    def __enter__(self):
        if not self.on: return self
        command = ["stress-ng", "--quiet", "--cpu", "1", "--vm", "1", "--vm-bytes", "64M", "--switch", "1", "--timer", "1", "--temp-path", "/tmp"]
        try: self.process = subprocess.Popen(wake.elsewhere(command), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        except OSError as e: wake.fail("stress-ng: %s: make deps-bench" % e.strerror)
        time.sleep(1)
        if self.process.poll() is not None: wake.fail("stress-ng ended with status %d" % self.process.returncode)
        return self

    def __exit__(self, *unused):
        if not self.process: return
        alive = self.process.poll() is None
        self.process.terminate()
        self.process.wait()
        if not alive: wake.fail("stress-ng ended before the measurement")


def ratio(a, b): return measured.finite(a / max(b, 1e-3), "ratio")


class Turns:
    """Runs cyclictest and other sleepers in turns."""

    def __init__(self, period_s, slot_s):
        self.period_s, self.slot_s, self.bare, self.runs, self.itself = period_s, slot_s, [], {}, []
        self.cyclictest()

    def cyclictest(self): self.bare.append(wake.cyclictest(self.slot_s, self.period_s))

    def turn(self, name, sleeper):
        """Runs a sleeper between two runs of cyclictest."""
        run = sleeper(self.slot_s, self.period_s)
        self.cyclictest()
        before, after = self.bare[-2:]
        self.itself.append({c: ratio(after[c], before[c]) for c in COLUMNS})
        self.runs.setdefault(name, []).append((run, {c: ratio(run[c], math.sqrt(before[c] * after[c])) for c in COLUMNS}))

    def median(self, name, c): return statistics.median(run[c] for run, _ in self.runs[name])

    def median_ratio(self, name, c): return statistics.median(r[c] for _, r in self.runs[name])

    def spread(self, c):
        """Returns the ratio of cyclictest to itself one slot later: the median of the larger over the smaller."""
        return statistics.median(max(r[c], 1 / r[c]) for r in self.itself)

    def late(self, name):
        """Returns wake-ups a period late per million: the sleeper's and cyclictest's."""
        runs = [run for run, _ in self.runs[name]]
        return tuple(1e6 * sum(w["late"] for w in of) / sum(w["count"] for w in of) for of in (runs, self.bare))


def table(out, rows, name, values):
    print("| %s | %s |" % (name, " | ".join(values)), file=out, flush=True)
    rows.append((name, *values))


def beside(a, out, rows, stressed):
    load = "stress-ng on the others" if stressed else "idle"
    with Stress(stressed), wake.Plant() as plant:
        turns = Turns(.002, a.slot)
        for _ in range(a.turns):
            turns.turn("sim:", wake.loop)
            turns.turn("modbus", lambda seconds, period_s: wake.loop(seconds, period_s, plant.url))
    bare = ["%.0f" % statistics.median(w[c] for w in turns.bare) for c in COLUMNS]
    table(out, rows, "%s: cyclictest, us" % load, bare + ["%.0f" % turns.late("sim:")[1], ""])
    table(out, rows, "%s: cyclictest over itself" % load, ["%.2f" % turns.spread(c) for c in COLUMNS] + ["", ""])
    for name, limit in WANTED.items():
        late, over, spread = turns.late(name)[0], turns.median_ratio(name, "p99"), turns.spread("p99")
        table(out, rows, "%s: %s, us" % (load, name), ["%.0f" % turns.median(name, c) for c in COLUMNS] + ["%.0f" % late, ""])
        said = "yes" if over <= limit else "yes: cyclictest's own spread" if over <= spread else "NO"
        table(out, rows, "%s: %s over cyclictest" % (load, name), ["%.2f" % turns.median_ratio(name, c) for c in COLUMNS] +
              ["", "%s (%.1f)" % (said, limit)])
    return turns


def doctor_beside(a, out, rows):
    turns = Turns(.002, a.slot)
    for _ in range(3): turns.turn("doctor", wake.doctor)
    table(out, rows, "idle: doctor --latency over cyclictest", ["%.2f" % turns.median_ratio("doctor", c) for c in COLUMNS] + ["", ""])


def substeps(period_s): return max(1, math.ceil(period_s / 2.5e-4 - 1e-9))


def rate(a, out, hz, turns_count):
    """Measures the loop at this rate. Returns the rate if it is held, else 0."""
    period_s = 1 / hz
    settings = ["sim.engine=closed_form", "sim.substeps=%d" % substeps(period_s)]
    turns = Turns(period_s, a.rate_slot)
    for _ in range(turns_count): turns.turn("loop", lambda seconds, period: wake.loop(seconds, period, settings=settings))
    late, bare = turns.late("loop")
    runs = [run for run, _ in turns.runs["loop"]]
    exec_us = statistics.median(r["exec_p99"] for r in runs)
    held = late <= max(MISSED_RATIO * bare, 1e6 * MISSED_SHARE if hz != 5000 else 0) and exec_us < .5e6 * period_s
    print("| %d | %.0f | %.0f | %.2f | %.0f | %.0f | %.1f | %.1f | %.1f | %s |" % (
        hz, turns.median("loop", "p99"), statistics.median(w["p99"] for w in turns.bare), turns.median_ratio("loop", "p99"), late, bare,
        statistics.median(r["exec_p50"] for r in runs), exec_us, max(r["exec_max"] for r in runs), "yes" if held else "NO"), file=out, flush=True)
    return hz if held else 0


def threads(out):
    """Prints the activity of each of the daemon's threads from its first sleep on, and its stack; on sim:, then on Modbus."""
    print("\n| back-end | thread | sleeps | heap calls | locks | page faults | stack, bytes |\n|" + " --- |" * 7, file=out)
    with wake.Plant() as plant:
        for name, url in (("sim:", "sim:"), ("modbus", plant.url)):
            command = [wake.HEXID, "run", "--hal", url, "--rt", "try", "--tests", "x", "--json", "/dev/null"]
            keys = wake.ENDURES + ["loop.overrun_limit=%d" % (wake.STALL_S / .002), "motion.automatic=true", "motion.engage_s=3", "motion.park_s=3"]
            found, _ = counts.counted([os.path.abspath(command[0]), *command[1:], *(x for k in keys for x in ("--set", k))])
            if not any(t["thread"] == "loop_thread" and t["sleeps"] for t in found): wake.fail("the loop was not counted")
            for t in found:
                print("| %s | %s | %d | %d | %d | %d | %d |" % (name, t["thread"], t["sleeps"], t["heap"], t["locks"], t["minor_faults"] + t["major_faults"],
                                                              t["stack_bytes"]), file=out, flush=True)


def measure(a, out):
    rows, start = [], time.monotonic()
    print("%s, %s, %d processors, %s; %d turns of %g s, processor %d\n" % (measured.build(), os.uname().release, os.cpu_count(), time.strftime("%Y-%m-%d %H:%M UTC", time.gmtime()),
                                                                     a.turns, a.slot, wake.CPU), file=out)
    print("| wake-up after the deadline, 2 ms | p50 | p99 | p99.9 | max | a period late, per million | p99 as wanted |\n|" + " --- |" * 7, file=out)
    for stressed in (False, True): beside(a, out, rows, stressed)
    doctor_beside(a, out, rows)
    print("\n| rate, Hz | wake p99, us | cyclictest's | ratio | a period late, per million | cyclictest's | cycle p50, us | p99 | max | held |\n|" +
          " --- |" * 10, file=out)
    held = [rate(a, out, hz, a.turns if hz == 5000 else 1) for hz in a.rates]
    threads(out)
    print("\nhighest rate held: %d Hz; measured in %.0f s" % (max(held), time.monotonic() - start), file=out)
    with open(a.csv, "w", newline="") as file:
        print("# " + measured.build(), file=file)
        w = csv.writer(file, lineterminator="\n")
        w.writerow(("what", *COLUMNS, "late_per_million", "wanted"))
        w.writerows(rows)


class Both:
    """Writes to the terminal and the file."""

    def __init__(self, path): self.file = open(path, "w")

    def write(self, text): sys.stdout.write(text), self.file.write(text)

    def flush(self): sys.stdout.flush(), self.file.flush()


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--turns", type=int, default=5)
    p.add_argument("--slot", type=float, default=7)
    p.add_argument("--rate-slot", type=float, default=7)
    p.add_argument("--rates", type=lambda text: [int(x) for x in text.split(",")], default=[500, 1000, 2000, 5000, 8000, 10000])
    p.add_argument("-o", dest="page", default="build/bench_rt.md")
    p.add_argument("--csv", default="build/bench_rt.csv")
    a = p.parse_args()
    if a.turns < 1 or not a.rates: p.error("one turn and one rate, at least")
    if subprocess.run(["chrt", "-f", "80", "true"], capture_output=True).returncode: wake.fail("this user has no SCHED_FIFO: run as root")
    measure(a, Both(a.page))


if __name__ == "__main__": main()
