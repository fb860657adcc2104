"""The scorecard of score.py's lines as text and as a self-contained page."""
import csv, html, math

FIELDS = ["truth", "size", "seed", "series", "shape", "verdict", "named", "ambiguous_with", "score", "z", "error", "right", "covered",
          "values", "sigmas", "where", "before", "after", "floor", "ratio", "seconds", "remark", "white", "weak",
          "certainty", "stated", "family"]
SIZES = ("detectable", "typical", "strong")
DETECTABLE_Z = 6  # threshold for z of the likelihood ratio after the fit of the base


def read(files):
    """Returns the rows of the files; a line that begins with # names their build, and rows of older ones have fewer fields."""
    return [row for f in files for row in csv.DictReader((line for line in open(f) if line[0] != "#"), FIELDS, restval="") if row["truth"] != "truth"]


def builds(files): return sorted({line[1:].strip() for f in files for line in open(f) if line[0] == "#"})


def score(rows): return sum(float(r["score"]) for r in rows)


def weak(r): return r["weak"] == "1"  # True if the case counts as right because signatures of this size cannot be distinguished.


def share(rows): return "%5.1f %% of %d" % (100 * score(rows) / len(rows), len(rows)) if rows else "-"


def at(values, share): return values[int(share * len(values))]


def unknown(r): return r["truth"].startswith("unknown_")


def nearly(r): return r["truth"].startswith("nearly_")


def single(r): return r["truth"] != "none" and "+" not in r["truth"] and not unknown(r) and not nearly(r)


def detectable(r): return single(r) and r["z"] and float(r["z"]) >= DETECTABLE_Z


# True unless z shows that the missed effect is invisible with the other one in the model.
def both_show(r): return float(r["score"]) > 0 or not r["z"] or float(r["z"]) >= DETECTABLE_Z


def wrong_name(r):
    """Returns whether the verdict names another effect than the hidden one; of what the catalogue lacks, anything of another family."""
    if nearly(r): return r["family"] == "wrong"
    if unknown(r): return r["verdict"] in ("effect_named", "partly_named") and r["family"] != "right"
    return r["verdict"] == "effect_named" and float(r["score"]) == 0


def said(r): return " ".join((r["verdict"] + " " + r["named"] + (" | " + r["ambiguous_with"] if r["ambiguous_with"] else "") + r["remark"]).split())


def otherwise(r): return "%s %s s%s%s: %s" % (r["size"], r["shape"], r["seed"], "" if r["series"] == "tolerance" else " " + r["series"], said(r))


def figures(ran):
    """Yields the figures of the scorecard with their names."""
    for series in ("tolerance", "beyond"):
        of = [r for r in ran if r["series"] == series]
        if not of: continue
        seen, none = [r for r in of if detectable(r)], [r for r in of if r["truth"] == "none"]
        yield "base %s: single effects, detectable, right first" % series, "%s; wrong names %d" % (share(seen), len(list(filter(wrong_name, seen))))
        alike = list(filter(weak, seen))
        if alike: yield "    the same, with sets of weak effects as half", "%5.1f %%, %d of them" % (100 * (score(seen) - .5 * len(alike)) / len(seen), len(alike))
        for size in SIZES:
            if any(r["size"] == size for r in seen): yield "    " + size, share([r for r in seen if r["size"] == size])
        yield "    not detectable (z < %d)" % DETECTABLE_Z, "%d, of these %d with a wrong name" % (
            len([r for r in of if single(r) and not detectable(r)]), len([r for r in of if single(r) and not detectable(r) and wrong_name(r)]))
        yield "    nothing hidden: no gap", "%s; unknown_effect %d, named %d" % (
            share(none), sum(r["verdict"] == "unknown_effect" for r in none), sum(r["verdict"] in ("effect_named", "ambiguous") for r in none))
        two = [r for r in of if "+" in r["truth"]]
        yield "    two effects, both named", "%s; of these both show in %s" % (share(two), share([r for r in two if both_show(r)]))
        yield from foreign_figures(of)
    right = [r for r in ran if r["right"] and float(r["score"]) == 1 and r["verdict"] == "effect_named" and single(r)]
    if right:
        ratio = sorted(float(r["ratio"]) for r in right)
        yield "held-out gap over the noise floor", "median %.3f, 95 %% %.3f, most %.3f" % (at(ratio, .5), at(ratio, .95), ratio[-1])
    typical = [r for r in right if r["size"] == "typical"]
    if typical:
        error = sorted(float(r["error"]) for r in typical)
        yield "parameters, typical: within 5 % or two deviations", "%d of %d cases" % (sum(r["right"] == "1" for r in typical), len(typical))
        yield "    error over what was hidden", "median %.3f, 90 %% %.3f, most %.3f" % (at(error, .5), at(error, .9), error[-1])
    values = sum(int(r["values"]) for r in right)
    if values: yield "truth within two stated deviations", "%.1f %% of %d values" % (100 * sum(int(r["covered"]) for r in right) / values, values)
    seconds = sorted(float(r["seconds"]) for r in ran if r["seconds"])
    if seconds: yield "time of the workflow", "median %.1f s, most %.1f s" % (at(seconds, .5), seconds[-1])


def foreign_figures(rows):
    """Yields the figures of laws that are nearly the catalogue's, and of effects that it lacks altogether, by kind."""
    near, far = list(filter(nearly, rows)), list(filter(unknown, rows))
    silent = lambda rs: sum(r["verdict"] in ("no_gap", "unknown_effect") for r in rs)
    wrong = lambda rs: sum(map(wrong_name, rs))
    for head, name in [("    laws that are nearly right: right family", None)] + [("        " + n, n) for n in sorted({r["truth"] for r in near})]:
        rs = [r for r in near if name in (None, r["truth"])]
        if rs: yield head, "%s; wrong names %d, no name %d" % (share(rs), wrong(rs), silent(rs))
    for head, name in [("    not in the catalogue: unknown_effect", None)] + [("        " + n, n) for n in sorted({r["truth"] for r in far})]:
        rs = [r for r in far if name in (None, r["truth"])]
        yield head, share(rs) + ("; wrong names %d, wrong sets %d, right family %d, no gap %d" % (
            wrong(rs), sum(r["verdict"] == "ambiguous" and r["family"] == "wrong" for r in rs), sum(r["family"] == "right" for r in rs),
            sum(r["verdict"] == "no_gap" for r in rs)) if rs else "")


BINS = (0, .5, .8, .95, .99, 1)


def binomial_interval(k, n, sure=.95):
    """Returns the exact (Clopper-Pearson) interval of a share, k of n."""
    def at_most(k, p):
        ways = lambda i: math.lgamma(n + 1) - math.lgamma(i + 1) - math.lgamma(n - i + 1)
        return sum(math.exp(ways(i) + i * math.log(p) + (n - i) * math.log1p(-p)) for i in range(k + 1))
    def root(falls):
        low, high = 0.0, 1.0
        for _ in range(50):
            middle = (low + high) / 2
            low, high = (middle, high) if falls(middle) else (low, middle)
        return low
    tail = (1 - sure) / 2
    return (root(lambda p: 1 - at_most(k - 1, p) < tail) if k else 0.0), (root(lambda p: at_most(k, p) > tail) if k < n else 1.0)


def calibration(ran):
    """Returns for each bin of stated certainty its ends, the number of verdicts, their mean certainty, and the share that is true at the level
    stated with its 95 % interval; bins without a verdict are left out."""
    said = [(float(r["certainty"]), r["stated"] == "1") for r in ran if r["certainty"] and r["stated"]]
    rows = []
    for low, high in zip(BINS, BINS[1:]):
        of = [x for x in said if low <= x[0] < high or (x[0] == high == 1)]
        true = sum(t for _, t in of)
        if of: rows.append((low, high, len(of), sum(c for c, _ in of) / len(of), true / len(of), *binomial_interval(true, len(of))))
    return rows


def calibration_lines(ran):
    """Yields the cells of the table of calibration: of all verdicts that state a certainty, then by what was hidden."""
    groups = [("all", lambda r: True), ("one or two effects, or none", lambda r: not nearly(r) and not unknown(r)),
              ("laws that are nearly right", nearly), ("not in the catalogue", unknown)]
    for name, of in groups:
        for low, high, count, mean, right, least, most in calibration(list(filter(of, ran))):
            yield name, "%g to %g" % (low, high), "%d" % count, "%.3f" % mean, "%.1f %%" % (100 * right), "%.1f to %.1f %%" % (100 * least, 100 * most)


CALIBRATION_HEAD = ("hidden", "certainty", "verdicts", "mean", "true", "95 % interval")


def reliability_diagram(ran):
    """Draws the share of true verdicts over their stated certainty, as SVG: on the diagonal certainties are what they say."""
    size, edge = 260, 40
    x, y = lambda p: edge + size * p, lambda p: 10 + size * (1 - p)
    line = lambda x0, y0, x1, y1, more="": "<line x1='%.1f' y1='%.1f' x2='%.1f' y2='%.1f' stroke='currentColor' %s/>" % (x0, y0, x1, y1, more)
    text = lambda at, to, words, more="": "<text x='%.1f' y='%.1f' %s>%s</text>" % (at, to, more, words)
    parts = ["<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 %d %d' width='%d' height='%d' font-size='11' fill='currentColor' "
             "font-family='system-ui, sans-serif'>" % (size + edge + 20, size + edge + 10, size + edge + 20, size + edge + 10),
             line(x(0), y(0), x(1), y(1), "stroke-dasharray='3 3' opacity='.5'"), line(x(0), y(0), x(1), y(0)), line(x(0), y(0), x(0), y(1))]
    for tick in (0, .5, 1):
        parts += [text(x(tick), y(0) + 14, "%g" % tick, "text-anchor='middle'"), text(x(0) - 6, y(tick) + 4, "%g" % tick, "text-anchor='end'")]
    parts += [text(x(.5), y(0) + 28, "stated certainty", "text-anchor='middle'"),
              text(0, 0, "share that is true", "text-anchor='middle' transform='translate(12 %.1f) rotate(-90)'" % y(.5))]
    for low, high, count, mean, right, least, most in calibration(ran):
        parts += [line(x(mean), y(least), x(mean), y(most), "stroke-width='1.5'"),
                  "<circle cx='%.1f' cy='%.1f' r='3.5'><title>%d verdicts from %g to %g</title></circle>" % (x(mean), y(right), count, low, high)]
    return "".join(parts) + "</svg>"


def of_effect(ran, name):
    """Returns the right cases by size, and the smallest size at which all were named right."""
    rows = [r for r in ran if r["truth"] == name]
    by_size = [(size, [r for r in rows if r["size"] == size]) for size in SIZES]
    by_size = [(size, of) for size, of in by_size if of]
    smallest = next((size for k, (size, _) in enumerate(by_size) if all(score(of) == len(of) for _, of in by_size[k:])), "-")
    return ", ".join("%s %g/%d" % (size, score(of), len(of)) for size, of in by_size), smallest


def report(files, page=None):
    rows, of = read(files), builds(files)
    ran, not_run = [r for r in rows if r["score"] != ""], [r for r in rows if r["score"] == ""]
    if not ran: raise SystemExit("score.py report: no case ran: nothing was measured")
    for build in of: print(build)
    print("%-28s %-40s %s" % ("hidden", "right of cases, by size", "named otherwise"))
    for name in sorted({r["truth"] for r in ran}):
        wrong = [r for r in ran if r["truth"] == name and float(r["score"]) < 1]
        print("%-28s %-40s %s" % (name, of_effect(ran, name)[0], "; ".join(map(otherwise, wrong))))
    for name, figure in figures(ran): print("%-56s %s" % (name, figure))
    lines = list(calibration_lines(ran))
    for cells in [CALIBRATION_HEAD] + lines if lines else []: print("%-28s %-12s %8s %8s %8s   %s" % cells)
    for r in not_run: print("not a case: %s %s %s %s: %s" % (r["truth"], r["size"], r["seed"], r["shape"], r["remark"]))
    if page:
        with open(page, "w") as out: out.write(as_page(ran, not_run, of))


STYLE = """:root{color-scheme:light dark;--ink:#222;--paper:#fff;--line:#ddd;--ok:#cfe8cf;--half:#fbeec1;--no:#f3c6c1;--weak:#e2e2e2}
@media(prefers-color-scheme:dark){:root{--ink:#e8e8e8;--paper:#1a1a1a;--line:#444;--ok:#1f4d2b;--half:#574708;--no:#6a2720;--weak:#444}}
body{font:14px/1.45 system-ui,sans-serif;margin:2em auto;max-width:1500px;padding:0 1em;color:var(--ink);background:var(--paper)}
h1{font-size:22px} h2{font-size:17px;margin-top:2em} .wide{overflow-x:auto} table{border-collapse:collapse}
td,th{padding:2px 8px;text-align:left;vertical-align:top}
tr+tr td{border-top:1px solid var(--line)} .m td,.m th{padding:1px 3px;text-align:center;border:1px solid var(--line);min-width:16px}
.m th:first-child{text-align:right;font-weight:400;white-space:nowrap} .m thead th{font-weight:400;vertical-align:bottom;height:190px}
.m thead th span{writing-mode:vertical-rl;transform:rotate(180deg);white-space:nowrap}
.ok{background:var(--ok)} .half{background:var(--half)} .no{background:var(--no)} .weak{background:var(--weak)}"""


def verdict_of(r): return r["named"].split()[0] if r["verdict"] == "effect_named" and r["named"] else r["verdict"] or "refused"


def matrix(ran):
    """Makes a table with a row per hidden effect and a column per effect named first; green is right, yellow half, grey too weak to be
    seen."""
    verdicts = ["ambiguous", "unknown_effect", "no_gap", "refused"]
    truths, said = sorted({r["truth"] for r in ran if "+" not in r["truth"]}), {verdict_of(r) for r in ran if "+" not in r["truth"]}
    columns = sorted({t for t in truths if single({"truth": t})} | said - set(verdicts)) + verdicts
    head = "".join("<th><span>%s</span></th>" % html.escape(c) for c in columns)
    lines = ["<div class=wide><table class=m><thead><tr><th></th>%s</tr></thead>" % head]
    for truth in truths:
        cells = ""
        for c in columns:
            of = [r for r in ran if r["truth"] == truth and verdict_of(r) == c]
            right = score(of) / len(of) if of else 0
            weak = of and all(single(r) and not detectable(r) for r in of)
            mark = "" if not of else "ok" if right == 1 else "weak" if weak else "half" if right > 0 else "no"
            cells += "<td class='%s'>%s</td>" % (mark, len(of) or "")
        lines.append("<tr><th>%s</th>%s</tr>" % (html.escape(truth), cells))
    return "\n".join(lines) + "</table></div>"


def table(head, rows):
    line = lambda tag, cells: "<tr>" + "".join("<%s>%s</%s>" % (tag, html.escape(c).replace("    ", "&emsp;"), tag) for c in cells) + "</tr>"
    return "<div class=wide><table>" + line("th", head) + "\n".join(line("td", r) for r in rows) + "</table></div>"


def values_of(ran, name):
    """Returns the median error relative to the hidden value of a typical size, and the share of values within two deviations."""
    right = [r for r in ran if r["truth"] == name and r["right"] and float(r["score"]) == 1]
    error = sorted(float(r["error"]) for r in right if r["size"] == "typical")
    count = sum(int(r["values"]) for r in right)
    covered = "%d of %d" % (sum(int(r["covered"]) for r in right), count) if count else "-"
    return "%.1f %%" % (100 * at(error, .5)) if error else "-", covered


def as_page(ran, not_run, of):
    effects = sorted({r["truth"] for r in ran if single(r)})
    misses = [r for r in ran if float(r["score"]) < 1 and (detectable(r) or not single(r))]
    by_effect = [(name, *of_effect(ran, name), *values_of(ran, name)) for name in effects]
    parts = ["<!doctype html><html lang=en><meta charset=utf-8><meta name=viewport content='width=device-width, initial-scale=1'><title>hexid gap: hidden effects</title><style>%s</style>" % STYLE,
             "<h1>Hidden effects against hexid gap: %d cases</h1>" % len(ran),
             *("<p>%s</p>" % html.escape(build) for build in of),
             table(("figure", "result"), list(figures(ran))),
             "<p>A case is one hidden effect in one simulated machine. z is the strength of evidence, comparable to a number of standard deviations; "
             "below %d an effect is not detectable. An ambiguous set that holds the hidden effect "
             "counts as half, or as right where its members are alike by their physics or, of just detectable effects, by their signatures (less than z = 4 between them).</p>" % DETECTABLE_Z,
             "<h2>Confusion matrix: hidden (rows), named first (columns)</h2>",
             "<p>Green: right. Yellow: partly right. Red: wrong. Grey: too weak to be detected.</p>", matrix(ran),
             "<h2>Each effect</h2>",
             table(("effect", "right of cases, by size", "named reliably from", "median parameter error, typical", "within two deviations"), by_effect),
             "<h2>Certainty</h2>",
             "<p>Of the verdicts that state a certainty, by bins of it: how many are true at the level stated, an effect or a family.</p>",
             reliability_diagram(ran), table(CALIBRATION_HEAD, list(calibration_lines(ran))),
             "<h2>Misses: what is detectable, two effects, none, unknown</h2>",
             table(("hidden", "size, legs, seed", "said", "z", "worst place"),
                   [(r["truth"], otherwise(r).split(":")[0], said(r), r["z"], r["where"]) for r in misses]) if misses else "<p>none</p>"]
    if not_run:
        parts += ["<h2>Not a case</h2>", table(("hidden", "size, seed", "why"), [(r["truth"], r["size"] + " s" + r["seed"], r["remark"]) for r in not_run])]
    return "\n".join(parts) + "\n"
