#!/bin/bash
# Who may give commands: the daemon's user, root and group hexid all of them, everybody else stop and park; and whose programs count as
# machines. Real users, in a mount namespace with this script's own group hexid and /run.
. tests/scenarios/lib
skip_unless_root() {
    [ "$(id -u)" -eq 0 ] && unshare -m true 2>/dev/null && return
    echo "ok - who may give commands # SKIP only root can act as others"
    exit
}
skip_unless_root
if [ "${OWN_GROUPS:-}" != yes ]; then
    { grep -v '^hexid:' /etc/group; echo 'hexid:x:64123:'; } >"$work/group"
    rm -rf "$HEXID_RUNTIME_DIR"
    trap - EXIT
    OWN_GROUPS=yes exec unshare -m bash -c 'mount --bind "$0/group" /etc/group && mount -t tmpfs -o mode=755 none /run && exec "$@"' "$work" "$0"
fi
. tests/scenarios/operators_lib
chmod 755 "$work"
cp "$hexid" "$work/hexid"
hexid=$work/hexid
machines=$HEXID_RUNTIME_DIR
unset HEXID_RUNTIME_DIR # commands use the normal path
cd "$work" || exit # the built-in configuration, because nobody can read the checkout

# user UID GROUPS COMMAND...: runs as a user with these groups, none with "".
user() {
    local groups=(--clear-groups)
    [ -z "$2" ] || groups=(--groups "$2")
    setpriv --reuid "$1" --regid "$1" "${groups[@]}" "${@:3}"
}
# A service: its user's group is hexid and its directory is made for it. Or root, who makes the directory and gives the socket to the group.
service() {
    rm -rf /run/hexid
    [ -z "$1" ] || install -d -m 755 -o "$1" /run/hexid
    as=(${1:+setpriv --reuid "$1" --regid 64123 --clear-groups})
    daemon "of${1:-root}" --set lcm.url=
}
member_engages() { # DAEMON
    user 64001 64123 "$hexid" command engage >"$work/operator" 2>&1 &
    local operator=$!
    comes ready "$1" && user 64001 64123 "$hexid" command park && comes settled "$1" 2 && ends 0 wait $operator
}
others_do_not() { # DAEMON
    local command
    for command in engage start reset; do
        refuses 4 "refused group hexid adduser everybody" user 64002 "" "$hexid" command $command || return
    done
    for command in stop park; do ends 0 user 64002 "" "$hexid" command $command || return; done
    ! grep -c refused "$work/$1"
}
passed_on() { # a stop by a non-member while a member holds the lease
    user 64001 64123 "$hexid" command engage >"$work/operator" 2>&1 &
    local operator=$!
    comes ready "$1" 2 && ends 0 user 64002 "" "$hexid" command park && comes settled "$1" 3 && ends 0 wait $operator && ended_by TERM 0
}
for owner in 64000 ""; do
    name=of${owner:-root}
    service "$owner" >"$work/start"
    ls -ln /run/hexid | sed 's/^/# /'
    claim "a daemon of ${owner:-root}: a member of group hexid engages" member_engages "$name"
    claim "engage, start and reset are refused for others by the kernel, stop and park never" others_do_not "$name"
    claim "and others put down what a member engaged" passed_on "$name"
done

# A user's program in a world-writable directory under the name of a machine.
stranger() {
    rm -rf "$machines"
    install -d -m 1777 "$machines"
    export HEXID_RUNTIME_DIR=$machines
    user 64002 "" /usr/bin/python3 - "$machines" <<'END' &
import os, socket, struct, sys
answer = b"HEXA" + struct.pack(">HBBII", 1, 0, 1, 1, 0) + bytes(496)
listeners = []
for name in ("hexid.stop", "hexid"):
    listener = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    listener.bind(os.path.join(sys.argv[1], name))
    os.chmod(os.path.join(sys.argv[1], name), 0o666)
    listener.listen(100)
    listener.setblocking(False)
    listeners.append(listener)
open(os.path.join(sys.argv[1], "ready"), "w").close()
import select
open_ones = []
while True:
    for one in select.select(listeners + open_ones, [], [])[0]:
        if one in listeners:
            open_ones.append(one.accept()[0])
        elif one.recv(100):
            one.send(answer)
        else:
            open_ones.remove(one)
END
    local stranger=$! status
    until [ -e "$machines/ready" ]; do kill -0 $stranger || return; sleep 0.05; done
    ends 3 "$hexid" command park --set lcm.url= >"$work/park" 2>&1 && ends 3 "$hexid" command engage >>"$work/park" 2>&1
    status=$?
    cat "$work/park"
    as=()
    daemon beside --set lcm.url= --set machine.name=hexid && ends 0 "$hexid" command park >"$work/own"
    local started=$?
    kill $stranger $daemon
    unset HEXID_RUNTIME_DIR
    ((status == 0 && started == 0)) && ! grep -q ' done' "$work/park" && grep -q "another user's program" "$work/park" && grep 'park done' "$work/own"
}
claim "a stranger's program is no machine: park is not done by it, and its name is taken from it" stranger
elsewhere() {
    install -d -m 755 -o 64002 "$work/theirs"
    HEXID_RUNTIME_DIR=$work/theirs refuses 4 "another user" user 64001 "" "$hexid" run --rt off "${fair[@]}" --set lcm.url=
}
claim "a directory of another user is refused" elsewhere
