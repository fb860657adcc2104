#!/usr/bin/env python3
"""The platform by a second engine: MuJoCo's 13 bodies on prescribed motions, with chambers, friction and sensors, as CSV for `hexid import`.

    mujoco_machine.py -o DIR [-c FILE] [--tolerance SEED] [--noise SEED] [--effect NAME.KEY=V[,V2..V6] ...]
    mujoco_machine.py --inertia-matrix [-c FILE] [--tolerance SEED] [--effect ...]

Options and files are those of the rig (tests/rig/README.md), which shares no code with this; of its effects only those in EFFECTS.

- Bodies: an open tree of the platform (three slides, Rz Ry Rx) and of each leg a cylinder on a universal joint and a rod that slides in it.
  The legs' coordinates follow from the pose. K, the rates of all joints by those of the platform, is from MuJoCo's Jacobians; with the forces
  tau of its inverse dynamics the legs push with f = J'^-1 K' tau, where the rows of J are those of K for the slides. The matrix at neutral
  is K' M K, M being MuJoCo's.
- Motion: the six sines of the configuration with their ramps, and in all coordinates a wander of some micrometres, as a controller leaves it.
- Chambers: continuity of both, with the one valve opening that gives the force A1 P1 - A2 P2 = f + friction; their common pressure follows
  from valve, leakage and oil. Dry friction is tanh(v / 2 mm/s). Of a pipe, inertia and resistance of its oil act; orifices see chambers.
- Tolerance, uniform: payload, upper and lower masses 1 %, legs alike; viscous friction, bulk modulus, leakage of each leg 5 %.

Environment: HEXID (for the configuration's numbers)."""
import argparse, json, math, os, random, sys

import mujoco
import numpy as np
from scipy.interpolate import CubicSpline

sys.dont_write_bytecode = True # leaves no files in the tree

from real_sensors import configured

AXES = "x y z phi theta psi".split()
PLATFORM = [0, 1, 2, 5, 4, 3] # place of x y z phi theta psi among the platform's joints: x y z psi theta phi
PERIOD_S, FINE = .002, 4      # period of the samples; steps of the chambers in each
SLIDES_AT = 2e-3              # m/s: dry friction is tanh of the speed over this
WANDER = .0015                # rms of the wander, as a share of the amplitude
OIL_KG_M3, OIL_M2_S = 870, 4e-5
EFFECTS = {
    "cylinder_coulomb_friction.force_extend_n": 0, "cylinder_coulomb_friction.force_retract_n": 0,
    "geometry_error.a_x_m": 0, "geometry_error.a_y_m": 0, "geometry_error.a_z_m": 0,
    "geometry_error.b_x_m": 0, "geometry_error.b_y_m": 0, "geometry_error.b_z_m": 0,
    "pressure_sensor_scale.p1": 1, "pressure_sensor_scale.p2": 1, "pressure_sensor_offset.p1": 0, "pressure_sensor_offset.p2": 0,
    "pressure_sensor_lag.cutoff_hz": 0, "pressure_sensor_delay.delay_s": 0, "position_sensor_delay.delay_s": 0,
    "position_sensor_scale.scale": 1, "position_sensor_offset.offset_m": 0,
    "pipeline_dynamics.length_m": 0, "pipeline_dynamics.diameter_m": .012,
}


def six(value): return np.array(value if isinstance(value, list) else [value] * 6, float)


def circle(radius, angles): return np.array([[radius * math.cos(x), radius * math.sin(x), 0] for x in angles])


def joints(config, effects):
    """Returns the upper joints in {M} and the lower ones in {B}: docs/method.md, section 1."""
    third, alpha, beta = math.pi / 3, config["geometry.upper_half_angle_rad"], config["geometry.lower_half_angle_rad"]
    a = np.array(config["geometry.upper_joints_m"] or circle(config["geometry.upper_radius_m"], [
        2 * third * (i // 2) + (alpha if i % 2 else -alpha) for i in range(6)]), float)
    b = np.array(config["geometry.lower_joints_m"] or circle(config["geometry.lower_radius_m"], [
        2 * third * ((i + 1) // 2) - third + beta if i % 2 == 0 else 2 * third * ((i + 1) // 2) - third - beta for i in range(6)]), float)
    center = np.array([config["payload.center_x_m"], config["payload.center_y_m"], -config["payload.center_height_m"]])
    off = [np.stack([effects["geometry_error.%s_%s_m" % (end, axis)] for axis in "xyz"], 1) for end in "ab"]
    return a - center + off[0], b + [0, 0, config["geometry.height_m"]] - center + off[1]


def rotation(pose):
    """Returns Rz Ry Rx of poses, one a row."""
    (cx, cy, cz), (sx, sy, sz) = np.cos(pose[:, 3:].T), np.sin(pose[:, 3:].T)
    return np.moveaxis(np.array([[cz * cy, cz * sy * sx - sz * cx, cz * sy * cx + sz * sx],
                                 [sz * cy, sz * sy * sx + cz * cx, sz * sy * cx - cz * sx], [-sy, cy * sx, cy * cx]]), 2, 0)


def frame(axis):
    """Returns the frame with z along the leg and x level."""
    z = axis / np.linalg.norm(axis)
    x = np.cross([0, 0, 1], z)
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(z, x), z], 1)


class Bodies:
    def __init__(self, config, effects, draw):
        self.a, self.b = joints(config, effects)
        self.frames = [frame(a - b) for a, b in zip(self.a, self.b)]
        self.neutral_m = np.linalg.norm(self.a - self.b, axis=1)
        self.model = mujoco.MjModel.from_xml_string(self.xml(config, draw))
        self.data = mujoco.MjData(self.model)

    def xml(self, config, draw):
        def line(values): return " ".join("%.17g" % x for x in values)

        def body(kg, centre, inertia): return '<inertial pos="%s" mass="%.17g" fullinertia="%s"/>' % (line(centre), kg, line(inertia))

        def about(axes): return config["payload.inertia_%s_kg_m2" % axes] * draw["payload"]
        part = {key: six(config["actuator." + key]) for key in (
            "upper_mass_kg", "lower_mass_kg", "upper_inertia_kg_m2", "lower_inertia_kg_m2", "upper_center_m", "lower_center_m")}
        own = 1e-9 # kg m^2 about a leg's axis: MuJoCo takes no zero
        text = '<mujoco><compiler angle="radian"/><option gravity="0 0 %.17g"/><worldbody><body name="platform">' % config["payload.gravity_mps2"]
        text += "".join('<joint type="slide" axis="%s"/>' % axis for axis in ("1 0 0", "0 1 0", "0 0 1"))
        text += "".join('<joint type="hinge" axis="%s"/>' % axis for axis in ("0 0 1", "0 1 0", "1 0 0"))
        text += body(config["payload.mass_kg"] * draw["payload"], [0, 0, 0], map(about, ("xx", "yy", "zz", "xy", "xz", "yz"))) + "</body>"
        for i in range(6):
            quat = np.empty(4)
            mujoco.mju_mat2Quat(quat, self.frames[i].ravel())
            upper, lower = draw["upper"], draw["lower"]
            text += '<body pos="%s" quat="%s"><joint axis="1 0 0"/><joint axis="0 1 0"/>' % (line(self.b[i]), line(quat))
            text += body(part["lower_mass_kg"][i] * lower, [0, 0, part["lower_center_m"][i]],
                         [part["lower_inertia_kg_m2"][i] * lower] * 2 + [own, 0, 0, 0])
            text += '<body name="rod%d" pos="0 0 %.17g"><joint type="slide" axis="0 0 1"/>' % (i, self.neutral_m[i])
            text += body(part["upper_mass_kg"][i] * upper, [0, 0, -part["upper_center_m"][i]],
                         [part["upper_inertia_kg_m2"][i] * upper] * 2 + [own, 0, 0, 0]) + "</body></body>"
        return text + "</worldbody></mujoco>"

    def coordinates(self, pose):
        """Returns all 24 coordinates of poses, one a row: the platform's, then two angles and the slide of each leg."""
        q = np.empty((len(pose), 24))
        q[:, PLATFORM] = pose
        T = rotation(pose)
        for i in range(6):
            x = (pose[:, :3] + T @ self.a[i] - self.b[i]) @ self.frames[i]
            r = np.linalg.norm(x, axis=1)
            q[:, 6 + 3 * i] = np.arctan2(-x[:, 1], x[:, 2])
            q[:, 7 + 3 * i] = np.arcsin(x[:, 0] / r)
            q[:, 8 + 3 * i] = r - self.neutral_m[i]
        return q

    def closure(self):
        """Returns K at MuJoCo's present position."""
        K, platform = np.eye(24, 6), self.model.body("platform").id
        end, joint = np.zeros((3, 24)), np.zeros((3, 24))
        T, c = self.data.xmat[platform].reshape(3, 3), self.data.xpos[platform]
        for i in range(6):
            rod, leg = self.model.body("rod%d" % i).id, slice(6 + 3 * i, 9 + 3 * i)
            mujoco.mj_jac(self.model, self.data, end, None, self.data.xpos[rod], rod)
            mujoco.mj_jac(self.model, self.data, joint, None, c + T @ self.a[i], platform)
            K[leg] = np.linalg.solve(end[:, leg], joint[:, :6])
        return K

    def forces(self, q, v, a):
        """Returns the forces of the legs along their axes, at one instant; positive pushes."""
        self.data.qpos[:], self.data.qvel[:], self.data.qacc[:] = q, v, a
        mujoco.mj_inverse(self.model, self.data)
        K = self.closure()
        return np.linalg.solve(K[8::3].T, K.T @ self.data.qfrc_inverse)

    def matrix(self):
        self.data.qpos[:] = 0
        mujoco.mj_forward(self.model, self.data)
        M = np.zeros((24, 24))
        mujoco.mj_fullM(self.model, M, self.data.qM)
        K = self.closure()
        return (K.T @ M @ K)[np.ix_(PLATFORM, PLATFORM)]


def smooth(q):
    q = np.clip(q, 0, 1)
    return q * q * (3 - 2 * q)


class Test:
    """One sine of an axis, and the wander of all coordinates."""
    def __init__(self, config, axis, r):
        def of(key, place):
            value = config["tests." + key]
            return value[place] if isinstance(value, list) else value
        self.axis, self.hz = axis, of("frequency_hz", axis)
        self.amplitude = of("amplitude_m" if axis < 3 else "amplitude_rad", axis % 3)
        self.ramp_s, self.duration_s, self.ramp_out_s = (config["tests." + key] for key in ("ramp_s", "duration_s", "ramp_out_s"))
        self.t = np.arange(round((self.ramp_s + self.duration_s + self.ramp_out_s) / PERIOD_S)) * PERIOD_S
        lines = np.array([[[r.uniform(.1, 5) * self.hz, r.uniform(0, 2 * math.pi)] for _ in range(12)] for _ in range(6)])
        self.w, self.phase = 2 * math.pi * lines[:, :, 0], lines[:, :, 1]
        self.wander_rms = WANDER * np.array([of("amplitude_m" if k < 3 else "amplitude_rad", k % 3) for k in range(6)])

    def reference(self, t):
        pose = np.zeros((len(t), 6))
        pose[:, self.axis] = self.amplitude * np.sin(2 * math.pi * self.hz * t) * smooth(t / self.ramp_s) * (
            1 - smooth((t - self.ramp_s - self.duration_s) / self.ramp_out_s))
        return pose

    def pose(self, t):
        lines = np.sin(self.w[:, :, None] * t + self.phase[:, :, None]).sum(1).T
        return self.reference(t) + self.wander_rms / math.sqrt(self.w.shape[1] / 2) * lines


def motion(bodies, test, t, h=1e-3):
    """Returns coordinates, rates and accelerations by differences of fourth order."""
    q = [bodies.coordinates(test.pose(t + k * h)) for k in (-2, -1, 0, 1, 2)]
    rate = (q[0] - 8 * q[1] + 8 * q[3] - q[4]) / (12 * h)
    return q[2], rate, (-q[0] + 16 * q[1] - 30 * q[2] + 16 * q[3] - q[4]) / (12 * h * h)


class Chambers:
    """Chambers of six legs; arrays are [test, leg]."""
    def __init__(self, config, draw, neutral_m):
        def of(key): return six(config["hydraulics." + key])
        piston, rod = six(config["actuator.piston_diameter_m"]), six(config["actuator.rod_diameter_m"])
        self.a1, self.a2 = math.pi / 4 * piston**2, math.pi / 4 * (piston**2 - rod**2)
        self.supply, self.tank = config["hydraulics.supply_pa"], config["hydraulics.tank_pa"]
        self.gain = of("valve_flow_m3_per_s") / math.sqrt(config["hydraulics.valve_drop_pa"])
        self.bulk, self.leakage = of("bulk_modulus_pa") * draw["bulk"], of("leakage_m3_per_s_pa") * draw["leakage"]
        self.dead1, self.dead2 = of("dead_volume_m3"), of("dead_volume_m3") + of("dead_volume_difference_m3")
        self.half, self.middle = six(config["actuator.stroke_m"]) / 2, six(config["actuator.mid_stroke_m"])

    def start(self, f):
        """Returns P2 at rest: the leakage into the rodless side leaves by the valve, so both orifices have the same drop."""
        p2 = (self.a1 * (self.supply + self.tank) - f) / (self.a1 + self.a2)
        if np.any(p2 < self.supply + self.tank - p2): raise SystemExit("mujoco_machine.py: a leg that pulls at rest is not provided for")
        return p2

    def flows(self, p2, f, f_rate, slide, rate):
        p1 = (f + self.a2 * p2) / self.a1
        v1 = self.dead1 + self.a1 * (self.half + slide - self.middle)
        v2 = self.dead2 + self.a2 * (self.half - slide + self.middle)
        c1, c2, leak = self.bulk / v1, self.bulk / v2, self.leakage * (p2 - p1)
        need = f_rate + self.a1 * c1 * (self.a1 * rate - leak) + self.a2 * c2 * (self.a2 * rate - leak)
        into = np.where(need > 0, self.supply - p1, p1 - self.tank)
        out = np.where(need > 0, p2 - self.tank, self.supply - p2)
        if np.any(into < 2e4) or np.any(out < 2e4): raise SystemExit("mujoco_machine.py: the supply does not suffice")
        root1, root2 = np.sqrt(into), np.sqrt(out)
        opening = need / (self.a1 * c1 * root1 + self.a2 * c2 * root2) # times the gain
        return p1, opening * root1, -opening * root2, c2 * (-opening * root2 + self.a2 * rate - leak)

    def pressures(self, t, f, slide):
        """Returns P1, P2 and the flows into both chambers on the grid t, from splines of force and slide."""
        f_rate, rate, h, p2 = f.derivative(), slide.derivative(), t[1] - t[0], self.start(f(t[0]))
        given = [[x(at) for x in (f, f_rate, slide, rate)] for at in (t, t + h / 2)]
        out = np.empty((4, len(t), *p2.shape))
        for k in range(len(t)):
            p1, q1, q2, k1 = self.flows(p2, *(x[k] for x in given[0]))
            out[:, k] = p1, p2, q1, q2
            if k + 1 == len(t): break
            middle = [x[k] for x in given[1]]
            k2 = self.flows(p2 + h / 2 * k1, *middle)[3]
            k3 = self.flows(p2 + h / 2 * k2, *middle)[3]
            k4 = self.flows(p2 + h * k3, *(x[k + 1] for x in given[0]))[3]
            p2 = p2 + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        return out


def piped(p, q, rate, length, diameter):
    """Returns the pressure at the valve's end of a pipe, one a leg."""
    section = math.pi / 4 * diameter**2
    return p + length * (OIL_KG_M3 / section * rate + 128 * OIL_KG_M3 * OIL_M2_S / (math.pi * diameter**4) * q)


def lagged(p, h, cutoff_hz):
    """Returns the pressure with a lag of first order, exact for pressures that are straight between the samples."""
    if not np.any(cutoff_hz > 0): return p
    x = 2 * math.pi * np.where(cutoff_hz > 0, cutoff_hz, 1) * h
    y, out, decay = p[0].copy(), np.empty_like(p), np.exp(-x)
    out[0] = y
    for k in range(1, len(p)):
        ramp = (p[k] - p[k - 1]) / x
        y = p[k] - ramp + (y - p[k - 1] + ramp) * decay
        out[k] = y
    return np.where(cutoff_hz > 0, out, p)


def delayed(spline, t, delay_s): return np.stack([spline(t - delay_s[i])[..., i] for i in range(6)], -1)


def measured(config, effects, spline, t, side, noise):
    p = delayed(spline, t, effects["pressure_sensor_delay.delay_s"])
    p = p * effects["pressure_sensor_scale.p%d" % side] + effects["pressure_sensor_offset.p%d" % side]
    if not config["sensors.enabled"]: return p
    full, half = config["sensors.adc_range_v"], config["sensors.pressure_noise_v"] / 2
    steps, volt = 2 ** (config["sensors.adc_bits"] - 1), config["sensors.pressure_full_scale_pa"] / full
    level = np.round((p / volt + noise.uniform(-half, half, p.shape)) / full * steps)
    return np.clip(level, -steps, steps - 1) / steps * full * volt


def record(config, effects, draw, bodies, seed, directory):
    tests = [Test(config, axis, random.Random("%d %d" % (seed, axis))) for axis in range(6)]
    t = tests[0].t
    moved = [motion(bodies, test, t) for test in tests]
    force = np.array([[bodies.forces(*instant) for instant in zip(*m)] for m in moved])
    fine = np.arange(FINE * len(t) - FINE + 1) * PERIOD_S / FINE
    chambers = Chambers(config, draw, bodies.neutral_m)

    # Friction reverses within a millisecond, so it is computed on the fine grid, on which the bodies' forces are smooth.
    slide = CubicSpline(t, np.moveaxis(np.array([m[0][:, 8::3] for m in moved]), 0, 1))
    rate = slide(fine, 1)
    dry = np.where(rate > 0, effects["cylinder_coulomb_friction.force_extend_n"], effects["cylinder_coulomb_friction.force_retract_n"])
    rubbed = six(config["hydraulics.viscous_n_s_per_m"]) * draw["viscous"] * rate + dry * np.tanh(rate / SLIDES_AT)
    oil = CubicSpline(fine, CubicSpline(t, np.moveaxis(force, 0, 1))(fine) + rubbed)

    p1, p2, q1, q2 = chambers.pressures(fine, oil, slide)
    read = []
    for p, q in ((p1, q1), (p2, q2)):
        p = piped(p, q, np.gradient(q, fine, axis=0), effects["pipeline_dynamics.length_m"], effects["pipeline_dynamics.diameter_m"])
        read.append(CubicSpline(fine, lagged(p, fine[1], effects["pressure_sensor_lag.cutoff_hz"])))
    noise, step = np.random.default_rng(seed), config["sensors.position_resolution_m"] if config["sensors.enabled"] else 0
    pressures = [measured(config, effects, spline, t, side, noise) for side, spline in zip((1, 2), read)]
    drawing = np.linalg.norm(np.subtract(*joints(config, {key: np.zeros(6) for key in EFFECTS})), axis=1)
    length = delayed(slide, t, effects["position_sensor_delay.delay_s"]) + bodies.neutral_m
    length = drawing + (length - drawing) * effects["position_sensor_scale.scale"] + effects["position_sensor_offset.offset_m"]
    if step: length = step * np.round(length / step)
    os.makedirs(directory, exist_ok=True)
    for k, test in enumerate(tests):
        write("%s/%d.csv" % (directory, k), test, np.hstack([t[:, None], test.reference(t), length[:, k], pressures[0][:, k], pressures[1][:, k]]))


def write(file, test, table):
    names = ["t_s"] + ["ref_%s_%s" % (axis, "m" if k < 3 else "rad") for k, axis in enumerate(AXES)]
    names += [name % i for name in ("l%d_m", "p1_%d_pa", "p2_%d_pa") for i in range(1, 7)]
    head = "# dof: %s\n# frequency_hz: %g\n# amplitude: %g\n# rate_hz: %g\n# ramp_s: %g\n# duration_s: %g\n# ramp_out_s: %g\n%s" % (
        AXES[test.axis], test.hz, test.amplitude, 1 / PERIOD_S, test.ramp_s, test.duration_s, test.ramp_out_s, ",".join(names))
    np.savetxt(file, table, "%.9g", ",", header=head, comments="")


def drawn(config, seed):
    if seed is None: return {key: 1 for key in ("payload", "upper", "lower", "viscous", "bulk", "leakage")}
    r = random.Random("tolerance %d" % seed)

    def about(key): return 1 + r.uniform(-1, 1) * config["model.tolerance." + key]
    draw = {key: about("mass") for key in ("payload", "upper", "lower")}
    return draw | {key: np.array([about(of) for _ in range(6)]) for key, of in
                   (("viscous", "viscous"), ("bulk", "bulk_modulus"), ("leakage", "leakage"))}


def hidden(assignments):
    effects = {key: np.full(6, float(value)) for key, value in EFFECTS.items()}
    for assignment in assignments:
        key, _, values = assignment.partition("=")
        if key not in EFFECTS: raise SystemExit("mujoco_machine.py: %s: not one of its effects" % key)
        effects[key][:] = [float(x) for x in values.split(",")]
    return effects


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("-o", metavar="DIR")
    p.add_argument("-c", metavar="FILE")
    p.add_argument("--tolerance", type=int)
    p.add_argument("--noise", type=int, default=1)
    p.add_argument("--effect", action="append", default=[])
    p.add_argument("--inertia-matrix", action="store_true")
    a = p.parse_args()
    config = configured(a.c)
    effects, draw = hidden(a.effect), drawn(config, a.tolerance)
    bodies = Bodies(config, effects, draw)
    if a.inertia_matrix: print(json.dumps(bodies.matrix().tolist()))
    elif a.o: record(config, effects, draw, bodies, a.noise, a.o)
    else: p.error("-o DIR or --inertia-matrix")


if __name__ == "__main__": main()
