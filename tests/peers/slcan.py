#!/usr/bin/env python3
"""A serial line with a CAN adapter at its end (Lawicel's protocol): the kernel's slcan makes a CAN controller of it, with a bit rate and a state.
The adapter sends each line of standard input: sSTTTRRR is the controller's state, a w p b, and both error counters."""
import fcntl
import os
import pty
import struct
import sys
import termios
import threading
import tty

N_SLCAN = 17
adapter, line = pty.openpty()
tty.setraw(line)
fcntl.ioctl(line, termios.TIOCSETD, struct.pack("i", N_SLCAN))


def take():  # the kernel's settings for the adapter: bit rate, open, close
    while os.read(adapter, 100):
        pass


threading.Thread(target=take, daemon=True).start()
print("ready", flush=True)
for said in sys.stdin:
    os.write(adapter, said.strip().encode() + b"\r")
