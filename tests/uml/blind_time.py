"""Kills and stops a daemon at random moments and asks the device when its valves are centred:

    blind_time.py HEXID BUS MOMENTS SEED LIMIT_S OPTION...

BUS is where the daemon finds its plant, which is there. Prints a line with the longest time from the last command (where the bus shows it)
and from the signal to centred valves; exit status 1 when one is not below LIMIT_S."""
import os
import random
import signal
import socket
import struct
import subprocess
import sys
import time

hexid, bus, moments, seed, limit_s, *options = sys.argv[1:]
SO_TIMESTAMPNS = 35
RPDO, EMCY, RPDO_TIMEOUT = (0x201, 0x204, 0x207), range(0x081, 0x088), 0x8250


class Can:
    """Starts to listen shortly before the moment."""

    def __init__(self):
        self.socket = socket.socket(socket.PF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
        self.socket.setsockopt(socket.SOL_SOCKET, SO_TIMESTAMPNS, 1)
        self.socket.setsockopt(socket.SOL_CAN_RAW, socket.CAN_RAW_FILTER,
                               b"".join(struct.pack("=II", i, 0x7FF) for i in (*RPDO, *EMCY)))
        self.socket.bind((bus.removeprefix("can:"),))
        self.socket.settimeout(30)

    def centred(self):
        """Returns the time of the last command on the bus, and of the last of seven nodes' report of a centred valve or a switched-off
        output; s."""
        command, nodes = None, {}
        while len(nodes) < len(EMCY):
            frame, ancillary, _, _ = self.socket.recvmsg(16, 64)
            s, ns = struct.unpack("qq", ancillary[0][2])
            (identifier,) = struct.unpack_from("=I", frame)
            if identifier in RPDO:
                command = s + ns * 1e-9
            elif struct.unpack_from("<H", frame, 8)[0] == RPDO_TIMEOUT:
                nodes[identifier] = s + ns * 1e-9
        self.socket.close()
        return command, max(nodes.values())


class Modbus:
    """A separate client, which polls four times per millisecond."""

    def __init__(self):
        self.socket = socket.create_connection(("127.0.0.1", int(bus.rsplit(":", 1)[1])))
        self.socket.settimeout(30)

    def silent(self):
        self.socket.sendall(b"\0\1\0\0\0\6\1\3\0\x21\0\1")  # MODBUS_STATUS
        return self.socket.recv(260)[10] & 1

    def centred(self):
        while not self.silent():
            time.sleep(0.00025)
        at = time.time()
        self.socket.close()
        return None, at


def moment(number):
    """Returns the two times for one daemon."""
    time.sleep(0.3)  # until the device no longer belongs to the daemon before
    what = (signal.SIGKILL, signal.SIGSTOP)[number % 2]
    run = subprocess.Popen([hexid, "run", "--hal", bus, *options], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    said = []
    for line in run.stdout:
        said.append(line)
        if "engaging" in line:
            break
    time.sleep(random.uniform(0, 4))
    device = Can() if bus.startswith("can:") else Modbus()
    time.sleep(random.uniform(0.01, 0.02))
    if run.poll() is not None:
        sys.exit("the run ended before its moment:\n" + "".join(said) + run.stdout.read())
    at = time.time()
    os.kill(run.pid, what)
    command, centred = device.centred()
    run.kill()
    run.wait()
    run.stdout.close()
    return centred - command if command else 0.0, centred - at


random.seed(int(seed))
times = [moment(number) for number in range(int(moments))]
command_s, signal_s = (max(t[i] for t in times) for i in (0, 1))
seen = f"{command_s * 1e3:.1f} ms after the last command" if command_s else "the last command is not seen"
print(f"{bus.split(':')[0]}: {len(times)} moments, centred at the latest {signal_s * 1e3:.1f} ms after the signal, {seen}; "
      f"computed {float(limit_s) * 1e3:.0f} ms")
sys.exit(not (0 < signal_s < float(limit_s) and command_s < float(limit_s)))
