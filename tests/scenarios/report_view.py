"""Opens a page in a headless Chromium: report_view.py PAGE WORK. At 1200 and 420 pixels, in light and dark, it must not be wider than the window,
and its text must stand out from its ground."""
import html
import json
import re
import subprocess
import sys

page, work = open(sys.argv[1], encoding="utf-8").read(), sys.argv[2]
# A window can be no narrower than some 500 pixels; a frame can.
FRAME = """<iframe id="f" style="border:0;width:%dpx;height:900px" srcdoc="%s"></iframe><pre id="probe"></pre><script>
document.getElementById('f').addEventListener('load', event => {
  const d = event.target.contentDocument, style = event.target.contentWindow.getComputedStyle(d.body);
  const light = colour => colour.match(/[0-9]+/g).slice(0, 3).reduce((sum, c) => sum + Number(c), 0) / 765;
  document.getElementById('probe').textContent = JSON.stringify({width: d.documentElement.scrollWidth, ground: light(style.backgroundColor),
    ink: light(style.color), images: [...d.images].filter(i => i.naturalWidth > 300).length, wide: Math.max(...[...d.images].map(i => i.width))});
});</script>"""
for width in 1200, 420:
    for dark in False, True:
        probed = work + "/probed.html"
        open(probed, "w", encoding="utf-8").write(FRAME % (width, html.escape(page)))
        scheme = ["--blink-settings=preferredColorScheme=0"] if dark else []
        dom = subprocess.run(["chromium", "--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--no-first-run",
                              "--disable-background-networking", "--user-data-dir=" + work + "/chromium", "--window-size=1280,1000", *scheme,
                              "--dump-dom", "file://" + probed], check=True, capture_output=True, text=True, timeout=300).stdout
        seen = json.loads(html.unescape(re.search(r'<pre id="probe">(.*?)</pre>', dom, re.S).group(1)))
        print(width, "dark" if dark else "light", seen)
        assert seen["width"] <= width and seen["wide"] <= width, "wider than the window"
        assert seen["images"] == page.count("<img "), "a picture is not drawn"
        assert seen["ground"] < 0.2 and seen["ink"] > 0.8 if dark else seen["ground"] > 0.9 and seen["ink"] < 0.2, "not the colour scheme asked for"
