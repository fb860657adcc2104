#!/bin/bash
# No input file and no recording is ever overwritten, whatever the option and however the file is named.
. tests/scenarios/lib
skip_under tsan "outputs" "one thread"

# Short runs; lcm.url is empty, so that nothing needs a network.
short=(--fast --set sim.engine=closed_form --set lcm.url= --tests z --set tests.duration_s=0.5 --set motion.hold_s=0.1)
run() { "$hexid" run "${short[@]}" "$@"; }
files=$work/files
mkdir -p "$files/csv" "$files/logs" "$files/new" "$work/links"
for log in a b; do run --log "$files/$log.lcm" >"$work/said" 2>&1 || [ $? -eq 1 ] || cat "$work/said"; done # one test yields no matrix
"$hexid" run --print-config >"$files/rig.yaml"
"$hexid" export "$files/a.lcm" -o "$files/csv" >"$work/said"
"$hexid" export "$files/a.lcm" --all -o "$files/all.csv" >"$work/said"
"$hexid" export "$files/a.lcm" --format mcap -o "$files/all.mcap" >"$work/said"
"$hexid" export "$files/a.lcm" --format mat -o "$files/all.mat" >"$work/said"
cp "$files/b.lcm" "$files/logs/2026-01-01T00-00-00Z.lcm"
printf 't_s,ref_z_m\n0,0\n1,0.001\n2,0\n' >"$files/way.csv"
printf 'Zeit;Weg\n0,1;2,5\n' >"$files/stand.csv"

state() { (cd "$files" && find . -type f | sort | xargs cksum); }
state >"$work/before"
# untouched: the files are the same as before, and there is no new one.
untouched() { state | diff "$work/before" - && [ "$(find "$work" -name '.hexid-*' | wc -l)" -eq 0 ]; }

# spelled HOW FILE: another name of the same file.
spelled() {
    local link=$work/links/link
    rm -f "$link"
    case $1 in
    plain) echo "$2" ;;
    dots) echo "$(dirname "$2")/./../$(basename "$(dirname "$2")")//$(basename "$2")" ;;
    symbolic) ln -s "$2" "$link" && echo "$link" ;;
    twice) ln -s "$2" "$link.2" 2>/dev/null || ln -sf "$2" "$link.2"; ln -s link.2 "$link" && echo "$link" ;;
    hard) ln "$2" "$link" && echo "$link" ;;
    folder) rm -rf "$work/links/folder" && ln -s "$(dirname "$2")" "$work/links/folder" && echo "$work/links/folder/$(basename "$2")" ;;
    descriptor) echo /proc/self/fd/9 ;;
    esac
}

# Table of the endangered file (@) and the command that would overwrite it. The message contains the file's name or the output's.
table=(
    "a.lcm|check $files/a.lcm -o @"
    "a.lcm|check $files/a.lcm --json @"
    "b.lcm|check $files/a.lcm $files/b.lcm -o @"
    "b.lcm|check $files/a.lcm -o @"
    "rig.yaml|check $files/a.lcm -c $files/rig.yaml --json @"
    "csv/1_z.csv|check $files/csv -o @"
    "csv/config.yaml|check $files/csv -o @"
    "csv/1_z.csv|check $files/csv/1_z.csv --json @"
    "a.lcm|identify $files/a.lcm --json @"
    "b.lcm|identify $files/a.lcm --json @"
    "rig.yaml|identify $files/a.lcm -c $files/rig.yaml --json @"
    "b.lcm|report $files/a.lcm -o @"
    "a.lcm|report $files/a.lcm $files/b.lcm -o @"
    "rig.yaml|report $files/a.lcm -c $files/rig.yaml -o @"
    "all.mcap|report $files/a.lcm -o @"
    "all.mat|report $files/a.lcm -o @"
    "all.csv|report $files/a.lcm -o @"
    "stand.csv|report $files/a.lcm -o @"
    "rig.yaml|gap --measured $files/a.lcm -c $files/rig.yaml -o $work/gap --json @"
    "a.lcm|gap --measured $files/a.lcm -c $files/rig.yaml -o $work/gap --json @"
    "b.lcm|gap --measured $files/a.lcm --validate $files/b.lcm -c $files/rig.yaml -o $work/gap --json @"
    "csv/1_z.csv|import $files/csv -o @"
    "csv/config.yaml|import $files/csv -o @"
    "stand.csv|import $files/csv -o @"
    "all.mcap|import $files/csv -o @"
    "rig.yaml|import $files/csv/1_z.csv -c $files/rig.yaml -o @"
    "a.lcm|export $files/a.lcm --all -o @"
    "a.lcm|export $files/a.lcm --format mcap -o @"
    "rig.yaml|run ${short[*]} -c $files/rig.yaml --log @"
    "rig.yaml|run ${short[*]} -c $files/rig.yaml --json @"
    "b.lcm|run ${short[*]} --json @"
    "all.mat|run ${short[*]} --json @"
    "all.mcap|run ${short[*]} --log @"
    "stand.csv|run ${short[*]} --log @"
    "way.csv|run --fast --set lcm.url= --trajectory $files/way.csv --json @"
    "way.csv|run --fast --set lcm.url= --trajectory $files/way.csv --log @"
    "b.lcm|doctor --latency 0 --json @"
    "b.lcm|effects --json @"
)
# refused HOW FILE COMMAND: status 2 with one line that names the output; nothing has changed.
refused() {
    local name command
    name=$(spelled "$1" "$files/$2")
    read -ra command <<<"${3//@/$name}"
    refuses 2 "$name" "$hexid" "${command[@]}" 9>>"$files/$2" >"$work/said" && untouched
}
all_refused() {
    local row bad=0
    for row in "${table[@]}"; do
        refused "$1" "${row%%|*}" "${row#*|}" || { echo "^^ ${row#*|} ($1 ${row%%|*})"; bad=1; }
    done
    ((!bad))
}
claim "${#table[@]} commands that would write over a recording or what they read: refused, status 2, nothing moved" all_refused plain
some=("${table[@]}") table=()
for row in 0 6 8 11 13 18 21 27 28 30 34; do table+=("${some[row]}"); done
for how in dots symbolic twice hard folder descriptor; do
    claim "the same by another name of the file ($how)" all_refused $how
done

both() { refuses 2 "--log --json $work/new.lcm one file" run --log "$work/new.lcm" --json "$1" && [ ! -e "$work/new.lcm" ]; }
claim "two options with one file that is not there yet: refused" both "$work/new.lcm"
ln -s . "$work/same"
claim "also by two names" both "$work/same/../$(basename "$work")/new.lcm"
page_and_json() { refuses 2 "--json -o one file" "$hexid" check "$files/a.lcm" -o "$work/x.html" --json "$work/x.html" && untouched; }
claim "page and JSON in one file: refused" page_and_json
printed() { refuses 2 "standard output a.lcm" bash -c '"$1" identify "$2" >>"$2"' - "$hexid" "$files/a.lcm" && untouched; }
claim "standard output into the log that is read: refused" printed
standard_input() { refuses 2 "/dev/stdin $files/a.lcm" "$hexid" identify /dev/stdin --json "$files/a.lcm" <"$files/a.lcm" && untouched; }
claim "the log is /dev/stdin: the same" standard_input

cp "$files/rig.yaml" "$files/new/model.yaml" && mkdir "$work/gaps" && cp "$files/rig.yaml" "$work/gaps/model.yaml" && state >"$work/before"
own_model() { refuses 2 "-o $work/gaps/model.yaml configuration" "$hexid" gap --measured "$files/a.lcm" -c "$work/gaps/model.yaml" -o "$work/gaps" && cmp "$files/rig.yaml" "$work/gaps/model.yaml"; }
claim "gap into the directory whose model.yaml it reads: refused" own_model
in_directory() { refuses 2 "-o $1 recordings" "$hexid" "${@:2}" -o "$1" && untouched; }
claim "gap into a directory with recordings: refused, naming one" in_directory "$files" gap --measured "$files/a.lcm" -c "$files/rig.yaml"
claim "export into the log's directory: refused, naming one" in_directory "$files/logs" export "$files/logs/2026-01-01T00-00-00Z.lcm"

# Results replace results.
again() {
    local page=$work/page.html
    ends 1 "$hexid" report "$files/a.lcm" -o "$page" >/dev/null && cp "$page" "$work/first.html" && ln -sf page.html "$work/link.html" &&
        ends 1 "$hexid" report "$files/b.lcm" -o "$work/link.html" >"$work/said" && ! cmp -s "$page" "$work/first.html" && [ -L "$work/link.html" ] && untouched
}
claim "a page takes the place of an earlier page, through a link, which stays" again
no_room() {
    cp "$work/first.html" "$work/page.html"
    (trap '' XFSZ; ulimit -f 4; refuses 3 "page.html earlier" "$hexid" report "$files/b.lcm" -o "$work/page.html" >"$work/said") &&
        cmp "$work/first.html" "$work/page.html" && untouched
}
claim "a disk that is full: the earlier page is left, whole" no_room
in_place() {
    ends 1 run --json /dev/null >/dev/null && ends 1 run --log /dev/null >/dev/null && [ -c /dev/null ] &&
        "$hexid" identify "$files/a.lcm" --json /dev/stdout 2>/dev/null | grep -q '"schema": "hexid.identification/1"' &&
        ends 1 "$hexid" identify "$files/a.lcm" --json /dev/stdout >"$work/out" && grep -q '"schema"' "$work/out" && grep -q '^verdict' "$work/out" &&
        ends 1 "$hexid" identify "$files/a.lcm" --json - 2>/dev/null >"$work/out" && grep -q '"schema"' "$work/out"
}
claim "/dev/null, /dev/stdout and - are written in place" in_place
fifo() {
    mkfifo "$work/fifo"
    refuses 3 "fifo FIFO reader" timeout 60 "$hexid" run "${short[@]}" --json "$work/fifo" >"$work/said" || return 1
    cat "$work/fifo" >"$work/read" & local reader=$!
    ends 1 run --json "$work/fifo" >"$work/said" && wait $reader && grep -q hexid.identification/1 "$work/read"
}
claim "a FIFO for a result: refused where nobody reads it, else written" fifo

# An existing log is set aside, by run and by import; a line reports it.
aside() {
    cp "$files/a.lcm" "$work/d.lcm" && ln -sf d.lcm "$work/e.lcm"
    for log in d.lcm d.lcm e.lcm; do ends 1 run --log "$work/$log" >"$work/said" 2>"$work/error" || return 1; done
    cat "$work/error"
    grep -q "e.lcm: the log that was there is now .*d.lcm.3" "$work/error" && cmp "$files/a.lcm" "$work/d.lcm.1" && [ -L "$work/e.lcm" ] &&
        cmp "$work/d.lcm" "$work/d.lcm.3" && "$hexid" import "$files/csv" -o "$work/d.lcm" 2>&1 | grep 'now .*d.lcm.4' && untouched
}
claim "an earlier log is set aside: a.lcm.1, .2, and so on, and a line says so" aside

# Two daemons, one log. The second is refused while the first goes on to its end.
mkfifo "$work/lines"
# while_running COMMAND...: runs it once the platform moves; then the run is interrupted if `interrupts` is 1. Sets run_status.
while_running() {
    local line status
    "$hexid" run --rt off --set sim.engine=closed_form --set lcm.url= --log "$work/f.lcm" >"$work/lines" 2>"$work/run_error" &
    local run=$!
    exec 3<"$work/lines"
    while read -r -t 60 -u 3 line; do [[ $line =~ engaging ]] && break; done
    "$@"
    status=$?
    ((interrupts)) && kill -INT $run
    cat <&3 >"$work/run_said"
    wait $run
    run_status=$?
    cat "$work/run_said" "$work/run_error"
    return $status
}
interrupts=1
one_writer() {
    while_running refuses 3 "f.lcm another process writes this log" run --log "$work/f.lcm" && [ $run_status -eq 1 ] && [ ! -e "$work/f.lcm.1" ] &&
        grep -q ' 0 records lost' "$work/run_said" && "$hexid" export "$work/f.lcm" --all -o "$work/f.csv" | grep ' 0 cycles lost'
}
claim "a second writer of a log is refused, and the first loses nothing" one_writer
# The run ends by itself, parked, with status 3.
interrupts=0
happens() {
    rm -f "$work"/f.lcm*
    while_running eval "$1" && [ $run_status -eq 3 ] && grep -q "f.lcm: $2 while it was written.*parking" "$work/run_error" &&
        grep -q '^  parking' "$work/run_said" && grep -Eq ' [1-9][0-9]* records lost' "$work/run_said"
}
claim "a log that is deleted while it is written: parked, status 3, its records are lost" happens "rm '$work/f.lcm'" "was deleted"
claim "one that is renamed: the same" happens "mv '$work/f.lcm' '$work/g.lcm'" "was renamed or replaced"
claim "one that is cut: the same" happens ": >'$work/f.lcm'" "was cut"
lost() {
    rm -f "$work"/f.lcm*
    (trap '' XFSZ; ulimit -f 300; ends 3 run --log "$work/f.lcm" >"$work/said" 2>&1) || { cat "$work/said"; return 1; }
    "$python" - "$work/said" "$work/f.lcm" <<'END'
import re, sys, lcm
said = open(sys.argv[1]).read()
cycles, lost = map(int, re.search(r"loop +(\d+) cycles.* (\d+) records lost", said).groups())
log, kept = open(sys.argv[2], "rb").read(), 0
at = 0
while at + 28 <= len(log):
    channel, size = (int.from_bytes(log[at + 20 + i:at + 24 + i], "big") for i in (0, 4))
    end = at + 28 + channel + size
    if end <= len(log) and log[at + 28:at + 28 + channel] == b"HEXID_STATE": kept += 1
    at = end
print(cycles, "cycles", kept, "in the log", lost, "lost")
sys.exit(not (lost and cycles == kept + lost))
END
}
# Names with terminal control codes.
obeyed() {
    local name=$work/$'a\033]0;owned\007\033[2J.lcm'
    { ends 1 run --log "$name" && ends 1 run --log "$name" && "$hexid" export "$name" -o "$work/o" && ends 2 "$hexid" report "$name" -o "$name" &&
        ends 1 "$hexid" identify "$name" && ends 1 "$hexid" report "$name" -o "$name.html"; } >"$work/said" 2>&1
    local status=$?
    cat -v "$work/said"
    ((status == 0)) && [ "$(grep -c 'a?]0;owned??\[2J.lcm' "$work/said")" -ge 5 ] && ! grep -q $'[\033\007]' "$work/said"
}
claim "escape sequences in a log's own name are shown as text" obeyed
claim "a disk that fills up: the records that are lost are counted, to the last" lost
