"""Ways in and out: a study at other values, lists of parameter sets, searches that begin where something is known, two studies side by side."""
import csv
import json
import math

import pytest
from support import LAYERED, LAYERED_BOWL, run, workspace, write_study


def layered(folder, more=""):
    return write_study(folder, LAYERED + more, LAYERED_BOWL)


SUBGRADE = """
[[parameters]]
name = "subgrade.modulus_MPa"
min = 20
max = 300
scale = "log"
"""


def values(done):
    assert done.returncode == 0, done.stderr
    return [r["value"] for r in json.loads(done.stdout)["responses"]]


def test_forward_at_another_value_is_that_of_a_study_with_this_value():
    folder = workspace()
    study = layered(folder)
    other = folder / "other.toml"
    text = study.read_text()
    assert text.count("modulus_MPa = 450") == 1
    other.write_text(text.replace("modulus_MPa = 450", "modulus_MPa = 600"))
    assert values(run("forward", study, "--set", "base.modulus_MPa=600", "--json")) == values(run("forward", other, "--json"))
    # What is not sought can be set, too: half the pressure is half of every deflection of linear layers.
    pressure = float(text.split("pressure_kPa = ")[1].split()[0])
    halved = values(run("forward", study, "--set", f"fwd.pressure_kPa={pressure / 2}", "--json"))
    for half, whole in zip(halved, values(run("forward", study, "--json"))):
        assert half == pytest.approx(whole / 2, rel=1e-9)
    said = run("forward", study, "--set", "base.modulus_MPa=600")
    assert "At base.modulus_MPa = 600" in said.stdout, said.stdout


def test_forward_with_a_wrong_value_says_what_is_allowed():
    folder = workspace()
    study = layered(folder, '\n[[parameters]]\nname = "subgrade.modulus_MPa"\nequals = "0.2 * base.modulus_MPa"\n')
    for text, *wanted in (("base.modulus_MPa", "NAME=VALUE"), ("base.modulus_MPa=soft", "not a number"), ("base.moduls_MPa=3", "base.modulus_MPa"),
                          ("base.modulus_MPa=-3", "out of range", "base.modulus_MPa"), ("subgrade.modulus_MPa=60", "follows others", "base.modulus_MPa")):
        done = run("forward", study, "--set", text)
        assert done.returncode == 2 and all(w in done.stderr for w in ("--set", *wanted)), (text, done.stderr)
    done = run("forward", study, "--set", "base.modulus_MPa=500", "--set", "base.modulus_MPa=600")
    assert done.returncode == 2 and "twice" in done.stderr, done.stderr


def table(text):
    return list(csv.DictReader(line for line in text.splitlines() if not line.startswith("#")))


def test_a_list_of_points_gives_a_line_each_like_single_runs():
    folder = workspace()
    study = layered(folder)
    sets = [(300, 707), (450, 707), (900, 500)]
    points = folder / "points.csv"
    points.write_text("base.modulus_MPa;fwd.pressure_kPa\n" + "".join(f"{m};{p}\n" for m, p in sets))  # as a spreadsheet saves it
    done = run("forward", study, "--points", points)
    assert done.returncode == 0, done.stderr
    rows = table(done.stdout)
    assert len(rows) == 3 and all(row["status"] == "converged" for row in rows)
    told = json.loads(run("forward", study, "--points", points, "--json").stdout)["points"]
    for (modulus, pressure), row, point in zip(sets, rows, told):
        single = json.loads(run("forward", study, "--set", f"base.modulus_MPa={modulus}", "--set", f"fwd.pressure_kPa={pressure}", "--json").stdout)["responses"]
        assert float(row["base.modulus_MPa"]) == modulus and point["parameters"] == {"base.modulus_MPa": modulus, "fwd.pressure_kPa": pressure}
        assert [r["value"] for r in point["responses"]] == pytest.approx([r["value"] for r in single], rel=1e-12)
        columns = [c for c in row if "@" in c]
        assert len(columns) == len(single) and [float(row[c]) for c in columns] == pytest.approx([r["value"] for r in single], rel=1e-12)


def test_a_point_without_an_answer_is_a_line_with_its_reason():
    folder = workspace()
    study = layered(folder)
    (folder / "points.csv").write_text("base.modulus_MPa\n450\n-1\n")
    done = run("forward", study, "--points", folder / "points.csv")
    rows = table(done.stdout)
    assert done.returncode == 0 and [row["status"] for row in rows] == ["converged", "invalid-parameters"] and "out of its range" in rows[1]["reason"], done.stdout
    (folder / "points.csv").write_text("base.modulus_MPa\n-2\n")
    assert run("forward", study, "--points", folder / "points.csv").returncode == 1


def test_what_export_and_sample_write_are_lists_of_points():
    folder = workspace()
    study = layered(folder, SUBGRADE)
    assert run("sample", study, "--samples", 400, "--out", folder / "run").returncode in (0, 1)
    (folder / "exported.csv").write_text(run("export", folder / "run").stdout)
    assert run("forward", study, "--points", folder / "exported.csv").stdout.count("converged") > 100
    draws = (folder / "run" / "samples.csv").read_text().count("\n") - 1
    assert len(table(run("forward", study, "--points", folder / "run" / "samples.csv").stdout)) == draws


def test_a_wrong_list_is_refused_with_line_and_column():
    folder = workspace()
    study = layered(folder)
    points = folder / "points.csv"
    for text, *wanted in (("base.modulus\n450\n", "did you mean", "base.modulus_MPa"), ("base.modulus_MPa\n", "no points"), ("base.modulus_MPa\n45O\n", "not a number", ":2"),
                          ("base.modulus_MPa,base.modulus_MPa\n1,2\n", "twice"), ("base.modulus_MPa,fwd.pressure_kPa\n1\n", "wrong number of cells")):
        points.write_text(text)
        done = run("forward", study, "--points", points)
        assert done.returncode == 2 and all(w in done.stderr for w in wanted), (text, done.stderr)


def test_fit_begins_a_search_at_a_start_that_is_given():
    folder = workspace()
    study = layered(folder, SUBGRADE)
    told = json.loads(run("fit", study, "--explore", 4, "--starts", 1, "--start", "base.modulus_MPa=451,subgrade.modulus_MPa=69.5", "--joint-only", "--out", folder / "run", "--json").stdout)
    assert told["starts"] == 2, told["starts"]
    exported = table(run("export", folder / "run", "--command", "fit").stdout)
    begun = [(float(row["base.modulus_MPa"]), float(row["subgrade.modulus_MPa"])) for row in exported if row["phase"] == "search"]
    assert any(abs(a - 451) < 1e-6 and abs(b - 69.5) < 1e-6 for a, b in begun), begun
    for text, *wanted in (("base.modulus_MPa=5", "within the bounds", "100"), ("base.k1=5", "base.modulus_MPa"), ("base.modulus_MPa", "NAME=VALUE")):
        done = run("fit", study, "--start", text)
        assert done.returncode == 2 and all(w in done.stderr for w in ("--start", *wanted)), (text, done.stderr)


def test_fit_begins_where_an_earlier_run_was_lowest():
    folder = workspace()
    study = layered(folder, SUBGRADE)
    first = json.loads(run("fit", study, "--explore", 64, "--starts", 3, "--joint-only", "--out", folder / "first", "--json").stdout)
    best = first["best"]["parameters"]
    for source in (folder / "first", folder / "list.csv"):
        (folder / "list.csv").write_text("base.modulus_MPa,subgrade.modulus_MPa\n{},{}\n".format(*best.values()))
        again = json.loads(run("fit", study, "--explore", 2, "--starts", 1, "--from", source, "--joint-only", "--out", folder / source.stem / "again", "--json").stdout)
        assert again["best"]["misfit"] == pytest.approx(first["best"]["misfit"], abs=1e-6)
        assert again["starts"] == 2
    (folder / "list.csv").write_text("base.modulus_MPa\n5\n")
    done = run("fit", study, "--from", folder / "list.csv")
    assert done.returncode == 2 and "bounds" in done.stderr, done.stderr


def test_two_studies_of_the_same_readings_are_compared():
    folder = workspace()
    known = layered(folder)
    # The same with a stiffer subgrade, held: it cannot fit.
    wrong = folder / "wrong.toml"
    wrong.write_text(known.read_text().replace("modulus_MPa = 70", "modulus_MPa = 90"))
    assert wrong.read_text() != known.read_text()
    done = run("compare", known, wrong, "--explore", 16, "--verify", 2, "--out", folder / "run", "--json")
    assert done.returncode == 0, done.stderr
    told = json.loads(done.stdout)
    studies = {s["study"]: s for s in told["studies"]}
    assert list(studies) == [str(known), str(wrong)] and told["same_noise"]
    # chi2 of each by its own fit; AICc of one parameter where the noise is known: 2 more.
    for path in (known, wrong):
        fitted = json.loads(run("fit", path, "--explore", 16, "--starts", 2, "--joint-only", "--out", folder / path.stem, "--json").stdout)
        assert studies[str(path)]["chi2"] == pytest.approx(fitted["best"]["misfit"] ** 2, abs=1e-4)
    assert studies[str(known)]["aicc"] - studies[str(wrong)]["aicc"] == pytest.approx(studies[str(known)]["chi2"] - studies[str(wrong)]["chi2"], abs=1e-9)
    assert studies[str(known)]["aicc"] - studies[str(known)]["chi2"] == pytest.approx(2, abs=1e-9)
    assert studies[str(known)]["log_evidence"] > studies[str(wrong)]["log_evidence"] + 5
    assert "the data prefer" in told["findings"][0].lower()
    assert str(wrong) in run("compare", known, wrong, "--explore", 16, "--verify", 2, "--out", folder / "run").stdout


def test_the_evidence_of_a_study_is_the_integral_over_its_box():
    folder = workspace()
    study = layered(folder)
    narrow = folder / "narrow.toml"
    narrow.write_text(study.read_text().replace("min = 100\nmax = 1500", "min = 300\nmax = 675"))
    told = json.loads(run("compare", study, narrow, "--explore", 16, "--verify", 2, "--out", folder / "run", "--json").stdout)
    log = {s["study"]: s["log_evidence"] for s in told["studies"]}
    # One parameter, uniform in its logarithm, its posterior well inside both: the densities differ by the widths alone.
    assert log[str(narrow)] - log[str(study)] == pytest.approx(math.log(math.log(1500 / 100) / math.log(675 / 300)), abs=0.15)


def test_studies_of_other_readings_are_not_compared():
    folder = workspace()
    study = layered(folder)
    other = folder / "other"
    fewer = write_study(other, LAYERED, "\n".join(LAYERED_BOWL.splitlines()[:-1]) + "\n")
    moved = write_study(folder / "moved", LAYERED, LAYERED_BOWL.replace("fwd,deflection,600", "fwd,deflection,610"))
    for path in (fewer, moved):
        done = run("compare", study, path)
        assert done.returncode == 2 and "same readings" in done.stderr and "deflection" in done.stderr, done.stderr
    louder = write_study(folder / "louder", LAYERED, LAYERED_BOWL.replace(f",{0.01 * 0.5118775}\n", ",0.02\n"))
    told = json.loads(run("compare", study, louder, "--explore", 16, "--verify", 2, "--out", folder / "run", "--json").stdout)
    assert not told["same_noise"] and all(s["aicc"] is None for s in told["studies"]) and "different noise" in told["findings"][0]
