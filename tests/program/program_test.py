"""The commands as another program calls them: JSON keys, exit status, silence where it is due."""
import csv
import io
import json
import math
import sqlite3
import struct

from support import *

folder = workspace()
study = write_study(folder)


def call(*arguments):
    done = run(*arguments, "--json")
    assert done.returncode == 0, f"{arguments[0]}: {done.stderr}"
    assert done.stderr == "", f"{arguments[0]}: standard error is silent when piped: {done.stderr}"
    return json.loads(done.stdout)


def test_forward_answers_every_row_in_order():
    # forward: every row of the data in order, then every output.
    result = call("forward", study, "--jacobian")
    assert result["status"] == "converged", "forward: status"
    assert ([(r["quantity"], r["x_mm"], r["unit"]) for r in result["responses"]] ==
            [("deflection", 0, "mm"), ("deflection", 300, "um"), ("deflection", 600, "mm"), ("strain_zz", 0, "strain"),
             ("strain_zz", 0, "microstrain")]), \
        "forward: responses in the order and units of the data, then the outputs"
    assert all(key in r for r in result["responses"] for key in ("load", "y_mm", "depth_mm", "value")), "forward: keys"
    assert result["residual_relative"] < 1e-8 and "newton_steps" in result, "forward: how it ended"
    assert result["jacobian"]["parameters"] == ["base.k1", "base.n"], "forward: jacobian parameters"
    assert len(result["jacobian"]["rows"]) == 5 and all(len(row) == 2 for row in result["jacobian"]["rows"]), "forward: jacobian shape"
    # Per unit of the response and of the parameter: against a difference quotient of the program itself.
    values = []
    for k1 in (1999.0, 2001.0):
        changed = write_study(folder, STUDY.replace("k1 = 2000", f"k1 = {k1}"), name="changed")
        values.append([r["value"] for r in call("forward", changed)["responses"]])
    for i, row in enumerate(result["jacobian"]["rows"]):
        quotient = (values[1][i] - values[0][i]) / 2.0
        assert abs(row[0] - quotient) <= 1e-5 * abs(quotient), f"forward: jacobian row {i}: {row[0]} against {quotient}"


def test_forward_works_without_data():
    # forward works without data; the others do not.
    bare = write_study(folder, STUDY[:STUDY.index("[data]")] + STUDY[STUDY.index("[[outputs]]"):], name="bare")
    assert len(call("forward", bare)["responses"]) == 1, "forward without data"
    assert run("fit", bare).returncode == 2, "fit without data"


def test_secant():
    secant = write_study(folder, STUDY.replace("[mesh]", '[solver]\nintegration = "secant"\n\n[mesh]'), name="secant")
    result = call("forward", secant)
    assert result["newton_steps"] > 0 and result["residual_relative"] < 1e-8, "secant: Newton steps to equilibrium"
    impossible = write_study(folder, STUDY.replace("[mesh]", '[solver]\nintegration = "secant"\n\n[mesh]').replace("k2 = 0.5", "k2 = 2.1"),
                             name="impossible")
    done = run("forward", impossible, "--json")
    assert done.returncode == 1, "no equilibrium: exit status 1"
    assert json.loads(done.stdout)["status"] == "no-equilibrium" and "fold" in done.stderr, "no equilibrium: said in words"


def test_more_of_the_same_sequence_continues_a_run():
    # More of the same sequence continues a run: only what is new is computed, and the result is that of a fresh run.
    for name, few, many, new in (("map", ("--design", "sobol", "--points", 10), ("--design", "sobol", "--points", 25), 15),
                                 ("fit", ("--explore", 12, "--starts", 2), ("--explore", 12, "--starts", 3), None),
                                 ("fit", ("--explore", 12, "--starts", 3), ("--explore", 20, "--starts", 3), None),
                                 ("unique", ("--explore", 12, "--verify", 3), ("--explore", 12, "--verify", 5), None)):
        grown, fresh = folder / f"grown-{name}-{many[1]}-{many[3]}", folder / f"fresh-{name}-{many[1]}-{many[3]}"
        call(name, study, *few, "--out", grown)
        before = evaluations(grown)
        extended = call(name, study, *many, "--out", grown)
        added = evaluations(grown) - before
        whole = call(name, study, *many, "--out", fresh)
        assert lasting(extended) == lasting(whole), f"{name} {many} after {few}: the result of a fresh run"
        assert 0 < added < evaluations(fresh), f"{name} {many} after {few}: {added} new of {evaluations(fresh)}"
        assert new is None or added == new, f"{name} {many} after {few}: {added} new, not {new}"
        call(name, study, *few, "--out", grown)
        assert evaluations(grown) == before + added, f"{name} {few} again: nothing new"


def test_map_and_export():
    result = call("map", study, "--out", folder / "map")
    assert result["points"] == 12 and sum(result["statuses"].values()) == 12, "map: a full grid of 4 x 3"
    assert result["statuses"]["invalid-parameters"] > 0, "map: points that cannot be a material are shown as such"
    rows = list(csv.DictReader(io.StringIO(run("export", folder / "map").stdout)))
    assert [int(row["number"]) for row in rows] == list(range(12)), "export: run order"
    for row in rows:
        assert (row["misfit"] != "") == (row["status"] == "converged"), "export: a misfit exactly where there is an answer"
        assert (row["reason"] != "") == (row["status"] != "converged"), "export: a reason exactly where there is none"
    as_json = json.loads(run("export", folder / "map", "--format", "json").stdout)
    assert [e["parameters"] for e in as_json["evaluations"]] == [[float(row["base.k1"]), float(row["base.n"])] for row in rows], \
        "export: JSON and CSV agree to the last bit"


def test_what_only_an_output_needs_is_not_computed_at_every_point():
    # What only an output needs is not computed at every point: a second load under which nothing is measured.
    other = """
[[loads]]
name = "heavy"
type = "plate"
radius_mm = 150
pressure_kPa = 900

[mesh]"""
    dear = write_study(folder, STUDY.replace("[mesh]", other.lstrip(), 1).replace('load = "fwd"\nquantity = "strain_zz"', 'load = "heavy"\nquantity = "strain_zz"'), name="dear")
    low = call("map", dear, "--out", folder / "dear")["lowest"]
    with sqlite3.connect(folder / "dear" / "run.sqlite") as database:
        kept = [struct.unpack(f"{len(r) // 8}d", r) for r, in database.execute("SELECT responses FROM evaluation JOIN run ON run = id WHERE status = 0 AND settings NOT LIKE '%lowest%'")]
    assert kept and all(math.isnan(r[-1]) and not math.isnan(r[0]) for r in kept), "map: an output's own load is not computed at explored points"
    at_low = write_study(folder, (folder / "dear.toml").read_text().replace("k1 = 2000", f"k1 = {low[0]['parameters']['base.k1']!r}").replace(
        "n = 0.5", f"n = {low[0]['parameters']['base.n']!r}"), name="at-low")
    wanted = call("forward", at_low)["responses"][-1]["value"]
    assert abs(low[0]["outputs"][0]["value"] - wanted) < 1e-9 * abs(wanted) and len(low) > 1, f"map: the output at the lowest point {low[0]['outputs']}, {wanted}"


def test_a_map_called_again_computes_nothing():
    call("map", study, "--out", folder / "map")
    again = call("map", study, "--out", folder / "map")
    assert again["computed"] == 0 and again["kept"] == 12, "map: called again, nothing is computed again"


def test_fit_by_both_schemes_and_another_method():
    for scheme in ("multistart", "paper"):
        result = call("fit", study, "--scheme", scheme, "--explore", 40, "--starts", 4, "--out", folder / scheme)
        best = result["best"]
        assert best["status"] == "converged" and set(best["parameters"]) == {"base.k1", "base.n"}, "fit: best"
        assert abs(result["minima"][0]["misfit"] - best["misfit"]) == 0, "fit: the best is the first of the minima"
        assert result["starts"] >= 1 and result["evaluations"] > 10, "fit: counts"
        assert sum(len(m["starts"]) for m in result["minima"]) == result["starts"], "fit: every start ended somewhere"
        assert json.loads((folder / scheme / "fit.json").read_text()) == result, "fit: the same in the folder of the run"
    text = run("fit", study, "--verbose", "--explore", 40, "--starts", 4, "--out", folder / "multistart").stdout
    for words in ("Best fit", "distinct", "measured", "model", "starts ended in the best minimum"):
        assert words in " ".join(text.split()), f"fit: '{words}' in the report"
    assert "\x1b" not in text, "fit: no terminal codes when piped"

    # derivative-free methods get there too
    free = call("fit", study, "--method", "bobyqa", "--explore", 40, "--starts", 4, "--out", folder / "bobyqa")
    assert abs(free["best"]["misfit"] / result["best"]["misfit"] - 1) < 1e-3, "fit: another method, the same misfit"


def test_twin():
    # twin: the layout of the study, values of the model, noise by the seed
    result = call("twin", study, "--out", folder / "twin")
    assert [m["exact"] for m in result["measurements"]] == [m["value"] for m in result["measurements"]], "twin: no noise unless requested"
    noisy = [call("twin", study, "--noise", 0.05, "--seed", seed, "--out", folder / f"twin{seed}") for seed in (1, 1, 2)]
    assert noisy[0]["measurements"] == noisy[1]["measurements"] != noisy[2]["measurements"], "twin: the seed fixes the noise"
    (folder / "back").mkdir()
    back = write_study(folder / "back", STUDY.replace("k1 = 2000", "k1 = 900"), (folder / "twin" / "twin.csv").read_text())
    result = call("fit", back, "--explore", 40, "--starts", 3, "--out", folder / "back" / "out")
    assert abs(result["best"]["parameters"]["base.k1"] / 2000 - 1) < 0.01, "twin and fit: the parameters come back"


def test_version_and_help():
    assert run("--version").stdout.strip() != "" and run("--help").returncode == 0, "version and help"
    for command in ("forward", "map", "fit", "twin", "export"):
        assert "Example:" in run(command, "--help").stdout, f"{command} --help holds an example"
