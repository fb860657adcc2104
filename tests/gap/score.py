#!/usr/bin/env python3
"""Hidden cases for `hexid gap`: a rig with hidden effects, the workflow on its log, the score.

    score.py cases [--seeds N] [--series tolerance|beyond] [--kinds single,none,two,unknown,nearly] [--effects A,B]   one case a line
    score.py case NAME[+NAME] SIZE SEED SERIES        runs one case; one line of CSV
    score.py report FILE... [-o report.html]          the confusion matrix and the figures of such lines

Environment: HEXID, the program (build/hexid); RIG, another rig than hexid's own plant (build/tests/rig/rig, tests/rig/README.md); DETECTABLE, the file of strengths at which z = 8, and of the share of z
left beside each other effect (build/gap_score/detectable.csv, written by tests/bench/signatures); CONFIG, the base model (config/tian2015.yaml); SUBSTEPS of the rig (12); MOTION of the independent rig (sines; or multisine); RECORDINGS, a directory where rigs'
recordings stay, to be scored again without the rig; SET, "KEY=VALUE ..." that hexid gap alone is told; KEEP, a directory where a case leaves its log and report.

The rig runs on the ODE engine with a step of 0.167 ms, with noisy sensors and every base parameter off within model.tolerance;
`beyond` also disturbs it in ways that the tolerance does not cover. The diagnosis uses the other engine, its own steps, and only the log."""
import argparse, csv, functools, json, math, os, random, shutil, subprocess, sys, tempfile

sys.dont_write_bytecode = True  # leaves no files in the tree
import score_report

HEXID = os.environ.get("HEXID", "build/hexid")
CONFIG = os.environ.get("CONFIG", "config/tian2015.yaml")
RIG = os.environ.get("RIG", "")
MOTION = os.environ.get("MOTION", "sines")
FIELDS = score_report.FIELDS
SIZES = {"typical": 1.0, "strong": 3.0}  # relative to the catalogue's typical size; "detectable": the likelihood ratio is z = 8

# Values of the base, and effects whose parameters are added to one of them or scale one: the search must find the sum or the product.
BASE = {"payload.mass_kg": 178.6, "payload.inertia_xx_kg_m2": 13.6, "payload.inertia_yy_kg_m2": 13.6, "payload.inertia_zz_kg_m2": 23.92,
        "actuator.upper_mass_kg": 15.65, "actuator.lower_mass_kg": 52.48}
EACH = {"hydraulics.viscous_n_s_per_m": 2000, "hydraulics.bulk_modulus_pa": 1e9, "hydraulics.leakage_m3_per_s_pa": 3e-11,
        "hydraulics.valve_flow_m3_per_s": 1.57e-3, "hydraulics.dead_volume_m3": 1e-4}  # legs differ
NEUTRAL = {"null_bias": 0}
MASS, LEG, NULL = .01, .05, .005
SUMS = {"payload_mass.mass_kg": "payload.mass_kg", "payload_rotational_inertia.xx": "payload.inertia_xx_kg_m2",
        "actuator_inertia.upper_mass_kg": "actuator.upper_mass_kg", "actuator_inertia.lower_mass_kg": "actuator.lower_mass_kg",
        "payload_rotational_inertia.yy": "payload.inertia_yy_kg_m2", "payload_rotational_inertia.zz": "payload.inertia_zz_kg_m2",
        "cylinder_viscous_friction.extend_n_s_per_m": "hydraulics.viscous_n_s_per_m",
        "cylinder_viscous_friction.retract_n_s_per_m": "hydraulics.viscous_n_s_per_m",
        "valve_null_bias.offset": "null_bias"}  # for the independent rig, which has both
PRODUCTS = {"valve_flow_gain.scale": "hydraulics.valve_flow_m3_per_s", "internal_leakage.scale": "hydraulics.leakage_m3_per_s_pa"}

# Physically alike on the six tests: an ambiguous verdict with exactly this set is right (tests/bench/signatures shows which).
ALIKE = [{"payload_rotational_inertia", "external_stiffness"}, {"payload_mass", "external_stiffness"}, {"command_delay", "valve_lag"},
         {"actuator_inertia", "external_stiffness"}, {"position_sensor_scale", "position_sensor_offset"},
         {"geometry_error", "payload_center_of_mass"},
         {"geometry_error", "position_sensor_offset"}]  # moving a joint along a leg lengthens it, as a zero error of its sensor does
TOGETHER = {"payload_mass", "payload_rotational_inertia", "external_stiffness"}  # the first two together, at one frequency
RIVAL_Z = 4  # threshold of src/gap/search.c to distinguish two effects; below it an ambiguous set contains both


def effects():
    out = subprocess.run([HEXID, "effects", "--json", "-"], capture_output=True, text=True, check=True).stdout
    # no rig here has a force sensor
    return {e["name"]: e for e in json.loads(out)["effects"] if not e["name"].startswith("force_sensor")}


def base(r, series):
    def off(share): return 1.0 + r.uniform(-share, share)
    values = {name: value * off(MASS) for name, value in BASE.items()}
    values |= {name: [value * off(LEG) for _ in range(6)] for name, value in EACH.items()}
    values["effects.valve_null_bias.offset"] = [r.uniform(-NULL, NULL) for _ in range(6)]
    if series == "beyond":
        values |= {"hydraulics.supply_pa": 1e7 * off(.02), "hydraulics.valve_damping": [.8 * off(.2) for _ in range(6)],
                   "hydraulics.dead_volume_m3": [1e-4 * off(.3) for _ in range(6)],
                   "hydraulics.dead_volume_difference_m3": [1e-4 * r.uniform(-.3, .3) for _ in range(6)]}
        for key in ("a_x_m", "a_y_m", "a_z_m", "b_x_m", "b_y_m", "b_z_m"):
            values["effects.geometry_error." + key] = [r.uniform(-5e-4, 5e-4) for _ in range(6)]
    return values


# What the catalogue lacks: its family, if the catalogue has one for it, and the effects of the catalogue that a verdict may name. The laws
# of the first five are nearly the catalogue's.
FOREIGN = {"nearly_uneven_friction": ("cylinder_friction", {"cylinder_coulomb_friction"}),
           "nearly_stribeck_exponent": ("cylinder_friction", {"cylinder_stribeck_friction"}),
           "nearly_other_bristles": ("cylinder_friction", {"cylinder_dahl_friction"}),
           "nearly_rounded_hysteresis": ("valve", {"valve_hysteresis"}),
           "nearly_turbulent_leakage": ("oil", {"internal_leakage"}),
           "unknown_base_spring": ("", set()), "unknown_pump_ripple": ("supply", set()), "unknown_valve_kink": ("valve", set()),
           "unknown_loose_piston": ("", set()), "unknown_sensor_drift": ("sensors", set()), "unknown_sloshing": ("", set()),
           "unknown_warming_friction": ("cylinder_friction", {"cylinder_coulomb_friction"})}
OWN_UNKNOWN = ("unknown_base_spring", "unknown_pump_ripple")  # hexid's own plant has these
LOAD_PA = 3.2e6  # difference of the pressures of a resting leg, at which a turbulent leakage is as large as the laminar one


def foreign(name): return name in FOREIGN


def nearly(name): return name.startswith("nearly_")


def factor(r, most): return most ** r.uniform(-1, 1)


def foreign_values(r, name, size):
    """Draws an effect that the catalogue lacks, for the independent rig. A nearly known one has the size of its neighbour in the catalogue,
    and as hide() has it, in a third of the cases it is in one leg only."""
    one = r.randrange(6) if nearly(name) and r.random() < 1 / 3 else None
    s = SIZES.get(size, 1.0) * r.uniform(.8, 1.25) if nearly(name) else 1.0
    if name == "nearly_uneven_friction":
        values = {"uneven_friction.force_n": 100 * s, "uneven_friction.share": .1, "uneven_friction.wavelength_m": r.uniform(.02, .06),
                  "uneven_friction.phase_rad": r.uniform(0, 2 * math.pi)}
    elif name == "nearly_stribeck_exponent":
        values = {"cylinder_stribeck_friction.excess_n": 100 * s, "cylinder_stribeck_friction.velocity_mps": .02 * factor(r, 1.5),
                  "cylinder_stribeck_friction.exponent": r.uniform(.5, 1.8)}
    elif name == "nearly_other_bristles":  # stiffness is force over give
        values = {"bristle_friction.force_n": 100 * s, "bristle_friction.give_m": 1e-4 * factor(r, 3),
                  "bristle_friction.damping_n_s_per_m": 500 * factor(r, 3)}
    elif name == "nearly_rounded_hysteresis": values = {"rounded_hysteresis.width": .01 * s}
    elif name == "nearly_turbulent_leakage":  # as large as what internal_leakage.scale adds, of 1 + 2 s
        values = {"turbulent_leakage.flow_m3_per_s": 2 * s * EACH["hydraulics.leakage_m3_per_s_pa"] * LOAD_PA / math.sqrt(LOAD_PA / 1e6)}
    elif name == "unknown_base_spring": values = {"base_spring.frequency_hz": r.uniform(5, 8), "base_spring.mass_kg": r.uniform(800, 1500)}
    elif name == "unknown_pump_ripple": values = {"pump_ripple.pressure_pa": r.uniform(2e5, 8e5),
                                                  "pump_ripple.frequency_hz": 4 * r.randrange(8, 55) + r.uniform(1, 3)}
    elif name == "unknown_valve_kink":
        values = {"valve_kink.opening": r.uniform(.04, .12), "valve_kink.gain": r.choice([r.uniform(.5, .8), r.uniform(1.3, 2)])}
    elif name == "unknown_loose_piston": values = {"loose_piston.clearance_m": r.uniform(3e-4, 1.5e-3), "loose_piston.mass_kg": r.uniform(2, 5)}
    elif name == "unknown_sensor_drift": values = {"pressure_sensor_drift.p1_pa_per_s": [r.uniform(-5e3, 5e3) for _ in range(6)]}
    elif name == "unknown_sloshing": values = {"sloshing.mass_kg": r.uniform(15, 50), "sloshing.frequency_hz": r.uniform(.6, 2)}
    else: values = {"warming_friction.force_n": r.uniform(100, 400), "warming_friction.time_s": r.uniform(10, 40)}
    if one is not None:
        size_key = next(iter(values))
        values[size_key] = [values[size_key] if k == one else 0 for k in range(6)]
    return values, "all" if one is None else "leg %d" % (one + 1)


def unlisted(r, name):
    """Draws an effect that the catalogue lacks (sim/surroundings.h)."""
    if name == "unknown_base_spring": return {"sim.base_hz": r.uniform(5, 8), "sim.base_mass_kg": r.uniform(800, 1500)}
    return {"sim.ripple_pa": r.uniform(2e5, 8e5), "sim.ripple_hz": 4 * r.randrange(8, 55) + r.uniform(1, 3)}


def strength_of(effect, size):
    if size in SIZES: return SIZES[size]
    return detectable()[effect["name"]]


def signatures():
    with open(os.environ.get("DETECTABLE", "build/gap_score/detectable.csv")) as f: return list(csv.DictReader(line for line in f if line[0] != "#"))


def detectable(): return {row["effect"]: float(row["strength"]) for row in signatures()}


def told_apart(name, other, z):
    """Returns the z that separates a just detectable effect in all legs from another one, by their signatures on the six sines."""
    left = next((row["left"] for row in signatures() if row["effect"] == name), "").split()
    return z * next((float(share) for effect, share in (x.split(":") for x in left) if effect == other), math.inf)


def value_at(key, strength):
    if key["reciprocal"]: x = 1 / (1 / key["neutral"] + strength * (1 / key["typical"] - 1 / key["neutral"]))
    else: x = key["neutral"] + strength * (key["typical"] - key["neutral"])
    return min(max(x, key["min"]), key["max"])


def hide(r, effect, size):
    """Draws the effect's values, for all legs alike or for one; sign and size of each key are drawn around the requested size."""
    per_leg = all(k["per_leg"] for k in effect["keys"])
    one = r.randrange(6) if per_leg and r.random() < 1 / 3 else None
    sign = r.choice([-1, 1])
    strength, values = strength_of(effect, size), {}
    for key in effect["keys"]:
        low = key["neutral"] + (key["neutral"] - key["typical"])
        s = strength * r.uniform(.8, 1.25) * (sign if low >= key["min"] and not key["reciprocal"] else 1)
        if effect["name"] == "geometry_error":
            x = [value_at(key, s * r.choice([-1, 1])) for _ in range(6)]
        else:
            x = value_at(key, s)
            body = (BASE | EACH).get(SUMS.get(effect["name"] + "." + key["name"]), math.inf)
            if body + x <= 0: x = value_at(key, -s)  # a body's inertia and a cylinder's friction are never negative
        if one is not None: x = [(x[k] if isinstance(x, list) else x) if k == one else key["neutral"] for k in range(6)]
        values["effects.%s.%s" % (effect["name"], key["name"])] = x
    return values, "all" if one is None else "leg %d" % (one + 1)


def setting(name, value):
    return "%s=%s" % (name, "[%s]" % ", ".join("%.9g" % x for x in value) if isinstance(value, list) else "%.9g" % value)


def six(value): return value if isinstance(value, list) else [value] * 6


def whole(settings, name, value, found, neutral):
    """Returns the parameter's value in a model with the base as given that yields the rig's sum or product of both: in a leg that has the
    effect, or, if all are found alike, in the mean of the legs."""
    short = name.removeprefix("effects.")
    value, alike = six(value), min(six(found)) == max(six(found))
    off = [(six(settings[table[short]]), (BASE | EACH | NEUTRAL)[table[short]]) for table in (SUMS, PRODUCTS)
           if table.get(short) in settings]
    if not off: return value
    rig, given = off[0]
    full = [v if v == neutral else v + b - given if short in SUMS else v * b / given for v, b in zip(value, rig)]
    return [sum(full) / 6] * 6 if alike else full


def parameters(table, settings, truth, result):
    """Compares the found parameters with the rig's totals: the largest error in units of the hidden value; whether each is within 5 % of
    the rig's full value or two standard deviations; how many of how many are within two; and the largest error in deviations."""
    worst, right, covered, count, sigmas = 0.0, True, 0, 0, 0.0
    for name, hidden in truth.items():
        _, effect, key = name.split(".")
        k, short = next(x for x in table[effect]["keys"] if x["name"] == key), effect + "." + key
        e = next((e for e in result["effects"] if e["name"] == effect), None)
        if e is None: return {}
        if k["typical"] == k["neutral"]: continue
        found, std = six(e["parameters"][key]), six(e["std"][key])
        full, given = whole(settings, name, hidden, e["parameters"][key], k["neutral"]), (BASE | EACH | NEUTRAL)[SUMS[short]] if short in SUMS else 0
        size = max(abs(v - k["neutral"]) for v in six(hidden))
        for f, x, sd in zip(found, full, std):
            worst = max(worst, abs(f - x) / size) if size > 0 else worst
            right = right and abs(f - x) <= max(.05 * abs(x + given), 2 * sd)
            if sd > 0: sigmas = max(sigmas, abs(f - x) / sd)
        pairs = list(zip(found, full, std))
        if min(found) == max(found): pairs = pairs[:1]  # the model has one number for all legs
        pairs = [p for p in pairs if p[2] > 0]
        covered, count = covered + sum(abs(f - x) <= 2 * sd for f, x, sd in pairs), count + len(pairs)
    return {"error": worst, "right": int(right), "covered": covered, "values": count, "sigmas": sigmas}


def family_said(name, result, families):
    """Compares what a verdict says with the family of a foreign effect: "right", "half" (a set with members of other families), "wrong", or
    "" where it names nothing."""
    if result["verdict"] not in ("effect_named", "partly_named", "ambiguous"): return ""
    own = FOREIGN[name][0]
    said = {families.get(e, "") for e in [e["name"] for e in result["effects"]] + result["ambiguous_with"]}
    if said == {own}: return "right"
    return "half" if own in said and result["verdict"] == "ambiguous" else "wrong"


def stated_truly(names, result, families):
    """Returns whether what the verdict says is true at the level that it states: each effect is a hidden one, or a catalogue's neighbour of it;
    of an ambiguous set one of those in doubt is; a family is that of a hidden effect. None: it says nothing, or nothing is known of it."""
    if result["verdict"] not in ("effect_named", "partly_named", "ambiguous"): return None
    true = set().union(*(FOREIGN[n][1] if foreign(n) else {n} for n in names)) - {"none"}
    own = {FOREIGN[n][0] if foreign(n) else families.get(n) for n in names}
    named = [e["name"] for e in result["effects"]]
    levels = [s["level"] for s in result["statements"][:len(named)]]  # the sure statements come first, one an effect; none: all are effects
    doubt = {result["in_doubt"], *result["ambiguous_with"]} if result["ambiguous_with"] else set()
    if doubt and not doubt & true: return False
    if result["ambiguous_together"] and result["in_doubt"] not in true and not set(result["ambiguous_with"]) <= true: return False
    by_family = [k < len(levels) and levels[k] == "family" for k in range(len(named))]
    return all(e in doubt or (families[e] in own if family else e in true) for e, family in zip(named, by_family))


def judge(names, result, z, weak, families):
    """Returns the score, 1, 0.5 or 0; and whether it is 1 because the effect is too weak to be distinguished from the others of the set."""
    verdict, named, rivals = result["verdict"], [e["name"] for e in result["effects"]], result["ambiguous_with"]
    if names == ["none"]: return (1.0 if verdict == "no_gap" else 0.0), False
    if nearly(names[0]): return {"right": 1.0, "half": 0.5}.get(family_said(names[0], result, families), 0.0), False
    if names[0].startswith("unknown_"): return (1.0 if verdict == "unknown_effect" else 0.0), False
    if len(names) == 2:
        doubt = set(rivals) | {result["in_doubt"]}
        alike = not rivals or any(doubt <= a for a in ALIKE) or (result["ambiguous_together"] and doubt == TOGETHER)
        return (1.0 if alike and set(names) <= set(named + rivals) else 0.0), False
    if verdict in ("effect_named", "partly_named"): return (1.0 if named[:1] == names else 0.0), False
    said = set(named + rivals)
    if verdict != "ambiguous" or names[0] not in said: return 0.0, False
    if any(said <= a for a in ALIKE) or (result["ambiguous_together"] and said == TOGETHER): return 1.0, False
    weak = weak and len(named) == 1 and all(told_apart(names[0], other, z) < RIVAL_Z for other in said - {names[0]})
    return (1.0 if weak else 0.5), weak


@functools.cache
def drawing():
    """Returns settings with the drawing of the independent rig: the orientation of its joints' axes."""
    if not RIG: return []
    return subprocess.run([RIG, "-c", CONFIG, "--joint-axes"], stdout=subprocess.PIPE, text=True, check=True).stdout.splitlines()


def diagnose(log, out, settings=()):
    """Runs hexid gap on a log; returns its result, or the reason why there is none."""
    options = [x for s in [*drawing(), *settings, *os.environ.get("SET", "").split()] for x in ("--set", s)]
    gap = subprocess.run([HEXID, "gap", "--measured", log, "-c", CONFIG, "-o", out, "--set", "lcm.url="] + options, capture_output=True, text=True)
    if gap.returncode: return {}, gap.stderr.strip().split("\n")[-1][-160:]
    with open(out + "/gap.json") as f: return json.load(f), ""


def seen(name, result):
    """Returns z of an effect in the first round, beside the base alone."""
    z = [e["z"] for e in result["effects"] + result["rejected"] if e["name"] == name and e["z"]]
    return z[0] if z else 0.0


def seen_beside(name, other, hidden, log, out):
    """Returns z of an effect when the model has the other effect at its true size, to find out whether these data can show both."""
    result, refused = diagnose(log, out, [setting(*i) for i in hidden[other].items()])
    return math.nan if refused else seen(name, result)


def own_rig(r, series, seed, work, log, hidden, table):
    """Records hexid's own plant with the other engine. Returns its parameters besides the hidden ones, and the reason if there is no
    log."""
    settings = base(r, series)
    for name in hidden: settings |= unlisted(r, name) if name.startswith("unknown_") else hidden[name]
    settings |= {"sim.substeps": int(os.environ.get("SUBSTEPS", 12))}
    options = [x for s in [setting(*i) for i in settings.items()] + ["sim.engine=ode", "lcm.url="] for x in ("--set", s)]
    rig = subprocess.run([HEXID, "run", "-c", CONFIG, "--hal", "sim:", "--fast", "--seed", str(1000 + int(seed)), "--log", log,
                          "--json", work + "/rig.json"] + options, capture_output=True, text=True)
    if rig.returncode not in (0, 1): return settings, "the rig does not run: " + rig.stderr.strip()[-120:]
    with open(work + "/rig.json") as f: tests = json.load(f)["tests"]
    return settings, "" if any(t["complete"] for t in tests) else "the rig ends in a fault before its first test is done"


def other_rig(r, series, seed, work, log, hidden, table):
    """Records an independent rig (RIG), through its CSV; returns the same as own_rig()."""
    options = []
    for name in hidden:
        if foreign(name): values = hidden[name]
        else: values = {key.removeprefix("effects."): off_legs(table, key, value) for key, value in hidden[name].items()}
        for key, value in values.items(): options += ["--effect", "%s=%s" % (key, ",".join("%.9g" % x for x in six(value)))]
    command = [RIG, "-c", CONFIG, "-o", work + "/measured", "--" + series, str(seed), "--noise", str(seed), "--motion", MOTION] + options
    rig = subprocess.run(command, capture_output=True, text=True)
    if rig.returncode == 0: rig = subprocess.run([HEXID, "import", work + "/measured", "-o", log], capture_output=True, text=True)
    if rig.returncode: return {}, "the rig does not run: " + (rig.stderr.strip() or "status %d" % rig.returncode)[-120:]
    with open(work + "/truth.json") as f: base = json.load(f)["base"]
    share = base["payload_mass_kg"] / BASE["payload.mass_kg"]
    settings = {name: BASE[name] * share for name in BASE if name.startswith("payload.")}
    settings |= {"actuator.upper_mass_kg": base["upper_mass_kg"], "actuator.lower_mass_kg": base["lower_mass_kg"]}
    of = {"viscous": "viscous_n_s_per_m", "leakage": "leakage_m3_per_s_pa", "valve_gain": "valve_flow_m3_per_s"}
    for name, key in of.items():
        settings["hydraulics." + key] = [EACH["hydraulics." + key] * x for x in base[name + " relative to nominal, legs 1..6"]]
    settings["null_bias"] = base["null_bias of full opening, legs 1..6"]
    return settings, ""


def recorded(case, size, series, seed, work, log, table):
    """Makes the rig's log, unless it was kept. Returns its other parameters, the hidden effects, their legs, and the reason if there is no
    log."""
    r, hidden, shapes = random.Random("%s %s %s %s" % (case, size, seed, series)), {}, []
    rig = "rig" if RIG else "own%s" % os.environ.get("SUBSTEPS", 12)
    if MOTION != "sines": rig += "-" + MOTION
    kept = os.environ.get("RECORDINGS")
    name = kept and "/".join((kept, ".".join((rig, os.path.basename(CONFIG), case, size, series, str(seed)))))
    if kept and os.path.exists(name + ".json"):
        shutil.copy(name + ".lcm", log)
        with open(name + ".json") as f: k = json.load(f)
        return k["settings"], k["hidden"], k["shapes"], ""
    for effect in case.split("+"):
        if effect in table:
            hidden[effect], shape = hide(r, table[effect], size)
            shapes.append(shape)
        elif foreign(effect) and RIG:
            hidden[effect], shape = foreign_values(r, effect, size)
            if nearly(effect): shapes.append(shape)
        elif effect in OWN_UNKNOWN: hidden[effect] = {}
        elif effect != "none": raise SystemExit("score.py: no such effect, or not on this rig: " + effect)
    settings, remark = (other_rig if RIG else own_rig)(r, series, seed, work, log, hidden, table)
    if kept and not remark:
        os.makedirs(kept, exist_ok=True)
        shutil.copy(log, name + ".lcm")
        with open(name + ".json", "w") as f: json.dump({"settings": settings, "hidden": hidden, "shapes": shapes}, f)
    return settings, hidden, shapes, remark


def off_legs(table, name, value):
    """Returns the six values for the rig, in which 0 means no limit if the law is a limit."""
    _, effect, key = name.split(".")
    k = next(x for x in table[effect]["keys"] if x["name"] == key)
    return [0 if x == k["neutral"] and k["reciprocal"] else x for x in six(value)]


def run_case(case, size, seed, series):
    table, names = effects(), case.split("+")
    row = dict.fromkeys(FIELDS, "") | {"truth": case, "size": size, "seed": seed, "series": series}
    with tempfile.TemporaryDirectory() as work:
        work = os.environ.get("KEEP", work)
        log, out = work + "/rig.lcm", work + "/out"
        settings, hidden, shapes, remark = recorded(case, size, series, seed, work, log, table)
        truth = {key: value for name, values in hidden.items() if name in table for key, value in values.items()}
        row["shape"] = " ".join(shapes)
        if remark: return row | {"remark": remark}
        result, refused = diagnose(log, out)
        if refused: return row | {"score": 0.0, "remark": "refused: " + refused}
        z = seen(names[0], result)
        families = {name: e["family"] for name, e in table.items()}
        score, weak = judge(names, result, z, size == "detectable" and shapes == ["all"] and MOTION == "sines", families)
        true = stated_truly(names, result, families)
        if foreign(names[0]):
            row["family"] = family_said(names[0], result, families)
            z = max((seen(n, result) for n in FOREIGN[names[0]][1]), default=0.0)
        if len(names) == 2 and score == 0:  # the effect that is less visible
            z = min(seen_beside(a, b, hidden, log, work + "/beside") for a, b in (names, names[::-1]))
    g = {k: (result["gap"][k]["overall"] or math.nan) for k in ("held_out_before", "held_out_after", "noise_floor")}
    where = result["where"][0] if result["where"] else {}
    row |= {"certainty": "" if result["certainty"] is None else result["certainty"], "stated": "" if true is None else int(true)}
    return row | {"weak": int(weak), "verdict": result["verdict"], "named": " ".join(e["name"] for e in result["effects"]),
                  "ambiguous_with": " ".join(result["ambiguous_with"]), "score": score, "z": "%.1f" % z if z or (len(names) == 2 and score == 0) else "",
                  **(parameters(table, settings, truth, result) if truth else {}), "before": g["held_out_before"],
                  "after": g["held_out_after"], "floor": g["noise_floor"],
                  "ratio": g["held_out_after"] / g["noise_floor"], "seconds": result["seconds"], "white": result["mean_white_square"]["after"],
                  "where": "%s %s leg %s h%s" % tuple(where.get(k, "") for k in ("test", "channel", "leg", "harmonic"))}


def cases(a):
    names = a.effects.split(",") if a.effects else list(effects())
    for kind in a.kinds.split(","):
        if kind == "single":
            for name in names:
                for size in a.sizes.split(","):
                    if size == "detectable" and not detectable().get(name): continue  # no strength has z = 8
                    for seed in range(a.first, a.first + a.seeds): print(name, size, seed, a.series)
        if kind == "none":
            for seed in range(a.first, a.first + 4 * a.seeds): print("none typical", seed, a.series)
        if kind == "two":
            r, strength = random.Random(a.first), detectable()
            names = [n for n in names if strength.get(n, math.inf) < 1]  # the effects that the residuals show
            for seed in range(a.first, a.first + 8 * a.seeds): print("+".join(r.sample(names, 2)), "typical", seed, a.series)
        if kind == "unknown":
            for seed in range(a.first, a.first + 2 * a.seeds):
                for name in [n for n in FOREIGN if not nearly(n)] if RIG else OWN_UNKNOWN: print(name, "typical", seed, a.series)
        if kind == "nearly":
            for seed in range(a.first, a.first + 12 * a.seeds):
                for size in SIZES:
                    for name in filter(nearly, FOREIGN): print(name, size, seed, a.series)


def write_rows(rows, out):
    w = csv.DictWriter(out, FIELDS, lineterminator="\n")
    for row in rows: w.writerow({k: ("%.6f" if k == "certainty" else "%.4g") % v if isinstance(v, float) else v for k, v in row.items()})


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    sub = p.add_subparsers(dest="what", required=True)
    c = sub.add_parser("cases")
    c.add_argument("--seeds", type=int, default=1)
    c.add_argument("--first", type=int, default=1)
    c.add_argument("--series", default="tolerance")
    c.add_argument("--kinds", default="single,none")
    c.add_argument("--sizes", default="typical")
    c.add_argument("--effects", default="")
    c = sub.add_parser("case")
    c.add_argument("name"), c.add_argument("size"), c.add_argument("seed"), c.add_argument("series")
    c = sub.add_parser("report")
    c.add_argument("files", nargs="+")
    c.add_argument("-o", dest="page", help="the same as a page")
    a = p.parse_args()
    if a.what == "cases": cases(a)
    elif a.what == "case": write_rows([run_case(a.name, a.size, a.seed, a.series)], sys.stdout)
    else: score_report.report(a.files, a.page)


if __name__ == "__main__": main()
