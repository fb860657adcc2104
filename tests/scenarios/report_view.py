"""Opens a page in a headless Chromium: report_view.py PAGE WORK. At 1200 and 420 pixels, in light and in dark, all its pictures are drawn
and fit, and no label of theirs lies on another. Its text stands out from its ground, no table column is so narrow that it shows single
letters, and elements that scroll sideways show that they do."""
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parent.parent / "peers"))
from browser import Browser  # noqa: E402

path, work = pathlib.Path(sys.argv[1]).resolve(), sys.argv[2]
LOOK = """(() => { const ink = getComputedStyle(document.body).color.match(/[0-9]+/g).slice(0, 3);
  const more = [...document.querySelectorAll('.wide, pre')].filter(e => e.scrollWidth > e.clientWidth);
  return {ink: ink.reduce((sum, c) => sum + Number(c), 0) / 765, images: [...document.images].filter(i => i.naturalWidth > 300).length,
    wide: Math.max(...[...document.images].map(i => i.width)), scrolls: more.length,
    unshaded: more.filter(e => !getComputedStyle(e).backgroundImage.includes('gradient')).length,
    highest: Math.max(...[...document.querySelectorAll('td code')].map(c => c.closest('tr').getBoundingClientRect().height), 0)}; })()"""
with Browser(work) as page:
    page.open(f"file://{path}")
    for width, dark in page.views():
        seen = page.evaluate(LOOK)
        print(width, "dark" if dark else "light", seen)
        assert seen["wide"] <= width, "a picture wider than the window"
        assert seen["images"] == path.read_text(encoding="utf-8").count("<img "), "a picture is not drawn"
        assert seen["ink"] > 0.8 if dark else seen["ink"] < 0.2, "not the colour scheme asked for"
        assert not seen["unshaded"] and seen["highest"] < 200
    overlaps = page.overlaps()
    assert not overlaps, overlaps
