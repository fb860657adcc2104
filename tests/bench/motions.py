#!/usr/bin/env python3
"""Writes four motions as trajectories for `hexid run --trajectory`: 100 poses a second, from rest at neutral to rest at neutral.

    motions.py DIR          take_off.csv, road.csv, earthquake.csv, circle.csv

No control law was designed or tuned with any of them. x points forward, y to the right, z down; theta > 0 is nose up, phi > 0 lowers the
right side. Random phases have a fixed seed."""
import cmath, math, os, random, sys

GRAVITY = 9.80665            # m/s^2
STEP_S = 0.01
LOWEST_HZ, HIGHEST_HZ = 0.3, 10.0     # band of the random motions; the highest is half of the lowest oil column's frequency
AXES = "x_m y_m z_m phi_rad theta_rad psi_rad".split()


def times(duration_s): return [i * STEP_S for i in range(round(duration_s / STEP_S) + 1)]


def smooth(t, start_s, duration_s):
    """Goes from 0 to 1, with rate and acceleration zero at both ends."""
    q = min(max((t - start_s) / duration_s, 0.0), 1.0)
    return q ** 3 * (10.0 - 15.0 * q + 6.0 * q * q)


def rise_and_fall(t, rise_s, start_of_fall_s, fall_s):
    return smooth(t, 0.0, rise_s) - smooth(t, start_of_fall_s, fall_s)


def low_pass(signal, omega):
    """A low-pass of first order with gain 1, omega in rad/s."""
    out, y = [], 0.0
    for u in signal:
        out.append(y)
        y += (1.0 - math.exp(-omega * STEP_S)) * (u - y)
    return out


def high_pass(signal, omega): return [u - y for u, y in zip(signal, low_pass(signal, omega))]


# ---- a take-off, as a classical washout filter moves the platform ----

def flight(t):
    """A transport aircraft: thrust to 2.5 m/s^2 within 2 s; rotation at 29 s and 67 m/s to 15 degrees, at most 3.1 degrees/s; lift-off 4 s
    later into a climb at 9 degrees. Returns the accelerations along the path and upward, m/s^2, and the pitch angle, rad."""
    along = 2.5 * smooth(t, 1.0, 2.0) - 1.7 * smooth(t, 33.0, 10.0)
    turn_radps = math.radians(9.0) * (smooth(t + 1e-3, 33.0, 10.0) - smooth(t - 1e-3, 33.0, 10.0)) / 2e-3
    return along, 80.0 * turn_radps, math.radians(15.0) * smooth(t, 29.0, 9.0)


def displacement(accelerations, omega):
    """Integrates twice with a washout of third order: 1 / (s + omega)^2 s / (s + 0.2 rad/s) of the acceleration."""
    return [x / omega ** 2 for x in high_pass(low_pass(low_pass(accelerations, omega), omega), 0.2)]


def take_off():
    """The structure is Reid and Nahon's classical algorithm (UTIAS Report 296, 1985); gains and frequencies are ours, for this stroke:
    half of each cue, washouts of 1.5 rad/s for x and 1.8 for z, tilt by a critically damped low-pass of 1 rad/s, washout of pitch by
    0.5 rad/s. From 50 s on the platform goes back to neutral."""
    time = times(58.0)
    along, upward, pitch = zip(*map(flight, time))
    x, z = displacement([0.5 * a for a in along], 1.5), displacement([-0.5 * a for a in upward], 1.8)
    forces = [0.5 * (a / GRAVITY + math.sin(p)) for a, p in zip(along, pitch)]
    tilt, turn = low_pass(low_pass(forces, 1.0), 1.0), high_pass([0.5 * p for p in pitch], 0.5)
    keep = [1.0 - smooth(t, 50.0, 8.0) for t in time]
    return [(t, k * x, 0.0, k * z, 0.0, k * (a + b), 0.0) for t, k, x, z, a, b in zip(time, keep, x, z, tilt, turn)]


# ---- random motions, as sums of sines ----

def lines(duration_s):
    """Frequencies of the band that repeat after the duration."""
    return [i / duration_s for i in range(math.ceil(LOWEST_HZ * duration_s), math.floor(HIGHEST_HZ * duration_s) + 1)]


def phases(generator, count): return [cmath.exp(2j * math.pi * generator.random()) for _ in range(count)]


def wave(frequencies, amplitudes, t):
    return sum((a * cmath.exp(2j * math.pi * f * t)).real for f, a in zip(frequencies, amplitudes))


def road():
    """A road of ISO 8608, class C (geometric mean: 256e-6 m^3 at 0.1 cycles/m, falling with the square), at 20 m/s. The body stands on a
    wheelbase of 2.7 m and a track of 1.5 m; the coherence of both tracks is exp(-2 n track) at n cycles/m (ours). Springs and dampers
    give heave, pitch and roll 1.3 Hz and a damping ratio of 0.3."""
    duration_s, speed_mps, wheelbase_m, track_m = 24.0, 20.0, 2.7, 1.5
    frequencies, generator = lines(duration_s), random.Random(8608)
    heave, pitch, roll = [], [], []
    for f, common, other in zip(frequencies, *(phases(generator, len(frequencies)) for _ in range(2))):
        n, natural_hz = f / speed_mps, 1.3
        size_m = math.sqrt(2.0 * 256e-6 * (n / 0.1) ** -2 / (speed_mps * duration_s))
        coherence = math.exp(-2.0 * n * track_m)
        left, right = size_m * common, size_m * (coherence * common + math.sqrt(1.0 - coherence ** 2) * other)
        rear = cmath.exp(-2j * math.pi * n * wheelbase_m)
        damper = 2j * 0.3 * f / natural_hz
        body = (1.0 + damper) / (1.0 - (f / natural_hz) ** 2 + damper)
        heave.append(-body * (left + right) * (1.0 + rear) / 4.0)
        pitch.append(body * (left + right) * (1.0 - rear) / (2.0 * wheelbase_m))
        roll.append(body * (left - right) * (1.0 + rear) / (2.0 * track_m))
    rows = []
    for t in times(duration_s):
        part = rise_and_fall(t, 2.0, duration_s - 2.0, 2.0)
        rows.append((t, 0.0, 0.0, part * wave(frequencies, heave, t), part * wave(frequencies, roll, t), part * wave(frequencies, pitch, t),
                     0.0))
    return rows


def ground(f):
    """One-sided spectrum of the ground's acceleration, without its scale: Clough and Penzien's, firm soil of Der Kiureghian and Neuenhofer
    (1992): 15 rad/s, 0.6; 1.5 rad/s, 0.6."""
    q, slow = (2.0 * math.pi * f / 15.0) ** 2, (2.0 * math.pi * f / 1.5) ** 2
    kanai_tajimi = (1.0 + 1.44 * q) / ((1.0 - q) ** 2 + 1.44 * q)
    return kanai_tajimi * slow ** 2 / ((1.0 - slow) ** 2 + 1.44 * slow)


def largest_acceleration(xs):
    return max(abs(a - 2.0 * b + c) for a, b, c in zip(xs, xs[1:], xs[2:])) / STEP_S ** 2


def shaking(time, duration_s, generator, peak_mps2):
    frequencies = lines(duration_s)
    amplitudes = [math.sqrt(ground(f)) / (2.0 * math.pi * f) ** 2 * p for f, p in zip(frequencies, phases(generator, len(frequencies)))]
    xs = [rise_and_fall(t, 3.0, 13.0, duration_s - 13.0) * wave(frequencies, amplitudes, t) for t in time]
    scale = peak_mps2 / largest_acceleration(xs)
    return [scale * x for x in xs]


def earthquake():
    """Independent motions along x, y and z with a peak acceleration of 3.5, 3.5 and 2.3 m/s^2, from 0.3 to 10 Hz. Their displacement rises
    for 3 s, stays for 10 s and falls for 11 s."""
    duration_s, generator = 24.0, random.Random(1940)
    time = times(duration_s)
    x, y, z = (shaking(time, duration_s, generator, peak) for peak in (3.5, 3.5, 2.3))
    return [(t, x, y, z, 0.0, 0.0, 0.0) for t, x, y, z in zip(time, x, y, z)]


# ---- a circle ----

def circle():
    """Spirals out within 6 s to the largest circle in the plane of neutral that the strokes allow, goes round twice, and back; a turn
    takes 6 s."""
    radius_m, turn_s = 0.68, 6.0
    rows = []
    for t in times(24.0):
        r, angle = radius_m * rise_and_fall(t, 6.0, 18.0, 6.0), 2.0 * math.pi * t / turn_s
        rows.append((t, r * math.cos(angle), r * math.sin(angle), 0.0, 0.0, 0.0, 0.0))
    return rows


def write(directory, name, rows):
    with open(os.path.join(directory, name + ".csv"), "w") as file:
        file.write(",".join(["t_s"] + AXES) + "\n")
        file.writelines("%.2f,%s\n" % (row[0], ",".join("%.8f" % v for v in row[1:])) for row in rows)


def main():
    if len(sys.argv) != 2: raise SystemExit("usage: motions.py DIR")
    os.makedirs(sys.argv[1], exist_ok=True)
    for name, motion in ("take_off", take_off), ("road", road), ("earthquake", earthquake), ("circle", circle):
        write(sys.argv[1], name, motion())


if __name__ == "__main__": main()
