"""Whole pulses in the explorer: a twin by transforms in frequency (tests/blind/pulse_generator.cpp) is fitted, its answer walked, mapped, compared and reported; a hidden
effect that only time tells is found in histories."""
import json
import subprocess

import pytest

from support import *

GENERATOR = BUILD / "tests" / "pulse_generator"
folder = workspace()


def made(name, seed, *effect):
    done = subprocess.run([GENERATOR, str(seed), folder / name, *effect], capture_output=True, text=True)
    assert done.returncode == 0, f"generator: {done.stderr}"
    return json.loads(done.stdout)


def results(command, study, *options):
    done = run(command, study, "--out", study.parent / command, "--json", *options)
    assert done.returncode == 0, f"{command}: {done.stderr}"
    return json.loads(done.stdout)


@pytest.fixture(scope="module")
def twin():
    truth = made("twin", 2001)["parameters"]
    study = folder / "twin" / "study.toml"
    found = results("fit", study, "--explore", 32, "--starts", 2)
    return truth, study, found


def test_a_fit_finds_the_twin(twin):
    truth, _, found = twin
    best, errors = found["best"]["parameters"], found["best"]["standard_errors"]
    assert found["noise"]["p_value"] > 1e-3, f"the model fits the twin: {found['noise']}"
    for name in truth:
        assert abs(best[name] - truth[name]) < 4 * errors[name], f"fit: {name} {best[name]} +- {errors[name]}, not {truth[name]}"
    assert errors["subgrade.thickness_mm"] < 0.02 * truth["subgrade.thickness_mm"], "histories determine the depth of the rock"


def test_ranges_of_unique_are_those_of_the_standard_errors(twin):
    truth, study, found = twin
    errors = found["best"]["standard_errors"]  # noise is small
    answer = results("unique", study, "--explore", 32, "--verify", 2)
    assert answer["verdict"] == "unique", f"unique: {answer['verdict']}"
    for name in truth:
        span = next(p for p in answer["profiles"] if p["name"] == name)
        assert abs((span["high"] - span["low"]) / (2 * 1.96 * errors[name]) - 1) < 0.15, f"unique: the range of {name}: {span}, standard error {errors[name]}"


def test_no_point_of_a_map_is_lower_than_the_fit(twin):
    _, study, found = twin
    lowest = results("map", study, "--points", 128)
    assert lowest["lowest"][0]["misfit"] >= found["best"]["misfit"], "no point of a map is lower than the fit"


@pytest.mark.long
def test_a_linear_base_is_not_taken_for_another(twin):
    _, study, found = twin
    laws = {law["law"]: law for law in results("compare", study, "--layer", "base", "--laws", "linear,k-theta", "--explore", 24, "--verify", 2)["laws"]}
    assert abs(laws["linear"]["chi2"] - found["noise"]["chi2"]) < 0.1, f"compare fits as fit does: {laws['linear']['chi2']}, {found['noise']['chi2']}"
    assert "k-theta" in laws and laws["linear"]["aicc"] < laws["k-theta"]["aicc"] + 2, f"a linear base is not taken for another: {laws}"


def test_sensitivity_of_every_reading(twin):
    _, study, _ = twin
    curves = results("sensitivity", study, "--samples", 16)
    assert len(curves["responses"]) == 105, f"sensitivity of every reading: {len(curves['responses'])}"


def test_the_page_has_times(twin):
    _, study, _ = twin
    page = run("report", study.parent / "fit")
    assert page.returncode == 0 and "time_ms" in (study.parent / "fit" / "report.html").read_text(), f"the page: {page.stderr}"


def test_damping_is_told_by_histories():
    # The effect is known to the judge alone.
    hidden = made("hidden", 2002, "damping")
    told = results("diagnose", folder / "hidden" / "study.toml", "--explore", 32, "--starts", 2, "--bootstrap", 10)
    assert told["causes"] == ["damping"], f"damping in histories: {told['verdict']} {told['causes']}"
    own = next(c for c in told["candidates"] if c["effect"] == "damping")
    assert abs(own["size"] - hidden["size"]) < 1.5 * (own["size_high"] - own["size_low"]), \
        f"its size {own['size']} ({own['size_low']} to {own['size_high']}), not {hidden['size']}"
