#!/bin/bash
# doctor on this computer: output, JSON, exit status; an existing Modbus device and a full disk.
. tests/scenarios/lib
own_network "doctor finds what is wrong"
quiet=(--latency 0 --set lcm.url=)

# Each upper pair of joints belongs to the same legs as the lower pair.
paired=(--set 'geometry.upper_joints_m=[[0.545,-0.13,0],[0.545,0.13,0],[-0.16,0.537,0],[-0.385,0.407,0],[-0.385,-0.407,0],[-0.16,-0.537,0]]'
    --set 'geometry.lower_joints_m=[[1.179,-0.225,0],[1.179,0.225,0],[-0.395,1.133,0],[-0.784,0.908,0],[-0.784,-0.908,0],[-0.395,-1.133,0]]'
    --set motion.park_z_m=0.3 --set limits.length_min_m=1.35)
warned() {
    "$hexid" doctor --latency 0 --set lcm.url= "${paired[@]}" | sed -n 's/^  WARN  workspace *//p' | grep . >"$work/found" &&
        ends 2 quick "${paired[@]}" >"$work/text" 2>"$work/warning" && cat "$work/found" "$work/warning" &&
        [ "$(grep -c 'warning: workspace: ' "$work/warning")" -eq 1 ] && grep -qF "warning: workspace: $(cat "$work/found")" "$work/warning"
}
if [ -n "${MORE_CASES:-}" ]; then # make test-long only: each searches ten seconds for gains of a machine that has none
    claim "a singular pose near neutral: the run says doctor's warning, once" warned
    exit
fi

fit() {
    ends 0 "$hexid" doctor "${quiet[@]}" >"$work/text"
    local status=$?
    cat "$work/text"
    ((status == 0)) && grep -Eqx 'fit: 0 FAIL, [0-9]+ WARN, [0-9]+ that cannot be seen from here' "$work/text"
}
claim "a simulation without LCM: nothing fails, exit status 0" fit

complete() {
    ends 0 "$hexid" doctor --set lcm.url="$url" --latency 0.5 --json "$work/doctor.json" >"$work/text" || { cat "$work/text"; return 1; }
    "$python" - "$work/doctor.json" "$work/text" <<'END'
import json, sys
d, text = json.load(open(sys.argv[1])), open(sys.argv[2]).read()
assert d["schema"] == "hexid.doctor/1" and d["machine"] == "sim:" and d["fit"] is True and d["version"] and d["config"]
names = [f["name"] for f in d["findings"]]
assert len(set(names)) == len(names), names
for name in ("configuration", "kernel", "real time", "governor", "isolation", "throttling", "clock source", "LCM socket", "LCM route", "LCM datagram",
             "LCM buffers", "log room", "log speed", "wake-up"):
    assert name in names, name
for f in d["findings"]:
    assert f["level"] in ("ok", "unknown", "warn", "fail") and (f["level"] == "ok") == (f["remedy"] == ""), f
    assert f["name"] in text and f["found"].split("\n")[0] in text and f["remedy"] in text, f
w = next(f["data"] for f in d["findings"] if f["name"] == "wake-up")
assert w["count"] == sum(b["count"] for b in w["histogram"]) and w["count"] + w["missed"] >= 249 and w["period_us"] == 2000, w
assert 0 < w["p50_us"] <= w["p99_us"] <= w["p999_us"] <= w["max_us"], w
assert text.count("WARN ") == sum(f["level"] == "warn" for f in d["findings"]), text
END
}
claim "JSON: every finding once, with level, words, remedy and numbers; the text has the same" complete
# The command line may contain invalid UTF-8, which JSON cannot contain.
any_bytes() {
    mkdir "$work"/$'dis\xffk' && "$hexid" doctor "${quiet[@]}" --hal $'can:\xff' --log "$work"/$'dis\xffk' --json "$work/any.json" >"$work/text"
    "$python" -c 'import json, sys
found = {f["name"]: f for f in json.load(open(sys.argv[1]))["findings"]}
print(found["CAN interface"], found["log room"])
sys.exit("can:?" not in found["CAN interface"]["found"] or not found["log room"]["data"]["directory"].endswith("dis?k"))' "$work/any.json"
}
claim "bytes that are no text are no trouble for it" any_bytes
json_alone() { "$hexid" doctor "${quiet[@]}" --json - 2>/dev/null | "$python" -c 'import json, sys; json.load(sys.stdin)'; }
claim "--json -: standard output is JSON alone" json_alone

# fails NAME WORDS OPTION...: exit status 1, and a FAIL of this name with these words.
fails() {
    ends 1 "$hexid" doctor --latency 0 "${@:3}" >"$work/text"
    local status=$?
    cat "$work/text"
    ((status == 0)) && grep "^  FAIL  $1 .*$2" "$work/text"
}
no_route() { ip route del 224.0.0.0/4 dev lo && fails 'LCM socket' 'no route for multicast' --set lcm.url="$url"; }
claim "no route for multicast: FAIL, exit status 1" no_route
claim "a loop that is unstable: FAIL, with mode, frequency and damping" fails loop 'unstable at neutral: y at 18.6 Hz, damping -0.0' --set lcm.url= --set control.kp=270
claim "a directory for logs that is not there: FAIL" fails 'log room' /nowhere --set lcm.url= --log /nowhere/a.lcm
full() { # the speed trial leaves most of the free space alone
    mkdir "$work/disk" && mount -t tmpfs -o size=1m none "$work/disk" && fails 'log room' '1.05 MB free' --set lcm.url= --log "$work/disk"
    local status=$?
    umount "$work/disk"
    return $status
}
if unshare -m mount -t tmpfs none "$work" 2>/dev/null; then
    claim "a disk without room for one run: FAIL" unshare -m bash -c "$(declare -f ends fails full); hexid=$hexid work=$work; full"
else
    echo "ok - a disk without room for one run: FAIL # SKIP this user cannot mount one"
fi
claim "a machine that is no back-end: refused" refuses 2 "--hal telepathy: no such back-end" "$hexid" doctor --hal telepathy:
claim "a time that is none: refused" refuses 2 "--latency ever" "$hexid" doctor --latency ever
claim "a configuration that is none: refused, exit status 2" refuses 2 "tests.frequency_hz" "$hexid" doctor --set tests.frequency_hz=nan

# A device is asked and keeps running: it is unclaimed before and after.
modbus() {
    mkfifo "$work/plant"
    "$hexid" plant --bus modbus:tcp://127.0.0.1:0 "${quick_settings[@]}" --rt off >"$work/plant" 2>&1 &
    local plant=$! line=''
    exec 3<"$work/plant"
    until [[ $line == *'ready on '* ]]; do read -r -t 60 -u 3 line || return; done
    "$hexid" doctor "${quiet[@]}" --hal "${line##*ready on }" --json "$work/modbus.json"
    kill $plant
    wait $plant || return
    "$python" - "$work/modbus.json" <<'END'
import json, sys
found = {f["name"]: f for f in json.load(open(sys.argv[1]))["findings"]}
print(found["Modbus"])
data = found["Modbus"]["data"] # the level is not checked, because it depends on this host's clock
sys.exit(not (data["asked"] == 50 and data["lost"] < 50 and 0 < data["median_us"] <= data["max_us"]) or "another master" in found["Modbus"]["found"])
END
}
claim "a Modbus device is there: round trips of single reads" modbus
claim "one that is not: FAIL" fails Modbus 'refused' --set lcm.url= --hal modbus:tcp://127.0.0.1:1
on_own_machine "doctor on CAN" --can tests/uml/doctor_checks.sh

unwarned() { quick >"$work/text" 2>"$work/warning"; ! grep 'workspace' "$work/warning"; }
claim "a machine without one: no such warning" unwarned
