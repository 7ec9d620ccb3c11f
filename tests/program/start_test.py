"""The first steps of a user: `new` writes a study, `check` says what would run, `fit` runs it."""
import json
import math
import re

import pytest

from support import *

folder = workspace()


@pytest.fixture(scope="module")
def new():
    study = folder / "road.toml"
    done = run("new", study)
    assert done.returncode == 0 and study.exists() and (folder / "road.csv").exists(), f"new writes a study and its readings: {done.stderr}"
    assert str(study) in done.stdout, "new says what it wrote"
    text = study.read_text()
    return study, text


def test_new_overwrites_nothing(new):
    study, text = new
    again = run("new", study)
    assert again.returncode == 2 and "there already" in again.stderr and study.read_text() == text, "new overwrites nothing"


def test_new_refuses_other_names():
    for name, word in (("road.txt", "NAME.toml"), ('a"b.toml', "letters")):
        wrong = run("new", folder / name)
        assert wrong.returncode == 2 and word in wrong.stderr, f"new refuses {name}: {wrong.stderr}"


def test_check_says_what_would_run(new):
    study, _ = new
    page = run("check", study)
    assert page.returncode == 0, f"check of a new study: {page.stderr}"
    for word in ("fwd.deflection: 8", "noise stated", "2 outputs", "map", "fit", "with derivatives"):
        assert word in " ".join(page.stdout.split()), f"check says '{word}':\n{page.stdout}"
    found = json.loads(run("check", study, "--json").stdout)
    assert found["readings"] == 8 and found["parameters"] == 3, "check counts readings and parameters"
    assert {"unique", "diagnose", "compare", "sensitivity"} <= {c["command"] for c in found["commands"]}, f"every command has an estimate: {found['commands']}"
    times = {c["command"]: c["seconds"] for c in found["commands"]}
    assert 0 < times["forward"] < times["map"] and times["forward --jacobian"] < times["fit"], f"times: {times}"


def test_outputs_in_three_dimensions_are_counted_where_they_are_computed():
    # map computes them at its ten lowest points, unique at some eight.
    found = json.loads(run("check", ROOT / "grids" / "captif-p1-unique-fwd.toml", "--json", "--threads", "1").stdout)
    times = {c["command"]: c["seconds"] for c in found["commands"]}
    assert 10 * times["forward"] < times["map"] < 30 * times["forward"], times
    assert 8 * times["forward --jacobian"] < times["unique"] < 30 * times["forward --jacobian"], times


def test_check_runs_the_model_only_where_its_time_is_asked_for():
    # No run of it ends in time, and check without --time makes none.
    impossible = write_study(folder / "impossible", STUDY.replace("refine = 0.4", "refine = 6") + "\n[solver]\ntime_limit_s = 0.01\n")
    assert run("forward", impossible).returncode == 1
    page = run("check", impossible)
    assert page.returncode == 0 and "estimated from sizes" in " ".join(page.stdout.split()), page.stdout + page.stderr
    assert max(map(len, page.stdout.splitlines())) <= 80, "no line is wide"
    timed = run("check", impossible, "--time")
    assert timed.returncode == 1 and "no answer at its own values" in timed.stderr, timed.stderr


def test_the_new_study_can_be_fitted_as_it_stands(new):
    study, _ = new
    fitted = json.loads(run("fit", study, "--explore", "16", "--starts", "2", "--out", folder / "run", "--json").stdout)
    assert fitted["best"]["converged"], "the new study can be fitted as it stands"
    assert fitted["at_bounds"] == [] and fitted["noise"]["p_value"] > 0.05, f"with a sensible answer: {fitted['at_bounds']} {fitted['noise']}"
    for name, truth in (("asphalt.modulus_MPa", 3500), ("base.k1", 1400), ("subgrade.modulus_MPa", 65)):
        value, error = fitted["best"]["parameters"][name], fitted["best"]["std_error"][name]
        assert abs(value - truth) < 3 * error and error < 0.3 * value, f"{name}: {value} +- {error}, the readings were made with {truth}"


def test_a_station_of_an_fwd_file_becomes_a_study():
    # Of a station of an FWD file: its drops by hand.
    station = folder / "station.toml"
    done = run("new", station, "--from", ROOT / "grids" / "road-north.f25", "--station", "100")
    assert done.returncode == 0 and str(station) in done.stdout, f"new writes a study of a station: {done.stderr}"
    drops = [[565, 468, 371, 300, 219, 156, 75], [571, 470, 374, 304, 221, 158, 76]]  # pressure, deflections; the first of three seats the plate
    pressure = sum(d[0] for d in drops) / 2
    rows = [line.split(",") for line in (folder / "station.csv").read_text().splitlines() if line.startswith("fwd-568kPa")]
    assert f"pressure_kPa = {pressure:g} " in station.read_text() and len(rows) == 6, f"the load and the sensors: {rows}"
    for row, offset, own in zip(rows, (0, 200, 300, 450, 600, 900), zip(*(d[1:] for d in drops))):
        median = sum(v * pressure / d[0] for v, d in zip(own, drops)) / 2
        assert float(row[2]) == offset and abs(float(row[6]) - median) < 0.006 and row[7] == "um", f"the median of its drops: {row}, {median}"
        assert math.sqrt(1 + (0.01 * median) ** 2) < float(row[8]) < math.sqrt(1 + (0.02 * median) ** 2), f"its noise: {row}"
    done = run("fit", station, "--explore", "16", "--starts", "2", "--out", folder / "station", "--json")
    assert done.returncode == 0 and json.loads(done.stdout)["best"]["converged"], f"and fits: {done.stderr}"


def test_every_level_of_a_station_is_a_load():
    levels = folder / "levels.csv"
    levels.write_text("station,drop,radius_mm,pressure_kPa,D0_um,D300_um,D600_um,D900_um,D1200_um\n" + "".join(
        f"7,{k},150,{p},{p * a:.1f},{p * 0.6 * a:.1f},{p * 0.3 * a:.1f},{p * 0.2 * a:.1f},{p * 0.14 * a:.1f}\n" for k, (p, a) in enumerate(((400, 0.9), (560, 0.88), (800, 0.86)), 1)))
    done = run("new", "--from", levels, "--station", "7", cwd=folder)
    assert done.returncode == 0 and (folder / "levels-7.toml").exists(), f"a name of its own: {done.stdout} {done.stderr}"
    assert (folder / "levels-7.toml").read_text().count("[[loads]]") == 3 and json.loads(run("forward", folder / "levels-7.toml", "--json").stdout)["status"] == "converged", \
        "every level is a load"
    for arguments, word in ((("--station", "9"), "7"), ((folder / "x.toml", "--station", "7"), "--from"), ((), "FILE")):
        done = run("new", *(("--from", levels) if word == "7" else ()), *arguments, cwd=folder)
        assert done.returncode == 2 and done.stdout == "" and word in done.stderr, f"new {arguments}: {done.returncode} {done.stderr}"


def test_a_floor_below_the_subgrade_leaves_its_modulus_within_the_bounds():
    # Asphalt of 80 mm and 3000 MPa, base of 250 mm and 200 MPa, subgrade of 1000 mm and 50 MPa on rock, by layered theory (`forward`): surface moduli
    # of 106, 119, 191 and 456 MPa.
    road = folder / "rock-bowl.csv"
    road.write_text("station,drop,radius_mm,pressure_kPa,D0_um,D300_um,D600_um,D900_um,D1200_um\n1,1,150,566,644.8,351.1,156.5,65.1,20.4\n")
    study = folder / "over-rock.toml"
    assert run("new", study, "--from", road, "--linear").returncode == 0
    of_subgrade = study.read_text().split('name = "subgrade.modulus_MPa"')[1]
    low, high = (float(re.search(rf"^{key} = (\S+)", of_subgrade, re.M)[1]) for key in ("min", "max"))
    assert low < 40 and high > 400, (low, high)


def test_layers_can_be_stated():
    stated = folder / "stated.toml"
    done = run("new", stated, "--from", ROOT / "grids" / "road-north.f25", "--station", "100", "--layers", "asphalt 90, subbase 280,subgrade", "--linear")
    assert done.returncode == 0 and "state the layers" not in done.stdout, done.stderr
    text = stated.read_text()
    for words in ('name = "asphalt"\nthickness_mm = 90', 'name = "subbase"\nthickness_mm = 280', 'name = "subbase.modulus_MPa"', "depth_mm = 371", "depth_mm = 89.9"):
        assert words in text, f"{words}:\n{text}"
    assert text.count('law = "linear"') == 3 and "uzan" not in text
    assert json.loads(run("forward", stated, "--json").stdout)["status"] == "converged"
    for layers, word in (("asphalt 90, base 280", "no thickness"), ("asphalt, base", "only the last"), ("asphalt 0, base", "from 1 to 20000"), ("asphalt 9x, base", "9x"),
                         ("a 90, a 100, b", "this name"), ("subgrade", "fewer than two"), ("asphalt 90 mm, b", "not a layer"), ("a.b 90, c", "not a layer")):
        wrong = run("new", folder / "wrong.toml", "--layers", layers)
        assert wrong.returncode == 2 and word in wrong.stderr and wrong.stderr.count("\n") == 1 and not (folder / "wrong.toml").exists(), f"{layers}: {wrong.stderr}"


def test_asphalt_has_its_modulus_at_the_temperature_of_the_file():
    # E(T) = E(20) 10^(-0.021 (T - 20)) (FHWA-RD-98-085), two digits.
    bowl = "402,318,262,201,158,103"
    for celsius, modulus in ((20, 3000), (35, 1500), (5, 6200)):
        road = folder / f"road-at{celsius}.csv"
        road.write_text(f"station,drop,radius_mm,pressure_kPa,asphalt_C,D0_um,D200_um,D300_um,D450_um,D600_um,D900_um\n1,1,150,600,{celsius},{bowl}\n")
        assert run("new", folder / f"at{celsius}.toml", "--from", road).returncode == 0
        assert f"modulus_MPa = {modulus} " in (folder / f"at{celsius}.toml").read_text(), celsius


def test_a_study_of_strain_gauges():
    gauges = folder / "gauges.toml"
    done = run("new", gauges, "--gauges", "150,300", "--linear", "--layers", "base 250, subgrade")
    assert done.returncode == 0, done.stderr
    rows = [line.split(",") for line in (folder / "gauges.csv").read_text().splitlines() if line.startswith("wheel")]
    assert [(row[1], row[4], row[7]) for row in rows] == [("strain_zz", "150", "microstrain"), ("strain_zz", "300", "microstrain")]
    # Boussinesq under the centre of a circle: (s_z - 2 nu s_r)/E of 650 kPa, 120 MPa, 0.35.
    for row in rows:
        cosine = float(row[4]) / math.hypot(float(row[4]), 98.9)
        vertical = 650e3 * (1 - cosine**3)
        radial = 650e3 / 2 * (1 + 2 * 0.35 - 2 * 1.35 * cosine + cosine**3)
        assert abs(float(row[6]) - 1e6 * (vertical - 0.7 * radial) / 120e6) < 0.6, row
    fitted = json.loads(run("fit", gauges, "--explore", 16, "--starts", 2, "--out", folder / "run-gauges", "--json").stdout)
    assert fitted["best"]["status"] == "converged" and fitted["readings"] == 2
    assert run("new", folder / "both.toml", "--gauges", "150", "--from", ROOT / "grids" / "road-north.f25").returncode == 2


def test_check_finds_a_misspelt_key(new):
    study, text = new
    misspelt = folder / "misspelt.toml"
    misspelt.write_text(text.replace("pressure_kPa", "presure_kPa"))
    wrong = run("check", misspelt)
    assert wrong.returncode == 2 and "presure_kPa" in wrong.stderr, "check finds a misspelt key"
