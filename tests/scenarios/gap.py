"""hexid.gap/1.
gap.py FILE no_gap|EFFECT[,EFFECT]              is it named, and does the gap close?
gap.py repaired FILE IDENTIFICATION DIAGONAL COUPLING   percent: is the matrix without friction the nominal one?"""
import json
import sys


def load(path):
    with open(path) as f: return json.load(f)


def named(path, names):
    result, wanted = load(path), set(names.split(",")) - {"no_gap"}
    found, gap = {e["name"] for e in result["effects"]}, result["gap"]
    after, floor = gap["held_out_after"]["overall"], gap["noise_floor"]["overall"]
    print(result["verdict"], sorted(found), f"held out {gap['held_out_before']['overall']:.4f} -> {after:.4f}, noise {floor:.4f}")
    assert result["schema"] == "hexid.gap/1"
    for key in "ambiguous_with rejected where mean_white_square unexplained_fraction next_experiment base model".split():
        assert key in result, key
    assert result["verdict"] == ("effect_named" if wanted else "no_gap"), result["reason"]
    assert found == wanted
    assert [e["z"] for e in result["effects"]] == sorted((e["z"] for e in result["effects"]), reverse=True), "the surest first"
    if len(found) == 1 and found != {"clock_skew"}:
        only = result["effects"][0]
        assert only["share_explained"] == 1.0 and only["z"] > max(c["z"] for c in result["rejected"]) - 1, "one alone explains all that is gone"
    assert after <= 1.2 * floor


def repaired(path, identification, percent, deviations):
    """True if each entry is within `percent` of the nominal one and within `deviations` of its stated standard deviations."""
    mt, ident = load(path)["Mt"]["repaired"], load(identification)
    nominal, std = ident["nominal"]["Mt"], ident["method_a"]["std"]
    error = {f"{i + 1}{j + 1}": 100 * (mt[i][j] / nominal[i][j] - 1)
             for i, j in [(k, k) for k in range(6)] + [(0, 4), (1, 3), (3, 1), (4, 0)]}
    print(" ".join(f"{k} {e:+.2f}" for k, e in error.items()), "%")
    for k, e in error.items():
        i, j = int(k[0]) - 1, int(k[1]) - 1
        bound = float(percent) + float(deviations) * abs(100 * std[i][j] / nominal[i][j])
        assert abs(e) <= bound, f"{k} {e:+.2f} %, bound {bound:.2f} %"


if sys.argv[1] == "repaired": repaired(*sys.argv[2:])
else: named(*sys.argv[1:])
