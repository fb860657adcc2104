"""Checks a device against the text of the Modbus standards, with raw sockets and pymodbus. TAP, one line per check.

    modbus_conformance.py tcp PORT          a device on TCP, at rest, unit 1, without a master, and with a watchdog of its own that is longer
                                            than any pause of this machine
    modbus_conformance.py rtu COMMAND...    a command that serves a serial line; LINE in it becomes the line's name, "ready" says when

"App": MODBUS Application Protocol Specification V1.1b3. "TCP": MODBUS Messaging on TCP/IP Implementation Guide V1.0b. "Line": MODBUS over
Serial Line V1.02. "Map": `hexid doctor --modbus-map`. A missing answer shows when the answer to the next request comes
first, so no check depends on a clock; a time-out is a failure."""
import os, random, select, socket, struct, subprocess, sys, time, tty
from pymodbus.client import ModbusTcpClient

PATIENCE_S = 30
END = 0x3C  # registers 0..0x3a exist
IDENTITY, WATCHDOG_MAX, WATCHDOG, TOKEN, VALVE, COMMAND, SAMPLE, STATUS, FOREIGN = 0, 4, 0x15, 0x16, 0x18, 0x1F, 0x20, 0x21, 0x3A
failures = 0


def check(text, holds):
    global failures
    failures += not holds
    print(("ok - " if holds else "not ok - ") + text, flush=True)


def read(address, count):
    return struct.pack(">BHH", 3, address, count)


def write_one(address, value):
    return struct.pack(">BHH", 6, address, value)


def write(address, values, count=None, size=None):
    data = struct.pack(">%dH" % len(values), *values)
    return struct.pack(">BHHB", 16, address, len(values) if count is None else count, len(data) if size is None else size) + data


def exchange(read_address, reads, address, values, count=None, size=None):
    data = struct.pack(">%dH" % len(values), *values)
    head = (read_address, reads, address, len(values) if count is None else count, len(data) if size is None else size)
    return struct.pack(">BHHHHB", 23, *head) + data


def cycle(token, number, valve=0):
    return exchange(COMMAND, END - COMMAND, TOKEN, token + [valve & 0xFFFF] * 6 + [number & 1, number])


def exception(function, code):
    return bytes([function | 0x80, code])


def registers(pdu):
    return list(struct.unpack(">%dH" % (pdu[1] // 2), pdu[2:]))


class Connection:
    """One TCP connection; every request has its own transaction identifier."""

    def __init__(self, port):
        self.socket = socket.create_connection(("127.0.0.1", port), timeout=PATIENCE_S)
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.transaction = random.randrange(1 << 16)

    def frame(self, pdu, unit=1, protocol=0, length=None):
        self.transaction = self.transaction + 1 & 0xFFFF
        return struct.pack(">HHHB", self.transaction, protocol, len(pdu) + 1 if length is None else length, unit) + pdu

    def send(self, data):
        self.socket.sendall(data)

    def take(self, size):
        data = b""
        while len(data) < size:
            more = self.socket.recv(size - len(data))
            if not more:
                raise ConnectionError
            data += more
        return data

    def receive(self):
        """Returns transaction, protocol, length, unit and PDU of the next answer."""
        head = struct.unpack(">HHHB", self.take(7))
        return head + (self.take(head[2] - 1),)

    def ask(self, pdu, **frame):
        """Returns the PDU of the answer; anything else than an answer to this request is an error."""
        self.send(self.frame(pdu, **frame))
        transaction, protocol, _, unit, answer = self.receive()
        if (transaction, protocol, unit) != (self.transaction, 0, frame.get("unit", 1)):
            raise ConnectionError
        return answer

    def unanswered(self, data):
        """True if the request is discarded while the connection keeps serving."""
        try:
            self.send(data)
            return self.ask(read(IDENTITY, 1)) == b"\x03\x02HE"
        except OSError:
            return False

    def closed_by(self, data):
        try:
            self.send(data)
            return self.socket.recv(1) == b""
        except ConnectionResetError:
            return True
        except TimeoutError:
            return False

    def close(self):
        self.socket.close()


def tcp(port):
    def fresh():
        return Connection(port)

    def refused(text, pdu, code, **frame):
        """Checks that a request gets an exception while the connection keeps serving."""
        c = fresh()
        try:
            holds = c.ask(pdu, **frame) == exception(pdu[0], code) and c.ask(read(IDENTITY, 1)) == b"\x03\x02HE"
        except OSError:
            holds = False
        c.close()
        check(text, holds)

    def discarded(text, pdu, **frame):
        c = fresh()
        check(text, c.unanswered(c.frame(pdu, **frame)))
        c.close()

    def closes(text, data):
        c = fresh()
        check(text, c.closed_by(data) and fresh().ask(read(IDENTITY, 1)) == b"\x03\x02HE")
        c.close()

    c = fresh()
    # The header.
    copied = True
    for transaction in (0, 1, 0x00FF, 0xFF00, 0xFFFF):
        c.transaction = transaction - 1 & 0xFFFF
        c.send(c.frame(read(IDENTITY, 1)))
        copied &= c.receive() == (transaction, 0, 5, 1, b"\x03\x02HE")
    check("TCP 3.1.3: the answer has the transaction identifier of its request, protocol 0 and the unit", copied)
    c.send(c.frame(read(0, 10)))
    check("TCP 3.1.3: the length counts the unit and the PDU", c.receive()[2] == 1 + 2 + 20)
    check("TCP 4.4.1.2: unit 0xFF, not significant, is answered and copied", c.ask(read(IDENTITY, 1), unit=0xFF) == b"\x03\x02HE")
    check("TCP 4.4.1.2: unit 0 is accepted, too", c.ask(read(IDENTITY, 1), unit=0) == b"\x03\x02HE")
    others = [unit for unit in range(2, 255) if c.ask(read(IDENTITY, 1), unit=unit) != exception(3, 0x0B)]
    check("App 7: any other unit, exception 0B, target device failed to respond", others == [])
    for protocol in (1, 0x0100, 0xFFFF):
        discarded("TCP 4.4.2.1: protocol identifier %#06x is discarded" % protocol, read(IDENTITY, 1), protocol=protocol)
    for length in (0, 1, 255, 0xFFFF):
        closes("TCP 3.1.3: length %d cannot be, and leaves no way to the next request: closed" % length,
               struct.pack(">HHHB", 1, 0, length, 1) + read(IDENTITY, 1))
    discarded("TCP 4.4.2.1: function 3 with a byte too many is discarded", read(IDENTITY, 1) + b"\0")
    discarded("TCP 4.4.2.1: function 3 with a byte too few is discarded", read(IDENTITY, 1)[:-1])
    discarded("TCP 4.4.2.1: function 6 with a byte too many is discarded", write_one(WATCHDOG, 9) + b"\0")
    discarded("TCP 4.4.2.1: function 16 longer than its byte count is discarded", write(WATCHDOG, [9]) + b"\0")
    discarded("TCP 4.4.2.1: function 16 shorter than its byte count is discarded", write(WATCHDOG, [9, 9])[:-1])
    discarded("TCP 4.4.2.1: function 23 without its values is discarded", exchange(0, 1, TOKEN, [1, 2])[:10])
    discarded("TCP 4.4.2.1: function 23 longer than its byte count is discarded", exchange(0, 1, TOKEN, [1, 2]) + b"\0\0")
    check("TCP 4.4.2.1: what was discarded has set nothing", registers(c.ask(read(WATCHDOG, 1))) == registers(c.ask(read(WATCHDOG_MAX, 1))))

    # The stream.
    for byte in c.frame(read(IDENTITY, 2)):
        c.send(bytes([byte]))
    check("TCP 4.3: a request that comes in single bytes is one request", c.receive()[4][:4] == b"\x03\x04HE")
    data = b"".join(c.frame(read(n, 1)) for n in range(20))
    c.send(data)
    answers = [c.receive() for _ in range(20)]
    check("TCP 4.3: twenty requests in one segment are twenty requests, answered in their order",
          [a[0] for a in answers] == [c.transaction - 19 + n & 0xFFFF for n in range(20)] and all(len(a[4]) == 4 for a in answers))
    data = c.frame(read(0, 1)) + c.frame(read(1, 1)) + c.frame(read(2, 1))
    c.send(data[:17])
    first = c.receive()[0]
    c.send(data[17:])
    check("TCP 4.3: a request and a part are answered and waited for", [first, c.receive()[0], c.receive()[0]] ==
          [c.transaction - 2 & 0xFFFF, c.transaction - 1 & 0xFFFF, c.transaction])
    half = fresh()
    half.send(half.frame(read(0, 1))[:9])
    check("TCP 4.2: half a request on one connection does not hold another one up", all(c.ask(read(n, 1)) for n in range(100)))
    half.send(read(0, 1)[2:])
    check("TCP 4.2: and is answered when its rest has come", half.receive()[4] == b"\x03\x02HE")
    half.send(half.frame(read(0, 1))[:9])
    half.close()
    check("TCP 4.2: a client that leaves in the middle of a request takes nobody with it", c.ask(read(IDENTITY, 1)) == b"\x03\x02HE")
    idle = [fresh() for _ in range(100)]
    check("TCP 4.2.1: a hundred idle clients do not keep the next one out", fresh().ask(read(IDENTITY, 1)) == b"\x03\x02HE")
    check("TCP 4.2.1: the one that was idle for longest has made room", idle[0].closed_by(b""))
    for other in idle:
        other.close()
    c.close()
    c = fresh()

    # Functions.
    check("App 4.2: a register's upper byte comes first", c.ask(read(IDENTITY, 1)) == b"\x03\x02\x48\x45")
    answer = c.ask(read(0, END))
    check("App 6.3: function 3 answers byte count 2 N and N registers", answer[1] == 2 * END and len(answer) == 2 + 2 * END)
    check("App 6.3: the last register alone is read", c.ask(read(END - 1, 1))[:2] == b"\x03\x02")
    inputs = registers(c.ask(read(END - 1, 1)))[0]
    check("Map: each input comes twice, plain in bits 0 to 3 and inverse in bits 4 to 7", (inputs ^ inputs >> 4) & 15 == 15 and inputs & 7 == 7)
    check("App 4.4: register 1 is addressed 0", registers(c.ask(read(0, 2)))[1:] == registers(c.ask(read(1, 1))))
    for count in (0, 126, 0x8000, 0xFFFF):
        refused("App 6.3: function 3, quantity %d: exception 3" % count, read(0, count), 3)
    for address, count in ((END, 1), (END - 1, 2), (0, 125), (0xFFFF, 1), (0xFFFF, 2)):
        refused("App 6.3: function 3, %d from %#06x: exception 2" % (count, address), read(address, count), 2)
    refused("App 6.6: function 6, a register that is not there: exception 2", write_one(END, 1), 2)
    refused("App 6.6: function 6, a register that is only read: exception 2", write_one(SAMPLE, 1), 2)
    for count in (0, 124):
        refused("App 6.12: function 16, quantity %d: exception 3" % count, write(VALVE, [0] * min(count, 123), count=count), 3)
    refused("App 6.12: function 16, byte count of one register less: exception 3", write(VALVE, [0] * 5, count=6), 3)
    refused("App 6.12: function 16, byte count that is odd: exception 3", write(VALVE, [0] * 6, size=11), 3)
    refused("App 6.12: function 16, a register that is not there: exception 2", write(0x1000, [1]), 2)
    refused("App 4.1: a PDU of 253 bytes is taken: function 16, 123 registers from 0, of which some are only read", write(0, [0] * 123), 2)
    for reads in (0, 126):
        refused("App 6.17: function 23, %d to read: exception 3" % reads, exchange(0, reads, VALVE, [0]), 3)
    for count in (0, 122):
        refused("App 6.17: function 23, %d to write: exception 3" % count, exchange(0, 1, VALVE, [0] * min(count, 121), count=count), 3)
    refused("App 6.17: function 23, a wrong byte count: exception 3", exchange(0, 1, VALVE, [0] * 6, size=11), 3)
    refused("App 6.17: function 23, reads what is not there: exception 2", exchange(END, 1, VALVE, [0]), 2)
    refused("App 6.17: function 23, writes what is not there: exception 2", exchange(0, 1, END, [0]), 2)
    refused("App 6.7: function 7, of serial lines only: exception 1", b"\x07", 1)
    for function in (0, 1, 2, 4, 5, 8, 11, 15, 17, 20, 22, 24, 43, 65, 127):
        refused("App 5: function %d, not supported: exception 1" % function, bytes([function, 0, 0, 0, 1]), 1)
    strange = [f for f in range(128, 256) if c.ask(bytes([f, 0, 0])) != bytes([f, 1])]
    check("App 5.1: functions of 128 and more, which are none: exception 1", strange == [])

    # One master, and its watchdog: the map's, with the codes of App 7.
    mine, yours = [0x1234, 0x5678], [0x8765, 0x4321]
    own_ms = registers(c.ask(read(WATCHDOG_MAX, 1)))[0]
    check("Map: nobody commands without a claim: exception 6", c.ask(cycle(mine, 1, 32767)) == exception(23, 6))
    check("Map: a token of 0 is none: exception 3", c.ask(write(WATCHDOG, [own_ms, 0, 0])) == exception(16, 3))
    for value in (0, 1, own_ms + 1, 65535):
        check("App 7: a watchdog of %d ms is not taken: exception 3" % value,
              c.ask(write(WATCHDOG, [value] + mine)) == exception(16, 3) and registers(c.ask(read(WATCHDOG, 1))) == [own_ms])
    check("App 6.12: function 16 answers address and quantity", c.ask(write(WATCHDOG, [own_ms] + mine)) ==
          struct.pack(">BHH", 16, WATCHDOG, 3))
    answer = registers(c.ask(cycle(mine, 4711)))
    check("App 6.17: function 23 writes before it reads", answer[0] == 4711 and len(answer) == END - COMMAND)
    foreign = answer[FOREIGN - COMMAND]
    check("App 6.6: function 6 answers an echo", c.ask(write_one(WATCHDOG, own_ms)) == write_one(WATCHDOG, own_ms))

    other = fresh()
    kept, moved = True, False
    for n in range(200):  # the master continues to command, so that it stays the master
        answer = registers(c.ask(cycle(mine, n)))
        kept &= answer[0] == n and answer[FOREIGN - COMMAND] == foreign
        other.send(other.frame(write(WATCHDOG, [own_ms] + yours)))
        kept &= other.receive()[4] == exception(16, 6) or n == 0
    check("Map: a claim of a machine that another one has: exception 6, and its master does not notice", kept)
    attempts = [write_one(VALVE, 32767), write(VALVE, [32767] * 6 + [9]), write_one(COMMAND, 9), write_one(WATCHDOG, 5), cycle(yours, 9, 32767),
                cycle(mine, 9, 32767)]
    busy = []
    for n, attempt in enumerate(attempts):
        c.ask(cycle(mine, 1000 + n))
        busy.append(other.ask(attempt) == exception(attempt[0], 6))
    answer = registers(c.ask(cycle(mine, 2000)))
    check("Map: whatever another one writes, over whichever function: exception 6", all(busy))
    check("Map: each is counted for the master to see", (answer[FOREIGN - COMMAND] - foreign) & 0xFFFF == len(attempts))
    check("Map: and has moved nothing", registers(c.ask(read(VALVE, 6))) == [0] * 6 and registers(c.ask(read(WATCHDOG, 1))) == [own_ms])
    check("Map: everybody reads", registers(other.ask(read(COMMAND, 1))) == [2000])
    c.ask(write_one(WATCHDOG, 2))
    c.ask(cycle(mine, 2001))  # the time counts from a command on
    while not registers(other.ask(read(STATUS, 1)))[0] & 1:
        pass
    check("Map: a master that was silent can be replaced", other.ask(write(WATCHDOG, [own_ms] + yours))[0] == 16)
    check("Map: and is then a stranger: exception 6", c.ask(cycle(mine, 3)) == exception(23, 6))
    again = fresh()
    check("Map: who has the token claims again over a new connection", other.ask(cycle(yours, 5))[0] == 23 and
          again.ask(write(WATCHDOG, [own_ms] + yours))[0] == 16 and again.ask(cycle(yours, 6))[0] == 23)
    many = [fresh() for _ in range(40)]
    check("TCP 4.2.1: the master makes room for nobody", again.ask(cycle(yours, 7))[0] == 23)
    again.ask(write_one(WATCHDOG, 2))
    for connection in many + [other, again]:
        connection.close()

    # Anything at all.
    c.close()
    c = fresh()
    dice, answered = random.Random(3), True
    for _ in range(1000):
        function = dice.choice((3, 6, 16, 23, dice.randrange(256)))
        pdu = {3: read(dice.randrange(70), dice.randrange(130)), 6: write_one(dice.randrange(70), dice.randrange(65536)),
               16: write(dice.randrange(70), [dice.randrange(65536)] * dice.randrange(124)),
               23: exchange(dice.randrange(70), dice.randrange(130), dice.randrange(70), [1] * dice.randrange(122))}.get(
                   function, bytes([function]) + dice.randbytes(dice.randrange(252)))
        answer = c.ask(pdu)
        answered &= answer[0] == pdu[0] and len(answer) > 2 or answer[0] == pdu[0] | 0x80 and answer[1] in (1, 2, 3, 6) and len(answer) == 2
    check("App 4.5: 1000 requests drawn at random, each answered or refused with an exception there is", answered)
    client = ModbusTcpClient("127.0.0.1", port=port, timeout=PATIENCE_S)
    client.connect()
    check("pymodbus agrees: functions 3, 6, 16, 23 and an exception", client.read_holding_registers(0, 2, slave=1).registers == [0x4845, 3] and
          client.write_registers(WATCHDOG, [own_ms, 1, 2], slave=1).address == WATCHDOG and
          client.write_register(WATCHDOG, own_ms, slave=1).value == own_ms and
          client.readwrite_registers(read_address=COMMAND, read_count=1, write_address=COMMAND, values=[77], slave=1).registers == [77] and
          client.read_coils(0, 1, slave=1).exception_code == 1)
    client.close()


def crc(data):
    c = 0xFFFF
    for byte in data:
        c ^= byte
        for _ in range(8):
            c = c >> 1 ^ 0xA001 if c & 1 else c >> 1
    return struct.pack("<H", c)


class Line:
    """A pseudo-terminal with a device at its other end, started here."""

    def __init__(self, command):
        self.master, slave = os.openpty()
        tty.setraw(slave)
        words = [word.replace("LINE", os.ttyname(slave)) for word in command]
        self.device = subprocess.Popen(words, stdout=subprocess.PIPE, text=True)
        if "ready" not in self.device.stdout.readline():
            sys.exit("the device does not start")

    def send(self, pdu, unit=1, check=None):
        data = bytes([unit]) + pdu
        os.write(self.master, data + (crc(data) if check is None else check))

    def receive(self, within_s):
        """Returns everything received until the line is silent for within_s."""
        data = b""
        while select.select([self.master], [], [], within_s)[0]:
            data += os.read(self.master, 4096)
            within_s = 0.05
        return data

    def ask(self, pdu, unit=1):
        """Returns the answer's PDU; repeats the request, as a master does when a line loses bytes."""
        for _ in range(10):
            self.send(pdu, unit)
            data = self.receive(3)
            if data[:1] == bytes([unit]) and len(data) > 3 and crc(data[:-2]) == data[-2:]:
                return data[1:-2]
        return None

    def unanswered(self, pdu, unit=1, check=None):
        """True if this request is not answered, and the next one is."""
        self.send(pdu, unit, check)
        early = self.receive(0.3)
        return early == b"" and self.ask(read(IDENTITY, 1)) == b"\x03\x02HE"


def rtu(command):
    line = Line(command)
    mine, yours = [1, 2], [3, 4]
    check("Line 2.5.1.1: unit, PDU, checksum with its lower byte first", line.ask(read(IDENTITY, 1)) == b"\x03\x02HE")
    check("Line 2.5.1.2: a wrong checksum is not answered", line.unanswered(read(IDENTITY, 1), check=b"\0\0"))
    check("Line 2.2: another unit is not answered", line.unanswered(read(IDENTITY, 1), unit=2))
    check("Line 2.5.1.1: what is cut short is dropped in the silence", line.unanswered(read(IDENTITY, 1)[:3], check=b""))
    data = bytes([1]) + read(IDENTITY, 1)
    for byte in data + crc(data):
        os.write(line.master, bytes([byte]))
    answer = line.receive(3)
    check("Line 2.5.1.1: byte by byte is one request", answer[1:-2] == b"\x03\x02HE" or line.ask(read(IDENTITY, 1)) == b"\x03\x02HE")
    check("App 7: an unknown function: exception 1", line.ask(b"\x41\x01\x02") == exception(0x41, 1))
    own_ms = registers(line.ask(read(WATCHDOG_MAX, 1)))[0]
    check("Line 2.1: a broadcast is not answered", line.unanswered(write(WATCHDOG, [own_ms - 1] + mine), unit=0))
    check("Line 2.1: and is carried out", registers(line.ask(read(WATCHDOG, 1))) == [own_ms - 1])
    check("Line 2.1: a broadcast that reads is dropped", line.unanswered(read(IDENTITY, 1), unit=0))
    check("Map: the token is the proof", registers(line.ask(cycle(mine, 7)))[0] == 7)
    check("Map: another token: exception 6", line.ask(cycle(yours, 8)) == exception(23, 6))
    check("Map: none at all: exception 6", line.ask(write_one(COMMAND, 9)) == exception(6, 6))
    check("Map: nothing of that was carried out", registers(line.ask(read(COMMAND, 1))) == [7])
    os.write(line.master, random.Random(1).randbytes(5000))
    check("Line 2.5.1.2: after 5000 bytes of noise and a silence the next request is answered", line.receive(0.3) == b"" and
          line.ask(read(IDENTITY, 1)) == b"\x03\x02HE")
    line.device.terminate()
    check("the device ends when it is told to", line.device.wait(PATIENCE_S) == 0)


if sys.argv[1] == "tcp":
    tcp(int(sys.argv[2]))
else:
    rtu(sys.argv[2:])
sys.exit(failures > 0)
