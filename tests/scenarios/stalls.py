"""Reports stalls of the machine under this kernel: stalls.py PRIORITY... (of SCHED_FIFO; 0: an ordinary thread)

It wakes every 2 ms on every processor at every priority, and prints a line, time and duration (us, ms), for every wake-up that is a
millisecond late or more, which makes a sample late; a fault takes 10 ms."""
import os
import sys
import threading
import time

PERIOD_NS, LATE_NS = 2_000_000, 1_000_000


def watch(processor, priority, begun):
    os.sched_setaffinity(0, {processor})  # of this thread
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO if priority else os.SCHED_OTHER, os.sched_param(priority))
    except PermissionError:
        pass  # then the thread is no more real-time than the daemon
    begun.wait()
    due = time.monotonic_ns() + PERIOD_NS
    while True:
        time.sleep(max(0, due - time.monotonic_ns()) / 1e9)
        late_ns = time.monotonic_ns() - due
        due = time.monotonic_ns() + PERIOD_NS
        if late_ns >= LATE_NS:
            os.write(1, b"%d %d\n" % (time.time_ns() // 1000, late_ns // 1_000_000))


watchers = [(processor, int(priority)) for processor in os.sched_getaffinity(0) for priority in sys.argv[1:]]
begun = threading.Barrier(len(watchers) + 1)
for processor, priority in watchers:
    threading.Thread(target=watch, args=(processor, priority, begun), daemon=True).start()
begun.wait()
os.write(1, b"ready\n")
threading.Event().wait()
