"""Tells when the machine under this kernel stood still: wakes every 2 ms ahead of everything else, and prints a line, when and for how long
(us, ms), for every time that it came a millisecond late or more, which makes a sample late; a fault takes 10 ms."""
import os
import time

PERIOD_NS, LATE_NS = 2_000_000, 1_000_000

try:
    os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(99))
except PermissionError:
    pass  # no more real-time than the daemon then
print("ready", flush=True)
due = time.monotonic_ns() + PERIOD_NS
while True:
    time.sleep(max(0, due - time.monotonic_ns()) / 1e9)
    late_ns = time.monotonic_ns() - due
    due = time.monotonic_ns() + PERIOD_NS
    if late_ns >= LATE_NS:
        print(time.time_ns() // 1000, late_ns // 1_000_000, flush=True)
