"""A road whose material is known and the same everywhere: it comes back together where no station knows it alone, a station
with a wrong sensor is named, and neither threads nor a kill change a bit."""
import csv
import io
import math
import random

import pytest

from support import *

folder = workspace()
OFFSETS = (0, 200, 300, 450, 600, 900, 1200)
PRESSURES = (400, 560, 750)
STATIONS = 12
OUTLIER = 5
K2, K3 = 0.5, -0.3  # of the section in support.py
REPEAT = 0.005
HEADER = "station,chainage_m,drop,radius_mm,pressure_kPa," + ",".join(f"D{o}_um" for o in OFFSETS)
SECTION = STUDY[:STUDY.index("[data]")].replace("thickness_mm = 40", "thickness_mm = 80")


def parameters(k2='level = "shared"', k3='level = "shared"'):
    return SECTION + f"""[data]
misfit = "weighted"

[[parameters]]
name = "base.k1"
min = 300
max = 12000
scale = "log"

[[parameters]]
name = "base.k2"
min = 0.05
max = 1.0
{k2}

[[parameters]]
name = "base.k3"
min = -1.5
max = 0.0
{k3}

[[parameters]]
name = "subgrade.modulus_MPa"
min = 15
max = 200
scale = "log"
"""


def bowls(k1, subgrade):
    """Deflections in um at every pressure, by the program's own forward run."""
    text = SECTION.replace("k1 = 2000", f"k1 = {k1}").replace("modulus_MPa = 45", f"modulus_MPa = {subgrade}")
    load = text[text.index("[[loads]]"):text.index("[mesh]")]
    text = text.replace(load, "".join(load.replace('"fwd"', f'"p{p}"').replace("= 600", f"= {p}") for p in PRESSURES))
    for p in PRESSURES:
        for o in OFFSETS:
            text += f'[[outputs]]\nname = "p{p}D{o}"\nload = "p{p}"\nquantity = "deflection"\nx_mm = {o}\n'
    done = run("forward", write_study(folder, text, None, "truth"), "--json")
    assert done.returncode == 0, f"forward: {done.stderr}"
    values = [1e3 * r["value"] for r in json.loads(done.stdout)["responses"]]
    return [values[i:i + len(OFFSETS)] for i in range(0, len(values), len(OFFSETS))]


@pytest.fixture(scope="module")
def made():
    # Noise as docs/guide/field.md says it: of every sensor 1 um and 1 % at a level, and of every drop its repeatability.
    chance = random.Random(4)
    truth, rows = [], []
    for s in range(STATIONS):
        truth.append({"base.k1": 2000 * 2 ** chance.uniform(-1, 1), "subgrade.modulus_MPa": 45 * 2 ** chance.uniform(-0.7, 0.7)})
        drop = 0
        for pressure, exact in zip(PRESSURES, bowls(*truth[-1].values())):
            sensors = [d + chance.gauss(0, (1 + (0.01 * d) ** 2) ** 0.5) for d in exact]
            sensors[3] *= 1.15 if s == OUTLIER else 1.0
            for _ in range(2):
                drop += 1
                rows.append([f"P{s:02}", 25 * s, drop, 150, pressure, *(f"{d * (1 + REPEAT * chance.gauss(0, 1)):.2f}" for d in sensors)])
    road = folder / "road.csv"
    road.write_text(HEADER + "\n" + "\n".join(",".join(map(str, row)) for row in rows) + "\n")
    study = write_study(folder, parameters(), None, "together")
    return truth, rows, road, study


@pytest.fixture(scope="module")
def fitted(made):
    _, _, road, study = made
    results = {}
    for threads in (1, 2):
        out = folder / f"threads-{threads}"
        done = run("road", road, "--study", study, "--threads", threads, "--out", out, "--json")
        assert done.returncode == 0 and done.stderr == "", f"road: {done.returncode} {done.stderr}"
        results[threads] = json.loads(done.stdout)
        assert json.loads((out / "road.json").read_text()) == results[threads], "the same in the folder of the run"
    assert lasting(results[1]) == lasting(results[2]), "one and two threads differ"
    tables = [(folder / f"threads-{threads}" / "road.csv").read_text() for threads in (1, 2)]
    assert tables[0] == tables[1], "the tables of one and two threads differ"
    r = results[1]

    # The material: near the truth, and known together where it is not alone.
    shared = {p["name"]: p for p in r["shared"]}
    return r, tables, shared


def test_the_material_is_near_the_truth_and_known_together(fitted):
    _, _, shared = fitted
    assert list(shared) == ["base.k2", "base.k3"], f"what is shared: {list(shared)}"
    for name, value in (("base.k2", K2), ("base.k3", K3)):
        p = shared[name]
        half = 1.5 * (p["high"] - p["low"]) / 2  # three standard deviations
        assert abs(p["value"] - value) < half, f"{name}: {p['value']} ({p['low']} to {p['high']}), made with {value}"
        assert p["low"] < p["value"] < p["high"], f"{name}: {p}"
        assert p["narrower"] >= 3 and p["width"] < p["median_width_alone"], f"{name}: {p['width']} together, {p['median_width_alone']} alone"
        assert p["stations"] == STATIONS - 1, f"{name} comes from all stations but the outlier: {p['stations']}"

    k2 = shared["base.k2"]
    assert k2["determined"] and k2["determined_alone"] == 0 and k2["median_width_alone"] >= 3 * k2["width"], f"k2 is unique together, and nowhere alone: {k2}"


def test_regions_of_pairs_reach_as_far_as_chi2_says(fitted):
    r, _, shared = fitted
    # The 95 % region of a pair of them reaches as far beyond each range as the quantiles of chi2 with two degrees of freedom and one do (5.991 and 3.841).
    assert len(r["landscape"]) == len(shared) * (len(shared) - 1) // 2, f"every pair has a region: {len(r['landscape'])}"
    for region in r["landscape"]:
        assert region["border"][0] == region["border"][-1], "the border is closed"
        reaches = []
        for side, name in enumerate((region["x"], region["y"])):
            scale = math.log if region[("log_x", "log_y")[side]] else float
            value, low, high = (scale(shared[name][key]) for key in ("value", "low", "high"))
            place = [scale(b[side]) for b in region["border"]]
            reaches += [(value - min(place)) / (value - low), (max(place) - value) / (high - value)]
        # The box cuts off what lies beyond k3 = 0.
        assert abs(max(reaches) / math.sqrt(5.991 / 3.841) - 1) < 5e-3, f"the region reaches {reaches} times the ranges"


def test_stations_hold_the_truth_about_as_often_as_they_say(made, fitted):
    truth, _, _, _ = made
    r, _, shared = fitted
    # Stations: their own parameters, within their ranges about as often as these say.
    within = []
    for s, station in enumerate(r["stations"]):
        assert station["station"] == f"P{s:02}" and station["status"] == "ok", f"{station['station']}: {station['status']}"
        for name, value in truth[s].items():
            p = station["parameters"][name]
            if s != OUTLIER:
                within.append(p["low"] <= value <= p["high"])
        for name in shared:
            p, alone = station["parameters"][name], station["road"]["alone"][name]
            if s == OUTLIER:  # what is common is not its own
                assert p == alone if alone["determined"] else not p["determined"], (name, p, alone)
            else:
                assert p["value"] == shared[name]["value"], f"{station['station']}: {name} is that of the road"
        assert len(station["levels"]) == len(PRESSURES), "all load levels are used"
    # Of 22 ranges of 95 % fewer than 17 hold the truth with p = 2e-4 (binomial; those of one station go together).
    assert sum(within) >= 17, f"{sum(within)} of {len(within)} ranges of stations hold the truth"
    good = [s["road"] for i, s in enumerate(r["stations"]) if i != OUTLIER]
    chi2, dof = sum(s["chi2"] for s in good), sum(s["degrees_of_freedom"] for s in good)
    assert abs(chi2 - r["chi2"]) < 1e-6 * chi2 and abs(dof - r["degrees_of_freedom"]) < 0.1, f"chi2 {chi2} {r['chi2']}, dof {dof} {r['degrees_of_freedom']}"
    unknowns = len(PRESSURES) * len(OFFSETS) * (STATIONS - 1) - 2 * (STATIONS - 1) - 2
    assert r["degrees_of_freedom"] == unknowns, f"readings less unknowns: {r['degrees_of_freedom']}, {unknowns}"
    assert r["noise_factor"] == 1.0 and 0.01 < r["p_value"], f"the made-up noise is what is assumed: p = {r['p_value']}"
    assert r["conflict"]["p_value"] > 0.01 and r["conflict"]["degrees_of_freedom"] == 2 * (STATIONS - 1) - 2, f"conflict: {r['conflict']}"
    assert all(s["chi2_alone"] <= s["chi2"] + 1e-6 for s in good), "alone a station fits no worse"


def test_there_is_no_course_where_none_is(made, fitted):
    truth, _, _, _ = made
    r, _, _ = fitted
    # The course of what stations have for themselves: drawn independently, so that neighbours tell little of each other.
    assert [c["name"] for c in r["courses"]] == list(truth[0]), f"courses: {[c['name'] for c in r['courses']]}"
    for c in r["courses"]:
        assert len(c["stations"]) == STATIONS - 1 and c["p_none"] > 0.001, f"{c['name']}: no course ({c['p_none']})"
        for s in c["stations"]:
            own = next(t for t in r["stations"] if t["station"] == s["station"])["parameters"][c["name"]]
            assert s["high"] / s["low"] < 1.001 * own["high"] / own["low"], f"{c['name']} at {s['station']}: no wider with its neighbours"


def test_the_station_with_a_wrong_sensor_is_named(fitted):
    r, _, _ = fitted
    assert [o["station"] for o in r["outliers"]] == [f"P{OUTLIER:02}"], f"outliers: {r['outliers']}"
    assert r["outliers"][0]["cause"] == "sensor" and "450 mm" in r["outliers"][0]["reason"], f"its cause: {r['outliers'][0]}"
    assert r["outliers"][0]["p_familywise"] < 0.05, "by the test"


def test_table_page_and_report(made, fitted):
    _, _, road, study = made
    r, tables, _ = fitted
    cells = list(csv.DictReader(io.StringIO(tables[0])))
    assert [c["station"] for c in cells] == [s["station"] for s in r["stations"]], "the table: one line a station"
    assert [c["outlier"] for c in cells].index("true") == OUTLIER, "the table: the outlier"
    for c, s in zip(cells, r["stations"]):
        assert c["base.k1"] == repr(s["parameters"]["base.k1"]["value"]), "the table: the bits of the JSON"
    done = run("road", road, "--study", study, "--verbose", "--out", folder / "threads-1")
    for words in ("as one experiment", "base.k2 = ", "unique together", "P05 does not belong", "0 runs", "do not contradict"):
        assert words in " ".join(done.stdout.split()), f"'{words}' in the page:\n{done.stdout}"
    assert run("report", folder / "threads-1", "--out", folder / "road.html").returncode == 0, "a report"
    assert "The road as one experiment" in (folder / "road.html").read_text(), "with a part for the road"


def test_a_killed_road_continues_with_the_same_bits(made, fitted):
    _, _, road, study = made
    r, _, _ = fitted
    # Killed and continued: the same, and nothing is computed twice.
    out = folder / "killed"
    total = counted(folder / "threads-1")[0]
    held = kill_at(total * 2 // 3, out, "road", road, "--study", study)
    assert held < total, "the kill came in time"
    done = run("road", road, "--study", study, "--out", out, "--json")
    assert lasting(json.loads(done.stdout)) == lasting(r), "the killed and continued road differs"


def test_the_withheld_level_is_predicted_within_its_noise(made):
    _, _, road, study = made
    # The highest level kept out of the fit: the model that made it predicts it within its noise.
    done = run("road", road, "--study", study, "--withhold", "750kPa", "--out", folder / "withheld", "--json")
    assert done.returncode == 0, f"withheld: {done.stderr}"
    w = json.loads(done.stdout)["withheld"]
    assert w["stations"] == STATIONS - 1 and w["readings"] == len(OFFSETS) * (STATIONS - 1), f"withheld: {w}"
    assert w["p_value"] > 0.01 and all(s["p_familywise"] > 0.01 for s in w["sensors"]), f"withheld: {w}"
    assert 0.7 < w["rms_percent"] / w["noise_percent"] < 1.4, f"withheld: as far off as noise is: {w}"
    assert all(len(s["levels"]) == 2 for s in json.loads(done.stdout)["stations"]), "withheld: the other levels are fitted"


def test_what_all_stations_lack(made):
    _, rows, _, study = made
    # What all stations lack: nothing here; then a sensor that reads 3 % too much everywhere.
    results = []
    for name, factor, threads in (("clean", 1.0, 1), ("scaled", 1.03, 1), ("scaled", 1.03, 2)):
        scaled = folder / f"{name}.csv"
        at = HEADER.split(",").index("D900_um")
        scaled.write_text("\n".join([HEADER, *(",".join(f"{float(cell) * factor:.2f}" if k == at else str(cell) for k, cell in enumerate(row)) for row in rows)]) + "\n")
        done = run("road", scaled, "--study", study, "--diagnose", "--threads", threads, "--out", folder / f"{name}-{threads}", "--json")
        assert done.returncode == 0, f"{name}: {done.stderr}"
        results.append(json.loads(done.stdout))
    clean, first, second = (r["diagnosis"] for r in results)
    assert clean["verdict"] == "adequate" and clean["causes"] == [] and clean["candidates"][0]["p_familywise"] > 0.05, f"nothing is lacking: {clean['candidates'][0]}"
    # A place of that sensor makes the same: the basin falls alike at all stations.
    assert first["verdict"] in ("cause-named", "ambiguous") and set(first["causes"]) <= {"sensor-gain", "sensor-position"}, \
        f"a sensor: {first['verdict']} {first['causes']}"
    gain = next(c for c in first["candidates"] if c["effect"] == "sensor-gain" and "size" in c)
    assert "sensor-gain" in first["causes"] and gain["size_low"] < 1.03 < gain["size_high"], f"reads too much, and by how much: {gain}"
    named = first["candidates"][:len(first["causes"])]
    assert all(c["on"] == "the sensor at 900 mm" and c["p_value"] > 0.05 and first["chi2"] - c["chi2"] > 20 for c in named), \
        f"which one, and what is left is noise: {named}"
    assert any(f.startswith(("CAUSE NAMED", "AMBIGUOUS")) and "900 mm reads" in f for f in results[1]["findings"]), "in words"
    assert first == second, "one and two threads differ in the diagnosis"


def test_a_prior_of_a_shared_parameter_counts_once(made, fitted):
    _, _, road, _ = made
    _, _, shared = fitted
    # A prior of a shared parameter counts once: its pull is that of the road's information, not of every station's.
    p2 = shared["base.k2"]
    sd = (p2["high"] - p2["low"]) / 2 / 1.96
    known = parameters(k2=f'level = "shared"\nprior = {{ mean = {p2["value"] + 2 * sd}, sd = {sd} }}')
    done = run("road", road, "--study", write_study(folder, known, None, "known"), "--out", folder / "known", "--json")
    assert done.returncode == 0, f"with a prior: {done.stderr}"
    p = {p["name"]: p for p in json.loads(done.stdout)["shared"]}["base.k2"]
    # Two normals of one width: half way between them, the range narrower by the root of 2.
    assert abs((p["value"] - p2["value"]) / sd - 1) < 0.2, f"with a prior: moved by {(p['value'] - p2['value']) / sd} of 1"
    assert abs((p["high"] - p["low"]) / (p2["high"] - p2["low"]) * 2 ** 0.5 - 1) < 0.1, f"with a prior: {p}"


def test_what_is_wrong_is_said_in_one_message(made):
    _, _, road, study = made
    for text, words in ((parameters(k2='level = "road"'), "level"), (parameters(k2="", k3=""), "no parameter in common"),
                        (parameters() + '\n[[constraints]]\nthat = "base.k1 <= 9000"\n', "constraints are not taken of a road")):
        done = run("road", road, "--study", write_study(folder, text, None, "wrong"), "--out", folder / "wrong")
        assert done.returncode == 2 and done.stdout == "" and words in done.stderr, f"{words}: {done.returncode} {done.stderr}"
        assert not (folder / "wrong").exists(), "nothing is written"
    assert run("road", road).returncode == 2, "a study is needed"
    done = run("road", road, "--study", study, "--withhold", "90kN", "--out", folder / "wrong")
    assert done.returncode == 2 and done.stdout == "" and "no station has a load level near" in done.stderr, f"nothing to withhold: {done.stderr}"


def test_levels_in_another_command():
    # Elsewhere the level means nothing, but it is read.
    levels = write_study(folder, STUDY.replace("points = 4", 'level = "shared"'), name="levels")
    assert run("check", levels).returncode == 0, "a study with levels in another command"
    done = run("check", write_study(folder, STUDY.replace("points = 4", 'level = "lane"'), name="levels"))
    assert done.returncode == 2 and "station, section, shared" in done.stderr, f"a wrong level: {done.stderr}"


def test_help_holds_an_example():
    assert "Example:" in run("road", "--help").stdout, "road --help holds an example"


def test_of_two_stations_none_is_left_out(made):
    _, rows, _, study = made
    pair = folder / "pair.csv"
    pair.write_text(HEADER + "\n" + "\n".join(",".join(map(str, row)) for row in rows if row[0] in ("P00", f"P{OUTLIER:02}")) + "\n")
    done = run("road", pair, "--study", study, "--out", folder / "pair", "--json")
    assert done.returncode == 0, done.stderr
    r = json.loads(done.stdout)
    assert len(r["stations"]) == 2 and not any("does not belong" in s for s in r["findings"]), r["findings"]
    assert all(p["stations"] == 2 for p in r["shared"]), r["shared"]
