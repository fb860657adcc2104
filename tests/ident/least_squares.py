#!/usr/bin/python3
"""Other authors' methods on the same recordings, to compare hexid's with: inverse dynamics, linear in the payload's ten parameters and in
friction.

    least_squares.py LOG|CSVDIR [-o OUT.json] [--choice NAME=VALUE ...]

- Least squares, as in Gautier, Janot, Vandanjon (IEEE Transactions on Control Systems Technology 21(2), 2013, 428-444): Butterworth filter
  of the lengths forward and backward, central differences, both sides of the equations filtered alike and decimated, ordinary least
  squares, then each leg weighted by the variance of its residuals. Friction of a leg: viscous, Coulomb, and a constant.
- Wavelets, after "A Parameter Identification Method for Stewart Manipulator Based on Wavelet Transform" (Mathematics 2020, 8(2), 257).
  Its abstract says that inertial and viscous parameters follow from a wavelet transform and an analysis of the joints' velocities, whatever
  the Coulomb friction; only the abstract was available. This is a reconstruction from it: between two reversals of a leg its dry friction
  is constant, so wavelet coefficients whose support lies there contain none of it.

For Tian 2015's machine only: its geometry and legs are read from tests/data/, kinematics and dynamics are written here from the formulas,
and nothing is shared with the program. Prints the errors, in %, of the ten entries of Mt that Tian 2015 prints; OUT.json has the whole
matrices. Environment: HEXID, for a LOG. Debian's Python, for its numpy."""
import argparse, csv, json, os, subprocess, sys, tempfile
import numpy as np

DATA = os.path.join(os.path.dirname(__file__), "..", "data")
LEGS, TEN = 6, 10  # m, m c (3), inertia about the origin of {M}: xx yy zz xy xz yz
GRAVITY = np.array([0, 0, 9.80665])
EVALUATED = 3  # PHASE_EVALUATE of include/types.h
ENTRIES = {"mx": (0, 0), "my": (1, 1), "mz": (2, 2), "Ixx": (3, 3), "Iyy": (4, 4), "Izz": (5, 5),
           "Mt15": (0, 4), "Mt24": (1, 3), "Mt42": (3, 1), "Mt51": (4, 0)}
CHOICES = {
    "motion_hz": 40.0,     # cut-off of the lengths' filter: ten times the excitation
    "rows_hz": 20.0,       # cut-off of the filter of both sides
    "order": 4,  # order of the Butterworth filter, which acts twice
    "smooth_mps": 0.0,     # speed s of Coulomb friction tanh(v / s); 0: sign(v)
    "offset": 1,  # a constant force per leg, as Gautier has it; 0: none
    "finest": 5, "coarsest": 5, # levels of the wavelets, of 2^level samples: 64 ms, half a stroke
    "reversal_mps": 0.005, # below this speed a leg may stick
}


def constants():
    values = {}
    for name in ("table1_geometry.csv", "table2_inertia.csv"):
        with open(os.path.join(DATA, name)) as file:
            values |= {row["symbol"]: float(row["value"]) for row in csv.DictReader(file)}
    return argparse.Namespace(**values)


def joints(p):
    """Returns the upper joints in {M} and the lower joints in {B}: [leg, xyz]."""
    third, signs = 2 * np.pi / 3 * np.arange(3), np.array([-1, 1])
    upper = (third[:, None] + signs * p.alpha).ravel()
    lower = (third[:, None] + signs * (np.pi / 3 - p.beta)).ravel()
    ring = lambda radius, angle, z: np.stack([radius * np.cos(angle), radius * np.sin(angle), np.full(LEGS, z)], 1)
    return ring(p.Ra, upper, p.h), ring(p.Rb, lower, p.h + p.H)


def cross(a): return np.stack([np.stack([0 * a[..., 0], -a[..., 2], a[..., 1]], -1), np.stack([a[..., 2], 0 * a[..., 0], -a[..., 0]], -1),
                               np.stack([-a[..., 1], a[..., 0], 0 * a[..., 0]], -1)], -2)


def rotation(angles):
    """Returns Rz(psi) Ry(theta) Rx(phi): [sample, 3, 3]."""
    (c1, c2, c3), (s1, s2, s3) = np.cos(angles.T), np.sin(angles.T)
    return np.stack([np.stack([c3 * c2, c3 * s2 * s1 - s3 * c1, c3 * s2 * c1 + s3 * s1], -1),
                     np.stack([s3 * c2, s3 * s2 * s1 + c3 * c1, s3 * s2 * c1 - c3 * s1], -1),
                     np.stack([-s2, c2 * s1, c2 * c1], -1)], -2)


def angular_rates(angles):
    """Returns the matrix that maps the rates of the angles to omega in {B}."""
    (_, c2, c3), (_, s2, s3), one = np.cos(angles.T), np.sin(angles.T), np.ones(len(angles))
    return np.stack([np.stack([c3 * c2, -s3, 0 * one], -1), np.stack([s3 * c2, c3, 0 * one], -1), np.stack([-s2, 0 * one, one], -1)], -2)


class Legs:
    """Vectors of the legs at poses: arms from the origin of {M}, lengths, directions, Jacobian, all [sample, leg, ...]."""
    def __init__(self, pose, upper, lower):
        self.rotation = rotation(pose[:, 3:])
        self.arm = np.einsum("nij,kj->nki", self.rotation, upper)
        vector = pose[:, None, :3] + self.arm - lower
        self.length = np.linalg.norm(vector, axis=2)
        self.along = vector / self.length[..., None]
        self.jacobian = np.concatenate([self.along, np.cross(self.arm, self.along)], 2)


def forward_kinematics(lengths, upper, lower):
    pose = np.zeros((len(lengths), 6))
    for _ in range(5):
        legs = Legs(pose, upper, lower)
        step = np.linalg.solve(legs.jacobian, (lengths - legs.length)[..., None])[..., 0]
        step[:, 3:] = np.linalg.solve(angular_rates(pose[:, 3:]), step[:, 3:, None])[..., 0]
        pose += step
    if not np.abs(lengths - legs.length).max() < 1e-9: sys.exit("least_squares: no pose has these lengths")
    return pose


def butterworth(signal, cut_hz, order, step_s):
    """Filters forward and backward along axis 0: the gain is squared and the phase zero. Ends are continued by reflection in the end
    point."""
    n = len(signal)
    long = np.concatenate([2 * signal[0] - signal[:0:-1], signal, 2 * signal[-1] - signal[-2::-1]])
    gain = 1 / (1 + (np.fft.rfftfreq(len(long), step_s) / cut_hz) ** (2 * order))
    return np.fft.irfft(np.fft.rfft(long, axis=0) * gain.reshape(-1, *[1] * (signal.ndim - 1)), len(long), axis=0)[n - 1:2 * n - 1]


def differences(signal, step_s):
    rate, second = np.gradient(signal, step_s, axis=0), np.zeros_like(signal)
    second[1:-1] = (signal[2:] - 2 * signal[1:-1] + signal[:-2]) / step_s ** 2
    return rate, second


def leg_wrench(p, legs, velocity, acceleration):
    """Returns the wrench on the platform that moves and holds the legs without friction: [sample, 6]. velocity and acceleration are those
    of the upper joints. The formulas follow from T = ma Ldot^2 / 2 + g(L) Omega^2 / 2 and the weight of both parts."""
    n, length = legs.along, legs.length[..., None]
    dot = lambda a, b: (a * b).sum(-1, keepdims=True)
    rate = dot(n, velocity)
    turn = (velocity - n * rate) / length
    turn_rate = (acceleration - n * dot(n, acceleration) - 2 * rate * turn) / length  # angular acceleration's component across the leg
    inertia, slope = p.ma * (length - p.ra) ** 2 + p.mb * p.rb ** 2 + p.ia + p.ib, 2 * p.ma * (length - p.ra)
    # ma Lddot - g'(L) Omega^2 / 2 along the leg, Lddot = n.a + L Omega^2
    force = n * (p.ma * (dot(n, acceleration) + length * dot(turn, turn)) - slope * dot(turn, turn) / 2)
    force = force + (slope * rate * turn + inertia * turn_rate) / length
    down = GRAVITY - n * (n @ GRAVITY)[..., None]
    force = force - p.ma * n * (n @ GRAVITY)[..., None] - (p.ma * (length - p.ra) + p.mb * p.rb) * down / length
    return np.concatenate([force.sum(1), np.cross(legs.arm, force).sum(1)], 1)


def payload_wrench(legs, acceleration, omega, alpha):
    """Returns the wrench for a unit of each of the ten parameters: [sample, 6, TEN]."""
    columns = np.zeros((len(omega), 6, TEN))
    lift, t = acceleration - GRAVITY, legs.rotation
    columns[:, :3, 0] = lift
    columns[:, :3, 1:4] = (cross(alpha) + cross(omega) @ cross(omega)) @ t
    columns[:, 3:, 1:4] = -cross(lift) @ t
    for c, (i, j) in enumerate([(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)]):
        unit = np.zeros((3, 3))
        unit[i, j] = unit[j, i] = 1
        inertia = t @ unit @ t.transpose(0, 2, 1)
        columns[:, 3:, 4 + c] = (inertia @ alpha[..., None] + cross(omega) @ inertia @ omega[..., None])[..., 0]
    return columns


def friction_columns(rate, choice):
    """Returns the columns of viscous, dry and constant force of each leg: [sample, leg, unknown]."""
    sign = np.tanh(rate / choice["smooth_mps"]) if choice["smooth_mps"] else np.sign(rate)
    parts = [rate] + [sign] + [np.ones_like(rate)] * (choice["offset"] > 0)
    return np.concatenate([part[..., None] * np.eye(LEGS) for part in parts], 2)


def equations(p, test, choice):
    """Returns for one unfiltered test the columns of the unknowns [sample, leg, unknown], the forces that they explain [sample, leg], and
    the rates of the legs."""
    upper, lower = joints(p)
    pose = forward_kinematics(butterworth(test.lengths, choice["motion_hz"], choice["order"], test.step_s), upper, lower)
    legs = Legs(pose, upper, lower)
    rate, second = differences(pose, test.step_s)
    map_, map_rate = angular_rates(pose[:, 3:]), differences(angular_rates(pose[:, 3:]), test.step_s)[0]
    omega = (map_ @ rate[:, 3:, None])[..., 0]
    alpha = (map_ @ second[:, 3:, None] + map_rate @ rate[:, 3:, None])[..., 0]
    spin = np.cross(omega[:, None], legs.arm)
    velocity = rate[:, None, :3] + spin
    acceleration = second[:, None, :3] + np.cross(alpha[:, None], legs.arm) + np.cross(omega[:, None], spin)
    leg_rate = (legs.along * velocity).sum(2)
    area = np.pi / 4 * np.array([p.D ** 2, p.D ** 2 - p.d ** 2])
    own = np.concatenate([payload_wrench(legs, second[:, :3], omega, alpha), leg_wrench(p, legs, velocity, acceleration)[..., None]], 2)
    along = np.linalg.solve(legs.jacobian.transpose(0, 2, 1), own)
    force = area[0] * test.p1 - area[1] * test.p2
    return np.concatenate([along[..., :TEN], friction_columns(leg_rate, choice)], 2), force - along[..., TEN], leg_rate


def decimated(tests, choice):
    """Returns the rows of all tests, given as (test, its equations), in a list by leg: both sides are filtered alike, and decimated over
    the evaluated time."""
    rows = [[] for _ in range(LEGS)]
    for test, (columns, target, _) in tests:
        both = butterworth(np.concatenate([columns, target[..., None]], 2), choice["rows_hz"], choice["order"], test.step_s)
        kept = both[test.evaluated][::max(1, round(0.4 / (choice["rows_hz"] * test.step_s)))]  # 2.5 times the cut-off
        for k in range(LEGS): rows[k].append(kept[:, k])
    return [np.concatenate(r) for r in rows]


def haar(level):
    half = np.ones(2 ** (level - 1))
    return np.concatenate([half, -half]) / np.sqrt(2.0 ** level)


def strokes(rate, slow):
    """Returns the stretches of samples between two reversals."""
    moving = np.concatenate([[0], np.where(np.abs(rate) > slow, np.sign(rate), 0), [0]])
    ends = np.flatnonzero(np.diff(moving))
    return [(a, b) for a, b in zip(ends, ends[1:]) if moving[a + 1]]


def in_wavelets(tests, choice):
    """Returns the rows of all tests in a list by leg: wavelet coefficients whose support lies between two reversals of their leg, where dry
    friction is constant and a wavelet of it is zero."""
    rows = [[] for _ in range(LEGS)]
    filters = [haar(level) for level in range(int(choice["finest"]), int(choice["coarsest"]) + 1)]
    for test, (columns, target, rate) in tests:
        both, rate = np.concatenate([columns[..., :TEN + LEGS], target[..., None]], 2)[test.evaluated], rate[test.evaluated]
        for k in range(LEGS):
            for a, b in strokes(rate[:, k], choice["reversal_mps"]):
                for f in filters:
                    if len(f) > b - a: continue
                    rows[k].append(np.lib.stride_tricks.sliding_window_view(both[a:b, k], len(f), 0)[::max(1, len(f) // 4)] @ f)
    return [np.concatenate(r) if r else np.zeros((0, TEN + LEGS + 1)) for r in rows]


def solve(rows):
    """Solves by ordinary least squares, then with each leg weighted by its residuals."""
    weight = np.ones(LEGS)
    for _ in range(2):
        all_rows = np.concatenate([w * r for w, r in zip(weight, rows)])
        size = np.linalg.norm(all_rows[:, :-1], axis=0)
        x = np.linalg.lstsq(all_rows[:, :-1] / size, all_rows[:, -1], rcond=None)[0] / size
        weight = np.array([1 / max(np.sqrt(np.mean((r[:, :-1] @ x - r[:, -1]) ** 2)), 1e-9) if len(r) else 0 for r in rows])
    return x


def matrix(p, ten):
    """Returns Mt at neutral of the known legs and a payload with these ten parameters, by the accelerations of a platform at rest."""
    upper, lower = joints(p)
    result, still = np.zeros((6, 6)), np.zeros((1, 3))
    legs = Legs(np.zeros((1, 6)), upper, lower)
    def needed(a, alpha):
        acceleration = a[:, None] + np.cross(alpha[:, None], legs.arm)
        return (payload_wrench(legs, a, still, alpha) @ ten)[0] + leg_wrench(p, legs, 0 * acceleration, acceleration)[0]
    for i, unit in enumerate(np.eye(6)): result[:, i] = needed(unit[None, :3], unit[None, 3:]) - needed(still, still)
    return result


def nominal(p):
    inertia = np.array([p.Icxx, p.Icyy, p.Iczz, 0, 0, 0])
    return matrix(p, np.concatenate([[p.m, 0, 0, 0], inertia]))


def read_test(path):
    with open(path) as file:
        lines = [line for line in file if not line.startswith("#")]
    names = lines[0].strip().split(",")
    table = dict(zip(names, np.array([line.split(",") for line in lines[1:]], float).T))
    test, time = argparse.Namespace(), table["t_s"]
    test.step_s = np.median(np.diff(time))
    if np.abs(np.diff(time) - test.step_s).max() > 1e-6: sys.exit("least_squares: %s: rows are missing" % path)
    of_legs = lambda name: np.stack([table[name % (k + 1)] for k in range(LEGS)], 1)
    test.lengths, test.p1, test.p2 = of_legs("l%d_m"), of_legs("p1_%d_pa"), of_legs("p2_%d_pa")
    test.evaluated = table["phase"] == EVALUATED
    return test


def identify(directory, choice):
    p = constants()
    tests = [read_test(os.path.join(directory, name)) for name in sorted(os.listdir(directory)) if name.endswith(".csv")]
    tests = [(test, equations(p, test, choice)) for test in tests]
    found = {"least_squares": solve(decimated(tests, choice)), "wavelet": solve(in_wavelets(tests, choice))}
    value = lambda x: {"Mt": matrix(p, x[:TEN]).tolist(), "payload": x[:TEN].tolist(), "friction": x[TEN:].tolist()}
    return {"nominal": {"Mt": nominal(p).tolist()}} | {name: value(x) for name, x in found.items()}


def exported(log, directory):
    done = subprocess.run([os.environ.get("HEXID", "build/hexid"), "export", log, "-o", directory], capture_output=True, text=True)
    if done.returncode: sys.exit(done.stderr.strip())
    return directory


def chosen(settings):
    """Returns CHOICES with NAME=VALUE of the command line."""
    choice = dict(CHOICES)
    for name, _, value in (x.partition("=") for x in settings):
        if name not in choice: sys.exit("least_squares: no such choice: %s; there are: %s" % (name, ", ".join(choice)))
        choice[name] = float(value)
    return choice


def main():
    a = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    a.add_argument("log")
    a.add_argument("-o", "--output")
    a.add_argument("--choice", action="append", default=[])
    a = a.parse_args()
    with tempfile.TemporaryDirectory() as work:
        result = identify(a.log if os.path.isdir(a.log) else exported(a.log, work + "/csv"), chosen(a.choice))
    truth = np.array(result["nominal"]["Mt"])
    for name, one in list(result.items())[1:]:
        print("%-14s" % name, "  ".join("%s %+.2f" % (e, 100 * (one["Mt"][i][j] / truth[i, j] - 1)) for e, (i, j) in ENTRIES.items()))
    if a.output:
        with open(a.output, "w") as file: json.dump(result, file)


if __name__ == "__main__": main()
