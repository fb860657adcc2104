"""The live page as readers and attackers see it: live.py CLAIM WORK HEXID URL, in a network of its own. WORK has axis.lcm."""
import json
import pathlib
import signal
import socket
import subprocess
import sys
import threading
import time

sys.path.insert(0, str(pathlib.Path(__file__).parent.parent / "peers"))
from browser import Browser  # noqa: E402

WORK, HEXID, URL = sys.argv[2:5]
LCM = "--set", "lcm.url=" + URL
QUICK = [option for setting in ("sim.engine=closed_form", "motion.park_z_m=0.35", "motion.rate_mps=0.55",
                                           "motion.engage_s=1.6", "motion.park_s=1.6", "motion.hold_s=0.1",
                                "tests.settle_s=0.2", "tests.ramp_s=0.3", "tests.duration_s=1", "tests.ramp_out_s=0.2")
         for option in ("--set", setting)]
cleanup = []
TEXT = "document.body.innerText"
# Elements whose text is wider than they are, or that extend beyond the window; canvases without a mark.
CLIPPED = """[...document.querySelectorAll('td, th, h1, h2, p, figcaption, header span')].filter(e => e.offsetParent &&
    (e.scrollWidth > e.clientWidth + 1 && getComputedStyle(e).display != 'inline' || e.getBoundingClientRect().right > innerWidth + 1))
    .map(e => e.outerHTML)"""
BLANK = """[...document.querySelectorAll('canvas')].filter(c => { const blank = document.createElement('canvas');
    [blank.width, blank.height] = [c.width, c.height]; return !c.width || c.toDataURL() == blank.toDataURL(); }).length"""


class Monitor:
    """Runs hexid monitor --http, and has its address."""
    def __init__(self, *options, port=0):
        command = [HEXID, "monitor", *options, *LCM, "--http", f"127.0.0.1:{port}"]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        self.url = self.process.stdout.readline().split()[-1]
        self.port = int(self.url.split(":")[2].strip("/"))

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.send_signal(signal.SIGTERM)
        assert self.process.wait() == 0, "the monitor did not end well"


class Run:
    """Runs a hexid by the wall clock; its lines are stored as (time, line)."""
    def __init__(self, *options):
        command = [HEXID, "run", "--rt", "off", *QUICK, *LCM, *options]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.kill()
        self.process.wait()

    def line(self, word):
        """Returns the time of the first line with this word."""
        for line in self.process.stdout:
            if word in line:
                return time.time()
        raise AssertionError("no line of the run has " + word)


def page(monitor):
    browser = Browser(WORK)
    browser.size(1200, 900)
    browser.open(monitor.url)
    return browser


def state(word):
    return f"document.getElementById('state').textContent == '{word}'"


def fits(browser):
    """Checks that in every view no label is cut off and everything is drawn."""
    for width, dark in browser.views():
        seen = browser.evaluate(f"({{blank: {BLANK}, clipped: {CLIPPED}}})")
        print(width, "dark" if dark else "light", seen)
        assert not seen["blank"] and not seen["clipped"]


# Least distance between two legs of the drawing, divided by its size.
APART = """(async () => {
    const machine = await new Promise(done => { const source = new EventSource('events');
        source.addEventListener('machine', event => { source.close(); done(JSON.parse(event.data)); }); });
    const { Drawing, apart } = await import('./drawing.js'), drawing = new Drawing(document.createElement('canvas'), machine);
    return apart(drawing.upper, drawing.lower, drawing.turn) / drawing.size; })()"""


def draws():
    with Monitor() as monitor, page(monitor) as browser:
        browser.wait("document.getElementById('link').textContent == 'no hexid heard yet'")
        apart = browser.evaluate(APART)
        print(f"legs apart by {apart:.3f} of the drawing")
        assert apart > 0.06, "a leg hides another; a cylinder is 0.05 wide"
        with Run("--set", "tests.duration_s=2"):  # method C's requirement
            browser.wait(state("testing"))
            browser.wait("document.querySelectorAll('#tests tr')[1].textContent.includes(' mm')")  # the first result
            browser.wait("document.getElementById('matrix_state').textContent.includes('determined')")
            fits(browser)
            text = browser.evaluate(TEXT)
            before = browser.evaluate("document.getElementById('drawing').toDataURL()")
            browser.wait(f"document.getElementById('drawing').toDataURL() != {json.dumps(before)}")
        with Run("--fast"):
            browser.wait("document.getElementById('verdict').textContent.includes('Verdict of the run: ')")
            browser.wait(state("settled"))
        for word in "six legs", "leg 1", "Leg force", "Inertia matrix", "wake-up latency", "lost on the way":
            assert word in text, (word, text)
        assert not browser.complaints(), browser.complaints()
        elsewhere = [url for url in browser.asked() if not url.startswith((monitor.url, "data:", "about:"))]
        assert not elsewhere and len(browser.asked()) > 5, elsewhere


def fault_once(options, word, shown):
    """Returns the seconds from the run's own line to the page's."""
    with Monitor() as monitor, page(monitor) as browser:
        browser.evaluate("""{ const box = document.getElementById('fault');
            new MutationObserver(() => { if (!box.hidden) window.faultSince ??= Date.now(); }).observe(box, {attributes: true}); }""")
        browser.wait("document.getElementById('machine').textContent != ''")
        with Run(*options) as run:
            told = run.line(word)
            browser.wait("window.faultSince")
            took = browser.evaluate("window.faultSince") / 1e3 - told
            browser.wait(state("fault"))
            text = browser.evaluate("document.getElementById('fault').innerText")
            print(f"{took:.3f} s", repr(text))
            assert shown in text and "most likely" in text and "To do: " in text and not browser.complaints()
            assert browser.evaluate("document.title").startswith("FAULT")
    return took


def fault():
    """One of up to three tries must be within the second, since the machine itself may stall for so long."""
    tries = []
    for _ in range(3):
        tries.append(fault_once(["--hal", "fault:freeze@3+60/3;sim:"], "fault", "standstill, leg 3"))  # this run ends with its fault
        if tries[-1] < 1:
            return
    raise AssertionError(f"none within a second: {tries}")


def restarts():
    with Monitor() as monitor, page(monitor) as browser:
        with Run():
            browser.wait(state("testing"))
        browser.wait("document.getElementById('link').textContent.startsWith('nothing heard for')")
        assert "until 2 s ago" in browser.evaluate(TEXT) and browser.evaluate("document.querySelectorAll('#loop .old').length") == 1
        with Run():
            browser.wait("document.getElementById('link').textContent == 'live'")
            assert browser.evaluate("document.querySelectorAll('#loop .old').length") == 0 and " ago\n" in browser.evaluate(TEXT)
            browser.wait("document.getElementById('when').textContent.startsWith('run 2')")
            browser.wait(state("testing"))
            monitor.process.terminate()  # ends its server as well
            browser.wait("document.getElementById('link').textContent.includes('is gone')")
            monitor.process.wait()
            with Monitor(port=monitor.port):
                browser.wait("document.getElementById('link').textContent == 'live'")
                browser.wait("document.querySelectorAll('#tests tr')[1].textContent.includes(' mm')")


def cylinder():
    with Monitor("-c", "config/axis.yaml") as monitor, page(monitor) as browser:
        player = subprocess.Popen(["lcm-logplayer", "--lcm-url=" + URL, WORK + "/axis.lcm"], stdout=subprocess.DEVNULL)
        cleanup.append(player.kill)
        browser.wait("document.getElementById('pose').textContent.includes('position')")
        browser.wait("Number(document.getElementById('loop').rows[0]?.cells[1].textContent) > 600")
        fits(browser)
        assert browser.evaluate("document.querySelectorAll('canvas.empty').length") == 2  # neither pressures nor valve in this recording
        text = browser.evaluate(TEXT)
        print(text)
        for word in "a single cylinder", "position, mm", "Force, N", "Pressure, MPa":
            assert word in text, word
        for word in "leg", "platform", "matrix", "mrad", "Tests", "NaN", "undefined", "null":
            assert word not in text, word
        assert not browser.complaints(), browser.complaints()


def ask(port, request, host="127.0.0.1"):
    with socket.create_connection(("127.0.0.1", port), timeout=20) as s:
        s.sendall(f"{request} HTTP/1.1\r\n{f'Host: {host}' if host else 'X: y'}\r\nConnection: close\r\n\r\n".encode())
        answer = b""
        while more := s.recv(65536):
            answer += more
    head, _, body = answer.partition(b"\r\n\r\n")
    return int(head.split()[1]), head.decode().lower(), body


def requests():
    with Monitor() as monitor:
        port = monitor.port
        status, head, body = ask(port, "GET /")
        assert status == 200 and b"<!DOCTYPE html>" in body and "default-src 'none'" in head and "nosniff" in head
        assert ask(port, "HEAD /")[::2] == (200, b"")
        assert ask(port, "GET /page.css")[0] == ask(port, "GET /live.js")[0] == 200
        for method in "POST", "PUT", "DELETE", "OPTIONS", "HEXID":
            status, head, _ = ask(port, method + " /")
            assert status == 405 and "allow: get, head" in head, method
        for path in "/none", "/../config/tian2015.yaml", "/live.html/", "//", "/%2e%2e/Makefile":
            assert ask(port, "GET " + path)[0] == 404, path
        for host in "evil.example", "evil.example:80", "localhost.evil.example":
            assert ask(port, "GET /", host)[0] == 403 and ask(port, "GET /events", host)[0] == 403, host
        assert ask(port, "GET /", None)[0] in (400, 403)
        assert ask(port, "GET /", "localhost:9999")[0] == 200
        for junk in b"\0" * 5000, b"GET / HTTP/1.1\r\n" + b"X: " + b"y" * 100000 + b"\r\n\r\n", b"GET " + b"/" * 70000:
            with socket.create_connection(("127.0.0.1", port)) as s:
                try:
                    s.sendall(junk)
                except OSError:
                    pass  # disconnected
        assert ask(port, "GET /")[0] == 200


def stream(port):
    s = socket.create_connection(("127.0.0.1", port), timeout=20)
    s.sendall(b"GET /events HTTP/1.1\r\nHost: localhost\r\n\r\n")
    return s


def slow():
    """There are as many idle readers as the server has places for, and one that reads: that one gets all cycles, and the monitor does not
    grow."""
    with Monitor() as monitor, Run("--set", "lcm.state_every=5", "--set", "tests.duration_s=5"):
        good = stream(monitor.port).makefile("rb")
        sleepers = [stream(monitor.port) for _ in range(15)]
        for s in sleepers:
            s.recv(12)
        assert ask(monitor.port, "GET /events")[0] == 503
        seqs, sizes = [], []
        while len(seqs) < 200:
            line = good.readline()
            if line.startswith(b"data: [{\"seq\""):
                seqs += [c["seq"] for c in json.loads(line[6:])]
                sizes.append(kilobytes(monitor.process.pid))
        steps = {b - a for a, b in zip(seqs, seqs[1:])}
        print(len(seqs), "cycles, apart", steps, "kB", sizes[len(sizes) // 2], sizes[-1])
        assert steps == {10}, "cycles are missing"
        assert sizes[-1] < sizes[len(sizes) // 2] + 2000


def sparse():
    """With one state in 200 cycles the strips still show lines; the seventeenth reader gets a message."""
    blue = """(c => { const p = c.getContext('2d').getImageData(0, 0, c.width, c.height).data; let n = 0;
        for (let i = 0; i < p.length; i += 4) n += p[i] < 30 && Math.abs(p[i + 1] - 114) < 30 && Math.abs(p[i + 2] - 178) < 30;
        return n; })(document.querySelectorAll('#strips canvas')[2])"""
    with Monitor() as monitor:
        with page(monitor) as browser, Run("--set", "lcm.state_every=200", "--set", "tests.duration_s=4"):
            browser.wait(state("testing"))
            browser.wait(blue + " > 100")
        readers = []
        while len(readers) < 16:  # the closed browser may occupy its place for a moment
            s = stream(monitor.port)
            if s.recv(12).endswith(b"200"):
                readers.append(s)
            else:
                s.close()
                time.sleep(0.1)
        with page(monitor) as browser:
            browser.wait("document.getElementById('link').textContent.startsWith('not let in')")
            readers[0].close()
            browser.wait("document.getElementById('link').textContent.startsWith('nothing heard')")


def strangers():
    """Foreign texts are plain text in the page: nothing runs, nothing is loaded."""
    with Monitor() as monitor, page(monitor) as browser:
        browser.wait("document.getElementById('link').textContent == 'no hexid heard yet'")
        subprocess.run([sys.executable, "tests/peers/hostile.py", WORK, URL], check=True)
        browser.wait("document.getElementById('events').textContent.includes('the last one')")
        assert "<img src=x onerror=" in browser.evaluate(TEXT) and not browser.evaluate("window.hurt")
        assert not browser.complaints(), browser.complaints()


def kilobytes(pid):
    return int(next(line for line in open(f"/proc/{pid}/status") if line.startswith("VmRSS")).split()[1])


def hour():
    """An hour of a loop's time, 1.8 million cycles: a log of 73 s played 50 times at 20 times its speed, each time a new start. After the
    first tenth neither the server nor the page may grow: a leak of ten bytes per cycle would be 16 MB in the server and 1.6 MB in the
    page, which gets one in ten."""
    plays, warm, most_kb, most_heap = 50, 5, 1000, 500_000
    with Monitor() as monitor, page(monitor) as browser:
        for play in range(1, plays + 1):
            subprocess.run(["lcm-logplayer", "--speed=20", "--lcm-url=" + URL, WORK + "/run.lcm"], check=True, stdout=subprocess.DEVNULL)
            browser.wait(f"document.getElementById('when').textContent.startsWith('run {play} ')" if play > 1 else state("settled"))
            if play in (warm, plays):
                got = (kilobytes(monitor.process.pid), browser.heap_bytes(), browser.evaluate("document.querySelectorAll('*').length"),
                       browser.evaluate("document.getElementById('loop').innerText.match(/messages of its state\\s+([0-9]+)/)[1]"))
                print(f"after {play} plays: server {got[0]} kB, page's heap {got[1]} bytes, {got[2]} elements, {got[3]} states in the last",
                      flush=True)
                before = got if play == warm else before
        assert got[0] - before[0] < most_kb and got[1] - before[1] < most_heap and got[2] <= before[2] + 10
        assert not browser.complaints(), browser.complaints()


def drain(connection):
    while connection.recv(65536):
        pass


def cost():
    """Prints the processor time of the server in per cent of one processor, with 0 to 16 readers of a run by the wall clock: 50 states per
    second."""
    ticks = lambda pid: sum(int(x) for x in open(f"/proc/{pid}/stat").read().rsplit(")", 1)[1].split()[11:13])
    with Monitor() as monitor, Run("--set", "tests.duration_s=20"):
        time.sleep(3)  # engaged
        readers = 0
        for count in 0, 1, 5, 16:
            while readers < count:
                threading.Thread(target=drain, args=(stream(monitor.port),), daemon=True).start()
                readers += 1
            time.sleep(1)
            before, began = ticks(monitor.process.pid), time.monotonic()
            time.sleep(10)
            share = (ticks(monitor.process.pid) - before) / (time.monotonic() - began)
            print(f"{count} readers: {share:.2f} %, {kilobytes(monitor.process.pid)} kB", flush=True)


if __name__ == "__main__":
    try:
        globals()[sys.argv[1]]()
    finally:
        for end in cleanup:
            end()
