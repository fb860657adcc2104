#!/usr/bin/env python3
"""Random faults of sensors, wiring and configuration: how does `hexid identify` judge such recordings?

    random_faults.py --recordings DIR [--faults 200] [--first 1] [--machines 8] [--row all_priors] [--wrong 1] [--jobs 1]

Each draw takes one machine of DIR, as real_sensors.py recorded it, and makes one to three faults of it: channels scaled, offset, inverted,
exchanged, stuck, noisy, late, rotated by some legs; a drawing or an area that is another machine's. The program may refuse the recording, fail
it, or pass it. A result that passes must have a payload that can exist; and if its intervals do not contain the truth, the draw is counted as wrong.
Fails if a payload that cannot exist passes, or a wrong result does in more than --wrong of a hundred draws. Machines that DIR has not are
recorded. Environment: HEXID, RIG."""
import argparse, collections, concurrent.futures, csv, math, os, random, sys, tempfile

sys.dont_write_bytecode = True # leaves no files in the tree
sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import real_sensors as sensors

TESTS = 6
PASSABLE = 3.0 # rms of error/deviation of a result, above which it is wrong
CHANNELS = ("l%d_m", "p1_%d_pa", "p2_%d_pa")
WORDS = dict(zip(CHANNELS, ("lengths", "p1", "p2")))


def legs_of(r): return r.sample(range(1, 7), r.choice((1, 1, 1, 2, 6)))


def channel(r): return r.choice(CHANNELS)


def signed(r, least, most): return r.choice((-1, 1)) * math.exp(r.uniform(math.log(least), math.log(most)))


def mapped(names, change):
    """Returns a fault that changes the columns with these names."""
    def fault(columns, r):
        for name in names: columns[name] = change(columns[name], r)
    return fault


def column_fault(change):
    def draw(r):
        kind, legs = channel(r), legs_of(r)
        size, words = change(kind, r)
        return "%s of %s" % (words, ", ".join(kind % leg for leg in legs)), mapped([kind % leg for leg in legs], size), []
    return draw


def scaled(kind, r):
    factor = 1 + signed(r, .005, .5)
    def change(x, _):
        middle = sum(x) / len(x) if kind == CHANNELS[0] else 0 # a length's gain acts about a place in the stroke
        return [middle + factor * (v - middle) for v in x]
    return change, "gain %.4g" % factor


def offset(kind, r):
    by = signed(r, 1e-3, .1) if kind == CHANNELS[0] else signed(r, 3e4, 3e6)
    return (lambda x, _: [v + by for v in x]), "offset %.3g" % by


def drift(kind, r):
    by = signed(r, 1e-4, 1e-2) if kind == CHANNELS[0] else signed(r, 1e4, 1e6)
    return (lambda x, _: [v + by * i / len(x) for i, v in enumerate(x)]), "drift %.3g" % by


def late(kind, r):
    rows = r.randrange(1, 11)
    return (lambda x, _: [x[0]] * rows + x[:-rows]), "%d ms late" % (2 * rows)


def lagging(kind, r):
    keep = math.exp(-.002 / math.exp(r.uniform(math.log(1e-3), math.log(2e-2))))
    def change(x, _):
        out, state = [], x[0]
        for v in x:
            state = keep * state + (1 - keep) * v
            out.append(state)
        return out
    return change, "first-order lag of %.3g ms" % (-2 / math.log(keep))


def noisy(kind, r):
    std = math.exp(r.uniform(math.log(2e-5), math.log(2e-3))) if kind == CHANNELS[0] else math.exp(r.uniform(math.log(2e4), math.log(1e6)))
    return (lambda x, draw: [v + draw.gauss(0, std) for v in x]), "noise %.3g" % std


def inverted(kind, r):
    def change(x, _):
        middle = sum(x) / len(x)
        return [2 * middle - v for v in x]
    return change, "inverted motion"


def stuck(kind, r):
    share = r.choice((0, .3, .7))
    return (lambda x, _: [v if i < share * len(x) else x[int(share * len(x))] for i, v in enumerate(x)]), "stuck after %g of the test" % share


def clipped(kind, r):
    share = r.uniform(.05, .4)
    def change(x, _):
        top = max(x) - share * (max(x) - min(x))
        return [min(v, top) for v in x]
    return change, "clipped by %.2g of its range" % share


def held(kind, r):
    rows = r.randrange(2, 9)
    return (lambda x, _: [x[i - i % rows] for i in range(len(x))]), "new every %d rows" % rows


def curved(kind, r):
    by = signed(r, .003, .1)
    def change(x, _):
        middle = sum(x) / len(x)
        half = max(max(x) - middle, middle - min(x)) or 1
        return [v + by * half * (((v - middle) / half) ** 2 - .5) for v in x]
    return change, "curved by %.3g of its range" % by


def exchanged(r):
    a, b = r.sample(range(1, 7), 2)
    kinds = r.choice((CHANNELS[:1], CHANNELS[1:], CHANNELS, CHANNELS[1:2]))
    def fault(columns, _):
        for kind in kinds: columns[kind % a], columns[kind % b] = columns[kind % b], columns[kind % a]
    return "%s of legs %d and %d exchanged" % (", ".join(map(WORDS.get, kinds)), a, b), fault, []


def sides(r):
    legs = legs_of(r)
    def fault(columns, _):
        for leg in legs: columns["p1_%d_pa" % leg], columns["p2_%d_pa" % leg] = columns["p2_%d_pa" % leg], columns["p1_%d_pa" % leg]
    return "p1 and p2 exchanged, legs %s" % legs, fault, []


def rotated(r):
    by, back = r.randrange(6), r.random() < .5
    kinds = r.choice((CHANNELS[:1], CHANNELS[1:], CHANNELS))
    order = [((-i if back else i) + by) % 6 + 1 for i in range(6)]
    def fault(columns, _):
        for kind in kinds:
            old = [columns[kind % leg] for leg in order]
            for i, x in enumerate(old): columns[kind % (i + 1)] = x
    return "%s in the order %s" % (", ".join(map(WORDS.get, kinds)), order), fault, []


def configured(r):
    """Returns a configuration with a value of another machine: areas, payload, gravity or the drawing."""
    config = sensors.configured(None)
    key = r.choice(("actuator.piston_diameter_m", "actuator.rod_diameter_m", "payload.mass_kg", "actuator.upper_mass_kg", "geometry.upper_radius_m",
                    "geometry.lower_radius_m", "geometry.height_m"))
    if key not in config: return configured(r)
    value = config[key] * (1 + signed(r, .01, .4))
    return "%s=%.6g" % (key, value), lambda columns, _: None, ["%s=%.6g" % (key, value)]


FAULTS = [column_fault(f) for f in (scaled, scaled, offset, drift, late, lagging, noisy, inverted, stuck, clipped, held, curved)] + [
    exchanged, sides, rotated, configured]


def table(path):
    with open(path) as file: lines = file.read().splitlines()
    head = [x for x in lines if x.startswith("#")]
    rows = list(csv.reader(x for x in lines if not x.startswith("#")))
    return head, {name: [float(row[i]) for row in rows[1:]] for i, name in enumerate(rows[0])}


def write(path, head, columns):
    with open(path, "w") as file:
        file.write("\n".join(head + [",".join(columns)]) + "\n")
        for row in zip(*columns.values()): file.write(",".join("%.10g" % v for v in row) + "\n")


def possible(payload):
    """True if a body within four deviations of this payload can exist."""
    value, std, nearest = payload["value"], payload["std"], payload["nearest"]
    return nearest["mass_kg"] > 0 and all(abs(value[k] - nearest[k]) <= 4 * std[k] for k in value)


def run(a, number):
    r = random.Random("fault %d" % number)
    seed = r.randrange(1, a.machines + 1)
    work = os.path.join(a.recordings, "rig", "default", a.row, str(seed))
    truth = sensors.recorded(argparse.Namespace(c=None, truth="rig", dry=50), a.row, seed, work)
    drawn = [r.choice(FAULTS)(r) for _ in range(r.choice((1, 1, 2, 3)))]
    with tempfile.TemporaryDirectory() as out:
        os.mkdir(out + "/measured")
        for i in range(TESTS):
            head, columns = table("%s/measured/%d.csv" % (work, i))
            if r.random() < .3 and number % 3 == 0: columns = {k: v for k, v in columns.items() if not k.startswith("ref_")}
            for _, fault, _ in drawn: fault(columns, random.Random("%d %d" % (number, i)))
            write("%s/measured/%d.csv" % (out, i), head, columns)
        a_run = argparse.Namespace(c=None, settings=[s for _, _, settings in drawn for s in settings])
        try: result = sensors.identified(a_run, out, out)
        except SystemExit as e: result = {"method_c": None, "verdict": {"status": "refused", "reasons": [str(e)]}}
    return " + ".join(words for words, _, _ in drawn), seed, result, truth


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--recordings", required=True, metavar="DIR")
    p.add_argument("--faults", type=int, default=200)
    p.add_argument("--first", type=int, default=1)
    p.add_argument("--machines", type=int, default=8)
    p.add_argument("--row", default="all_priors")
    p.add_argument("--wrong", type=float, default=1)
    p.add_argument("--jobs", type=int, default=1)
    a = p.parse_args()
    sensors.measured.enough(range(a.faults), "faults")
    print("%s; %d draws of one to three faults" % (sensors.measured.build(), a.faults))
    count, impossible = collections.Counter(), 0
    with concurrent.futures.ThreadPoolExecutor(a.jobs) as pool:
        for words, seed, result, truth in pool.map(lambda n: run(a, n), range(a.first, a.first + a.faults)):
            status, c = result["verdict"]["status"], result["method_c"]
            kind = status
            if status == "pass" and c:
                off = sensors.deviations([(result, truth)])
                rms = math.sqrt(sum(z * z for z in off) / len(off))
                kind = "pass, right" if rms < PASSABLE else "pass, wrong"
                if not possible(c["payload"]): kind, impossible = "pass, impossible", impossible + 1
                print("%-18s machine %2d  rms %.2f  %s" % (kind, seed, rms, words), flush=True)
            else: print("%-18s machine %2d  %s  <- %s" % (kind, seed, words, (result["verdict"]["reasons"] + [""])[0]), flush=True)
            count[kind] += 1
    print(", ".join("%s %d" % pair for pair in sorted(count.items())))
    if impossible or count["pass, wrong"] > a.wrong / 100 * a.faults: sensors.measured.fail("results that are wrong pass")


if __name__ == "__main__": main()
