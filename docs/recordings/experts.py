"""Least squares by hand: the laws that a plot of force over speed and over position shows, in a stated band, and what they leave.

Position and force go through the same low-pass filter (a window of Gauss, zero phase), so mass and friction are compared in one band.
Laws are fitted to every other piece of the record (of 23) and judged on the others. Intervals are two standard deviations over
the pieces, each left out once (jackknife).
"""
import numpy as np

DISTANCES = np.geomspace(1e-5, 3e-1, 46)
PIECES = 23  # a prime: pieces that are half cycles would all be of one direction
TWO = ('dry_each_way', 'viscous_each_way', 'lever')


def low_pass(t, y, hz):
    dt = np.median(np.diff(t))
    sigma = np.sqrt(np.log(2)) / (2 * np.pi * hz) / dt
    k = np.arange(-int(4 * sigma) - 1, int(4 * sigma) + 2)
    window = np.exp(-0.5 * (k / sigma)**2)
    return np.convolve(np.pad(y, len(k) // 2, 'edge'), window / window.sum(), 'valid')


def even(t, x, force):
    """Rows on an even grid: stamps of a PC are not, and derivatives want it."""
    t, first = np.unique(t, return_index=True)
    at = np.arange(t[0], t[-1], np.median(np.diff(t)))
    return at, np.interp(at, t, x[first]), np.interp(at, t, force[first])


def dahl(x, distance):
    z, course = 0.0, np.empty(len(x))
    for i, dx in enumerate(np.diff(x, prepend=x[0])):
        z = np.sign(dx) + (z - np.sign(dx)) * np.exp(-abs(dx) / distance) if dx else z
        course[i] = z
    return course


def sign(v, still):
    return np.tanh(v / still)


# Each law: columns of t, x, v, a, and the record's slowest speed that counts as motion.
LAWS = {
    'mass': lambda x, v, a, s: [a],
    'dry': lambda x, v, a, s: [sign(v, s)],
    'dry_each_way': lambda x, v, a, s: [np.maximum(sign(v, s), 0), np.minimum(sign(v, s), 0)],
    'viscous': lambda x, v, a, s: [v],
    'viscous_each_way': lambda x, v, a, s: [np.maximum(v, 0), np.minimum(v, 0)],
    'spring': lambda x, v, a, s: [x],
    'parabola': lambda x, v, a, s: [x**2],
    'lever': lambda x, v, a, s: [np.sin(x), np.cos(x)],
}


def columns(series, laws, distance):
    t, x, v, a, _, raw = series
    still = 0.02 * np.percentile(np.abs(v), 95)
    found = [np.ones(len(t))]
    for law in laws:
        found += [dahl(raw, distance)] if law == 'presliding' else LAWS[law](x - np.mean(x) if law in ('spring', 'parabola') else x, v, a, still)
    return np.array(found).T


def series_of(piece, hz):
    t, x, force = even(*piece)
    smooth = low_pass(t, x, hz)
    v = np.gradient(smooth, t)
    return t, smooth, v, np.gradient(v, t), low_pass(t, force, hz), low_pass(t, x, 4 * hz)


def fit(basis, force):
    return np.linalg.lstsq(basis, force, rcond=None)[0]


def moving(series):
    """Rows within 0.3 s of motion: a rest tells of friction only that it is not exceeded."""
    t, speed = series[0], np.abs(series[2])
    reach = max(1, int(0.3 / np.median(np.diff(t))))
    fast = (speed > 0.05 * np.percentile(speed, 95)).astype(float)
    return np.convolve(fast, np.ones(2 * reach + 1))[reach:reach + len(fast)] > 0


def at_speed(laws, value, speed):
    """Friction at a speed, mean of both ways, from the coefficients behind the constant."""
    total, i = 0.0, 1
    for law in laws:
        width = 2 if law in TWO else 1
        share = np.mean(value[i:i + width])
        total += share if law in ('dry', 'dry_each_way', 'presliding') else share * speed if law.startswith('viscous') else 0.0
        i += width
    return total


def expert(pieces, laws, hz, mass):
    every = [series_of(p, hz) for p in pieces]
    keep = np.concatenate([moving(s) for s in every])
    speed = np.percentile(np.abs(np.concatenate([s[2] for s in every])[keep]), 95)
    best = None
    for distance in DISTANCES if 'presliding' in laws else [0.0]:
        basis = np.vstack([columns(s, laws, distance) for s in every])[keep]
        force = np.concatenate([s[4] - mass * s[3] for s in every])[keep]
        block = np.arange(len(force)) * PIECES // len(force)
        odd = block % 2 == 1
        left = [force[odd] - basis[odd] @ fit(basis[~odd], force[~odd]), force[~odd] - basis[~odd] @ fit(basis[odd], force[odd])]
        rms = np.sqrt(np.mean(np.concatenate(left)**2))
        if best is None or rms < best[0]:
            best = rms, distance, basis, force, block
    rms, distance, basis, force, block = best
    jack = np.array([fit(basis[block != b], force[block != b]) for b in range(PIECES)])
    value = fit(basis, force)

    def two_deviations(each):
        return 2 * np.sqrt(np.sum((each - each.mean(0))**2, 0) * (PIECES - 1) / PIECES)

    names = ['constant'] + [name for law in laws for name in ([law + '+', law + '-'] if law in TWO else [law])]
    result = {n: rounded(v, d) for n, v, d in zip(names, value, two_deviations(jack))}
    if distance:
        result['presliding_m'] = float(f'{distance:.2g}')
    frictions = np.array([at_speed(laws, j, speed) for j in jack])
    return {'values': result, 'speed_mps': float(f'{speed:.3g}'), 'friction_n': rounded(at_speed(laws, value, speed), two_deviations(frictions)),
            'varies_n': float(f'{np.std(force):.4g}'), 'left_n': float(f'{rms:.3g}'), 'explained': round(1 - rms**2 / np.var(force), 4)}


def rounded(value, interval):
    return [float(f'{value:.4g}'), float(f'{interval:.2g}')]


def laws_of(effects):
    """Force over a series and friction at a speed, each with the effects' values: those of hexid, in the expert's band."""
    def both(p, unit):
        return np.array([p.get(f'{way}_{unit}', p.get(f'force_{way}_{unit}', 0.0)) for way in ('extend', 'retract')])

    def force(series, mass, middle):
        _, x, v, a, _, raw = series
        still = 0.02 * np.percentile(np.abs(v), 95)
        out = mass * a
        for e in effects:
            p = e['parameters']
            if e['name'] == 'payload_mass':
                out = out + p['mass_kg'] * a
            elif e['name'] == 'external_stiffness':
                out = out + p['x'] * x
            elif e['name'] == 'lever_load':
                y, w = x - middle, np.sqrt(complex(p['turn_per_m2'] or 1e-9))
                out = out + np.real(p['slope_n_per_m'] * np.sin(w * y) / w + p['bend_n_per_m2'] * (1 - np.cos(w * y)) / w**2)
            elif e['name'] == 'cylinder_coulomb_friction':
                f = both(p, 'n')
                out = out + np.where(v > 0, f[0], f[1]) * sign(v, still)
            elif e['name'] == 'cylinder_viscous_friction':
                b = both(p, 'n_s_per_m')
                out = out + np.where(v > 0, b[0], b[1]) * v
            elif e['name'] == 'cylinder_dahl_friction':
                z, f = dahl(raw, p['distance_m']), both(p, 'n')
                out = out + np.where(z > 0, f[0], f[1]) * z
            elif e['name'] == 'cylinder_stribeck_friction':
                out = out + p['excess_n'] * np.exp(-(v / p['velocity_mps'])**2) * sign(v, still)
            else:
                return None
        return out

    def friction(speed):
        value, square = 0.0, 0.0
        for e in effects:
            if not e['name'].startswith('cylinder_'):
                continue
            p, d = e['parameters'], e['std']
            factor, unit = (speed, 'n_s_per_m') if 'viscous' in e['name'] else (1.0, 'n')
            if 'stribeck' in e['name']:
                factor = np.exp(-(speed / p['velocity_mps'])**2)
                value, square = value + factor * p['excess_n'], square + (factor * (d['excess_n'] or 0))**2
            else:
                value, square = value + factor * both(p, unit).mean(), square + (factor * np.mean([x or 0 for x in both(d, unit)]))**2
        return rounded(value, 2 * np.sqrt(square))

    return force, friction


def middle_of(pieces):
    return (min(x.min() for _, x, _ in pieces) + max(x.max() for _, x, _ in pieces)) / 2


def left_by(pieces, hz, effects, mass):
    """rms in N that a model leaves in the expert's band, a constant for each piece taken out."""
    square, count, middle = 0.0, 0, middle_of(pieces)
    for p in pieces:
        series = series_of(p, hz)
        model = laws_of(effects)[0](series, mass, middle)
        if model is None:
            return None
        rest = (series[4] - model)[moving(series)]
        square, count = square + np.sum((rest - rest.mean())**2), count + len(rest)
    return np.sqrt(square / count)
