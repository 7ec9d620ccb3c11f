"""The steps of the load path in what the program says: chosen by the noise of the readings, the same when the run goes on, stated by the study."""
import functools
import json

from support import *

STUDY = """schema = 1
[[layers]]
name = "asphalt"
density_kg_m3 = 2300
k0 = 0.5
thickness_mm = 60
law = "linear"
modulus_MPa = 5000
poisson = 0.35
[[layers]]
name = "base"
density_kg_m3 = 2100
k0 = 0.4
thickness_mm = 240
law = "uzan"
k1 = 2500
k2 = 0.8
k3 = -0.3
n = 0.3
poisson_12 = 0.35
poisson_31 = 0.35
[[layers]]
name = "subgrade"
density_kg_m3 = 1800
k0 = 0.5
thickness_mm = 1500
law = "linear"
modulus_MPa = 70
poisson = 0.4
[[loads]]
name = "fwd"
type = "plate"
radius_mm = 150
pressure_kPa = 900
[mesh]
refine = 0.5
"""
FITTED = """[data]
files = ["small.csv"]
misfit = "weighted"
[[parameters]]
name = "base.k1"
min = 500
max = 9000
scale = "log"
[[parameters]]
name = "subgrade.modulus_MPa"
min = 30
max = 200
scale = "log"
"""
PLACES = [("deflection", x, 0) for x in (0, 300, 600, 900)] + [("strain_zz", 0, z) for z in (120, 200, 290, 400)]
OUTPUTS = "".join(f'[[outputs]]\nname = "r{i}"\nload = "fwd"\nquantity = "{q}"\nx_mm = {x}\ndepth_mm = {z}\n' for i, (q, x, z) in enumerate(PLACES))
STEPS = "[solver]\nload_steps = {}\n"
folder = workspace()


def forward(name, solver):
    done = run("forward", write_study(folder / name, STUDY + solver + OUTPUTS, None), "--json")
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@functools.cache
def fine():
    return forward("fine", STEPS.format(200))["responses"]


def fitted(name, share, solver="", *options):
    """The fit to readings along a path of 200 steps that state this share of their value as noise."""
    data = "load,quantity,x_mm,y_mm,depth_mm,gauge_mm,value,unit,sigma\n" + "".join(
        f"fwd,{q},{x},0,{z},0,{r['value']},{r['unit']},{share * abs(r['value'])}\n" for (q, x, z), r in zip(PLACES, fine()))
    done = run("fit", write_study(folder / name, STUDY + solver + FITTED, data), "--json", "--explore", "16", "--starts", "2", *options)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def said(fit, *words):
    return [f for f in fit["findings"] if "load path" in f.lower() and all(word in f for word in words)]


def test_forward_runs_take_the_steps_that_the_study_states():
    assert forward("default", "")["load_steps"] == 9
    assert forward("stated", STEPS.format(17))["load_steps"] == 17
    assert forward("older", "[solver]\npath_tolerance = 2.5e-4\n")["load_steps"] == 18


def test_noise_that_is_large_needs_fewer_steps_which_leave_next_to_nothing():
    fit = fitted("large", 0.1)
    assert 5 <= fit["path"]["load_steps"] < 9 and not fit["path"]["shows"] and not said(fit), fit["path"]
    assert fit["path"]["share_of_noise"] < 0.024
    # The readings are exact: what the path leaves is all of chi2.
    assert fit["noise"]["chi2"] < 0.024**2 * len(PLACES)


def test_noise_that_is_small_asks_for_more_steps_which_leave_no_bias():
    fit = fitted("small", 0.001)
    steps = fit["path"]["load_steps"]
    assert steps > 9 and said(fit, f"{steps} steps")
    assert fit["path"]["share_of_noise"] < 0.12
    # The readings are exact: what the path leaves is all of chi2, a hundredth a reading at most.
    assert fit["noise"]["chi2"] < 0.01 * len(PLACES)


def test_stated_steps_are_kept_and_judged():
    fit = fitted("few", 0.001, STEPS.format(3))
    assert fit["path"]["load_steps"] == 3 and fit["path"]["shows"]
    assert said(fit, "3 steps", "load_steps = ")


def test_a_run_that_goes_on_is_found_again():
    out = folder / "kept"
    first = fitted("again", 0.001, "", "--out", out)
    before = counted(out)
    again = fitted("again", 0.001, "", "--out", out)
    assert first["best"] == again["best"] and first["path"] == again["path"]
    assert counted(out) == before, "the second run computed nothing"
