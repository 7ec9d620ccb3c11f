"""Several loads in one fit: weights, held-out groups, and what fitting one group alone predicts for the others."""
import csv
import json
import math

import pytest

from support import *

folder = workspace()
TWO_LOADS = STUDY.replace("[mesh]", """[[loads]]
name = "wheel"
type = "dual-wheel"
force_kN = 40
pressure_kPa = 700
spacing_mm = 340

[[loads]]
name = "heavy"
type = "plate"
radius_mm = 150
pressure_kPa = 900

[mesh]""").replace("max = 4.5", "max = 1.0").replace("refine = 0.4", "refine = 0.3")
# Readings made by the model itself at the study's own values: a perfect fit of every group exists.
LAYOUT = """load,quantity,x_mm,y_mm,depth_mm,gauge_mm,value,unit,sigma
fwd,deflection,0,0,0,0,1,mm,
fwd,deflection,300,0,0,0,1,mm,
wheel,strain_zz,170,0,180,75,1,microstrain,
heavy,deflection,0,0,0,0,1,mm,
wheel,strain_zz,170,0,340,75,1,microstrain,
"""


@pytest.fixture(scope="module")
def data():
    study = write_study(folder, TWO_LOADS, LAYOUT)
    exact = [r["value"] for r in json.loads(run("forward", study, "--json").stdout)["responses"]]
    lines = LAYOUT.splitlines()
    data = [lines[0]]
    for line, value in zip(lines[1:], exact):
        cells = line.split(",")
        cells[6] = repr(value)
        data.append(",".join(cells))
    return "\n".join(data) + "\n"


held_out = TWO_LOADS.replace('misfit = "log"', 'misfit = "log"\nheld_out = ["heavy"]')


@pytest.fixture(scope="module")
def held(data):
    study = write_study(folder, held_out, data)
    done = run("fit", study, "--explore", 12, "--starts", 2, "--json", "--out", folder / "held")
    assert done.returncode == 0, done.stderr
    result = json.loads(done.stdout)
    groups = {g["name"]: g for g in result["groups"]}
    return result, groups


def test_a_held_out_load_is_predicted(held):
    result, groups = held
    assert list(groups) == ["fwd.deflection", "wheel.strain_zz", "heavy.deflection"], "the groups in the order of the data"
    assert groups["heavy.deflection"]["held_out"] and not groups["fwd.deflection"]["held_out"], "which is held out"
    assert groups["wheel.strain_zz"]["readings"] == 2, "readings of a group that are apart in the file"
    assert abs(result["best"]["parameters"]["base.k1"] / 2000 - 1) < 1e-3, "the truth is found"
    assert groups["heavy.deflection"]["rms"] < 1e-3, "the held-out load is predicted"
    assert [fit["fitted"] for fit in result["alone"]] == ["fwd.deflection", "wheel.strain_zz"], "each fitted group alone"
    for fit in result["alone"]:
        assert fit["rms"][fit["fitted"]] < 1e-3, f"{fit['fitted']} alone is fitted"
    assert len(result["responses"]) == 6 and all(math.isfinite(r["value"]) for r in result["responses"]), "responses of all loads and outputs"


@pytest.mark.usefixtures("held")
def test_a_held_out_load_is_not_computed_while_fitting():
    rows = list(csv.reader(run("export", folder / "held", "--command", "fit").stdout.splitlines()))
    column = next(i for i, name in enumerate(rows[0]) if name.startswith("heavy"))
    assert len(rows) > 12 and all(row[column] == "" for row in rows[1:]), "the held-out load cost nothing"


def test_a_held_out_reading_has_no_influence(data, held):
    result, _ = held
    # A spoiled held-out reading changes nothing; a spoiled fitted one counts by its weight.
    spoiled = data.replace("heavy,deflection,0,0,0,0,", "heavy,deflection,0,0,0,0,9")
    again = json.loads(run("fit", write_study(folder, held_out, spoiled), "--explore", 12, "--starts", 2, "--joint-only",
                           "--json", "--out", folder / "spoiled").stdout)
    assert again["best"]["parameters"] == result["best"]["parameters"], "a held-out reading has no influence"
    assert again["alone"] == [], "--joint-only"


def test_a_group_counts_by_its_weight(data):
    wheel = next(line for line in data.splitlines() if line.startswith("wheel"))
    double = data.replace(wheel, wheel.replace(wheel.split(",")[6], repr(2 * float(wheel.split(",")[6]))))
    misfits = {}
    for weight in (1, 100):
        text = held_out + f"\n[data.weights]\nwheel = {weight}\n"
        fit = json.loads(run("fit", write_study(folder, text, double), "--explore", 12, "--starts", 2, "--joint-only",
                             "--json", "--out", folder / f"weight{weight}").stdout)
        misfits[weight] = {g["name"]: g["rms"] for g in fit["groups"]}
    assert misfits[100]["wheel.strain_zz"] < misfits[1]["wheel.strain_zz"], "a heavy group is met better"
    assert misfits[100]["fwd.deflection"] > misfits[1]["fwd.deflection"], "at the cost of the other"


def test_wrong_groups_are_refused(data):
    for label, text, words in (
            ("a group that is not there", held_out.replace('held_out = ["heavy"]', 'held_out = ["haevy"]'), ["haevy", "fwd.deflection", "heavy"]),
            ("everything held out", held_out.replace('["heavy"]', '["heavy", "fwd", "wheel"]'), ["nothing is left to fit"]),
            ("a weight of nothing", held_out + "\n[data.weights]\nnone = 1\n", ["none", "no reading belongs"]),
            ("a weight of zero", held_out + "\n[data.weights]\nfwd = 0\n", ["0 < value"])):
        done = run("fit", write_study(folder, text, data), "--out", folder / "never")
        assert done.returncode == 2 and all(word in done.stderr for word in words), f"{label}: {done.stderr}"
