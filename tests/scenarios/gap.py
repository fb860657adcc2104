"""hexid.gap/1: gap.py FILE no_gap|EFFECT[,EFFECT]: is it named, and does the gap close?"""
import json
import sys

result = json.load(open(sys.argv[1]))
wanted = set(sys.argv[2].split(",")) - {"no_gap"}
named = {e["name"] for e in result["effects"]}
gap = result["gap"]
after, floor = gap["held_out_after"]["overall"], gap["noise_floor"]["overall"]
print(result["verdict"], sorted(named), f"held out {gap['held_out_before']['overall']:.4f} -> {after:.4f}, noise {floor:.4f}")
assert result["schema"] == "hexid.gap/1"
for key in "ambiguous_with rejected where unexplained_fraction next_experiment base model".split():
    assert key in result, key
assert result["verdict"] == ("effect_named" if wanted else "no_gap"), result["reason"]
assert named == wanted
assert after <= 1.2 * floor
