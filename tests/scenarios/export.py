"""A whole log in other formats against what LCM's own Python library reads of it: every number the same, bit for bit.

    export.py table|mat|mcap LOG FILE TYPES   TYPES: the directory of `make python-types`
    export.py opens mat|mcap FILE             read to its end, whatever is in it

The names of the columns are repeated here, so that an exchanged one is seen."""
import csv
import json
import struct
import sys
import zlib

import numpy as np

LEGS, DOFS = range(6), ("x_m", "y_m", "z_m", "phi_rad", "theta_rad", "psi_rad")
ARRAYS = {"length_m": "l{}_m", "p1_pa": "p1_{}_pa", "p2_pa": "p2_{}_pa", "force_n": "force_{}_n", "valve": "u{}"}
SCALARS = {"sample_flags": "flags"}  # names that differ from lcmtypes


def columns(m):
    """Returns one state_t by the names of the columns."""
    row = {}
    for name in m.__slots__:
        value = getattr(m, name)
        if name in ARRAYS:
            row.update({ARRAYS[name].format(i + 1): value[i] for i in LEGS})
        elif name.endswith(("_m", "_rad")):
            part = DOFS[:3] if name.endswith("_m") else DOFS[3:]
            row.update({f"{name.split('_')[0]}_{dof}": value[i] for i, dof in enumerate(part)})
        else:
            row[SCALARS.get(name, name)] = value
    return row


def read_log(path, types):
    sys.path.insert(0, types)
    import hexid
    import lcm
    kinds = {"HEXID_EVENT": hexid.event_t, "HEXID_LOOP_STATS": hexid.loop_stats_2_t, "HEXID_TEST_RESULT": hexid.test_result_t,
             "HEXID_IDENTIFICATION": hexid.identification_t}
    cycles, times, messages = [], [], {}
    for event in lcm.EventLog(path, "r"):
        if event.channel == "HEXID_STATE":
            cycles.append(columns(hexid.state_t.decode(event.data)))
            times.append(event.timestamp * 1000)
        else:
            m = kinds[event.channel].decode(event.data)
            messages.setdefault(event.channel[6:].lower(), []).append({n: getattr(m, n) for n in m.__slots__ if not n.endswith("_count")})
    return {name: np.array([c[name] for c in cycles]) + 0 for name in cycles[0]}, np.array(times), messages  # + 0 makes 0 and 1 of booleans


def same(name, ours, theirs):
    ours, theirs = np.asarray(ours), np.asarray(theirs)
    assert ours.shape == theirs.shape, (name, ours.shape, theirs.shape)
    assert np.array_equal(ours, theirs, equal_nan=ours.dtype.kind == "f"), name


def same_columns(logged, file):
    time_s = file.pop("time_s")
    assert set(logged) == set(file), set(logged) ^ set(file)
    for name in logged:
        same(name, logged[name], file[name])
    assert np.max(np.abs(time_s - (logged["time_ns"] - logged["time_ns"][0]) * 1e-9)) < 1e-9
    assert {"init", "testing"} <= {STATES[s] for s in file["state"]} and np.ptp(file["pose_x_m"]) > 0 and np.ptp(file["force_3_n"]) > 0
    print(len(time_s), "cycles,", len(file), "columns")


STATES = "init settled engaging ready testing parking fault pressurising".split()


def table(logged, times, messages, path):
    with open(path, newline="") as file:
        rows = csv.reader(file)
        names = next(rows)
        values = list(zip(*rows))
    same_columns(logged, {n: np.array(v, dtype=logged[n].dtype if n in logged else float) for n, v in zip(names, values)})


def mat(logged, times, messages, path):
    import scipy.io
    file = scipy.io.loadmat(path, simplify_cells=True)["hexid"]
    units, config = file.pop("units"), file.pop("config")
    assert config == messages["event"][0]["text"] and "geometry" in config
    assert units["l1_m"] == "m" and units["p2_6_pa"] == "Pa" and units["force_1_n"] == "N" and len(units["u1"]) == 0
    for kind, logged_messages in messages.items():
        found = file.pop(kind)
        found = found if isinstance(found, list) else [found]
        assert len(found) == len(logged_messages), kind
        for a, b in zip(logged_messages, found):
            assert set(a) == set(b), (kind, set(a) ^ set(b))
            for name in a:
                if isinstance(a[name], str):
                    assert a[name] == (b[name] if len(b[name]) else ""), name
                elif name == "reasons":
                    assert a[name] == list(np.ravel(b[name])), name
                else:
                    same(name, a[name], np.reshape(b[name], np.shape(a[name])))
    same_columns(logged, file)


def checksums(path):
    """Checks the checksums of the data and the summary, which the readers ignore. A footer has 29 bytes and 8 of magic behind it, a DataEnd
    13."""
    with open(path, "rb") as file:
        data = file.read()
    opcode, length, summary, _, crc = struct.unpack("<BQQQI", data[-37:-8])
    assert (opcode, length) == (2, 20) and crc == zlib.crc32(data[summary:-12])
    assert struct.unpack("<BQI", data[summary - 13:summary]) == (15, 4, zlib.crc32(data[:summary - 13]))


def mcap(logged, times, messages, path):
    from mcap.reader import make_reader
    checksums(path)
    rows, log_times, found = [], [], {}
    with open(path, "rb") as file:
        reader = make_reader(file, validate_crcs=True)
        summary = reader.get_summary()
        for schema, channel, message in reader.iter_messages():
            fields = json.loads(schema.data)["properties"]
            data = json.loads(message.data)
            assert schema.encoding == "jsonschema" and channel.message_encoding == "json" and set(data) <= set(fields)
            if channel.topic == "/hexid/state":
                rows.append(data)
                log_times.append(message.log_time)
            else:
                found.setdefault(channel.topic[len("/hexid/"):], []).append(data)
    assert summary.statistics.message_count == len(rows) + sum(map(len, found.values())) and summary.statistics.chunk_count > 1
    same("log_time", times, log_times)
    assert {k: len(v) for k, v in found.items()} == {k: len(v) for k, v in messages.items()}
    for kind in found:
        for a, b in zip(messages[kind], found[kind]):
            for name, value in a.items():
                numbers = np.ravel(value)
                if numbers.dtype.kind == "f" and numbers.size == 1 and not np.isfinite(numbers[0]):
                    assert name not in b, name
                elif numbers.dtype.kind == "f":
                    same(name, numbers, np.array(np.ravel(b[name]), dtype=float))
                else:
                    same(name, numbers, np.ravel(b[name]))
    file = {name: np.array([row.get(name, np.nan) for row in rows], dtype=logged[name].dtype) for name in logged}
    same_columns(logged, {**file, "time_s": (file["time_ns"] - file["time_ns"][0]) * 1e-9})


def opens(kind, path):
    if kind == "mat":
        import scipy.io
        assert "hexid" in scipy.io.loadmat(path)
    else:
        from mcap.reader import NonSeekingReader
        with open(path, "rb") as file:
            for _, _, message in NonSeekingReader(file, validate_crcs=True).iter_messages():
                json.loads(message.data)


if sys.argv[1] == "opens":
    opens(*sys.argv[2:])
else:
    {"table": table, "mat": mat, "mcap": mcap}[sys.argv[1]](*read_log(sys.argv[2], sys.argv[4]), sys.argv[3])
