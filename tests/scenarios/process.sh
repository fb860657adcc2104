#!/bin/bash
# The program starts correctly whatever its parent left behind: closed descriptors, blocked and ignored signals, limits (src/rt/process.h).
own="a process in a network of its own"
. tests/scenarios/lib
own_network "$own"

short=("${quick[@]}" --tests z)
standard() { ls -l "/proc/$1/fd" | sed -n 's/.* \([012]\) -> /\1 /p'; }

# closed SUBSET COMMAND...: closes those of descriptors 0 to 2 whose bit is set in SUBSET.
closed() {
    local subset=$1
    shift
    (
        ((subset & 1)) && exec <&-
        ((subset & 2)) && exec >&-
        ((subset & 4)) && exec 2>&-
        exec "$@"
    )
}

same_log() {
    local subset
    "${short[@]}" --log "$work/good.lcm" --json "$work/good.json" >/dev/null
    for subset in 1 2 3 4 5 6 7; do
        rm -f "$work"/bad.*
        closed $subset "${short[@]}" --log "$work/bad.lcm" --json "$work/bad.json" >"$work/out" 2>"$work/err" </dev/null
        cmp "$work/good.lcm" "$work/bad.lcm" && cmp "$work/good.json" "$work/bad.json" || { echo "subset $subset"; return 1; }
    done
}
claim "a run with any of its descriptors 0 to 2 closed writes the same log and the same result" same_log

# Every descriptor 0 to 2 that is written to is a terminal or a pipe, or the write is refused: strace sees no file or socket among them.
writes=trace=read,readv,recvfrom,recvmsg,recvmmsg,write,writev,pwrite64,sendto,sendmsg,sendmmsg,ioctl,ftruncate
traced() {
    local subset=$1
    shift
    closed "$subset" strace -f -y -qq --seccomp-bpf -e "$writes" -o "$work/calls" "$@" </dev/null >"$work/out" 2>"$work/err"
    grep -m 3 -E '^[0-9]+ +[a-z0-9_]+\([012]<(socket|anon|UDP|TCP|UNIX|NETLINK|'"$work"'/(x|a)\.)' "$work/calls" && { echo "subset $subset: $*"; return 1; }
    return 0
}
none_shared() {
    local subset
    command -v strace >/dev/null || { echo "no strace"; return 1; }
    "${short[@]}" --log "$work/a.lcm" >/dev/null
    for subset in 1 2 3 4 5 6 7; do
        rm -f "$work"/x.*
        traced $subset "${short[@]}" --set tests.duration_s=0.5 --set "lcm.url=$url" --log "$work/x.lcm" &&
            traced $subset "$hexid" identify "$work/a.lcm" --json "$work/x.json" || return 1
    done
    for subset in 1 2 7; do
        traced $subset timeout -s INT 1 "$hexid" plant --bus modbus:tcp://127.0.0.1:0 --rt off --set sim.engine=closed_form &&
            traced $subset timeout -s TERM 1 "$hexid" monitor --http 0 --set "lcm.url=$url" &&
            traced $subset timeout -s TERM 1 "$hexid" monitor --json --set "lcm.url=$url" &&
            traced $subset timeout -s INT 1 "$hexid" command park --set "lcm.url=$url" || return 1
    done
}
claim "no subcommand has a log, a result, a socket or a bus for a descriptor 0 to 2" none_shared

# A bus whose connection had descriptor 1 took the run's output for requests. These gains have their margins over a bus, so that the run
# connects at once, and computes no better ones first.
bus_apart() {
    local line port plant subset seconds status=0 gains=(--set control.kp=40 --set control.kpf=6e-7)
    mkfifo "$work/served"
    "$hexid" plant --bus modbus:tcp://127.0.0.1:0 --rt off --set sim.engine=closed_form >"$work/served" &
    plant=$!
    read -r line <"$work/served"
    port=${line##*:}
    port=${port%%[^0-9]*}
    for subset in 1 2 4 7; do
        for seconds in 2 8 30; do # tries again, until there was enough time to connect
            traced $subset timeout -s INT $seconds "$hexid" run --hal "modbus:tcp://127.0.0.1:$port" --rt off "${quick_settings[@]}" \
                "${gains[@]}" || status=1
            grep -q 'socket:' "$work/calls" && continue 2
        done
        echo "no connection: $(cat "$work/err")"
        status=1
    done
    kill $plant
    wait $plant
    return $status
}
claim "nor has a run for its Modbus connection" bus_apart

# ---- signals ----

left_behind() {
    "$python" - "$hexid" "$work/a.lcm" "$work/page.html" <<'P'
import signal, subprocess, sys, time

def leave():
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)
    signal.signal(signal.SIGPIPE, signal.SIG_IGN)
    signal.pthread_sigmask(signal.SIG_BLOCK, range(1, 32))

hexid, log, page = sys.argv[1:]
report = subprocess.run([hexid, "report", log, "-o", page], preexec_fn=leave, restore_signals=False, capture_output=True, text=True)
print(report.stderr)
assert "gnuplot" not in report.stderr, "SIGCHLD ignored: the status of gnuplot was lost"
plant = subprocess.Popen([hexid, "plant", "--bus", "modbus:tcp://127.0.0.1:0", "--rt", "off"], preexec_fn=leave, restore_signals=False,
                         stdout=subprocess.PIPE)
plant.stdout.readline()
plant.terminate()
print("plant ended with", plant.wait(30))
P
}
claim "signals that were blocked or ignored by who started it work: gnuplot's end, SIGTERM" left_behind

nothing_for_everybody() {
    (umask 0 && "${short[@]}" --log "$work/open.lcm" --json "$work/open.json" >/dev/null)
    stat -c '%A %n' "$work"/open.*
    ! stat -c %A "$work"/open.* | grep -q 'w.$'
}
claim "with umask 0 no log or result is for everybody to write" nothing_for_everybody

quiet_libraries() {
    G_MESSAGES_DEBUG=all G_DEBUG=fatal-warnings "$hexid" run --fast "${quick_settings[@]}" --tests z --set "lcm.url=$url" --json - 2>/dev/null |
        "$python" -m json.tool >/dev/null
}
claim "variables of GLib change neither results nor the end of a run" quiet_libraries

# ---- limits ----

# limited LIMIT WORDS COMMAND...: under `ulimit LIMIT`, refused with status 3 and one line with these words.
limited() {
    local limit=$1 words=$2
    shift 2
    refuses 3 "$words" bash -c "ulimit -c 0; ulimit $limit; exec \"\$@\"" _ "$@" >/dev/null
}
# A sanitizer's runtime does not fit into such a stack even before main().
small_stack() { built_with 'asan|tsan' || "$@"; }
small_stack claim "512 kB of stack are refused: the limit, the need, the remedy" limited "-s 512" "512 8192 LimitSTACK" "${short[@]}"
small_stack claim "64 kB of stack, too" limited "-s 64" "64 8192 LimitSTACK" "${short[@]}"
small_stack claim "and to analyse a log" limited "-s 512" "512 8192 LimitSTACK" "$hexid" identify "$work/a.lcm"
claim "16 open files are refused: the limit, the need, the remedy" limited "-n 16" "16 128 LimitNOFILE" "${short[@]}"
small_stack claim "a soft limit of 64 kB of stack and 16 files is raised: a run with the same log" eval \
    '(ulimit -Ss 64; ulimit -Sn 16; "${short[@]}" --log "$work/soft.lcm" >/dev/null); cmp "$work/good.lcm" "$work/soft.lcm"'

# With any address space the run either completes or prints one line with the reason; never a signal.
little_memory() {
    local kb status
    for kb in 20000 40000 50000 60000 70000 80000 100000 120000 200000; do
        (ulimit -c 0; ulimit -v $kb; exec "${short[@]}" --log "$work/little.lcm") >/dev/null 2>"$work/error"
        status=$?
        echo "$kb kB: status $status: $(head -n 1 "$work/error")"
        ((status < 128)) || return 1
        ((status == 0 || status == 1)) || [ -s "$work/error" ] || return 1
        rm -f "$work/little.lcm"
    done
    ((status <= 1))
}
built_with 'asan|tsan' || claim "with any amount of address space: a run, or an error, and no crash" little_memory

built_with 'asan|tsan' || claim "no stack of a run is used to more than half" "$python" tests/bench/stacks.py "${quick[@]}"

# With the shell's limit of 8 MB of stack per thread, 72 MB were locked.
little_locked() {
    local run kb=0
    "$hexid" run --rt try "${quick_settings[@]}" --set motion.automatic=true >"$work/said" 2>"$work/error" &
    run=$!
    until grep -q engaging "$work/said" || ! kill -0 $run 2>/dev/null; do sleep 0.1; done
    kb=$(sed -n 's/^VmLck:\s*\([0-9]*\).*/\1/p' "/proc/$run/status")
    kill -INT $run
    wait $run
    echo "$kb kB are locked; $(cat "$work/error")"
    grep -q 'memory not locked' "$work/error" || ((kb > 0 && kb < 40000))
}
built_with 'asan|tsan' || claim "what is locked at the start is less than 40 MB, the threads' stacks included" little_locked

# Applies to users: the kernel exempts root from these two.
if [ "$(id -u)" = 0 ]; then
    chmod 755 "$work"
    cp "$hexid" "$work/hexid"
    user=(setpriv --reuid 64124 --regid 64124 --clear-groups "$work/hexid") # a user without other processes
else
    user=("$hexid")
fi
# AddressSanitizer's mlockall() does nothing.
built_with 'asan|tsan' || claim "no memory to lock: --rt require is refused, with the remedy" ends 4 eval \
    '(ulimit -l 0; "${user[@]}" run --rt require "${quick_settings[@]}") 2>&1 >/dev/null | tee /dev/stderr | grep -q "memlock unlimited" && (exit 4)'
built_with 'asan|tsan' || claim "the simulated device is refused likewise" ends 4 eval \
    '(ulimit -l 0; "${user[@]}" plant --bus can:none --rt require) 2>&1 >/dev/null | tee /dev/stderr | grep -q "memlock unlimited" && (exit 4)'
no_threads() {
    local most
    for most in 1 2 3 4; do
        (ulimit -u $most; exec "${user[@]}" run --fast "${quick_settings[@]}" --tests z) >/dev/null 2>"$work/error"
        status=$?
        echo "$most: status $status: $(cat "$work/error")"
        ((status == 3)) && grep -q 'thread.*ulimit -u' "$work/error" && return
    done
    return 1
}
claim "too few threads: the run says which one, and names the limit" no_threads

full_output() {
    local words
    for words in --help --version effects "command --help"; do
        "$hexid" $words >/dev/full 2>"$work/err"
        [ $? = 3 ] && grep -q 'standard output did not take all of the text: No space left' "$work/err" ||
            { cat "$work/err"; echo "$words"; return 1; }
    done
    "$hexid" effects | head -n 1 >"$work/out"
    local status=${PIPESTATUS[0]}
    echo "exit status $status"
    ((status == 0 || status == 141)) # 128 + SIGPIPE
}
claim "text that a full disk does not take ends with status 3; a reader that has read enough is no failure" full_output

cut_mat() {
    local kb
    for kb in 20 100; do
        (ulimit -f $kb && ends 3 "$hexid" export "$work/good.lcm" --format mat -o "$work/cut.mat") 2>"$work/err"
        grep -q 'cut.mat: cannot be written: File too large' "$work/err" && [ ! -e "$work/cut.mat" ] || { cat "$work/err"; echo "$kb kB"; return 1; }
    done
}
claim "a .mat that would be longer than a file may be is not written" cut_mat

twice() {
    ends 2 "$hexid" identify "$work/good.lcm" --json "$work/1.json" --json "$work/2.json" 2>"$work/err" &&
        grep -q -e "--json: given twice, as $work/1.json and as $work/2.json" "$work/err" && [ ! -e "$work/2.json" ] &&
        ends 2 "$hexid" gap "$work/good.lcm" --validate "$work/good.lcm" -c config/tian2015.yaml -o "$work/gap" 2>"$work/err" &&
        grep -q 'good.lcm: given twice; name each log once' "$work/err" && return
    cat "$work/err"
    return 1
}
claim "an option with two values is refused, and so is a log that is to validate what was fitted to it" twice
