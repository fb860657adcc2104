#!/bin/bash
# Debian's PREEMPT_RT kernel, booted in QEMU by software alone, runs hexid's self-check (init). It shows that the daemon runs there and gets
# the rights that it asks for; the speed of an emulated machine shows nothing.
. tests/scenarios/lib
build=${BUILD:-build}/rt-kernel
mkdir -p "$build"

# The kernel of linux-image-rt-amd64, unpacked once; nothing is installed.
kernel() {
    local package
    compgen -G "$build/root/boot/vmlinuz-*" >/dev/null && return
    package=$(apt-cache depends linux-image-rt-amd64 | sed -n 's/^ *Depends: \(linux-image-.*-rt-amd64\)$/\1/p' | head -n 1)
    [ -n "$package" ] || { echo "linux-image-rt-amd64 is not known: apt-get update"; return 1; }
    (cd "$build" && apt-get download "$package" && dpkg-deb --fsys-tarfile "$package"_*.deb | tar -x -C . --wildcards --one-top-level=root './boot/vmlinuz-*' './boot/config-*') ||
        return 1
}
# Packs hexid, its libraries, its configuration and busybox.
initramfs() {
    local root=$work/root file
    mkdir -p "$root/bin" "$root/config" "$root/lib64"
    cp /bin/busybox "$hexid" "$root/bin/" && cp config/tian2015.yaml "$root/config/" && cp tests/rt/kernel/init "$root/init" || return
    strip "$root/bin/hexid"
    for file in $(ldd "$hexid" | grep -o '/[^ ]*'); do install -D "$(realpath "$file")" "$root$file" || return; done
    (cd "$root" && find . | cpio -o -H newc --quiet | gzip -1) >"$work/initrd"
}
boots() {
    timeout -k 5 1200 qemu-system-x86_64 -accel tcg -smp 2 -m 1024 -nographic -no-reboot -kernel "$build"/root/boot/vmlinuz-* -initrd "$work/initrd" \
        -append "console=ttyS0 loglevel=4 panic=-1" </dev/null | tr -d '\r' >"$work/console"
    sed -n '/BEGIN$/,/^END$/p' "$work/console" >"$work/said"
    grep -q '^END$' "$work/said" || { tail -n 30 "$work/console"; return 1; }
}
says() { cat "$work/said" && grep -qE "$1" "$work/said"; }
claim "the kernel of linux-image-rt-amd64 is there" kernel
claim "it boots with hexid in its initramfs" eval 'initramfs && boots'
[ -s "$work/said" ] || exit
sed 's/^/# /' "$work/said"
claim "it is PREEMPT_RT" says '^kernel: .*PREEMPT_RT'
claim "and says so to programs" says '^realtime: 1$'
claim "the loop has SCHED_FIFO 80" says '^thread: 80 1$'
claim "its memory is locked" says '^locked: +[1-9][0-9]{4,} kB'
claim "with --rt require it runs its test to the end" says '^run: status [01]$'
claim "without a fault" eval '! grep -q FAULT "$work/said"'
claim "its wake-ups are timed" says 'wake-up +p50 [0-9]+ +p99 [0-9]+'
claim "doctor knows the kernel" says 'ok +kernel .*PREEMPT_RT'
claim "and draws the histogram of the wake-ups" says 'below [0-9]+ us +[0-9]+ #'
