"""CiA 301 (4.2.0), clause by clause, against the plant's nodes: raw frames, and the objects of config/hexid_node.eds; for node 7
config/hexid_io.eds, and CiA 401's digital inputs and outputs. TAP.

    canopen_conformance.py INTERFACE NODE

Every wait ends with the expected frame; times are the kernel's stamps, and a frame that must not come is waited for long enough that even
a slow machine would have sent it.
"""
import os
import struct
import sys
import time

import can
import canopen

interface, NODE = sys.argv[1], int(sys.argv[2])
IO = NODE == 7
EDS = os.path.join(os.path.dirname(__file__), "..", "..", "config", "hexid_io.eds" if IO else "hexid_node.eds")
WIDE = 1 if IO else 2  # bytes of a command
COMMAND_OBJECT, IN_FORCE = ((0x6200, 1), (0x6200, 1)) if IO else ((0x6300, 1), (0x6301, 1))
MASTER, OFF = 0x7F, 0x80000000
VALVE, DUMMY = 0x63000110, 0x00030010
COMMAND, WRITE_ONLY, READ_ONLY, NO_OBJECT, NO_SUB = 0x05040001, 0x06010001, 0x06010002, 0x06020000, 0x06090011
NOT_MAPPABLE, TOO_LONG, INCOMPATIBLE, SIZE = 0x06040041, 0x06040042, 0x06040043, 0x06070010
VALUE, HIGH, LOW = 0x06090030, 0x06090031, 0x06090032
STATE, NO_DATA = 0x08000022, 0x08000024
failures = checks = 0
bus = can.Bus(interface="socketcan", channel=interface)


def claim(clause, text, good):
    global failures, checks
    checks += 1
    failures += not good
    standard = "" if clause.startswith("CiA") else "CiA 301, "
    print(("ok" if good else "not ok") + f" - node {NODE}: {standard}{clause}: {text}", flush=True)


def send(cob, data=b""):
    bus.send(can.Message(arbitration_id=cob, data=bytes(data), is_extended_id=False))


def frames(seconds, wanted=lambda m: False):
    """Returns all frames up to and including the first wanted one, or until the time is over."""
    got, end = [], time.monotonic() + seconds
    while (left := end - time.monotonic()) > 0:
        message = bus.recv(left)
        if message is None:
            continue
        got.append(message)
        if wanted(message):
            break
    return got


def settle():
    """Discards earlier frames, so that none is taken for an answer to a later one."""
    frames(0.02)


def answer(cob, seconds=1.0):
    """Returns the data of the next frame with this identifier; None if no frame comes."""
    got = frames(seconds, lambda m: m.arbitration_id == cob)
    return bytes(got[-1].data) if got and got[-1].arbitration_id == cob else None


def request(data, seconds=1.0):
    send(0x600 + NODE, data)
    return answer(0x580 + NODE, seconds)


def abort_of(reply):
    return struct.unpack("<I", reply[4:])[0] if reply and reply[0] == 0x80 else None


def read(index, sub=0):
    """Returns an object's value, or the abort code as a negative number."""
    reply = request(struct.pack("<BHB4x", 0x40, index, sub))
    if reply is None:
        return None
    if reply[0] == 0x80:
        return -abort_of(reply)
    return int.from_bytes(reply[4:8 - (reply[0] >> 2 & 3)], "little")


def write(index, sub, value, size):
    """Writes an object; returns 0, or the abort code."""
    reply = request(struct.pack("<BHBI", 0x23 | (4 - size) << 2, index, sub, value))
    if reply is None:
        return None
    return abort_of(reply) if reply[0] == 0x80 else 0 if reply == struct.pack("<BHB4x", 0x60, index, sub) else -1


def nmt(command, node=NODE):
    send(0x000, [command, node])


def heartbeat(node=MASTER):
    send(0x700 + node, [5])


def reset():
    nmt(0x82)
    assert answer(0x700 + NODE) == b"\0"
    settle()


def state():
    """Returns the state from the next heartbeat."""
    reply = answer(0x700 + NODE)
    return reply[0] if reply else None


def emergencies(got):
    return [struct.unpack("<HB", m.data[:3]) for m in got if m.arbitration_id == 0x80 + NODE]


def operational():
    """Sets slow watchdogs, so that no check triggers one unintentionally; then starts the node."""
    reset()
    write(0x1016, 1, MASTER << 16 | 60000, 4)
    write(0x1400, 5, 1000, 2)
    nmt(1)
    heartbeat()
    settle()


# Boot-up and identity.
nmt(0x81)
booted = answer(0x700 + NODE)
claim("7.2.8.3.3", "NMT reset node is answered by a boot-up message of one byte 0", booted == b"\0")
nmt(0x82)
claim("7.2.8.3.3", "so is NMT reset communication", answer(0x700 + NODE) == b"\0")
settle()
claim("7.2.8.3.2.2", "no heartbeat while 0x1017 is 0, its default",
      not [m for m in frames(0.5) if m.arbitration_id == 0x700 + NODE])

dictionary = canopen.import_od(EDS, NODE)
entries = [entry for item in dictionary.values() if item.index >= 0x1000  # entries below are data types, for dummies
           for entry in ([item] if isinstance(item, canopen.objectdictionary.ODVariable) else item.subindices.values())]
wrong = []
for e in entries:
    value = read(e.index, e.subindex)
    empty = e.index == 0x1003 and e.subindex
    expected = -WRITE_ONLY if e.access_type == "wo" else -NO_DATA if empty else e.default & (1 << len(e)) - 1
    if value != expected:
        wrong.append(f"{e.index:04x}:{e.subindex} {value} {expected}")
claim("7.5.1", f"each of the {len(entries)} objects of the EDS is read with its default value, or refused as its access says {wrong}",
      len(entries) > 50 and not wrong)
wrong = [f"{e.index:04x}:{e.subindex}" for e in entries
         if e.access_type in ("const", "ro") and write(e.index, e.subindex, 0, len(e) // 8) != READ_ONLY]
claim("7.2.4.3.17", f"what the EDS calls const or ro is refused with 0x06010002 {wrong}", not wrong)
wrong = [f"{e.index:04x}:{e.subindex}" for e in entries
         if e.access_type in ("rw", "rww", "wo") and write(e.index, e.subindex, 0, 4 if len(e) < 32 else 2) != SIZE]
claim("7.2.4.3.17", f"a download of another length is refused with 0x06070010 {wrong}", not wrong)
claim("7.5.2 (1000h)", "the device type is that of the EDS", read(0x1000) == dictionary[0x1000].default)
claim("7.5.2 (1018h)", "the identity has four entries", read(0x1018) == 4)
known = set(dictionary)
claim("7.2.4.3.17", "an index that is not there: 0x06020000",
      all(read(i) == -NO_OBJECT
          for i in (0x1002, 0x1008, 0x100C, 0x1010, 0x1401, 0x1601, 0x1801, 0x1FFF, 0x2001, 0x5FFF, 0xFFFF) if i not in known))
claim("7.2.4.3.17", "a sub-index that is not there: 0x06090011",
      {read(0x1018, 5), read(0x1000, 1), read(0x1400, 3), read(0x1017, 255)} == {-NO_SUB})
claim("7.2.4.3.17", "the same for downloads", (write(0x5FFF, 0, 0, 4), write(0x1018, 9, 0, 4)) == (NO_OBJECT, NO_SUB))

# SDO protocol.
claim("7.2.4.3.3", "expedited download of two bytes is answered 0x60 with its multiplexer",
      request(bytes.fromhex("2b17100064000000")) == bytes.fromhex("6017100000000000") and read(0x1017) == 100)
write(0x1017, 0, 0, 2)
claim("7.2.4.3.3", "expedited download without a size indicated (0x22) is taken",
      request(bytes.fromhex("2217100000000000")) == bytes.fromhex("6017100000000000"))
claim("7.2.4.3.6", "an upload is answered with its size: 0x43, 0x4b, 0x4f",
      [request(struct.pack("<BHB4x", 0x40, i, 0))[0] for i in (0x1000, 0x1017, 0x1001)] == [0x43, 0x4B, 0x4F])
for name, data in (("segmented download", "2117100002000000"), ("download segment", "0000000000000000"),
                   ("its toggled one", "1000000000000000"),
                   ("upload segment", "6000000000000000"), ("its toggled one", "7000000000000000"), ("block upload", "a417100000000000"),
                   ("block download", "c217100002000000"), ("command specifier 7", "e017100000000000")):
    claim("7.2.4.3.17", f"{name}, which is not supported: abort 0x05040001", abort_of(request(bytes.fromhex(data))) == COMMAND)
claim("7.2.4.3.17", "a client's abort is not answered", request(bytes.fromhex("8017100000000405"), 0.1) is None)
claim("7.2.4.3", "an SDO of less than 8 bytes is ignored", request(bytes.fromhex("40001000"), 0.1) is None)
bus.send(can.Message(arbitration_id=0x600 + NODE, data=bytes.fromhex("4000100000000000"), is_extended_id=True))
claim("7.2.4.3", "a frame of 29 bit with the same identifier is ignored", answer(0x580 + NODE, 0.1) is None)
bus.send(can.Message(arbitration_id=0x600 + NODE, dlc=8, is_remote_frame=True, is_extended_id=False))
claim("7.2.4.3", "so is a remote frame", answer(0x580 + NODE, 0.1) is None)

# Heartbeat producer.
write(0x1017, 0, 60000, 2)
settle()
send(0x600 + NODE, struct.pack("<BHBI", 0x2B, 0x1017, 0, 20))
beats = [m for m in frames(5, lambda m, n=[0]: m.arbitration_id == 0x700 + NODE and (n.append(0) or len(n) > 11))
         if m.arbitration_id == 0x700 + NODE]
gaps = sorted(b.timestamp - a.timestamp for a, b in zip(beats, beats[1:]))
claim("7.5.2 (1017h)", "a new producer time takes effect at once, not after the old one of a minute", len(beats) >= 10)
claim("7.2.8.3.2.2", "heartbeats come at the period written, 20 ms",
      len(gaps) >= 9 and abs(gaps[len(gaps) // 2] - 0.02) < 0.005)
claim("7.2.8.3.2.2", "a heartbeat is one byte: 0x7f in pre-operational", {bytes(m.data) for m in beats} == {b"\x7f"})
nmt(1)
claim("7.3.2.2", "NMT start: operational", 5 in (state(), state()))
nmt(2)
claim("7.3.2.2", "NMT stop: stopped", 4 in (state(), state()))
claim("7.3.2.2", "no SDO in stopped", request(bytes.fromhex("4000100000000000"), 0.1) is None)
send(0x80)
claim("7.3.2.2", "no PDO in stopped", answer(0x180 + NODE, 0.1) is None)
nmt(1)
claim("7.3.2.2", "from stopped to operational", 5 in (state(), state()))
nmt(0x80)
claim("7.3.2.2", "NMT enter pre-operational", 0x7F in (state(), state()))
nmt(1, 0)
claim("7.2.8.2.1", "node 0 addresses all", 5 in (state(), state()))
nmt(0x80, 0)
settle()
nmt(1, NODE % 6 + 1)
claim("7.2.8.2.1", "another node's command is not taken", 5 not in (state(), state()))
for command in (0, 3, 0x7F, 0x83, 0xFF):
    nmt(command)
send(0, [1])
send(0, [1, NODE, 0])
send(0)
claim("7.2.8.2.1", "unknown commands and such of another length are ignored", {state(), state(), state()} == {0x7F})
claim("7.5.2 (1017h)", "0 stops the heartbeat", write(0x1017, 0, 0, 2) == 0 and answer(0x700 + NODE, 0.2) is None)
reset()
claim("7.3.2.2", "NMT reset communication restores the defaults",
      read(0x1017) == 0 and read(0x1400, 5) == dictionary[0x1400][5].default)

# SYNC and TPDO.
send(0x80)
claim("7.3.2.2", "no TPDO in pre-operational", answer(0x180 + NODE, 0.1) is None)
operational()
send(0x80)
reply = answer(0x180 + NODE)
mapped = [read(0x1A00, i + 1) for i in range(read(0x1A00))]
length = sum(entry & 0xFF for entry in mapped) // 8
claim("7.2.2.5", f"SYNC is answered by the TPDO of {length} bytes that is mapped", reply is not None and len(reply) == length)
claim("7.5.2 (1A00h)", "the TPDO is what SDO reads of the mapped objects",
      reply == b"".join(read(entry >> 16, entry >> 8 & 0xFF).to_bytes((entry & 0xFF) // 8, "little") for entry in mapped))
send(0x80, [1])
got = frames(0.1)
claim("7.2.5 (1019h)", "SYNC with a counter that is not configured: no PDO, EMCY 0x8240",
      not [m for m in got if m.arbitration_id == 0x180 + NODE] and emergencies(got) == [(0x8240, 0x11)])
send(0x80)
claim("7.2.7.1", "with the next good one the error is reset: EMCY 0x0000, register 0",
      emergencies(frames(0.1)) == [(0, 0)])
reset()
claim("7.5.2 (1019h)", "1 and 241 are refused, 240 is taken",
      (write(0x1019, 0, 1, 1), write(0x1019, 0, 241, 1), write(0x1019, 0, 240, 1)) == (VALUE, VALUE, 0))
nmt(1)
settle()
send(0x80, [7])
claim("7.5.2 (1019h)", "then SYNC has one byte", answer(0x180 + NODE) is not None)
reset()
claim("7.3.5", "0x1005 takes no restricted identifier",
      {write(0x1005, 0, cob, 4)
       for cob in (0, 0x001, 0x07F, 0x101, 0x180, 0x581, 0x5FF, 0x601, 0x67F, 0x6E0, 0x6FF, 0x701, 0x77F, 0x7FF)} == {VALUE})
claim("7.5.2 (1005h)", "no 29 bit, and no producing of SYNC: refused",
      {write(0x1005, 0, v, 4) for v in (0x20000080, 0x40000080)} == {VALUE})
claim("7.5.2 (1005h)", "another identifier is taken", write(0x1005, 0, 0x90, 4) == 0)
nmt(1)
settle()
send(0x80)
old = answer(0x180 + NODE, 0.1)
send(0x90)
claim("7.5.2 (1005h)", "and acts: that is the SYNC now, the old one is not",
      old is None and answer(0x180 + NODE) is not None)
reset()
claim("7.5.2 (1800h)", "transmission types 241 to 255 are refused for readings that SYNC latches",
      {write(0x1800, 2, t, 1) for t in (241, 252, 253, 254, 255)} == {VALUE})
claim("7.5.2 (1800h)", "type 3 is taken", write(0x1800, 2, 3, 1) == 0)
nmt(1)
settle()
count = []
for _ in range(6):
    send(0x80)
    count.append(answer(0x180 + NODE, 0.1) is not None)
claim("7.5.2 (1800h)", "and the TPDO comes with every third SYNC", count == [False, False, True] * 2)
reset()
claim("7.5.2 (1800h)", "an identifier is not changed while the PDO is on", write(0x1800, 1, 0x301, 4) == STATE)
write(0x1800, 1, OFF | 0x180 + NODE, 4)
nmt(1)
settle()
send(0x80)
claim("7.5.2 (1800h)", "bit 31 switches the TPDO off", answer(0x180 + NODE, 0.1) is None)
nmt(0x80)
claim("7.3.5", "no restricted identifier for a PDO",
      {write(0x1800, 1, cob, 4) for cob in (0, 0x07F, 0x101, 0x581, 0x601, 0x6E0, 0x701)} == {VALUE})
claim("7.5.2 (1800h)", "another identifier is taken", write(0x1800, 1, 0x385, 4) == 0)
nmt(1)
settle()
send(0x80)
claim("7.5.2 (1800h)", "and acts", answer(0x385) is not None)

# RPDO.
operational()


def data(value):
    return value.to_bytes(WIDE, "little")


def output(data, cob=0x200 + NODE, sync=True):
    """Returns the output after this RPDO, and after SYNC."""
    send(cob, data)
    if sync:
        send(0x80)
        answer(0x180 + NODE)
    return read(*IN_FORCE)


claim("7.2.2.5", "a synchronous RPDO acts with the SYNC after it",
      output(data(0x10), sync=False) == 0 and output(data(0x10)) == 0x10)
settle()
send(0x200 + NODE, data(0x20)[:-1])
got = frames(0.1)
send(0x80)
answer(0x180 + NODE)
claim("7.2.7.1 (8210h)", "a short RPDO is an EMCY 0x8210 and is not processed",
      emergencies(got) == [(0x8210, 0x11)] and read(*IN_FORCE) == 0x10)
settle()
send(0x200 + NODE, data(0x20) + b"\0\0")
got = emergencies(frames(0.1))
claim("7.2.7.1 (8220h)", "of a long one the first bytes are processed, with EMCY 0x8220",
      (0x8220, 0x11) in got and output(data(0x21)) == 0x21)
claim("7.5.2 (1003h)", "the error history has the newest first",
      (read(0x1003), read(0x1003, 1), read(0x1003, 2)) == (2, 0x8220, 0x8210))
claim("7.5.2 (1003h)", "past its end there is no data: 0x08000024", read(0x1003, 3) == -NO_DATA)
claim("7.5.2 (1003h)", "it takes nothing but 0",
      write(0x1003, 0, 1, 1) == VALUE and write(0x1003, 0, 0, 1) == 0 and read(0x1003) == 0)
claim("SAFETY", "in operational nothing else is written",
      {write(i, s, v, n)
       for i, s, v, n in ((0x1400, 5, 20, 2), (0x1400, 1, OFF, 4), (0x1016, 1, 0, 4), (0x1017, 0, 0, 2), (0x1005, 0, 0x90, 4),
                          (0x1800, 1, OFF, 4), (0x2000, 1, 1, 4), (*COMMAND_OBJECT, 1, WIDE), (0x1029, 1, 2, 1))} == {STATE})
settle()
output(data(0x30))
got = frames(3, lambda m: m.arbitration_id == 0x80 + NODE)
claim("7.5.2 (1400h:5)", "without RPDOs for the event timer: EMCY 0x8250", emergencies(got) == [(0x8250, 0x11)])
claim("7.5.2 (1029h)", "and pre-operational, with the output at 0",
      write(0x1017, 0, 20, 2) == 0 and 0x7F in (state(), state()) and read(*IN_FORCE) == 0)
claim("7.5.2 (1001h)", "the error register has generic and communication", read(0x1001) == 0x11)
settle()
nmt(1)
got = frames(0.2)
claim("7.2.7.1", "with the start the error is reset: EMCY 0x0000", (0, 0) in emergencies(got))
reset()
claim("7.5.2 (1029h)", "the error behaviour is 0 or 2",
      (write(0x1029, 1, 1, 1), write(0x1029, 1, 3, 1), write(0x1029, 1, 2, 1)) == (VALUE, VALUE, 0))
write(0x1017, 0, 20, 2)
nmt(1)
heartbeat()
send(0x200 + NODE, data(0x10))
got = frames(3, lambda m: m.arbitration_id == 0x700 + NODE and m.data[0] == 4)
claim("7.5.2 (1029h)", "2: to stopped", got and got[-1].data[0] == 4 and (0x8250, 0x11) in emergencies(got))
reset()
claim("7.5.2 (1400h:5)", "SAFETY: 0 does not switch it off, and it has an upper limit: 0x06090032, 0x06090031",
      (write(0x1400, 5, 0, 2), write(0x1400, 5, 1001, 2)) == (LOW, HIGH))
claim("7.5.2 (1400h)", "transmission types that are reserved are refused",
      {write(0x1400, 2, t, 1) for t in (241, 250, 253)} == {VALUE})
claim("7.5.2 (1400h)", "type 255 is taken", write(0x1400, 2, 255, 1) == 0)
write(0x1400, 5, 1000, 2)
nmt(1)
heartbeat()
claim("7.5.2 (1400h)", "and the RPDO acts at once", output(data(0x44), sync=False) == 0x44)
reset()
if not IO:
    claim("7.5.2 (1600h)", "the mapping is not changed while the PDO is on", write(0x1600, 0, 0, 1) == STATE)
claim("7.5.2 (1400h)", "an identifier is not changed while the PDO is on", write(0x1400, 1, 0x301, 4) == STATE)
claim("7.5.2 (1400h)", "bit 31 switches it off", write(0x1400, 1, OFF | 0x200 + NODE, 4) == 0)
claim("7.3.5", "no restricted identifier for an RPDO, NMT's least of all",
      {write(0x1400, 1, cob, 4) for cob in (0, 0x07F, 0x180, 0x5FF, 0x67F, 0x6FF, 0x77F)} == {VALUE})
if not IO:
    claim("7.5.2 (1600h)", "entries are not changed while they count", write(0x1600, 1, VALVE, 4) == STATE)
    claim("7.5.2 (1600h)", "0 entries", write(0x1600, 0, 0, 1) == 0)
    claim("7.5.2 (1400h)", "an RPDO without entries is not switched on", write(0x1400, 1, 0x200 + NODE, 4) == STATE)
    claim("7.5.2 (1600h)", "what cannot be mapped: 0x06040041",
          {write(0x1600, 1, v, 4) for v in (0x10170010, 0x60200120, 0x63000108, 0x00050008)} == {NOT_MAPPABLE})
    claim("7.5.2 (1600h)", "what is not there: 0x06020000, 0x06090011",
          (write(0x1600, 1, 0x5FFF0010, 4), write(0x1600, 1, 0x63000910, 4)) == (NO_OBJECT, NO_SUB))
    claim("7.5.2 (1600h)", "dummy, then the valve", (write(0x1600, 1, DUMMY, 4), write(0x1600, 2, VALVE, 4)) == (0, 0))
    claim("7.5.2 (1600h)", "more entries than there are: 0x06040042", write(0x1600, 0, 4, 1) == TOO_LONG)
    claim("7.5.2 (1600h)", "two, and the PDO on with another identifier",
          (write(0x1600, 0, 2, 1), write(0x1400, 1, 0x301, 4)) == (0, 0))
    write(0x1400, 5, 1000, 2)
    nmt(1)
    heartbeat()
    claim("7.4.7", "the dummy takes its two bytes, the valve the next", output(b"\x11\x11\x22\x02", 0x301) == 0x222)

# CiA 401: one group of eight inputs, one of eight outputs.
if IO:
    reset()
    claim("CiA 401, 1000h", "profile 401, digital inputs and digital outputs, nothing else", read(0x1000) == 0x00030191)
    claim("CiA 401, RPDO 1", "by default carries the first eight outputs", (read(0x1600), read(0x1600, 1)) == (1, 0x62000108))
    claim("CiA 401, TPDO 1", "by default carries the first eight inputs", (read(0x1A00), read(0x1A00, 1)) == (1, 0x60000108))
    claim("7.5.2 (1600h)", "the mapping is fixed: 0x06010002",
          {write(0x1600, 0, 0, 1), write(0x1600, 1, 0x62000108, 4), write(0x1A00, 0, 0, 1)} == {READ_ONLY})
    claim("CiA 401, 6000h", "inputs are read only, and say how the machine is: emergency stop, enable switch and door closed",
          (read(0x6000), read(0x6000, 1), write(0x6000, 1, 0, 1)) == (1, 0, READ_ONLY) and (send(0x80), read(0x6000, 1))[1] & 7 == 7)
    claim("SAFETY (CiA 304's idea)", "each input comes twice, plain in bits 0 to 3 and inverse in bits 4 to 7",
          (read(0x6000, 1) ^ read(0x6000, 1) >> 4) & 15 == 15)
    claim("CiA 401, 6206h, 6207h", "SAFETY: on an error every output takes its error value, 0; neither can be changed",
          (read(0x6206, 1), read(0x6207, 1)) == (0xFF, 0) and
          {write(0x6206, 1, 0, 1), write(0x6207, 1, 1, 1)} == {READ_ONLY})
    claim("SAFETY", "no SDO sets an output", write(0x6200, 1, 1, 1) == STATE and read(0x6200, 1) == 0)
    operational()
    claim("CiA 401, 6200h", "all eight outputs are as commanded", [output(data(v)) for v in (0xFF, 0x01, 0x80, 0)] == [0xFF, 1, 0x80, 0])
    output(data(1))
    nmt(2)
    nmt(1)
    settle()
    claim("CiA 401, 6206h", "stopped and started again, an output waits for a new command", read(0x6200, 1) == 0)

# Heartbeat consumer.
reset()
claim("7.5.2 (1016h)", "SAFETY: the master is watched by default", read(0x1016, 1) == MASTER << 16 | 150)
claim("7.5.2 (1016h)", "the same node twice: 0x06040043", write(0x1016, 2, MASTER << 16 | 100, 4) == INCOMPATIBLE)
claim("7.5.2 (1016h)", "node 0, time 0 and nodes above 127 are taken: not used",
      {write(0x1016, 2, v, 4) for v in (100, 10 << 16, 200 << 16 | 100, 0)} == {0})
settle()
claim("7.5.2 (1016h)", "what was never heard is not missed", emergencies(frames(0.4)) == [])
write(0x1016, 1, 100 << 16 | 100, 4)
heartbeat(100)
got = frames(2, lambda m: m.arbitration_id == 0x80 + NODE)
claim("7.2.8.2.2", "a heartbeat that is late: EMCY 0x8130, in pre-operational too",
      emergencies(got) == [(0x8130, 0x11)])
heartbeat(100)
got = frames(2, lambda m: m.arbitration_id == 0x80 + NODE)
claim("7.2.7.1", "it comes again: EMCY 0x0000", emergencies(got) == [(0, 0)])
reset()
write(0x1017, 0, 20, 2)
write(0x1016, 1, 100 << 16 | 100, 4)
write(0x1400, 5, 1000, 2)
nmt(1)
claim("SAFETY", "without the heartbeat the output stays 0", output(data(0x10)) == 0)
heartbeat(100)
claim("SAFETY", "with it the output is set", output(data(0x10)) == 0x10)
settle()
got = frames(2, lambda m: m.arbitration_id == 0x80 + NODE)
claim("7.5.2 (1029h)", "its loss in operational: EMCY, pre-operational, output 0",
      emergencies(got) in ([(0x8130, 0x11)],) and 0x7F in (state(), state()) and read(*IN_FORCE) == 0)
reset()
write(0x1016, 1, 0, 4)
nmt(1)
heartbeat()
claim("SAFETY", "switched off, the output is not set at all", output(data(0x10)) == 0)

# Manufacturer's objects: one owner.
reset()
claim("7.5 (2000h)", "nobody's; the claim of token 0 is refused",
      read(0x2000, 3) == 0 and write(0x2000, 1, 0, 4) == VALUE)
claim("7.5 (2000h)", "claimed", write(0x2000, 1, 0x1111, 4) == 0 and read(0x2000, 3) == 1)
claim("7.5 (2000h)", "another's claim and release are refused in this state: 0x08000022",
      (write(0x2000, 1, 0x2222, 4), write(0x2000, 2, 0x2222, 4)) == (STATE, STATE))
claim("7.5 (2000h)", "the token cannot be read: 0x06010001", read(0x2000, 1) == -WRITE_ONLY)
reset()
claim("7.5 (2000h)", "an NMT reset does not take it away", write(0x2000, 1, 0x2222, 4) == STATE)
claim("7.5 (2000h)", "the owner releases", write(0x2000, 2, 0x1111, 4) == 0 and read(0x2000, 3) == 0)
write(0x2000, 1, 0x1111, 4)
frames(0.4)
claim("7.5 (2000h)", "without its heartbeat the owner is gone",
      read(0x2000, 3) == 0 and write(0x2000, 1, 0x2222, 4) == 0 and write(0x2000, 2, 0x2222, 4) == 0)
reset()
bus.shutdown()
print(f"# {checks} checks")
sys.exit(failures > 0)
