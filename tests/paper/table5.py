#!/usr/bin/env python3
"""Finds simulated effects with which hexid's method A reads the values of Tian 2015's real machine (Table 5); docs/table5.md has the results.

    table5.py search                  # the best single effects and pairs, as Markdown
    table5.py laws                    # friction, controller and mass centre together: each law of friction, and each part left out
    table5.py chance                  # how much would be explained of the same deviations with other signs?
    table5.py state KEY=VALUE ...     # what methods A and B read on one machine, beside Table 5
    table5.py legs KEY=VALUE ...      # the leg forces behind it
    table5.py check docs/table5.md    # the machines that the page states, run again

Every hypothesis is the simulated machine run anew (closed form, exact sensors, shortened tests), never a linearisation; results are kept in
DIR by the settings and the program they belong to. Environment: HEXID. Needs nothing but Python."""
import argparse, csv, functools, hashlib, itertools, json, math, operator, os, random, statistics, subprocess, sys
sys.dont_write_bytecode = True # leaves no files in the tree
sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "bench"))
import measured
from hypotheses import HYPOTHESES, LOWER, UPPER

HEXID = os.environ.get("HEXID", "build/hexid")
TABLES = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "data")
TESTS = ("x", "y", "z", "phi", "theta", "psi")
ENTRIES = ("mx", "my", "mz", "Ixx", "Iyy", "Izz", "Mt15", "Mt24", "Mt42", "Mt51")
# Shorter rests and ramps than the shipped tests: with exact sensors they move no entry by more than 0.4 (kg, kg m, kg m^2).
BASE = {"lcm.url": "", "sim.engine": "closed_form", "sensors.enabled": "false", "motion.engage_s": 1.6, "motion.park_s": 1.6,
        "motion.hold_s": .1, "tests.settle_s": .5, "tests.ramp_s": .5, "tests.duration_s": 1.5, "tests.ramp_out_s": .2}


# ---- the simulated machine -------------------------------------------------------------------------------------------------------------

@functools.lru_cache(None)
def program():
    try:
        with open(HEXID, "rb") as f: return hashlib.sha1(f.read()).hexdigest()
    except OSError as e: raise SystemExit("table5: %s: `make` first, or set HEXID" % e)


def result(settings, cache, seed=1):
    """Returns the JSON of `hexid run` of the paper's six tests; None if the machine did not complete them."""
    options = ["--seed", str(seed)] + [x for k, v in sorted((BASE | settings).items()) for x in ("--set", "%s=%s" % (k, v))]
    path = os.path.join(cache, hashlib.sha1("\0".join([program()] + options).encode()).hexdigest() + ".json")
    if not os.path.exists(path):
        run = subprocess.run([HEXID, "run", "--fast", "--json", path + ".part"] + options, capture_output=True, text=True)
        if run.returncode not in (0, 1, 4) or not os.path.exists(path + ".part"): # refused before any motion
            print("no such machine:", run.stderr.strip(), file=sys.stderr)
            with open(path + ".part", "w") as f: f.write("null")
        os.rename(path + ".part", path)
    with open(path) as f: r = json.load(f)
    return r if r and r["method_a"] and r["method_b"] else None


def entries(settings, cache, method="method_a", seed=1):
    r = result(settings, cache, seed)
    return r and [r[method]["Mt"][i][j] for i, j in PLACES]


def table(name):
    with open(os.path.join(TABLES, name)) as f: return list(csv.DictReader(f))


PLACES = [(int(row["row"]) - 1, int(row["col"]) - 1) for row in table("table5_experiment.csv")]


def column(name, key): return [float(row[key]) for row in table(name)]


# ---- what is compared, and how exactly it can be known ----------------------------------------------------------------------------------

def stated_error(cache, seeds=20):
    """Returns the standard deviation of each entry: the print's rounding, the sensors' noise (`seeds` runs), the method's own error in the
    paper's Table 3."""
    noisy = [entries({"sensors.enabled": "true", "tests.duration_s": 5}, cache, seed=s) for s in range(1, seeds + 1)]
    for seed, x in enumerate(noisy, 1): measured.enough(x, "the paper's machine, seed %d" % seed)
    method = [abs(a - n) for a, n in zip(column("table3_linear_friction.csv", "method_a"), column("table3_linear_friction.csv", "nominal"))]
    return [math.sqrt((.1 / math.sqrt(12)) ** 2 + statistics.stdev(x) ** 2 + m ** 2) for x, m in zip(zip(*noisy), method)]


# ---- search ----------------------------------------------------------------------------------------------------------------------------

class Model:
    """Hypotheses with their sizes, the machine's reading with them, and its distance from Table 5."""

    def __init__(self, search, parts):
        self.search, self.parts = search, parts
        settings = {}
        for h, size in parts: settings |= h.settings(size)
        self.settings, self.value = settings, entries(settings, search.cache)
        self.residual = self.value and search.residual(self.value)
        self.chi2 = sum(x * x for x in self.residual) if self.value else math.inf

    def name(self): return " + ".join("%s %.3g %s" % (h.name, size, h.unit) for h, size in self.parts)

    def key(self): return frozenset(h.name for h, _ in self.parts)

    def jacobian(self):
        """Returns the change of the residual with each size, over the hypothesis' range; towards the inside of the range."""
        columns = []
        for i, (h, size) in enumerate(self.parts):
            step = .04 * (h.high - h.low) * (-1 if size + .04 * (h.high - h.low) > h.high else 1)
            near = Model(self.search, self.parts[:i] + [(h, size + step)] + self.parts[i + 1:])
            if not near.value: return None
            columns.append([(a - b) / (step / (h.high - h.low)) for a, b in zip(near.residual, self.residual)])
        return columns

    def deviations(self):
        """Returns the standard deviations of the sizes, with the stated error enlarged to the residual: an undetermined size has a large
        one."""
        j, k = self.jacobian(), len(self.parts)
        if not j: return [math.nan] * k
        scale = self.chi2 / (len(ENTRIES) - k)
        inverse = [solved([row + [float(i == m)] for m, row in enumerate(normal(j, 0))])[i] for i in range(k)]
        return [math.sqrt(scale * v) * (h.high - h.low) for v, (h, _) in zip(inverse, self.parts)]

    def moved(self, change):
        return Model(self.search, [(h, min(h.high, max(h.low, size + c * (h.high - h.low)))) for (h, size), c in zip(self.parts, change)])

    def fitted(self):
        """Fits the sizes within bounds, by Levenberg's and Marquardt's method."""
        best, damping = self, 1e-3
        for _ in range(8):
            j = best.jacobian()
            if not j: return best
            for _ in range(8):
                next_ = best.moved(step(j, best.residual, damping))
                if next_.chi2 < best.chi2: break
                damping *= 10
            if next_.chi2 > .999 * best.chi2: return next_ if next_.chi2 < best.chi2 else best
            best, damping = next_, damping / 10
        return best


def solved(a):
    """Returns x of A x = b, given as rows [A | b], by Gauss-Jordan elimination with pivots."""
    n = len(a)
    for i in range(n):
        pivot = max(range(i, n), key=lambda k: abs(a[k][i]))
        a[i], a[pivot] = a[pivot], a[i]
        for k in range(n):
            if k != i: a[k] = [x - a[k][i] / a[i][i] * y for x, y in zip(a[k], a[i])]
    return [a[i][n] / a[i][i] for i in range(n)]


def normal(columns, damping):
    """Returns J'J, its diagonal larger by the damping; the last term keeps a size without any influence where it is."""
    return [[sum(map(operator.mul, p, q)) * (1 + damping * (p is q)) + 1e-12 * (p is q) for q in columns] for p in columns]


def step(columns, residual, damping):
    """Returns the least-squares change of the sizes: (J'J + damping diag) c = -J'r."""
    return solved([row + [-sum(x * r for x, r in zip(p, residual))] for row, p in zip(normal(columns, damping), columns)])


class Search:
    def __init__(self, cache, floor, only=None, seeds=20):
        self.cache = cache
        self.measured = column("table5_experiment.csv", "method_a")
        self.sigma = stated_error(cache, seeds)
        self.nominal = measured.enough(entries({}, cache), "the paper's machine, exact sensors")
        unknown = set(only or ()) - {h.name for h in HYPOTHESES}
        if unknown: measured.fail("no such hypothesis: " + ", ".join(unknown))
        self.hypotheses = [h for h in HYPOTHESES if not only or h.name in only]
        if floor:
            diagonal = dict(zip(PLACES, self.nominal))
            size = [math.sqrt(abs(diagonal[i, i] * diagonal[j, j])) for i, j in PLACES]
            self.sigma = [math.hypot(s, floor * x) for s, x in zip(self.sigma, size)]
        self.nothing = Model(self, [])

    def residual(self, value): return [(m - v) / s for m, v, s in zip(self.measured, value, self.sigma)]

    def extended(self, model, columns):
        """Yields the model with each other hypothesis at each of its sizes, and the residual when the model's own sizes adapt, to first
        order."""
        for h in self.hypotheses:
            if h.name in model.key(): continue
            for size in h.sizes():
                more = Model(self, model.parts + [(h, size)])
                if not more.value: continue
                change = step(columns, more.residual, 1e-2) if columns else []
                left = [r + sum(c * x[i] for c, x in zip(change, columns)) for i, r in enumerate(more.residual)]
                yield sum(x * x for x in left), more

    def grown(self, beam, count):
        """Returns models with one hypothesis more than those of the beam: the most promising ones, fitted, best first."""
        candidates = {}
        for model in beam:
            columns = model.jacobian() if model.parts else []
            for left, more in self.extended(model, columns):
                if left < candidates.get(more.key(), (math.inf,))[0]: candidates[more.key()] = (left, more)
            print("%d runs kept" % len(os.listdir(self.cache)), file=sys.stderr)
        measured.enough(candidates, "machines with one hypothesis more")
        best = sorted(candidates.values(), key=lambda c: c[0])[:count]
        return sorted((more.fitted() for _, more in best), key=lambda m: m.chi2)

    def share(self, model): return 100 * (1 - model.chi2 / self.nothing.chi2)

    def bic(self, model):
        """Returns Schwarz's criterion with unknown error scale, plus a penalty for the choice among so many hypotheses."""
        k, n = len(model.parts), len(self.measured)
        return n * math.log(model.chi2 / n) + k * math.log(n) + 2 * math.log(math.comb(len(HYPOTHESES), k))

    def show(self, models):
        print("\n| model | explained, % | rms, sigma | BIC | " + " | ".join(ENTRIES) + " |\n|" + " --- |" * 14)
        for m in models:
            print("| %s | %.1f | %.1f | %.1f | %s |" % (m.name() or "nothing", self.share(m), math.sqrt(m.chi2 / 10), self.bic(m),
                                                       " | ".join("%.1f" % measured.finite(x, m.name() or "nothing") for x in m.value)))
            print("| | | | | %s |" % " | ".join("%+.0f" % x for x in m.residual), flush=True)


# ---- could it be chance? ---------------------------------------------------------------------------------------------------------------

def curves(s):
    """Scans each hypothesis on a fine grid of sizes. Returns the changes of the ten entries in units of the error, interpolated
    linearly."""
    grids = []
    for h in HYPOTHESES:
        for side in (h.low, h.high):
            known = [[0.0] * len(ENTRIES)]
            for size in h.sizes():
                if (size - h.neutral) * (side - h.neutral) <= 0: continue
                value = entries(h.settings(size), s.cache)
                if not value: break
                known.append([(v - n) / e for v, n, e in zip(value, s.nominal, s.sigma)])
            grids.append([[p + t / 8 * (q - p) for p, q in zip(a, b)] for a, b in zip(known, known[1:]) for t in range(1, 9)])
    return [g for g in grids if g]


def left(target, vectors):
    """Returns the smallest |target - v|^2 over the vectors (with their |v|^2)."""
    t2 = sum(x * x for x in target)
    return min(t2 - 2 * sum(map(operator.mul, target, v)) + v2 for v, v2 in vectors)


def explained(target, grids):
    """Returns the shares that the best hypothesis and the best pair explain when their scans are added; pairs from the four best
    hypotheses."""
    t2 = sum(x * x for x in target)
    singles = sorted((left(target, g), i) for i, g in enumerate(grids))
    pairs = min(left([t - x for t, x in zip(target, v)], other) for _, i in singles[:4] for v, _ in grids[i]
                for j, other in enumerate(grids) if j != i)
    return 1 - singles[0][0] / t2, 1 - min(pairs, singles[0][0]) / t2


def chance(a):
    """Gives the same deviations random signs, and prints how much of them the hypotheses would explain."""
    print(measured.build())
    s, draw = Search(a.cache, a.floor), random.Random(1)
    grids = [[(v, sum(x * x for x in v)) for v in g] for g in curves(s)]
    target = s.nothing.residual
    print("Table 5: single %.2f, pair %.2f" % explained(target, grids))
    drawn = [explained([x * draw.choice((-1, 1)) for x in target], grids) for _ in range(a.patterns)]
    for what, shares, own in zip(("single", "pair"), zip(*drawn), explained(target, grids)):
        print("signs at random, %s: median %.2f, as much as Table 5's or more in %d of %d" % (
            what, statistics.median(shares), sum(x >= own - 1e-9 for x in shares), len(shares)))


# ---- without any simulation: the legs' forces that Table 5 asks for --------------------------------------------------------------------

def jacobian():
    """Returns the legs' rates from the six coordinates' rates at neutral, for Tian 2015 Table 1 (method.md, section 2)."""
    rows = []
    for u, l in zip(UPPER, LOWER):
        a, b = [.56 * math.cos(u), .56 * math.sin(u), .16], [1.2 * math.cos(l), 1.2 * math.sin(l), .16 + 1.64]
        leg = [p - q for p, q in zip(a, b)]
        n = [x / math.hypot(*leg) for x in leg]
        rows.append(n + [a[1] * n[2] - a[2] * n[1], a[2] * n[0] - a[0] * n[2], a[0] * n[1] - a[1] * n[0]])
    return rows


def legs(a):
    """Prints the peak leg speed of each test, and the amplitude of the legs' forces, in phase with the acceleration, that change the
    nominal matrix into the one read: J' f = (Mt - nominal) column w^2 amplitude. Entries that the paper does not print are taken to be
    nominal."""
    j, w = jacobian(), 8 * math.pi
    nominal = column("table5_experiment.csv", "nominal")
    read = [("Table 5", column("table5_experiment.csv", "method_a"), nominal),
            ("Table 4, 200 N", column("table4_nonlinear_friction.csv", "method_a"), nominal)]
    if a.settings: read.append(("simulated", entries(dict(a.settings), a.cache), entries({}, a.cache)))
    forces = []
    for test, name in enumerate(TESTS):
        amplitude = .004 if test < 3 else .006
        print("%-26s %s" % (name + ", mm/s", " ".join("%7.1f" % (1e3 * w * amplitude * r[test]) for r in j)))
        for what, value, against in read:
            wrench = [0.0] * 6
            for (i, k), x, y in zip(PLACES, value, against):
                if k == test: wrench[i] = (x - y) * w * w * amplitude
            force = step(j, [-x for x in wrench], 0) # the columns of J' are J's rows: six equations for six unknowns
            print("    %-22s %s" % (what + ", N", " ".join("%7.1f" % x for x in force)))
            forces.append((what, test, force))
    if a.svg: draw(a.svg, [(t, f) for what, t, f in forces if what == "Table 5"], [(t, f) for what, t, f in forces if what == "simulated"])


def draw(path, measured, simulated):
    """Draws bars of each test's six leg forces: measured grey, simulated blue."""
    n_per_pixel, width, height, out = 2.2, 112, 170, []
    for rows, colour, shift in ((measured, "#999", 0), (simulated, "#1f6fb2", 6)):
        for test, force in rows:
            for leg, f in enumerate(force):
                out.append('<rect x="%d" y="%.1f" width="6" height="%.1f" fill="%s"/>' % (
                    46 + test * width + leg * 16 + shift, height / 2 - max(f, 0) / n_per_pixel, max(abs(f) / n_per_pixel, .5), colour))
    for test, name in enumerate(TESTS):
        out.append('<text x="%d" y="%d">%s</text>' % (84 + test * width, height + 12, name))
        out.append('<path d="M%d %.1fh100" stroke="#444"/>' % (44 + test * width, height / 2))
    for f in (-150, 0, 150): out.append('<text x="2" y="%.0f">%d N</text>' % (height / 2 - f / n_per_pixel + 4, f))
    with open(path, "w") as file:
        file.write('<svg xmlns="http://www.w3.org/2000/svg" width="%d" height="%d" font-family="sans-serif" font-size="12" fill="#222">\n'
                   '<rect width="100%%" height="100%%" fill="#fff"/>\n%s\n</svg>\n' % (46 + 6 * width, height + 18, "\n".join(out)))


# ---- one machine -----------------------------------------------------------------------------------------------------------------------

def line(name, values): return "%-22s %s" % (name, " ".join("%6.1f" % x for x in values))


def setting(text):
    key, sign, value = text.partition("=")
    if not key or not sign: raise argparse.ArgumentTypeError("%s is no KEY=VALUE" % text)
    return key, value


def machine(settings, cache, seeds):
    """Prints the readings of methods A and B on one machine: with exact sensors, or mean and deviation over seeds of the paper's sensors
    and whole tests."""
    settings, lines = dict(settings), []
    for method in ("method_a", "method_b"):
        name = "simulated, " + method[-1].upper()
        if not seeds:
            value = entries(settings, cache, method)
            if not value: raise SystemExit("table5: the machine does not get through its tests: smaller sizes?")
            lines.append(line(name, value))
            continue
        whole = {"sensors.enabled": "true", "tests.settle_s": 3, "tests.ramp_s": 1, "tests.duration_s": 5, "tests.ramp_out_s": .5}
        runs = list(zip(*(entries(whole | settings, cache, method, seed) for seed in range(1, seeds + 1))))
        lines += [line(name + ", mean", map(statistics.fmean, runs)), line("    deviation", map(statistics.stdev, runs))]
    return lines


def state(a):
    print(" " * 23 + " ".join("%6s" % e for e in ENTRIES))
    for method in ("method_a", "method_b"): print(line("Table 5, " + method[-1].upper(), column("table5_experiment.csv", method)))
    print("\n".join(machine(a.settings, a.cache, a.seeds)))


def check(a):
    """Runs again every machine that the page states (`table5.py state`, exact sensors): the numbers below its command must come out."""
    with open(a.page) as f: lines = f.read().splitlines()
    worst, stated = 0, 0
    for i, said in enumerate(lines):
        command = said.split()
        if command[:2] != ["tests/paper/table5.py", "state"] or "--seeds" in command: continue
        for printed in machine(map(setting, command[2:]), a.cache, 0):
            name, numbers = printed[:22], [float(x) for x in printed[22:].split()]
            block = itertools.takewhile(str.strip, lines[i + 1:])
            below = [x for x in block if x.strip().startswith(name.strip())]
            if len(below) != 1: raise SystemExit("table5: %s: line %d: no line below it begins with: %s" % (a.page, i + 1, name))
            worst = max([worst] + [abs(x - float(y)) for x, y in zip(numbers, below[0].split()[-len(numbers):], strict=True)])
            stated += 1
    print("%s: %d rows, largest difference %.2f" % (a.page, stated, worst))
    if not stated or not worst <= a.within: sys.exit(1)


def search(a):
    s = Search(a.cache, a.floor, a.only, a.noisy)
    print(measured.build() + "\n")
    print("| | " + " | ".join(ENTRIES) + " |\n|" + " --- |" * 11)
    for name, row in (("measured", s.measured), ("hexid, nothing added", s.nominal), ("stated error", s.sigma)):
        print("| %s | %s |" % (name, " | ".join("%.2f" % x for x in row)))
    beam = [s.nothing]
    s.show(beam)
    for _ in range(a.effects):
        beam = s.grown(beam, 16)
        s.show(beam)
        beam = beam[:a.beam]


def laws(a):
    """Combines the two different partners of friction among the best pairs, with each law of friction, and with each part left out."""
    print(measured.build())
    s, named = Search(a.cache, a.floor), {h.name: h for h in HYPOTHESES}
    frictions = [("dry friction", 167), ("load dependent friction", .018), ("Stribeck friction, 20 mm/s", 175),
                 ("Stribeck friction, 60 mm/s", 165), ("Stribeck friction, 5 mm/s", 300)]
    others = [("controller kpf", 4.87e-5), ("mass centre z", .072)]
    without = [[frictions[0], others[0]], [frictions[0], others[1]], others]
    for parts in [[frictions[0]] + others] + without + [[f] + others for f in frictions[1:]]:
        model = Model(s, [(named[name], size) for name, size in parts]).fitted()
        s.show([model])
        print("+-", ", ".join("%.2g" % x for x in model.deviations()), flush=True)


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = p.add_subparsers(dest="command", required=True)
    for function in (search, laws, chance, state, legs, check):
        c = commands.add_parser(function.__name__)
        c.set_defaults(function=function)
        c.add_argument("--cache", default="build/table5", help="directory of the results")
        if function in (search, laws, chance): c.add_argument("--floor", type=float, default=0, help="more error, of sqrt(M_ii M_jj)")
        if function is search: c.add_argument("--effects", type=int, default=2, help="at most so many at once")
        if function is search: c.add_argument("--noisy", type=int, default=20, help="runs with the sensors' noise, for the stated error")
        if function is search: c.add_argument("--only", action="append", metavar="NAME", help="this hypothesis, not all of them; again for more")
        if function is search: c.add_argument("--beam", type=int, default=3, help="so many models are extended")
        if function is chance: c.add_argument("--patterns", type=int, default=40)
        if function is state: c.add_argument("--seeds", type=int, default=0, help="sensors with noise, so many runs; 0: exact sensors")
        if function in (state, legs): c.add_argument("settings", nargs="*", metavar="KEY=VALUE", type=setting)
        if function is legs: c.add_argument("--svg", help="draws them, with settings")
        if function is check: c.add_argument("--within", type=float, default=.2)
        if function is check: c.add_argument("page")
    a = p.parse_args()
    os.makedirs(a.cache, exist_ok=True)
    a.function(a)


if __name__ == "__main__": main()
