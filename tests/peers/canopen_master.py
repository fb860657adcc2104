"""Another maker's CANopen master (python canopen, with config/hexid_node.eds and hexid_io.eds) at the plant's nodes. TAP.

    canopen_master.py INTERFACE NODE
"""
import os
import sys
import time

import canopen

CONFIG = os.path.join(os.path.dirname(__file__), "..", "..", "config")
interface, number = sys.argv[1], int(sys.argv[2])
failures = 0


def claim(text, good):
    global failures
    failures += not good
    print(("ok" if good else "not ok") + " - canopen: " + text, flush=True)


def within(seconds, condition):
    end = time.monotonic() + seconds
    while not condition() and time.monotonic() < end:
        time.sleep(0.0005)
    return condition()


network = canopen.Network()
network.connect(channel=interface, interface="socketcan")
node = network.add_node(number, os.path.join(CONFIG, "hexid_node.eds"))
io = network.add_node(7, os.path.join(CONFIG, "hexid_io.eds"))
emergencies = []
node.emcy.add_callback(lambda error: emergencies.append(error.code))

node.nmt.send_command(0x82)
claim("NMT reset is answered by a boot-up", within(2, lambda: node.nmt.state == "PRE-OPERATIONAL"))
claim("SDO reads the device type of the EDS", node.sdo[0x1000].raw == node.object_dictionary[0x1000].default)
claim("SDO reads the identity: serial number is the node id", node.sdo[0x1018][4].raw == number)
try:
    node.sdo[0x1000].raw = 1
    refused = False
except canopen.SdoAbortedError as error:
    refused = error.code == 0x06010002
claim("SDO refuses to write what is read-only", refused)

node.sdo[0x1017].raw = 50
beats = []
network.subscribe(0x700 + number, lambda cob, data, stamp: beats.append(stamp))
within(2, lambda: len(beats) >= 5)
gaps = sorted(b - a for a, b in zip(beats, beats[1:]))
claim("heartbeats come at the period written, 50 ms", len(gaps) >= 4 and abs(gaps[len(gaps) // 2] - 0.05) < 0.01)

node.tpdo.read()
node.rpdo.read()
node.nmt.state = "OPERATIONAL"
claim("NMT starts the node: its heartbeat says operational", within(1, lambda: node.nmt.state == "OPERATIONAL"))


io.tpdo.read()
io.rpdo.read()
claim("the I/O module maps its byte of inputs and its byte of outputs, as the EDS says",
      [[v.index for v in pdo[1]] for pdo in (io.tpdo, io.rpdo)] == [[0x6000], [0x6200]])
io.nmt.state = "OPERATIONAL"
inputs = []
io.tpdo[1].add_callback(lambda pdo: inputs.append(pdo[0].raw))


answers = []
node.tpdo[1].add_callback(lambda pdo: answers.append(tuple(v.raw for v in pdo)))


heard = 0.0


def cycle(valve=None):
    """Sends the master's heartbeat when due, RPDOs and SYNC; returns position, P1, P2 of the answering TPDO. With a valve command the
    supply output toggles as well."""
    global heard
    if time.monotonic() - heard > 0.03:
        heard = time.monotonic()
        network.send_message(0x77F, [5])
    if valve is not None:
        node.rpdo[1][0].raw = int(valve * 32767)
        node.rpdo[1].transmit()
        io.rpdo[1][0].raw ^= 1
        io.rpdo[1].transmit()
    del answers[:]
    network.sync.transmit()
    return answers[0] if within(1, lambda: answers) else None


at_rest = cycle()
claim("SYNC is answered by a TPDO as the EDS maps it: a leg of 1.43 m, tank pressure",
      at_rest is not None and abs(at_rest[0] - 1431000) < 2000 and max(abs(at_rest[1]), abs(at_rest[2])) < 100)
claim("all inputs are closed but the supply's pressure, and the other contact of each says the inverse", inputs[-1] == 0b10000111)
for _ in range(300):
    time.sleep(1e-3)  # the simulated machine follows the clock
    at_rest = cycle(0.0)
claim("while the supply output changes, the machine has pressure", inputs[-1] == 0b00001111)
for _ in range(300):
    time.sleep(1e-3)
    last = cycle(0.5)
claim("RPDO and SYNC move the leg: %+.1f mm in 300 cycles" % ((last[0] - at_rest[0]) * 1e-3), last[0] - at_rest[0] > 10000)
claim("commands that stop are an emergency 0x8250", within(1, lambda: 0x8250 in emergencies))
claim("and the node leaves operational", within(1, lambda: node.nmt.state == "PRE-OPERATIONAL"))
claim("with its valve at the centre", node.sdo[0x6301][1].raw == 0)
claim("and the supply's output off", io.sdo[0x6200][1].raw == 0)
time.sleep(0.5)
network.sync.transmit()
time.sleep(0.05)
ridden = node.sdo[0x6020][1].raw - last[0]
claim("and the leg stands, without a SYNC: %+.1f mm in 0.5 s" % (ridden * 1e-3), abs(ridden) < 20000)  # limit: 20 ms at 0.4 m/s, and the oscillation

node.sdo[0x1016][1].raw = 100 << 16 | 100
node.nmt.state = "OPERATIONAL"
within(1, lambda: node.nmt.state == "OPERATIONAL")
for _ in range(5):
    network.send_message(0x764, [5])
    time.sleep(0.02)
del emergencies[:]
claim("without the master's heartbeat: emergency 0x8130", within(1, lambda: 0x8130 in emergencies))
network.disconnect()
sys.exit(failures > 0)
