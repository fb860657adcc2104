#!/usr/bin/env python3
"""Helpers of the benchmarks: a table names its build, and a figure that is not a finite number ends the benchmark.

    measured.py FILE COUNT ROW...    checks that the table has each row exactly once, with at least COUNT finite numbers

A row is identified by the start of its line. Environment: HEXID."""
import math, os, re, subprocess, sys

NUMBER = re.compile(r"(?<![\w.])[-+]?(?:\d+\.?\d*(?:[eE][-+]?\d+)?|nan|inf|-nan|-inf)(?![\w.])", re.IGNORECASE)


def fail(text): raise SystemExit("%s: %s" % (os.path.basename(sys.argv[0]), text))


def build():
    """Returns the version of the measured program, such as `hexid 0.9.0 (commit ...)`."""
    program = os.environ.get("HEXID", "build/hexid")
    try: said = subprocess.run([program, "--version"], capture_output=True, text=True).stdout.strip()
    except OSError as e: fail("%s: %s: `make` first, or set HEXID" % (program, e.strerror))
    if not said.startswith("hexid "): fail("%s --version says %r: that is no hexid" % (program, said[:40]))
    return said


def finite(value, what):
    """Returns the value if it is a finite number; otherwise ends the benchmark."""
    if value is None or not math.isfinite(value): fail("%s: %s: nothing was measured" % (what, value))
    return value


def enough(things, what):
    """Returns the items if there is at least one; otherwise ends the benchmark."""
    if not things: fail("%s: none: nothing was measured" % what)
    return things


def row_faults(lines, count, name):
    """Returns the error of that row, or nothing."""
    rows = [line[len(name):] for line in lines if re.match(re.escape(name) + r"(?![\w.])", line)]
    if len(rows) != 1: return "%s: %d rows" % (name, len(rows))
    numbers = [float(x) for x in NUMBER.findall(rows[0])]
    if not all(map(math.isfinite, numbers)): return "%s: a figure is no number:%s" % (name, rows[0])
    return "" if len(numbers) >= count else "%s: %d figures, %d expected:%s" % (name, len(numbers), count, rows[0])


def main():
    if len(sys.argv) < 3: fail("usage: measured.py FILE COUNT ROW...")
    with open(sys.argv[1]) as file: text = file.read()
    if build() not in text: fail("%s: does not say that it is of %s" % (sys.argv[1], build()))
    faults = list(filter(None, (row_faults(text.splitlines(), int(sys.argv[2]), name) for name in sys.argv[3:])))
    if faults: fail("%s: %s" % (sys.argv[1], "; ".join(faults)))


if __name__ == "__main__": main()
