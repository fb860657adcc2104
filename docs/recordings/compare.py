#!/usr/bin/env python3
"""Recordings of real axes by other people, through hexid import and hexid gap, beside what their authors found in them.

    docs/recordings/compare.py emps DIRECTORY [OUTPUT]     DATA_EMPS.mat and DATA_EMPS_PULSES.mat (needs scipy)
    docs/recordings/compare.py seals DIRECTORY [OUTPUT]    results_pneumatic-actuator/data/friction of the repository

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


def seals(source, output):
    """Zillen 2021: the range of the friction force, from the mean of the strokes one way to that of the other way (her equations 2 and 3)."""
    print('| seal | bar | hexid names | cannot be told from | range, N | hers, N |\n| --- | --- | --- | --- | --- | --- |')
    for ring in ('O-ring', 'NAPN', 'NAP310', 'PK', 'KDN', 'O-ring257', 'X-ring257'):
        diameter = 25.7e-3 if ring.endswith('257') else 25e-3
        for bar in (1, 3, 5, 7):
            text = (source / f'{ring}_{bar}bar.csv').read_text()
            table = [[float(word) for word in line.split()] for line in text.splitlines()[15:]]  # as she does
            friction = [row[6] - row[5] * 1e5 * math.pi / 4 * diameter**2 for row in table]
            rows = [(row[0] / 1e3, row[4] / 1e3, force) for row, force in zip(table, friction)]
            rows = [row for row, before in zip(rows[1:], rows) if row[0] > before[0]]
            place = output / f'{ring}_{bar}bar'
            result = gap(place, recording(place, dict(mass=0.2, middle=0.02, stroke=0.1, resolution=1e-6, period=0.01), rows))
            names = ' + '.join(e['name'] for e in result['effects']) or result['verdict']
            forces = [v for e in result['effects'] for k, v in e['parameters'].items() if k in ('force_extend_n', 'force_retract_n')]
            size = f'{sum(forces):.2f}' if forces else '-'
            mean = sum(friction) / len(friction)
            over, under = [f for f in friction if f > mean], [f for f in friction if f < mean]
            hers = f'{sum(over) / len(over) - sum(under) / len(under):.2f}'
            print('|', ' | '.join([ring, str(bar), names, ', '.join(result['ambiguous_with']), size, hers]), '|', flush=True)


if __name__ == '__main__':
    if len(sys.argv) < 3 or sys.argv[1] not in ('emps', 'seals'):
        sys.exit(__doc__)
    {'emps': emps, 'seals': seals}[sys.argv[1]](Path(sys.argv[2]), Path(sys.argv[3] if sys.argv[3:] else f'build/recordings/{sys.argv[1]}'))
