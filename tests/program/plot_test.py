"""Figures as files: of every kind of run that has some, in every format, with the numbers that they show; and the landscape over pairs."""
import csv
import math
import os
import re
import xml.etree.ElementTree

import pytest

from support import *

folder = workspace()
SIGMAS = [0.04, 20.0, 0.01, 0.00004]  # of the readings, in their units
lines = DATA.strip().splitlines()
data = "\n".join(lines[:2] + [line + str(sigma) for line, sigma in zip(lines[2:], SIGMAS)]) + "\n"
study = write_study(folder / "s", STUDY.replace('misfit = "log"', 'misfit = "weighted"'), data)


@pytest.fixture(scope="module")
def unique():
    done = run("unique", study, "--json", "--out", folder / "unique", "--explore", 16, "--verify", 4, "--landscape")
    assert done.returncode == 0, f"unique runs: {done.stderr}"
    return json.loads(done.stdout)


@pytest.fixture(scope="module")
def pair(unique):
    return unique["landscape"]["pairs"][0]


def test_a_landscape_is_the_full_models_chi2(unique, pair):
    assert {pair["x"], pair["y"]} == {"base.k1", "base.n"}, f"one pair of two parameters: {pair['x']}, {pair['y']}"
    assert len(pair["rise"]) == len(pair["y_values"]) and all(len(row) == len(pair["x_values"]) for row in pair["rise"]), "rows by columns"
    lowest = min(v for row in pair["rise"] for v in row if v is not None)
    assert -1e-6 < lowest < 25, f"the rise is above the minimum: {lowest}"
    # With two parameters nothing is left to fit: each node is the full model's own chi2 there, whoever asks for it.
    best = unique["minima"][0]["misfit"]
    low, high = {"base.k1": (500, 8000), "base.n": (0.1, 4.5)}[pair["x"]], {"base.k1": (500, 8000), "base.n": (0.1, 4.5)}[pair["y"]]
    assert math.isclose(pair["x_values"][0], low[0]) and math.isclose(pair["y_values"][-1], high[1]), "the grid reaches the bounds"
    i, j = len(pair["x_values"]) // 3, len(pair["y_values"]) // 3
    at = {pair["x"]: pair["x_values"][i], pair["y"]: pair["y_values"][j]}
    text = study.read_text().replace("k1 = 2000", f"k1 = {at['base.k1']!r}").replace("n = 0.5\n", f"n = {at['base.n']!r}\n")
    forward = json.loads(run("forward", write_study(folder / "node", text, data), "--json").stdout)
    compared = [r for r in forward["responses"] if "measured" in r]
    chi2 = sum(((r["value"] - r["measured"]) / sigma) ** 2 for r, sigma in zip(compared, SIGMAS))
    rise = pair["rise"][j][i]
    assert rise is None or abs(rise - (chi2 - best ** 2)) < 0.02 * max(rise, 1.0), f"a node is chi2 there: {rise} against {chi2 - best ** 2}"


@pytest.fixture(scope="module")
def runs():
    assert run("fit", study, "--out", folder / "fit", "--explore", 16, "--starts", 2).returncode == 0, "fit runs"
    assert run("map", study, "--out", folder / "map", "--design", "sobol", "--points", 20).returncode == 0, "map runs"

    assert run("compare", study, "--laws", "uzan,k-theta", "--explore", 8, "--verify", 2, "--out", folder / "compare").returncode == 0, "compare runs"
    assert run("sensitivity", study, "--samples", 4, "--out", folder / "sensitivity").returncode == 0, "sensitivity runs"
    # A diagnosis in numbers made up here: what `plot` draws of it.
    made_up = folder / "made-up"
    made_up.mkdir()
    (made_up / "diagnose.json").write_text(json.dumps({"causes": ["load-magnitude"], "candidates": [{"effect": "plate-rigidity", "on": "", "delta_chi2": None, "score_z": 1.5, "p_familywise": 0.9},
        {"effect": "load-magnitude", "on": "fwd", "delta_chi2": -9.0, "score_z": 3.0, "p_familywise": 0.001}], "corrections": [{"channel": "depth", "layer": "base", "unit": "mm", "at": [50, 150, 250],
        "values": [0.8, 1.0, 1.3], "low": [0.7, 0.5, 1.1], "high": [0.9, 2.0, 1.5], "seen": [True, False, True]}]}))

    # A posterior of two moduli, one with a prior; and a road, one station of which cannot be.
    two = write_study(folder / "two", LAYERED + """
[[parameters]]
name = "subgrade.modulus_MPa"
min = 20
max = 200
scale = "log"
prior = { mean = 60, sd = 0.5 }
""", LAYERED_BOWL)
    done = run("sample", two, "--json", "--samples", 400, "--out", folder / "sample")
    assert done.returncode == 0, f"sample runs: {done.stderr}"
    sampled = json.loads(done.stdout)
    assert run("sample", two, "--prior", "--samples", 400, "--out", folder / "prior").returncode == 0, "sample --prior runs"
    HEADER = "station,lane,chainage_m,drop,radius_mm,pressure_kPa,D0_um,D200_um,D300_um,D450_um,D600_um,D900_um"
    STATIONS = ["A,L,0,1,150,600,500,390,320,230,170,100", "B,L,100,1,150,600,700,500,400,260,180,110", "C,R,50,1,150,600,400,330,280,210,160,100",
                "D,R,150,1,150,600,500,300,200,250,100,50"]
    (folder / "road.csv").write_text("\n".join([HEADER, *STATIONS]) + "\n")
    section = STUDY[:STUDY.index("[data]")] + SURVEYED
    done = run("survey", folder / "road.csv", "--study", write_study(folder / "section", section, None), "--json", "--out", folder / "survey")
    assert done.returncode == 0, f"survey runs: {done.stderr}"
    surveyed = json.loads(done.stdout)
    return made_up, sampled, surveyed


FIGURES = {"sample": {"posterior", "predictive"}, "prior": {"prior-predictive"}, "survey": {"deflections", "back-calculation"}, "made-up": {"candidates", "corrections"}, "compare": {"fit"},
           "sensitivity": {"sensitivity"}, "unique": {"landscape", "profiles", "fit", "residuals"}, "fit": {"fit", "residuals"}, "map": {"landscape"}}
BEGINS = {"svg": b"<?xml", "pdf": b"%PDF", "png": b"\x89PNG"}


@pytest.fixture(scope="module")
def plotted(unique, runs):
    """{run: {format: {figure: file}}}"""
    files = {}
    for name in FIGURES:
        for form in BEGINS:
            done = run("plot", folder / name, "--format", form)
            assert done.returncode == 0, f"plot of {name} as {form}: {done.stderr}"
            files.setdefault(name, {})[form] = {f.stem: f for f in (folder / name / "figures").glob(f"*.{form}")}
    return files


@pytest.mark.parametrize("name, expected", FIGURES.items())
def test_every_run_has_its_figures_in_every_format(plotted, name, expected):
    for form, files in plotted[name].items():
        assert expected <= set(files), f"figures of {name}: {sorted(files)}"
        for file in files.values():
            assert file.read_bytes().startswith(BEGINS[form]) and file.stat().st_size > 2000, f"{file.name} is a picture"
            if form == "svg":
                xml.etree.ElementTree.parse(file)


@pytest.mark.usefixtures("plotted")
def test_the_readings_are_among_the_numbers(unique):
    tables = {f.name: list(csv.DictReader(f.open())) for f in (folder / "unique" / "figures" / "data").glob("*.csv")}
    assert tables and all(rows for rows in tables.values()), f"numbers beside them: {sorted(tables)}"
    measured = [float(r["value"]) for rows in tables.values() for r in rows if r.get("series") == "measured"]
    assert sorted(measured) == sorted(r["measured"] for r in unique["responses"] if "measured" in r), f"the readings are among them: {measured}"


@pytest.mark.usefixtures("plotted")
def test_a_diagnosis_as_it_is_drawn(runs):
    made_up, _, _ = runs
    effects = list(csv.DictReader((made_up / "figures" / "data" / "candidates.csv").open()))
    assert [(r["effect"], float(r["fall_of_chi2"]), r["named"]) for r in effects] == [("load-magnitude", 9.0, "yes"), ("plate-rigidity", 2.25, "no")], \
        f"falls of chi2, the largest first: {effects}"
    # The probability falls from 0.9 to 0.001 between the squares of the scores: 5 % by its logarithm.
    chance = 2.25 + (9 - 2.25) * math.log(0.9 / 0.05) / math.log(0.9 / 0.001)
    numbers = [float(n) for n in re.findall(r"(?<![\w.])\d+\.\d+(?![\w.])", (made_up / "figures" / "data" / "candidates.gnuplot").read_text())]
    assert any(abs(n - chance) < 1e-3 for n in numbers), f"what chance reaches, {chance}: {numbers}"
    corrected = list(csv.DictReader((made_up / "figures" / "data" / "corrections.csv").open()))
    assert [(float(r["at"]), float(r["factor"]), r["seen"]) for r in corrected] == [(50, 0.8, "yes"), (150, 1.0, "no"), (250, 1.3, "yes")], f"corrections: {corrected}"


def test_strains_over_the_depth_stand_in_their_layers():
    gauges = folder / "gauges.toml"
    assert run("new", gauges, "--linear", "--layers", "upper 253, lower 170, ground", "--gauges", "200,300,500").returncode == 0
    assert run("fit", gauges, "--explore", 16, "--starts", 1, "--out", folder / "gauges").returncode == 0
    assert run("plot", folder / "gauges", "fit").returncode == 0
    script = (folder / "gauges" / "figures" / "data" / "fit.gnuplot").read_text()
    assert all(name in script for name in ("upper", "lower", "ground")), "layers have their names"
    for border in (253, 423):
        assert len(re.findall(rf"^\s*[-\d.e]+ {border}$", script, re.M)) == 2, f"a line across at {border} mm: {script[-3000:]}"


@pytest.mark.usefixtures("plotted")
def test_a_sample_is_drawn_as_points():
    # 20 points: in each of the panels as many marks, and no cells.
    script = (folder / "map" / "figures" / "data" / "landscape.gnuplot").read_text()
    assert "nothing is known between them" in script and "lowest misfit computed in a cell" not in script


@pytest.mark.usefixtures("plotted")
def test_indices_are_those_of_the_result():
    indices = json.loads((folder / "sensitivity" / "sensitivity.json").read_text())["global"]["indices"]
    drawn = {(r["response"], r["parameter"], r["index"]): r["value"] for r in csv.DictReader((folder / "sensitivity" / "figures" / "data" / "sensitivity.csv").open())}
    assert all(drawn[(i["response"], n, "total")] == ("" if e["value"] is None else repr(e["value"])) or math.isclose(float(drawn[(i["response"], n, "total")]), e["value"])
               for i in indices for n, e in i["total"].items()), \
        f"indices: {drawn}"


@pytest.mark.usefixtures("plotted")
def test_every_law_is_drawn():
    laws = {r["series"] for r in csv.DictReader((folder / "compare" / "figures" / "data" / "fit.csv").open())}
    assert {"measured", "uzan", "k-theta"} <= laws, f"every law is drawn: {laws}"


def numbers(run_folder, table):
    return list(csv.DictReader((folder / run_folder / "figures" / "data" / f"{table}.csv").open()))


@pytest.mark.usefixtures("plotted")
def test_the_border_holds_most_of_the_draws(runs):
    _, sampled, _ = runs
    # The border over the pair is closed, holds most of the draws, and is the one of the result.
    border = [(float(r["x"]), float(r["y"])) for r in numbers("sample", "posterior-regions") if r["border"] == "1"]
    assert border and border[0] == border[-1] and [list(q) for q in border] == sampled["regions"][0]["borders"][0], f"the border: {border[:3]}"
    inside = 0
    for _, x, y in sampled["draws"]:
        crossed = sum((a[1] > y) != (b[1] > y) and x < a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0]) for a, b in zip(border, border[1:]))
        inside += crossed % 2
    assert 0.9 <= inside / len(sampled["draws"]) <= 1, f"draws inside the border: {inside} of {len(sampled['draws'])}"
    ranges = {r["name"]: r for r in numbers("sample", "posterior")}
    assert (ranges["subgrade.modulus_MPa"]["prior_mean"], ranges["base.modulus_MPa"]["prior_mean"]) == ("60", ""), f"priors: {ranges}"
    assert len(numbers("sample", "posterior-draws")) == len(sampled["draws"]), "every draw of the result"


@pytest.mark.usefixtures("plotted")
def test_predicted_readings_are_those_of_the_results(runs):
    for run_folder, table, of in (("sample", "predictive", runs[1]["predictive"]), ("prior", "prior-predictive", json.loads((folder / "prior" / "sample-prior.json").read_text()))):
        drawn = numbers(run_folder, table)
        assert len(drawn) == len(of["readings"]) > 0, drawn
        for row, reading in zip(drawn, of["readings"]):
            assert all(float(row[key]) == reading[key] for key in ("measured", "low", "median", "high", "pit")), (row, reading)
    # A prior is wider than what it leaves with readings.
    width = {t: sum(float(r["high"]) - float(r["low"]) for r in numbers(f, t)) for f, t in (("sample", "predictive"), ("prior", "prior-predictive"))}
    assert width["prior-predictive"] > 3 * width["predictive"], width


@pytest.mark.usefixtures("plotted")
def test_a_road_in_numbers(runs):
    _, _, surveyed = runs
    d0 = {r["station"]: float(r["value"]) for r in numbers("survey", "deflections") if r["quantity"] == "D0_um_at_common_pressure"}
    assert d0 == {"A": 500, "B": 700, "C": 400}, f"D0 along the road: {d0}"
    assert [(r["station"], r["kind"]) for r in numbers("survey", "warnings") if r["kind"] not in ("remark", "doubtful")] == [("D", "rejected")], \
        "a bowl that rises outwards is a warning"
    fitted = {(r["station"], r["quantity"]): r for r in numbers("survey", "back-calculation")}
    for s in surveyed["stations"]:
        for name, p in s["parameters"].items():
            row = fitted[s["station"], name]
            assert [float(row[k]) for k in ("value", "low", "high")] == [p["value"], p["low"], p["high"]] and row["determined"] == ("yes" if p["determined"] else "no"), \
                f"{s['station']} {name}: {row}"


def test_a_weak_station_has_a_colour_of_its_own():
    bowls = ["500,390,320,230,170,100", "510,398,326,233,172,101", "490,383,314,226,168,99", "900,700,560,400,290,160", "505,394,322,231,171,100", "495,387,318,229,169,99"]
    header = "station,chainage_m,drop,radius_mm,pressure_kPa,D0_um,D200_um,D300_um,D450_um,D600_um,D900_um"
    (folder / "one-weak.csv").write_text("\n".join([header, *(f"S{i},{50 * i},1,150,600,{bowl}" for i, bowl in enumerate(bowls))]) + "\n")
    done = run("survey", folder / "one-weak.csv", "--json", "--out", folder / "one-weak")
    assert [(w["station"], round(w["times_median"], 1)) for w in json.loads(done.stdout)["weak_stations"]] == [(3, 1.8)], done.stderr
    assert run("plot", folder / "one-weak", "deflections").returncode == 0
    assert [(r["station"], r["kind"]) for r in numbers("one-weak", "warnings") if r["kind"] == "weak"] == [("S3", "weak")]
    script = (folder / "one-weak" / "figures" / "data" / "deflections.gnuplot").read_text()
    assert "'#D55E00'" in script and re.search(r"^150 900$", script, re.M), "its mark stands by itself"


def test_one_pair_and_its_surface(pair):
    i, j = len(pair["x_values"]) // 3, len(pair["y_values"]) // 3
    pair_folder = folder / "pair"
    for form in ("svg", "pdf", "png"):
        done = run("plot", folder / "unique", "--pair", "base.n,base.k1", "--out", pair_folder, "--format", form)
        assert done.returncode == 0 and {f.name for f in pair_folder.glob(f"*.{form}")} == {f"landscape-base.k1-base.n{kind}.{form}" for kind in ("", "-surface")}, \
            f"one pair: {done.stdout}{done.stderr}"
        assert all(f.stat().st_size > 10000 for f in pair_folder.glob(f"*-surface.{form}")), f"the surface is drawn as {form}"
    nodes = list(csv.DictReader((pair_folder / "data" / "landscape-base.k1-base.n-surface.csv").open()))
    assert len(nodes) == len(pair["x_values"]) * len(pair["y_values"]) and math.isclose(float(nodes[j * len(pair["x_values"]) + i]["rise_of_chi2"]), pair["rise"][j][i]), \
        "the nodes of the surface"
    done = run("plot", folder / "unique", "--pair", "base.n,base.k2")
    assert done.returncode == 2 and "base.n,base.k2" in done.stderr and "base.k1" in done.stderr, f"a pair that there is not: {done.stderr}"


@pytest.mark.usefixtures("unique")
def test_one_figure_elsewhere():
    one = folder / "one"
    assert run("plot", folder / "unique", "residuals", "--out", one).returncode == 0 and [f.name for f in one.glob("*.svg")] == ["residuals.svg"], \
        "one figure of one's choice, elsewhere"


@pytest.mark.usefixtures("unique")
def test_what_cannot_be_plotted_is_said():
    done = run("plot", folder / "unique", "bowl")
    assert done.returncode == 2 and done.stdout == "" and "bowl" in done.stderr and "landscape" in done.stderr, f"an unknown figure: {done.stderr}"
    done = run("plot", folder)
    assert done.returncode == 2 and done.stdout == "", f"a folder without a run: {done.stderr}"
    empty = folder / "empty"
    empty.mkdir()
    done = run("plot", folder / "unique", env={**os.environ, "PATH": str(empty)})
    assert done.returncode == 2 and "gnuplot-nox" in done.stderr, f"without gnuplot: {done.stderr}"
