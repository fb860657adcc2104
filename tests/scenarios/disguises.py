#!/usr/bin/env python3
"""One recording of an axis, as different people's programs would have written it.

    disguises.py list                       names of the disguises
    disguises.py write NAME DIRECTORY       writes the recording there, and prints the --map
    disguises.py right GAP.json             succeeds if the effect and its forces are right
    disguises.py spoil FILE DIRECTORY       writes damaged copies, and prints their names
    disguises.py foreign DIRECTORY          MAT and MCAP files that hexid cannot read

A mass of 200 kg moves by 20 mm at 2 Hz, with 80 N of dry friction that the model does not know. It rests for 2 s
before and after the motion. The noise is 1 N and 1 um.
"""
import json
import math
import random
import sys

HZ, AMPLITUDE_M, MASS_KG, DRY_N, SECONDS, RAMP, REST = 2.0, 0.02, 200.0, 80.0, 20.0, 2.0, 2.0
W = 2.0 * math.pi * HZ


def place(t):
    """Position: a sine whose amplitude rises and falls in two seconds each, with a continuous second derivative."""
    def smooth(s):
        s = min(max(s, 0.0), 1.0)
        return s * s * s * (10.0 + s * (6.0 * s - 15.0))
    gain = smooth((t - REST) / RAMP) * smooth((SECONDS - REST - t) / RAMP)
    return gain * AMPLITUDE_M * math.sin(W * (t - REST))


def speed(t, h=1e-4):
    return (place(t + h) - place(t - h)) / (2.0 * h)


def force(t, h=1e-4):
    acceleration = (place(t + h) - 2.0 * place(t) + place(t - h)) / h**2
    return MASS_KG * acceleration + DRY_N * math.tanh(speed(t) / 1e-4)


class Sensors:
    def __init__(self):
        self.random = random.Random(7)

    def position(self, t):
        return place(t) + self.random.gauss(0.0, 1e-6)

    def force(self, t):
        return force(t) + self.random.gauss(0.0, 1.0)


def times(rate, late=0.0):
    return [late + i / rate for i in range(int(SECONDS * rate))]


def write(name, directory):
    s = Sensors()
    rows = [(t, s.position(t), s.force(t)) for t in times(500.0)]

    def put(file, lines):
        with open(f"{directory}/{file}", "w", encoding="utf-8") as f:
            f.write("\n".join(lines) + "\n")

    def comma(x):
        return x.replace(".", ",")

    if name == "plain":
        put("a.csv", ["t_s,position_m,force_n"] + [f"{t:.4f},{x:.9f},{f:.4f}" for t, x, f in rows])
        return ""
    if name == "instrument":
        put("a.csv", ["Instrument;FlexTest", "Operator;Bo, Li", "Rate;500", "", "Time;Stroke;Load", "s;mm;kN"]
            + [comma(f"{t:.4f};{1e3 * x:.6f};{1e-3 * f:.7f}") for t, x, f in rows])
        return "t=Time,position=Stroke,force=Load"
    if name == "inches":
        def clock(t):
            return f"11/24/2024 {11 if t < 5 else 12}:{59 if t < 5 else 0:02d}:{(55 + t) % 60:07.4f} {'AM' if t < 5 else 'PM'}"
        put("a.csv", ["Stamp\tDisp (in)\tLoad (lbf)"] + [f"{clock(t)}\t{x / 0.0254:.8f}\t{f / 4.4482216152605:.6f}" for t, x, f in rows])
        return "t=Stamp:s,position=Disp (in),force=Load (lbf)"
    if name == "topics":
        late = [(t, s.force(t)) for t in times(500.0, 0.0007)]
        put("a.csv", ["__time,/axis/position,/cell/force"]
            + [line for (t, x, _), (u, f) in zip(rows, late) for line in (f"{1.7e9 + t:.6f},{x:.9f},", f"{1.7e9 + u:.6f},,{f:.4f}")])
        return "t=__time:s,position=/axis/position:m,force=/cell/force:N"
    if name == "clocks":
        late = [(t, s.force(t)) for t in times(200.0, 0.0013)]
        lines = [f"{t:.4f};{x:.9f};" + (f"{late[i][0]:.4f};{late[i][1]:.4f}" if i < len(late) else ";") for i, (t, x, _) in enumerate(rows)]
        put("a.csv", ["Time;Position [m];Time;Force [N]"] + [comma(line) for line in lines])
        return "t=Time:s,position=Position [m],force=Force [N]"
    if name == "files":
        put("position.csv", ["stamp_ms,x"] + [f"{1e3 * t:.1f},{1e3 * x:.6f}" for t, x, _ in rows])
        put("force.csv", ["stamp_us,f"] + [f"{1e6 * t:.0f},{s.force(t):.4f}" for t in times(200.0, 0.0013)])
        return "t=stamp_ms,t=stamp_us,position=x:mm,force=f:N"
    if name == "repeated":
        put("a.csv", ["t_s,position_m,force_n"] + [f"{t:.4f},{x:.9f},{rows[i - i % 5][2]:.4f}" for i, (t, x, _) in enumerate(rows)])
        return ""
    if name == "speed":
        put("a.csv", ["t_s,v,force_n"] + [f"{t:.4f},{1e3 * speed(t) + 1.5 + s.random.gauss(0.0, 0.05):.6f},{f:.4f}" for t, _, f in rows])
        return "position=v:mm/s"
    if name == "current":
        put("a.csv", ["t_s,Counts,Current [A]"] + [f"{t:.4f},{round(x / 2.5e-7)},{f / -85.2:.7f}" for t, x, f in rows])
        return "position=Counts:0.00025 mm,force=Current [A]:-85.2 N"
    if name == "turning":
        put("a.csv", ["t_s,q,tau"] + [f"{t:.4f},{math.degrees(x):.9f},{f:.4f}" for t, x, f in rows])
        return "position=q:deg,force=tau:N m"
    if name == "unnamed":
        put("a.csv", [f"  {x:.9f}   {f:.4f}" for _, x, f in rows])
        return "t=#0:2 ms,position=#1:m,force=#2:N"
    if name == "matlab":
        import numpy
        import scipy.io
        late = [(t, s.force(t)) for t in times(200.0, 0.0013)]
        run = {"axis": {"time": numpy.array([r[0] for r in rows]), "stroke": numpy.array([1e3 * r[1] for r in rows])},
               "cell": {"time": numpy.array([r[0] for r in late]), "load": numpy.array([r[1] for r in late])}}
        scipy.io.savemat(f"{directory}/a.mat", {"run": run, "note": "a text", "gain": 3.0}, do_compression=True)
        return "t=run.axis.time:s,t=run.cell.time:s,position=run.axis.stroke:mm,force=run.cell.load:N"
    if name == "mcap":
        from mcap.writer import CompressionType, Writer
        with open(f"{directory}/a.mcap", "wb") as out:
            w = Writer(out, compression=CompressionType.ZSTD)
            w.start()
            schema = w.register_schema(name="o", encoding="jsonschema", data=b'{"type":"object"}')
            topics = [w.register_channel(schema_id=schema, topic=t, message_encoding="json") for t in ("/axis", "/cell")]
            for t, x, f in rows:
                ns = 1700000000000000000 + round(t * 1e9)
                w.add_message(topics[0], log_time=ns, publish_time=ns, data=json.dumps({"state": {"position": [x, 0.0]}}).encode())
                w.add_message(topics[1], log_time=ns + 700000, publish_time=ns, data=json.dumps({"force": s.force(t + 0.0007)}).encode())
            w.finish()
        return "t=log_time_s,position=/axis.state.position.0:m,force=/cell.force:N"
    sys.exit(f"{name}: no disguise")


NAMES = ["plain", "instrument", "inches", "topics", "clocks", "files", "repeated", "speed", "current", "turning", "unnamed", "matlab", "mcap"]


def right(path):
    """Returns true if the effect alone is named and both forces are within 5 % of the truth."""
    with open(path, encoding="utf-8") as f:
        gap = json.load(f)
    forces = [v for e in gap["effects"] for v in e["parameters"].values()]
    print(gap["verdict"], *[e["name"] for e in gap["effects"]], *[f"{v:.2f}" for v in forces])
    named = gap["verdict"] == "effect_named" and [e["name"] for e in gap["effects"]] == ["cylinder_coulomb_friction"]
    return named and all(abs(v / DRY_N - 1.0) < 0.05 for v in forces)


def foreign(directory):
    import numpy
    import scipy.io
    from mcap.writer import CompressionType, Writer
    with open(f"{directory}/hdf.mat", "wb") as f:
        f.write(b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM" + b"\x89HDF\r\n\x1a\n")
    scipy.io.savemat(f"{directory}/texts.mat", {"note": "no numbers", "gain": 2.0})
    scipy.io.savemat(f"{directory}/flat.mat", {"Time": numpy.arange(2000) * 0.002, "Stroke": numpy.sin(numpy.arange(2000) * 0.02),
                                               "Load": numpy.cos(numpy.arange(2000) * 0.02), "other": numpy.arange(7.0)})
    t = numpy.arange(4000) * 0.002
    many = {f"value_{i}": numpy.arange(3.0) for i in range(600)}
    scipy.io.savemat(f"{directory}/wide.mat", {**many, "clock": t, "x": numpy.sin(6 * t), "f": numpy.cos(6 * t)})
    few = {f"value_{i}": numpy.arange(3.0) for i in range(300)}
    scipy.io.savemat(f"{directory}/long.mat", {**few, "zeros": numpy.zeros(500000, "u1"), "clock": t, "x": numpy.sin(6 * t), "f": numpy.cos(6 * t)},
                     do_compression=True)
    scipy.io.savemat(f"{directory}/timeout.mat", {"timeout": numpy.ones(4000), "time_gap": numpy.ones(4000), "t_s": t, "x": numpy.sin(6 * t),
                                                  "f": numpy.cos(6 * t)})
    test = numpy.repeat(numpy.arange(101.0), 2)
    scipy.io.savemat(f"{directory}/tests.mat", {"hexid": {"test": test, "dof": 0 * test, "test_time_s": numpy.arange(202) % 2 * 0.002,
                                                          "l1_m": 0 * test}})
    with open(f"{directory}/wide.mcap", "wb") as out:
        w = Writer(out, compression=CompressionType.ZSTD)
        w.start()
        schema = w.register_schema(name="o", encoding="jsonschema", data=b"{}")
        ids = [w.register_channel(schema_id=schema, topic=f"/t{i}", message_encoding="json") for i in range(301)]
        other = json.dumps({f"value_{i}": i for i in range(600)}).encode()
        w.add_message(ids[0], log_time=0, publish_time=0, data=other)
        order = list(range(4000))
        order[100:104] = reversed(order[100:104])
        for i in order:
            data = json.dumps({"x": math.sin(6 * t[i]), "f": math.cos(6 * t[i])}).encode()
            w.add_message(ids[300], log_time=i * 2000000, publish_time=0, data=data)
        w.finish()
    with open(f"{directory}/wide.mcap", "rb") as f:
        whole = f.read()
    with open(f"{directory}/cut.mcap", "wb") as f:
        f.write(whole[:whole.rindex(b"\x0f\x04" + bytes(7))])
    with open(f"{directory}/large.mcap", "wb") as f:
        f.write(whole[:8] + b"\x06" + (1 << 40).to_bytes(8, "little"))
    for name, encoding, compression in ("cdr", "cdr", CompressionType.ZSTD), ("lz4", "json", CompressionType.LZ4):
        with open(f"{directory}/{name}.mcap", "wb") as out:
            w = Writer(out, compression=compression)
            w.start()
            channel = w.register_channel(schema_id=w.register_schema(name="o", encoding="jsonschema", data=b"{}"), topic="/a", message_encoding=encoding)
            for i in range(100):
                w.add_message(channel, log_time=i * 2000000, publish_time=0, data=b'{"x":1}')
            w.finish()


def spoil(path, directory):
    """Writes copies of a file with wrong bytes, every other one cut short too, and prints their names."""
    with open(path, "rb") as f:
        data = f.read()
    r = random.Random(3)
    for i in range(24):
        bad = bytearray(data[: r.randrange(8, len(data))] if i % 2 else data)
        for _ in range(3):
            bad[r.randrange(8, len(bad))] = r.randrange(256)
        name = f"{directory}/{i}{path[path.rindex('.'):]}"
        with open(name, "wb") as f:
            f.write(bad)
        print(name)


if sys.argv[1] == "list":
    print(*NAMES)
elif sys.argv[1] == "write":
    print(write(sys.argv[2], sys.argv[3]))
elif sys.argv[1] == "right":
    sys.exit(not right(sys.argv[2]))
elif sys.argv[1] == "spoil":
    spoil(sys.argv[2], sys.argv[3])
elif sys.argv[1] == "foreign":
    foreign(sys.argv[2])
