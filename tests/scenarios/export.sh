#!/bin/bash
# A whole log is exported to CSV, MATLAB and MCAP: other makers' readers find every number in it, and a failed export leaves nothing behind.
. tests/scenarios/lib

quick --log "$work/run.lcm" >"$work/run" 2>&1
quick --tests x --log "$work/x.lcm" >>"$work/run" 2>&1
env -u MAKEFLAGS -u MAKELEVEL make -s BUILD="$work/made" python-types >"$work/make" 2>&1 || cat "$work/make"

peer() { "$python" tests/scenarios/export.py "$@"; }
# formatted FORMAT LOG FILE
formatted() {
    case $1 in
    table) "$hexid" export "$2" --all -o "$3" ;;
    *) "$hexid" export "$2" --format "$1" -o "$3" ;;
    esac
}
whole() { formatted "$1" "$work/run.lcm" "$work/all.$1" && peer "$1" "$work/run.lcm" "$work/all.$1" "$work/made/python"; }
claim "a table of all cycles has every number of the log" whole table
claim "so has a .mat, read by scipy, with units, configuration and results" whole mat
claim "so has an MCAP, read by the library of PyPI: messages that fit their schemas, times, index, checksums" whole mcap
sequential() { peer opens mcap "$work/all.mcap"; }
claim "it is read from front to back, too" sequential
same_bytes() {
    formatted "$1" "$work/run.lcm" "$work/again.$1" && cmp "$work/all.$1" "$work/again.$1"
}
for format in table mat mcap; do claim "$format: the same log makes the same bytes" same_bytes $format; done

# Only `hexid export --format mat` loads HDF5, curl and their dependencies.
without() { ldd "$hexid" >"$work/libraries" && grep -q liblcm "$work/libraries" && ! grep -E 'matio|hdf5|curl|microhttpd|gnutls' "$work/libraries"; }
claim "the process that moves a machine has neither libmatio nor a web server in it" without

page() {
    mkdir -p "$work/page/build" "$work/page/runs" && ln -s "$work/made/python" "$work/page/build/python" && cp "$work/run.lcm" "$work/page/runs/a.lcm" || return 1
    sed -n '/^```python$/,/^```$/{/^```/d;p}' docs/python.md >"$work/page/page.py"
    [ "$(grep -c . "$work/page/page.py")" -eq 15 ] || { echo "not fifteen lines"; return 1; }
    (cd "$work/page" && "$python" page.py) >"$work/page.out" 2>&1 || { cat "$work/page.out"; return 1; }
    cat "$work/page.out"
    grep -qE '^x +[0-9]' "$work/page.out" && grep -qE '^psi +[0-9]' "$work/page.out"
}
claim "the fifteen lines of docs/python.md go from a log to pandas" page

# refused_and_gone FILE STATUS WORDS COMMAND...: refused, and no FILE is left.
refused_and_gone() {
    local file=$1
    shift
    refuses "$@" && [ ! -e "$file" ]
}
to() { echo "$work/never.$1"; }
claim "a format that is not there: refused, with those that are" refuses 2 "--format xls csv mat mcap" "$hexid" export "$work/x.lcm" --format xls -o "$(to xls)"
for format in mat mcap; do
    claim "$format to standard output: refused" refuses 2 "- name a file" "$hexid" export "$work/x.lcm" --format $format -o -
done
claim "--all with another format: refused" refuses 2 "--all mat" "$hexid" export "$work/x.lcm" --all --format mat -o "$(to mat)"
full() (trap '' XFSZ; ulimit -f 16; formatted "$@")
for format in table mat mcap; do
    claim "$format: a file that is there is not overwritten" refuses 3 "all.$format another" formatted $format "$work/x.lcm" "$work/all.$format"
    claim "$format: a directory that is not there: refused, naming it" refuses 3 "$work/none/" formatted $format "$work/x.lcm" "$work/none/a.$format"
    claim "$format: a log that is not there: refused, and no file made" refused_and_gone "$(to $format)" 3 "$work/none.lcm" formatted $format "$work/none.lcm" "$(to $format)"
    # A limit of the file's size simulates a full disk: the same writes fail.
    claim "$format: a disk that is full: said, and nothing left of the file" refused_and_gone "$(to $format)" 3 "never.$format written" full $format "$work/x.lcm" "$(to $format)"
done

head -c 300000 "$work/x.lcm" >"$work/cut.lcm"
: >"$work/empty.lcm"
cut() {
    rm -f "$work"/short.*
    formatted "$1" "$work/cut.lcm" "$work/short.$1" 2>"$work/error" >"$work/said"
    status=$?
    cat "$work/error" "$work/said"
    [ $status -eq 0 ] && grep -q 'cut.lcm is cut off or damaged: read up to byte' "$work/error" && grep -qE '[1-9][0-9]* cycles,' "$work/said"
}
for format in table mat mcap; do
    claim "$format: a log that is cut: written up to there, and said" cut $format
    claim "$format: a log without a cycle: refused, and no file left" refused_and_gone "$(to $format)" 3 "empty.lcm no cycle" formatted $format "$work/empty.lcm" "$(to $format)"
done

# The log has more events than a .mat can contain.
many() {
    PYTHONPATH=$work/made/python "$python" - "$work/many.lcm" <<'PY'
import sys, hexid, lcm
log, event, state = lcm.EventLog(sys.argv[1], "w"), hexid.event_t(), hexid.state_t()
event.kind, event.text = "state", "ready"
log.write_event(0, "HEXID_STATE", state.encode())
for n in range(100001):
    log.write_event(n, "HEXID_EVENT", event.encode())
PY
    refused_and_gone "$(to mat)" 3 "never.mat 100000 csv mcap" formatted mat "$work/many.lcm" "$(to mat)" &&
        formatted mcap "$work/many.lcm" "$work/many.mcap" | grep -q '100001 messages'
}
claim "a log that is too long for a .mat: refused, with what takes it" many

# Random changes to a log, inside its messages too: every output can be opened.
hostile() {
    "$python" - "$work/cut.lcm" "$work" <<'PY'
import random, sys
log, work = open(sys.argv[1], "rb").read(), sys.argv[2]
for n in range(6):
    random.seed(n)
    bytes_ = bytearray(log)
    for _ in range(4 ** n // 4 + 1):
        bytes_[random.randrange(len(bytes_))] = random.randrange(256)
    open(f"{work}/hostile{n}.lcm", "wb").write(bytes_)
PY
    for n in 0 1 2 3 4 5; do
        for format in table mat mcap; do
            formatted $format "$work/hostile$n.lcm" "$work/hostile$n.$format" >"$work/said" 2>&1
            status=$?
            ((status == 0 || status == 3)) || { echo "log $n as $format: exit status $status"; cat "$work/said"; return 1; }
            ((status == 3)) && [ -e "$work/hostile$n.$format" ] && return 1
            ((status == 3)) || [ $format = table ] || peer opens $format "$work/hostile$n.$format" || return 1
        done
    done
    [ -e "$work/hostile0.mat" ] && [ -e "$work/hostile3.mcap" ]
}
claim "logs with bytes changed: what is written opens, and nothing else is left" hostile

# Import takes every CSV file of a directory for a test.
beside() {
    "$hexid" export "$work/x.lcm" -o "$work/tests" >/dev/null && "$hexid" export "$work/x.lcm" --all -o "$work/tests/all.csv" >/dev/null &&
        refuses 2 "all.csv:1 no column t_s" "$hexid" import "$work/tests" -o "$work/never.lcm"
}
claim "a table of all cycles among the tests: import refuses it, naming it" beside
