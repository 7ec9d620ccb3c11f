"""The stand-in of a model of one's own: explores and draws, while what is reported comes from the model."""
import math

from any_model_test import Model, decay, serve
from python_test import python
from support import *

RANGES = ((0.1, 0.8), (0.9, 4))


def answer(command, study, out, *options):
    done = run(command, study, *options, "--json", "--out", out, "--threads", 1)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.mark.parametrize("offers", [("Evaluate",), ("Evaluate", "ApplyJacobian")], ids=["values", "derivatives"])
def test_a_landscape_is_the_stand_ins_and_the_answer_the_models(offers):
    folder = workspace()
    url, asked, server = serve(Model(), offers)
    study = decay(folder, url, RANGES)
    full = answer("unique", study, folder / "full", "--landscape")
    of_full = asked.count("/Evaluate")
    own = answer("unique", study, folder / "auto", "--model", "auto")
    of_stand_in = asked.count("/Evaluate") - of_full
    server.shutdown()
    assert own["verdict"] == full["verdict"] == "unique"
    assert own["minima"][0]["parameters"] == pytest.approx(full["minima"][0]["parameters"], rel=1e-5)
    for a, b in zip(own["profiles"], full["profiles"]):
        assert (a["low"], a["high"]) == pytest.approx((b["low"], b["high"]), rel=1e-3)
    (load,) = own["reduced_model"]["loads"]
    assert load["error_95"] < 0.02 and of_stand_in < of_full / 2, (load, of_stand_in, of_full)
    # The misfit over the pair, where chi2 rises by less than ten: the exact function at the nodes.
    pair = own["landscape"]["pairs"][0]
    worst = 0.0
    for i, k1 in enumerate(pair["x_values"]):
        for j, k2 in enumerate(pair["y_values"]):
            rise = sum(((y - z) / 0.01) ** 2 for y, z in zip(Model()((k1, k2)), Model()((0.4, 1.6))))
            if rise < 10:
                worst = max(worst, abs(pair["rise"][j][i] - rise))
    assert worst < 1.0, worst


def test_draws_by_the_stand_in_are_those_of_the_posterior():
    folder = workspace()
    url, asked, server = serve(Model(), ("Evaluate", "ApplyJacobian"))
    drawn = answer("sample", decay(folder, url, RANGES), folder / "out", "--model", "auto", "--samples", 1000, "--confirm", 50)
    server.shutdown()
    # Nearly normal: half a range of 95 % is 1.96 sigma sqrt((J'J)^-1).
    j = [[-t * math.exp(-k * t) / 0.01 for k in (0.4, 1.6)] for t in Model.times]
    a, b, c = (sum(row[p] * row[q] for row in j) for p, q in ((0, 0), (0, 1), (1, 1)))
    for parameter, variance, value in zip(drawn["parameters"], (c / (a * c - b * b), a / (a * c - b * b)), (0.4, 1.6)):
        half = 1.96 * math.sqrt(variance)
        assert abs(parameter["q025"] - (value - half)) < 0.3 * half and abs(parameter["q975"] - (value + half)) < 0.3 * half, (parameter, half)
    assert asked.count("/Evaluate") < 500, "a thousand draws and what leads to them"


# Waves that are shorter than any few hundred points can show, behind k1 = 0.5.
WAVES = """
import json, numpy as np, pavescape
calls = []
times = 0.25 * np.arange(1, 13)
def model(k):
    calls.append(1)
    return np.exp(-k[0] * times) + np.exp(-k[1] * times) + (0.3 * np.sin(400 * k[0] + 300 * k[1]) if k[0] > 0.5 else 0.0)
measured = model([0.4, 1.6])
problem = pavescape.Problem([("k1", 0.1, 0.8), ("k2", 0.9, 4)], (measured, 0.01), model)
told = []
for use in ("reduced", "full"):
    calls.clear()
    result, points, misfit = problem.map(points=500, model=use, seed=7, threads=1)
    exact = np.array([np.linalg.norm((model(x) - measured) / 0.01) for x in points])
    told.append([float(np.mean(np.abs(misfit - exact) > 0.05 * exact + 0.5)), len(calls) - 500])
print(json.dumps(told))
"""


def test_where_the_stand_in_is_not_sure_the_model_runs():
    (off, runs), (exactly, all_runs) = json.loads(python(WAVES))
    assert exactly == 0.0 and all_runs >= 500
    # Where the waves are, nearly half of the points, the model has to run. Estimates of errors hold in 95 of 100.
    assert off < 0.05 and runs > 150, (off, runs)


def test_points_of_the_stand_in_are_kept_and_a_killed_run_continues():
    folder = workspace()
    url, asked, server = serve(Model())
    study = decay(folder, url, RANGES)
    asked_for = ("fit", study, "--model", "auto", "--explore", 16, "--starts", 2, "--joint-only")
    whole = answer(*asked_for[:2], folder / "whole", *asked_for[2:])
    kept = kill_at(10, folder / "cut", *asked_for)
    assert kept >= 10
    again = answer(*asked_for[:2], folder / "cut", *asked_for[2:])
    server.shutdown()
    assert again["best"] == whole["best"] and again["reduced_model"] == whole["reduced_model"]


def test_a_model_with_too_few_answers_has_no_stand_in():
    folder = workspace()
    url, _, server = serve(Model())
    done = run("fit", decay(folder, url, RANGES, keys="config = { limit = 0.0 }"), "--model", "auto", "--out", folder / "out")
    server.shutdown()
    assert done.returncode == 1 and "too few for a stand-in" in done.stderr, done.stderr
