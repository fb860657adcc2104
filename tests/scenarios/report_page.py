"""Compares a page of `hexid report` with the JSON of `hexid identify`: report_page.py PAGE JSON [JSON2 ...], one per log."""
import html
import html.parser
import json
import re
import sys

page = open(sys.argv[1], encoding="utf-8").read()
logs = [json.load(open(name)) for name in sys.argv[2:]]
ENTRIES = {"mx": (0, 0), "my": (1, 1), "mz": (2, 2), "Ixx": (3, 3), "Iyy": (4, 4), "Izz": (5, 5), "Mt15": (0, 4), "Mt24": (1, 3),
           "Mt42": (3, 1), "Mt51": (4, 0)}
SURE = 1.96


class Nesting(html.parser.HTMLParser):
    """Checks that every element is closed, in the order of opening."""
    open = []

    def handle_starttag(self, tag, attributes):
        if tag not in ("meta", "img", "br"): self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open and self.open.pop() == tag, (tag, self.getpos())


nesting = Nesting()
nesting.feed(page)
assert not nesting.open, nesting.open


def tables(kind):
    """Yields the rows of cells, without the small text beside a value."""
    for table in re.findall(rf'<table class="{kind}">(.*?)</table>', page, re.S):
        rows = [re.findall(r"<t[dh][^>]*>(.*?)</t[dh]>", row, re.S) for row in re.findall(r"<tr>(.*?)</tr>", table, re.S)]
        yield [[html.unescape(re.sub(r"<small>.*?</small>|<[^>]*>", "", cell)) for cell in row] for row in rows]


def shown(text, value, what):
    """Asserts that the text is this value, rounded to as many digits as the text has."""
    if value is None:
        assert text == "–", (what, text)
        return
    decimals = len(text.partition(".")[2])
    assert abs(float(text) - value) <= 0.500001 * 10.0 ** -decimals, (what, text, value)


def estimate(cell, value, std, what):
    if value is None:
        assert cell == "–", (what, cell)
        return
    text, _, interval = cell.partition(" ± ")
    shown(text, value, what), shown(interval, SURE * std, what)


def entry(log, method, place):
    found = log[method]
    return (found[key][place[0]][place[1]] for key in ("Mt", "std")) if found else (None, None)


values = list(tables("values"))
head, body = values[0][0], values[0][2 if len(logs) > 1 else 1:]
methods = [name for name in ("method_c", "method_a") if any(log[name] for log in logs)]
assert [row[0].split()[0] for row in body] == list(ENTRIES) and len(body[0]) == 2 + len(methods) * len(logs), values[0]
compared = 0
for row in body:
    place = ENTRIES[row[0].split()[0]]
    shown(row[1], logs[0]["nominal"]["Mt"][place[0]][place[1]], row[0])
    for i, cell in enumerate(row[2:]):
        estimate(cell, *entry(logs[i % len(logs)], methods[i // len(logs)], place), (row[0], i))
        compared += cell != "–"
assert compared >= 10, "nothing was compared"

payload, friction = values[1], values[2]
for row, (name, scale) in zip(payload[-10:], [("mass_kg", 1)] + [(f"center_{a}_m", 1e3) for a in "xyz"] +
                              [(f"inertia_{a}_kg_m2", 1) for a in ("xx", "yy", "zz", "xy", "xz", "yz")], strict=True):
    for log, cell in zip(logs, row[2:], strict=True):
        found = log["method_c"]["payload"]
        estimate(cell, scale * found["value"][name], scale * found["std"][name], name)
for leg, row in enumerate(friction[-6:]):
    for i, cell in enumerate(row[1:]):
        c, kind = logs[i % len(logs)]["method_c"], i // len(logs)
        pair = [(c["viscous_n_s_per_m"], c["viscous_std_n_s_per_m"])] + [(c["dry_friction_n"][w], c["dry_friction_n"][w + "_std"])
                                                                        for w in ("extend", "retract")]
        estimate(cell, pair[kind][0][leg], pair[kind][1][leg], ("leg", leg + 1, kind))

names = re.findall(r"<h3>(Nominal|Method [ABC]|Modified A)</h3>", page)
matrices = list(tables("matrix"))
expected = [(name, log[key]) for log in logs for name, key in (("Nominal", "nominal"), ("Method C", "method_c"), ("Method A", "method_a"),
                                                               ("Modified A", "modified_a"), ("Method B", "method_b")) if log[key]]
assert names == [name for name, _ in expected], names
for table, (name, found) in zip(matrices, expected, strict=True):
    for i in range(6):
        for j in range(6):
            shown(table[1 + i][1 + j], found["Mt"][i][j], (name, i, j))
intervals = [re.findall(r"<small>± (.*?)</small>", table) for table in re.findall(r'<table class="matrix">(.*?)</table>', page, re.S)]
for texts, (name, found) in zip(intervals, expected, strict=True):
    stds = [std for row in found["std"] for std in row if std is not None] if "std" in found else []
    for text, std in zip(texts, stds, strict=True):
        shown(text, SURE * std, (name, "interval"))
assert page.count("Every ± on this page") == 1 and page.count("95 % interval") == 1, "the interval is explained once"

tests, friction_pictures = sum(len(log["tests"]) or 1 for log in logs), 6 * len(logs)
assert page.count("<img ") == 1 + tests + friction_pictures, page.count("<img ")
for log in logs:
    assert f"Verdict <b>{log['verdict']['status']}</b>" in page
for words in ("Payload", "Friction", "All entries of the matrix", "Motion and leg forces", "Friction of each leg", "Checks", "Configuration"):
    assert page.count(f"{words}</h2>") == (1 if words in ("Payload", "Friction") else len(logs)), words
assert not re.search(r"<script|(?:src|href)=\"(?!data:)|url\((?!data:)|@import", page), "the page wants something from outside"
assert len(page) < 0.7e6 * len(logs), len(page)
print(compared, "entries,", len(matrices), "matrices,", len(page), "bytes")
