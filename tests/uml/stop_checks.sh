# Run by tests/uml/run.
. tests/scenarios/lib
. tests/scenarios/bus_lib
lcm-gen -p --ppath "$work" lcmtypes/*.lcm
ip link set lo multicast on && ip route add 224.0.0.0/4 dev lo
# It prints its own claims.
PYTHONPATH=$work "$python" tests/uml/stop_checks.py "$hexid" "$work"
