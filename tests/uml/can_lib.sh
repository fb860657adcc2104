# Sourced, after tests/scenarios/lib, by what tests/uml/can runs.

# until_in PATTERN FILE PID: waits until the file has such a line; false when the process ends before.
mkfifo "$work/nothing"
exec 9<>"$work/nothing"
until_in() {
    until grep -qs -- "$1" "$2"; do
        kill -0 "$3" || return
        read -rt 0.01 -u 9 || true # no process is started for it
    done
} 2>/dev/null

# plant_start OPTION...: the plant on vcan0, ready when this returns.
plant_start() {
    "$hexid" plant --bus can:vcan0 "$@" >"$work/plant" 2>&1 &
    plant=$!
    until_in ready "$work/plant" $plant
}
plant_kill() { kill -KILL $plant; }
plant_stop() {
    kill "$@" $plant
    wait $plant
} 2>/dev/null

# What this machine does to real time is witnessed, not guessed.
"$python" tests/uml/stalls.py >"$work/stalls" &
witness=$!
trap 'kill $witness; rm -rf "$work"' EXIT
until_in ready "$work/stalls" $witness || exit 3

# stalled SINCE_US [MS]: the machine stood still since then, for as long or longer.
stalled() {
    awk -v since="$1" -v ms="${2:-5}" '$1 >= since && $2 >= ms { n++; if ($2 > worst) worst = $2 }
        END { if (n) print "the machine stood still " n " times, for up to " worst " ms"; exit !n }' "$work/stalls"
}

# fair_claim TEXT COMMAND...: like claim; but where the command fails and the machine stood still meanwhile (for still_ms, 5, or longer), or the
# run ended before what was to be done to it, once more, three times at most, or until patience is at its end. After a stall in the last try,
# too, the claim is skipped. Nothing excuses a crash or a wrong identification.
patience_s=400
fair_claim() {
    local text=$1 since stall try
    shift
    for try in 1 2 3; do
        since=${EPOCHREALTIME/./}
        "$@" >"$work/claim.out" 2>&1 && { echo "ok - $text"; return; }
        stall=$(stalled "$since" "${still_ms:-5}")
        grep -qE 'silently wrong|exit status 1[2-9][0-9]' "$work/claim.out" && stall= && break
        [ -n "$stall" ] || grep -q 'the run ended before' "$work/claim.out" || break
        sed 's/^/# again: /' "$work/claim.out"
        echo "# again: $stall"
        ((SECONDS < patience_s)) || break
    done
    if [ -n "$stall" ]; then
        echo "ok - $text # SKIP $stall, in the last of $try tries"
    else
        echo "not ok - $text"
        sed 's/^/#   /' "$work/claim.out"
    fi
}
