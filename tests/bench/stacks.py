#!/usr/bin/python3
"""Depth of the stacks of a program's threads: tests/bench/stacks.py build/hexid run --fast ...

The kernel gives a stack its pages when they are first touched, and the compiler's probes (-fstack-clash-protection) touch every page of a frame;
so the resident pages are exactly the used ones. Prints a line for each size of stack (src/rt/thread.h); status 1 if more than half of one
was used. Locked memory is resident whether it is used or not: run it with --rt off.
"""

import collections
import re
import subprocess
import sys
import time

MAPPING = re.compile(r"^([0-9a-f]+)-([0-9a-f]+) (\S+) \S+ \S+ (\d+) *(.*)$")
SIZES = {128 << 10: "COPY", 512 << 10: "REALTIME", 2 << 20: "IDENTIFY", 8 << 20: "FIT"}


def resident(pid):
    """Yields (address, size, resident bytes) of the threads' stacks: anonymous, of these sizes, behind a guard page. Size 0 is the main
    thread's."""
    guard_end = 0
    with open(f"/proc/{pid}/smaps", encoding="ascii") as smaps:
        for line in smaps:
            if match := MAPPING.match(line):
                begin, end = int(match[1], 16), int(match[2], 16)
                guarded = begin == guard_end
                guard_end = end if match[3].startswith("---") else 0
                stack = 0 if match[5] == "[stack]" else end - begin if guarded and end - begin in SIZES else None
            elif line.startswith("Rss:") and stack is not None:
                yield begin, stack, int(line.split()[1]) << 10


def main():
    program = subprocess.Popen(sys.argv[1:], stdout=subprocess.DEVNULL)
    deepest = collections.defaultdict(int)
    while program.poll() is None:
        try:
            for _, size, used in resident(program.pid):
                deepest[size] = max(deepest[size], used)
        except OSError:
            break
        time.sleep(0.02)
    for size, used in sorted(deepest.items()):
        print(f"{SIZES.get(size, 'main'):8} {(size or 8 << 20) >> 10:5} kB, used {used >> 10:5} kB")
    sys.exit(program.wait() not in (0, 1) or len(deepest) < 2 or any(used > (size or 8 << 20) / 2 for size, used in deepest.items()))


main()
