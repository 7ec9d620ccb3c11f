"""pavescape design: what it prints, its JSON, what is wrong in a study's criteria, the overlay by a forward run of its own."""
import csv
import json
import math

import pytest

from support import *

folder = workspace()
LAYERS = "\n".join(f'[[layers]]\nname = "{name}"\n{thickness}density_kg_m3 = 2200\nk0 = 0.5\nlaw = "linear"\nmodulus_MPa = {modulus}\npoisson = {poisson}\n'
                   for name, thickness, modulus, poisson in (("asphalt", "thickness_mm = 150\n", 3500, 0.35), ("base", "thickness_mm = 350\n", 320, 0.35), ("subgrade", "", 80, 0.4)))
LINEAR = f"""schema = 1
[section]
bottom = "half-space"
{LAYERS}
[[loads]]
name = "fwd"
type = "plate"
radius_mm = 150
pressure_kPa = 650
[[loads]]
name = "axle"
type = "dual-wheel"
force_kN = 40
pressure_kPa = 750
spacing_mm = 330
patch = "circle"
[data]
files = ["bowl.csv"]
misfit = "weighted"
""" + "".join(f'[[parameters]]\nname = "{name}.modulus_MPa"\nmin = {low}\nmax = {high}\nscale = "log"\n'
              for name, low, high in (("asphalt", 800, 15000), ("base", 60, 1600), ("subgrade", 20, 320)))
BOWL = """load,quantity,x_mm,y_mm,depth_mm,gauge_mm,value,unit,sigma
fwd,deflection,0,0,0,0,0.4308,mm,0.0086
fwd,deflection,200,0,0,0,0.3610,mm,0.0072
fwd,deflection,300,0,0,0,0.3196,mm,0.0064
fwd,deflection,600,0,0,0,0.2296,mm,0.0046
fwd,deflection,900,0,0,0,0.1733,mm,0.0035
fwd,deflection,1500,0,0,0,0.1093,mm,0.0022
"""
RUTTING = """
[[criteria]]
name = "rutting"
law = "austroads-subgrade"
axle = "axle"
traffic_per_year = 1.0e6
growth = 0.03
passed = 2e6
"""
CRACKING = """
[[criteria]]
name = "cracking"
law = "asphalt-institute-fatigue"
axle = "axle"
traffic_per_year = 1.0e6
growth = 0.03
passed = 2e6
"""
SN = """
[[criteria]]
name = "serviceability"
law = "aashto-sn"
axle = "fwd"
traffic_per_year = 1.0e6
"""
SEASON = """
[[seasons]]
name = "wet"
share = 1
factors = { subgrade = 0.6 }
"""
OWN = """
[[criteria]]
name = "own"
law = "expression"
place = "subgrade-top"
life = "(9150 / strain)^7"
axle = "axle"
traffic_per_year = 1.0e6
growth = 0.03
passed = 2e6
"""


def written(name, criteria):
    (folder / "bowl.csv").write_text(BOWL)
    path = folder / f"{name}.toml"
    path.write_text(LINEAR + criteria)
    return path


study = written("road", RUTTING + CRACKING + SN + OWN)


@pytest.fixture(scope="module")
def answer():
    done = run("design", study, "--json", "--out", folder / "out")
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_keys_and_ranges(answer):
    assert answer["status"] == "converged" and (folder / "out" / "design.json").exists()
    assert [c["name"] for c in answer["criteria"]] == ["rutting", "cracking", "serviceability", "own"]
    for c in answer["criteria"]:
        assert c["allowable_low"] <= c["allowable"] <= c["allowable_high"], c["name"]
        assert c["low"] <= c["remaining_years"] <= c["high"], c["name"]
        assert math.isclose(c["remaining"], max(0, c["allowable"] - c["passed"]), rel_tol=1e-9), c["name"]
    assert math.isclose(sum(answer["governs"].values()), 1, abs_tol=1e-9)
    assert set(answer["overlay_mm"]) >= {"value", "low", "high", "at_reliability"}


def test_an_expression_is_the_guide_s_law(answer):
    rutting, own = answer["criteria"][0], answer["criteria"][3]
    for key in ("strain_microstrain", "allowable", "remaining_years"):
        assert math.isclose(rutting[key], own[key], rel_tol=1e-9), key


def values_of(answer):
    return [part for name, value in answer["best"]["parameters"].items() for part in ("--set", f"{name}={value!r}")]


def test_strains_are_those_of_a_forward_run(answer):
    # The place that was found, as an output of a study of its own; nowhere across the wheels is the strain larger.
    place = answer["criteria"][0]["place"]
    outputs = "".join(f'[[outputs]]\nname = "x{x}"\nload = "axle"\nquantity = "strain_zz"\nx_mm = {x}\ndepth_mm = 500\n' for x in [place["x_mm"], *range(0, 300, 20)])
    forward = json.loads(run("forward", written("check", outputs), "--json", *values_of(answer)).stdout)
    strains = [r["value"] for r in forward["responses"][6:]]
    assert math.isclose(strains[0], answer["criteria"][0]["strain_microstrain"], rel_tol=1e-6)
    assert max(strains) <= 1.005 * strains[0], "the largest strain is found to half a percent"
    assert math.isclose(answer["criteria"][0]["allowable"], (9150 / strains[0]) ** 7, rel_tol=1e-5)


def test_ends_are_those_of_walks_by_the_full_model(answer):
    """The subgrade's strain as an output of `unique`, whose every step is a full run; a law without a modulus follows it."""
    assert answer["strains_from_between"]["runs"] >= 7 and answer["strains_from_between"]["off"] <= 0.02
    rutting = answer["criteria"][0]
    place = rutting["place"]
    walked = written("walked", f'[[outputs]]\nname = "s"\nload = "axle"\nquantity = "strain_zz"\nx_mm = {place["x_mm"]}\ndepth_mm = 500\n')
    done = run("unique", walked, "--json", "--out", folder / "walked")
    assert done.returncode == 0, done.stderr
    strain = json.loads(done.stdout)["outputs"][0]
    for end, other in (("low", "high"), ("high", "low")):
        life = (9150 / strain[other]) ** 7
        assert math.isclose(rutting[f"allowable_{end}"], life, rel_tol=0.05), f"{end}: {rutting[f'allowable_{end}']:.4g} and {life:.4g}"


def test_the_distribution_is_that_of_the_range(answer):
    for c in answer["criteria"]:
        lives = [p["allowable"] for p in c["distribution"]]
        chances = [p["probability"] for p in c["distribution"]]
        assert chances == sorted(chances) and lives == sorted(lives), c["name"]
        assert math.isclose(chances[0], 0.025, abs_tol=2e-3) and math.isclose(lives[0], c["allowable_low"], rel_tol=1e-9), c["name"]
        assert math.isclose(chances[-1], 0.975, abs_tol=2e-3) and math.isclose(lives[-1], c["allowable_high"], rel_tol=1e-9), c["name"]


def test_figures_show_what_is_said(answer):
    done = run("plot", folder / "out", "life", "overlay")
    assert done.returncode == 0, done.stderr
    drawn = list(csv.DictReader((folder / "out" / "figures" / "data" / "life.csv").open()))
    assert [float(r["allowable"]) for r in drawn if r["criterion"] == "rutting"] == [p["allowable"] for p in answer["criteria"][0]["distribution"]]
    drawn = list(csv.DictReader((folder / "out" / "figures" / "data" / "overlay.csv").open()))
    mm = answer["overlay_mm"]
    assert [(float(r["reliability_percent"]), float(r["overlay_mm"])) for r in drawn] == [(2.5, mm["low"]), (50, mm["value"]), (95, mm["at_reliability"]), (97.5, mm["high"])]


def test_overlay_lasts_by_a_forward_run(answer):
    added = answer["overlay_mm"]["value"]
    assert added > 0, "an overlay is needed"

    def lives(extra):
        outputs = f'[[outputs]]\nname = "s"\nload = "axle"\nquantity = "strain_zz"\nx_mm = {answer["criteria"][0]["place"]["x_mm"]}\ndepth_mm = {500 + extra}\n'
        outputs += "".join(f'[[outputs]]\nname = "{q}{x}"\nload = "axle"\nquantity = "strain_{q}"\nx_mm = {x}\ndepth_mm = {149.99 + extra}\n' for q in ("xx", "yy") for x in (0, 73, 165))
        text = (LINEAR + outputs).replace("thickness_mm = 150", f"thickness_mm = {150 + extra}")
        path = folder / "thicker.toml"
        path.write_text(text)
        r = [r["value"] for r in json.loads(run("forward", path, "--json", *values_of(answer)).stdout)["responses"][6:]]
        psi = answer["best"]["parameters"]["asphalt.modulus_MPa"] * 145.0377
        fatigue = 18.4 * 0.004325 * 10 ** (4.84 * (11 / 15.5 - 0.69)) * (-min(r[1:]) * 1e-6) ** -3.291 * psi ** -0.854
        return (9150 / r[0]) ** 7, fatigue

    required = 2e6 + 1e6 * (1.03 ** 20 - 1) / 0.03
    for name, life in zip(("rutting", "cracking"), lives(added)):
        assert life >= 0.98 * required, f"{name}: {life:.3g} of {required:.3g} with {added:.1f} mm"


def test_the_page_is_short(answer):
    done = run("design", study, "--out", folder / "out")
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert len(lines) <= 25 and "years are left" in lines[0], done.stdout
    assert max(map(len, lines)) <= 80 and "Next: " in done.stdout, done.stdout


def test_options_and_repetition(answer):
    surer = json.loads(run("design", study, "--json", "--out", folder / "out", "--reliability", 90).stdout)
    assert surer["overlay_mm"]["at_reliability"] <= answer["overlay_mm"]["at_reliability"]
    assert surer["computed"] == 0, "the walks are in the store"


def test_a_season_is_softer_all_over_the_answer(answer):
    wet = json.loads(run("design", written("wet", RUTTING + SEASON), "--json", "--out", folder / "wet").stdout)
    assert wet["seasons"] == [{"name": "wet", "share": 1, "factors": {"asphalt": 1, "base": 1, "subgrade": 0.6}}]
    c, dry = wet["criteria"][0], answer["criteria"][0]
    values = dict(wet["best"]["parameters"])
    values["subgrade.modulus_MPa"] *= 0.6
    outputs = f'[[outputs]]\nname = "s"\nload = "axle"\nquantity = "strain_zz"\nx_mm = {c["place"]["x_mm"]}\ndepth_mm = 500\n'
    forward = json.loads(run("forward", written("softer", outputs), "--json", *[part for name, value in values.items() for part in ("--set", f"{name}={value!r}")]).stdout)
    assert math.isclose(c["allowable"], (9150 / forward["responses"][-1]["value"]) ** 7, rel_tol=1e-4)
    assert c["allowable"] < 0.5 * dry["allowable"] and math.isclose(c["strain_microstrain"], dry["strain_microstrain"], rel_tol=1e-3)
    assert c["allowable_low"] < c["allowable"] < c["allowable_high"]


def test_what_would_decide_has_a_price(answer):
    steps = answer["next"]
    assert [s["left"] for s in steps] == sorted(s["left"] for s in steps) and 0 < steps[0]["left"] < 1
    mm = answer["overlay_mm"]
    cost = max(0, mm["at_reliability"]) - max(0, mm["value"])
    assert math.isclose(mm["cost_of_what_is_open"], cost, abs_tol=1e-9)
    assert math.isclose(steps[0]["overlay_saved_mm"], cost * (1 - steps[0]["left"]), abs_tol=1e-9)


FAULTS = {
    "no criteria": ("", "criteria"),
    "no traffic": (RUTTING.replace("1.0e6", "0"), "traffic_per_year"),
    "no axle": (RUTTING.replace('axle = "axle"', 'axle = "lorry"'), "axle"),
    "unknown law": (RUTTING.replace("austroads-subgrade", "austroads-subgrad"), "did you mean"),
    "no such layer": (RUTTING + 'layer = "subbase"\n', "layer"),
    "fatigue of no bound layer": (CRACKING + 'layer = "subgrade"\n', "bound layer"),
    "deformation of the top layer": (RUTTING + 'layer = "asphalt"\n', "others cover"),
    "unreadable expression": (OWN.replace("strain)", "stran)"), "life"),
    "an expression without a place": (OWN.replace('place = "subgrade-top"\n', ""), "place"),
    "a key of another law": (RUTTING + "air_voids_percent = 5\n", "air_voids_percent"),
    "a mix without its strength": (CRACKING.replace("asphalt-institute-fatigue", "french-fatigue"), "epsilon_6_microstrain"),
    "twice": (RUTTING + RUTTING, "twice"),
    "a plate's law under an axle": (SN.replace('axle = "fwd"', 'axle = "axle"'), "plate"),
    "a year of shares": (RUTTING + SEASON.replace("share = 1", "share = 0.7"), "add up"),
    "a season of no layer": (RUTTING + SEASON.replace("subgrade", "subgrad"), "did you mean"),
    "a season twice": (RUTTING + (SEASON * 2).replace("share = 1", "share = 0.5"), "twice"),
    "a temperature and a factor": (RUTTING + SEASON.replace("subgrade", "asphalt") + "asphalt_C = 30\ntested_C = 20\n", "one of the two"),
    "a temperature from nowhere": (RUTTING + SEASON + "asphalt_C = 30\n", "tested_C"),
    "a thickness that is sought": ('[[parameters]]\nname = "base.thickness_mm"\nmin = 200\nmax = 400\n' + RUTTING, "thickness"),
}


@pytest.mark.parametrize("name", FAULTS)
def test_one_line_says_what_is_wrong(name):
    criteria, word = FAULTS[name]
    done = run("design", written("fault", criteria), "--out", folder / "fault")
    assert done.returncode == 2, f"{name}: exit status {done.returncode}: {done.stderr}"
    assert done.stdout == "" and done.stderr.count("\n") == 1, f"{name}: {done.stderr}"
    assert word in done.stderr and "fault.toml" in done.stderr, f"{name}: {done.stderr}"


def test_strains_outside_a_law_are_said():
    heavy = written("heavy", RUTTING.replace("austroads-subgrade", "irc37-rutting-80")).read_text().replace(
        "force_kN = 40\npressure_kPa = 750", "force_kN = 200\npressure_kPa = 3000")
    (folder / "heavy.toml").write_text(heavy)
    done = run("design", folder / "heavy.toml", "--out", folder / "heavy")
    assert done.returncode == 0 and "extrapolated" in done.stdout, done.stdout + done.stderr
    assert "< 2e6" in done.stdout, "a life below the law is no number: " + done.stdout
    said = json.loads((folder / "heavy" / "design.json").read_text())["criteria"][0]
    assert "allowable" in said["beyond_law"] and said["allowable_if_wrong"]["low"] is None, said


def test_a_strain_has_its_range_whatever_the_law_reads_beside_it():
    """A law of strain and modulus: softer asphalt is strained more and lasts longer by it. The strain's range is that of a law of strain alone."""
    both = written("both", OWN.replace('"own"', '"strain"').replace('"subgrade-top"', '"asphalt-bottom"')
                   + OWN.replace('"own"', '"modulus"').replace('"subgrade-top"', '"asphalt-bottom"').replace('"(9150 / strain)^7"', '"(9150 / strain)^5 * (3000 / modulus)^7"'))
    done = run("design", both, "--json", "--out", folder / "both")
    assert done.returncode == 0, done.stderr
    alone, with_modulus = json.loads(done.stdout)["criteria"]
    for key in ("strain_low", "strain_high"):
        assert math.isclose(with_modulus[key], alone[key], rel_tol=2e-3), (key, alone[key], with_modulus[key])
    assert with_modulus["strain_low"] < 0.99 * with_modulus["strain_microstrain"] < with_modulus["strain_high"]


def test_seasons_are_read_with_the_study():
    broken = written("season", RUTTING + SEASON.replace("share = 1", "share = -5"))
    for command in (["check"], ["forward"], ["fit", "--out", folder / "season"]):
        done = run(command[0], broken, *command[1:])
        assert done.returncode == 2 and "share" in done.stderr, (command, done.stderr)
    assert not (folder / "season").exists()
