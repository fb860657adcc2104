"""A service manager like systemd, as far as hexid sees it: the socket, the watchdog's time, the signals.

    service.py ordered COMMAND...            ready when settled, alive; SIGTERM: stopping, status 0
    service.py put_down ENGAGE COMMAND...    the same with the platform raised by the command ENGAGE (one word list, blanks between): parked first
    service.py stalled FIFO COMMAND...       the log goes to a FIFO whose reader sleeps: no sign of life once no cycle is taken
    service.py faulted COMMAND...            SIGTERM while a fault stands: status 1
    service.py abstract COMMAND...           ordered, with a socket that has no file"""
import os
import pathlib
import signal
import socket
import subprocess
import sys
import tempfile
import time

WATCHDOG_S = 1.0
PATIENCE_S = 120


class Service:
    def __init__(self, command, name):
        self.socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self.socket.bind("\0" + name[1:] if name.startswith("@") else name)
        if not name.startswith("@"):
            os.chmod(name, 0o777)
        self.socket.settimeout(0.05)
        self.heard = []  # (time, line)
        environment = dict(os.environ, NOTIFY_SOCKET=name, WATCHDOG_USEC=str(int(WATCHDOG_S * 1e6)))
        self.process = subprocess.Popen(command, env=environment)

    def hear(self):
        try:
            for line in self.socket.recv(4096).decode().split("\n"):
                self.heard.append((time.monotonic(), line))
                if line != "WATCHDOG=1":
                    print(line, flush=True)
        except TimeoutError:
            pass

    def lines(self):
        return [line for _, line in self.heard]

    def signs(self):
        return [at for at, line in self.heard if line == "WATCHDOG=1"]

    def until(self, what, count=1):
        end = time.monotonic() + PATIENCE_S
        while self.lines().count(what) < count:
            if self.process.poll() is not None or time.monotonic() > end:
                sys.exit(f"{what} never came; heard {self.lines()}, exit status {self.process.poll()}")
            self.hear()

    def ended(self):
        end = time.monotonic() + PATIENCE_S
        while self.process.poll() is None and time.monotonic() < end:
            self.hear()
        self.hear()
        print("exit status", self.process.returncode)
        return self.process.returncode


def ordered(command, name):
    service = Service(command, name)
    service.until("READY=1")
    if "STATUS=engaging" in service.lines():
        sys.exit("it moved")
    service.until("WATCHDOG=1", 4)
    signs = service.signs()
    if not 0.9 * WATCHDOG_S / 2 < signs[3] - signs[2]:
        sys.exit(f"signs of life {signs[3] - signs[2]} s apart")
    service.process.send_signal(signal.SIGTERM)
    return service.ended() != 0 or "STOPPING=1" not in service.lines()


def put_down(engage, command, name):
    service = Service(command, name)
    service.until("READY=1")
    operator = subprocess.Popen(engage.split())
    service.until("STATUS=ready")
    service.process.send_signal(signal.SIGTERM)
    status = service.ended()
    operator.wait()
    said = [line for line in service.lines() if line.startswith("ST")]
    return status != 0 or "STATUS=parking" not in said or said[-1] != "STATUS=settled" or "STOPPING=1" not in said


def faulted(command, name):
    service = Service(command, name)
    service.until("STATUS=fault")
    service.process.send_signal(signal.SIGTERM)
    return service.ended() != 1


def stalled(fifo, command, name):
    os.mkfifo(fifo)
    os.chmod(fifo, 0o777)
    reader = os.open(fifo, os.O_RDONLY | os.O_NONBLOCK)  # it sleeps
    service = Service(command, name)
    status = service.ended()
    os.close(reader)
    quiet_s = time.monotonic() - (service.signs() or [0])[-1]
    print(f"without a sign of life for {quiet_s:.1f} s at its end")
    return status != 3 or not service.signs() or quiet_s < 2 * WATCHDOG_S


with tempfile.TemporaryDirectory() as directory:
    os.chmod(directory, 0o755)
    name = str(pathlib.Path(directory, "notify"))
    case, *rest = sys.argv[1:]
    if case in ("ordered", "abstract"):
        sys.exit(ordered(rest, name if case == "ordered" else "@" + name))
    if case == "faulted":
        sys.exit(faulted(rest, name))
    sys.exit({"put_down": put_down, "stalled": stalled}[case](rest[0], rest[1:], name))
