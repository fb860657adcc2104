"""A headless Chromium, driven by its DevTools protocol over a pipe: no port, no other package.

    with Browser(directory) as page:
        page.open(url)
        page.wait("document.title.startsWith('ready')")"""
import base64
import json
import os
import subprocess
import time

VIEWS = [(width, dark) for width in (1200, 420) for dark in (False, True)]
PATIENCE_S = 60  # time-out of a page; a claim about time measures the time itself


class Browser:
    def __init__(self, directory):
        to_browser, self.write = os.pipe()
        self.read, from_browser = os.pipe()

        def place():  # where --remote-debugging-pipe looks
            high = [os.dup(fd) for fd in (to_browser, from_browser)]
            for fd, target in zip(high, (3, 4)):
                os.dup2(fd, target)

        self.process = subprocess.Popen(
            ["chromium", "--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--no-first-run",
             "--disable-background-networking", "--hide-scrollbars", "--remote-debugging-pipe", f"--user-data-dir={directory}/chromium",
             "about:blank"], preexec_fn=place, close_fds=False, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL)
        os.close(to_browser)
        os.close(from_browser)
        self.number, self.buffer, self.session, self.events = 0, b"", None, []
        target = next(t for t in self.send("Target.getTargets")["targetInfos"] if t["type"] == "page")
        self.session = self.send("Target.attachToTarget", targetId=target["targetId"], flatten=True)["sessionId"]
        for domain in "Page", "Runtime", "Log", "Network":
            self.send(domain + ".enable")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        os.close(self.write)
        os.close(self.read)
        self.process.terminate()
        self.process.wait()

    def message(self):
        while b"\0" not in self.buffer:
            more = os.read(self.read, 1 << 16)
            assert more, "the browser ended"
            self.buffer += more
        one, self.buffer = self.buffer.split(b"\0", 1)
        return json.loads(one)

    def send(self, method, **params):
        self.number += 1
        session = {"sessionId": self.session} if self.session else {}
        os.write(self.write, json.dumps({"id": self.number, "method": method, "params": params, **session}).encode() + b"\0")
        while True:
            got = self.message()
            if got.get("id") == self.number:
                assert "error" not in got, (method, got["error"])
                return got["result"]
            if "method" in got:
                self.events.append(got)

    def evaluate(self, expression):
        got = self.send("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        assert "exceptionDetails" not in got, (expression, got["exceptionDetails"])
        return got["result"].get("value")

    def open(self, url):
        self.send("Page.navigate", url=url)
        self.wait(f"location.href == {json.dumps(url)} && document.readyState == 'complete'")

    def wait(self, expression, patience_s=PATIENCE_S):
        end = time.monotonic() + patience_s
        while not (value := self.evaluate(expression)):
            if time.monotonic() > end:
                page = self.evaluate("document.body.innerText")
                raise AssertionError(f"not within {patience_s} s: {expression}; the page says:\n{page}")
            time.sleep(0.02)
        return value

    def size(self, width, height, dark=False, scale=1):
        self.send("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=scale, mobile=False)
        self.send("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": "dark" if dark else "light"}])

    def views(self):
        """Shows the page at 1200 and 420 px, light and dark: it must be no wider than the window and follow the scheme."""
        for width, dark in VIEWS:
            self.size(width, 900, dark)
            self.wait("innerWidth == %d" % width)
            self.evaluate("new Promise(done => requestAnimationFrame(() => setTimeout(done, 200)))")
            wide, ground = self.evaluate("[document.documentElement.scrollWidth, getComputedStyle(document.body).backgroundColor]")
            light = sum(int(x) for x in ground[4:-1].split(",")) / 765
            assert wide <= width and (light < 0.2 if dark else light > 0.9), (width, dark, wide, ground)
            yield width, dark

    def overlaps(self):
        """Returns labels of pictures (SVG, in data of the page) that overlap."""
        return self.evaluate("""(() => {
            const pictures = [...document.querySelectorAll('img')].filter(i => i.src.startsWith('data:image/svg'));
            return pictures.flatMap(i => {
                const place = document.createElement('div'), found = [];
                place.innerHTML = new TextDecoder().decode(Uint8Array.from(atob(i.src.split('base64,')[1]), c => c.charCodeAt(0)));
                document.body.append(place);
                const label = [...place.querySelectorAll('text')].filter(e => e.textContent.trim());
                const box = label.map(e => e.getBoundingClientRect());
                for (let a = 0; a < box.length; a++) for (let b = a + 1; b < box.length; b++) {
                    const wide = Math.min(box[a].right, box[b].right) - Math.max(box[a].left, box[b].left);
                    const high = Math.min(box[a].bottom, box[b].bottom) - Math.max(box[a].top, box[b].top);
                    if (wide > 1 && high > 3) found.push(i.alt.slice(0, 40) + ': ' + label[a].textContent.trim() + ' | ' + label[b].textContent.trim());
                }
                place.remove();
                return label.length ? found : [i.alt + ': no label'];
            });
        })()""")

    def picture(self, path, whole=False):
        got = self.send("Page.captureScreenshot", format="png", captureBeyondViewport=whole)
        with open(path, "wb") as file:
            file.write(base64.b64decode(got["data"]))

    def heap_bytes(self):
        for _ in range(3):
            self.send("HeapProfiler.collectGarbage")
        return self.send("Runtime.getHeapUsage")["usedSize"]

    def complaints(self):
        """Returns the browser's complaints: script errors, violations of the content security policy, missing resources."""
        of = {"Runtime.exceptionThrown", "Log.entryAdded", "Runtime.consoleAPICalled"}
        self.send("Runtime.evaluate", expression="0")  # its answer comes after all earlier events
        return [e["params"] for e in self.events if e["method"] in of]

    def asked(self):
        """Returns the addresses that the page requested."""
        self.send("Runtime.evaluate", expression="0")
        return [e["params"]["request"]["url"] for e in self.events if e["method"] == "Network.requestWillBeSent"]
