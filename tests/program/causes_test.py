"""What `diagnose` says where little is measured, where the noise is not as stated and where a size ends its range: no name that
the data do not bear, nothing left out that was not tried."""
import json
import math

import pytest

from support import *

folder = workspace()
LEVELS, OFFSETS = (400, 566, 800), (0, 300, 600, 900, 1500)
LOADS = "".join(f'[[loads]]\nname = "p{p}"\ntype = "plate"\nradius_mm = 150\npressure_kPa = {p}\n\n' for p in LEVELS)
PARAMETERS = "".join(f'[[parameters]]\nname = "{name}"\nmin = {low}\nmax = {high}\n\n'
                     for name, low, high in (("base.k1", 500, 8000), ("base.k2", 0, 1), ("subgrade.modulus_MPa", 15, 150)))
SECTION, _, REST = STUDY.replace("refine = 0.4", "refine = 0.25").replace('misfit = "log"', 'misfit = "weighted"').partition("[[loads]]")
DROPS = SECTION + LOADS + REST[REST.index("[mesh]"):REST.index("[[parameters]]")] + PARAMETERS
HEADER = DATA.splitlines()[1] + "\n"
BOWLS = HEADER + "".join(f"p{p},deflection,{x},0,0,0,1,mm,\n" for p in LEVELS for x in OFFSETS)


def made(name, noise, seed, *effects, layout=BOWLS, readings=lambda cells: cells, truth=DROPS):
    """A study whose readings a twin of the truth made, each as `readings` turns its cells."""
    place = folder / name
    twin = run("twin", write_study(place, truth, layout), "--noise", noise, "--seed", seed, *(o for e in effects for o in ("--effect", e)),
               "--out", place / "twin")
    assert twin.returncode == 0, twin.stderr
    rows = [line.split(",") for line in (place / "twin" / "twin.csv").read_text().splitlines() if line[0] not in "#l"]
    return write_study(place, DROPS, HEADER + "".join(",".join(readings(cells)) + "\n" for cells in rows))


def times(cells, value=1.0, sigma=1.0):
    return [*cells[:6], repr(float(cells[6]) * value), cells[7], repr(float(cells[8]) * sigma)]


def diagnose(study):
    done = run("diagnose", study, "--json", "--out", study.parent / "run", "--explore", 16, "--starts", 2, "--bootstrap", 4)
    assert done.returncode == 0, f"diagnose {study.parent.name}: {done.stderr}"
    found = json.loads(done.stdout)
    if any("biased" in s for s in found["findings"]):
        assert found["extended"]["p_value"] >= 0.05, f"no bias by a model that is rejected: {found['findings']}"
    print(f"{study.parent.name}: {found['verdict']} {found['causes']}")
    return found


@pytest.fixture(scope="module")
def few():
    # Fifteen readings and three parameters that follow much of them: every effect is fitted, and the true one is among those that explain the data.
    return diagnose(made("few", 0.01, 1, "weak-subgrade-top=0.7"))


def test_of_few_readings_the_true_cause_is_not_lost(few):
    assert few["verdict"] in ("cause-named", "ambiguous") and "weak-subgrade-top" in few["causes"], f"a soft top is not lost: {few['causes']}"
    untried = [c["effect"] for c in few["candidates"] if c["size"] is None and c["score_z"] is not None]
    assert not untried, f"every effect that changes a reading is fitted: {untried}"


@pytest.mark.skipif(sanitizer() is not None, reason="a sanitizer keeps memory of its own")
@pytest.mark.usefixtures("few")
def test_models_that_were_tried_are_let_go():
    # A diagnosis takes no more memory than a fit of the same study; and six drops not more than one.
    study = folder / "few" / "small.toml"
    options = ("--threads", 1, "--explore", 8, "--starts", 1)
    fit, found = peak_MB("fit", study, "--out", folder / "fit", *options), peak_MB("diagnose", study, "--out", folder / "again", *options, "--bootstrap", 1)
    assert found < fit + 12, f"memory of a diagnosis: {found:.0f} MB, of a fit: {fit:.0f} MB"
    drop = LOADS.split("[[loads]]")[1]
    drops = [drop.replace("400", str(400 + 80 * k)) for k in range(6)]
    one, six = (peak_MB("forward", "--jacobian", write_study(
        folder / f"drops-{count}", DROPS.replace(LOADS, "".join("[[loads]]" + d for d in drops[:count])).replace("refine = 0.25", "refine = 1"),
        HEADER + "".join(f"p{400 + 80 * k},deflection,{x},0,0,0,1,mm,\n" for k in range(count) for x in OFFSETS))) for count in (1, 6))
    assert six < one + 10, f"memory of six drops: {six:.0f} MB, of one: {one:.0f} MB"


def test_a_soft_top_of_another_thickness_is_not_lost():
    # A soft top thicker than the catalogue's 200 mm, far beyond noise.
    WHOLE = '[[layers]]\nname = "subgrade"\nthickness_mm = 1210'
    TOP = '[[layers]]\nname = "top"\nthickness_mm = 450\ndensity_kg_m3 = 1900\nk0 = 0.5\nlaw = "linear"\nmodulus_MPa = 22.5\npoisson = 0.40\n\n'
    thick = diagnose(made("thick", 0.01, 1, truth=DROPS.replace(WHOLE, TOP + WHOLE.replace("1210", "760"))))
    assert "weak-subgrade-top" in thick["causes"], f"a soft top of another thickness is not lost: {thick['verdict']} {thick['causes']}"


def test_a_stiff_top_at_the_end_of_its_range_is_said():
    # A stiff top is the same effect with a size below 0: said which way and how much, and that its range ends there; the extended study runs.
    stiff = diagnose(made("stiff", 0.01, 2, "weak-subgrade-top=-0.9"))
    words = next((s for s in stiff["findings"] if "weak-subgrade-top = -1.000" in s), "")
    assert "end of its range" in words and "the top 200 mm of the subgrade have 2.7 times the stated modulus" in words, \
        f"exp(1) times as stiff, at the end: {stiff['findings']}"
    for command in ("check", "forward"):
        done = run(command, folder / "stiff" / "run" / "extended.toml")
        assert done.returncode == 0, f"{command} of the extended study: {done.stderr}"


def test_noise_of_twice_its_size_is_no_cause():
    # The noise is twice the stated one: no name, and what would be needed stands beside what comes nearest.
    loud = diagnose(made("loud", 0.02, 14, readings=lambda cells: times(cells, sigma=0.5)))
    assert loud["verdict"] != "cause-named", f"noise is no cause: {loud['findings'][0]}"
    assert any("times what is stated" in s or "times as large as stated" in s for s in loud["findings"]), f"by how much the noise would have to be larger: {loud['findings']}"


def test_of_explanations_none_of_which_fits_none_is_called_one():
    none = diagnose(made("none", 0.02, 12, readings=lambda cells: times(cells, sigma=0.5)))
    fits = max([e.get("p_value", 0) for e in none["explanations"]] + [none["extended"]["p_value"]])
    assert fits < 0.05, f"nothing explains these: {fits}"
    assert not any("explanations fit these data so alike" in s for s in none["findings"]), f"and none is said to: {none['findings'][0]}"
    assert any("comes nearest" in s or "as large as stated" in s for s in none["findings"]), f"but what comes nearest: {none['findings']}"
    if none["verdict"] == "unexplained":
        assert any("they are no answer" in s for s in none["findings"]), f"ranges of what does not explain the data are marked: {none['findings']}"
        assert "models that do not explain these data" in (folder / "none" / "run" / "diagnose.txt").read_text(), "on the page too"
        words = next((s for s in none["findings"] if "misses most" in s), "")
        assert "mm under p" in words and ("too high" in words or "too low" in words), f"place, load and sign of what is left: {words}"
        predicted = [p["explanation"] for p in none["next_measurement"]["predicted"]]
        assert len(predicted) > 1 and len(set(predicted)) == len(predicted), f"the next reading, by what comes nearest: {predicted}"


def test_a_suspect_reading_is_asked_for_once_more():
    # A reading that one explanation takes for wrong and the others do not: another instrument at its place would tell them apart, and is offered.
    SHALLOW = HEADER + "".join(f"p566,deflection,{x},0,0,0,1,mm,\n" for x in OFFSETS) + "".join(f"p566,strain_zz,0,0,{z},75,1,microstrain,\n" for z in (90, 165, 240))
    suspect = diagnose(made("suspect", 0.02, 5, layout=SHALLOW, readings=lambda cells: times(cells, 1.25) if cells[4] == "240" else cells))
    assert "outlier" in suspect["causes"] and len(suspect["causes"]) > 1, f"one reading too large among few: {suspect['verdict']} {suspect['causes']}"
    again = [r for r in (suspect["next_measurement"], *suspect["further_measurements"]) if r["again"]]
    assert len(again) == 1 and again[0]["depth_mm"] == 240 and again[0]["reading"].endswith("once more by another instrument"), f"its place once more: {again}"
    predicted = {p["explanation"].split(" ")[0]: p["value"] for p in again[0]["predicted"]}
    assert min(v for e, v in predicted.items() if e != "outlier") > 1.05 * predicted["outlier"], f"where it was wrong it reads less: {predicted}"


def test_overstated_noise_is_said():
    # It is less than the stated one.
    calm = diagnose(made("calm", 0.01, 3, readings=lambda cells: times(cells, sigma=2.5)))
    assert calm["verdict"] == "adequate" and any("scatter less" in s for s in calm["findings"]), f"overstated noise is said: {calm['findings']}"


def test_no_name_alone_at_the_end_of_its_range():
    # Gauges that read 2.06 times as much, where the range of a gain ends at 2: not named alone.
    GAUGES = HEADER + "".join(f"p566,deflection,{x},0,0,0,1,mm,\n" for x in OFFSETS) + "".join(
        f"p566,strain_zz,0,0,{z},75,1,microstrain,\n" for z in (90, 165, 240, 340, 420, 500))
    gain = diagnose(made("gain", 0.03, 3, layout=GAUGES, readings=lambda cells: times(cells, 2.06, 2.06) if cells[1] == "strain_zz" else cells))
    at_end = next(c for c in gain["candidates"] if c["effect"] == "sensor-gain")
    assert at_end["size"] == 2, f"the range of the size ends at 2: {at_end['size']}"
    assert gain["verdict"] != "cause-named", f"no name alone at the end of its range: {gain['findings'][0]}"


# Made by a transform solution of layered elasticity that shares nothing with the program: 4200, 230 and 72 MPa, the base 220 mm thick and stated as
# 300 mm, 1 % and 1 um of noise. By its slopes alone a base softer at its bottom promises most.
def test_a_base_thinner_than_stated_by_a_quarter_is_not_another_cause():
    data = pathlib.Path(__file__).parent / "data"
    told = run("diagnose", data / "thin-base.toml", "--threads", 1, "--json", "--out", workspace() / "thin")
    found = json.loads(told.stdout)
    assert found["causes"][0] == "base-thickness" and found["verdict"] in ("cause-named", "ambiguous", "cause named"), (found["verdict"], found["causes"])
    size = next(h for h in found["hypotheses"] if h["name"] == "base-thickness")["sizes"]["base-thickness"]
    assert abs(size["value"] + 80) < 5 and size["low"] <= -80 <= size["high"], size


def test_gauges_exchanged_in_depth_are_seen_by_the_model():
    # Layered elasticity by an independent transform solution (4200, 230 and 72 MPa) with noise; the vertical strains at 460 and 700 mm
    # stand in each other's rows. No bowl shows it.
    data = pathlib.Path(__file__).parent / "data"
    found = json.loads(run("diagnose", data / "exchanged-gauges.toml", "--threads", 1, "--json", "--out", workspace() / "gauges").stdout)
    assert found["verdict"] == "cause-named" and found["causes"] == ["sensor-position"], found["findings"][0]
    assert "460 mm deep and strain_zz 700 mm deep are exchanged" in found["findings"][0]
    output = found["outputs"][0]
    assert output["low"] <= 631.06 <= output["high"], output


def test_two_wrong_readings_of_eleven_that_hide_each_other_are_found():
    # Layered elasticity by an independent transform solution with noise of 1 %; the strains at 430 and 700 mm are read 0.72 and 1.4 times.
    data = pathlib.Path(__file__).parent / "data"
    found = json.loads(run("diagnose", data / "two-wrong-of-eleven.toml", "--threads", 1, "--json", "--out", workspace() / "eleven").stdout)
    assert found["verdict"] == "cause-named" and found["causes"] == ["outlier"], found["findings"][0]
    assert sorted(int(e["on"].split()[1].rstrip(":")) for e in found["explanations"][0]["effects"]) == [8, 10]
    output = next(o for o in found["outputs"] if o["name"] == "top of subgrade")
    assert output["low"] <= 698.46 <= output["high"], output


def test_a_floor_that_is_not_there_is_among_the_causes():
    # Layered elasticity by an independent transform solution with noise of 1 %: 3600, 210 and 66 MPa, the last for ever, where the study has a floor
    # 3 m down. With the floor, mass and damping do nearly as well, with other moduli.
    data = pathlib.Path(__file__).parent / "data"
    found = json.loads(run("diagnose", data / "no-floor.toml", "--threads", 1, "--json", "--out", workspace() / "floor").stdout)
    assert found["verdict"] == "ambiguous" and found["causes"] == ["floor-depth", "inertia"], found["findings"][0]
    assert "there is no floor" in found["findings"][0] and "with the floor as stated: inertia" in found["findings"][0]
    assert found["hypotheses"][0]["name"].startswith("there is no floor") and 0.5 < found["hypotheses"][0]["probability"] < 0.95
    other = next(h for h in found["hypotheses"] if h.get("elsewhere"))
    assert other["name"] == "with the floor as stated: inertia" and abs(other["probability"] + found["hypotheses"][0]["probability"] - 1) < 1e-9
    truths = {"top of subgrade": 843.28, "bottom of asphalt": -358.29}
    for output in found["outputs"]:
        assert output["low"] <= truths[output["name"]] <= output["high"], output


def test_a_sigma_in_another_unit_is_said_first():
    data = pathlib.Path(__file__).parent / "data"
    folder = workspace()
    text = (data / "no-floor.toml").read_text().replace("thickness_mm = 2630\n", "").replace("[mesh]", '[section]\nbottom = "half-space"\n[mesh]')
    (folder / "study.toml").write_text(text)
    lines = (data / "no-floor.csv").read_text().splitlines()
    cells = lines[3].split(",")  # the value in another unit than its sigma
    lines[3] = ",".join([*cells[:6], f"{1000 * float(cells[6]):g}", "um", cells[8]])
    (folder / "no-floor.csv").write_text("\n".join(lines) + "\n")
    for command in ("fit", "diagnose"):
        found = json.loads(run(command, folder / "study.toml", "--threads", 1, "--json", "--out", folder / command).stdout)
        assert any("deflection at 300 mm under p400: sigma = 0.003117 um" in words for words in found["findings"][:2]), found["findings"][:3]


@pytest.mark.parametrize("factor", [25.4, 1000 / 25.4, 0.001])
def test_a_load_in_another_unit_with_its_errors_is_that_and_nothing_else(factor):
    # The errors of an instrument of 2 um and 1 %: another share of every reading.
    def readings(cells):
        value = float(cells[6])
        own = factor if cells[0] == "p800" else 1.0
        return [*cells[:6], repr(own * value), cells[7], repr(own * math.hypot(0.002, 0.01 * value))]
    found = diagnose(made(f"unit-{factor:.3g}", 0.01, 3, readings=readings))
    assert found["verdict"] == "cause-named" and found["causes"] == ["sensor-gain"], f"{found['verdict']} {found['causes']}: {found['findings'][0]}"
    assert "all readings of one load" in found["findings"][0] and "fits the data within their noise" in found["findings"][0], found["findings"][0]


def test_instruments_that_the_readings_do_not_tell_apart_are_both_named():
    # In a linear section gauges that read 0.85 times as much and geophones that read 1.18 times as much are one thing.
    study = folder / "instruments" / "study.toml"
    study.parent.mkdir()
    assert run("new", study, "--linear").returncode == 0
    rows = "".join(f"fwd,deflection,{x},0,0,0,1,mm,\n" for x in (0, 200, 300, 450, 600, 900, 1200)) + "".join(
        f"fwd,strain_zz,0,0,{z},0,1,microstrain,\n" for z in (170, 270, 350, 450, 550, 700))
    (study.parent / "study.csv").write_text(HEADER + rows)
    assert run("twin", study, "--noise", 0.01, "--seed", 5, "--out", study.parent / "twin").returncode == 0
    cells = [line.split(",") for line in (study.parent / "twin" / "twin.csv").read_text().splitlines() if line[0] not in "#l"]
    (study.parent / "study.csv").write_text(HEADER + "".join(",".join(times(c, 0.85, 0.85) if c[1] == "strain_zz" else c) + "\n" for c in cells))
    found = diagnose(study)
    assert found["verdict"] == "ambiguous" and found["causes"] == ["sensor-gain"], f"{found['verdict']} {found['causes']}"
    assert "deflection" in found["findings"][0] and "strain_zz" in found["findings"][0], found["findings"][0]
    right = {r["name"]: r["value"] for r in json.loads(run("forward", study, "--json").stdout)["responses"] if "strain" in r.get("name", "").split(".")[0]}
    assert len(right) == 2, right
    for output in found["outputs"]:
        assert output["low"] <= right[output["name"]] <= output["high"], f"{output['name']}: {right[output['name']]} is not in {output['low']} to {output['high']}"
    # Further readings by the same two instruments are as wrong.
    words = " ".join(found["findings"])
    assert "calibration of the instruments" in words and "Best next measurement" not in words, words


def test_without_stated_noise_ranges_are_those_of_the_residuals():
    # Some effect follows five readings almost exactly; the answer is the model without one.
    ONE_DROP = HEADER + "".join(f"p566,deflection,{x},0,0,0,1,mm,\n" for x in OFFSETS)
    study = made("estimated", 0.03, 6, layout=ONE_DROP, readings=lambda cells: [*cells[:8], ""])
    found = diagnose(study)
    assert found["verdict"] == "adequate", f"nothing is stated that could be contradicted: {found['verdict']}"
    done = run("fit", study, "--json", "--out", study.parent / "fit", "--explore", 16, "--starts", 4)
    best = json.loads(done.stdout)["best"]
    for name, error in best["standard_errors"].items():
        own = found["baseline"]["parameters"][name]
        ranges = best["ranges_95"].get(name) if best.get("ranges_95") else None
        width = ranges[1] - ranges[0] if ranges else 4 * error
        assert own["high"] - own["low"] > 0.8 * width, f"{name}: {own}, by the fit {width} wide"
