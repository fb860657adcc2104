"""stop_checks.py HEXID DIRECTORY: attacks a running hexid from all sides, then stops it, and reads in its log how long that took. Prints one
TAP line a claim. In a network of its own with CAN, and with the log's types on PYTHONPATH."""
import contextlib, fcntl, os, random, signal, socket, struct, subprocess, sys, threading, time

import hexid, lcm

HEXID, WORK = sys.argv[1:]
URL = "udpm://239.255.76.67:7667?ttl=0"
GROUP = ("239.255.76.67", 7667)
SIGNAL_MS, MESSAGE_MS = 100, 20  # from the signal or the message's arrival to the first cycle that parks
PACKET_MS = 4 if os.environ.get("CLOCK") == "virtual" else 20  # from a command over a socket: two cycles
MORE, REAL = bool(os.environ.get("MORE_CASES")), os.environ.get("CLOCK") == "real"
QUICK = [word for key in """sim.engine=closed_form motion.park_z_m=0.35 motion.rate_mps=0.55
motion.engage_s=1.6 motion.park_s=1.6 motion.hold_s=0.1 tests.settle_s=0.2 tests.ramp_s=0.3
    tests.duration_s=30 tests.ramp_out_s=0.2 sensors.enabled=false""".split() for word in ("--set", key)]
# For a field bus, so that no start searches for better ones to warn of (tests/scenarios/bus_lib).
BUS_GAINS = ["--set", "control.kp=49", "--set", "control.kpf=6.2e-7"]
SETTLED, PRESSURISING, READY, TESTING, PARKING, FAULT = 1, 7, 3, 4, 5, 6
RAMP_OUT = 4  # phase of a test


def stalled_ms(since_us):
    """Returns the longest stall of the machine since then: on the real clock a witness records it (tests/scenarios/stalls_lib)."""
    time.sleep(0.01)
    with contextlib.suppress(FileNotFoundError), open(os.path.join(WORK, "stalls")) as witness:
        return max((int(ms) for at, ms in (line.split() for line in witness if line[0].isdigit()) if int(at) >= since_us), default=0)
    return 0


def claim(text, tries=3, sweep=False, long=False):
    """Runs the check it decorates. `make test-long` and `make test-rt` run the long ones; `make test-long` sweeps over all signals."""
    def run(check):
        if not (sweep or long == MORE or (long and REAL)):
            return
        for _ in range(tries):
            since = now_us()
            try:
                said = check()
                print(f"ok - {text}" + (f": {said}" if said else ""), flush=True)
                return
            except Exception as error:  # any error makes this claim fail, unless the machine stalled
                failure, stall = f"#   {type(error).__name__}: {error}", stalled_ms(since)
                if stall < 5:
                    break
            print(f"# again, the machine stood still for {stall} ms: {failure}", flush=True)
        if stall < 5:
            print(f"not ok - {text}\n{failure}", flush=True)
        else:
            print(f"ok - {text} # SKIP the machine stood still for {stall} ms, in the last of {tries} tries", flush=True)
    return run


def demand(holds, *words):
    if not holds:
        raise AssertionError(" ".join(map(str, words)))


class Run:
    """Runs a hexid on the simulated platform, or on the back-end `hal`, up to its first test."""

    def __init__(self, *options, hal="sim:", log="run.lcm", wait=True, out=None):
        self.log = os.path.join(WORK, log)
        if os.path.isfile(self.log):  # otherwise it would be set aside, with a message to a terminal that may hang
            os.unlink(self.log)
        self.output = open(os.path.join(WORK, "output"), "w+b")
        command = [HEXID, "run", "--hal", hal, *QUICK, *(BUS_GAINS if hal != "sim:" else []), "--set", "lcm.url=" + URL, "--set", "motion.automatic=true", "--log", self.log, *options]
        self.process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=out or self.output, stderr=out or self.output)
        if wait:
            self.until(TESTING)

    def states(self, log=None):
        """Returns (time of the day in us, state, message) of every cycle in the log so far."""
        events = [e for e in lcm.EventLog(log or self.log, "r") if e.channel == "HEXID_STATE"]
        return [(e.timestamp, m.state, m) for e in events for m in (hexid.state_t.decode(e.data),)]

    def until(self, state, patience_s=60):
        listener = lcm.LCM(URL)
        seen = []
        listener.subscribe("HEXID_STATE", lambda _, data: seen.append(hexid.state_t.decode(data).state))
        end = time.monotonic() + patience_s
        while state not in seen:
            demand(self.process.poll() is None, "ended", self.process.returncode, self.said())
            demand(time.monotonic() < end, "not in state", state)
            listener.handle_timeout(100)

    def said(self):
        return open(self.output.name, errors="replace").read()

    def ended(self, status=1, patience_s=60):
        got = self.process.wait(patience_s)
        demand(got == status, "exit status", got, "not", status, self.said())

    def parked_after_ms(self, since_us):
        """Returns the time until the first cycle that parks, by its sample, which may be a cycle older; checks that the platform was parked
        and no uncounted cycle is missing."""
        states = self.states()
        later = [at for at, state, _ in states if state == PARKING]
        demand(later, "never parked")
        demand(states[-1][1] == SETTLED and not states[-1][2].enable, "not put down:", states[-1][1])
        steps = {b[2].seq - a[2].seq for a, b in zip(states, states[1:])}
        demand(steps == {1}, "cycles are missing in the log:", steps)
        demand(not any(m.sample_flags & 16 for _, _, m in states), "deadlines were missed")
        return (later[0] - since_us) / 1e3


def now_us():
    return time.time_ns() // 1000


def stopped_by(run, number, limit_ms=SIGNAL_MS):
    since = now_us()
    run.process.send_signal(number)
    run.ended()
    took_ms = run.parked_after_ms(since)
    demand(-2 <= took_ms <= limit_ms, "parked after", took_ms, "ms")
    return took_ms


def park_message():
    command = hexid.command_t()
    command.command = "park"
    return b"LC02\0\0\0\0HEXID_COMMAND\0" + command.encode()


def sender():
    out = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    out.connect(GROUP)
    return out


def parked_by_message(run, limit_ms=MESSAGE_MS):
    since = now_us()
    sender().send(park_message())
    run.ended()
    took_ms = run.parked_after_ms(since)
    demand(-2 <= took_ms <= limit_ms, "parked after", took_ms, "ms")
    return f"{took_ms:.0f} ms"


def full_pipe():
    """Returns the write end of a full pipe, like that of a terminal whose other end hangs."""
    reader, writer = os.pipe()
    fcntl.fcntl(writer, fcntl.F_SETFL, os.O_NONBLOCK)
    with contextlib.suppress(BlockingIOError):
        while True:
            os.write(writer, b"x" * 4096)
    with contextlib.suppress(BlockingIOError):
        while True:
            os.write(writer, b"x")
    fcntl.fcntl(writer, fcntl.F_SETFL, 0)
    return reader, writer


@claim("a terminal that hangs holds no signal up")
def _():
    reader, writer = full_pipe()
    took = stopped_by(Run(out=writer), signal.SIGTERM)
    os.close(reader), os.close(writer)
    return f"{took:.0f} ms"


@claim("nor a message")
def _():
    reader, writer = full_pipe()
    took = parked_by_message(Run(out=writer))
    os.close(reader), os.close(writer)
    return took


@claim("a log whose reader sleeps: parked before a record is lost, and ended with status 3")
def _():
    fifo = os.path.join(WORK, "fifo.lcm")
    os.mkfifo(fifo)
    reader = os.open(fifo, os.O_RDONLY | os.O_NONBLOCK)
    run = Run(log="fifo.lcm", wait=False)
    run.ended(3)
    demand("took no more for 2 s" in run.said() and "records of the end are not in it" in run.said(), run.said())
    kept = os.path.join(WORK, "kept.lcm")
    with open(kept, "wb") as out, contextlib.suppress(BlockingIOError):
        while piece := os.read(reader, 1 << 16):
            out.write(piece)
    os.close(reader)


STOPS = [signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT, signal.SIGUSR1, signal.SIGUSR2, signal.SIGALRM, signal.SIGVTALRM,
         signal.SIGPROF, signal.SIGIO, signal.SIGPWR, signal.SIGSTKFLT, signal.SIGTSTP, signal.SIGXCPU, signal.SIGRTMIN, signal.SIGRTMAX]
HARMLESS = [signal.SIGPIPE, signal.SIGXFSZ, signal.SIGTTIN, signal.SIGTTOU, signal.SIGURG, signal.SIGWINCH, signal.SIGCHLD, signal.SIGCONT]


if not MORE:  # the terminal's, the system's, one of the kernel's, one for the keyboard's stop, the last one
    STOPS = [signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGTSTP, signal.SIGRTMAX]


@claim("every signal that would end or stop a process parks the platform instead", sweep=True)
def _():
    worst = max(stopped_by(Run(), number) for number in STOPS)
    return f"{len(STOPS)} signals, {worst:.0f} ms at most"


@claim("the others do nothing")
def _():
    run = Run()
    for number in HARMLESS:
        run.process.send_signal(number)
        time.sleep(0.05)
    demand(run.process.poll() is None, "ended")
    return f"{stopped_by(run, signal.SIGINT):.0f} ms"


@claim("a second signal centres the valves at once")
def _():
    run = Run()
    run.process.send_signal(signal.SIGINT)
    time.sleep(0.5)
    since = now_us()
    run.process.send_signal(signal.SIGINT)
    run.ended()
    last_us = run.states()[-1][0]
    demand(last_us - since <= SIGNAL_MS * 1000, "the last cycle came", (last_us - since) / 1e3, "ms later")


@claim("signals that come twice at once, as from a terminal that is lost, are one: parked")
def _():
    for number in (signal.SIGHUP, signal.SIGTERM):
        run = Run()
        since = now_us()
        for _ in range(3):
            run.process.send_signal(number)
            time.sleep(0.01)
        if number == signal.SIGHUP:
            time.sleep(0.5)
            run.process.send_signal(number)
        run.ended()
        demand(run.parked_after_ms(since) <= SIGNAL_MS, "parked after", run.parked_after_ms(since), "ms")


def crafted(dice, n):
    """Returns a malformed message: fragments, wrong lengths, unterminated names, right names with wrong contents."""
    name = dice.choice([b"HEXID_COMMAND", b"HEXID_STATE", b"HEXID_" + bytes(dice.choices(range(256), k=60)), b"", b"A" * 300])
    offset = dice.choice([0, 0xFFFFFFF0, 0x7FFFFFFF, 1 << 20])
    good = park_message()[22:]
    return dice.choice([
        b"LC03" + struct.pack(">IIIHH", n, dice.choice([1, 66, 0xFFFFFFFF]), offset, dice.choice([0, 1, 65535]), 2) + name + b"\0x",
        b"LC02" + struct.pack(">I", n) + name,
        b"LC02" + struct.pack(">I", n) + b"HEXID_COMMAND\0" + good[:dice.randrange(len(good))],
        b"LC02" + struct.pack(">I", n) + b"HEXID_COMMAND\0" + good[:16] + struct.pack(">i", dice.choice([-1, 0, 1 << 30])) + b"park\0",
        b"LC02" + struct.pack(">I", n) + b"HEXID_COMMAND\0" + bytes(dice.choices(range(256), k=dice.randrange(2000))),
        b"LC02" * dice.randrange(1, 4),
    ])


@claim("10,000 random and 1,000 crafted datagrams do nothing, and park acts")
def _():
    run, dice, out = Run("--set", "lcm.commands=true"), random.Random(1), sender()
    unicast = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    for n in range(11000):
        data = crafted(dice, n) if n % 11 == 0 else bytes(dice.choices(range(256), k=dice.randrange(200)))
        out.send(data)
        unicast.sendto(data, ("127.0.0.1", GROUP[1]))
        if n % 10 == 0:
            time.sleep(0.001)
    demand(run.process.poll() is None, "ended", run.process.returncode)
    demand(all(state != PARKING for _, state, _ in run.states()), "parked by garbage")
    return parked_by_message(run)


def flood(messages, per_ms, stop):
    out, n = sender(), 0
    while not stop.is_set():
        for _ in range(per_ms):
            n += 1
            with contextlib.suppress(OSError):
                out.send(messages[n % len(messages)])
        time.sleep(0.001)


@claim("10,000 messages a second on all channels, requests among them: park acts")
def _():
    run, stop = Run("--set", "lcm.commands=true"), threading.Event()
    request = hexid.request_t()
    request.id, request.command = 77, "engage"
    messages = [b"LC02\0\0\0\0HEXID_COMMAND\0" + request.encode()]
    messages += [b"LC02\0\0\0\0" + name + b"\0" + bytes(400) for name in (b"HEXID_STATE", b"HEXID_EVENT", b"HEXID_COMMAND", b"OTHER")]
    thread = threading.Thread(target=flood, args=(messages, 10, stop))
    thread.start()
    time.sleep(1)
    since = now_us()
    sender().send(park_message())
    time.sleep(0.2)
    stop.set()
    thread.join()
    run.ended()
    took_ms = run.parked_after_ms(since)
    demand(-2 <= took_ms <= MESSAGE_MS, "parked after", took_ms, "ms")
    return f"{took_ms:.0f} ms"


@claim("well-formed requests over LCM, with tokens that are guessed, set nothing in motion")
def _():
    run, dice = Run("--set", "lcm.commands=true", "--set", "motion.automatic=false", wait=False), random.Random(7)
    run.until(SETTLED)
    bus, request, command = lcm.LCM(URL), hexid.request_t(), hexid.command_t()
    for n in range(1000):
        request.command = command.command = dice.choice(["engage", "start", "reset", "renew"])
        request.id, request.token = n, dice.choice([0, 1, -1, 2**63 - 1, dice.getrandbits(63)])
        bus.publish("HEXID_COMMAND", request.encode() if n % 2 else command.encode())
        if n % 10 == 0:
            time.sleep(0.005)
    time.sleep(0.5)
    demand({state for _, state, _ in run.states()} <= {0, SETTLED}, "it moved")
    run.process.send_signal(signal.SIGINT)
    run.ended()


# ---- the sockets of commands


def connection(name="hexid.stop"):
    out = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    out.connect(os.path.join(os.environ["HEXID_RUNTIME_DIR"], name))
    return out


ENGAGE, START, STOP, PARK, RESET = 1, 2, 3, 4, 5


def packet(command, number=1, renew=0, version=1):
    return b"HEXC" + struct.pack(">HBBII", version, command, renew, number, 0)


def parked_by_packet(run, limit_ms=PACKET_MS):
    """Sends a park over a socket, and tries again when its connection was closed to make room, as `hexid command` does."""
    since, tries = now_us(), 0
    while True:
        tries += 1
        demand(tries < 100, "no place for a stop")
        with contextlib.suppress(OSError), connection() as out:
            out.send(packet(PARK, 77))
            out.settimeout(5)
            if answer := out.recv(600):
                break
    took_ms = (now_us() - since) / 1e3
    demand(answer[:4] == b"HEXA" and answer[6] == 0 and answer[8:12] == struct.pack(">I", 77), "answered", answer[:16])
    run.ended()
    parked_ms = run.parked_after_ms(since)
    demand(-2 <= parked_ms <= limit_ms, "parked after", parked_ms, "ms")
    return f"{parked_ms:.0f} ms, answered after {took_ms:.0f} ms, {tries} tries"


@claim("200 idle connections on each socket: park acts")
def _():
    run = Run("--set", "lcm.commands=true")
    idle = []
    for name in ("hexid.stop", "hexid"):
        for _ in range(200):
            idle.append(connection(name))
    said = parked_by_packet(run)
    for one in idle:
        one.close()
    return said


def flood_sockets(packets, stop, per_ms=10):
    """Sends per_ms packets per ms over connections that are reopened when closed."""
    open_ones, n = [], 0
    while not stop.is_set():
        for _ in range(per_ms):
            n += 1
            with contextlib.suppress(OSError):
                while len(open_ones) < 20:
                    one = connection("hexid" if n % 2 else "hexid.stop")
                    one.setblocking(False)
                    open_ones.append(one)
            if not open_ones:
                break
            one = open_ones.pop(0)
            try:
                one.send(packets[n % len(packets)])
                open_ones.append(one)
            except BlockingIOError:
                open_ones.append(one)
            except OSError:
                one.close()
        time.sleep(0.001)


@claim("10,000 packets a second beside 200 idle connections, requests and garbage among them: park acts", long=True)
def _():
    run, stop, dice = Run("--set", "lcm.commands=true"), threading.Event(), random.Random(3)
    idle = [connection() for _ in range(200)]
    packets = [packet(command, 5, renew) for command in (ENGAGE, START, RESET) for renew in (0, 1)]
    packets += [packet(0, 5, 1), packet(200), packet(ENGAGE, version=9), b"", b"HEXC", bytes(16)]
    packets += [bytes(dice.choices(range(256), k=dice.randrange(1, 2000))) for _ in range(20)]
    thread = threading.Thread(target=flood_sockets, args=(packets, stop))
    thread.start()
    time.sleep(1)
    demand(run.process.poll() is None, "ended", run.said())
    demand(all(state != PARKING for _, state, _ in run.states()), "parked by garbage")
    try:
        said = parked_by_packet(run)
    finally:
        stop.set()
        thread.join()
    for one in idle:
        one.close()
    return said


def lingering(seconds):
    """Returns a TCP connection whose last close() takes that long, because its peer reads nothing, and what has to stay open meanwhile."""
    listener = socket.create_server(("127.0.0.1", 0))
    out = socket.create_connection(listener.getsockname())
    peer, _ = listener.accept()
    out.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, seconds))
    out.setblocking(False)
    with contextlib.suppress(BlockingIOError):
        while True:
            out.send(bytes(1 << 16))
    return out, (listener, peer)


@claim("a client's descriptor holds up whoever drops it: refused by the kernel, or the platform is parked after 1 s")
def _():
    run, (out, kept), since = Run(), lingering(20), now_us()
    with connection() as client:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(99))  # so that the daemon's copy of it is the last one
        try:
            socket.send_fds(client, [b"x"], [out.fileno()])
        except PermissionError:  # Linux 6.16 and later
            stopped_by(run, signal.SIGTERM)
            return "refused"
        finally:
            out.close()
            os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
        run.ended(3)
    took_ms = run.parked_after_ms(since)
    demand(990 <= took_ms <= 1000 + SIGNAL_MS, "parked after", took_ms, "ms")
    demand("stops could not be taken for 1 s" in run.said(), run.said())
    return f"{took_ms:.0f} ms"


@claim("while that thread is held up signals park and centre the valves, and when it is free again the log is closed, however much still waits")
def _():
    run, held = Run(), [lingering(1000) for _ in range(4)]
    clients = [connection() for _ in held]
    os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(99))
    try:
        for client, (out, _) in zip(clients, held):
            socket.send_fds(client, [b"x"], [out.fileno()])
    except PermissionError:
        stopped_by(run, signal.SIGTERM)
        return "refused"
    finally:
        for out, _ in held:
            out.close()
        os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
    time.sleep(0.05)
    since = now_us()
    run.process.send_signal(signal.SIGINT)
    time.sleep(0.4)
    again = now_us()
    run.process.send_signal(signal.SIGINT)
    time.sleep(5)
    demand(run.process.poll() is None, "nothing was held up")
    for one in held[0][1]:  # which resets the first client's connection
        one.close()
    run.ended(1, 10)
    states = run.states()
    parked_ms = (next(at for at, state, _ in states if state == PARKING) - since) / 1e3
    demand(-2 <= parked_ms <= SIGNAL_MS, "parked after", parked_ms, "ms")
    demand(states[-1][0] - again <= SIGNAL_MS * 1000, "the last cycle came", (states[-1][0] - again) / 1e3, "ms after the second")
    return f"{parked_ms:.0f} ms"


@claim("a stop is taken from a client of a later version, and from one that went away at once")
def _():
    took = []
    for send in (packet(PARK, version=7) + bytes(20), packet(PARK)):
        run, since = Run(), now_us()
        with connection() as out:
            out.send(send)
        run.ended()
        took.append(run.parked_after_ms(since))
        demand(-2 <= took[-1] <= PACKET_MS, "parked after", took[-1], "ms")
    return f"{max(took):.0f} ms"


@claim("engage, start, stop and park: each is in the log within two cycles")
def _():
    run = Run("--set", "lcm.commands=true", "--set", "motion.automatic=false", wait=False)
    took = {}

    def asked(name, command, state, phase):
        since = now_us()
        out.send(packet(command, len(took) + 1))
        answer = out.recv(600)
        demand(answer[:4] == b"HEXA" and answer[6] == 0, name, "answered", answer[:16])
        answered_ms = (now_us() - since) / 1e3
        time.sleep(0.5)  # until it is in the log
        later = [at for at, was, m in run.states() if at >= since - 2000 and was == state and m.phase == phase]
        demand(later, name, "never")
        took[name] = (later[0] - since) / 1e3, answered_ms
        demand(-2 <= took[name][0] <= PACKET_MS, name, "acted upon after", took[name], "ms")

    run.until(SETTLED)
    with connection("hexid") as out:
        asked("engage", ENGAGE, PRESSURISING, 0)
        run.until(READY)
        asked("start", START, TESTING, 1)
        time.sleep(1)
        asked("stop", STOP, TESTING, RAMP_OUT)
        run.until(READY)
        asked("park", PARK, PARKING, 0)
        run.until(SETTLED)
    run.process.send_signal(signal.SIGINT)
    run.ended()
    return ", ".join(f"{name} {acted:.0f} ms, answered after {answered:.0f} ms" for name, (acted, answered) in took.items())


@claim("what moves is refused over the socket for stops, and taken back when its client goes away at once")
def _():
    run = Run("--set", "lcm.commands=true", "--set", "motion.automatic=false", wait=False)
    run.until(SETTLED)
    with connection() as out:
        for command in (ENGAGE, START, RESET):
            out.send(packet(command))
            demand(out.recv(600)[6] == 2, "taken from everybody")
    run.process.send_signal(signal.SIGSTOP)
    for _ in range(30):
        with connection("hexid") as out:
            out.send(packet(ENGAGE))
    run.process.send_signal(signal.SIGCONT)
    time.sleep(0.3)
    demand({state for _, state, _ in run.states()} <= {0, SETTLED}, "moved for nobody")
    run.process.send_signal(signal.SIGINT)
    run.ended()


@contextlib.contextmanager
def plant(bus):
    settings = [word for key in ("sim.engine=closed_form", "sensors.enabled=false") for word in ("--set", key)]
    process = subprocess.Popen([HEXID, "plant", "--bus", bus, *settings], stdout=subprocess.PIPE, text=True)
    line = process.stdout.readline()
    demand("ready on" in line, line)
    try:
        yield line.split("ready on ")[1].strip()
    finally:
        process.send_signal(signal.SIGTERM)
        process.wait(10)


@claim("a second master on this host is refused, by name, and the first goes on")
def _():
    with plant("modbus:tcp://127.0.0.1:0") as url:
        run = Run(hal=url)
        second = subprocess.run([HEXID, "run", "--hal", url, *BUS_GAINS, "--set", "lcm.url="], capture_output=True, text=True)
        demand(second.returncode == 4 and "drives this machine" in second.stderr and str(run.process.pid) in second.stderr,
               second.returncode, second.stderr)
        return f"{stopped_by(run, signal.SIGINT):.0f} ms"


ERRORS = [signal.SIGSEGV, signal.SIGBUS, signal.SIGFPE, signal.SIGILL, signal.SIGABRT, signal.SIGTRAP, signal.SIGSYS]
if not MORE:
    ERRORS = [signal.SIGSEGV, signal.SIGABRT]


def last_commands(dump, since_us):
    """Returns the valve commands on the bus since then: any that is not the centre, and the time of the last one, in ms."""
    last = 0.0
    for line in open(dump):
        at, _, frame = line.split()
        us = float(at.strip("()")) * 1e6
        if frame.startswith(("201#", "204#")) and set(frame[4:]) != {"0"} and us > since_us:
            last = max(last, (us - since_us) / 1e3)
    return last


@claim("a crash centres the valves before the process ends, and before any watchdog must", sweep=True)
def _():
    worst = 0.0
    for number in ERRORS:
        dump = os.path.join(WORK, "dump")
        with plant("can:vcan0") as url, open(dump, "w") as out:
            candump = subprocess.Popen(["stdbuf", "-oL", "candump", "-L", "vcan0,200:7f8,080:7f8"], stdout=out)
            run = Run(hal=url)
            since = now_us()
            run.process.send_signal(number)
            demand(run.process.wait(10) == -number, "exit status", run.process.returncode)
            time.sleep(0.1)
            candump.send_signal(signal.SIGTERM)
            candump.wait()
        zeros = [line for line in open(dump) if " 201#000000000000" in line and float(line.split()[0].strip("()")) * 1e6 >= since]
        demand(zeros, "signal", number, "sent no centre")
        worst = max(worst, last_commands(dump, since))
    demand(worst <= 5, "valves were driven for", worst, "ms")
    return f"{len(ERRORS)} signals, driven on for {worst:.1f} ms at most"
