"""Draws platforms over two decades of mass and one and a half of size: the paper's machine, scaled so that static pressures and speeds stay
those of a machine, each with its own spread, and with the default gains. Reads the effective configuration of the paper's machine on standard
input (`hexid run --print-config`) and writes DIR/machine_NN.yaml.

    hexid run --print-config -c config/tian2015.yaml | tune_machines.py DIR COUNT
"""
import math, random, re, sys

LENGTHS = """geometry.upper_radius_m geometry.lower_radius_m geometry.height_m payload.center_height_m actuator.stroke_m
    actuator.upper_center_m actuator.lower_center_m motion.park_z_m limits.length_min_m limits.length_max_m limits.following_m
    limits.standstill_m checks.length_wander_m checks.reference_off_m model.tolerance.joints_m""".split()
FORCES = "limits.force_n checks.force_wander_n".split()


def base(lines):
    """Returns the numbers of the configuration by key."""
    values, path = {}, []
    for line in lines:
        found = re.match(r"( *)([a-z0-9_]+): *([^#]*?) *(#.*)?$", line.rstrip())
        if not found: continue
        path[len(found[1]) // 2:] = [found[2]]
        try: values[".".join(path)] = float(found[3])
        except ValueError: pass
    return values


def draw(b, seed):
    """Draws a machine. Relative to the paper's, s is its size, m its payload's mass, p its supply, v its legs' speed and w its oil's
    frequency."""
    r = random.Random(seed)
    log_uniform = lambda least, most: math.exp(r.uniform(math.log(least), math.log(most)))
    s, p = log_uniform(0.15, 3.2), log_uniform(0.7, 2.0)
    m = s ** 3 * log_uniform(0.6, 3.0)
    leg, e, v = s ** 3 * log_uniform(0.5, 1.5), log_uniform(0.6, 1.4), math.sqrt(s) * log_uniform(0.5, 1.5)
    area = m / p * log_uniform(0.8, 1.6)
    w = math.sqrt(e * area / (s * m))
    flow = area * v
    to = {key: b[key] * s for key in LENGTHS}
    to.update({key: b[key] * m for key in FORCES})
    for part, mass, size in (("payload", m, s), ("actuator", leg, s)):
        for key in b:
            if key.startswith(part) and key.endswith("mass_kg"): to[key] = b[key] * mass
            if key.startswith(part) and "inertia" in key: to[key] = b[key] * mass * size ** 2
    to["actuator.piston_diameter_m"] = b["actuator.piston_diameter_m"] * math.sqrt(area)
    to["actuator.rod_diameter_m"] = b["actuator.rod_diameter_m"] * math.sqrt(area) * log_uniform(0.75, 1.1)
    to["hydraulics.supply_pa"] = b["hydraulics.supply_pa"] * p
    to["hydraulics.valve_flow_m3_per_s"] = b["hydraulics.valve_flow_m3_per_s"] * flow / math.sqrt(p)
    to["hydraulics.valve_frequency_hz"] = b["hydraulics.valve_frequency_hz"] * s ** -0.3 * log_uniform(0.6, 1.4)
    to["hydraulics.bulk_modulus_pa"] = b["hydraulics.bulk_modulus_pa"] * e
    to["hydraulics.dead_volume_m3"] = b["hydraulics.dead_volume_m3"] * area * s
    to["hydraulics.leakage_m3_per_s_pa"] = b["hydraulics.leakage_m3_per_s_pa"] * flow / p * log_uniform(0.5, 1.5)
    to["hydraulics.viscous_n_s_per_m"] = b["hydraulics.viscous_n_s_per_m"] * m / v * log_uniform(0.5, 1.5)
    to["hydraulics.stop_stiffness_n_per_m"] = b["hydraulics.stop_stiffness_n_per_m"] * m / s
    to["hydraulics.stop_damping_n_s_per_m"] = b["hydraulics.stop_damping_n_s_per_m"] * m / math.sqrt(s)
    to["sensors.position_resolution_m"] = b["sensors.position_resolution_m"] * min(s, 1.0) * log_uniform(0.1, 1.0)
    to["sensors.pressure_full_scale_pa"] = b["sensors.pressure_full_scale_pa"] * p
    to["limits.pressure_max_pa"] = b["limits.pressure_max_pa"] * p
    to["limits.leg_rate_mps"] = b["limits.leg_rate_mps"] * v
    to["motion.rate_mps"] = b["motion.rate_mps"] * v
    to["motion.engage_s"] = to["motion.park_s"] = round(b["motion.engage_s"] * max(s / v, 0.5), 2)
    to["motion.hold_s"] = round(max(b["motion.hold_s"] / w, 1.0), 2)
    to["tests.frequency_hz"] = hz = round(0.9 * b["tests.frequency_hz"] * w, 2)
    amplitude_m = b["tests.amplitude_m"] * v * b["tests.frequency_hz"] / hz
    to["tests.amplitude_m"] = amplitude_m
    to["tests.amplitude_rad"] = b["tests.amplitude_rad"] / b["tests.amplitude_m"] * amplitude_m / s
    to["tests.duration_s"] = round(max(20.0 / hz, 3.0), 1)
    return s, m, to


def text(values):
    """Returns the YAML of keys with dots."""
    lines, before = [], []
    for key in sorted(values):
        *path, name = key.split(".")
        for depth, section in enumerate(path):
            if path[: depth + 1] != before[: depth + 1]: lines.append("  " * depth + section + ":")
        lines.append("  " * len(path) + f"{name}: {values[key]:.6g}")
        before = path
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    default = base(sys.stdin)
    for seed in range(1, int(sys.argv[2]) + 1):
        s, m, values = draw(default, seed)
        name = f"{sys.argv[1]}/machine_{seed:02}.yaml"
        with open(name, "w") as file:
            file.write(f"# size {s:.3g}, mass {m:.3g} of the paper's machine; seed {seed}\n" + text(values))
        print(name)
