"""pavescape sensitivity: keys, holes, no data needed, the same for any number of threads, continued without repeating."""
import json
import math

import pytest

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
    assert done.returncode == status, f"{arguments}: exit status {done.returncode}: {done.stderr}"
    assert status != 0 or done.stderr == "", f"{arguments}: standard error is silent when piped: {done.stderr}"
    return json.loads(done.stdout)


def timeless(result):
    return {key: value for key, value in result.items() if key not in ("run", "computed", "kept")}


@pytest.fixture(scope="module")
def results():
    small = ("--samples", 16, "--points", 5)
    return {threads: call(study, *small, "--threads", threads, "--out", folder / f"t{threads}") for threads in (1, 2)}


def test_one_and_two_threads_give_the_same_result(results):
    assert timeless(results[1]) == timeless(results[2]), "1 and 2 threads give the same result"


@pytest.fixture(scope="module")
def result(results):
    return results[1]


def test_parameters_and_responses(result):
    assert json.loads((folder / "t1" / "sensitivity.json").read_text()) == result, "the same in the folder of the run"
    assert [p["name"] for p in result["parameters"]] == ["base.k1", "base.n"], "parameters"
    assert [(r["name"], r["unit"]) for r in result["responses"]] == [("subgrade-top-strain", "microstrain"), ("d0", "mm")], "responses: the outputs"


def test_elasticities_are_those_of_the_forward_run(result):
    forward = json.loads(run("forward", study, "--jacobian", "--json").stdout)
    for i, response in enumerate(result["responses"]):
        value = forward["responses"][i]["value"]
        assert math.isclose(response["value"], value, rel_tol=1e-9), f"{response['name']}: the value of the forward run"
        for k, (name, own) in enumerate((("base.k1", 2000), ("base.n", 0.5))):
            want = forward["jacobian"]["rows"][i][k] * own / value
            assert math.isclose(response["elasticities"][name], want, rel_tol=1e-9), f"elasticity of {response['name']} by {name}"


def test_curves_pass_through_the_own_value_with_the_elasticity_as_slope(result):
    # Curves: percentages of the study's own value, the middle is that value, the slope there is the elasticity.
    assert [c["parameter"] for c in result["curves"]] == ["base.k1", "base.n"], "one curve a parameter"
    curve = result["curves"][0]["points"]
    assert [p["change_percent"] for p in curve] == [-50, -25, 0, 25, 50], "points of a curve"
    assert [p["value"] for p in curve] == [1000, 1500, 2000, 2500, 3000], "values of a curve"
    assert all(abs(v) < 1e-9 for v in curve[2]["responses_change_percent"]), "no change in the middle"
    fine = call(study, "--samples", 0, "--points", 3, "--range", 0.5, "--parameter", "base.k1", "--out", folder / "fine")
    assert [p["name"] for p in fine["parameters"]] == ["base.k1"] and "global" not in fine, "one parameter, no sample"
    low, _, high = [p["responses_change_percent"] for p in fine["curves"][0]["points"]]
    for i, response in enumerate(result["responses"]):
        assert math.isclose(high[i] - low[i], response["elasticities"]["base.k1"], rel_tol=1e-3), f"slope of the curve of {response['name']}"
    changed = write_study(folder, BARE.replace("k1 = 2000", "k1 = 1000"), data=None, name="changed")
    value = json.loads(run("forward", changed, "--json").stdout)["responses"][0]["value"]
    assert math.isclose(curve[0]["responses_change_percent"][0], 100 * (value / result["responses"][0]["value"] - 1), abs_tol=1e-6), \
        "the low end of a curve is a run at that value"


def test_every_run_of_the_sample_counts(result):
    # The sample: every run counted, rows with a hole dropped whole.
    sample = result["global"]
    assert sample["rows"] == 16 and sum(sample["statuses"].values()) == 16 * 4, "the sample is rows x (parameters + 2)"
    assert sample["statuses"]["invalid-parameters"] > 0 and sample["complete_rows"] < 16, "the box holds points without an answer"
    assert math.isclose(sample["dropped_share"], 1 - sample["complete_rows"] / 16), "the share that is dropped"
    assert any("without an answer" in s for s in result["findings"]), "dropped rows are said in words"
    for index in sample["indices"]:
        for kind in ("first_order", "total"):
            for name, e in index[kind].items():
                assert e["low"] <= e["value"] <= e["high"], f"{index['response']} {kind} {name}: the value lies in its interval"
    rows = run("export", folder / "t1", "--command", "sensitivity").stdout.splitlines()
    assert len(rows) == 1 + 64, "export: the runs of the sample"
    assert all(",nan," not in row for row in rows), "export: no misfit without data"


@pytest.mark.usefixtures("results")
def test_more_rows_go_on_where_fewer_ended():
    more = call(study, "--samples", 24, "--points", 5, "--out", folder / "t1")
    assert more["computed"] == 8 * 4 and more["kept"] == 10 + 64, f"more rows: {more['computed']} computed, {more['kept']} kept"


def test_holes_in_the_curves_have_their_reasons():
    # Holes in the curves: outside of the range of the parameter (k1 > 0), and no material.
    holes = write_study(folder, BARE.replace("n = 0.5", "n = 2.0"), data=None, name="holes")
    result = call(holes, "--samples", 0, "--points", 5, "--range", 100, "--out", folder / "holes")
    for curve, bad in zip(result["curves"], ([0], [0, 3, 4])):
        for p, point in enumerate(curve["points"]):
            if p in bad:
                assert point["status"] == "invalid-parameters" and point["reason"] and "responses_change_percent" not in point, \
                    f"{curve['parameter']} {point['change_percent']}: a hole with its reason: {point}"
            else:
                assert point["status"] == "converged" and len(point["responses_change_percent"]) == 2, f"{curve['parameter']} {point['change_percent']}: {point}"
    assert "0 < value" in result["curves"][0]["points"][0]["reason"], "the allowed range is said"
    text = run("sensitivity", holes, "--samples", 0, "--points", 5, "--range", 100, "--verbose", "--out", folder / "holes").stdout
    lines = [line for line in text.splitlines() if "█" in line and "base.n" in line]
    assert len(lines) == 2 and all(line.split("base.n")[1].split()[:5].count("-") == 3 for line in lines), f"holes in the table: {lines}"
    assert text.count("no answer at") == 4, "each hole is listed with its status"


def test_a_parameter_of_zero_has_no_percentage():
    zero = write_study(folder, BARE.replace("k3 = -0.3", "k3 = 0").replace('name = "base.n"\nmin = 0.1\nmax = 4.5', 'name = "base.k3"\nmin = -1\nmax = 0.5'), data=None, name="zero")
    result = call(zero, "--samples", 0, "--points", 3, "--out", folder / "zero")
    assert [c["parameter"] for c in result["curves"]] == ["base.k1"] and result["responses"][0]["elasticities"]["base.k3"] is None, "a parameter of zero"


def test_without_outputs_the_readings_are_the_responses():
    with_data = write_study(folder / "data", STUDY[:STUDY.index("[[outputs]]")])
    done = run("sensitivity", with_data, "--samples", 16, "--points", 3, "--verbose", "--out", folder / "data" / "out")
    assert done.returncode == 0, f"with data: {done.stderr}"
    for words in ("fwd.deflection@300,0,0", "positive in compression", "What this means", "is governed by", "95 % interval"):
        assert words in " ".join(done.stdout.split()), f"'{words}' in the report"


def test_help_holds_an_example():
    assert "Example:" in run("sensitivity", "--help").stdout, "help holds an example"


def test_wrong_input_is_said():
    # Wrong input: exit status 2, one message. No answer at the study's own values: 1.
    for arguments, words in (((study, "--parameter", "base.k"), "base.k1"), ((study, "--range", 101), "--range"), ((study, "--points", 1), "--points"),
                             ((study, "--samples", -1), "--samples")):
        done = run("sensitivity", *arguments, "--out", folder / "wrong")
        assert done.returncode == 2 and words in done.stderr, f"{arguments[1:]}: {done.returncode} {done.stderr}"
    bare = write_study(folder, BARE[:BARE.index("[[parameters]]")] + OUTPUTS, data=None, name="no-parameters")
    done = run("sensitivity", bare, "--out", folder / "wrong")
    assert done.returncode == 2 and "parameters" in done.stderr, f"no parameters: {done.stderr}"
    impossible = write_study(folder, BARE.replace("[mesh]", '[solver]\nintegration = "secant"\n\n[mesh]').replace("k2 = 0.5", "k2 = 2.1"), data=None, name="impossible")
    assert call(impossible, "--out", folder / "wrong", status=1)["status"] == "no-equilibrium", "no answer at the own values"
