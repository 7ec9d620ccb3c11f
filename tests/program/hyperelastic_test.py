"""The law that gives strain back, as a user meets it: forward, derivatives, compare, a pulse beside one of uzan, no reduced model."""
import json
import math

from support import *

folder = workspace()
UZAN = 'law = "uzan"\nk1 = 2000\nk2 = 0.5\nk3 = -0.3\n'
HYPERELASTIC = 'law = "hyperelastic"\nk1 = 1300\nk = 0.5\n'
BASE = STUDY.replace(UZAN, HYPERELASTIC)
assert BASE != STUDY


def answer(*arguments):
    done = run(*arguments, "--json")
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_a_run_has_no_load_path_and_derivatives_that_its_values_have():
    study = write_study(folder / "forward", BASE)
    here = answer("forward", study, "--jacobian")
    assert here["status"] == "converged" and here["newton_steps"] > 0 and here["residual_relative"] < 1e-9
    high, low = (answer("forward", write_study(folder / f"moved{sign:+d}", BASE.replace("k1 = 1300", f"k1 = {1300 + sign * 0.13!r}"))) for sign in (1, -1))
    column = here["jacobian"]["parameters"].index("base.k1")
    for i, row in enumerate(here["jacobian"]["rows"]):
        difference = (high["responses"][i]["value"] - low["responses"][i]["value"]) / 0.26
        assert math.isclose(row[column], difference, rel_tol=1e-5), (i, row[column], difference)


def test_its_way_of_integration_makes_no_difference():
    values = [[r["value"] for r in answer("forward", write_study(folder / way, BASE.replace("[mesh]", f'[solver]\nintegration = "{way}"\n\n[mesh]')))["responses"]]
              for way in ("incremental", "secant")]
    assert values[0] == values[1]


def test_an_exponent_out_of_range_is_refused():
    done = run("forward", write_study(folder / "wrong", BASE.replace("k = 0.5", "k = 1.0")))
    assert done.returncode == 2 and "k" in done.stderr and "0.99" in done.stderr, done.stderr


def test_compare_tries_it_beside_the_others():
    found = answer("compare", write_study(folder / "compared", STUDY), "--laws", "uzan,hyperelastic", "--explore", 8, "--verify", 1, "--out", folder / "compare")
    laws = {law["law"]: law for law in found["laws"]}
    assert set(laws) == {"uzan", "hyperelastic"} and laws["hyperelastic"]["status"] == "converged"
    assert set(laws["hyperelastic"]["parameters"]) == {"base.k1", "base.k", "base.n"}


def test_there_is_no_reduced_model_and_it_says_why():
    for model in ("reduced", "auto"):
        done = run("map", write_study(folder / "map", BASE), "--model", model, "--out", folder / model)
        assert done.returncode == 2 and "no load path" in done.stderr and "--model full" in done.stderr, done.stderr


def test_a_pulse_leaves_nothing_behind_and_the_warning_of_another_law_names_this_one():
    rows = "time_ms,force_kN\n" + "".join(f"{t},{45 * math.sin(math.pi * t / 24) ** 2:.6f}\n" for t in range(25)) + "500,0\n"
    outputs = "".join(f'\n[[outputs]]\nname = "{name}"\nload = "fwd"\nquantity = "{quantity}"\ndepth_mm = {depth}\n{time}'
                      for quantity, depth in (("deflection", 0), ("strain_zz", 150)) for name, time in ((f"{quantity}-largest", ""), (f"{quantity}-end", "time_ms = 500\n")))
    found = {}
    for name, text in (("uzan", STUDY), ("hyperelastic", BASE)):
        text = text[:text.index("[data]")].replace("pressure_kPa = 600", 'history = "force.csv"').replace("k0 = 0.5", "k0 = 0.5\ndamping_time_ms = 5") + "[solver]\ntime_step_ms = 0.5\n" + outputs
        study = write_study(folder / f"pulse-{name}", text)
        (folder / f"pulse-{name}" / "force.csv").write_text(rows)
        found[name] = answer("forward", study)
    for quantity in ("deflection", "strain_zz"):
        value = {r["name"]: r["value"] for r in found["hyperelastic"]["responses"]}
        assert abs(value[f"{quantity}-end"]) < 1e-3 * abs(value[f"{quantity}-largest"]), value
    assert not any("after the pulse" in warning for warning in found["hyperelastic"]["warnings"]), found["hyperelastic"]["warnings"]
    assert any('"hyperelastic"' in warning for warning in found["uzan"]["warnings"]), found["uzan"]["warnings"]
