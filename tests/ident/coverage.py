#!/usr/bin/env python3
"""Do method C's intervals contain the truth? Random machines on the simulated platform against their own inertia matrix, computed here.

    coverage.py [--machines 200] [--first 1] [--dry 150] [KEY=VALUE ...]

Each machine has its joints off by model.tolerance.joints_m (uniform, each coordinate), a payload of 0.7 to 1.3 times the configured mass
and inertias with its centre off by up to 30 mm, and separate dry friction of 0 to --dry N for each leg and direction. It has sensors with
noise; the configuration stays the same. Prints, entry by entry, how many of the 95 % intervals contain the machine's own value, and the
payload's largest errors. Environment: HEXID."""
import argparse, concurrent.futures, json, math, os, random, statistics, subprocess, sys, tempfile

sys.dont_write_bytecode = True # leaves no files in the tree
sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "bench"))
import measured

HEXID = os.environ.get("HEXID", "build/hexid")
AXES = ("x", "y", "z", "phi", "theta", "psi")
# Values of Tian 2015 Tables 1 and 2, as in config/tian2015.yaml.
RA, RB, H, ALPHA, BETA, CENTRE = .56, 1.20, 1.64, .2343, .1886, .16
MASS, INERTIA = 178.6, (13.6, 13.6, 23.92)
MA, MB, IA, IB, UPPER, LOWER = 15.65, 52.48, 2.11, 3.58, .70, .71
JOINTS_M = .5e-3


def joints(r):
    third = 2 * math.pi / 3
    upper = [(-ALPHA), ALPHA, third - ALPHA, third + ALPHA, 2 * third - ALPHA, 2 * third + ALPHA]
    lower = [-math.pi / 3 + BETA, math.pi / 3 - BETA, math.pi / 3 + BETA, math.pi - BETA, math.pi + BETA, 5 * math.pi / 3 - BETA]
    off = [[[r.uniform(-JOINTS_M, JOINTS_M) for _ in range(3)] for _ in range(6)] for _ in range(2)]
    a = [[RA * math.cos(u) + d[0], RA * math.sin(u) + d[1], CENTRE + d[2]] for u, d in zip(upper, off[0])]
    b = [[RB * math.cos(u) + d[0], RB * math.sin(u) + d[1], CENTRE + H + d[2]] for u, d in zip(lower, off[1])]
    return a, b, off


def skew(v): return [[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]]


def times(a, b): return [[sum(a[i][k] * b[k][j] for k in range(len(b))) for j in range(len(b[0]))] for i in range(len(a))]


def matrix(a, b, mass, centre, inertia):
    """Returns the matrix by Tian 2015 A1 to A6 at neutral, about the origin of {M}, with an off-centre payload."""
    m = [[0.0] * 6 for _ in range(6)]
    c = skew(centre)
    cc = times(c, c)
    for i in range(3):
        m[i][i] += mass
        for j in range(3):
            m[i][3 + j] -= mass * c[i][j]
            m[3 + i][j] += mass * c[i][j]
            m[3 + i][3 + j] += (inertia[i] if i == j else 0) - mass * cc[i][j]
    for p, q in zip(a, b):
        leg = [x - y for x, y in zip(p, q)]
        length = math.sqrt(sum(x * x for x in leg))
        n = [x / length for x in leg]
        across = (MA * (length - UPPER) ** 2 + MB * LOWER ** 2 + IA + IB) / length ** 2
        own = [[MA * n[i] * n[j] + across * ((i == j) - n[i] * n[j]) for j in range(3)] for i in range(3)]
        jacobian = [[float(i == j) for j in range(3)] + [-x for x in skew(p)[i]] for i in range(3)]
        add = times([list(x) for x in zip(*jacobian)], times(own, jacobian))
        for i in range(6):
            for j in range(6): m[i][j] += add[i][j]
    return m


def machine(seed, dry_n, more):
    r = random.Random(seed)
    a, b, off = joints(r)
    mass, inertia = MASS * r.uniform(.7, 1.3), [x * r.uniform(.7, 1.3) for x in INERTIA]
    centre = [r.uniform(-.03, .03) for _ in range(3)]
    settings = {"effects.geometry_error.%s_%s_m" % ("ab"[k], "xyz"[i]): [off[k][leg][i] for leg in range(6)] for k in range(2) for i in range(3)}
    settings |= {"effects.payload_mass.mass_kg": mass - MASS}
    settings |= {"effects.payload_rotational_inertia." + k: x - y for k, x, y in zip(("xx", "yy", "zz"), inertia, INERTIA)}
    settings |= {"effects.payload_center_of_mass.%s_m" % k: x for k, x in zip("xyz", centre)}
    settings |= {"effects.cylinder_coulomb_friction.force_%s_n" % k: [r.uniform(0, dry_n) for _ in range(6)] for k in ("extend", "retract")}
    settings |= {"sim.engine": "closed_form", "lcm.url": "", "motion.engage_s": 1.6, "motion.park_s": 1.6, "motion.hold_s": .1}
    options = [x for k, v in settings.items()
               for x in ("--set", "%s=%s" % (k, "[%s]" % ",".join("%.9g" % y for y in v) if isinstance(v, list) else v))]
    options += [x for s in more for x in ("--set", s)]
    with tempfile.TemporaryDirectory() as work:
        run = subprocess.run([HEXID, "run", "--fast", "--seed", str(seed), "--json", work + "/run.json"] + options, capture_output=True, text=True)
        if run.returncode not in (0, 1): raise SystemExit("machine %d: %s" % (seed, run.stderr.strip()))
        with open(work + "/run.json") as f: c = json.load(f)["method_c"]
    if not c: return None
    return c, matrix(a, b, mass, centre, inertia), mass, centre, inertia


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--machines", type=int, default=200)
    p.add_argument("--first", type=int, default=1)
    p.add_argument("--dry", type=float, default=150)
    p.add_argument("settings", nargs="*")
    a = p.parse_args()
    print(measured.build())
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        runs = list(pool.map(lambda seed: machine(seed, a.dry, a.settings), range(a.first, a.first + a.machines)))
    known = measured.enough([r for r in runs if r], "machines that method C was evaluated on")
    print("%d machines, method C evaluated on %d; 95 %% intervals that hold, %%; below: rms error, %% of sqrt(M_ii M_jj)" % (len(runs), len(known)))
    inside = total = 0
    for i in range(6):
        hold, rms = [], []
        for j in range(6):
            cells = [(c["Mt"][i][j] - m[i][j], c["std"][i][j], math.sqrt(m[i][i] * m[j][j])) for c, m, *_ in known if c["Mt"][i][j] is not None]
            measured.enough(cells, "entry %d, %d" % (i + 1, j + 1))
            good = sum(abs(e) <= 1.96 * s for e, s, _ in cells)
            hold.append("%7.1f" % (100 * good / len(cells)))
            rms.append("%7.2f" % measured.finite(100 * math.sqrt(statistics.fmean((e / size) ** 2 for e, _, size in cells)), "rms error"))
            if j >= i: inside, total = inside + good, total + len(cells)
        print("%-6s" % AXES[i], *hold)
        print("      ", *rms)
    print("all: %.1f %% of %d" % (100 * inside / total, total))
    errors = {"mass, %": [], "centre, mm": [], "inertia, % of the largest": []}
    for c, _, mass, centre, inertia in known:
        v = c["payload"]["value"] if c["payload"] else None
        if not v: continue
        errors["mass, %"].append(100 * abs(v["mass_kg"] / mass - 1))
        errors["centre, mm"].append(1e3 * max(abs(v["center_%s_m" % k] - x) for k, x in zip("xyz", centre)))
        truth = dict(zip(("xx", "yy", "zz"), inertia)) | {"xy": 0, "xz": 0, "yz": 0}
        errors["inertia, % of the largest"].append(100 * max(abs(v["inertia_%s_kg_m2" % k] - x) for k, x in truth.items()) / max(inertia))
    for name, values in errors.items():
        measured.enough(values, "payload, " + name).sort()
        print("payload, %s: median %.2f, 95 %% below %.2f" % (name, values[len(values) // 2], values[int(.95 * len(values))]))


if __name__ == "__main__": main()
