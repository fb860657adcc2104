"""Prints what LCM's own Python library decodes of hexid's messages, as JSON lines: {"channel": ..., "message": {field: value, ...}}.

    subscriber.py WORK URL READY   listens until standard input ends; creates the file READY when it listens
    subscriber.py WORK LOG         reads an event log

The types are compiled from lcmtypes/*.lcm into the directory WORK. Bytes on a channel of hexid's that are not of its type end it with a
traceback.
"""
import glob
import json
import math
import os
import select
import subprocess
import sys

import lcm

work, source = sys.argv[1:3]
top = os.path.join(os.path.dirname(__file__), "..", "..")
subprocess.run(["lcm-gen", "-p", "--ppath", work, *sorted(glob.glob(os.path.join(top, "lcmtypes", "*.lcm")))], check=True)
sys.path.insert(0, work)
import hexid  # noqa: E402

TYPES = {"HEXID_STATE": hexid.state_t, "HEXID_LOOP_STATS": hexid.loop_stats_2_t, "HEXID_TEST_RESULT": hexid.test_result_t,
         "HEXID_IDENTIFICATION": hexid.identification_t, "HEXID_EVENT": hexid.event_t, "HEXID_COMMAND": hexid.command_t,
         "HEXID_GAP": hexid.gap_2_t, "HEXID_METHOD_C": hexid.method_c_t}


def plain(value):
    """Returns the value without NaN, which JSON does not have."""
    if isinstance(value, (list, tuple)):
        return [plain(v) for v in value]
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
    return value


def show(channel, data):
    if channel in TYPES:
        message = TYPES[channel].decode(data)
        print(json.dumps({"channel": channel, "message": {name: plain(getattr(message, name)) for name in message.__slots__}}), flush=True)


def listen(url, ready):
    bus = lcm.LCM(url)
    bus.subscribe("HEXID_.*", show).set_queue_capacity(1000)
    open(ready, "w").close()
    while True:
        readable = select.select([bus, sys.stdin], [], [])[0]
        if bus in readable:
            bus.handle()
        elif not sys.stdin.buffer.read1(4096):
            return


if len(sys.argv) > 3:
    listen(source, sys.argv[3])
else:
    for event in lcm.EventLog(source, "r"):
        show(event.channel, event.data)
