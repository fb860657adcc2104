"""Hypotheses that may explain Tian 2015's readings on the real machine: one size each, the same in all legs (table5.py)."""
import math


class Hypothesis:
    """A hypothesis sets each key to value(size), with size from low to high; `neutral` changes nothing."""

    def __init__(self, name, unit, neutral, low, high, keys, value=lambda s: s):
        self.name, self.unit, self.neutral, self.low, self.high = name, unit, neutral, low, high
        self.keys, self.value = keys.split(), value

    def settings(self, size):
        v = self.value(size)
        return {k: v[k] if isinstance(v, dict) else "%.9g" % v for k in self.keys}

    def sizes(self):
        """Returns four sizes on each side of neutral."""
        return [self.neutral + f * (end - self.neutral) for end in (self.low, self.high) if end != self.neutral for f in (.1, .25, .5, 1)]


def effect(name, key, unit, neutral, low, high, label=None, value=lambda s: s):
    keys = " ".join("effects.%s.%s" % (name, k) for k in key.split())
    return Hypothesis(label or name.replace("_", " "), unit, neutral, low, high, keys, value)


def radius(which, angles):
    """Returns a function that moves all joints of the platform (a) or of the base (b) outwards by `size`."""
    keys = ["effects.geometry_error.%s_%s_m" % (which, axis) for axis in "xy"]
    return lambda size: dict(zip(keys, ("[%s]" % ",".join("%.9g" % (size * f(x)) for x in angles) for f in (math.cos, math.sin))))


THIRD, ALPHA, BETA = 2 * math.pi / 3, .2343, .1886
UPPER = [k * THIRD + s * ALPHA for k in range(3) for s in (-1, 1)]
LOWER = [x for k in range(3) for x in ((2 * k - 1) * math.pi / 3 + BETA, (2 * k + 1) * math.pi / 3 - BETA)]

STRIBECK = "effects.cylinder_stribeck_friction.excess_n effects.cylinder_stribeck_friction.velocity_mps"

HYPOTHESES = [
    effect("cylinder_coulomb_friction", "force_extend_n force_retract_n", "N", 0, 0, 600, "dry friction"),
    effect("cylinder_coulomb_friction", "force_extend_n", "N", 0, 0, 900, "dry friction, extending only"),
    effect("cylinder_coulomb_friction", "force_retract_n", "N", 0, 0, 900, "dry friction, retracting only"),
    *(Hypothesis("Stribeck friction, %g mm/s" % v, "N", 0, 0, 900, STRIBECK, lambda s, v=v: dict(zip(STRIBECK.split(), (s, v / 1e3))))
      for v in (5, 20, 60)),
    Hypothesis("viscous friction", "N s/m", 2000, 0, 10000, "hydraulics.viscous_n_s_per_m"),
    effect("load_dependent_friction", "mu", "-", 0, 0, .08),
    effect("passive_joint_friction", "coulomb_nm", "N m", 0, 0, 120, "dry friction of the joints"),
    effect("passive_joint_friction", "viscous_nm_s", "N m s", 0, 0, 400, "viscous friction of the joints"),
    effect("joint_backlash", "clearance_m", "m", 0, 0, 1e-3),
    effect("payload_mass", "mass_kg", "kg", 0, -60, 60),
    effect("payload_center_of_mass", "x_m", "m", 0, -.1, .1, "mass centre x"),
    effect("payload_center_of_mass", "y_m", "m", 0, -.1, .1, "mass centre y"),
    effect("payload_center_of_mass", "z_m", "m", 0, -.2, .2, "mass centre z"),
    effect("payload_rotational_inertia", "xx yy", "kg m^2", 0, -12, 12, "payload inertia xx, yy"),
    effect("payload_rotational_inertia", "xx", "kg m^2", 0, -12, 12, "payload inertia xx"),
    effect("payload_rotational_inertia", "yy", "kg m^2", 0, -12, 12, "payload inertia yy"),
    effect("payload_rotational_inertia", "zz", "kg m^2", 0, -15, 15, "payload inertia zz"),
    effect("actuator_inertia", "upper_mass_kg", "kg", 0, -12, 12, "actuator, upper mass"),
    effect("actuator_inertia", "lower_mass_kg", "kg", 0, -40, 40, "actuator, lower mass"),
    effect("actuator_inertia", "transverse_kg_m2", "kg m^2", 0, -2, 12, "actuator, transverse inertia"),
    *(effect("external_stiffness", k, "N/m", 0, 0, 4e4, "stiffness " + k) for k in "xyz"),
    *(effect("external_stiffness", k, "N m/rad", 0, 0, 8e3, "stiffness " + k) for k in ("phi", "theta", "psi")),
    # Shifting all joints of the base alike changes nothing; shifting all of the platform equals shifting the mass centre the other way.
    effect("geometry_error", "a_x_m a_y_m", "m", 0, -.05, .05, "radius of the upper joints", radius("a", UPPER)),
    effect("geometry_error", "b_x_m b_y_m", "m", 0, -.1, .1, "radius of the lower joints", radius("b", LOWER)),
    effect("base_tilt", "phi_rad", "rad", 0, -.1, .1, "base tilt phi"),
    effect("base_tilt", "theta_rad", "rad", 0, -.1, .1, "base tilt theta"),
    effect("clock_skew", "ratio", "-", 1, .97, 1.03),
    effect("command_delay", "delay_s", "s", 0, 0, .004),
    effect("entrained_air", "bulk_modulus_pa", "1/GPa", 1, 1, 8, "oil's compliance", lambda s: 1e9 / s),
    effect("internal_leakage", "scale", "-", 1, 0, 4),
    effect("pipeline_dynamics", "length_m", "m", 0, 0, 4),
    effect("port_area_ratio", "ratio", "-", 1, .49, 2),
    effect("position_sensor_delay", "delay_s", "s", 0, 0, .004),
    effect("position_sensor_offset", "offset_m", "m", 0, -.03, .03),
    effect("position_sensor_scale", "scale", "-", 1, .9, 1.1),
    effect("pressure_sensor_lag", "cutoff_hz", "ms", 0, 0, 4, None, lambda s: min(1e5, 1e3 / (2 * math.pi * max(s, 1e-9)))),
    effect("pressure_sensor_offset", "p1", "Pa", 0, -4e5, 4e5, "pressure sensor offset, p1"),
    effect("pressure_sensor_offset", "p2", "Pa", 0, -4e5, 4e5, "pressure sensor offset, p2"),
    effect("pressure_sensor_scale", "p1 p2", "-", 1, .9, 1.1),
    effect("pressure_sensor_scale", "p1", "-", 1, .9, 1.1, "pressure sensor scale, p1"),
    effect("pressure_sensor_scale", "p2", "-", 1, .9, 1.1, "pressure sensor scale, p2"),
    effect("supply_pressure_sag", "resistance_pa_s_per_m3", "Pa s/m^3", 0, 0, 4e9),
    effect("tank_back_pressure", "resistance_pa_s_per_m3", "Pa s/m^3", 0, 0, 4e9),
    effect("valve_dead_band", "overlap", "-", 0, 0, .04),
    effect("valve_hysteresis", "width", "-", 0, 0, .03),
    effect("valve_lag", "frequency_hz", "ms", 5 / math.pi, 5 / math.pi, 8, None, lambda s: 1e3 / (2 * math.pi * s)),
    effect("valve_rate_limit", "per_s", "s", 0, 0, .5, "valve rate limit", lambda s: min(1e4, 1 / max(s, 1e-9))),
    effect("valve_flow_gain", "scale", "-", 1, .5, 2),
    effect("valve_null_bias", "offset", "-", 0, -.05, .05),
    # Controller and test values that the paper does not print; the defaults are hexid's.
    Hypothesis("controller kp", "1/m", 40, 15, 120, "control.kp"),
    Hypothesis("controller kff", "s/m", 2, .8, 3, "control.kff"),
    Hypothesis("controller kpf", "1/N", 2e-5, 0, 1e-4, "control.kpf"),
    Hypothesis("smoothness of dry friction", "m/s", 0, 0, .01, "sim.smooth_friction_mps"),
    Hypothesis("amplitude of the tests", "-", 1, .5, 1.5, "tests.amplitude_m tests.amplitude_rad",
               lambda s: {"tests.amplitude_m": .004 * s, "tests.amplitude_rad": .006 * s}),
    Hypothesis("base on springs", "1/Hz", 0, 0, .1, "sim.base_hz sim.engine",
               lambda s: {"sim.base_hz": 1 / s if s else 0, "sim.engine": "ode"}),
]
