"""A page at 1200 and 420 px, light and dark: narrow.py PAGE WORK [WORD...]. It is no wider than the window, though its tables may scroll;
no label of its pictures lies on another; none of the words is on it."""
import pathlib
import re
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parent.parent / "peers"))
from browser import Browser  # noqa: E402

path, work, words = pathlib.Path(sys.argv[1]).resolve(), sys.argv[2], sys.argv[3:]
with Browser(work) as page:
    page.open(f"file://{path}")
    print(*page.views())
    overlaps = page.overlaps()
    text = page.evaluate("document.body.innerText")
found = [m for word in words for m in re.findall(rf".*\b{word}\b.*", text)]
assert not found, found
assert not overlaps, overlaps
