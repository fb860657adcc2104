#!/usr/bin/env python3
"""Recordings of real axes by other people, through hexid import and hexid gap, beside what their authors found in them.

    docs/recordings/compare.py emps DIRECTORY [OUTPUT]     DATA_EMPS.mat and DATA_EMPS_PULSES.mat (needs scipy)
    docs/recordings/compare.py seals DIRECTORY [OUTPUT]    results_pneumatic-actuator/data/friction of the repository
    docs/recordings/compare.py deflection DIRECTORY        the same; least squares of Dahl's friction, without hexid (needs numpy)

Sources and licences: README.md beside this file. HEXID names the program, build/hexid if it is not set.
"""
import json
import math
import os
import subprocess
import sys
from pathlib import Path

HEXID = os.environ.get('HEXID', 'build/hexid')
AXIS = """mechanism: axis
axis: {{mass_kg: {mass}, gravity_mps2: 0, middle_m: {middle}, force_offset_n: 0}}
actuator: {{stroke_m: {stroke}}}
hydraulics: {{viscous_n_s_per_m: 1}}
sensors: {{position_resolution_m: {resolution}}}
tests: {{order: [x], settle_s: 0, ramp_s: 0, ramp_out_s: 0}}
loop: {{period_s: {period}}}
"""


def hexid(*arguments):
    run = subprocess.run([HEXID, *map(str, arguments)], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    if run.returncode:
        sys.exit(run.stderr)


def recording(place, axis, rows):
    """A directory as hexid import reads it, and the log of it."""
    (place / 'csv').mkdir(parents=True, exist_ok=True)
    (place / 'axis.yaml').write_text(AXIS.format(**axis))
    with open(place / 'csv/1.csv', 'w') as file:
        file.write('# mechanism: axis\n# dof: none\nt_s,position_m,force_n\n')
        file.writelines(f'{t:.4f},{position:.8f},{force:.6f}\n' for t, position, force in rows)
    hexid('import', place / 'csv', '-c', place / 'axis.yaml', '-o', place / 'axis.lcm')
    return place / 'axis.lcm'


def gap(place, *logs):
    hexid('gap', '--measured', logs[0], *(['--validate', logs[1]] if logs[1:] else []), '-c', place / 'axis.yaml', '--replay', 'motion',
          '-o', place / 'gap')
    return json.loads((place / 'gap/gap.json').read_text())


def shares(sizes):
    names = {'before': 'held_out_before', 'after': 'held_out_after', 'noise': 'noise_floor'}
    return ', '.join(f'{name} {100 * sizes[key]["force"]["normalised"]:.1f} %' for name, key in names.items())


def verdict_of(result):
    return ' and '.join(e['name'] for e in result['effects']) or result['verdict']


def emps(source, output):
    """Janot, Gautier, Brunot 2019. Their own scripts on the same files: symmetric friction (printed in their description) and asymmetric."""
    import scipy.io

    theirs = {'axis.mass_kg': (95.11, 95.15), 'force_extend_n': (20.39, 20.14), 'force_retract_n': (20.39, 20.72),
              'extend_n_s_per_m': (203.5, 166.7), 'retract_n_s_per_m': (203.5, 239.6)}
    axis = dict(mass=95, middle=0.12, stroke=0.3, resolution=5e-8, period=0.001)
    logs = []
    for name in ('DATA_EMPS', 'DATA_EMPS_PULSES'):
        data = scipy.io.loadmat(source / f'{name}.mat')
        columns = data['t'][:, 0], data['qm'][:, 0], data['gtau'][0, 0] * data['vir'][:, 0]
        logs.append(recording(output / name, axis, zip(*columns)))
    own, other = gap(output / 'DATA_EMPS', logs[0]), gap(output / 'DATA_EMPS_PULSES', logs[0], logs[1])
    print(f'named: {verdict_of(own)}; {own["seconds"]:.1f} s\n')
    print('| value | hexid | theirs, symmetric | theirs, asymmetric |\n| --- | --- | --- | --- |')
    found = {k: (v['value'], v['std']) for k, v in own['base'].items()}
    for effect in own['effects']:
        found.update({k: (v, effect['std'][k]) for k, v in effect['parameters'].items()})
    for name, (symmetric, asymmetric) in theirs.items():
        if name in found:
            print(f'| `{name}` | {found[name][0]:.4g} +- {found[name][1]:.2g} | {symmetric} | {asymmetric} |')
    print(f'\nforce left, rms over its variation, held out: {shares(own["gap"])}; with pulses: {shares(other["gap"])}')


def seal_recordings(source):
    """Ring, bar, and rows of time, position and friction, as she calculates it."""
    for ring in ('O-ring', 'NAPN', 'NAP310', 'PK', 'KDN', 'O-ring257', 'X-ring257'):
        diameter = 25.7e-3 if ring.endswith('257') else 25e-3
        for bar in (1, 3, 5, 7):
            text = (source / f'{ring}_{bar}bar.csv').read_text()
            table = [[float(word) for word in line.split()] for line in text.splitlines()[15:]]  # as she does
            yield ring, bar, [(row[0] / 1e3, row[4] / 1e3, row[6] - row[5] * 1e5 * math.pi / 4 * diameter**2) for row in table]


def in_order(rows):
    return [row for row, before in zip(rows[1:], rows) if row[0] > before[0]]


def seals(source, output):
    """Zillen 2021: the range of the friction force, from the mean of the strokes one way to that of the other way (her equations 2 and 3)."""
    print('| seal | bar | hexid names | cannot be told from | range, N | hers, N |\n| --- | --- | --- | --- | --- | --- |')
    for ring, bar, rows in seal_recordings(source):
        place = output / f'{ring}_{bar}bar'
        result = gap(place, recording(place, dict(mass=0.2, middle=0.02, stroke=0.1, resolution=1e-6, period=0.01), in_order(rows)))
        names = ' + '.join(e['name'] for e in result['effects']) or result['verdict']
        forces = [v for e in result['effects'] for k, v in e['parameters'].items() if k in ('force_extend_n', 'force_retract_n')]
        size = f'{sum(forces):.2f}' if forces else '-'
        friction = [row[2] for row in rows]
        mean = sum(friction) / len(friction)
        over, under = [f for f in friction if f > mean], [f for f in friction if f < mean]
        hers = f'{sum(over) / len(over) - sum(under) / len(under):.2f}'
        print('|', ' | '.join([ring, str(bar), names, ', '.join(result['ambiguous_with']), size, hers]), '|', flush=True)


def deflection(source, _):
    """What dry friction leaves, and what it leaves when it builds up over a distance; beside a constant and viscous friction."""
    import numpy as np

    def rest(force, *columns):
        basis = np.array(columns).T
        return (force - basis @ np.linalg.lstsq(basis, force, rcond=None)[0]).std()

    print('| seal | bar | dry friction leaves, N | over a distance, N | distance, mm |\n| --- | --- | --- | --- | --- |')
    for ring, bar, rows in seal_recordings(source):
        t, x, force = np.array(in_order(rows)).T
        window = np.hanning(11)[1:-1] / np.hanning(11).sum()
        x = np.convolve(np.pad(x, 4, 'edge'), window, 'valid')
        v, steps = np.gradient(x, t), np.diff(x, prepend=x[0])
        best = (math.inf, 0)
        for distance in np.geomspace(2e-5, 3e-3, 16):
            z, course = 0.0, []
            for dx in steps:
                z = math.copysign(1, dx) + (z - math.copysign(1, dx)) * math.exp(-abs(dx) / distance) if dx else z
                course.append(z)
            best = min(best, (rest(force, np.ones(len(x)), v, course), distance))
        dry = rest(force, np.ones(len(x)), v, np.tanh(v / 2e-4))
        print(f'| {ring} | {bar} | {dry:.2f} | {best[0]:.2f} ({100 * (best[0] / dry - 1):.0f} %) | {1e3 * best[1]:.2f} |', flush=True)


if __name__ == '__main__':
    if len(sys.argv) < 3 or sys.argv[1] not in ('emps', 'seals', 'deflection'):
        sys.exit(__doc__)
    {'emps': emps, 'seals': seals, 'deflection': deflection}[sys.argv[1]](Path(sys.argv[2]), Path(sys.argv[3] if sys.argv[3:] else f'build/recordings/{sys.argv[1]}'))
