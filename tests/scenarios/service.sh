#!/bin/bash
# The service: its unit, and a run with the unit's user, rights and limits, set by the same system calls, under a service manager that
# receives the messages to systemd.
. tests/scenarios/lib
shopt -s extglob
skip_under 'asan|tsan' "the service" "sanitizer builds are not confined and lock more memory"
own_network "the service"

mkdir -p "$work/usr/bin" "$work/logs"
chmod 755 "$work"
chmod 777 "$work/logs"
cp "$hexid" "$work/usr/bin/hexid"
sed "s|@prefix@|$work/usr|g; s|@sysconfdir@|/etc|g" config/hexid.service >"$work/hexid.service"
unit() { sed -n "s/^$1=//p" "$work/hexid.service"; }

text="systemd-analyze finds nothing wrong with the unit, and its exposure below 2.0"
exposed() {
    systemd-analyze verify --man=no "$work/hexid.service" 2>"$work/wrong" && ! grep . "$work/wrong" || { cat "$work/wrong"; return 1; }
    systemd-analyze security --offline=yes --no-pager "$work/hexid.service" | tail -n 1 | tee "$work/exposure"
    awk '{ for (i = 1; i <= NF; i++) if ($i ~ /^[0-9.]+$/) { n = 1; if ($i >= 2.0) exit 1 } } END { exit !n }' "$work/exposure"
}
if command -v systemd-analyze >/dev/null; then claim "$text" exposed; else echo "ok - $text # SKIP no systemd-analyze here"; fi

# The unit's command and the options of the service as shipped.
# A busy host may be late; no claim here depends on the wall clock.
. config/hexid.default
command=$(unit ExecStart | sed "s|/var/log/hexid|$work/logs|; s|\\\$HEXID_OPTIONS|$HEXID_OPTIONS|")
brisk="--set sim.engine=closed_form --set motion.park_z_m=0.35 --set motion.rate_mps=0.55 \
    --set motion.engage_s=1.6 --set motion.park_s=1.6 --set motion.hold_s=0.1 --set limits.blind_time_s=10
    --set loop.overrun_limit=4000"
service=($command $brisk)
claim "it moves on command only, whatever its options say" eval '[[ $command == *" --set motion.automatic=false" ]]'

# Its rights: the unit's capabilities, limits and no new privileges, as nobody.
if [ "$(id -u)" -ne 0 ]; then
    echo "ok - as the service's user with its rights # SKIP only root can give these rights to another user"
    exit
fi
rights=-all
for right in $(unit AmbientCapabilities); do rights+=,+$(tr '[:upper:]' '[:lower:]' <<<"${right#CAP_}"); done
limit() { unit "Limit$1" | sed 's/infinity/unlimited/'; }
limits=(--core="$(limit CORE)" --nofile="$(limit NOFILE)")
# A container may not raise it, but the right to lock memory overrides it.
prlimit --memlock="$(limit MEMLOCK)" true 2>/dev/null && limits+=(--memlock="$(limit MEMLOCK)")
limited=(prlimit "${limits[@]}"
    setpriv --reuid nobody --regid nogroup --clear-groups --no-new-privs --inh-caps "$rights" --ambient-caps "$rights" --bounding-set "$rights")
realtime=(--rt require)
chrt -f 80 true 2>/dev/null || realtime=(--rt off)
manager() { "$python" tests/scenarios/service.py "$@"; }
# Its runtime directory, as made by the service manager.
rmdir "$HEXID_RUNTIME_DIR" && install -d -m "$(unit RuntimeDirectoryMode)" -o nobody -g nogroup "$HEXID_RUNTIME_DIR"
run=("${limited[@]}" "${service[@]}" "${realtime[@]}")

claim "it has two rights and no others" eval \
    '[ "$rights" = -all,+sys_nice,+ipc_lock ] && [ "$(unit CapabilityBoundingSet)" = "$(unit AmbientCapabilities)" ]'
claim "ready when settled, alive while cycles come; SIGTERM ends it with status 0 (${realtime[*]})" manager ordered "${run[@]}"
claim "its log is there, whole, and holds the run" eval '"$hexid" identify "$work"/logs/*Z.0001.lcm --json "$work/log.json" 2>"$work/error" >/dev/null;
    cat "$work/error"; [ -s "$work/log.json" ] && ! grep -q cut "$work/error"'
claim "a manager whose socket has no file hears the same" manager abstract "${run[@]}"
claim "SIGTERM while the platform is raised: parked, status 0" manager put_down "$work/usr/bin/hexid command engage" "${run[@]}"
claim "SIGTERM while a fault stands: status 1" manager faulted "${run[@]}" --hal "fault:drop@1+1000;sim:"
claim "no sign of life once the recorder takes no cycle, whoever else runs" manager stalled "$work/fifo" "${limited[@]}" \
    ${command/--log*--log-part +([0-9])/--log $work/fifo} $brisk --rt off

# The program never makes a call that SystemCallFilter= denies: the names in its sets against the calls of a run.
set_of() {
    systemd-analyze syscall-filter "$1" | sed -n 's/^    \([@a-z0-9_-]*\)$/\1/p' |
        while read -r name; do if [[ $name == @* ]]; then set_of "$name"; else echo "$name"; fi; done
}
allowed() {
    [ "$(unit SystemCallFilter | head -n 1)" = "@system-service seccomp" ] || return
    manager ordered strace -D -f -qq -o "$work/calls" "${service[@]}" --rt try --log-part 0.0001 || return
    sed -nE 's/^[0-9]+ +([a-z0-9_]+)\(.*/\1/p' "$work/calls" | sort -u | grep -vx 'execve' >"$work/called"
    { set_of @system-service; echo seccomp; } | sort -u >"$work/let"
    unit SystemCallFilter | tail -n 1 | tr -d '~' | tr ' ' '\n' | while read -r name; do set_of "$name"; done | sort -u >"$work/denied"
    echo "$(wc -l <"$work/called") calls, $(wc -l <"$work/let") allowed, less $(wc -l <"$work/denied")"
    [ "$(wc -l <"$work/called")" -gt 20 ] && ! comm -23 "$work/called" "$work/let" | grep . && ! comm -12 "$work/called" "$work/denied" | grep .
}
text="it asks for no system call that the unit denies"
if command -v strace systemd-analyze >/dev/null; then claim "$text" allowed; else echo "ok - $text # SKIP strace or systemd-analyze is missing"; fi
