#!/bin/bash
# Runs are exported to CSV and imported again bit for bit; missing data in a directory is reported, wrong data refused.
. tests/scenarios/lib

quick --log "$work/run.lcm" --json "$work/run.json" >"$work/run" 2>&1

there_and_back() {
    "$hexid" export "$work/run.lcm" -o "$work/csv" && "$hexid" import "$work/csv" -o "$work/back.lcm" &&
        "$hexid" export "$work/back.lcm" -o "$work/again"
}
# Compares everything except the loop's own statistics and the rest before the supply, which concern cycles outside the tests.
identified_alike() {
    "$hexid" identify "$work/back.lcm" --json "$work/back.json" >/dev/null
    "$python" -c 'import json, sys
a, b = (json.load(open(f)) for f in sys.argv[1:])
for x in a, b: x.pop("loop"), x.pop("rest", None)
sys.exit(a != b)' "$work/run.json" "$work/back.json"
}
# Files as another program writes them: only leg lengths and time, no configuration.
without_pressures() {
    mkdir "$work/lengths"
    for file in "$work"/csv/*.csv; do
        sed '/^#/!s/^\([^,]*\),\([^,]*,\)\{6\}\(\([^,]*,\)\{6\}\).*/\1,\3/; /^#/!s/,$//' "$file" >"$work/lengths/${file##*/}"
    done
    "$hexid" import "$work/lengths" -o "$work/lengths.lcm" | tee "$work/import" && grep -q 'p1_1_pa\.\.p1_6_pa' "$work/import" || return 1
    ends 1 "$hexid" identify "$work/lengths.lcm" --json "$work/lengths.json" &&
        "$python" -c 'import json, sys
v = json.load(open(sys.argv[1]))["verdict"]
print(v)
sys.exit(v["status"] == "pass")' "$work/lengths.json"
}
wrong_rate() {
    sed -i 's/^# rate_hz: .*/# rate_hz: 400/' "$work/lengths/2_y.csv"
    refuses 2 "2_y.csv:2 rate_hz: 400" "$hexid" import "$work/lengths" -o "$work/none.lcm" && [ ! -e "$work/none.lcm" ]
}

without_lengths() {
    mkdir "$work/blind"
    sed '/^#/!s/^\(\([^,]*,\)\{7\}\)\([^,]*,\)\{6\}/\1/' "$work/csv/1_x.csv" >"$work/blind/1_x.csv"
    "$hexid" import "$work/blind" -o "$work/blind.lcm" 2>&1 | tee "$work/import" && grep -q 'warning: a file lacks lengths' "$work/import" &&
        "$hexid" export "$work/run.lcm" -o "$work/configured" >/dev/null &&
        refuses 2 "no sample has the lengths of all legs" "$hexid" gap --measured "$work/blind.lcm" -c "$work/configured/config.yaml" -o "$work/gap"
}

# stated_hz JSON: prints the frequencies that check reads in the files.
stated_hz() { "$python" -c 'import json, sys
print(*(t["stated_hz"] for t in json.load(open(sys.argv[1]))["tests"]))' "$1"; }
# One file states 5 Hz while the configuration has the default, 4 Hz; then two files of one axis state different frequencies.
own_frequency() {
    mkdir "$work/own" "$work/two"
    sed 's/^# frequency_hz: .*/# frequency_hz: 5/' "$work/csv/3_z.csv" >"$work/own/1.csv"
    sed 's/^# frequency_hz: .*/# frequency_hz: 3/' "$work/csv/3_z.csv" >"$work/two/1.csv"
    sed 's/^# amplitude: .*/# amplitude: 0.003/' "$work/own/1.csv" >"$work/two/2.csv"
    sed '/^# frequency_hz\|^# amplitude/d' "$work/csv/3_z.csv" >"$work/two/3.csv" # takes the configuration's, which is the first file's
    cp "$work/csv/config.yaml" "$work/four.yaml"
    for of in own two; do "$hexid" import "$work/$of" -c "$work/four.yaml" -o "$work/$of.lcm" || return 1; done
    "$hexid" export "$work/two.lcm" -o "$work/two_again"
    [ "$(sed -n 's/^# frequency_hz: //p' "$work"/two_again/*.csv | xargs)" = "3 5 3" ] || return 1
    sed -n 's/^# amplitude: //p' "$work"/two_again/*.csv | xargs | tee /dev/stderr | grep -qx "0.004 0.003 0.004" || return 1
    local of expected
    for of in own=5.0 "two=3.0 5.0 3.0"; do
        expected=${of#*=} of=${of%%=*}
        for from in "$work/$of" "$work/$of.lcm"; do
            "$hexid" check "$from" -c "$work/four.yaml" --json "$work/own.json" >"$work/own.out" 2>&1
            echo "$from: $(stated_hz "$work/own.json"), expected $expected"
            [ "$(stated_hz "$work/own.json")" = "$expected" ] || return 1
        done
    done
}
# The command line has priority, and one line reports that.
set_wins() {
    for from in "$work/own" "$work/own.lcm"; do
        "$hexid" check "$from" -c "$work/four.yaml" --set tests.frequency_hz=6 --json "$work/own.json" >"$work/own.out" 2>&1
        cat "$work/own.out"
        [ "$(stated_hz "$work/own.json")" = 6.0 ] && [ "$(grep -c -e '--set is taken, not what a file states: .*: frequency_hz 5$' "$work/own.out")" = 1 ] ||
            return 1
    done
}

# tests_of JSON KEY: prints a value of each test of an identification.
tests_of() { "$python" -c 'import json, sys
print(*(t[sys.argv[2]] for t in json.load(open(sys.argv[1]))["tests"]))' "$@"; }
printf 'tests:\n  frequency_hz: 5\n  amplitude_m: 0.0015\n  amplitude_rad: 0.002\n  ramp_s: 0.5\n  duration_s: 2\n' >"$work/other.yaml"
# alike A B: two results of identify are the same.
alike() { diff "$1" "$2" >&2 && [ -s "$1" ]; }
# A configuration of the same machine with other tests changes nothing, in a log of hexid and in an imported one.
own_tests() {
    for log in run back; do
        "$hexid" identify "$work/$log.lcm" --json "$work/own.json" >/dev/null
        "$hexid" identify "$work/$log.lcm" -c "$work/other.yaml" --json "$work/with.json" >/dev/null
        alike "$work/own.json" "$work/with.json" || return 1
        for with in own with; do
            [ $with = own ] && set -- || set -- -c "$work/other.yaml"
            "$hexid" check "$work/$log.lcm" "$@" --json "$work/check_$with.json" >/dev/null
            "$hexid" report "$work/$log.lcm" "$@" -o "$work/page_$with.html" >/dev/null
            sed -i '/<pre>/,$d' "$work/page_$with.html" # the configuration that it was given comes last
        done
        alike "$work/check_own.json" "$work/check_with.json" && alike "$work/page_own.html" "$work/page_with.html" || return 1
    done
}
# An import without a configuration of files whose heads state neither frequency nor amplitude: the log states none, and -c does.
stated_by_no_one() {
    mkdir "$work/bare"
    for file in "$work"/csv/*.csv; do sed '/^# \(frequency_hz\|amplitude\)/d' "$file" >"$work/bare/${file##*/}"; done
    "$hexid" import "$work/bare" -o "$work/bare.lcm" >/dev/null && "$hexid" import "$work/bare" -c "$work/csv/config.yaml" -o "$work/stated.lcm" >/dev/null
    "$hexid" identify "$work/bare.lcm" -c "$work/other.yaml" --json "$work/bare.json" >/dev/null
    "$hexid" identify "$work/stated.lcm" -c "$work/other.yaml" --json "$work/stated.json" >/dev/null
    "$hexid" export "$work/bare.lcm" -o "$work/bare_again" >/dev/null && ! grep '^# frequency_hz\|^# amplitude' "$work"/bare_again/*.csv || return 1
    tests_of "$work/bare.json" frequency_hz | tee /dev/stderr | grep -qx "5.0 5.0 5.0 5.0 5.0 5.0" &&
        tests_of "$work/bare.json" amplitude | grep -qx "0.0015 0.0015 0.0015 0.002 0.002 0.002" &&
        tests_of "$work/stated.json" frequency_hz | tee /dev/stderr | grep -qx "4.0 4.0 4.0 4.0 4.0 4.0"
}
# --set at import has priority over every key of the heads, and says which it left out.
set_at_import() {
    rm "$work"/bare/*
    cp "$work"/csv/[0-9]*.csv "$work/bare"
    "$hexid" import "$work/bare" -c "$work/csv/config.yaml" --set tests.amplitude_m=0.003 --set tests.settle_s=1 -o "$work/set.lcm" >"$work/said" 2>&1
    cat "$work/said"
    grep -q -e '--set is taken, not what a file states: 1_x.csv: amplitude 0.004, settle_s 0.2; 2_y.csv' "$work/said" || return 1
    "$hexid" identify "$work/set.lcm" --json "$work/set.json" >/dev/null
    [ "$(tests_of "$work/set.json" amplitude)" = "0.003 0.003 0.003 0.006 0.006 0.006" ]
}
# --set is explicit, and has priority over the log's own tests and over -c.
set_above_all() {
    "$hexid" identify "$work/back.lcm" -c "$work/other.yaml" --set tests.amplitude_m=0.003 --json "$work/set.json" >/dev/null
    tests_of "$work/set.json" amplitude | tee "$work/amplitudes"
    [ "$(cat "$work/amplitudes")" = "0.003 0.003 0.003 0.006 0.006 0.006" ] && [ "$(tests_of "$work/set.json" frequency_hz)" = "4.0 4.0 4.0 4.0 4.0 4.0" ]
}
# What -o writes has no influence on the tests of another log, and holds the tests of -c, not those of the log.
written_tests() {
    "$hexid" identify "$work/run.lcm" -o "$work/machine.yaml" >/dev/null
    quick --set tests.frequency_hz=3 --set tests.amplitude_rad=0.004 --log "$work/slow.lcm" --json "$work/slow.json" >/dev/null 2>&1
    "$hexid" identify "$work/slow.lcm" --json "$work/own.json" >/dev/null
    "$hexid" identify "$work/slow.lcm" -c "$work/machine.yaml" --json "$work/with.json" -o "$work/again.yaml" >/dev/null
    alike "$work/own.json" "$work/with.json" && [ "$(tests_of "$work/with.json" frequency_hz)" = "3.0 3.0 3.0 3.0 3.0 3.0" ] &&
        diff <(sed '/^found:/,/^$/d' "$work/machine.yaml") <(sed '/^found:/,/^$/d' "$work/again.yaml")
}

claim "a run goes to CSV and back" there_and_back
claim "to the same CSV, byte for byte" diff -r "$work/csv" "$work/again"
claim "and to the same identification" identified_alike
claim "a file's own frequency_hz and amplitude win over the configuration, in import and in check" own_frequency
claim "the tests of a log, its amplitudes, too, stand above -c in identify, check and report" own_tests
claim "what no one stated at import, -c states" stated_by_no_one
claim "--set stands above the heads in import, and says so" set_at_import
claim "--set tests. stands above the log and -c" set_above_all
claim "what identify -o writes does not change the tests of another log" written_tests
claim "tests.frequency_hz of --set wins over both, and says so" set_wins
claim "without pressures it is read, what is missing is named, and nothing is passed" without_pressures
claim "without lengths import warns, and gap says so" without_lengths
claim "a rate that is not that of the rows is refused" wrong_rate
claim "an export into a directory with CSV files is refused" refuses 3 "$work/csv" "$hexid" export "$work/run.lcm" -o "$work/csv"
claim "a directory without CSV files is refused" refuses 2 "$work has no CSV" "$hexid" import "$work" -o "$work/none.lcm"
# Names with terminal control codes: of a file, a column, a key, and a bad value.
escape=$'\033[2J\a\302\233'
hostile() {
    mkdir -p "$work/hostile"
    { echo "# dof: x"; echo "# ${escape}: 1"; echo "# rate_hz: 1000"; echo "t_s,l1_m,${escape}"; for n in 0 1 2 3 4 5 6 7 8 9; do echo "0.00$n,1.8,1"; done; } \
        >"$work/hostile/1_${escape}.csv"
    "$hexid" import "$work/hostile" -o "$work/hostile.lcm" >"$work/said" 2>&1
    { echo "# dof: ${escape}"; echo "t_s"; } >"$work/hostile/1_${escape}.csv"
    "$hexid" import "$work/hostile" -o "$work/hostile.lcm" >>"$work/said" 2>&1
    "$hexid" identify "$work/$escape.lcm" >>"$work/said" 2>&1
    "$hexid" gap -c "$work/$escape.yaml" -o "$work/gap" --measured "$work/$escape.lcm" >>"$work/said" 2>&1
    "$hexid" export "$work/$escape.lcm" -o "$work/csv2" >>"$work/said" 2>&1
    cat -v "$work/said"
    [ "$(grep -c '?\[2J' "$work/said")" -ge 4 ] && ! LC_ALL=C grep -q $'[\001-\010\013-\037\177\233]' "$work/said"
}
claim "names that a terminal would obey are printed as text" hostile
claim "a log on a full disk is an I/O error" refuses 3 "/dev/full" "$hexid" import "$work/csv" -o /dev/full
