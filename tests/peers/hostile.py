"""Publishes harmful messages for a monitor on URL, then one valid event: hostile.py WORK URL

The generated types are compiled into WORK."""
import glob
import os
import struct
import subprocess
import sys
import time

import lcm

work, url = sys.argv[1:]
top = os.path.join(os.path.dirname(__file__), "..", "..")
subprocess.run(["lcm-gen", "-p", "--ppath", work, *sorted(glob.glob(os.path.join(top, "lcmtypes", "*.lcm")))], check=True)
sys.path.insert(0, work)
import hexid  # noqa: E402


def test_result(name_length):
    good = hexid.test_result_t()
    good.dof_name = "x"
    data = bytearray(good.encode())
    struct.pack_into(">i", data, 18, name_length)  # after the type, the time, test and dof
    return bytes(data)


def gap(verdict_length, effects):
    good = hexid.gap_t()
    good.verdict, good.reason, good.next_experiment = "no_gap", "r", "n"
    data = bytearray(good.encode())
    struct.pack_into(">i", data, 16, verdict_length)
    struct.pack_into(">i", data, 16 + 4 + 7 + 4 + 2 + 4 + 2, effects)
    return bytes(data)


def event(kind, text):
    e = hexid.event_t()
    e.kind, e.text = kind, text
    return e.encode()


bus = lcm.LCM(url)
for n in (-1, -2**31, 2**31 - 1, 0, 1000):
    bus.publish("HEXID_TEST_RESULT", test_result(n))
    bus.publish("HEXID_GAP", gap(n, 0))
    bus.publish("HEXID_GAP", gap(7, n))
shown = hexid.test_result_t()
shown.dof_name = "x\033]0;title\a"
bus.publish("HEXID_TEST_RESULT", shown.encode())
bus.publish("HEXID_EVENT", event("no\033[2Jte", "a\u009b31m\n\u202eb"))
bus.publish("HEXID_EVENT", event("note", "<img src=x onerror='window.hurt = 1'></script><script>window.hurt = 1</script>"))
bus.publish("HEXID_EVENT", event("note", "the last one"))
time.sleep(0.05)
