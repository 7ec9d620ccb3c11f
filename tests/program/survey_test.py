"""A road whose moduli are known: they come back, nonsense at one station stops nothing, and neither the number of threads
nor an interrupt changes a bit."""
import csv
import html
import io
import json
import re
import signal
import time
import xml.etree.ElementTree
import zipfile

import pytest

from support import *

folder = workspace()
OFFSETS = (0, 200, 300, 450, 600, 900)
HEADER = "station,chainage_m,drop,radius_mm,pressure_kPa," + ",".join(f"D{o}_um" for o in OFFSETS)
SECTION = STUDY[:STUDY.index("[data]")].replace("thickness_mm = 40", "thickness_mm = 80")
SURVEY = SECTION + SURVEYED


def bowl(k1, subgrade, pressure):
    """Deflections in um, by the program's own forward run."""
    text = SECTION
    for old, new in (("k1 = 2000", f"k1 = {k1}"), ("modulus_MPa = 45", f"modulus_MPa = {subgrade}"),
                     ("pressure_kPa = 600", f"pressure_kPa = {pressure}")):
        assert text.count(old) == 1, f"the section holds '{old}' once"
        text = text.replace(old, new)
    for offset in OFFSETS:
        text += f'[[outputs]]\nname = "D{offset}"\nload = "fwd"\nquantity = "deflection"\nx_mm = {offset}\n'
    done = run("forward", write_study(folder, text, None, "truth"), "--json")
    assert done.returncode == 0, f"forward: {done.stderr}"
    return [1e3 * r["value"] for r in json.loads(done.stdout)["responses"]]


@pytest.fixture(scope="module")
def made():
    # The last stations first: the report goes along the road.
    truth = {"C": (4000, 60, 560), "B": (800, 200, 580), "A": (2500, 45, 600)}
    rows = []
    for name, (k1, subgrade, pressure) in truth.items():
        deflections = bowl(k1, subgrade, pressure)
        rows.append([name, 100 * "ABC".index(name), 1, 150, pressure, *deflections])
    rows.append(["nonsense", 50, 1, 150, 600, 500, 300, 200, 250, 100, 50])
    road = folder / "road.csv"
    road.write_text("# made by forward\n" + HEADER + "\n" + "\n".join(",".join(map(str, row)) for row in rows) + "\n")
    return truth, rows, road


study = write_study(folder, SURVEY, None, "survey")


def call(*arguments):
    done = run("survey", *arguments, "--json")
    assert done.returncode == 0, f"survey: {done.stderr}"
    assert done.stderr == "", f"survey: standard error is silent when piped: {done.stderr}"
    return json.loads(done.stdout)


def test_without_a_study_ratios_alone(made):
    _, rows, road = made
    result = call(road, "--out", folder / "ratios")
    stations = {s["station"]: s for s in result["stations"]}
    assert list(stations) == ["A", "nonsense", "B", "C"], "stations stand along the road"
    assert result["counts"] == {"stations": 4, "rejected": 1, "pass": 2, "fail": 1, "no_ratio": 0, "fitted": 0, "doubtful": 0, "no_fit": 0, "failed": 0}, f"counts: {result['counts']}"
    assert stations["nonsense"]["status"] == "rejected" and "rises from 200 um at 300 mm" in stations["nonsense"]["reason"], "nonsense has its reason"
    assert any(f.startswith("1 station is rejected. nonsense: ") for f in result["findings"]), f"and is named with it: {result['findings']}"
    for row in rows[:3]:
        s = stations[row[0]]
        interpolated = (row[6] * row[7]) ** 0.5  # half way between 200 and 300 mm on a logarithmic scale
        assert abs(s["deflection_ratio"] - interpolated / row[5]) < 1e-12, f"{row[0]}: the ratio"
        assert s["D250_is_interpolated"] and s["pass"] == (interpolated / row[5] >= 0.6), f"{row[0]}: the verdict"
        assert abs(s["D0_um_at_common_pressure"] - row[5] * 580 / row[4]) < 1e-9, f"{row[0]}: D0 at the median pressure"
        assert "fit" not in s, f"{row[0]}: nothing was fitted"
    assert not stations["B"]["pass"], "the weak station fails"
    assert "D250/D0" in result["deflection_ratio"]["definition"] and result["deflection_ratio"]["limit"] == 0.6, "the definition is said"
    assert not (folder / "ratios" / "run.sqlite").exists(), "no store without a computation"
    assert "--study" not in run("survey", road, "--verbose", "--out", folder / "ratios").stdout, "a table for people"


@pytest.fixture(scope="module")
def surveyed(made):
    _, _, road = made
    # With a study: the moduli come back, with the same bits for one and two threads.
    results = {}
    for threads in (1, 2):
        out = folder / f"threads-{threads}"
        results[threads] = call(road, "--study", study, "--threads", threads, "--out", out)
        assert json.loads((out / "survey.json").read_text()) == results[threads], "the same in the folder of the run"
    assert without_run(results[1]) == without_run(results[2]), "one and two threads differ"
    table = (folder / "threads-1" / "survey.csv").read_text()
    assert table == (folder / "threads-2" / "survey.csv").read_text(), "the tables of one and two threads differ"
    return results, table


def test_the_moduli_come_back(made, surveyed):
    truth, _, _ = made
    results, _ = surveyed
    assert results[1]["counts"]["fitted"] == 3 and results[1]["counts"]["failed"] == 0, "every sound station is fitted"
    for s in results[1]["stations"]:
        if s["station"] == "nonsense":
            assert "fit" not in s, "nonsense is not fitted"
            continue
        fit = s["fit"]
        k1, subgrade, _ = truth[s["station"]]
        # The same model and no noise: what is left is the tolerance of the search.
        assert abs(fit["parameters"]["base.k1"] / k1 - 1) < 1e-4, f"{s['station']}: k1 {fit['parameters']['base.k1']}, not {k1}"
        assert abs(fit["parameters"]["subgrade.modulus_MPa"] / subgrade - 1) < 1e-4, f"{s['station']}: subgrade {fit['parameters']}"
        assert fit["status"] == "converged" and fit["rms_percent"] < 0.01 and fit["on_bound"] == [], f"{s['station']}: {fit}"
        relative = [r["model_um"] / r["measured_um"] - 1 for r in s["readings"]]
        rms = 100 * (sum(d * d for d in relative) / len(relative)) ** 0.5
        assert abs(rms - fit["rms_percent"]) < 1e-9, f"{s['station']}: the root mean square"


def test_the_table_has_the_bits_of_the_json(surveyed):
    results, table = surveyed
    cells = list(csv.DictReader(io.StringIO(table)))
    assert [c["station"] for c in cells] == ["A", "nonsense", "B", "C"], "the table: one line a station"
    assert [c["verdict"] for c in cells] == ["pass", "", "fail", "pass"], "the table: verdicts"
    for c, s in zip(cells, results[1]["stations"]):
        assert None not in c and None not in c.values(), f"the table: {c['station']} has as many cells as the header"
        assert c["base.k1"] == ("" if "fit" not in s else repr(s["fit"]["parameters"]["base.k1"])), "the table: the bits of the JSON"


@pytest.mark.usefixtures("surveyed")
def test_the_report_in_words(made):
    _, _, road = made
    text = run("survey", road, "--study", study, "--verbose", "--out", folder / "threads-1").stdout
    for words in ("D250/D0", "Austroads", "~0.", "pass", "fail", "rejected: the deflection rises", "base.k1", "RMS %", "Along the road", "0 runs"):
        assert words in " ".join(text.split()), f"'{words}' in the report"
    assert "\x1b" not in text, "no terminal codes when piped"


def test_a_bound_between_truth_and_data_is_named(made):
    _, _, road = made
    bounded = write_study(folder, SURVEY.replace("max = 300\n", "max = 170\n"), None, "bounded")
    result = call(road, "--study", bounded, "--out", folder / "bounded")
    bounds = {s["station"]: s["fit"]["on_bound"] for s in result["stations"] if "fit" in s}
    assert bounds["B"] == ["subgrade.modulus_MPa at its upper bound"] and bounds["C"] == [], f"bounds: {bounds}"
    far_off = write_study(folder, SURVEY.replace("max = 300\n", "max = 60\n"), None, "far-off")
    station = {s["station"]: s for s in call(road, "--study", far_off, "--out", folder / "far-off")["stations"]}["B"]
    assert station["status"] == "no-fit" and "RMS" in station["reason"] and "attempt" in station, f"a third of the stiffness is no fit: {station['reason']}"


def test_a_model_that_cannot_be_is_said(made):
    _, _, road = made
    # A model that cannot be: no back-calculation, and it is said.
    stiff = write_study(folder, SURVEY.replace("min = 20\nmax = 300\n", "min = 2000\nmax = 3000\n"), None, "stiff")
    done = run("survey", road, "--study", stiff, "--out", folder / "stiff", "--json")
    assert done.returncode == 1, f"nothing back-calculated: exit status {done.returncode}"
    result = json.loads(done.stdout)
    assert result["counts"]["fitted"] == 0 and result["counts"]["no_fit"] == 3, f"no fit: {result['counts']}"
    assert all(s["reason"] and "fit" not in s and s["parameters"] == {} for s in result["stations"]), "no parameters of what is no fit"


def test_several_load_levels():
    # Several load levels tell k2 of a stress-dependent base, and are fitted together unless one is requested.
    text = [HEADER]
    for drop, pressure in enumerate((300, 600, 900), 1):
        text.append(",".join(map(str, ["A", 0, drop, 150, pressure, *bowl(2500, 45, pressure)])))
    levels = folder / "levels.csv"
    levels.write_text("\n".join(text) + "\n")
    result = call(levels, "--study", study, "--out", folder / "levels")
    station = result["stations"][0]
    assert station["drops_used"] == [1, 2, 3] and len(station["levels"]) == 3 and result["fits_all_levels"], f"all levels: {station['drops_used']}"
    # Within the path tolerance: the levels lie on one path here, and were made each on its own.
    assert abs(station["parameters"]["base.k1"]["value"] / 2500 - 1) < 1e-3, f"k1 of all levels: {station['parameters']}"
    station = call(levels, "--study", study, "--target-load", "42kN", "--out", folder / "level")["stations"][0]
    assert station["drops_used"] == [2] and station["drops_left_out"] == [1, 3], f"42 kN on this plate are 594 kPa: {station['drops_used']}"
    assert any("drops 1, 3 left out" in r for r in station["remarks"]), f"what is left out is said: {station['remarks']}"
    station = call(levels, "--drops", "1,2", "--out", folder / "drops")["stations"][0]
    assert station["drops_used"] == [2] and station["drops_left_out"] == [1, 3], f"drops 1 and 2, the higher of them: {station['drops_used']}"
    assert station["normalised"]["pressure_kPa"] == 600, "normalised to the median pressure"
    station = call(levels, "--normalise", "566kPa", "--out", folder / "normalised")["stations"][0]
    assert abs(station["normalised"]["D0_um"] / (station["D0_um"] * 566 / 900) - 1) < 1e-12, "in proportion to the pressure"


def test_parameters_have_ranges_around_their_values(surveyed):
    results, _ = surveyed
    for s in results[1]["stations"]:
        for name, p in s["parameters"].items():
            assert p["low"] < p["value"] < p["high"] and p["determined"], f"{s['station']}, {name}: {p}"


def test_a_folder_holds_one_road(made):
    _, _, road = made
    twin = folder / "elsewhere" / "road.csv"
    twin.parent.mkdir()
    twin.write_text(road.read_text().replace("500,300", "510,300"))
    assert run("survey", road, "--out", folder / "one-road").returncode == 0
    done = run("survey", twin, "--out", folder / "one-road")
    assert done.returncode == 2 and "another road" in done.stderr, f"another road into the same folder: {done.returncode} {done.stderr}"
    done = run("survey", road, cwd=folder)
    assert done.returncode == 0 and (folder / "output" / "road" / "survey.json").exists(), "results go under the name of the file"
    assert run("survey", road, cwd=folder).returncode == 0, "the same road again"


# The bowl of a half-space (of layers of 1214, 197.4 and 70.8 MPa, by an independent multilayer program): the floor of the study
# is said to carry the answer, without it the moduli come out.
(folder / "endless.csv").write_text("station,chainage_m,radius_mm,load_kN,D0_mm,D300_mm,D600_mm,D900_mm,D1200_mm,D1500_mm,D1800_mm\n"
                                    "A,0,150,40,0.4735,0.3095,0.2098,0.1583,0.1264,0.1041,0.0876\n")


def layered(bottom):
    text = f'schema = 1\n[section]\nbottom = "{bottom}"\n'
    for name, thickness, modulus, poisson in (("asphalt", 170, 1000, 0.4999), ("base", 575, 200, 0.4), ("subgrade", 4255, 60, 0.4)):
        text += (f'[[layers]]\nname = "{name}"\nthickness_mm = {thickness}\ndensity_kg_m3 = 2000\nk0 = 0.5\nlaw = "linear"\n'
                 f'modulus_MPa = {modulus}\npoisson = {poisson}\n')
    text += '[[loads]]\nname = "fwd"\ntype = "plate"\nradius_mm = 150\npressure_kPa = 566\n[data]\nmisfit = "relative"\n'
    for name, low, high in (("asphalt", 400, 3000), ("base", 50, 500), ("subgrade", 20, 200)):
        text += f'[[parameters]]\nname = "{name}.modulus_MPa"\nmin = {low}\nmax = {high}\nscale = "log"\n'
    (folder / f"{bottom}.toml").write_text(text)
    return folder / f"{bottom}.toml"


def test_the_floor_that_carries_the_answer_is_said():
    on_floor = call(folder / "endless.csv", "--study", layered("rigid"), "--out", folder / "on-floor")
    said = [f for f in on_floor["findings"] if "hangs on the floor at 5.000 m" in f]
    subgrade = re.search(r"subgrade.modulus_MPa ([0-9.]+) instead of", said[0]) if said else None
    assert subgrade and abs(float(subgrade[1]) / 70.8 - 1) < 0.01, f"the floor carries the answer: {on_floor['findings']}"


@pytest.fixture(scope="module")
def endless():
    return call(folder / "endless.csv", "--study", layered("half-space"), "--out", folder / "endless")


def test_moduli_of_a_half_space_come_out(endless):
    for name, modulus in (("asphalt", 1214), ("base", 197.4), ("subgrade", 70.8)):
        found = endless["stations"][0]["parameters"][f"{name}.modulus_MPa"]["value"]
        assert abs(found / modulus - 1) < 0.01, f"{name} of a half-space: {found}"
    assert not any("hangs on the floor" in f for f in endless["findings"]), "no floor, no finding of it"


# [[outputs]] of every station: the value is the forward run's at the best fit; with one parameter the range is what the ends of
# the parameter's own range give, to first order. Outputs may be under the plate or another load.
text = layered("half-space").read_text()
text = text[:text.index("[[parameters]]")].replace("pressure_kPa = 566", "pressure_kPa = 565.884242104515")
text = text.replace("modulus_MPa = 1000", "modulus_MPa = 1214").replace("modulus_MPa = 200", "modulus_MPa = 197.4")
text += '''[[loads]]
name = "tyres"
type = "gear"
pressure_kPa = 800
wheels = [ { x_mm = -160, y_mm = 0, force_kN = 20 }, { x_mm = 160, y_mm = 0, force_kN = 20 } ]
[[outputs]]
name = "base strain"
load = "tyres"
quantity = "strain_zz"
depth_mm = 300
[[outputs]]
name = "subgrade strain"
load = "fwd"
quantity = "strain_zz"
depth_mm = 760
'''
(folder / "outputs.toml").write_text(text + '[[parameters]]\nname = "subgrade.modulus_MPa"\nmin = 20\nmax = 200\nscale = "log"\n')


def outputs_at(modulus):
    (folder / "at.toml").write_text(text.replace("modulus_MPa = 60", f"modulus_MPa = {modulus!r}"))
    done = run("forward", folder / "at.toml", "--json")
    assert done.returncode == 0, f"forward: {done.stderr}"
    return [r["value"] for r in json.loads(done.stdout)["responses"]]


def test_outputs_of_every_station(endless):
    station = call(folder / "endless.csv", "--study", folder / "outputs.toml", "--out", folder / "outputs")["stations"][0]
    modulus = station["parameters"]["subgrade.modulus_MPa"]
    best, below, above = (outputs_at(modulus[end]) for end in ("value", "low", "high"))
    assert list(station["outputs"]) == ["base strain", "subgrade strain"], f"outputs: {station['outputs']}"
    for k, output in enumerate(station["outputs"].values()):
        assert abs(output["value"] / best[k] - 1) < 1e-6 and output["determined"], f"the output at the best fit: {output}, not {best[k]}"
        half, expected = (output["high"] - output["low"]) / 2, abs(below[k] - above[k]) / 2
        assert abs(half / expected - 1) < 0.02 and expected > 1e-4 * abs(best[k]), f"the range of {output}: half {half}, not {expected}"
    cells = list(csv.DictReader(io.StringIO((folder / "outputs" / "survey.csv").read_text())))[0]
    assert float(cells["base strain [microstrain]"]) == station["outputs"]["base strain"]["value"], f"the table: {list(cells)}"
    again = run("survey", folder / "endless.csv", "--study", folder / "outputs.toml", "--verbose", "--out", folder / "outputs").stdout
    assert "base strain" in again and "0 runs" in again, "outputs in the text, and kept"
    assert "outputs" not in open(folder / "endless" / "survey.csv").read() and endless["stations"][0]["outputs"] == {}, "none without [[outputs]]"


def part(name, lines, force=50):
    """A file of stations with one bowl."""
    drops = [line.format(f"150,{force},500,400,330,180,110") for line in lines.split("|")]
    (folder / f"{name}.csv").write_text("station,chainage_m,radius_mm,load_kN,D0_um,D200_um,D300_um,D600_um,D900_um\n" + "\n".join(drops) + "\n")
    return folder / f"{name}.csv"


def test_two_files_of_one_road():
    # Runs of their own where they lie over each other, one road where one follows the other.
    first, second, onwards = part("first", "1,0,{0}|2,100,{0}"), part("second", "1,0,{0}|2,100,{0}"), part("onwards", "3,200,{0}|4,300,{0}")
    both = call(first, second, "--out", folder / "two-runs")
    assert [s["profile"] for s in both["stations"]] == ["first", "first", "second", "second"], f"two runs: {[s['profile'] for s in both['stations']]}"
    both = call(first, onwards, "--out", folder / "on")
    assert [s["profile"] for s in both["stations"]] == [""] * 4, "one road of two files"


def test_a_slip_is_a_finding():
    slip = call(part("slip", "1,0,{0}|2,100,{0}", force=5.1), "--out", folder / "slip")
    assert any("tonnes" in f and "2 of 2 stations" in f for f in slip["findings"]), f"a slip is a finding: {slip['findings']}"


def test_positions_make_a_map_and_temperatures_the_asphalts():
    places = folder / "places.csv"
    places.write_text("station,chainage_m,radius_mm,load_kN,D0_um,D200_um,D300_um,latitude,longitude,time,surface_C,air_C,crew\n"
                      "A,0,150,50,500,400,330,48.97,2.58,13:15,25,15,us\nB,9,150,50,500,400,330,,,,95,,us\n")
    result = call(places, "--asphalt-thickness", 200, "--air-before", 15, "--out", folder / "places")
    map_of = json.loads((folder / "places" / "survey.geojson").read_text())
    assert [f["geometry"]["coordinates"] for f in map_of["features"]] == [[2.58, 48.97]], f"a map: {map_of}"
    # SCI = D0 - D300, here 170 um at the pressure that it is normalised to.
    indices = result["stations"][0]["normalised"]
    assert map_of["features"][0]["properties"]["SCI_um"] == indices["SCI_um"], f"indices: {map_of}"
    space = {"kml": "http://www.opengis.net/kml/2.2"}
    marks = xml.etree.ElementTree.parse(folder / "places" / "survey.kml").findall(".//kml:Placemark", space)
    assert [m.find("kml:name", space).text for m in marks] == ["A"] and marks[0].find(".//kml:coordinates", space).text == "2.58,48.97", "KML: the same map"
    data = {d.get("name"): d.find("kml:value", space).text for d in marks[0].iter("{http://www.opengis.net/kml/2.2}Data")}
    assert float(data["SCI_um"]) == indices["SCI_um"], f"KML: {data}"
    assert abs(result["stations"][0]["asphalt_C"] - 20.774) < 0.001, "BELLS3 at half of 200 mm: see survey_analysis_test"
    assert result["stations"][1]["asphalt_C"] is None, "no temperature without a surface"
    assert result["stations"][0]["at_reference"] is None, "nobody asked for a reference temperature"
    assert any("Fahrenheit" in r for r in result["stations"][1]["remarks"]), f"95 C: {result['stations'][1]['remarks']}"
    assert any("crew" in f for f in result["findings"]), f"columns that are not used are named: {result['findings']}"


def test_stations_without_a_ratio_are_counted():
    light = folder / "light.csv"
    light.write_text("station,chainage_m,radius_mm,load_kN,D0_um\n1,0,150,7.07,468\n2,10,150,7.07,607\n")
    done = run("survey", light, "--out", folder / "light")
    assert "2 stations: 0 pass the deflection ratio, 0 fail, 2 have none, 0 rejected" in " ".join(done.stdout.split()), done.stdout


def test_deflections_at_a_reference_temperature():
    warm = folder / "warm.csv"
    warm.write_text("station,chainage_m,radius_mm,load_kN,D0_um,D300_um,D600_um,D900_um,asphalt_C\nA,0,150,40,400,250,170,90,30\nB,9,150,40,400,250,170,90,\n")
    result = call(warm, "--asphalt-thickness", 150, "--latitude", 40, "--reference-temperature", 20, "--normalise", "40kN", "--out", folder / "warm")
    at, none = (s["at_reference"] for s in result["stations"])
    # Worked by hand in temperature_curves_test.cpp; D0 (90 + 213.7)/(90 + 259.0), D0 - D300 by 0.71888.
    assert abs(at["D0_um"] - 400 * 303.7 / 349.0) < 0.1 and abs(at["SCI_um"] - 150 * 0.71888) < 0.01, f"by FHWA-RD-98-085: {at}"
    assert at["out_of_range"] == [] and none is None, f"no temperature, no answer: {at}, {none}"
    assert any("FHWA-RD-98-085 at 1 of 2 stations" in f for f in result["findings"]), f"said: {result['findings']}"
    lines = list(csv.DictReader((folder / "warm" / "survey.csv").open()))
    assert float(lines[0]["BDI_um_at_reference"]) == at["BDI_um"] and lines[1]["BDI_um_at_reference"] == "", f"in the table: {lines}"
    dutch = call(warm, "--temperature-curve", "rws", "--reference-temperature", 20, "--normalise", "40kN", "--out", folder / "dutch")
    # t = 10: 1 + 0.13926 + 0.02298 = 1.16224
    assert abs(dutch["stations"][0]["at_reference"]["D0_um"] - 400 / 1.16224) < 0.01, f"another curve: {dutch['stations'][0]['at_reference']}"
    nowhere = call(warm, "--asphalt-thickness", 150, "--reference-temperature", 20, "--out", folder / "nowhere")
    assert "latitude" in nowhere["stations"][0]["at_reference"]["reason"], "the regressions want the latitude"


def workbook(path, sheets):
    """A workbook by hand: {name: rows}; words are shared strings, None is an empty cell."""
    words, parts, relations, list_ = [], {}, "", ""
    for number, (name, rows) in enumerate(sheets.items(), 1):
        lines = ""
        for r, row in enumerate(rows, 1):
            cells = ""
            for c, cell in enumerate(row):
                at = f"{chr(ord('A') + c)}{r}"
                if isinstance(cell, str):
                    words.append(cell)
                    cells += f'<c r="{at}" t="s"><v>{len(words) - 1}</v></c>'
                elif cell is not None:
                    cells += f'<c r="{at}"><v>{cell}</v></c>'
            lines += f'<row r="{r}">{cells}</row>' if cells else ""
        parts[f"xl/worksheets/sheet{number}.xml"] = \
            f'<worksheet xmlns="http://schemas.openxmlformats.org/spreadsheetml/2006/main"><sheetData>{lines}</sheetData></worksheet>'
        relations += f'<Relationship Id="rId{number}" Type="worksheet" Target="worksheets/sheet{number}.xml"/>'
        list_ += f'<sheet name="{name}" sheetId="{number}" r:id="rId{number}"/>'
    parts["xl/workbook.xml"] = f'<workbook xmlns:r="http://schemas.openxmlformats.org/officeDocument/2006/relationships"><sheets>{list_}</sheets></workbook>'
    parts["xl/_rels/workbook.xml.rels"] = f"<Relationships>{relations}</Relationships>"
    parts["xl/sharedStrings.xml"] = "<sst>" + "".join(f"<si><t>{w}</t></si>" for w in words) + "</sst>"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, text in parts.items():
            archive.writestr(name, text)
    return path


def test_a_workbook_is_read_as_its_table_and_written():
    header = ["station", "chainage_m", "radius_mm", "load_kN", "D0_um", "D200_um", "D300_um", "remark"]
    rows = [["A", 0, 150, 50, 500, 400.5, 330, "wet, cold"], ["B", 9, 150, 50, 480, 390, None, None]]
    table = folder / "table.csv"
    table.write_text("\n".join(",".join('"wet, cold"' if cell == "wet, cold" else "" if cell is None else str(cell) for cell in row) for row in [header, *rows]) + "\n")
    book = workbook(folder / "book.xlsx", {"Notes": [["Project"], ["by hand"]], "Drops": [["Project 12"], [], header, *rows]})
    of_table = call(table, "--out", folder / "of-table")
    of_book = call(book, "--out", folder / "of-book")
    for a, b in zip(of_table["stations"], of_book["stations"]):
        assert a["normalised"] == b["normalised"] and a["station"] == b["station"] and a["comment"] == b["comment"], f"{a}\n{b}"
    assert len(of_book["stations"]) == 2 and of_book["stations"][0]["comment"] == "wet, cold"
    with zipfile.ZipFile(folder / "of-book" / "survey.xlsx") as archive:
        sheet, shared = (archive.read(f"xl/{name}.xml").decode() for name in ("worksheets/sheet1", "sharedStrings"))
    header_of = next(csv.reader(io.StringIO((folder / "of-book" / "survey.csv").read_text())))
    assert all(f">{html.escape(name, quote=False)}</t>" in shared for name in header_of if name), "the header of survey.csv"
    assert re.search(r'<c r="[A-Z]+2"><v>150</v>', sheet) or "<v>9</v>" in sheet, "numbers are numbers"


def test_workbooks_without_drops_are_refused():
    for name, sheets, said in (("empty", {"Notes": [["Project"]]}, "no sheet of this workbook holds a survey table"),):
        done = run("survey", workbook(folder / f"{name}.xlsx", sheets), "--out", folder / name)
        assert done.returncode == 2 and said in done.stderr and "Notes" in done.stderr, done.stderr
    broken = folder / "broken.xlsx"
    broken.write_bytes((folder / "empty.xlsx").read_bytes()[:200])
    done = run("survey", broken, "--out", folder / "broken")
    assert done.returncode == 2 and "this workbook cannot be read" in done.stderr, done.stderr
    other = folder / "other.xlsx"
    with zipfile.ZipFile(other, "w") as archive:
        archive.writestr("hello.txt", "hello")
    done = run("survey", other, "--out", folder / "other")
    assert done.returncode == 2 and "holds no workbook" in done.stderr, done.stderr


def test_a_survey_that_is_cut_off_continues(made, surveyed):
    _, _, road = made
    results, _ = surveyed
    # Cut off and continued: the same result, and what was computed is not computed again.
    out = folder / "interrupted"
    for least in (100, 262):  # while exploring, while searching
        process = subprocess.Popen([PROGRAM, "survey", road, "--study", study, "--out", out], stdout=subprocess.DEVNULL,
                                   stderr=subprocess.PIPE, text=True)
        while evaluations(out) < least and process.poll() is None:
            time.sleep(0.01)
        process.send_signal(signal.SIGINT)
        message = process.communicate()[1]
        assert process.returncode == 130, f"interrupted: exit status {process.returncode}"
        assert "kept" in message, f"the interrupt says what is kept: {message}"
        assert not (out / "survey.json").exists(), "no result of half a road"
    result = call(road, "--study", study, "--out", out)
    assert without_run(result) == without_run(results[1]), "the interrupted and continued survey differs"


def test_a_station_without_an_answer_stops_no_other(made):
    _, rows, road = made
    # A station whose model has no answer is said, and the others are fitted.
    far = folder / "far.csv"
    far.write_text(HEADER + ",D3500_um\n" + "\n".join(",".join(map(str, row)) + ("," if row[0] == "A" else ",1") for row in rows[1:3]) + "\n")
    result = call(far, "--study", study, "--out", folder / "far")
    stations = {s["station"]: s for s in result["stations"]}
    assert stations["B"]["status"] == "failed" and "outside the mesh" in stations["B"]["reason"], f"B: {stations['B']}"
    assert stations["A"]["status"] == "ok" and "fit" in stations["A"], "A is fitted all the same"
    impossible = write_study(folder, SURVEY.replace('"base.k1"\nmin = 300\nmax = 10000', '"base.n"\nmin = 3.5\nmax = 4.5'), None, "impossible")
    done = run("survey", road, "--study", impossible, "--out", folder / "impossible", "--json")
    assert done.returncode == 1, f"no station has an answer: exit status {done.returncode}"
    reasons = [s["reason"] for s in json.loads(done.stdout)["stations"] if s["status"] == "failed"]
    assert len(reasons) == 3 and all("not one explored point has an answer" in r and "must be positive" in r for r in reasons), f"reasons: {reasons}"
    assert "\n6 stations" in run("survey", far, road, "--verbose", "--out", folder / "both").stdout, "several files make one road"


# Wrong input: one message, exit status 2, nothing written.
def expect(label, words, *arguments):
    done = run("survey", *arguments, "--out", folder / "wrong")
    message = done.stderr.strip()
    print(f"{label}\n    {message.replace(str(folder), '...')}")
    assert done.returncode == 2, f"{label}: exit status {done.returncode}"
    assert len(message.splitlines()) == 1 and done.stdout == "", f"{label}: one message"
    assert not (folder / "wrong").exists(), f"{label}: something was written"
    for word in words:
        assert word in message, f"{label}: '{word}' is missing"


def file(name, text):
    (folder / name).write_text(text)
    return folder / name


def test_wrong_input_is_one_message(made):
    _, _, road = made
    expect("no such file", ["nowhere.csv", "FWD file"], folder / "nowhere.csv")
    expect("another format", ["known format", "chainage_m"], study)
    done = run("survey", road, "--target-load", "heavy", "--out", folder / "wrong")
    assert done.returncode == 2 and "heavy is no load" in done.stderr, f"no load: {done.returncode} {done.stderr}"
    expect("columns without a table's name", ["no such column", "Kraft"], road, "--columns", "load_kN = Kraft")
    expect("no plate", ["plate", "0 loads"], road, "--study",
           write_study(folder, SURVEY.replace('type = "plate"\nradius_mm = 150', 'type = "wheel"\npatch = "circle"\nforce_kN = 40'), None, "wheel"))
    expect("a free load", ["fwd.pressure_kPa", "measured"], road, "--study",
           write_study(folder, SURVEY.replace('"base.k1"\nmin = 300', '"fwd.pressure_kPa"\nmin = 300'), None, "free-load"))
    expect("no parameters", ["parameters"], road, "--study", write_study(folder, SURVEY[:SURVEY.index("[[parameters]]")], None, "fixed"))


def test_words_cost_readings_not_the_file():
    letters = run("survey", file("letters.csv", HEADER + "\nA,0,1,150,600,many,1,1,1,1,1\nB,9,1,150,600,500,many,300,200,150,100\n"),
                            "--out", folder / "letters", "--json")
    stations = json.loads(letters.stdout)["stations"]
    assert [s["status"] for s in stations] == ["rejected", "ok"], "words cost readings, not the file"
    assert 'line 3, D200_um: "many" is not a number' in stations[1]["remarks"], f"the word is remarked: {stations[1]['remarks']}"


def test_nothing_but_nonsense(made):
    _, rows, _ = made
    assert run("survey").returncode == 2, "no file"
    only = file("only.csv", HEADER + "\n" + ",".join(map(str, rows[3])) + "\n")
    assert run("survey", only, "--out", folder / "only").returncode == 1, "nothing but nonsense: exit status 1"


def test_help_holds_an_example():
    assert "Example:" in run("survey", "--help").stdout, "survey --help holds an example"
