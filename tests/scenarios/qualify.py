"""qualify.py HEXID RESULT.json OPTION...: compares some describing functions of the result with the machine's response to that sine alone, for at
least ten seconds and four periods, as `hexid run` identifies it. They agree within 2 % and 2 degrees. OPTIONs go to `hexid run`."""
import json
import pathlib
import subprocess
import sys
import tempfile

hexid, result, *options = sys.argv[1:]
AXES = ["x", "y", "z", "phi", "theta", "psi"]
CASES = [("x", 0), ("x", 7), ("z", 4), ("theta", 2), ("psi", 10)]  # axis, number of the tone


def alone(axis, tone):
    key = "tests.amplitude_m" if axis in "xyz" else "tests.amplitude_rad"
    hz = tone["frequency_hz"]
    settings = {"tests.frequency_hz": hz, key: tone["amplitude"], "tests.duration_s": max(10, 4 / hz), "tests.ramp_s": 10}
    with tempfile.TemporaryDirectory() as work:
        out = pathlib.Path(work) / "one.json"
        sets = [word for k, v in settings.items() for word in ("--set", f"{k}={v!r}")]
        subprocess.run([hexid, "run", "--fast", "--tests", axis, *options, *sets, "--json", out], stdout=subprocess.DEVNULL, check=False)
        found = json.loads(out.read_text(encoding="utf-8"))["tests"][0]
    return found["achieved_amplitude"] / tone["amplitude"], found["phase_deg"]


axes = {a["axis"]: a["tones"] for a in json.loads(pathlib.Path(result).read_text(encoding="utf-8"))["axes"]}
for name, number in CASES:
    own = axes[name][number]
    gain, phase = alone(name, own)
    i = AXES.index(name)
    off_pct = 100 * (own["gain"][i] / gain - 1)
    off_deg = (own["phase_deg"][i] - phase + 180) % 360 - 180
    print(f"{name} at {own['frequency_hz']:.3g} Hz: {off_pct:+.2f} %, {off_deg:+.2f} deg off")
    assert abs(off_pct) < 2 and abs(off_deg) < 2
