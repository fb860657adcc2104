#!/usr/bin/env python3
"""Runs hexid with tests/rt/counts.c preloaded and prints for each of its threads from its first sleep on: heap calls, locks, page
faults, and the depth of its stack.

    counts.py [--json FILE] [--unlocked] -- HEXID ARGUMENT...

Ends with an error where the loop slept less than 500 times, called the heap, took a lock, or met a page fault (not with --unlocked: of a user
who may not lock memory). Environment: BUILD."""
import argparse, json, os, subprocess, sys, tempfile

PRELOAD = os.path.join(os.environ.get("BUILD", "build"), "tests/rt/counts.so")
REAL_TIME = ("loop_thread",)
SLEEPS = 500
FIELDS = ("sleeps", "heap", "locks", "minor_faults", "major_faults", "stack_bytes")


def functions(program):
    lines = subprocess.run(["nm", program], capture_output=True, text=True, check=True).stdout.split("\n")
    return {int(w[0], 16): w[2] for w in map(str.split, lines) if len(w) == 3 and w[1] in "tT"}


def counted(command):
    """Returns a dictionary for each thread and the program's status; security.confine would prevent the counting."""
    with tempfile.TemporaryDirectory() as work:
        environment = os.environ | {"LD_PRELOAD": os.path.abspath(PRELOAD), "HEXID_COUNTS": work + "/counts"}
        status = subprocess.run([*command, "--set", "security.confine=false"], env=environment, stdout=sys.stderr).returncode
        with open(work + "/counts") as file: lines = file.read().split("\n")[:-1]
    names = functions(command[0])
    rows = [(int(line.split()[0], 16), [int(x) for x in line.split()[1:]]) for line in lines]
    return [{"thread": names.get(begin, "?") if begin else "main"} | dict(zip(FIELDS, numbers)) for begin, numbers in rows], status


def faults_of(thread, unlocked):
    """Yields the forbidden activities of a real-time thread; page faults that could not be counted (-1) are not forbidden."""
    if thread["sleeps"] < SLEEPS: yield "slept %d times only" % thread["sleeps"]
    for what in ("heap", "locks") + (() if unlocked else ("minor_faults", "major_faults")):
        if thread[what] > 0: yield "%s: %d" % (what, thread[what])


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--json")
    p.add_argument("--unlocked", action="store_true")
    p.add_argument("command", nargs="+")
    a = p.parse_args()
    threads, status = counted(a.command)
    if status not in (0, 1): raise SystemExit("counts.py: %s: status %d" % (a.command[0], status))
    print("%-18s %8s %8s %8s %8s %8s %8s" % ("thread", "sleeps", "heap", "locks", "minor", "major", "stack B"))
    for t in threads: print("%-18s" % t["thread"], *("%8d" % t[f] for f in FIELDS))
    if a.json:
        with open(a.json, "w") as file: json.dump(threads, file)
    wrong = [(t["thread"], list(faults_of(t, a.unlocked))) for t in threads if t["thread"] in REAL_TIME]
    if {name for name, _ in wrong} != set(REAL_TIME): raise SystemExit("counts.py: no thread begins in %s" % " ".join(REAL_TIME))
    bad = ["%s: %s" % (name, ", ".join(what)) for name, what in wrong if what]
    if bad: raise SystemExit("counts.py: " + "; ".join(bad))


if __name__ == "__main__": main()
