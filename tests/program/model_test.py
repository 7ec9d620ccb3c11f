"""The reduced model in use: what it maps is what the full model maps, it says what it is, and it is built again where it no longer fits."""
import csv
import io
import math

import pytest

from support import *

folder = workspace()
study = write_study(folder)


def table(out):
    rows = csv.DictReader(line for line in io.StringIO(run("export", out, "--command", "map").stdout) if not line.startswith("#"))
    return [float(row["misfit"]) if row["misfit"] else None for row in rows]


def mapped(out, *options, source=study):
    done = run("map", source, "--design", "sobol", "--points", 300, "--json", "--out", out, *options)
    assert done.returncode == 0, f"map {options}: {done.stderr}"
    return json.loads(done.stdout)


@pytest.fixture(scope="module")
def maps():
    full = mapped(folder / "full")
    reduced = mapped(folder / "reduced", "--model", "reduced")
    auto = mapped(folder / "auto", "--model", "auto")
    return full, reduced, auto


def test_the_reduced_model_maps_what_the_full_one_maps(maps):
    full, reduced, auto = maps
    assert full["model"] == "full" and reduced["model"] == "reduced" and auto["model"] == "auto", "the result says which model"
    pairs = list(zip(table(folder / "full"), table(folder / "reduced"), strict=True))
    assert all((a is None) == (b is None) for a, b in pairs), "points without an answer are the same"
    errors = sorted(abs(a - b) / a for a, b in pairs if a is not None)
    print(f"{len(errors)} misfits: median error {100 * errors[len(errors) // 2]:.2f} %, 95 % below {100 * errors[len(errors) * 95 // 100]:.2f} %")
    assert len(errors) > 100 and errors[len(errors) * 95 // 100] < 0.03, "95 of 100 misfits within 3 %"
    assert errors[-1] > 0.0, "they are not the full model's"


def test_what_auto_reports_is_the_full_models(maps):
    full, _, auto = maps
    truth = [entry["number"] for entry in full["lowest"]]
    all_full = table(folder / "full")
    for entry in auto["lowest"]:
        assert math.isclose(entry["misfit"], all_full[entry["number"]], rel_tol=1e-12), "auto reports misfits of the full model"
        assert entry["misfit_of_reduced_model"] != entry["misfit"], "and those of the reduced one beside them"
    assert auto["lowest"][0]["number"] in truth, "the lowest point is among the lowest of the full model"


def test_the_model_is_built_once_and_again_where_it_no_longer_fits(maps):
    _, reduced, _ = maps
    # Built once, kept, built again where it is damaged or of another study.
    assert reduced["reduced_model"]["built"] and reduced["reduced_model"]["loads"][0]["full_runs"] < 300, "built from fewer than 300 runs"
    again = mapped(folder / "reduced", "--model", "reduced")
    assert not again["reduced_model"]["built"] and again["kept"] == 300, "neither model nor map is made twice"
    kept = folder / "reduced" / "reduced.bin"
    before = kept.read_bytes()
    kept.write_bytes(before[:1000] + bytes([before[1000] ^ 1]) + before[1001:])
    again = mapped(folder / "reduced", "--model", "reduced")
    assert again["reduced_model"]["built"] and kept.read_bytes() == before, "a damaged one is built again, bit for bit"
    again = mapped(folder / "reduced", "--model", "reduced", "--threads", 1)
    assert not again["reduced_model"]["built"], "whatever the number of threads"
    first = table(folder / "reduced")
    for store in (folder / "reduced").glob("run.sqlite*"):
        store.unlink()
    again = mapped(folder / "reduced", "--model", "reduced")
    assert not again["reduced_model"]["built"] and again["kept"] == 0, "the model is kept beside the run"
    assert table(folder / "reduced") == first, "and answers as when it was built, bit for bit"
    other = write_study(folder, STUDY.replace("thickness_mm = 250", "thickness_mm = 300"), name="other")
    again = mapped(folder / "reduced", "--model", "reduced", source=other)
    assert again["reduced_model"]["built"], "that of another section is not used"


@pytest.mark.usefixtures("maps")
def test_where_the_estimate_is_above_the_limit_the_full_model_runs():
    strict = mapped(folder / "strict", "--model", "reduced", "--model-error", 0.01)
    assert strict["by_full_model"] == strict["statuses"]["converged"], "no estimate is below a hundredth of a percent"
    pairs = list(zip(table(folder / "strict"), table(folder / "full"), strict=True))
    # By one run at a time and by several side by side, which round in another order.
    assert all(a == b if a is None or b is None else math.isclose(a, b, rel_tol=1e-9) for a, b in pairs), "then all is the full model's"


def test_a_fit_explored_by_the_reduced_model_ends_where_the_full_one_does():
    # A fit that the reduced model explores ends where that of the full model ends; one of the reduced model alone near it, and says so.
    fits = {}
    for model in ("full", "auto", "reduced"):
        done = run("fit", study, "--explore", 64, "--starts", 4, "--joint-only", "--model", model, "--out", folder / f"fit-{model}")
        assert done.returncode == 0, f"fit --model {model}: {done.stderr}"
        fits[model] = json.loads((folder / f"fit-{model}" / "fit.json").read_text())
        assert ("By the reduced model alone" in " ".join(done.stdout.split())) == (model == "reduced"), "what is of the reduced model alone says so"
    best = {model: fit["best"]["misfit"] for model, fit in fits.items()}
    assert math.isclose(best["auto"], best["full"], rel_tol=1e-6), f"auto: {best}"
    assert math.isclose(best["reduced"], best["full"], rel_tol=0.05) and best["reduced"] != best["full"], f"reduced: {best}"


def test_uniqueness_explored_by_the_reduced_model_is_the_full_models():
    # Whether the answer is unique: explored by the reduced model, everything that is said is the full model's.
    unique = {}
    for model in ("full", "auto", "reduced"):
        done = run("unique", study, "--explore", 64, "--verify", 8, "--model", model, "--out", folder / f"unique-{model}")
        assert done.returncode == 0, f"unique --model {model}: {done.stderr}"
        unique[model] = json.loads((folder / f"unique-{model}" / "unique.json").read_text())
        assert ("By the reduced model alone" in " ".join(done.stdout.split())) == (model == "reduced"), "what is of the reduced model alone says so"
    accepted = {model: [m for m in u["minima"] if m["accepted"]] for model, u in unique.items()}
    assert unique["auto"]["verdict"] == unique["full"]["verdict"] and len(accepted["auto"]) == len(accepted["full"]), "the same verdict"
    for a, b in zip(accepted["auto"], accepted["full"]):
        assert math.isclose(a["misfit"], b["misfit"], rel_tol=1e-5), f"the same minima: {a} {b}"
    for a, b in zip(unique["auto"]["profiles"] + unique["auto"]["outputs"], unique["full"]["profiles"] + unique["full"]["outputs"]):
        assert math.isclose(a["low"], b["low"], rel_tol=1e-3) and math.isclose(a["high"], b["high"], rel_tol=1e-3), f"the same ranges: {a['name']}"
    assert not unique["reduced"]["outputs"] and unique["full"]["outputs"], "ranges of outputs are the full model's alone"
    before = (folder / "unique-auto" / "unique.json").read_text()
    again = run("unique", study, "--explore", 64, "--verify", 8, "--model", "auto", "--verbose", "--out", folder / "unique-auto")
    assert (folder / "unique-auto" / "unique.json").read_text() == before, "from what is kept the same result"
    assert "; 0 runs computed" in " ".join(again.stdout.split()) and "0 runs more" not in again.stderr, f"nothing is computed twice: {again.stdout[:600]}"


def test_a_diagnosis_has_the_same_baseline_by_either_model():
    # A diagnosis: its baseline is explored by the reduced model.
    verdicts = {}
    for model in ("full", "auto"):
        done = run("diagnose", study, "--explore", 32, "--starts", 3, "--bootstrap", 5, "--model", model, "--out", folder / f"diagnose-{model}")
        assert done.returncode == 0, f"diagnose --model {model}: {done.stderr}"
        verdicts[model] = json.loads((folder / f"diagnose-{model}" / "diagnose.json").read_text())
    assert verdicts["auto"]["verdict"] == verdicts["full"]["verdict"], "the same verdict"
    assert math.isclose(verdicts["auto"]["baseline"]["misfit"], verdicts["full"]["baseline"]["misfit"], rel_tol=1e-5), "the same baseline"
    assert verdicts["auto"]["model"] == "auto", "the result says which model"
    refused = run("diagnose", study, "--model", "reduced", "--out", folder / "none")
    assert refused.returncode == 2 and "auto" in refused.stderr, "effects need the full model"


def test_an_adaptive_map_has_its_points_and_says_its_share():
    # An adaptive map by either model: all its points, and what of the box it knows.
    for model in ("full", "auto"):
        done = run("map", study, "--design", "adaptive", "--points", 200, "--model", model, "--json", "--out", folder / f"adaptive-{model}")
        assert done.returncode == 0, f"adaptive --model {model}: {done.stderr}"
        adaptive = json.loads(done.stdout)
        assert adaptive["points"] == 200 and len(table(folder / f"adaptive-{model}")) == 200, "an adaptive map has the points requested"
        assert adaptive["explored"]["checks"] == 20 and 0 <= adaptive["explored"]["share_low"] <= adaptive["explored"]["share_high"] <= 1, "and its share"
        again = json.loads(run("map", study, "--design", "adaptive", "--points", 200, "--model", model, "--json", "--out", folder / f"adaptive-{model}").stdout)
        assert again["computed"] == 0 and again["kept"] == 200 and again["explored"] == adaptive["explored"], "it is made once"

    few = run("map", study, "--design", "adaptive", "--points", 20, "--out", folder / "few")
    assert few.returncode == 2 and "at least 50" in few.stderr and not (folder / "few").exists(), f"too few points: {few.stderr}"


def test_what_has_no_reduced_model_is_refused():
    for change, word in ((("name = \"base.n\"\nmin = 0.1\nmax = 4.5", "name = \"base.thickness_mm\"\nmin = 200\nmax = 300"), "thickness"),
                         (("[mesh]", "[solver]\nintegration = \"secant\"\n\n[mesh]"), "secant")):
        refused = run("map", write_study(folder, STUDY.replace(*change), name=word), "--model", "reduced", "--out", folder / word)
        assert refused.returncode == 2 and word in refused.stderr and len(refused.stderr.strip().splitlines()) == 1, f"{word}: {refused.stderr}"
        assert not (folder / word).exists(), f"{word}: nothing is written"
