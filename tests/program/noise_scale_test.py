"""A size of the noise that is sought: one stiffness from the bowl of a half-space, in closed form. Deflections are c/E, so the model is
linear in 1/E: Student's t for E, chi2 for the size; the posterior by quadrature of the integrated likelihood."""
import math

import numpy as np
from scipy import stats

from support import *

folder = workspace()
OFFSETS = (0, 200, 300, 450, 600, 900, 1200, 1500)
ERRORS = (0.9, -1.6, 0.3, 1.2, -0.4, -1.1, 2.1, -0.7)  # in standard deviations of three times what is stated: made up
SIGMA = 0.004                                          # mm, as stated
STATED = 'misfit = "weighted"\n[data.noise]\nscale = "sought"\n'


def made(label, values, sigma, data=STATED, sought=OF_HALF_SPACE):
    return half_space_study(folder / label, OFFSETS, values, sigma, data + sought)


def answer(command, path, *options):
    done = run(command, path, "--json", "--threads", 1, "--out", path.parent / command, *options)
    assert done.returncode == 0, done.stdout + done.stderr
    return json.loads(done.stdout)


FLEXIBILITY = 100 * np.array([r["value"] for r in json.loads(run("forward", made("exact", [1] * len(OFFSETS), SIGMA), "--json").stdout)["responses"]])
READ = FLEXIBILITY / 80 + 3 * SIGMA * np.array(ERRORS)


def closed_form(read):
    """1/E and its standard error, the root mean square residual in units of SIGMA, degrees of freedom."""
    best = FLEXIBILITY @ read / (FLEXIBILITY @ FLEXIBILITY)
    dof = len(read) - 1
    size = math.sqrt(((read - best * FLEXIBILITY) ** 2).sum() / dof) / SIGMA
    return best, size * SIGMA / math.sqrt(FLEXIBILITY @ FLEXIBILITY), size, dof


def test_fit_and_unique_give_students_t_and_the_size_of_the_noise():
    path = made("stated", READ, SIGMA)
    best, error, size, dof = closed_form(READ)
    fit = answer("fit", path, "--explore", 16, "--starts", 2)
    assert abs(fit["best"]["parameters"]["subgrade.modulus_MPa"] * best - 1) < 1e-4
    assert abs(fit["best"]["standard_errors"]["subgrade.modulus_MPa"] / (error / best**2) - 1) < 2e-3  # to first order, of the logarithm
    ends = [size * math.sqrt(dof / stats.chi2.ppf(q, dof)) for q in (0.975, 0.025)]
    scale = fit["noise"]["scale"]
    assert fit["noise"]["source"] == "sought" and abs(scale["estimate"] / size - 1) < 1e-3, (scale, size)
    assert abs(scale["low"] / ends[0] - 1) < 1e-3 and abs(scale["high"] / ends[1] - 1) < 1e-3, (scale, ends)
    said = [f for f in fit["findings"] if "times what is stated" in f]
    assert said and not [f for f in fit["findings"] if "consistent with the stated noise" in f or "does not fit" in f], fit["findings"]
    unique = answer("unique", path, "--explore", 16, "--verify", 4)
    t = stats.t.ppf(0.975, dof)
    profile = unique["profiles"][0]
    assert abs(profile["low"] * (best + t * error) - 1) < 2e-3 and abs(profile["high"] * (best - t * error) - 1) < 2e-3, (profile["low"], profile["high"])
    assert abs(unique["acceptance"]["noise_scale"]["estimate"] / size - 1) < 1e-3


def test_sample_integrates_the_size_out():
    path = made("sampled", READ, SIGMA)
    sample = answer("sample", path, "--samples", 4000)
    # The prior of the square of the size: scaled inverse chi2 with 1/2 degrees of freedom around 1.
    nu, n = 0.5, len(READ)
    x = np.linspace(math.log(20), math.log(400), 20001)
    sums = np.array([((READ - FLEXIBILITY / e) ** 2).sum() / SIGMA**2 for e in np.exp(x)])
    log = (math.lgamma((nu + n) / 2) - math.lgamma(nu / 2) + nu / 2 * math.log(nu / 2) - (nu + n) / 2 * np.log((nu + sums) / 2)
           - n / 2 * math.log(2 * math.pi) - n * math.log(SIGMA / 1000))
    weight = np.exp(log - log.max())
    evidence = log.max() + math.log(weight.mean())
    weight /= weight.sum()
    found = sample["parameters"][0]
    mean = weight @ np.exp(x)
    sd = math.sqrt(weight @ (np.exp(x) - mean) ** 2)
    assert abs(found["mean"] - mean) < 0.08 * sd and abs(found["sd"] / sd - 1) < 0.06, (found, mean, sd)
    total = np.cumsum(weight)
    for key, share in (("q025", 0.025), ("q50", 0.5), ("q975", 0.975)):
        assert abs(found[key] - math.exp(x[np.searchsorted(total, share)])) < 0.2 * sd, (key, found[key])
    assert abs(sample["log_evidence"] - evidence) < 4 * sample["log_evidence_error"] + 0.02, (sample["log_evidence"], evidence)
    scale = sample["noise"]["scale"]
    for key, share in (("estimate", 0.5), ("low", 0.025), ("high", 0.975)):
        below = weight @ stats.chi2.sf((nu + sums) / scale[key] ** 2, nu + n)
        assert abs(below - share) < 0.01, (key, scale, below)
    assert sample["p_value"] is None and [f for f in sample["findings"] if "times what is stated" in f]


def test_where_nothing_is_stated_the_size_is_a_share_of_each_reading():
    errors = 0.05 * np.array(ERRORS)
    read = FLEXIBILITY / 80 * (1 + errors)
    fit = answer("fit", made("nothing", read, ""), "--explore", 16, "--starts", 2)
    percent = 2 * fit["noise"]["scale"]["estimate"]
    logs = np.log(1 + errors)  # a constant share: the mean of the logarithms is the answer, but for terms of second order
    assert abs(percent / (100 * logs.std(ddof=1)) - 1) < 0.06, (percent, 100 * logs.std(ddof=1))
    assert [f for f in fit["findings"] if "% of each reading (95 %:" in f], fit["findings"]


@pytest.mark.parametrize("data, sought, words", [
    ('misfit = "log"\n[data.noise]\nscale = "sought"\n', OF_HALF_SPACE, 'misfit = "log"'),
    ('misfit = "weighted"\n[data.noise]\nscale = "sought"\nloss = "student"\n', OF_HALF_SPACE, 'loss = "student"'),
    ('misfit = "weighted"\n[data.noise]\nscale = "free"\n', OF_HALF_SPACE, "sought"),
    (STATED, OF_HALF_SPACE + "prior = { mean = 80, sd = 0.2 }\n", 'scale = "sought"')])
def test_what_the_size_of_the_noise_cannot_be_sought_with_is_refused(data, sought, words):
    done = run("fit", made("refused", READ, SIGMA, data, sought), "--out", folder / "no")
    assert done.returncode == 2 and words in done.stderr and "study.toml" in done.stderr, done.stderr
