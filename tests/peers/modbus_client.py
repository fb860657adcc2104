"""Another maker's client (pymodbus) reads and moves the plant: modbus_client.py PORT. TAP."""
import socket, sys, time
from pymodbus.client import ModbusTcpClient

IDENTITY, WATCHDOG, TOKEN, COMMAND, SAMPLE, STATUS, LENGTH, END = 0x0000, 0x0015, 0x0016, 0x001F, 0x0020, 0x0021, 0x0022, 0x003C
MINE = [0x1234, 0x5678]
client = ModbusTcpClient("127.0.0.1", port=int(sys.argv[1]))
failures = 0


def claim(text, holds):
    global failures
    failures += not holds
    print(("ok - " if holds else "not ok - ") + text)


def signed(registers):
    return [(hi << 16 | lo) - (1 << 32 if hi >> 15 else 0) for hi, lo in zip(registers[::2], registers[1::2])]


def exchange(number, valve):
    raw = [int(32767 * v) & 0xFFFF for v in valve]
    answer = client.readwrite_registers(read_address=COMMAND, read_count=END - COMMAND, write_address=TOKEN,
                                        values=MINE + raw + [number & 1, number], slave=1).registers
    numbers.append(answer[0])
    return answer[1:]


numbers = []  # command numbers as the answers return them
client.connect()
claim("pymodbus: the device says what it is", client.read_holding_registers(IDENTITY, 2, slave=1).registers == [0x4845, 3])
claim("pymodbus: the machine is claimed", not client.write_registers(WATCHDOG, [20] + MINE, slave=1).isError())
first = signed(exchange(1, [0] * 6)[2:14])
claim("pymodbus: at rest, all legs alike: %s um" % first, max(first) - min(first) < 2 and 1.42e6 < first[0] < 1.44e6)
before = exchange(2, [0.3] * 6)[0]
for number in range(3, 203):
    time.sleep(2e-3)  # the simulated machine follows the clock
    last = exchange(number, [0.3] * 6)
claim("pymodbus: an answer has its command's number", numbers == list(range(1, 203)))
claim("pymodbus: every exchange is a new sample", (last[0] - before) & 0xFFFF == 200)
risen = signed(last[2:14])[0] - first[0]
claim("pymodbus: commands move the legs: +%.1f mm in 200 cycles" % (risen / 1000), risen > 20000)
while not client.read_holding_registers(STATUS, 1, slave=1).registers[0] & 1:
    pass
time.sleep(0.2)  # it still swings
held = signed(client.read_holding_registers(LENGTH, 12, slave=1).registers)[0]
time.sleep(0.2)
still = signed(client.read_holding_registers(LENGTH, 12, slave=1).registers)[0]
claim("pymodbus: without commands the watchdog centres the valves: %+.1f mm in 0.2 s" % ((still - held) / 1000), abs(still - held) < 1000)
claim("pymodbus: a register that is not there is an exception", client.read_holding_registers(0x1000, 1, slave=1).isError())
client.write_register(SAMPLE, 7, slave=1)
claim("pymodbus: what the device says cannot be written", client.read_holding_registers(SAMPLE, 1, slave=1).registers != [7])


def unheard_of():
    """Returns the seconds until an unknown function is refused, during which the device does nothing else, not even its watchdog."""
    with socket.create_connection(("127.0.0.1", int(sys.argv[1]))) as other:
        begun = time.monotonic()
        other.sendall(b"\0\1\0\0\0\2\1\x41")
        assert other.recv(260)[7] == 0xC1
        return time.monotonic() - begun


def flood():
    """Acts as a client that sends requests and never reads. Returns whether the device disconnects it instead of waiting."""
    with socket.create_connection(("127.0.0.1", int(sys.argv[1]))) as other:
        other.settimeout(5)
        try:
            while True:
                other.sendall(b"\0\1\0\0\0\6\1\3\0\0\0\x3a" * 1000)
        except TimeoutError:
            return False
        except OSError:
            return True


quickest = min(unheard_of() for _ in range(5))
claim("an unknown function is refused in %.1f ms, without libmodbus' 0.5 s of sleep" % (quickest * 1e3), quickest < 0.25)
claim("a client that never reads its answers is cut off, and the others are served", flood() and exchange(300, [0] * 6)[0] > 0)
sys.exit(failures > 0)
