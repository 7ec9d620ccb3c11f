"""`compare`: data made with one law are not taken for those of another; keys, ranges and answers are those of the study."""
import json

import pytest

from support import *

folder = workspace()
options = ["--explore", 24, "--verify", 4]

# A plate at two pressures over a base that stiffens with confinement.
loads = """[[loads]]
name = "light"
type = "plate"
radius_mm = 150
pressure_kPa = 200

[[loads]]
name = "heavy"
type = "plate"
radius_mm = 150
pressure_kPa = 900
"""
text = STUDY.replace(STUDY[STUDY.index("[[loads]]"):STUDY.index("[mesh]")], loads + "\n").replace('load = "fwd"', 'load = "heavy"')
text = text.replace("k2 = 0.5", "k2 = 0.8").replace("n = 0.5", "n = 1.0")
text = text.replace('[[parameters]]\nname = "base.n"\nmin = 0.1\nmax = 4.5\npoints = 3\n',
                    '[[parameters]]\nname = "base.k2"\nmin = 0\nmax = 1\n\n[[parameters]]\nname = "subgrade.modulus_MPa"\nmin = 20\nmax = 120\nscale = "log"\n')
text = text.replace('misfit = "log"', 'misfit = "log"\nnoise_relative = 0.02')
layout = "load,quantity,x_mm,y_mm,depth_mm,gauge_mm,value,unit,sigma\n" + "".join(
    f"{load},{quantity},{x},0,{depth},{gauge},{value},{unit},\n"
    for load in ("light", "heavy")
    for quantity, x, depth, gauge, value, unit in [("deflection", x, 0, 0, 0.5, "mm") for x in (0, 200, 300, 450, 600, 900)]
    + [("strain_zz", 0, 120, 75, 800, "microstrain"), ("strain_zz", 0, 220, 75, 800, "microstrain"), ("strain_zz", 0, 360, 75, 800, "microstrain")])


@pytest.fixture(scope="module")
def study():
    made = write_study(folder / "made", text, layout)
    twin = run("twin", made, "--noise", "0.02", "--seed", "5", "--out", folder / "twin")
    assert twin.returncode == 0, f"twin: {twin.stderr}"
    return write_study(folder / "s", text, (folder / "twin" / "twin.csv").read_text())


def test_a_linear_layer_is_compared_too(study):
    # From a study whose base is linear, and so isotropic.
    start = text.index('law = "uzan"')
    linear = text[:start] + 'law = "linear"\nmodulus_MPa = 200\npoisson = 0.35\n' + text[text.index("\n[[layers]]", start):]
    linear = linear.replace('name = "base.k1"', 'name = "base.modulus_MPa"').replace('[[parameters]]\nname = "base.k2"\nmin = 0\nmax = 1\n\n', "")
    of_linear = run("compare", write_study(folder / "l", linear, (study.parent / "small.csv").read_text()), "--layer", "base", "--laws", "linear,uzan", "--json",
                    "--out", folder / "of-linear", *options)
    assert of_linear.returncode == 0, f"compare from a linear layer: {of_linear.stderr}"
    from_linear = {law["law"]: law for law in json.loads(of_linear.stdout)["laws"]}
    assert from_linear["uzan"]["p_value"] > 0.001 and from_linear["linear"]["p_value"] < 1e-4, f"from a linear layer too: {from_linear}"


@pytest.fixture(scope="module")
def compared(study):
    done = run("compare", study, "--laws", "linear,uzan,k-theta,lade-nelson", "--json", "--out", folder / "run", *options)
    assert done.returncode == 0, f"compare runs: {done.stderr}"
    found = json.loads(done.stdout)
    laws = {law["law"]: law for law in found["laws"]}
    return found, laws


def test_the_law_of_the_data_is_preferred(compared):
    found, laws = compared
    assert found["layer"] == "base" and set(laws) == {"linear", "uzan", "k-theta", "lade-nelson"}, "every law that was requested"
    assert laws["uzan"]["p_value"] > 0.001, f"the law of the data fits: {laws['uzan']['p_value']}"
    assert laws["linear"]["p_value"] < 1e-4 and laws["linear"]["weight"] < 0.01, "a linear base does not fit what a stiffening one left"
    assert laws["linear"]["held_out_rms"] > 1.2 * laws["uzan"]["held_out_rms"], "and predicts worse what it was not shown"
    assert found["laws"][0]["law"] != "linear" and "linear" in found["findings"][0], f"the findings say so: {found['findings']}"
    assert abs(sum(law["weight"] for law in found["laws"]) - 1) < 1e-9, "weights are shares"
    assert found["laws"] == sorted(found["laws"], key=lambda law: law["aicc"]), "the preferred law stands first"


def test_parameters_of_each_law_are_varied(compared):
    _, laws = compared
    # k3 = -0.3 is held in the study: uzan and k-theta vary the same, k-theta is uzan without it.
    assert set(laws["uzan"]["parameters"]) == set(laws["k-theta"]["parameters"]) == {"base.k1", "base.k2", "subgrade.modulus_MPa"}, "shared keys are kept"
    assert set(laws["linear"]["parameters"]) == {"base.modulus_MPa", "subgrade.modulus_MPa"}, "own keys of a law are varied"
    assert set(laws["lade-nelson"]["parameters"]) == {"base.m", "base.lambda", "subgrade.modulus_MPa"}, "own keys of a law are varied"


def test_aicc_is_that_of_stated_noise_and_outputs_lie_in_their_ranges(compared):
    found, _ = compared
    for law in found["laws"]:
        # The noise is stated, and no variance is estimated: the correction for few readings belongs to that (Akaike 1974).
        expected = law["chi2"] + 2 * len(law["parameters"])
        assert abs(law["aicc"] - expected) < 1e-9, f"AICc of {law['law']} under stated noise: {law['aicc']}, not {expected}"
        for output in law["outputs"]:
            assert output["low"] <= output["best"] <= output["high"], f"{law['law']}: the best output lies in its range"


def test_with_its_own_law_the_study_is_what_unique_sees(study, compared):
    _, laws = compared
    own = json.loads(run("unique", study, "--json", "--out", folder / "unique", *options).stdout)
    for name, value in own["minima"][0]["parameters"].items():
        assert value == laws["uzan"]["parameters"][name]["value"], f"unique and compare agree on {name}"
    assert own["verdict"] == laws["uzan"]["verdict"], "and on the verdict"


def test_the_second_time_nothing_is_computed(study, compared):
    found, _ = compared
    total = evaluations(folder / "run")
    again = json.loads(run("compare", study, "--laws", "linear,uzan,k-theta,lade-nelson", "--json", "--out", folder / "run", *options).stdout)
    finished, computed = counted(folder / "run")
    assert again == found and evaluations(folder / "run") == total, "the second time nothing is computed"
    assert finished == computed, f"nothing is computed twice: {computed:g} for {finished} finished evaluations"


@pytest.mark.usefixtures("compared")
def test_a_person_gets_a_table_and_a_report(study):
    table = run("compare", study, "--laws", "linear,uzan,k-theta,lade-nelson", "--out", folder / "run", *options).stdout
    assert "AICc" in table and "lade-nelson" in table, "a person gets a table"
    assert run("report", folder / "run").returncode == 0, "and a report"


def test_what_cannot_be_compared_is_refused(study):
    wrong = run("compare", study, "--laws", "k_theta")
    assert wrong.returncode == 2 and "k-theta" in wrong.stderr, f"an unknown law: {wrong.stderr}"
    wrong = run("compare", study, "--layer", "bass")
    assert wrong.returncode == 2 and "base" in wrong.stderr, f"an unknown layer: {wrong.stderr}"
    effect = write_study(folder / "e", text + '\n[[effects]]\nname = "shear-ratio"\nsize = 0.3\n', layout)
    wrong = run("compare", effect, "--laws", "lade-nelson")
    assert wrong.returncode == 2 and "shear-ratio" in wrong.stderr, f"an effect that a law cannot have: {wrong.stderr}"


def test_evidence_of_the_own_law_is_that_of_sample():
    # Evidence: that of `sample` for each law, and shares of it. On linear layers, where a run takes a millisecond.
    linear = write_study(folder / "evidence", LAYERED, LAYERED_BOWL)
    weighed = run("compare", linear, "--layer", "base", "--laws", "linear", "--evidence", "--json", "--out", folder / "evidence" / "run", *options)
    assert weighed.returncode == 0, f"compare --evidence runs: {weighed.stderr}"
    law, = json.loads(weighed.stdout)["laws"]
    own = json.loads(run("sample", linear, "--json", "--out", folder / "evidence" / "sample").stdout)
    assert law["log_evidence"] == own["log_evidence"], f"the evidence of the study's own law is that of sample: {law.get('log_evidence')}, {own['log_evidence']}"
    assert abs(law["evidence_weight"] - 1) < 1e-12, f"one law has all of it: {law['evidence_weight']}"
