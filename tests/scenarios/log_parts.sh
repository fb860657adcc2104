#!/bin/bash
# A log in parts: together they are the log of the run, each is a valid log; a quota deletes earlier runs but never the present one.
. tests/scenarios/lib
logs=$work/logs
fresh() { rm -rf "$logs" && mkdir "$logs"; }
quick_settings+=(--set tests.duration_s=1.6) # method C needs six cycles
quick=("$hexid" run --hal sim: --fast "${quick_settings[@]}")

motion() {
    fresh && quick --set tests.multisine=true --set tests.duration_s=12 --log "$work/motion.lcm" --json "$work/motion.json" >/dev/null
    quick --set tests.multisine=true --set tests.duration_s=12 --log "$logs" --log-part 0.0005 >/dev/null
    ls -l "$logs" && ! [ "$(find "$logs" -size +1100k)" ] && cat "$logs"/*.lcm >"$work/joined.lcm" &&
        "$hexid" identify "$work/joined.lcm" --json "$work/joined.json" >/dev/null && "$hexid" identify "$work/motion.lcm" --json "$work/again.json" >/dev/null &&
        cmp "$work/joined.json" "$work/again.json"
}
if [ -n "${MORE_CASES:-}" ]; then # make test-long
    claim "a motion that does not end is cut at twice the size" motion
    exit
fi

quick --seed 7 --log "$work/whole.lcm" --json "$work/whole.json" >"$work/said"
together() {
    fresh && quick --seed 7 --log "$logs" --log-part 0.0005 --json "$work/parts.json" >"$work/said" || { cat "$work/said"; return 1; }
    ls -l "$logs" && grep -E '^log .*Z\.0001\.lcm to .*Z\.0007\.lcm, 7 parts$' "$work/said" && cmp "$work/whole.json" "$work/parts.json" &&
        cat "$logs"/*.lcm >"$work/joined.lcm" && "$hexid" identify "$work/joined.lcm" --json "$work/joined.json" >/dev/null &&
        "$hexid" identify "$work/whole.lcm" --json "$work/again.json" >/dev/null && cmp "$work/joined.json" "$work/again.json" &&
        "$hexid" export "$work/joined.lcm" -o "$work/joined" && "$hexid" export "$work/whole.lcm" -o "$work/whole" && diff -r "$work/joined" "$work/whole"
}
claim "joined by cat, the parts are the log of the run: the same result to the last bit, the same CSV" together
two_runs() { quick --seed 8 --set payload.mass_kg=160 --log "$work/other.lcm" >/dev/null && cat "$work/whole.lcm" "$work/other.lcm" >"$work/two.lcm" &&
    refuses 3 "two.lcm two configurations two runs" "$hexid" export "$work/two.lcm" -o "$work/two"; }
claim "logs of two configurations, joined, are no log of a run" two_runs
# Uses LCM's own reader.
each() {
    lcm-gen -p --ppath "$work" lcmtypes/*.lcm
    PYTHONPATH=$work "$python" - "$logs"/*.lcm <<'END'
import hexid, lcm, os, sys
cycles, tests, config = [], [], None
for number, path in enumerate(sys.argv[1:], 1):
    events = list(lcm.EventLog(path, "r"))
    begin = [hexid.event_t.decode(e.data) for e in events[:2] if e.channel == "HEXID_EVENT"]
    assert begin[0].kind == "config" and (config is None or begin[0].text == config), path
    assert number == 1 or (begin[1].kind, begin[1].text) == ("part", str(number)), path
    config = begin[0].text
    states = [hexid.state_t.decode(e.data) for e in events if e.channel == "HEXID_STATE"]
    cycles += [s.seq for s in states]
    tests.append({s.test for s in states} - {-1})
    print(path, len(states), "cycles, tests", tests[-1])
assert cycles == list(range(cycles[0], cycles[0] + len(cycles))), "a cycle is lost or there twice"
whole = sorted(t for part in tests for t in part) == list(range(6))
assert whole or os.environ.get("MAY_CUT"), "a test is cut"
END
}
claim "each begins with the configuration; no cycle is lost or there twice, no test is cut" each
apart() {
    local path known=0
    for path in "$logs"/*.lcm; do
        "$hexid" identify "$path" --json "$work/part.json" >/dev/null
        known=$((known + $("$python" -c 'import json, sys; print(len(json.load(open(sys.argv[1]))["tests"]))' "$work/part.json")))
    done
    echo "$known tests"
    [ $known -eq 6 ] && ends 0 "$hexid" identify "$logs"/*.000[1-6].lcm
}
claim "hexid identify takes each by itself, and those that have tests as several logs of one machine" apart
names_it() { refuses 2 "0007.lcm leave it out" "$hexid" identify "$logs"/*.lcm; }
claim "a part without a test is named where it is given with others" names_it
repeated() {
    mv "$logs" "$work/before" && fresh && quick --seed 7 --log "$logs" --log-part 0.0005 >/dev/null &&
        for i in 1 2 3 4 5 6 7; do cmp "$work/before"/*.000$i.lcm "$logs"/*.000$i.lcm || return; done
}
claim "the same seed gives the same parts, byte for byte" repeated

room() {
    local status
    fresh && for i in 1 2 3; do head -c 1000000 /dev/zero >"$logs/2026-01-0${i}T00-00-00Z.lcm" && touch -d "2026-01-0$i" "$logs/2026-01-0${i}T00-00-00Z.lcm"; done
    ends 0 quick --log "$logs" --log-quota 0.0035 --log-part 0.0005 >"$work/said" 2>&1
    status=$?
    cat "$work/said" && ls -l "$logs" && ((status == 0)) && [ "$(ls "$logs" | grep -c 2026-01)" -eq 0 ] && [ "$(ls "$logs" | wc -l)" -eq 7 ] &&
        [ "$(grep -c 'take more than --log-quota: nothing of them is deleted' "$work/said")" -eq 1 ]
}
claim "earlier runs make room while this one goes on; what alone is over the quota is not deleted, and that is said once" room

# A file system with room for one more file.
no_file() {
    local status
    fresh && mount -t tmpfs -o nr_inodes=2 none "$logs" && ends 0 "${quick[@]}" --log "$logs" --log-part 0.0005 --json "$work/parts.json" >"$work/said" 2>&1
    status=$?
    cat "$work/said"
    ls -l "$logs"
    "$hexid" identify "$logs"/*.lcm --json "$work/joined.json" >/dev/null
    umount "$logs"
    ((status == 0)) && grep 'no new part of the log: .*0002.lcm: cannot be created: No space' "$work/said" && "$hexid" identify "$work/whole.lcm" --json "$work/again.json" >/dev/null
}
if unshare -m mount -t tmpfs none "$work" 2>/dev/null; then
    claim "where no part can be made, that is said, and the log goes on in the one at hand" \
        unshare -m bash -c "$(declare -f fresh ends no_file); $(declare -p quick); hexid=$hexid work=$work logs=$logs; no_file"
else
    echo "ok - where no part can be made, that is said, and the log goes on in the one at hand # SKIP this user cannot mount"
fi

# keepers: this program's processes that work in this scenario's directory, including the run's own helper.
keepers() { grep -lz -- "${logs%s}[s]" /proc/[0-9]*/cmdline 2>/dev/null | wc -l; } # excludes itself
mkfifo "$work/lines"
killed() {
    local line run
    fresh
    "$hexid" run --hal sim: --rt off "${quick_settings[@]}" --log "$logs" --log-part 0.0005 >"$work/lines" 2>&1 &
    run=$!
    while read -r line; do
        [[ $line != *'test 1/6'* ]] || { [ "$(keepers)" -eq 2 ] || echo "not two processes"; kill -KILL $run; }
    done <"$work/lines" >"$work/read"
    wait $run
    ! grep 'not two' "$work/read" || return
    for _ in {1..300}; do [ "$(keepers)" -gt 0 ] || return 0; sleep 0.1; done
    return 1
}
claim "a daemon that is killed leaves no process behind" killed
# A loaded host may create a part late, and at twice its size a test is split (recorder.c).
by_the_clock() {
    fresh && ends 0 "$hexid" run --hal sim: --rt off "${quick_settings[@]}" --log "$logs" --log-part 0.0005 --json "$work/clock.json" >"$work/said" 2>&1 || { cat "$work/said"; return 1; }
    ls -l "$logs" && MAY_CUT=yes each
}
claim "by the clock, where nobody waits for a part: no cycle is lost or there twice" by_the_clock
# The process that makes the parts is stopped, as on a disk that hangs. It may have made the next one by then, which stays empty.
hangs() {
    local line run keeper status
    fresh
    "$hexid" run --hal sim: --rt off "${quick_settings[@]}" --log "$logs" --log-part 0.0005 >"$work/lines" 2>"$work/error" &
    run=$!
    exec 3<"$work/lines"
    while read -r -t 60 -u 3 line; do [[ $line =~ engaging ]] && break; done
    keeper=$(cat /proc/$run/task/$run/children)
    kill -STOP $keeper
    cat <&3 >"$work/said"
    wait $run
    status=$?
    kill -CONT $keeper
    kill -KILL $keeper 2>/dev/null
    cat "$work/said" "$work/error"
    ls -l "$logs"
    ((status == 3)) && grep -q 'warning: the process that makes the parts of the log does not answer: the log goes on in' "$work/error" &&
        grep -q ' 0 records lost' "$work/said" && [ "$(find "$logs" -size +0 -name '*.lcm' | wc -l)" -eq 1 ] &&
        ends 0 "$hexid" identify "$(find "$logs" -size +0 -name '*.lcm')"
}
claim "a process for the parts that hangs: said, the log goes on whole, status 3" hangs
claim "parts without a directory are refused" refuses 2 "--log-part DIR" quick --log "$work/x.lcm" --log-part 1
claim "a size that is none is refused" refuses 2 "--log-part 0" quick --log "$logs" --log-part 0
