"""Readings as prior and posterior predict them: one stiffness from the bowl of a half-space, whose deflections are c/E, by quadrature."""
import math

import numpy as np
from scipy import stats

from support import *

folder = workspace()
OFFSETS = (0, 200, 300, 450, 600, 900, 1200, 1500)
ERRORS = np.array((0.9, -1.6, 0.3, 1.2, -0.4, -1.1, 2.1, -0.7))  # made up
SIGMA = 0.02                                                     # mm


def made(label, values, more=OF_HALF_SPACE):
    return half_space_study(folder / label, OFFSETS, values, SIGMA, 'misfit = "weighted"\n' + more)


def answer(path, *options):
    done = run("sample", path, "--json", "--threads", 1, "--out", path.parent / "out", *options)
    assert done.returncode == 0, done.stdout + done.stderr
    return json.loads(done.stdout)


FLEXIBILITY = 100 * np.array([r["value"] for r in json.loads(run("forward", made("exact", [1] * len(OFFSETS)), "--json").stdout)["responses"]])
READ = FLEXIBILITY / 80 + SIGMA * ERRORS


def compared(rows, read, x, weight, near):
    """Each row against the mixture over stiffnesses exp(x) with these weights, within `near` of probability."""
    for row, c, value in zip(rows, FLEXIBILITY, read):
        def below(y):
            return weight @ stats.norm.cdf((y - c / np.exp(x)) / SIGMA)

        assert abs(row["pit"] - below(value)) < near, (row, below(value))
        for key, share in (("low", 0.025), ("median", 0.5), ("high", 0.975)):
            assert abs(below(row[key]) - share) < near, (key, row, below(row[key]))
        assert row["inside"] == (0.025 <= row["pit"] <= 0.975)


def test_the_prior_predicts_each_reading_and_says_which_it_does_not_reach():
    x = np.linspace(math.log(20), math.log(400), 4001)
    flat = np.full(len(x), 1 / len(x))
    check = answer(made("uniform", READ), "--prior", "--samples", 2000)
    compared(check["readings"], READ, x, flat, 0.004)
    assert check["unreached"] == [] and check["points"] == check["answered"] == 2000 and "reaches all 8 readings" in check["findings"][0]
    # Beyond what the softest ground of the box gives at the centre, by ten deviations.
    wrong = READ.copy()
    wrong[0] = FLEXIBILITY[0] / 20 + 10 * SIGMA
    check = answer(made("wrong", wrong), "--prior", "--samples", 2000)
    assert check["unreached"] == ["fwd.deflection@0,0,0"] and "does not reach 1 reading" in check["findings"][0], check["findings"]
    # Normal, and cut off by a constraint.
    normal = OF_HALF_SPACE + 'prior = { mean = 100, sd = 0.3 }\n[[constraints]]\nthat = "subgrade.modulus_MPa <= 110"\n'
    check = answer(made("normal", READ, normal), "--prior", "--samples", 4000)
    weight = np.where(x <= math.log(110), stats.norm.pdf((x - math.log(100)) / 0.3), 0)
    compared(check["readings"], READ, x, weight / weight.sum(), 0.01)


def test_the_draws_predict_each_reading_with_its_noise():
    sample = answer(made("posterior", READ), "--samples", 4000)
    x = np.linspace(math.log(60), math.log(110), 4001)
    weight = np.array([math.exp(-0.5 * (((READ - FLEXIBILITY / e) / SIGMA) ** 2).sum() + 0.5 * (ERRORS**2).sum()) for e in np.exp(x)])
    compared(sample["predictive"]["readings"], READ, x, weight / weight.sum(), 0.02)
    assert sample["predictive"]["inside"] == sum(row["inside"] for row in sample["predictive"]["readings"]) / len(READ)


def test_the_check_of_the_prior_is_a_page_and_continues():
    path = made("page", READ)
    done = run("sample", path, "--prior", "--samples", 400, "--out", folder / "page" / "out")
    assert done.returncode == 0 and done.stdout.startswith("The prior reaches all 8 readings") and "400 computed" in " ".join(done.stdout.split()), done.stdout + done.stderr
    again = run("sample", path, "--prior", "--samples", 500, "--out", folder / "page" / "out")
    assert "100 computed, 400 kept" in " ".join(again.stdout.split()), again.stdout
