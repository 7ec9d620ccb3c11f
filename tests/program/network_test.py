"""A road of eight stations or more is searched by one reduced model; its answers are those of the full model, which fits fewer by itself."""
import functools
import json
import math
import random

import pytest

from support import *

folder = workspace()
OFFSETS = (0, 200, 300, 450, 600, 900)
PRESSURES = (400, 700)
HEADER = "station,chainage_m,drop,radius_mm,pressure_kPa," + ",".join(f"D{o}_um" for o in OFFSETS)
SECTION = STUDY[:STUDY.index("[data]")].replace("thickness_mm = 40", "thickness_mm = 80")
PARAMETERS = {"base.k1": (300, 10000, "log"), "base.k2": (0.05, 1, "linear"), "subgrade.modulus_MPa": (20, 300, "log")}
SURVEY = SECTION + """[data]
misfit = "weighted"
[data.noise]
relative = 0.01
absolute = { um = 1 }
""" + "".join(f'[[parameters]]\nname = "{name}"\nmin = {low}\nmax = {high}\nscale = "{scale}"\n' for name, (low, high, scale) in PARAMETERS.items())
study = write_study(folder, SURVEY, None, "survey")
chance = random.Random(7)


def bowl(k1, subgrade, pressure):
    """Deflections in um with noise as the study states it, by the program's own forward run."""
    text = SECTION.replace("k1 = 2000", f"k1 = {k1}").replace("modulus_MPa = 45", f"modulus_MPa = {subgrade}")
    text = text.replace("pressure_kPa = 600", f"pressure_kPa = {pressure}")
    for offset in OFFSETS:
        text += f'[[outputs]]\nname = "D{offset}"\nload = "fwd"\nquantity = "deflection"\nx_mm = {offset}\n'
    done = run("forward", write_study(folder, text, None, "truth"), "--json")
    assert done.returncode == 0, f"forward: {done.stderr}"
    exact = [1e3 * r["value"] for r in json.loads(done.stdout)["responses"]]
    return [d + math.hypot(0.01 * d, 1.0) * chance.gauss(0, 1) for d in exact]


@functools.cache
def drops():
    """The rows of nine stations."""
    rows = []
    for i in range(9):
        k1, subgrade = 2500 * 2 ** chance.uniform(-1, 1), 50 * 2 ** chance.uniform(-1, 1)
        for drop, pressure in enumerate(PRESSURES, 1):
            pressure += chance.uniform(-10, 10)
            cells = [f"{d:.3f}" for d in bowl(k1, subgrade, pressure)]
            if i == 8:
                cells[-1] = ""  # the last station has lost a sensor
            rows.append([f"P{i}", 25 * i, drop, 150, f"{pressure:.1f}", *cells])
    return rows


def surveyed(stations, name, *options):
    road = folder / f"{name}.csv"
    road.write_text(HEADER + "\n" + "\n".join(",".join(map(str, r)) for r in drops() if r[0] in stations) + "\n")
    done = run("survey", road, "--study", study, "--out", folder / name, "--json", *options)
    assert done.returncode == 0, f"survey of {name}: {done.stderr}"
    return json.loads(done.stdout)


@pytest.fixture(scope="module")
def whole():
    return surveyed({f"P{i}" for i in range(9)}, "whole", "--threads", 1)


def test_eight_stations_share_one_reduced_model(whole):
    said = [f for f in whole["findings"] if "reduced model" in f]
    assert len(said) == 1 and said[0].startswith("8 stations"), f"eight stations share a model, the ninth has other sensors: {said}"
    assert (folder / "whole" / "reduced.bin").exists(), "the reduced model is kept"
    with sqlite3.connect(folder / "whole" / "run.sqlite") as store:
        counts = [n for n, in store.execute("SELECT count(*) FROM run JOIN evaluation ON run = id WHERE settings LIKE '%, confirmed' GROUP BY id")]
    assert len(counts) == 8 and sorted(counts)[4] <= 4, f"the full model starts where the reduced one ended: {counts} evaluations"


def test_answers_are_those_of_the_full_model_alone(whole):
    alone = [s for part in (range(5), range(5, 9)) for s in (surveyed({f"P{i}" for i in part}, f"part-{part[0]}")["stations"])]
    compared = 0
    for together, own in zip(whole["stations"], alone):
        assert together["station"] == own["station"] and together["fit"]["starts"] == own["fit"]["starts"], f"{own['station']}: searches"
        for name, p in own["parameters"].items():
            if p["determined"]:
                compared += 1
                error = (p["high"] - p["low"]) / (2 * 1.96)
                assert abs(together["parameters"][name]["value"] - p["value"]) < 0.2 * error, \
                    f"{own['station']}: {name} {together['parameters'][name]['value']} by the shared model, {p['value']} +- {error} without"
    assert compared >= 12, f"{compared} parameters are determined"


def test_two_threads_and_a_second_call_give_the_same_bits(whole):
    # The same bits for two threads, and again from what is kept.
    for options in (("--threads", 2), ()):
        if options:
            (folder / "whole").rename(folder / "one-thread")
        again = surveyed({f"P{i}" for i in range(9)}, "whole", *options)
        assert again == whole, f"{options}: other bits"
