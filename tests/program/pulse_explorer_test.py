"""Whole pulses in the explorer: a twin by transforms in frequency (tests/blind/pulse_generator.cpp) is fitted, its answer walked, mapped, compared and reported; a hidden
effect that only time tells is found in histories.

python3 tests/program/pulse_explorer_test.py PROGRAM GENERATOR"""
import json
import subprocess
import sys

from support import *

GENERATOR = sys.argv[2]
folder = workspace()


def made(name, seed, *effect):
    done = subprocess.run([GENERATOR, str(seed), folder / name, *effect], capture_output=True, text=True)
    check(done.returncode == 0, f"generator: {done.stderr}")
    return json.loads(done.stdout)


def results(command, study, *options):
    done = run(command, study, "--out", study.parent / command, "--json", *options)
    check(done.returncode == 0, f"{command}: {done.stderr}")
    return json.loads(done.stdout) if done.returncode == 0 else {}


truth = made("twin", 2001)["parameters"]
study = folder / "twin" / "study.toml"
found = results("fit", study, "--explore", 32, "--starts", 2)
best, errors = found["best"]["parameters"], found["best"]["standard_errors"]
check(found["noise"]["p_value"] > 1e-3, f"the model fits the twin: {found['noise']}")
for name in truth:
    check(abs(best[name] - truth[name]) < 4 * errors[name], f"fit: {name} {best[name]} +- {errors[name]}, not {truth[name]}")
check(errors["subgrade.thickness_mm"] < 0.02 * truth["subgrade.thickness_mm"], "histories determine the depth of the rock")

# The ranges of unique are those of the standard errors, for noise is small.
answer = results("unique", study, "--explore", 32, "--verify", 2)
check(answer["verdict"] == "unique", f"unique: {answer['verdict']}")
for name in truth:
    span = next(p for p in answer["profiles"] if p["name"] == name)
    check(abs((span["high"] - span["low"]) / (2 * 1.96 * errors[name]) - 1) < 0.15, f"unique: the range of {name}: {span}, standard error {errors[name]}")

lowest = results("map", study, "--points", 128)
check(lowest["lowest"][0]["misfit"] >= found["best"]["misfit"], "no point of a map is lower than the fit")
laws = {law["law"]: law for law in results("compare", study, "--layer", "base", "--laws", "linear,k-theta", "--explore", 24, "--verify", 2)["laws"]}
check(abs(laws["linear"]["chi2"] - found["noise"]["chi2"]) < 0.1, f"compare fits as fit does: {laws['linear']['chi2']}, {found['noise']['chi2']}")
check("k-theta" in laws and laws["linear"]["aicc"] < laws["k-theta"]["aicc"] + 2, f"a linear base is not taken for another: {laws}")
curves = results("sensitivity", study, "--samples", 16)
check(len(curves["responses"]) == 105, f"sensitivity of every reading: {len(curves['responses'])}")
page = run("report", study.parent / "fit")
check(page.returncode == 0 and "time_ms" in (study.parent / "fit" / "report.html").read_text(), f"the page: {page.stderr}")

# The effect is known to the judge alone.
hidden = made("hidden", 2002, "damping")
told = results("diagnose", folder / "hidden" / "study.toml", "--explore", 32, "--starts", 2, "--bootstrap", 10)
check(told["causes"] == ["damping"], f"damping in histories: {told['verdict']} {told['causes']}")
own = next(c for c in told["candidates"] if c["effect"] == "damping")
check(abs(own["size"] - hidden["size"]) < 1.5 * (own["size_high"] - own["size_low"]), f"its size {own['size']} ({own['size_low']} to {own['size_high']}), not {hidden['size']}")
finish()
