"""pavescape unique as a user meets it: the promised keys, the same answer for any number of threads, nothing lost."""
import json

import pytest

from support import *

folder = workspace()
study = write_study(folder / "s", STUDY.replace('misfit = "log"', 'misfit = "log"\nnoise_relative = 0.05'))
options = ["--explore", 16, "--verify", 4]


@pytest.fixture(scope="module")
def one():
    done = run("unique", study, "--json", "--out", folder / "one", "--threads", 1, *options)
    assert done.returncode == 0, f"unique runs: {done.stderr}"
    return without_run(json.loads(done.stdout))


def test_the_result_has_what_is_promised(one):
    assert one["verdict"] in ("unique", "non-unique", "undecided"), "the verdict is one of three"
    for key in ("directions", "minima", "outputs", "unseen_volume_bound", "profiles", "spectrum", "unseen", "merge_tree",
                "projections", "next_measurement", "passes", "traces", "ends", "findings"):
        assert key in one, f"the result has {key}"
    for output in one["outputs"]:
        assert output["low"] <= output["best"] <= output["high"], f"{output['name']}: the best lies in its range"
    for profile in one["profiles"]:
        first = profile["first_order"]
        assert first["low"] <= profile["best"] <= first["high"], f"{profile['name']}: the first-order range holds the best value: {first}"
        assert profile["low"] <= profile["best"] <= profile["high"], f"{profile['name']}: the best lies in its range"
        assert profile["kind"] in ("bounded", "bounded on one side", "flat", "incomplete"), "a profile is classified"
    assert abs(one["unseen_volume_bound"] - (1 - 0.05 ** (1 / 4))) < 1e-12, "four starts that find nothing new: 1 - 0.05^(1/4)"
    assert all(e["end"] in ("interior minimum", "minimum on a bound", "valley", "unfinished") for e in one["ends"]), "every search is classified"


def test_two_threads_give_the_same_answer(one):
    two = json.loads(run("unique", study, "--json", "--out", folder / "two", "--threads", 2, *options).stdout)
    assert one == without_run(two), "one thread and two give the same answer"


def test_a_killed_run_continues_with_the_same_answer(one):
    # Killed half way and continued.
    total = evaluations(folder / "one")
    before = kill_at(total // 2, folder / "cut", "unique", study, "--json", *options)
    cut = json.loads(run("unique", study, "--json", "--out", folder / "cut", *options).stdout)
    assert without_run(cut) == one, "a run that was killed and continued ends with the same answer"
    assert 0 < before and evaluations(folder / "cut") == total, "and repeats nothing that was finished"


def test_one_reading_for_two_parameters_is_undecided():
    # One reading, two parameters and no stated noise: nothing can be said of errors, and it is said what is missing.
    bare = write_study(folder / "bare", data="load,quantity,x_mm,y_mm,depth_mm,gauge_mm,value,unit,sigma\nfwd,deflection,0,0,0,0,0.95,mm,\n")
    undecided = json.loads(run("unique", bare, "--json", "--out", folder / "b", *options).stdout)
    assert undecided["verdict"] == "undecided" and "noise" in undecided["missing"][0], "without noise or data left over: undecided"


@pytest.mark.usefixtures("one")
def test_a_person_gets_tables():
    text = run("unique", study, "--verbose", "--out", folder / "one", "--threads", 1, *options).stdout
    assert "What the data accept" in text and "Most informative further readings" in text, "a person gets tables"


def test_a_missing_study_ends_with_status_2():
    assert run("unique", folder / "none.toml").returncode == 2, "a missing study: exit status 2"
