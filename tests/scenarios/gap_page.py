"""Opens a gap report in a headless Chromium: gap_page.py REPORT PICTURES WORK. A probe added to a copy of the page measures what a reader
would see: each picture's size and ink, the width of the page, where the first screen ends."""
import html
import json
import re
import subprocess
import sys

report, pictures, work = sys.argv[1], int(sys.argv[2]), sys.argv[3]
page = open(report, encoding="utf-8").read()
assert not re.search(r"<script|(?:src|href)=\"(?!data:)|url\((?!data:)|@import", page), "the page wants something from outside"

PROBE = """<pre id="probe"></pre><script>addEventListener('load', () => {
  const ink = image => {
    const canvas = document.createElement('canvas'), pen = canvas.getContext('2d');
    canvas.width = image.naturalWidth; canvas.height = image.naturalHeight;
    pen.drawImage(image, 0, 0);
    const p = pen.getImageData(0, 0, canvas.width, canvas.height).data;
    let dark = 0, blue = 0;
    for (let i = 0; i < p.length; i += 4) { dark += p[i] + p[i + 1] + p[i + 2] < 240; blue += p[i + 2] - p[i] > 100; }
    return {width: canvas.width, dark, blue};
  };
  const bottom = name => Math.max(...[...document.querySelectorAll(name)].map(e => e.getBoundingClientRect().bottom));
  document.getElementById('probe').textContent = JSON.stringify({pictures: [...document.images].map(ink),
    width: document.documentElement.scrollWidth, first: bottom('.cards, .next'), title: document.title,
    cells: document.querySelectorAll('table.map td[style]').length});
});</script></body>"""
probed = work + "/probed.html"
open(probed, "w", encoding="utf-8").write(page.replace("</body>", PROBE))
dom = subprocess.run(["chromium", "--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--no-first-run",
                      "--disable-background-networking", "--user-data-dir=" + work + "/chromium", "--window-size=1280,800", "--dump-dom",
                      "file://" + probed], check=True, capture_output=True, text=True, timeout=300).stdout
seen = json.loads(html.unescape(re.search(r'<pre id="probe">(.*?)</pre>', dom, re.S).group(1)))
print(seen)
assert len(seen["pictures"]) == pictures
for picture in seen["pictures"]:
    assert picture["width"] >= 370
    assert picture["dark"] > 500 and picture["blue"] > 300, "axes and curves are missing"  # a line of text has about 300 dark pixels
assert seen["width"] <= 1280, "wider than the window"
assert seen["first"] <= 800, "the first screen does not hold what is missing, how sure that is, how much is gone"
assert seen["cells"] > 0
