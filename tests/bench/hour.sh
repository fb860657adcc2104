#!/bin/bash
# Processor time and memory of `hexid identify` on an hour of noise-like motion at 2 ms: all axes at once, random, 0.3 to 5 Hz, on the
# closed-form engine. Needs 1 GB of disk.
#     hour.sh BUILD PYTHON
# SECONDS_OF: another length of the motion.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
seconds=${SECONDS_OF:-3600}
"$2" - "$seconds" >"$work/noise.csv" <<'END'
import sys

import numpy as np

rng = np.random.default_rng(5)
step_s = 0.01
count = int(float(sys.argv[1]) / step_s)
hz = np.fft.rfftfreq(count, step_s)
columns = [np.arange(count) * step_s]
for axis in range(6):
    band = (hz > 0.3) & (hz < 5.0)
    x = np.fft.irfft(band * (rng.normal(size=hz.size) + 1j * rng.normal(size=hz.size)), count)
    columns.append(x * (0.002 if axis < 3 else 0.004) / x.std())
np.savetxt(sys.stdout, np.column_stack(columns), delimiter=",", fmt="%.7g", header="t_s,x_m,y_m,z_m,phi_rad,theta_rad,psi_rad", comments="")
END
"$1/hexid" run --fast --set sim.engine=closed_form --trajectory "$work/noise.csv" --log "$work/a.lcm" >"$work/said" 2>&1 || true
[ -s "$work/a.lcm" ] || { tail -n 3 "$work/said" >&2; exit 1; }
/usr/bin/time -o "$work/time" -f '%U %S %M' "$1/hexid" identify "$work/a.lcm" --json "$work/a.json" >/dev/null
grep -q '"scatter": [0-9]' "$work/a.json" || { echo "hour: nothing was identified" >&2; exit 1; }
echo "$("$1/hexid" --version)"
printf '\n| motion, s | log, MB | processor time, s | memory, MB |\n| --- | --- | --- | --- |\n'
tail -n 1 "$work/time" | awk -v s="$seconds" -v b="$(stat -c %s "$work/a.lcm")" \
    '{ printf "| %g | %.0f | %.1f | %.0f |\n", s, b / 1e6, $1 + $2, $3 / 1e3; if (!($1 + $2 > 0)) exit 1 }'
