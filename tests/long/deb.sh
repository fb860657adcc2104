#!/bin/bash
# The Debian package on a fresh Debian with nothing but its dependencies: it installs, runs, has its pages and its service, and is purged
# without a trace.
. tests/scenarios/lib
text="the package in a fresh root"
skip_under 'asan|tsan' "$text" "a package is built without sanitizers"
[ "$(id -u)" -eq 0 ] || { echo "ok - $text # SKIP only root can make a root"; exit; }

package=$work/package
made() { make --no-print-directory BUILD="${BUILD:-build}" deb >"$work/made" 2>&1 && tail -n 1 "$work/made" >"$package" && [ -s "$(cat "$package")" ]; }
claim "make deb makes it, without errors of lintian" made || cat "$work/made"
deb=$(cat "$package")
needs=$(dpkg-deb -f "$deb" Depends | sed 's/([^)]*)//g; s/ //g')

# This script runs in the new root. Every claim's output is kept beside it.
cat >"$work/inside" <<'END'
set -u
export LC_ALL=C DEBIAN_FRONTEND=noninteractive PATH=/usr/sbin:/usr/bin:/sbin:/bin
claim() {
    local text=$1
    shift
    if "$@" >/tmp/claim.out 2>&1; then echo "ok - $text"; else echo "not ok - $text"; sed 's/^/#   /' /tmp/claim.out; fi
}
files() { find / -xdev \( -path /proc -o -path /sys -o -path /dev -o -path /tmp -o -path /run \) -prune -o -print | grep -vE '^/var/(lib/dpkg|log|cache)/|^/etc/(passwd|group|shadow|gshadow|subuid|subgid)-?$' | sort; }
files >/tmp/before
claim "it installs" dpkg -i /tmp/hexid.deb
mkdir /tmp/elsewhere && cd /tmp/elsewhere
run() { env -i /usr/bin/hexid run --fast --set sim.engine=closed_form --set lcm.url= --log a.lcm --json a.json && grep hexid.identification a.json && env -i /usr/bin/hexid identify a.lcm; }
claim "hexid run --fast passes and its log is identified, with an empty environment and without a checkout" run
configuration() { env -i /usr/bin/hexid doctor --latency 0 --set lcm.url= | grep '/etc/hexid/tian2015.yaml' && dpkg-query -W -f='${Conffiles}' hexid | grep -q /etc/hexid/tian2015.yaml; }
claim "its configuration is the one in /etc/hexid, which the package manager keeps" configuration
claim "the service has a user without a home or a shell" eval 'getent passwd hexid | grep -E ":/nonexistent:/usr/sbin/nologin$"'
claim "the service is there, neither enabled nor started" eval '[ -s /lib/systemd/system/hexid.service ] && ! find /etc/systemd -name "hexid*" | grep .'
claim "installed again, it is as it was" dpkg -i /tmp/hexid.deb
removed() { dpkg -r hexid && [ -s /etc/hexid/tian2015.yaml ] && ! command -v hexid; }
claim "removed, it leaves its configuration" removed
purged() { dpkg -P hexid && files >/tmp/after && diff /tmp/before /tmp/after && ! getent passwd hexid; }
claim "purged, it leaves no file and no user" purged
END

fresh() {
    mmdebstrap --quiet --variant=minbase --include="$needs" --format=null --customize-hook="cp '$deb' \"\$1/tmp/hexid.deb\"" \
        --customize-hook="cp '$work/inside' \"\$1/tmp/inside\"" --customize-hook="chroot \"\$1\" bash /tmp/inside >'$work/said'" \
        "$(. /etc/os-release && echo "$VERSION_CODENAME")" /dev/null >"$work/root" 2>&1
}
fresh
if [ -s "$work/said" ]; then
    cat "$work/said"
else
    tail -n 20 "$work/root" | sed 's/^/# /'
    echo "ok - $text # SKIP no root could be made: $(tail -n 1 "$work/root")"
fi
