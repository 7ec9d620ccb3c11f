"""pavescape sample as a user meets it: the promised keys, the same bits for any number of threads, killed and continued."""

import math
import re

import pytest

from support import *

folder = workspace()
TWO = LAYERED + """
[[parameters]]
name = "subgrade.modulus_MPa"
min = 20
max = 200
scale = "log"

[[outputs]]
name = "top-strain"
load = "fwd"
quantity = "strain_zz"
depth_mm = 630
"""
study = write_study(folder / "s", TWO, LAYERED_BOWL)
options = ["--samples", 800]


def sample(out, *more):
    done = run("sample", study, "--json", "--out", folder / out, *options, *more)
    assert done.returncode == 0, f"{out}: {done.stderr}"
    return lasting(json.loads(done.stdout))


@pytest.fixture(scope="module")
def one():
    return sample("one", "--threads", 1)


def test_the_draws_have_converged_and_are_the_same_for_two_threads(one):
    assert one["status"] == "converged" and one["log_evidence_error"] < 0.3, "converged, with an evidence"
    for quantity in one["parameters"] + one["outputs"]:
        for key in ("name", "mean", "sd", "q025", "q50", "q975", "rhat", "ess"):
            assert key in quantity, f"{quantity['name']} has {key}"
        assert quantity["rhat"] <= 1.05 and quantity["ess"] >= 200, f"{quantity['name']}: enough draws"
    assert one == sample("two", "--threads", 2), "one thread and two give the same draws"


def test_nearly_linear_posterior_ranges_are_those_of_the_profiles(one):
    # Next to linear within its noise: the posterior's 95 % range is the profile's.
    unique = json.loads(run("unique", study, "--json", "--out", folder / "u", "--explore", 16, "--verify", 4).stdout)
    for quantity, profile in zip(one["parameters"] + one["outputs"], unique["profiles"] + unique["outputs"]):
        width = profile["high"] - profile["low"]
        assert abs(quantity["q025"] - profile["low"]) < 0.2 * width and abs(quantity["q975"] - profile["high"]) < 0.2 * width, \
            f"{quantity['name']}: {quantity['q025']} to {quantity['q975']}, profile {profile['low']} to {profile['high']}"


def test_unique_with_posterior_says_the_same():
    held = json.loads(run("unique", study, "--posterior", "--json", "--out", folder / "up", "--explore", 16, "--verify", 4).stdout)
    assert (all(q["posterior"]["differs_by"] == "" for q in held["profiles"] + held["outputs"]) and
            any("agree with those that were walked" in f for f in held["findings"])), \
        "unique --posterior says the same"
    assert ([q["posterior"]["low"] for q in held["profiles"]] ==
            [p["q025"] for p in json.loads(run("sample", study, "--json", "--out", folder / "up").stdout)["parameters"]]), \
        "from the draws of sample"


def test_a_killed_run_continues_with_the_same_draws(one):
    total = evaluations(folder / "one")
    before = kill_at(total // 3, folder / "cut", "sample", study, "--json", *options)
    assert sample("cut") == one, "a run that was killed and continued ends with the same draws"
    assert 0 < before < total and evaluations(folder / "cut") == total, "and repeats nothing that was finished"
    assert len((folder / "cut" / "samples.csv").read_text().splitlines()) == 801, "a line a draw"


def test_the_next_reading_tells_what_differences_of_forward_say(one):
    # What a reading more would tell: ln(1 + s^2) / (2 ln 2), s the spread of its value over the draws in units of its noise, here by
    # differences of `forward` at the mean of the draws, on whose logarithmic scales both moduli were drawn.
    rows = [line.split(",") for line in (folder / "one" / "samples.csv").read_text().splitlines()]
    columns = [rows[0].index(p["name"]) for p in one["parameters"]]
    logs = [[math.log(float(row[c])) for c in columns] for row in rows[1:]]
    mean = [sum(values) / len(logs) for values in zip(*logs)]
    covariance = [[sum((v[a] - mean[a]) * (v[b] - mean[b]) for v in logs) / len(logs) for b in range(2)] for a in range(2)]
    telling = next(r for r in one["next_measurement"] if r["reading"].startswith("deflection at") and "% of" not in r["reading"])
    offset = float(telling["reading"].split()[2])


    def deflection(moduli):
        text = TWO.split("[data]")[0]
        for layer, modulus in zip(("base", "subgrade"), moduli):
            head, tail = text.split(f'name = "{layer}"', 1)
            text = head + f'name = "{layer}"' + re.sub(r"(?m)^modulus_MPa = .*", f"modulus_MPa = {math.exp(modulus)!r}", tail, count=1)
        write_study(folder / "d", text + f'[[outputs]]\nname = "d"\nload = "fwd"\nquantity = "deflection"\nx_mm = {offset}\n', None)
        return json.loads(run("forward", folder / "d" / "small.toml", "--json").stdout)["responses"][0]["value"]


    step = 0.01
    slope = [(deflection([m + step * (a == b) for b, m in enumerate(mean)]) - deflection([m - step * (a == b) for b, m in enumerate(mean)])) / (2 * step)
             for a in range(2)]
    spread = sum(slope[a] * covariance[a][b] * slope[b] for a in range(2) for b in range(2)) / telling["sigma"] ** 2
    # The posterior is nearly normal; the program's entropy is that of a few hundred draws, its value their mean at 64.
    assert abs(deflection(mean) / telling["value"] - 1) < 0.005 and abs(telling["bits"] - 0.5 * math.log2(1 + spread)) < 0.15, \
        f"{telling['reading']}: {telling['bits']} bits, {0.5 * math.log2(1 + spread)} by differences"
    order = sorted(one["next_measurement"], key=lambda r: (not r["reading"].startswith("deflection"), -r["bits"]))
    assert one["next_measurement"] == order, "what the study reads already, then other quantities; most bits first"


# A reduced model draws, the full one weighs: where it ran by its own density, elsewhere by a smooth surface. The same
# draws, all of them run, say how good that is.
noisy = STUDY.split("[[outputs]]")[0].replace('misfit = "log"', 'misfit = "weighted"\nnoise_relative = 0.02\nnoise_floor = 0.01').replace("max = 4.5", "max = 1.2")
bowl = "load,quantity,x_mm,y_mm,depth_mm,gauge_mm,value,unit,sigma\n" + "".join(f"fwd,deflection,{x},0,0,0,{v},mm,\n" for x, v in ((0, 1.08), (200, 0.72), (450, 0.335), (900, 0.08)))
stress = write_study(folder / "stress", noisy, bowl)


def density(confirm):
    out = "density"
    done = run("sample", stress, "--json", "--out", folder / out, "--model", "auto", "--samples", 400, "--confirm", confirm)
    assert done.returncode == 0, f"{out}: {done.stderr}"
    rows = [line.split(",") for line in (folder / out / "samples.csv").read_text().splitlines()[1:]]
    return json.loads(done.stdout)["correction"], {tuple(row[3:]): float(row[2]) for row in rows}


def test_draws_of_the_reduced_model_are_weighed_by_the_full_one():
    surface, some = density(80)
    exact, every = density(400)
    apart = [abs(some[place] - every[place]) for place in every if place in some]
    assert len(every) == 400 and len(apart) == 400, f"every draw is kept, {len(apart)} of {len(every)}"
    assert sum(a < 1e-12 for a in apart) >= 80, "those that were run by their own densities"
    others = [a for a in apart if a >= 1e-12]
    rms = (sum(a * a for a in others) / len(others)) ** 0.5
    nothing = 1e-3  # of a logarithm of density: weights change by as much
    assert rms < max(1.3 * surface["left"], nothing) and surface["left"] < 0.1, f"the others to what is said to be left: {rms}, {surface['left']}"
    assert exact["full_runs"] == 400 and surface["effective_draws"] > 0.9 * 400, "and are worth as much"


def test_a_posterior_that_differs_from_the_profile_is_said():
    # Two deflections for k1 and n: a valley that ends at a bound, where draws thin out.
    valley = write_study(folder / "v", noisy.replace("noise_floor = 0.01", "noise_floor = 0.1").replace("max = 1.2", "max = 4.5"),
                         bowl.splitlines()[0] + "\nfwd,deflection,0,0,0,0,1.08,mm,\nfwd,deflection,200,0,0,0,0.72,mm,\n")
    cheap = ["--model", "auto", "--posterior", "--json", "--explore", 16, "--verify", 4]
    held = json.loads(run("unique", valley, "--out", folder / "vp", *cheap).stdout)
    said = [q["name"] for q in held["profiles"] if q["posterior"]["differs_by"]]
    for q, scale in zip(held["profiles"], (math.log, float)):
        low, high = scale(q["low"]), scale(q["high"])
        off = max(abs(scale(q["posterior"]["low"]) - low), abs(scale(q["posterior"]["high"]) - high)) / (high - low)
        assert (off > 0.2) == (q["name"] in said), f"{q['name']}: {off} of the range, {said}"
    assert said and any("differs by more than a fifth" in f and all(n in f for n in said) for f in held["findings"]), "what differs is said"


def test_without_noise_it_is_refused():
    bare = write_study(folder / "bare", TWO, LAYERED_BOWL.split("\n")[0] + "\nfwd,deflection,0,0,0,0,0.5,mm,\n")
    done = run("sample", bare, "--out", folder / "b")
    assert done.returncode == 2 and done.stdout == "" and "noise" in done.stderr, "without noise: refused"
