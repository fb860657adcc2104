"""A drive that moves 200 kg to and fro, as another program records it: axis.py FRICTION_N SEED [millimetres: where it says metres | own-names |
cylinder: 50 mm, rod 28 mm, with its pressures | both: and the force]"""
import math
import random
import sys

friction, seed, how = float(sys.argv[1]), int(sys.argv[2]), sys.argv[3:]
random.seed(seed)
mass, viscous = 200 * random.uniform(0.992, 1.008), 2000 * random.uniform(0.96, 1.04)
w, amplitude = 2 * math.pi * 2, 0.02
pressures, areas = "cylinder" in how or "both" in how, [math.pi / 4 * square for square in (0.05**2, 0.05**2 - 0.028**2)]
print("# mechanism: axis\n# rate_hz: 400\n# frequency_hz: 2")
if "own-names" in how:
    print("Zeit;Weg [mm];Kraft;Motortemperatur")
elif pressures:
    print("t [ms];position_mm;p1 [bar];p2 [bar]" + ";force (kN)" * ("both" in how))
else:
    print("t [ms];%s;force (kN);motor temperature" % ("position_m" if "millimetres" in how else "position_mm"))
for i in range(400 * 12):
    if random.random() < 0.004:
        continue  # lost row
    t = i / 400
    ramp = min(t, 1.0)
    x, v, a = (ramp * amplitude * f for f in (math.sin(w * t), w * math.cos(w * t), -w * w * math.sin(w * t)))
    force = mass * a + viscous * v + friction * (v > 0) - friction * (v < 0) + random.gauss(0, 3)
    cells = "%.3f" % (1e3 * t), "%.3f" % (1e3 * (x + random.gauss(0, 3e-6))), "" if i % 333 == 0 else "%.5f" % (1e-3 * force), "warm"
    if pressures:
        p1, p2 = (1e-5 * (4e6 * areas[0] + half) / area + random.gauss(0, 0.01) for half, area in zip((force / 2, -force / 2), areas))
        cells = cells[:2] + ("%.4f" % p1, "%.4f" % p2) + cells[2:3] * ("both" in how)
    print(";".join(cells).replace(".", ","))
    if i % 1000 == 0:
        print("# still running")
