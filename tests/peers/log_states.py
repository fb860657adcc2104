"""Reads a log with LCM's own Python library and prints the states that the platform went through, a line each."""
import sys

import lcm
from hexid import state_t

NAMES = ["init", "settled", "engaging", "ready", "testing", "parking", "fault"]

last = None
for event in lcm.EventLog(sys.argv[1], "r"):
    if event.channel == "HEXID_STATE":
        state = state_t.decode(event.data).state
        if state != last:
            print(NAMES[state])
        last = state
