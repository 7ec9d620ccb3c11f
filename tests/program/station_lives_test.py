"""Life and overlay along a road (survey and road with [[criteria]]), against the laws worked out here at forward runs of the stations."""
import csv
import json
import math

import pytest

from support import *

folder = workspace()
OFFSETS = (0, 200, 300, 450, 600, 900, 1500)
TRUTHS = [{"asphalt": 3000, "base": 250, "subgrade": subgrade} for subgrade in (45, 50, 55, 48, 30, 60)]
NOISE = 0.03
LAYERS = "\n".join(f'[[layers]]\nname = "{name}"\n{thickness}density_kg_m3 = 2200\nk0 = 0.5\nlaw = "linear"\nmodulus_MPa = {modulus}\npoisson = {poisson}\n'
                   for name, thickness, modulus, poisson in (("asphalt", "thickness_mm = 100\n", 3500, 0.35), ("base", "thickness_mm = 300\n", 320, 0.35), ("subgrade", "", 80, 0.4)))
LOADS = """
[[loads]]
name = "wheel"
type = "wheel"
force_kN = 40
pressure_kPa = 750
patch = "circle"
[[loads]]
name = "fwd"
type = "plate"
radius_mm = 150
pressure_kPa = 700
"""
SECTION = '[section]\nbottom = "half-space"\n' + LAYERS + LOADS
PARAMETERS = "".join(f'[[parameters]]\nname = "{name}.modulus_MPa"\nmin = {low}\nmax = {high}\nscale = "log"\n'
                     for name, low, high in (("asphalt", 500, 20000), ("base", 50, 1500), ("subgrade", 15, 300)))
FITTED = f'schema = 1\n{SECTION}[data]\nmisfit = "weighted"\nnoise_relative = {NOISE}\n{PARAMETERS}'
CRITERIA = """
[[criteria]]
name = "rutting"
law = "austroads-subgrade"
axle = "wheel"
traffic_per_year = 1.0e5
passed = 1e4
[[criteria]]
name = "cracking"
law = "asphalt-institute-fatigue"
axle = "wheel"
traffic_per_year = 1.0e5
passed = 1e4
"""
REQUIRED = 1e4 + 20 * 1e5


def read_at(moduli, extra=0.0):
    """Deflections [mm], and the lives of both criteria by the laws, of a section with so much more asphalt [mm]."""
    at = [("fwd", "deflection", x, 0) for x in OFFSETS] + [("wheel", "strain_zz", 0, 400 + extra), ("wheel", "strain_xx", 0, 99.99 + extra)]
    outputs = "".join(f'[[outputs]]\nname = "{load}{quantity}{x}"\nload = "{load}"\nquantity = "{quantity}"\nx_mm = {x}\ndepth_mm = {depth}\n' for load, quantity, x, depth in at)
    path = folder / "forward.toml"
    path.write_text("schema = 1\n" + SECTION.replace("thickness_mm = 100", f"thickness_mm = {100 + extra}") + outputs)
    done = run("forward", path, "--json", *[part for name, value in moduli.items() for part in ("--set", f"{name}.modulus_MPa={value!r}")])
    assert done.returncode == 0, done.stderr
    values = [r["value"] for r in json.loads(done.stdout)["responses"]]
    cracking = 18.4 * 0.004325 * 10 ** (4.84 * (11 / 15.5 - 0.69)) * (-values[-1] * 1e-6) ** -3.291 * (145.0377377 * moduli["asphalt"]) ** -0.854
    return values[:-2], {"rutting": (9150 / values[-2]) ** 7, "cracking": cracking}


def surveyed(command, study):
    out = folder / command
    done = run(command, folder / "road.csv", "--study", study, "--json", "--out", out)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout), out


@pytest.fixture(scope="module")
def road():
    lines = ["station,chainage_m,latitude,longitude,drop,radius_mm,pressure_kPa," + ",".join(f"D{x}_um" for x in OFFSETS)]
    for i, truth in enumerate(TRUTHS):
        bowl, _ = read_at(truth)
        lines.append(f"S{i},{100 * i},{47 + 0.001 * i},8.5,1,150,700," + ",".join(f"{1000 * d:.4f}" for d in bowl))
    (folder / "road.csv").write_text("\n".join(lines) + "\n")
    study = folder / "section.toml"
    study.write_text(FITTED + CRITERIA)
    return surveyed("survey", study)


def fitted(station):
    return {name.split(".")[0]: value for name, value in station["fit"]["parameters"].items()}


def test_lives_are_the_laws_at_the_fit(road):
    answer, _ = road
    for station, truth in zip(answer["stations"], TRUTHS):
        _, lives = read_at(fitted(station))
        for name, life in lives.items():
            found = station["lives"]["criteria"][name]
            assert math.isclose(found["allowable"], life, rel_tol=1e-3), f"{station['station']} {name}"
            assert math.isclose(found["years"], max(0, life - 1e4) / 1e5, rel_tol=2e-3), f"{station['station']} {name}"
            assert found["allowable_low"] <= read_at(truth)[1][name] <= found["allowable_high"], "the readings are without noise"
        first = min(lives, key=lives.get)
        assert station["lives"]["ends_first"] == first and station["lives"]["years"] == station["lives"]["criteria"][first]["years"]


def test_ranges_are_to_first_order(road):
    """g' (J'J)^-1 g, by central differences of forward runs in the logarithms of the moduli."""
    answer, _ = road
    station = answer["stations"][1]
    here = fitted(station)
    rows, slopes = [], {"rutting": [], "cracking": []}
    step = 0.01
    for name in here:
        up, lives_up = read_at({**here, name: here[name] * math.exp(step)})
        down, lives_down = read_at({**here, name: here[name] * math.exp(-step)})
        rows.append([(math.log(u) - math.log(d)) / (2 * step) / NOISE for u, d in zip(up, down)])
        for law in slopes:
            slopes[law].append((math.log(lives_up[law]) - math.log(lives_down[law])) / (2 * step))
    normal = [[sum(a * b for a, b in zip(p, q)) for q in rows] for p in rows]
    for law, g in slopes.items():
        solved = solve(normal, g)
        half = 1.959964 * math.sqrt(sum(a * b for a, b in zip(g, solved)))
        found = station["lives"]["criteria"][law]
        assert math.isclose(math.log(found["allowable_high"] / found["allowable"]), half, rel_tol=0.03), law
        assert math.isclose(math.log(found["allowable"] / found["allowable_low"]), half, rel_tol=0.03), law


def solve(matrix, right):
    """Gauss's elimination."""
    rows = [[*row, value] for row, value in zip(matrix, right)]
    n = len(rows)
    for i in range(n):
        for k in range(i + 1, n):
            factor = rows[k][i] / rows[i][i]
            rows[k] = [a - factor * b for a, b in zip(rows[k], rows[i])]
    found = [0.0] * n
    for i in reversed(range(n)):
        found[i] = (rows[i][n] - sum(rows[i][k] * found[k] for k in range(i + 1, n))) / rows[i][i]
    return found


def test_an_overlay_lasts_by_a_forward_run(road):
    answer, _ = road
    station = min(answer["stations"], key=lambda s: s["lives"]["years"])
    assert station["station"] == "S4", "the weakest subgrade"
    overlay = station["lives"]["overlay_mm"]
    assert 0 < overlay["value"] < overlay["at_reliability"] < overlay["high"] and overlay["low"] < overlay["value"]
    _, lives = read_at(fitted(station), overlay["value"])
    assert 0.98 * REQUIRED <= min(lives.values()) <= 1.15 * REQUIRED, "no thicker than needed, to half a millimetre"
    # At a reliability: as many more repetitions as the life may be shorter.
    _, lives = read_at(fitted(station), overlay["at_reliability"])
    margins = []
    for name, life in lives.items():
        c = station["lives"]["criteria"][name]
        margins.append(life / (REQUIRED * (c["allowable"] / c["allowable_low"]) ** (1.644854 / 1.959964)))
    assert 0.98 <= min(margins) <= 1.15, margins


def test_tables_and_maps_have_them(road):
    answer, out = road
    rows = list(csv.DictReader((out / "survey.csv").open()))
    points = json.loads((out / "survey.geojson").read_text())["features"]
    for station, row, point in zip(answer["stations"], rows, points):
        lives = station["lives"]
        assert float(row["rutting years"]) == lives["criteria"]["rutting"]["years"] and row["ends_first"] == lives["ends_first"]
        assert float(row["overlay_mm at 95 %"]) == lives["overlay_mm"]["at_reliability"]
        assert point["properties"]["years"] == lives["years"] and point["properties"]["overlay_mm"] == lives["overlay_mm"]["value"]
    text = (out / "survey.txt").read_text()
    assert "Life and overlay" in text and "The life ends first at S4" in text
    done = run("plot", out, "back-calculation")
    assert done.returncode == 0, done.stderr
    drawn = list(csv.DictReader((out / "figures" / "data" / "back-calculation.csv").open()))
    assert drawn[0]["quantity"] == "years", "the first strip"


def test_a_section_has_what_most_of_its_stations_have(road):
    answer, _ = road
    section = answer["sections"][0]
    inside = [s["lives"] for s in answer["stations"] if section["from_m"] <= 100 * int(s["station"][1:]) <= section["to_m"]]
    assert section["life"]["stations"] == len(inside)

    def share(values, part):
        values = sorted(values)
        at = part * (len(values) - 1)
        low = int(at)
        return values[low] + (at - low) * (values[min(low + 1, len(values) - 1)] - values[low])

    assert math.isclose(section["life"]["years"], share([s["years"] for s in inside], 0.15), rel_tol=1e-9)
    assert math.isclose(section["life"]["years_low"], share([s["years_low"] for s in inside], 0.15), rel_tol=1e-9)
    assert math.isclose(section["life"]["overlay_mm_at_reliability"], share([s["overlay_mm"]["at_reliability"] for s in inside], 0.85), rel_tol=1e-9)


def test_a_road_as_one_experiment_narrows_them(road):
    answer, _ = road
    study = folder / "together.toml"
    study.write_text((FITTED + CRITERIA).replace('name = "asphalt.modulus_MPa"\n', 'name = "asphalt.modulus_MPa"\nlevel = "shared"\n').replace(
        'name = "base.modulus_MPa"\n', 'name = "base.modulus_MPa"\nlevel = "shared"\n'))
    together, out = surveyed("road", study)
    for one, alone, truth in zip(together["stations"], answer["stations"], TRUTHS):
        for name in ("rutting", "cracking"):
            found, by_itself = one["lives"]["criteria"][name], alone["lives"]["criteria"][name]
            assert found["allowable_high"] / found["allowable_low"] < by_itself["allowable_high"] / by_itself["allowable_low"]
            assert found["allowable_low"] <= read_at(truth)[1][name] <= found["allowable_high"]
    assert "rutting years" in (out / "road.csv").read_text().splitlines()[0]


def test_a_survey_says_what_is_wrong_with_its_criteria(road):
    study = folder / "fault.toml"
    study.write_text(FITTED + CRITERIA.replace('axle = "wheel"', 'axle = "lorry"', 1))
    done = run("survey", folder / "road.csv", "--study", study, "--out", folder / "fault")
    assert done.returncode == 2 and done.stderr.count("\n") == 1 and "lorry" in done.stderr, done.stderr
