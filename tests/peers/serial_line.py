"""A serial line between two pseudo-terminals, as fast as its baud rate and no faster: serial_line.py BAUD

Prints the names of its ends and "ready", then carries bytes until it is killed. A pseudo-terminal has no speed of its own: each byte of 10
bits is passed on, in order, when a line of this rate would have carried it; both directions are independent."""
import os, pty, select, sys, time, tty


class Direction:
    def __init__(self, source, sink, byte_s):
        self.source, self.sink, self.byte_s = source, sink, byte_s
        self.waiting, self.free = [], 0.0  # (time when a byte is due, byte); end of the last byte's transmission

    def take(self):
        now = time.monotonic()
        try:
            data = os.read(self.source, 4096)
        except BlockingIOError:  # the writer withdrew the byte (tcflush)
            return
        for byte in data:
            self.free = max(self.free, now) + self.byte_s
            self.waiting.append((self.free, byte))

    def give(self):
        now = time.monotonic()
        due = bytes(byte for when, byte in self.waiting if when <= now)
        if due:
            os.write(self.sink, due)
            self.waiting = self.waiting[len(due):]


def main(baud):
    ends = [pty.openpty() for _ in range(2)]
    for master, slave in ends:
        tty.setraw(slave)
        os.set_blocking(master, False)
        print(os.ttyname(slave))
    print("ready", flush=True)
    (a, _), (b, _) = ends
    lines = [Direction(a, b, 10 / baud), Direction(b, a, 10 / baud)]
    while True:
        due = [line.waiting[0][0] for line in lines if line.waiting]
        timeout = max(0.0005, min(due) - time.monotonic()) if due else None  # bytes come in bunches of 0.5 ms, as from a UART's buffer
        ready = select.select([a, b], [], [], timeout)[0]
        for line in lines:
            if line.source in ready:
                line.take()
            line.give()


main(float(sys.argv[1]))
