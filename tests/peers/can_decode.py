"""cantools decodes a candump (candump -L) with config/hexid.dbc to the values that hexid logged. TAP.

    can_decode.py DUMP CSVDIR    CSVDIR as `hexid export` writes it: every row's lengths, pressures and valve commands must be on the
                                 bus, in order
"""
import csv
import glob
import os
import sys

import cantools

DBC = os.path.join(os.path.dirname(__file__), "..", "..", "config", "hexid.dbc")
SENSORS = [f"{kind}_{leg}" for leg in range(1, 7) for kind in ("length", "p1", "p2")]
COLUMNS = [name for leg in range(1, 7) for name in (f"l{leg}_m", f"p1_{leg}_pa", f"p2_{leg}_pa")]
VALVES = [f"valve_{leg}" for leg in range(1, 7)]
IO = ["emergency_stop", "enable", "door", "pressure", "supply"]

database = cantools.database.load_file(DBC)
messages = {m.frame_id: m for m in database.messages}


def frames(path):
    for line in open(path):
        _, _, frame = line.split()[:3]
        identifier, data = frame.split("#")
        yield int(identifier, 16), bytes.fromhex(data)


def cycles(path):
    """Yields, for each time between two SYNCs, the values latched at the first and the commands that the second puts into force."""
    values = {}
    for identifier, data in frames(path):
        if identifier == 0x80:
            if all(name in values for name in SENSORS + VALVES + IO):
                yield (tuple(round(values[s] * (1e6 if s.startswith("length") else 1e-3)) for s in SENSORS), [values[v] for v in VALVES],
                       [values[i] for i in IO])
            values = {}
        elif identifier in messages:
            values.update(messages[identifier].decode(data, decode_choices=False))
        else:
            print(f"# frame {identifier:03x} is not in the DBC")
            values["unknown"] = True


def rows(directory):
    for path in sorted(glob.glob(os.path.join(directory, "*.csv"))):
        lines = [line for line in open(path) if not line.startswith("#")]
        for row in csv.DictReader(lines):
            yield (tuple(round(float(row[c]) * (1e6 if c.endswith("_m") else 1e-3)) for c in COLUMNS),
                   [float(row[f"u{leg}"]) for leg in range(1, 7)])


bus = list(cycles(sys.argv[1]))
places = {}
for place, (sensors, _, _) in enumerate(bus):
    places.setdefault(sensors, []).append(place)
total = found = commands = 0
for sensors, valves in rows(sys.argv[2]):
    total += 1
    here = places.get(sensors, [])
    found += bool(here)
    commands += any(max(abs(a - b) for a, b in zip(bus[place][1], valves)) <= 0.51 / 32767 for place in here)
print(f"# {len(bus)} cycles on the bus, {total} rows in the log, {found} with their readings and {commands} with their commands on the bus")
good = total > 1000 and found == total
print(("ok" if good else "not ok") + " - cantools decodes a candump to the logged lengths and pressures")
mostly = commands >= 0.99 * total  # a repeated sample was answered by one of two commands
print(("ok" if mostly else "not ok") + " - and to the logged valve commands, in the same cycle")
driven = [(before[2][4], io) for before, (_, valves, io) in zip(bus, bus[1:]) if any(valves)]
pumped = len(driven) > 1000 and all(supply != io[4] and io[:4] == [1, 1, 1, 1] for supply, io in driven)
print(("ok" if pumped else "not ok") + " - where a valve is driven, all inputs are closed, and the supply output changes in every cycle")
sys.exit(not (good and mostly and pumped))
