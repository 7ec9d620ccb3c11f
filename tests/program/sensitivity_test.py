"""pavescape sensitivity: keys, holes, no data needed, the same for any number of threads, continued without repeating."""
import json
import math

from support import *

folder = workspace()
# No data: the outputs alone. base.n leaves the stable materials at its upper end.
OUTPUTS = """
[[outputs]]
name = "d0"
load = "fwd"
quantity = "deflection"
"""
BARE = STUDY[:STUDY.index("[data]")] + STUDY[STUDY.index("[[parameters]]"):] + OUTPUTS
study = write_study(folder, BARE, data=None)


def call(*arguments, status=0):
    done = run("sensitivity", *arguments, "--json")
    check(done.returncode == status, f"{arguments}: exit status {done.returncode}: {done.stderr}")
    check(status != 0 or done.stderr == "", f"{arguments}: standard error is silent when piped: {done.stderr}")
    return json.loads(done.stdout)


def timeless(result):
    return {key: value for key, value in result.items() if key not in ("run", "computed", "kept")}


small = ("--samples", 16, "--points", 5)
results = {threads: call(study, *small, "--threads", threads, "--out", folder / f"t{threads}") for threads in (1, 2)}
check(timeless(results[1]) == timeless(results[2]), "1 and 2 threads give the same result")
result = results[1]
check(json.loads((folder / "t1" / "sensitivity.json").read_text()) == result, "the same in the folder of the run")
check([p["name"] for p in result["parameters"]] == ["base.k1", "base.n"], "parameters")
check([(r["name"], r["unit"]) for r in result["responses"]] == [("subgrade-top-strain", "microstrain"), ("d0", "mm")], "responses: the outputs")

# The own values and the elasticities are those of the forward run.
forward = json.loads(run("forward", study, "--jacobian", "--json").stdout)
for i, response in enumerate(result["responses"]):
    value = forward["responses"][i]["value"]
    check(math.isclose(response["value"], value, rel_tol=1e-9), f"{response['name']}: the value of the forward run")
    for k, (name, own) in enumerate((("base.k1", 2000), ("base.n", 0.5))):
        want = forward["jacobian"]["rows"][i][k] * own / value
        check(math.isclose(response["elasticities"][name], want, rel_tol=1e-9), f"elasticity of {response['name']} by {name}")

# Curves: percentages of the study's own value, the middle is that value, the slope there is the elasticity.
check([c["parameter"] for c in result["curves"]] == ["base.k1", "base.n"], "one curve a parameter")
curve = result["curves"][0]["points"]
check([p["change_percent"] for p in curve] == [-50, -25, 0, 25, 50], "points of a curve")
check([p["value"] for p in curve] == [1000, 1500, 2000, 2500, 3000], "values of a curve")
check(all(abs(v) < 1e-9 for v in curve[2]["responses_change_percent"]), "no change in the middle")
fine = call(study, "--samples", 0, "--points", 3, "--range", 0.5, "--parameter", "base.k1", "--out", folder / "fine")
check([p["name"] for p in fine["parameters"]] == ["base.k1"] and "global" not in fine, "one parameter, no sample")
low, _, high = [p["responses_change_percent"] for p in fine["curves"][0]["points"]]
for i, response in enumerate(result["responses"]):
    check(math.isclose(high[i] - low[i], response["elasticities"]["base.k1"], rel_tol=1e-3), f"slope of the curve of {response['name']}")
changed = write_study(folder, BARE.replace("k1 = 2000", "k1 = 1000"), data=None, name="changed")
value = json.loads(run("forward", changed, "--json").stdout)["responses"][0]["value"]
check(math.isclose(curve[0]["responses_change_percent"][0], 100 * (value / result["responses"][0]["value"] - 1), abs_tol=1e-6), "the low end of a curve is a run at that value")

# The sample: every run counted, rows with a hole dropped whole.
sample = result["global"]
check(sample["rows"] == 16 and sum(sample["statuses"].values()) == 16 * 4, "the sample is rows x (parameters + 2)")
check(sample["statuses"]["invalid-parameters"] > 0 and sample["complete_rows"] < 16, "the box holds points without an answer")
check(math.isclose(sample["dropped_share"], 1 - sample["complete_rows"] / 16), "the share that is dropped")
check(any("without an answer" in s for s in result["findings"]), "dropped rows are said in words")
for index in sample["indices"]:
    for kind in ("first_order", "total"):
        for name, e in index[kind].items():
            check(e["low"] <= e["value"] <= e["high"], f"{index['response']} {kind} {name}: the value lies in its interval")
rows = run("export", folder / "t1", "--command", "sensitivity").stdout.splitlines()
check(len(rows) == 1 + 64, "export: the runs of the sample")
check(all(",nan," not in row for row in rows), "export: no misfit without data")

# More rows go on where fewer ended.
more = call(study, "--samples", 24, "--points", 5, "--out", folder / "t1")
check(more["computed"] == 8 * 4 and more["kept"] == 10 + 64, f"more rows: {more['computed']} computed, {more['kept']} kept")

# Holes in the curves: outside of the range of the parameter (k1 > 0), and no material.
holes = write_study(folder, BARE.replace("n = 0.5", "n = 2.0"), data=None, name="holes")
result = call(holes, "--samples", 0, "--points", 5, "--range", 100, "--out", folder / "holes")
for curve, bad in zip(result["curves"], ([0], [0, 3, 4])):
    for p, point in enumerate(curve["points"]):
        if p in bad:
            check(point["status"] == "invalid-parameters" and point["reason"] and "responses_change_percent" not in point, f"{curve['parameter']} {point['change_percent']}: a hole with its reason: {point}")
        else:
            check(point["status"] == "converged" and len(point["responses_change_percent"]) == 2, f"{curve['parameter']} {point['change_percent']}: {point}")
check("0 < value" in result["curves"][0]["points"][0]["reason"], "the allowed range is said")
text = run("sensitivity", holes, "--samples", 0, "--points", 5, "--range", 100, "--out", folder / "holes").stdout
lines = [line for line in text.splitlines() if "█" in line and "base.n" in line]
check(len(lines) == 2 and all(line.split("base.n")[1].split()[:5].count("-") == 3 for line in lines), f"holes in the table: {lines}")
check(text.count("no answer at") == 4, "each hole is listed with its status")

# A parameter of zero has no percentage, and says so.
zero = write_study(folder, BARE.replace("k3 = -0.3", "k3 = 0").replace('name = "base.n"\nmin = 0.1\nmax = 4.5', 'name = "base.k3"\nmin = -1\nmax = 0.5'), data=None, name="zero")
result = call(zero, "--samples", 0, "--points", 3, "--out", folder / "zero")
check([c["parameter"] for c in result["curves"]] == ["base.k1"] and result["responses"][0]["elasticities"]["base.k3"] is None, "a parameter of zero")

# Without outputs the readings are the responses; the report in words.
with_data = write_study(folder / "data", STUDY[:STUDY.index("[[outputs]]")])
done = run("sensitivity", with_data, "--samples", 16, "--points", 3, "--out", folder / "data" / "out")
check(done.returncode == 0, f"with data: {done.stderr}")
for words in ("fwd.deflection@300,0,0", "positive in compression", "What this means", "is governed by", "95 % interval"):
    check(words in done.stdout, f"'{words}' in the report")

check("Example:" in run("sensitivity", "--help").stdout, "help holds an example")

# Wrong input: exit status 2, one message. No answer at the study's own values: 1.
for arguments, words in (((study, "--parameter", "base.k"), "base.k1"), ((study, "--range", 101), "--range"), ((study, "--points", 1), "--points"),
                         ((study, "--samples", -1), "--samples")):
    done = run("sensitivity", *arguments, "--out", folder / "wrong")
    check(done.returncode == 2 and words in done.stderr, f"{arguments[1:]}: {done.returncode} {done.stderr}")
bare = write_study(folder, BARE[:BARE.index("[[parameters]]")] + OUTPUTS, data=None, name="no-parameters")
done = run("sensitivity", bare, "--out", folder / "wrong")
check(done.returncode == 2 and "parameters" in done.stderr, f"no parameters: {done.stderr}")
impossible = write_study(folder, BARE.replace("[mesh]", '[solver]\nintegration = "secant"\n\n[mesh]').replace("k2 = 0.5", "k2 = 2.1"), data=None, name="impossible")
check(call(impossible, "--out", folder / "wrong", status=1)["status"] == "no-equilibrium", "no answer at the own values")

finish()
