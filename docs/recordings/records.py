#!/usr/bin/env python3
"""Recordings of thirteen sources: what an expert finds in them by least squares, and what hexid gap does, beside it.

    docs/recordings/records.py sums CHECKOUTS              checksum of each file that sources.tsv names; a missing one is said
    docs/recordings/records.py expect CHECKOUTS            the expert's fits, as expected.json: commit it before `gap` is run
    docs/recordings/records.py gap CHECKOUTS [RECORD...]   hexid gap on each, and the table

CHECKOUTS has one checkout of each repository, named OWNER+NAME. Needs numpy and scipy. HEXID names the program, build/hexid if it is
not set. What is made of the data is written below build/recordings.
"""
import hashlib
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np

from experts import expert, laws_of, left_by, middle_of
from formats import READ

HEXID = os.environ.get('HEXID', 'build/hexid')
HERE = Path(__file__).parent
OUT = Path(os.environ.get('OUT', 'build/recordings/records'))


def table(name):
    lines = [line.split('\t') for line in (HERE / name).read_text().splitlines() if line and not line.startswith('#')]
    return [dict(zip(lines[0], line)) for line in lines[1:]]


def source_file(checkouts, source):
    path = checkouts / source['repository'].replace('/', '+') / source['path']
    if not path.exists():
        print(f'missing: {path} (commit {source["commit"]} of github.com/{source["repository"]})', file=sys.stderr)
    elif hashlib.sha256(path.read_bytes()).hexdigest() != source['sha256']:
        print(f'another file than that of sources.tsv: {path}', file=sys.stderr)
    return path


def load(checkouts, record):
    """Time in s from 0 on an even grid, position in m and force in N, of each file of a record."""
    files = [source_file(checkouts, s) for s in table('sources.tsv') if s['record'] == record['record']]
    if not all(f.exists() for f in files):
        return None
    return [tuple(np.asarray(c, float) for c in columns) for columns in READ[record['format']](files, record)]


def sums(checkouts):
    for s in table('sources.tsv'):
        path = checkouts / s['repository'].replace('/', '+') / s['path']
        print(s['record'], hashlib.sha256(path.read_bytes()).hexdigest() if path.exists() else 'missing', s['path'], sep='\t')


def expect(checkouts):
    found = {}
    for record in table('records.tsv'):
        pieces = load(checkouts, record)
        if pieces:
            found[record['record']] = expert(pieces, record['laws'].split(), float(record['band_hz']), float(record['mass']))
            print(record['record'], json.dumps(found[record['record']]), file=sys.stderr)
    (HERE / 'expected.json').write_text(json.dumps(found, indent=1) + '\n')


AXIS = """mechanism: axis
axis: {{mass_kg: {mass}, gravity_mps2: 0, middle_m: {middle}, force_offset_n: 0}}
actuator: {{stroke_m: {stroke}}}
hydraulics: {{viscous_n_s_per_m: 0}}
sensors: {{position_resolution_m: {resolution}}}
tests: {{order: [x], settle_s: 0, ramp_s: 0, ramp_out_s: 0}}
loop: {{period_s: {period}}}
"""


def at_lever(record, pieces):
    """A rotation as the motion of a point on a lever, in m and N, of a stroke that a configuration may have."""
    lever = float(record['lever'])
    return float(record['mass']) / lever**2, [(t, lever * x, force / lever) for t, x, force in pieces]


def back(record, result):
    """The effects' values as those of the rotation."""
    lever = float(record['lever'])
    power = {'n': 1, 'x': 2, 'n_per_m': 2, 'n_per_m2': 3, 'turn_per_m2': 2, 'kg': 2, 'n_s_per_m': 2, 'm': -1, 'mps': -1}
    for e in result['effects']:
        for part in (e['parameters'], e['std']):
            for key, value in part.items():
                for unit, exponent in power.items():
                    if value and (key == unit or key.endswith('_' + unit)) and not (unit == 'm' and key.endswith('per_m')):
                        part[key] = value * lever**exponent
    base = result.get('base') or {}
    if 'axis.mass_kg' in base:
        base['axis.mass_kg']['value'] *= lever**2
    return result


def written(place, record, pieces):
    """A directory of CSV files as hexid import reads it, and the model that knows a mass and no friction."""
    mass, pieces = at_lever(record, pieces)
    (place / 'csv').mkdir(parents=True, exist_ok=True)
    low, high = min(p[1].min() for p in pieces), max(p[1].max() for p in pieces)
    period = float(np.median(np.diff(pieces[0][0])))
    (place / 'axis.yaml').write_text(AXIS.format(mass=f'{mass:.9g}', middle=middle_of(pieces), stroke=1.2 * (high - low),
                                                 resolution=float(record['lever']) * float(record['resolution']), period=f'{period:.6f}'))
    for number, (t, x, force) in enumerate(pieces, 1):
        with open(place / f'csv/{number}.csv', 'w') as file:
            file.write('# mechanism: axis\n# dof: none\nt_s,position_m,force_n\n')
            file.writelines(f'{a:.6f},{b:.9g},{c:.9g}\n' for a, b, c in zip(t - t[0], x, force))


def hexid(*arguments):
    return subprocess.run([HEXID, *map(str, arguments)], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)


def asked(place):
    """gap.json, or the words with which it was refused."""
    log, config = place / 'axis.lcm', place / 'axis.yaml'
    run = hexid('import', place / 'csv', '-c', config, '-o', log)
    if not run.returncode:
        run = hexid('gap', '--measured', log, '-c', config, '--replay', 'motion', '-o', place / 'gap')
    if run.returncode:
        return {'verdict': 'refused', 'reason': ' '.join(run.stderr.split())[-300:], 'effects': []}
    return json.loads((place / 'gap/gap.json').read_text())


FAMILY = {'payload_mass': 'bodies', 'actuator_inertia': 'bodies', 'external_stiffness': 'load', 'lever_load': 'load'}


def family(name):
    return FAMILY.get(name, 'friction' if 'friction' in name else name)


def score(record, result, expected, friction):
    """agree: each family expected is named; wrong: another is; silent: else."""
    if result['verdict'] not in ('effect_named', 'partly_named', 'ambiguous'):
        return 'agree' if record['expects'] == 'nothing' else 'silent'
    named = {family(e['name']) for e in result['effects']} | ({'friction'} if 'friction' in (result.get('family') or '') else set())
    if named - set(record['expects'].split()) - set(record['allows'].split()):
        return 'wrong'
    if 'friction' in record['expects'] and 'friction' not in named:
        return 'silent'
    away = abs(friction[0] - expected['friction_n'][0]) if result['effects'] else 0
    return 'agree' if away <= max(0.1 * expected['friction_n'][0], friction[1] + expected['friction_n'][1]) else 'wrong size'


def line(record, result, expected, pieces):
    friction = laws_of(result['effects'])[1](expected['speed_mps'])
    mass = float(record['mass']) if 'axis.mass_kg' not in (result.get('base') or {}) else result['base']['axis.mass_kg']['value']
    left = left_by(pieces, float(record['band_hz']), result['effects'], mass) if result['effects'] else None
    sizes = (result.get('gap') or {}).get('held_out_before'), (result.get('gap') or {}).get('held_out_after')
    share = '-'
    if result['effects'] and sizes[0]:
        share = f"{100 * (1 - (sizes[1]['force']['rms'] / sizes[0]['force']['rms'])**2):.1f} %"
    names = ' + '.join(e['name'].removeprefix('cylinder_') for e in result['effects']) or result.get('family') or '-'
    return [record['record'], record['expects'], f"{expected['friction_n'][0]:.4g} +- {expected['friction_n'][1]:.2g}", result['verdict'], names,
            f'{friction[0]:.4g} +- {friction[1]:.2g}' if result['effects'] else '-', f"{100 * expected['explained']:.1f} %", share,
            f"{left / expected['left_n']:.2f}" if left else '-', score(record, result, expected, friction)]


def gap(checkouts, names):
    expected = json.loads((HERE / 'expected.json').read_text())
    print('| record | expected | friction, N | verdict | named | friction, N | explained by the expert | by hexid, held out | left, to the expert\'s '
          '| |\n| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |')
    for record in table('records.tsv'):
        if names and record['record'] not in names:
            continue
        pieces = load(checkouts, record)
        if pieces:
            place = OUT / record['record']
            written(place, record, pieces)
            result = back(record, asked(place))
            print('|', ' | '.join(line(record, result, expected[record['record']], pieces)), '|', flush=True)
            print(record['record'], result['reason'], file=sys.stderr)


def main(command, checkouts, *names):
    if command == 'sums':
        sums(checkouts)
    elif command == 'expect':
        expect(checkouts)
    else:
        gap(checkouts, names)


if __name__ == '__main__':
    if len(sys.argv) < 3 or sys.argv[1] not in ('sums', 'expect', 'gap'):
        sys.exit(__doc__)
    main(sys.argv[1], Path(sys.argv[2]), *sys.argv[3:])
