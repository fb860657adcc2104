"""An adapter that is unplugged and plugged in again under a device on a serial line. TAP.

    serial_replug.py COMMAND...    the device; LINE in its arguments is the line's name, a link as in /dev/serial/by-id
"""
import os
import pty
import subprocess
import sys
import tempfile
import time
import tty

QUESTION, ANSWER = bytes.fromhex("010300000001840a"), bytes.fromhex("01030248454fb7")
name = os.path.join(tempfile.mkdtemp(), "line")
failed = False


def check(text, holds):
    global failed
    failed |= not holds
    print(("ok" if holds else "not ok") + " - " + text, flush=True)


def plug():
    """Makes a new pair of ends, and gives the master's one the line's name. Returns our end and the master's."""
    ours, theirs = pty.openpty()
    tty.setraw(ours)
    tty.setraw(theirs)
    if os.path.islink(name):
        os.unlink(name)
    os.symlink(os.ttyname(theirs), name)
    return ours, theirs


def answers(ours):
    os.write(ours, QUESTION)
    data = b""
    while len(data) < len(ANSWER):
        data += os.read(ours, 4096)
    return data == ANSWER


def ticks():
    return sum(map(int, open(f"/proc/{device.pid}/stat").read().rsplit(")", 1)[1].split()[11:13]))


ours, theirs = plug()
device = subprocess.Popen([word.replace("LINE", name) for word in sys.argv[1:]], stdout=subprocess.PIPE, text=True)
check("the device is ready", "ready on" in device.stdout.readline())
os.close(theirs)
check("and answers", answers(ours))
os.close(ours)
check("a line that is gone is said", "is gone" in device.stdout.readline())
before = ticks()
time.sleep(1)
used = ticks() - before
check(f"and waited for, not spun on: {used} of 100 ticks of processor time in a second", device.poll() is None and used < 30)
ours, theirs = plug()
check("it is opened again when it is back", "ready on" in device.stdout.readline())
os.close(theirs)
check("and the device answers there", answers(ours))
device.terminate()
check("told to end, it ends well", device.wait() == 0)
sys.exit(failed)
