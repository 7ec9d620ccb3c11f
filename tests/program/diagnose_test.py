"""`pavescape diagnose` as a user and another program meet it: keys, verdict without an effect, the extended study, wrong input,
continuation, the same bits for any number of threads. Whether it finds what is hidden: blind_test.py."""
import json
import math

import pytest

from support import *

LAYOUT = "load,quantity,x_mm,y_mm,depth_mm,gauge_mm,value,unit,sigma\n" + "".join(
    f"fwd,deflection,{x},0,0,0,1,mm,\n" for x in (0, 200, 300, 450, 600, 900)) + "".join(
    f"fwd,strain_zz,{x},0,{z},75,1,microstrain,\n" for x in (0, 200) for z in (90, 165, 240, 340, 420))
QUICK = ("--explore", 16, "--starts", 2, "--bootstrap", 4)

folder = workspace()
write_study(folder, data=LAYOUT, name="truth")


def twin(name, *options):
    """A study whose data a twin made."""
    place = folder / name
    done = run("twin", folder / "truth.toml", "--noise", 0.02, "--seed", 11, "--out", place / "twin", *options)
    assert done.returncode == 0, done.stderr
    shutil.copy(place / "twin" / "twin.csv", place / "data.csv")
    (place / "study.toml").write_text(STUDY.replace("small.csv", "data.csv"))
    return place / "study.toml"


def diagnose(study, out, *options):
    done = run("diagnose", study, "--json", "--out", folder / out, *QUICK, *options)
    assert done.returncode == 0, f"diagnose: {done.stderr}"
    return json.loads(done.stdout)


def test_nothing_hidden_is_adequate_and_the_model_is_left_as_it_is():
    study = twin("nothing")
    found = diagnose(study, "plain")
    assert found["verdict"] == "adequate" and found["causes"] == [], f"nothing is hidden: {found['verdict']} {found['causes']}"
    assert found["extended"]["study"] == str(study), "an adequate model is not extended"
    assert found["extended"]["chi2"] == found["baseline"]["chi2"], "an adequate model gains nothing"


@pytest.fixture(scope="module")
def study():
    """A gross effect, so that every part of the answer is there."""
    return twin("gross", "--effect", "floor-depth=2500")


@pytest.fixture(scope="module")
def found(study):
    return diagnose(study, "one", "--threads", 1)


def test_every_part_of_the_answer_is_there(found):
    for key, kinds in {"baseline": ("misfit", "chi2", "dof", "p_value"), "extended": ("misfit", "chi2", "dof", "p_value", "study"),
                       "gain": ("misfit_reduction", "held_out_rmse_before", "held_out_rmse_after", "delta_aicc")}.items():
        for kind in kinds:
            assert kind in found[key], f"{key} has {kind}"
    for candidate in found["candidates"]:
        for kind in ("effect", "score_z", "p_familywise", "delta_aicc", "size", "size_low", "size_high"):
            assert kind in candidate, f"a candidate has {kind}"
    names = [effect["name"] for effect in json.loads(run("effects", "--json").stdout)]
    assert found["verdict"] in ("adequate", "cause-named", "ambiguous", "located", "unexplained"), found["verdict"]
    assert found["verdict"] in ("cause-named", "ambiguous"), f"the floor lies 2.5 m deeper: {found['verdict']}"
    assert math.isclose(found["gain"]["misfit_reduction"], 1 - found["extended"]["misfit"] / found["baseline"]["misfit"]), "the gain is that of the misfits"
    assert found["gain"]["held_out_rmse_after"] < found["gain"]["held_out_rmse_before"], "readings left out are predicted better"


def test_the_extended_study_is_a_study(study, found):
    # The extended study is a study: its responses are those of the fit, and a fit of it ends no higher.
    extended = found["extended"]["study"]
    done = run("forward", extended, "--json")
    assert done.returncode == 0, f"the extended study: {done.stderr}"
    readings = [line.split(",") for line in (study.parent / "data.csv").read_text().splitlines() if line[0] not in "#l"]
    chi2 = sum(((r["value"] - float(line[6])) / float(line[8])) ** 2 for r, line in zip(json.loads(done.stdout)["responses"], readings))
    assert abs(chi2 / found["extended"]["chi2"] - 1) < 0.1, f"the extended study has chi2 {chi2}, the diagnosis says {found['extended']['chi2']}"
    refit = json.loads(run("fit", extended, "--json", "--explore", 16, "--starts", 3, "--out", folder / "refit").stdout)
    assert refit["best"]["misfit"] < found["extended"]["misfit"] * 1.01, "a fit of the extended study ends where the diagnosis did"
    assert any(name.endswith(".size") for name in refit["best"]["parameters"]), "the size is one of its parameters"


def without_the_place(found):
    return {k: v for k, v in without_run(found).items() if k != "extended"}


def test_two_threads_and_a_run_that_was_cut_off_give_the_same_bits(study, found):
    # The same bits on two threads, and after a run that was cut off; what is finished is not repeated.
    again = diagnose(study, "two", "--threads", 2)
    assert without_the_place(again) == without_the_place(found), "two threads give the same bits"
    kept = kill_at(60, folder / "cut", "diagnose", study, *QUICK)
    continued = diagnose(study, "cut")
    assert without_the_place(continued) == without_the_place(found), "a continued run ends with the same bits"
    assert evaluations(folder / "cut") == evaluations(folder / "one"), f"{kept} evaluations were kept, none was repeated"


def test_without_the_effect_it_is_not_named(study):
    other = diagnose(study, "without", "--without", "floor-depth")
    assert "floor-depth" not in other["causes"] and "floor-depth" not in [c["effect"] for c in other["candidates"]], "--without leaves an effect out"


def test_wrong_input_is_said(study):
    done = run("diagnose", study, "--without", "flor-depth")
    assert done.returncode == 2 and "did you mean \"floor-depth\"" in done.stderr, f"a misspelt effect: {done.stderr}"
    write_study(folder, study=STUDY.replace('[data]\nfiles = ["small.csv"]\nmisfit = "log"\n', ""), data=None, name="nodata")
    done = run("diagnose", folder / "nodata.toml")
    assert done.returncode == 2 and "needs measurements" in done.stderr, f"no data: {done.stderr}"


def test_an_effect_under_one_load_is_named_with_it():
    # An effect that acts under one load is named with it; another load that would do as well stands beside it.
    (folder / "loads").mkdir()
    two_loads = STUDY.replace("[mesh]", """[[loads]]
name = "light"
type = "plate"
radius_mm = 150
pressure_kPa = 300

[mesh]""").replace("k2 = 0.5", "k2 = 0.0").replace("k3 = -0.3", "k3 = 0.0") + "".join(
        f'\n[[parameters]]\nname = "{name}"\nmin = {low}\nmax = {high}\nscale = "log"\n'
        for name, low, high in (("asphalt.modulus_MPa", 500, 20000), ("subgrade.modulus_MPa", 15, 150)))
    rows = "".join(f"{load},deflection,{x},0,0,0,1,mm,\n" for load in ("fwd", "light") for x in (0, 200, 300, 450, 600, 900))
    write_study(folder / "loads", study=two_loads, data=LAYOUT.splitlines()[0] + "\n" + rows, name="truth")
    done = run("twin", folder / "loads" / "truth.toml", "--noise", 0.05, "--seed", 3, "--effect", "load-magnitude=1.4", "--out", folder / "loads" / "twin")
    assert done.returncode == 0, f"twin of two loads: {done.stderr}"
    shutil.copy(folder / "loads" / "twin" / "twin.csv", folder / "loads" / "data.csv")
    (folder / "loads" / "study.toml").write_text(two_loads.replace("small.csv", "data.csv"))
    done = run("diagnose", folder / "loads" / "study.toml", "--json", "--out", folder / "loads" / "run", *QUICK)
    found = json.loads(done.stdout)
    magnitude = next(c for c in found["candidates"] if c["effect"] == "load-magnitude")
    assert magnitude["on"] in ("fwd", "light") and magnitude["size"] is not None, f"which load: {magnitude}"
    assert all(other["on"] in ("fwd", "light") and other["on"] != magnitude["on"] and 0 <= other["delta_chi2"] <= 3.84 for other in magnitude["alike"]), \
        f"the other load: {magnitude}"
    by_load = {entry["on"]: entry["size"] for entry in [magnitude, *magnitude["alike"]]}
    assert "fwd" not in by_load or abs(by_load["fwd"] / 1.4 - 1) < 0.2, f"the first load is 1.4 times as large: {by_load}"
    assert "light" not in by_load or abs(by_load["light"] * 1.4 - 1) < 0.2, f"or the other 1.4 times smaller: {by_load}"
    assert len(by_load) == 2, f"a linear section cannot tell which of two loads is meant: {by_load}"
