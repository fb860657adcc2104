"""How each source writes its recordings: a reader yields time in s, position in m and force in N of each file. Angles count as metres."""
import csv
import datetime
import json
import math

import numpy as np


def rows(path, wanted, delimiter=',', start=None):
    """Columns by name or number; lines that have no number there are left out."""
    with open(path, encoding='latin1', newline='') as file:
        lines = [line for line in csv.reader(file, delimiter=delimiter) if line and not line[0].startswith('#')]
    if start:
        first = next(i for i, line in enumerate(lines) if start in line)
        names, lines = lines[first], lines[first + 1:]
        wanted = [names.index(w) if isinstance(w, str) else w for w in wanted]
    found = []
    for line in lines:
        try:
            found.append([float(line[w]) for w in wanted])
        except (ValueError, IndexError):
            pass
    return np.array(found).T


def crane(files, _):
    """Jib cylinder 150/100 mm, both pressures in bar at the cylinder; time in ms."""
    for f in files:
        t, x, pa, pb = rows(f, [0, 'JibPistonPosition', 'JibPaCyl', 'JibPbCyl'], start='JibPistonPosition')
        a, b = math.pi / 4 * 0.15**2, math.pi / 4 * (0.15**2 - 0.1**2)
        yield t / 1e3, x, 1e5 * (a * pa - b * pb)


def matlab(files, _):
    import scipy.io
    for f in files:
        data = scipy.io.loadmat(f)
        yield data['Tout'][:, 0], data['dist'][:, 0] / 1e3, data['forc'][:, 0]


def dyke(files, _):
    """Position in cm."""
    for f in files:
        t, x, force = rows(f, [0, 2, 6])
        keep = t < 19
        yield t[keep], x[keep] / 100, force[keep]


def usm(files, _):
    for f in files:
        t, x, _, force = np.loadtxt(f).T
        yield t, x / 1e3, force


def lehigh(files, _):
    """Inch and kip."""
    for f in files:
        t, x, force = np.array(json.loads(f.read_text())['data']).T[:3]
        yield t, 0.0254 * x, 4448.222 * force


def ur10e(files, record):
    """Motor current in A; the joint is the last figure of the record's name. The last 4 s, where the program ends, are left out."""
    joint = int(record['record'][-1])
    for f in files:
        t, x, current = rows(f, [0, joint, 12 + joint])
        t = t - t[0]
        keep = (t > 6) & (t < t[-1] - 4)
        yield t[keep] - t[keep][0], x[keep], current[keep]


def dvrk(files, record):
    """200 Hz; three columns of one joint, or positions, velocities and efforts of seven."""
    for f in files:
        data = np.loadtxt(f, delimiter=',').T
        x, force = (data[0], data[2]) if len(data) == 3 else (data[2], data[16])
        yield np.arange(len(x)) / 200, x, force


def embir(files, _):
    for f in files:
        t, x, force = rows(f, ['time [s]', 'a1 position [rad]', 'a1 torque [Nm]'], start='time [s]')
        yield t - t[0], x, force


def ohlins(files, _):
    """Time of day; mm; a force that pulls while the rod moves out is negative in them, so it is turned."""
    for f in files:
        with open(f, newline='') as file:
            lines = list(csv.reader(file))[1:]
        t = np.array([datetime.datetime.fromisoformat(line[0]).timestamp() for line in lines])
        x, force = np.array([[float(line[4]), -float(line[2])] for line in lines]).T
        yield t - t[0], x / 1e3, force


def buap(files, _):
    """Position and torque in a file each, in degrees and N m."""
    for x, force in zip(files[::2], files[1::2]):
        x, force = np.loadtxt(x).T, np.loadtxt(force).T
        n = min(len(x[0]), len(force[0]))
        yield x[0, :n] - x[0, 0], np.radians(x[1, :n]), force[1, :n]


def lodz(files, _):
    """A load cell at 2 kHz and a servo drive's speed at 1.5 kHz, 4 ms apart as their author has it; 200 N/V and 20 mm a turn."""
    force_file, speed_file = files
    t, volt = rows(force_file, [0, 1])
    ms, rpm = rows(speed_file, [0, 1])
    at = np.arange(0, t[-1] - 0.005, 0.667e-3)
    speed = np.interp(at, ms / 1e3, -rpm * 0.02 / 60)
    yield at, np.cumsum(speed) * 0.667e-3, -200 * (np.interp(at, t + 0.004, volt) - volt[:10].mean())


def hsm(files, _):
    import scipy.io
    for f in files:
        data = scipy.io.loadmat(f)['data'].T
        yield data[0], data[2], data[5]


def dfki(files, _):
    for f in files:
        t, x, force = rows(f, ['time', 'position', 'torque'], start='time')
        keep = t < 4.6
        yield t[keep], x[keep], force[keep]


READ = {name: value for name, value in globals().items() if callable(value) and name not in ('rows',)}
