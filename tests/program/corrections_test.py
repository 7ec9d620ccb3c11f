"""Corrections as a user meets them: stated in a study, and found by `diagnose` where the section has what no effect of the catalogue
is: a wet lens within the subgrade. How often that is right: tools/trials/blind."""
import json
import math

import pytest

from support import *

folder = workspace()

# A subgrade of three layers, the middle one wet, on a finer mesh; the study that is diagnosed knows one layer.
SUBGRADE = """[[layers]]
name = "{}"
thickness_mm = {}
density_kg_m3 = 1900
k0 = 0.5
law = "linear"
modulus_MPa = {}
poisson = 0.40
"""
WHOLE = SUBGRADE.format("subgrade", 1210, 45)
assert WHOLE in STUDY
LENS = "\n".join(SUBGRADE.format(*part) for part in (("subgrade", 150, 60), ("lens", 200, 25), ("below", 860, 60)))
LAYOUT = "load,quantity,x_mm,y_mm,depth_mm,gauge_mm,value,unit,sigma\n" + "".join(
    f"fwd,deflection,{x},0,0,0,1,mm,\n" for x in (0, 200, 300, 450, 600, 900, 1200)) + "".join(
    f"fwd,strain_zz,{x},0,{z},75,1,microstrain,\n" for x in (0, 250) for z in (90, 165, 240, 340, 420, 500, 580, 660, 740))
QUICK = ("--explore", 16, "--starts", 2, "--bootstrap", 4)
PARAMETERS = '\n[[parameters]]\nname = "subgrade.modulus_MPa"\nmin = 10\nmax = 200\nscale = "log"\n'
weighted = STUDY.replace('misfit = "log"', 'misfit = "weighted"') + PARAMETERS
truth = STUDY.replace(WHOLE, LENS).replace("refine = 0.4", "refine = 0.8").split("[[parameters]]")[0]


def twin(name, study, seed):
    write_study(folder / name, study, LAYOUT, "truth")
    done = run("twin", folder / name / "truth.toml", "--noise", 0.04, "--seed", seed, "--out", folder / name / "twin")
    assert done.returncode == 0, done.stderr
    shutil.copy(folder / name / "twin" / "twin.csv", folder / name / "small.csv")
    return write_study(folder / name, weighted, None, "study")


def diagnose(study, *options):
    done = run("diagnose", study, "--json", "--out", study.parent / "run", *QUICK, *options)
    assert done.returncode == 0, f"diagnose: {done.stderr}"
    return json.loads(done.stdout)


# Stated: factors of 1 change nothing, one factor everywhere is another modulus, and a factor is a parameter like others.
write_study(folder, STUDY)


@pytest.fixture(scope="module")
def plain():
    return json.loads(run("forward", folder / "small.toml", "--json").stdout)["responses"]


def corrected(name, text, *options):
    path = write_study(folder, STUDY.replace("[[outputs]]", text + "\n[[outputs]]"), None, name)
    done = run("forward", path, "--json", *options)
    assert done.returncode == 0, f"{name}: {done.stderr}"
    return json.loads(done.stdout)


DEPTH = '[[corrections]]\nchannel = "depth"\nlayer = "subgrade"\nat_mm = [0, 200, 600]\nfactor = [{}, {}, {}]\n'


def test_factors_of_one_change_nothing_and_one_factor_everywhere_is_another_modulus(plain):
    assert corrected("one", DEPTH.format(1, 1, 1))["responses"] == plain, "factors of 1 change nothing"
    half = corrected("half", DEPTH.format(0.5, 0.5, 0.5))["responses"]
    path = write_study(folder, STUDY.replace("modulus_MPa = 45", "modulus_MPa = 22.5"), None, "soft")
    soft = json.loads(run("forward", path, "--json").stdout)["responses"]
    assert all(math.isclose(a["value"], b["value"], rel_tol=1e-5) for a, b in zip(half, soft)), "half of it everywhere is half of the modulus"


def test_a_factor_is_a_parameter_like_others():
    FREE = '\n[[parameters]]\nname = "subgrade-depth.factor_2"\nmin = 0.2\nmax = 5\nscale = "log"\n'
    found = corrected("free", DEPTH.format(1, 1, 1) + FREE, "--jacobian")
    assert "subgrade-depth.factor_2" in found["jacobian"]["parameters"], "a factor is a parameter"


@pytest.fixture(scope="module")
def found():
    # Found.
    study = twin("lens", truth, 5)
    found = diagnose(study)
    print("\n".join(found["findings"]))
    return found


def test_a_wet_lens_is_located(found):
    assert found["verdict"] == "located", f"a wet lens is no effect of the catalogue: {found['verdict']} {found['causes']}"
    assert found["causes"] == [], "where it is located, no cause is named"
    for key in ("channel", "layer", "p_familywise", "values", "low", "high", "seen", "explained_by"):
        assert all(key in c for c in found["corrections"]), f"a correction has {key}"
    first = found["corrections"][0]
    assert first["layer"] == "subgrade" and first["channel"] == "depth", f"the lens lies in the subgrade: {first['layer']} by {first['channel']}"
    assert first["p_familywise"] < 0.01, f"it is not due to chance: p = {first['p_familywise']}"
    softest = min((m, at) for m, at, seen in zip(first["modulus_MPa"], first["at"], first["seen"]) if seen)
    assert 100 <= softest[1] <= 400 and softest[0] < 40, f"at 150 to 350 mm it has 25 of 60 MPa: {softest}"
    assert found["extended"]["chi2"] < 0.5 * found["baseline"]["chi2"], "the correction explains most of what was wrong"
    assert found["gain"]["held_out_rmse_after"] < found["gain"]["held_out_rmse_before"], "readings left out are predicted better"


def test_strains_in_the_layer_would_tell_most(found):
    # What would tell more of it: kinds that the study reads first, then those that need other gauges. Of what is offered, strains in the layer say more than deflections far away.
    offered = [found["next_measurement"], *found["further_measurements"]]
    assert offered == sorted(offered, key=lambda r: (r["quantity"] not in ("deflection", "strain_zz"), -r["bits"])) and offered[0]["bits"] > 0.1, f"the most telling first: {offered[0]}"
    bits = {(r["quantity"], r["x_mm"]): r["bits"] for r in offered if "% of" not in r["load"]}
    assert max(b for (q, _), b in bits.items() if q == "strain_zz") > bits["deflection", 1800], f"bits: {bits}"
    assert all("." not in r["load"] for r in offered) and any("150 %" in r["load"] for r in offered), "a heavier drop has a name that a study takes"
    assert any(f.startswith("Best next measurement") and "where the model errs" in f for f in found["findings"]), "said in the findings"


def test_the_extended_study_holds_the_correction_as_a_table(found):
    done = run("forward", found["extended"]["study"], "--json")
    assert done.returncode == 0, f"the extended study: {done.stderr}"
    modelled = json.loads(done.stdout)["responses"]
    assert all(math.isclose(r["value"], v, rel_tol=1e-6) for r, v in zip(modelled, found["responses"]["extended"])), "its responses are those of the diagnosis"
    assert "[[prior_correlations]]" in pathlib.Path(found["extended"]["study"]).read_text(), "with what was known beforehand"


def test_nothing_hidden_no_correction():
    found = diagnose(twin("plain", STUDY.replace("refine = 0.4", "refine = 0.8").split("[[parameters]]")[0], 6))
    assert found["verdict"] == "adequate" and found["corrections"] == [], f"nothing is hidden: {found['verdict']} {found['corrections']}"
