#!/usr/bin/env python3
"""`make soak-rt`: hexid on sim: at real pace for an hour, up, tests and down again and again, its log in parts under a quota.

    soak_rt.py [--seconds 3600] [--modbus] [-o build/soak_rt.md]

Prints, quarter by quarter of the time, the loop's own records (p50, p99, p99.9, max of the lateness, wake-ups a period late) and the
process's resources (memory, descriptors, page faults of the loop thread); then the moves, the content of the log's directory, and the
result of `hexid doctor --latency` on this computer right after. Ends with an error if memory or descriptors grow after the first quarter,
the loop meets a page fault, a record is lost, a move is not done, parts are missing, or the quota is not kept. Figures that depend on the
wall clock are printed and not judged. hexid runs with tests/rt/counts.c preloaded, hence unconfined.
--modbus: behind a plant of its own on Modbus TCP. Environment: HEXID. Needs root."""
import argparse, contextlib, glob, json, math, os, re, signal, subprocess, sys, tempfile, time

sys.dont_write_bytecode = True # leaves no files in the tree
sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "bench"))
import measured, wake
from counts import PRELOAD, functions as wake_names

NAME, QUARTERS = "soak%d" % os.getpid(), 4
PART_GB, QUOTA_GB = .01, .05  # 10 MB per part, so that parts come and go within minutes
MEMORY_KB = 8192  # more than this after the first quarter is growth: one minute of tests is 20 MB and is freed
SHORT = ["lcm.url=", "sim.engine=closed_form", "motion.automatic=false", "security.confine=false", "lcm.commands=true", "motion.engage_s=3", "motion.park_s=3", "tests.settle_s=0.3",
         "tests.ramp_s=0.3", "tests.ramp_out_s=0.3", "tests.duration_s=2", "machine.name=" + NAME, "loop.cpu=%d" % wake.CPU]


def status_of(pid, key):
    with open("/proc/%d/status" % pid) as file: return int(re.search(r"^%s:\s+(\d+)" % key, file.read(), re.M)[1])


def loop_thread(pid):
    """Returns the thread with SCHED_FIFO and the highest priority."""
    def priority(task):
        with open("/proc/%d/task/%s/stat" % (pid, task)) as file: return int(file.read().rsplit(")", 1)[1].split()[37])    # rt_priority
    return max(os.listdir("/proc/%d/task" % pid), key=priority)


def page_faults(pid, task):
    with open("/proc/%d/task/%s/stat" % (pid, task)) as file: words = file.read().rsplit(")", 1)[1].split()
    return int(words[7]) + int(words[9])    # minor and major


class Daemon:
    def __init__(self, work, url, quarter_s):
        self.logs = work + "/logs"
        os.mkdir(self.logs)
        before = [wake.HEXID, "run", "--fast", "--set", "sim.engine=closed_form", "--set", "lcm.url=", "--tests", "z", "--log", self.logs]
        subprocess.run(before, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.earlier, = os.listdir(self.logs) # a log of an earlier run, which the quota deletes; parts of the present run are kept
        command = [wake.HEXID, "run", "--hal", url, "--rt", "require", "--log", self.logs, "--log-part", str(PART_GB), "--log-quota", str(QUOTA_GB),
                   "--json", work + "/run.json"]
        self.result, self.said = work + "/run.json", open(work + "/said", "w+")
        keys = SHORT + wake.ENDURES + ["loop.overrun_limit=%d" % (wake.STALL_S / .002)]
        environment = os.environ | {"LD_PRELOAD": os.path.abspath(PRELOAD), "HEXID_COUNTS": work + "/counts", "HEXID_COUNTS_EVERY_S": "%g" % quarter_s}
        self.process = subprocess.Popen(command + [x for k in keys for x in ("--set", k)], stdout=self.said, stderr=subprocess.STDOUT, env=environment)
        self.rounds, self.seen = 0, 0
        self.wait_for("settled")
        self.pid, self.thread = self.process.pid, loop_thread(self.process.pid)

    def text(self):
        self.said.flush()
        with open(self.said.name) as file: return file.read()

    def wait_for(self, word):
        """Waits until the daemon reports this state, since the last wait."""
        end = time.monotonic() + wake.HANG_S
        while not (found := re.compile(r"^\s+%s\b.*\n" % word, re.M).search(text := self.text(), self.seen)):
            if self.process.poll() is not None or time.monotonic() > end: wake.fail("hexid run: not %s: %s" % (word, text[-600:]))
            time.sleep(.05)
        self.seen = found.end()

    def look(self):
        return {"rss_kb": status_of(self.pid, "VmRSS"), "locked_kb": status_of(self.pid, "VmLck"), "fds": len(os.listdir("/proc/%d/fd" % self.pid)),
                "threads": status_of(self.pid, "Threads"), "faults": page_faults(self.pid, self.thread), "log_mb": sum(os.path.getsize(f) for f in glob.glob(self.logs + "/*")) / 1e6}

    def end(self):
        self.process.send_signal(signal.SIGTERM)
        status = self.process.wait(120)
        if status not in (0, 1): wake.fail("hexid run: status %d: %s" % (status, self.text()[-600:]))
        with open(self.result) as file: return json.load(file)["loop"]


def cycle(daemon):
    """Engages, tests, parks. `engage` holds the platform until it is parked, `start` until the tests are over."""
    name = ["--machine", NAME]
    engage = subprocess.Popen([wake.HEXID, "command", "engage", *name], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    try:
        daemon.wait_for("ready")
        for what, statuses in (("start", (0,)), ("park", (0,))):
            told = subprocess.run([wake.HEXID, "command", what, *name], capture_output=True, text=True, timeout=wake.HANG_S)
            if told.returncode not in statuses: wake.fail("hexid command %s: status %d: %s" % (what, told.returncode, (told.stderr + daemon.text())[-500:]))
    finally:
        engage.wait(wake.HANG_S)
    daemon.wait_for("settled")
    time.sleep(1) # waits until the pressure is gone, because it makes `engage` refuse
    daemon.rounds += 1


def quarter_rows(daemon, counts):
    """Returns the loop's wake-ups in each quarter, as tests/rt/counts.c wrote them."""
    with open(counts) as file: lines = [line.split() for line in file if line.startswith("wake ")]
    names = wake_names(wake.HEXID)
    return [[float(x) for x in w[2:]] for w in lines if names.get(int(w[1], 16)) == "loop_thread"]


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--seconds", type=float, default=3600)
    p.add_argument("--modbus", action="store_true")
    p.add_argument("-o", dest="page", default="build/soak_rt.md")
    a = p.parse_args()
    if a.seconds < 120: p.error("--seconds: 120 at least, a round in each quarter")
    if subprocess.run(["chrt", "-f", "80", "true"], capture_output=True).returncode: wake.fail("this user has no SCHED_FIFO: run as root")
    with tempfile.TemporaryDirectory() as work, contextlib.ExitStack() as stack:
        os.environ["HEXID_RUNTIME_DIR"] = work # so that a stop for all machines of the host does not reach this one
        url = stack.enter_context(wake.Plant()).url if a.modbus else "sim:"
        soak(a, work, url)


def soak(a, work, url):
    daemon, start, looks = Daemon(work, url, a.seconds / QUARTERS), time.monotonic(), []
    while time.monotonic() - start < a.seconds:
        cycle(daemon)
        quarter = min(QUARTERS - 1, int((time.monotonic() - start) / a.seconds * QUARTERS))
        looks.append((quarter, daemon.look()))
    loop, rows = daemon.end(), quarter_rows(daemon, work + "/counts")
    doctor = wake.doctor(min(60, a.seconds / 10))
    faults = list(faults_of(daemon, looks, loop, rows))
    with open(a.page, "w") as file:
        for out in (file, sys.stdout): write(out, a, url, daemon, looks, loop, rows, doctor)
    if faults: wake.fail("; ".join(faults))


def of_quarter(looks, quarter): return [look for q, look in looks if q == quarter]


def faults_of(daemon, looks, loop, rows):
    first, last = of_quarter(looks, 0), of_quarter(looks, QUARTERS - 1)
    if not first or not last: return (yield "a quarter without a round: more --seconds")
    if len(rows) < QUARTERS: yield "wake-ups of %d quarters" % len(rows)
    most = max(look["rss_kb"] for look in first)
    for look in last:
        if look["rss_kb"] > most + MEMORY_KB: yield "memory grew from %d to %d kB" % (most, look["rss_kb"])
        if look["fds"] > max(l["fds"] for l in first): yield "descriptors grew from %d to %d" % (first[0]["fds"], look["fds"])
    if looks[-1][1]["faults"] != looks[0][1]["faults"]: yield "the loop met %d page faults" % (looks[-1][1]["faults"] - looks[0][1]["faults"])
    if loop["lost_records"]: yield "%d records lost" % loop["lost_records"]
    if looks[-1][1]["log_mb"] > 1e3 * QUOTA_GB and daemon.earlier in os.listdir(daemon.logs): yield "the quota is not kept: %s is still there" % daemon.earlier
    if len(os.listdir(daemon.logs)) < 2: yield "the log has no parts"


def write(out, a, url, daemon, looks, loop, rows, doctor):
    print("%s, %s, %s; %g s at real pace on %s, %d rounds of up, six tests, down\n" % (
        measured.build(), os.uname().release, time.strftime("%Y-%m-%d %H:%M UTC", time.gmtime()), a.seconds, url, daemon.rounds), file=out)
    print("| quarter | wake-ups | p50, us | p99 | p99.9 | max | memory, MB | descriptors | page faults of the loop | log, MB |\n|" + " --- |" * 10, file=out)
    for quarter, row in enumerate(rows[:QUARTERS]):
        of = of_quarter(looks, quarter)
        look = of[-1] if of else dict.fromkeys(("rss_kb", "fds", "faults", "log_mb"), math.nan)
        print("| %d | %.0f | %.0f | %.0f | %.0f | %.0f | %.1f | %.0f | %.0f | %.1f |" % (
            quarter + 1, *row, look["rss_kb"] / 1e3, look["fds"], look["faults"] - looks[0][1]["faults"], look["log_mb"]), file=out)
    print("\nall: %d cycles, %d deadlines missed, %d records lost, wake-up p99 %.0f us, max %.0f us" % (
        loop["cycles"], loop["overruns"], loop["lost_records"], loop["wake_us"]["p99"], loop["wake_us"]["max"]), file=out)
    print("doctor --latency right after: p50 %.0f us, p99 %.0f us, p99.9 %.0f us, max %.0f us, %d deadlines missed" % (
        *(doctor[k] for k in ("p50", "p99", "p999", "max")), doctor["late"]), file=out, flush=True)


if __name__ == "__main__": main()
