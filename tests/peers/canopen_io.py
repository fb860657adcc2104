"""Another maker's I/O module (python canopen, with config/hexid_io.eds but without the object for the owner) as node 7. It prints when it is ready.

    canopen_io.py INTERFACE

SIGUSR1 opens the emergency stop. On SIGTERM it prints the master's reaction: the number of SYNCs that still put a driving valve command
into force, and how often the supply output still changed. Exit status 1 if either exceeds two, or nothing was driven before.
"""
import os
import signal
import sys
import threading

import canopen

EDS = os.path.join(os.path.dirname(__file__), "..", "..", "config", "hexid_io.eds")
EMERGENCY_STOP, ENABLE, DOOR, PRESSURE = 1, 2, 4, 8
FILLED = 150  # changes of the supply output: 0.3 s


class Module:
    def __init__(self, interface):
        dictionary = canopen.import_od(EDS, 7)
        del dictionary[0x2000]  # the master does not need it
        self.inputs, self.level, self.changes, self.opened = EMERGENCY_STOP | ENABLE | DOOR, 0, 0, None
        self.valves, self.driven = {}, False
        self.network = canopen.Network()
        self.network.connect(channel=interface, interface="socketcan")
        self.node = self.network.create_node(7, dictionary)
        for cob, call in ((0x080, self.sync), (0x207, self.outputs), (0x201, self.command), (0x204, self.command), (0x000, self.nmt)):
            self.network.subscribe(cob, call)
        self.node.nmt.state = "INITIALISING"  # boot-up
        self.node.nmt.state = "PRE-OPERATIONAL"

    def nmt(self, cob, data, stamp):
        """Answers a reset by a boot-up."""
        if data[0] in (0x81, 0x82) and data[1] in (0, 7):
            self.node.nmt.state = "INITIALISING"
            self.node.nmt.state = "PRE-OPERATIONAL"

    def sync(self, cob, data, stamp):
        if self.node.nmt.state != "OPERATIONAL":
            return
        self.network.send_message(0x187, [self.inputs | (~self.inputs & 15) << 4])  # two contacts each
        if self.opened is None and not self.inputs & EMERGENCY_STOP:
            self.opened, self.changes, self.driven = 0, 0, any(self.valves.values())
        elif self.opened is not None and any(self.valves.values()):
            self.opened += 1

    def outputs(self, cob, data, stamp):
        self.changes += data[0] & 1 != self.level
        self.level = data[0] & 1
        if self.changes >= FILLED:
            self.inputs |= PRESSURE

    def command(self, cob, data, stamp):
        self.valves[cob] = any(data)


module = Module(sys.argv[1])
end = threading.Event()


def press(*_):
    module.inputs &= ~EMERGENCY_STOP


signal.signal(signal.SIGUSR1, press)
signal.signal(signal.SIGTERM, lambda *_: end.set())
print("ready", flush=True)
while not end.wait(0.05):
    pass
print(f"opened: {module.opened} SYNCs more with a valve driven, {module.changes} changes of the supply output", flush=True)
module.network.disconnect()
sys.exit(not (module.driven and module.opened <= 2 and module.changes <= 2))
