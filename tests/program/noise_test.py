"""The noise of FWD readings as a user meets it: drops made up here with a covariance that is known, in a file; what is
printed goes into a study as it stands."""
import json
import math
import random

import pytest

from support import *

folder = workspace()
OFFSETS = (0, 200, 300, 450, 600, 900, 1200)
RELATIVE, COMMON, CORRELATION_MM = 0.012, 0.006, 400.0
STATIONS, DROPS = 120, 4
draw = random.Random(5)


def errors():
    """One drop's: a common part, and a chain along the sensors (Gauss and Markov), whose correlation is exp(-distance / length)."""
    common = COMMON * draw.gauss(0, 1)
    own, last, at = [], None, 0.0
    for offset in OFFSETS:
        rho = 0.0 if last is None else math.exp(-(offset - at) / CORRELATION_MM)
        last = draw.gauss(0, 1) if last is None else rho * last + math.sqrt(1 - rho * rho) * draw.gauss(0, 1)
        own.append(common + RELATIVE * last)
        at = offset
    return own


rows = ["station,chainage_m,drop,radius_mm,pressure_kPa," + ",".join(f"D{o}_um" for o in OFFSETS)]
for station in range(STATIONS):
    for drop in range(DROPS):
        pressure = 600 + 5 * drop
        readings = [pressure * math.exp(-offset / 800 + e) for offset, e in zip(OFFSETS, errors())]
        rows.append(",".join(map(str, [station, 10 * station, drop + 1, 150, pressure, *readings])))
road = folder / "road.csv"
road.write_text("\n".join(rows) + "\n")


@pytest.fixture(scope="module")
def told_of_road():
    done = run("noise", road, "--json")
    assert done.returncode == 0 and done.stderr == "", done.stderr
    told = json.loads(done.stdout)
    return done, told


def test_the_noise_that_the_drops_have_is_found(told_of_road):
    _, told = told_of_road
    assert (told["stations"], told["drops"]) == (STATIONS, STATIONS * DROPS), "every drop counts"
    for key, truth in (("relative", RELATIVE), ("common_relative", COMMON), ("correlation_mm", CORRELATION_MM)):
        part = told["noise"][key]
        # Within twice its 95 % range, on the logarithm.
        half = math.log(part["high"] / part["low"]) / 2
        assert abs(math.log(part["value"] / truth)) < 2 * half, f"{key} is {truth}: {part}"
    total = math.hypot(RELATIVE, COMMON)
    assert all(abs(s["scatter"] / total - 1) < 4 / math.sqrt(2 * STATIONS * (DROPS - 1)) for s in told["sensors"]), "scatter of each sensor"


def test_the_block_goes_into_a_study_as_it_stands(told_of_road):
    done, told = told_of_road
    same = run("noise", road, "--json")
    assert same.stdout == done.stdout, "the same bits again"
    page = run("noise", road)
    assert page.returncode == 0 and told["block"] in page.stdout, "the page ends with what goes into a study"

    study = STUDY.replace('misfit = "log"', 'misfit = "weighted"\n' + told["block"])
    pasted = run("check", write_study(folder, study))
    assert pasted.returncode == 0, f"a study takes it: {pasted.stderr}"


def test_a_road_without_repeated_drops_is_refused():
    single = folder / "single.csv"
    single.write_text("\n".join(rows[:1] + rows[1::DROPS]) + "\n")
    refused = run("noise", single)
    assert refused.returncode == 2 and refused.stdout == "" and "no drop is repeated" in refused.stderr, refused.stderr
    assert run("noise", folder / "missing.csv").returncode == 2, "a file that is not there"


def test_what_is_left_out_is_said():
    # In one drop a sensor reads eighteen times what its repeats read: the drop goes, with all its sensors.
    changed = list(rows)
    cells = changed[2].split(",")
    cells[-1] = repr(18 * float(cells[-1]))
    changed[2] = ",".join(cells)
    spiked = folder / "spiked.csv"
    spiked.write_text("\n".join(changed) + "\n")
    done = run("noise", spiked, "--json")
    assert done.returncode == 0, done.stderr
    told = json.loads(done.stdout)
    assert told["drops"] == STATIONS * DROPS - 1, told["drops"]
    words, = told["left_out"]
    assert words.startswith("0: drop 2, all its sensors, for it reads ") and f"{float(cells[-1]):.1f} um at 1200 mm, its repeats " in words, words
    assert any(words in text for text in told["findings"]), told["findings"]
