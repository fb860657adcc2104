"""Compares an identification (hexid.identification/1) with the rig's own inertia matrix and hidden effects, and prints the comparison."""
import json, math, sys

ENTRIES = [(i, k) for i in range(6) for k in range(i, 6)]
NAMES = "x y z phi theta psi".split()


def load(path):
    with open(path) as file:
        return json.load(file)


def scale(matrix, i, k):
    """Returns the upper bound of an entry of a positive definite matrix: one measure for errors of masses, couplings and inertias."""
    return math.sqrt(matrix[i][i] * matrix[k][k])


def nominal(run, matrix, limit):
    """Compares the nominal matrix with the rig's own, which is derived differently."""
    errors = [abs(run["nominal"]["Mt"][i][k] - matrix[i][k]) / scale(matrix, i, k) for i in range(6) for k in range(6)]
    print(f"largest difference {max(errors):.1e}")
    return all(error <= limit for error in errors)


def covered(run, matrix, deviations):
    """Checks every entry of method C by its own stated deviation, whose scale close() bounds."""
    found, std = run["method_c"]["Mt"], run["method_c"]["std"]
    for i, k in ENTRIES:
        off = (found[i][k] - matrix[i][k]) / std[i][k]
        print(f"Mt({NAMES[i]},{NAMES[k]}) {found[i][k]:.5g}, the rig's {matrix[i][k]:.5g}: {off:+.2f} deviations")
    return all(abs(found[i][k] - matrix[i][k]) <= deviations * std[i][k] for i, k in ENTRIES)


def close(run, matrix, percent):
    """Checks the same entries in percent; diagonal entries relative to themselves. A coupling's own size is no measure, because symmetry
    makes it 0."""
    found = run["method_c"]["Mt"]
    errors = [100 * (found[i][k] - matrix[i][k]) / scale(matrix, i, k) for i, k in ENTRIES]
    print("  ".join(f"{NAMES[i]}{NAMES[k]} {error:+.2f} %" for (i, k), error in zip(ENTRIES, errors)))
    return all(abs(error) <= percent for error in errors)


def friction(run, hidden_n, percent, deviations):
    """Checks the friction of each leg by its stated deviation, and of the six together in percent, for each direction."""
    right = True
    for way in ("extend", "retract"):
        found, std = (run["method_c"]["dry_friction_n"][way + more] for more in ("", "_std"))
        mean = 100 * (sum(found) / 6 / hidden_n - 1)
        print(way, "  ".join(f"{x:.4g} N ({(x - hidden_n) / s:+.2f} deviations)" for x, s in zip(found, std)), f"mean {mean:+.2f} %")
        right = right and abs(mean) <= percent and all(abs(x - hidden_n) <= deviations * s for x, s in zip(found, std))
    return right


if __name__ == "__main__":
    check, run, *rest = sys.argv[1:]
    if check != "friction": rest[0] = load(rest[0])
    sys.exit(not globals()[check](load(run), *(x if isinstance(x, list) else float(x) for x in rest)))
