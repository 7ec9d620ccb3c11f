"""`pavescape slab`: concrete slabs from bowls that an independent integration (SciPy) of the plate equation makes."""
import json
import math

import pytest
from scipy.integrate import quad
from scipy.special import j0, j1

from support import *

folder = workspace()
RADIUS, PRESSURE = 0.15, 700e3
OFFSETS = (0, 200, 300, 600, 900, 1200, 1500)
HEADER = "station,chainage_m,drop,pressure_kPa,radius_mm," + ",".join(f"D{o}_um" for o in OFFSETS)
THICKNESS, CONCRETE, POISSON = 0.25, 32e9, 0.15
RIGIDITY = CONCRETE * THICKNESS ** 3 / (12 * (1 - POISSON ** 2))


def deflection(foundation, stiffness, x, pressure=PRESSURE):
    """um; stiffness: k in Pa/m, or E0/(2 (1 - nu^2)) in Pa"""
    l = (RIGIDITY / stiffness) ** (1 / 4 if foundation == "liquid" else 1 / 3)

    def integrand(t):
        bessel = j0(t * x / l) * j1(t * RADIUS / l)
        return bessel / (1 + t ** 4) if foundation == "liquid" else bessel / (t * (1 + t ** 3))

    whole = sum(quad(integrand, a, b, limit=300, epsabs=1e-12)[0] for a, b in ((1e-12, 2), (2, 8), (8, 60)))
    return 1e6 * pressure / stiffness * (RADIUS / l if foundation == "liquid" else RADIUS) * whole


def write(name, stations):
    """[(station, [(pressure, bowl)])]"""
    rows = [f"{station},{10 * i},{drop + 1},{p / 1e3:.1f},{1e3 * RADIUS:g}," + ",".join(f"{d:.3f}" for d in bowl)
            for i, (station, drops) in enumerate(stations) for drop, (p, bowl) in enumerate(drops)]
    path = folder / f"{name}.csv"
    path.write_text("\n".join([HEADER, *rows]) + "\n")
    return path


def bowl(foundation, stiffness, pressure=PRESSURE, void=0.0):
    return [deflection(foundation, stiffness, o / 1e3, pressure) + void for o in OFFSETS]


def slab(path, *options, code=0):
    done = run("slab", path, "--thickness", 250, "--json", *options)
    assert done.returncode == code, done.stderr
    return json.loads(done.stdout)


def test_a_slab_on_a_liquid_has_its_k_and_its_modulus():
    found = slab(write("liquid", [("S1", [(PRESSURE, bowl("liquid", 60e6))]), ("S2", [(PRESSURE, bowl("liquid", 120e6))])]))
    for station, k in zip(found["stations"], (60, 120)):
        assert math.isclose(station["k_MPa_per_m"]["value"], k, rel_tol=1e-3), station
        assert math.isclose(station["slab_MPa"]["value"], CONCRETE / 1e6, rel_tol=2e-3), station
        assert math.isclose(station["stiffness_radius_mm"]["value"], 1e3 * (RIGIDITY / k / 1e6) ** 0.25, rel_tol=1e-3), station
        assert math.isclose(station["by_area"]["k_MPa_per_m"], k, rel_tol=1e-3), "AREA and D0 say the same of an exact bowl"
        assert station["rms_percent"] < 0.05, station
    assert found["findings"][0].startswith("Modulus of subgrade reaction k at 2 slabs"), found["findings"]


def test_a_slab_on_a_solid_has_its_modulus_and_the_liquid_does_not_fit_it():
    e0, nu = 90e6, 0.45
    path = write("solid", [("S1", [(PRESSURE, bowl("solid", e0 / (2 * (1 - nu ** 2))))])])
    found = slab(path, "--foundation", "solid")["stations"][0]
    assert math.isclose(found["foundation_MPa"]["value"], 90, rel_tol=1e-3) and math.isclose(found["slab_MPa"]["value"], CONCRETE / 1e6, rel_tol=3e-3), found
    assert slab(path)["stations"][0]["rms_percent"] > 20 * found["rms_percent"], "the other foundation leaves more"


def test_a_joint_transfers_what_it_does():
    middle = bowl("liquid", 80e6)
    beyond = [1.6 * d if o < 300 else 0.55 * 1.6 * d for o, d in zip(OFFSETS, middle)] # 55 % of what the loaded side does
    found = slab(write("joint", [("S1", [(PRESSURE, middle)]), ("J1", [(PRESSURE, beyond)])]), "--joints", "J1")
    joint = found["stations"][1]
    assert joint["joint"] and "slab_MPa" not in joint and math.isclose(joint["load_transfer_percent"], 55, rel_tol=1e-3), joint
    assert any("Load transfer at J1: 55 %, which is low" in f for f in found["findings"]), found["findings"]


def test_a_void_shows_in_the_line_through_the_levels():
    levels = [(p, bowl("liquid", 80e6, p, void=70.0)) for p in (400e3, 550e3, 700e3)]
    sound = [(p, bowl("liquid", 80e6, p)) for p in (400e3, 550e3, 700e3)]
    found = slab(write("void", [("V1", levels), ("S1", sound)]))
    hollow, solid = found["stations"]
    assert math.isclose(hollow["intercept_um"], 70, abs_tol=0.5) and abs(solid["intercept_um"]) < 0.5, found["stations"]
    assert any(f.startswith("A void is suspected under V1:") for f in found["findings"]), found["findings"]


# By hand, for a bowl whose l by AREA is 900 mm: a slab of 4.5 by 3.6 m has L = 4025 mm, L/l = 4.472, and
# l 900 (1 - 0.89434 exp(-0.61662 4.472^1.04831)) = 900 (1 - 0.89434 exp(-2.9645)) = 900 (1 - 0.04613) = 858.5 mm,
# D0 times 1 - 1.15085 exp(-0.71878 4.472^0.80151) = 1 - 1.15085 exp(-2.3878) = 0.8943. One of 9 by 3.6 m counts as 7.2.
def test_a_slab_that_ends_is_stiffer_than_it_looks():
    k = RIGIDITY / 0.9 ** 4
    path = write("finite", [("S1", [(PRESSURE, bowl("liquid", k))])])
    plain = slab(path)["stations"][0]["by_area"]
    found = slab(path, "--length", 4500, "--width", 3600)
    by_area = found["stations"][0]["by_area"]
    assert math.isclose(found["size_mm"], 4025, abs_tol=1), found
    assert math.isclose(plain["stiffness_radius_mm"], 900, abs_tol=1) and math.isclose(by_area["stiffness_radius_mm"], 858.5, abs_tol=1), by_area
    at_l = deflection("liquid", RIGIDITY / 0.8585 ** 4, 0) * RIGIDITY / 0.8585 ** 4  # D0 k of an infinite slab of that l
    assert math.isclose(by_area["k_MPa_per_m"], at_l / (0.8943 * deflection("liquid", k, 0)) / 1e6, rel_tol=2e-3), by_area
    assert math.isclose(by_area["slab_MPa"], by_area["k_MPa_per_m"] * 0.8585 ** 4 / (RIGIDITY / CONCRETE), rel_tol=5e-3), by_area
    assert any(f.startswith("As slabs of 4.5 by 3.6 m, by AREA: k") for f in found["findings"]), found["findings"]
    assert math.isclose(slab(path, "--length", 9000, "--width", 3600)["size_mm"], math.sqrt(7.2 * 3.6) * 1e3, rel_tol=1e-6)


# Deflections of square plates with free edges, by finite elements (w k / pressure; l = 900 mm, side 4 l and 5 l).
FREE_EDGES = {4: (0.0124959, 0.0121062, 0.0117012, 0.0101142, 0.0083159, 0.0065273, 0.0048361),
              5: (0.0119377, 0.0115515, 0.0111509, 0.0095865, 0.0078231, 0.0060801, 0.0044476)}


@pytest.mark.parametrize("side", FREE_EDGES)
def test_a_plate_with_free_edges_has_its_own_k_back(side):
    k = RIGIDITY / 0.9 ** 4
    path = write(f"free{side}", [("S1", [(PRESSURE, [1e6 * w * PRESSURE / k for w in FREE_EDGES[side]])])])
    infinite = slab(path)["stations"][0]["by_area"]
    finite = slab(path, "--length", 900 * side, "--width", 900 * side)["stations"][0]["by_area"]
    assert math.isclose(finite["stiffness_radius_mm"], 900, rel_tol=0.03), (infinite, finite)
    assert math.isclose(finite["k_MPa_per_m"], k / 1e6, rel_tol=0.06), (infinite, finite)
    assert abs(infinite["stiffness_radius_mm"] / 900 - 1) > abs(finite["stiffness_radius_mm"] / 900 - 1), (infinite, finite)


@pytest.mark.parametrize("options, said", [(("--length", "4500"), "--length"), (("--length", "4500", "--width", "3600", "--foundation", "solid"), "dense liquid"),
                                           (("--joints", "J9"), "no station has this name"), (("--thickness", "3"), "--thickness"),
                                           (("--foundation", "sand"), "--foundation")])
def test_bad_input_is_met_with_one_message(options, said):
    path = write("bad", [("S1", [(PRESSURE, bowl("liquid", 60e6))])])
    done = run("slab", path, *(() if "--thickness" in options else ("--thickness", 250)), *options)
    assert done.returncode == 2 and said in done.stderr, done.stderr


def test_the_page_is_narrow():
    done = run("slab", write("page", [("S1", [(PRESSURE, bowl("liquid", 60e6))])]), "--thickness", 250)
    assert done.returncode == 0 and all(len(line) <= 80 for line in done.stdout.splitlines()), done.stdout
