"""Listens with LCM's own Python library until the identification has come, and prints what came: `channel count largest_size`.

    listen.py URL READY    creates the file READY when it listens
"""
import sys
import time

import lcm
import hexid

TYPES = {"HEXID_STATE": hexid.state_t, "HEXID_LOOP_STATS": hexid.loop_stats_t, "HEXID_TEST_RESULT": hexid.test_result_t,
         "HEXID_IDENTIFICATION": hexid.identification_t, "HEXID_EVENT": hexid.event_t}
counts, sizes = {}, {}


def on_message(channel, data):
    TYPES[channel].decode(data)  # raises for a message that is not of its channel's type
    counts[channel] = counts.get(channel, 0) + 1
    sizes[channel] = max(sizes.get(channel, 0), len(data))


bus = lcm.LCM(sys.argv[1])
bus.subscribe("HEXID_.*", on_message).set_queue_capacity(1000)
open(sys.argv[2], "w").close()
hung = time.monotonic() + 300
while "HEXID_IDENTIFICATION" not in counts and time.monotonic() < hung:
    bus.handle_timeout(1000)
for channel in sorted(counts):
    print(channel, counts[channel], sizes[channel])
