#!/bin/bash
# Impossible requests are refused before any motion in one line that names the place, with the exit status of their kind.
. tests/scenarios/lib

# file TEXT: a configuration file whose third line is the text.
file() {
    printf '# a rig\n%s:\n  %s\n' "${1%%.*}" "${1#*.}" >"$work/rig.yaml"
    echo "$work/rig.yaml"
}
refused_in_file() { claim "$1: refused, naming file, line and key" refuses 2 "rig.yaml:3: $2" quick -c "$(file "$3")"; }
refused_setting() { claim "$1: refused, naming the setting" refuses 2 "--set ${2%%=*}" quick --set "$2"; }

claim "a missing configuration file: refused, naming it" refuses 2 "$work/nowhere.yaml" quick -c "$work/nowhere.yaml"
refused_in_file "an unknown key" tests.frequenzy_hz "tests.frequenzy_hz: 4"
refused_in_file "a word for a number" tests.frequency_hz "tests.frequency_hz: four"
refused_in_file "a number for a choice" sim.engine "sim.engine: 3"
refused_in_file "a fraction for a count" sim.substeps "sim.substeps: 8.5"
refused_in_file "a list for a number" payload.mass_kg "payload.mass_kg: [1, 2]"
refused_in_file "a value out of range" payload.mass_kg "payload.mass_kg: -178"
refused_in_file "not a number" control.kp "control.kp: .nan"
refused_in_file "infinity" control.kp "control.kp: .inf"
refused_in_file "an empty value" control.kp "control.kp:"
refused_in_file "an unknown effect" effects.gremlins "effects.gremlins: 1"
claim "a file that is no YAML: refused, naming file and line" refuses 2 "rig.yaml:" quick -c "$(file "control.kp: [1")"
claim "a binary file: refused, naming it" refuses 2 "$hexid" quick -c "$hexid"
claim "a directory: refused, naming it" refuses 2 "$work" quick -c "$work"

refused_setting "an unknown key" tests.frequenzy_hz=4
refused_setting "a word for a number" tests.frequency_hz=four
refused_setting "not a number" tests.amplitude_m=nan
refused_setting "an amplitude of zero" tests.amplitude_m=0
refused_setting "a setting without a value" tests.amplitude_m
refused_setting "five values for six legs" effects.cylinder_coulomb_friction.force_extend_n=[1,2,3,4,5]
refused_setting "a negative friction" effects.cylinder_coulomb_friction.force_extend_n=-1
claim "a frequency above a quarter of the sample rate: refused, naming it" refuses 2 "tests.frequency_hz loop.period_s" \
    quick --set tests.frequency_hz=60 --set loop.period_s=0.005
claim "a rod thicker than its piston: refused, naming both" refuses 2 "rod_diameter_m piston_diameter_m" \
    quick --set actuator.rod_diameter_m=0.07
claim "legs that cannot reach: refused, naming stroke and height" refuses 2 "stroke_m height_m" quick --set geometry.height_m=0.3
claim "an impossible payload: refused, naming its inertia" refuses 2 "inertia_xx_kg_m2" quick --set payload.inertia_zz_kg_m2=60

claim "a loop that is unstable: refused, with mode, frequency, damping, the key and a value that suits" \
    refuses 2 "unstable y at 18.6 Hz damping -0.0 set control.kp to 85" quick --set control.kp=270
claim "a platform of 4 t and more with the default kpf: refused, naming it and a value that suits" \
    refuses 2 "unstable damping set control.kpf to 4.5e-06" "$hexid" run --fast -c config/simulator.yaml --set lcm.url= --set control.kpf=2e-5
claim "gains that make the sensors' noise a shaking platform: refused, with one that does not" \
    refuses 2 "noise shake m/s^2 limits.oscillation_mps2 set control.kd to" quick --set control.kd=1
claim "a loop that is unstable behind a bus: refused before anything is opened" \
    refuses 2 "unstable control.ki" "$hexid" run --hal can:nowhere0 --set lcm.url= --set control.ki=20000
warns_of_nothing() { ! "$hexid" run --fast "${quick_settings[@]}" --tests z 2>&1 >/dev/null | grep -E 'loop|feed-forward|limits'; }
claim "the default machine: nothing is warned of" warns_of_nothing
unwatched() { quick --tests z --set interlocks.door=false 2>&1 >/dev/null | grep -x 'hexid: interlocks: .*, supply output; NOT WIRED, so not watched: door'; }
claim "an input that is not wired: said at the start" unwatched
warned() { quick --tests z --set $1 2>&1 >/dev/null | grep "hexid: warning: $2: .*$3"; }
claim "a loop that is hardly damped runs, with a warning" warned "control.kpf=5e-5 --set sensors.enabled=false" loop "hardly damped at neutral: .*set control.kpf to"
claim "a feed-forward of another valve: a warning with the value that suits" warned control.kff=2.5 feed-forward "set control.kff to 1.74"
claim "a limit that nothing reaches: a warning with a value that protects" warned limits.force_n=1e6 limits "set limits.force_n to"

massless() { refuses 2 "actuator.$1 sim.engine closed_form" "$hexid" run --fast --set lcm.url= --set "actuator.$1=0" &&
    { "$hexid" doctor --latency 0 --set lcm.url= --set "actuator.$1=0" | grep "FAIL  tests  *actuator.$1"; }; }
for part in upper_mass_kg lower_mass_kg upper_inertia_kg_m2 lower_inertia_kg_m2; do
    claim "actuator.$part=0 with ODE: refused by run and doctor, naming it" massless $part
done

claim "a watchdog that leaves the machine blind for long: refused, with the key, the time and the remedy" \
    refuses 2 "device.watchdog_s 5.02 limits.blind_time_s" quick --set device.watchdog_s=5
blind_time() { "$hexid" doctor --latency 0 --set loop.overrun_limit=40 | grep 'ok *blind time *0.092 s of 0.1, with a loop that is late: .*loop.overrun_limit'; }
claim "doctor prints the blind time, and what it comes from" blind_time
claim "an unknown option: refused, naming it" refuses 2 "--fats" quick --fats
claim "an option without its value: refused, naming it" refuses 2 "--log" quick --log
claim "an argument too many: refused, naming it" refuses 2 "extra" quick extra
claim "a seed that is no number: refused" refuses 2 "--seed x1" quick --seed x1
claim "an unknown test: refused" refuses 2 "roll" quick --tests x,roll
claim "an unknown kind of machine: refused, naming it" refuses 2 "--hal telepathy:" "$hexid" run --hal telepathy: --set lcm.url=
claim "an unknown subcommand: refused" ends 2 "$hexid" fly
claim "no subcommand: usage" ends 2 "$hexid"
claim "--help is no error" ends 0 "$hexid" --help
claim "identify without a log: refused" refuses 2 "log" "$hexid" identify
gap() { refuses "$1" "$2" "$hexid" gap -c config/tian2015.yaml -o "$work/gap" "${@:3}"; }
claim "more logs than gap takes: refused, with the number" gap 2 "e 4" --measured={a,b,c} d e
named_once() { gap 3 "cannot read" --measured "$work/none.lcm" && [ "$(grep -o none.lcm "$work/error" | wc -l)" -eq 1 ]; }
claim "a log that is not there: gap names it, once" named_once

claim "a log in a directory that is not there: I/O error, naming it" refuses 3 "$work/none/run.lcm" quick --log "$work/none/run.lcm"
claim "a log on a full disk: I/O error, naming it" refuses 3 "/dev/full" quick --log /dev/full
claim "results on a full disk: I/O error, naming it" refuses 3 "/dev/full" quick --json /dev/full
claim "a log that is not there: I/O error, naming it" refuses 3 "$work/none.lcm" "$hexid" identify "$work/none.lcm"
claim "a file that is no log: I/O error, naming it" refuses 3 "Makefile" "$hexid" identify Makefile
: >"$work/empty.lcm"
claim "an empty log: I/O error, naming it" refuses 3 "$work/empty.lcm" "$hexid" identify "$work/empty.lcm"

# Runs that may never end are refused at once.
mkfifo "$work/fifo.lcm" "$work/fifo.yaml"
mkdir "$work/pipes" "$work/configured" "$work/linked"
mkfifo "$work/pipes/1_x.csv" "$work/configured/config.yaml"
ln -s /dev/zero "$work/linked/1_x.csv"
at_once() { refuses "$1" "$2" timeout 10 "${@:3}"; }
import() { at_once "$1" "$2" "$hexid" import "$work/$3" -o "$work/never.lcm"; }
claim "a FIFO for a log: refused, naming it and the remedy" at_once 3 "fifo.lcm FIFO file" "$hexid" identify "$work/fifo.lcm"
claim "export: the same" at_once 3 "fifo.lcm FIFO file" "$hexid" export "$work/fifo.lcm" -o "$work/never"
claim "gap: the same" at_once 3 "fifo.lcm FIFO file" "$hexid" gap -c config/tian2015.yaml -o "$work/gap" --measured "$work/fifo.lcm"
claim "a device for a log: refused" at_once 3 "/dev/zero device" "$hexid" identify /dev/zero
claim "a directory for a log: refused" at_once 3 "$work directory" "$hexid" identify "$work"
claim "a FIFO for a configuration: refused" at_once 2 "fifo.yaml FIFO" "$hexid" run -c "$work/fifo.yaml"
claim "a terminal for a configuration: refused" at_once 2 "/dev/ptmx device" "$hexid" run -c /dev/ptmx
claim "a FIFO among the files to import: refused, naming it" import 3 "pipes/1_x.csv FIFO" pipes
claim "one as their configuration: refused, naming it" import 2 "configured/config.yaml FIFO" configured
claim "a link to a device among them: refused" import 3 "linked/1_x.csv device" linked

# Another program can read an output at once.
piped() {
    local log status
    cat "$work/fifo.lcm" >"$work/piped.lcm" & log=$!
    ends 0 quick --log "$work/fifo.lcm" >/dev/null
    status=$?
    ((status == 0)) || kill $log
    wait $log
    ((status == 0)) && ends 0 "$hexid" identify "$work/piped.lcm" >/dev/null
}
claim "a FIFO takes the log of a run" piped

# The log keeps the measured frequency, so the page and a later identification report it as well.
measured() {
    local said="stroke, leg 3: [0-9.]* mm, limit 2240 mm (limits.length_max_m)"
    ends 1 quick --tests z --hal "fault:length@3+5/3=1;sim:" --log "$work/fault.lcm" >"$work/out" 2>&1
    cat "$work/out"
    grep "FAULT stroke, leg 3 at [0-9.]* s: [0-9.]* mm, limit 2240 mm (limits.length_max_m); supply off" "$work/out" && grep "fault $said" "$work/out" &&
        { "$hexid" identify "$work/fault.lcm" | grep "fault $said"; } && "$hexid" report "$work/fault.lcm" -o "$work/fault.html" >"$work/said" 2>&1
    grep "ended with the fault $said" "$work/fault.html"
}
claim "a fault: terminal, verdict, log and page say leg, value, limit and key" measured
