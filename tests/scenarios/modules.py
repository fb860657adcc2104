"""Compares tests/modules with the tree. From the repository root, after the tests are built.

    modules.py complete         every module has a test of its own name or a line
    modules.py current          no line is out of date
    modules.py linked BUILD     every C test is linked with the modules that it tests: it cannot call others"""
import collections
import fnmatch
import pathlib
import subprocess
import sys

MODULES = sorted(p for pattern in ("src/*/*.c", "src/*/*.cpp", "hal/*.c", "sim/*.c", "sim/effects/*.c") for p in pathlib.Path(".").glob(pattern))
LINES = [line.split() for line in pathlib.Path("tests/modules").read_text().splitlines() if not line.startswith("#")]


def own(module):
    return pathlib.Path("tests", f"test_{module.stem}.c")


def tests_of(module):
    """Returns the names of a module's tests, as tests/modules has them."""
    return [t for pattern, *tests in LINES if fnmatch.fnmatch(module, pattern) for t in tests] + [own(module).stem] * own(module).exists()


def missing():
    return [f"{m}: neither {own(m)} nor a line in tests/modules" for m in MODULES if not tests_of(m)]


def out_of_date():
    for pattern, *tests in LINES:
        held = [m for m in MODULES if fnmatch.fnmatch(m, pattern)]
        if not held or not tests:
            yield f"{pattern}: no such module, or no test"
        yield from (f"{m}: {own(m)} needs no line" for m in held if own(m).stem in tests)
        yield from (f"{pattern}: {t}: no such test" for t in tests
                    if not pathlib.Path("tests/scenarios" if t.endswith(".sh") else "tests", t if t.endswith(".sh") else t + ".c").exists())
    counts = collections.Counter(line[0] for line in LINES)
    yield from (f"{pattern}: listed twice" for pattern, count in counts.items() if count > 1)


def symbols(files, *options):
    """Returns a dictionary: file -> the names that it defines."""
    found = collections.defaultdict(set)
    listing = subprocess.run(["nm", "-A", "--defined-only", *options, *files], check=True, capture_output=True, text=True).stdout
    for file, _, rest in (line.partition(":") for line in listing.splitlines()):
        found[file].add(rest.split()[-1])
    return found


def not_linked(build):
    # a scenario runs the program, which has all modules
    programs = {t: str(build / "tests" / t) for m in MODULES for t in tests_of(m) if not t.endswith(".sh")}
    in_test = symbols(programs.values())
    in_module = symbols([str(build / m.with_suffix(".o")) for m in MODULES], "--extern-only")
    for module in MODULES:
        own_names = in_module[str(build / module.with_suffix(".o"))]
        yield from (f"{module} is not in {t}" for t in tests_of(module) if t in programs and not own_names & in_test[programs[t]])


if __name__ == "__main__":
    checks = {"complete": missing, "current": out_of_date, "linked": lambda: not_linked(pathlib.Path(sys.argv[2]))}
    found = list(checks[sys.argv[1]]())
    print("\n".join(found) or f"{len(MODULES)} modules, {len(LINES)} lines")
    sys.exit(bool(found) or len(MODULES) < 200)
