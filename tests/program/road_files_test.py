"""Files of roads as offices have them: what is read off their drops, and what is said of them. Stations are made by a transform solution that shares
nothing with the program (tests/blind/drop_generator.cpp); what they are made of is what has to be found."""
import json
import math
import pathlib
import random
import re
import resource
import subprocess

from support import PROGRAM, run, workspace

GENERATOR = pathlib.Path(PROGRAM).resolve().parents[1] / "tests" / "drop_generator"
OFFSETS = (0, 200, 300, 450, 600, 900, 1200, 1500, 1800)


def made(folder, stations, drops, seed):
    """(lines of the file without its header, the header's names, the study, what is true)"""
    done = subprocess.run([GENERATOR, str(stations), str(drops), str(seed), folder], capture_output=True, text=True, check=True)
    names, *rows = [line.split(",") for line in (folder / "drops.csv").read_text().splitlines()]
    return rows, names, folder / "study.toml", json.loads(done.stdout)


def written(path, names, rows):
    path.write_text("\n".join(",".join(map(str, row)) for row in [names, *rows]) + "\n")
    return path


def answer(command, road, study, folder, *options):
    done = run(command, road, "--study", study, "--out", folder / f"{command}-{road.stem}", "--threads", "1", "--json", *options)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def held(stations, truths, name):
    return [s["parameters"][name]["low"] <= t[name] <= s["parameters"][name]["high"] for s, t in zip(stations, truths)]


def test_ranges_from_files_of_drops_hold_the_truth():
    folder = workspace()
    count, drops = 48, 3
    rows, names, study, truths = made(folder, count, drops, 21)
    stations = answer("survey", written(folder / "drops.csv", names, rows), study, folder)["stations"]
    all_held = sum((held(stations, truths, name) for name in stations[0]["parameters"]), [])
    all_held += [s["outputs"]["strain"]["low"] <= t["strain_per_kPa"] * s["pressure_kPa"] <= s["outputs"]["strain"]["high"] for s, t in zip(stations, truths)]
    # Parameters of one station err together: at worst as few as the stations.
    assert abs(sum(all_held) / len(all_held) - 0.95) < 3.5 * math.sqrt(0.95 * 0.05 / count), sum(all_held)
    dof = sum(s["fit"]["degrees_of_freedom"] for s in stations)
    assert dof == count * (len(OFFSETS) - 3)
    ratio = sum(s["fit"]["chi2"] for s in stations) / dof
    assert abs(ratio - 1) < 3.5 * math.sqrt(2 / dof), ratio
    # A station that has lost two of its three drops has the noise of one.
    lone = [row for row in rows if not (row[0] == "S0" and row[2] != "1")]
    fewer = answer("survey", written(folder / "lone.csv", names, lone), study, folder)["stations"][0]
    width = lambda s: math.log(s["parameters"]["subgrade.modulus_MPa"]["high"] / s["parameters"]["subgrade.modulus_MPa"]["low"])
    if fewer["fit"]["p_value"] > 0.01 and stations[0]["fit"]["p_value"] > 0.01:
        assert abs(width(fewer) / width(stations[0]) / math.sqrt(3) - 1) < 0.15, (width(fewer), width(stations[0]))


def test_what_all_drops_share_does_not_fall_with_their_number():
    folder = workspace()
    rows, names, study, _ = made(folder, 2, 6, 3)
    road = written(folder / "drops.csv", names, rows)
    width = lambda s: math.log(s["parameters"]["subgrade.modulus_MPa"]["high"] / s["parameters"]["subgrade.modulus_MPa"]["low"])
    text = study.read_text()
    # Only what the load cell errs by: deflections are proportional to the load, so that the modulus errs by as much.
    shared = text.replace("of_drops = 1", "of_drops = 1\nshared_common_relative = 0.05")
    (folder / "shared.toml").write_text(shared)
    plain = answer("survey", road, study, folder)["stations"][0]
    with_shared = answer("survey", written(folder / "again.csv", names, rows), folder / "shared.toml", folder)["stations"][0]
    wider = math.sqrt(width(plain) ** 2 + (2 * 1.96 * 0.05) ** 2)
    assert abs(width(with_shared) / wider - 1) < 0.05, (width(plain), width(with_shared), wider)


def test_single_drops_that_scatter_more_than_sensors_are_taken_to_are_judged_together():
    folder = workspace()
    count = 60
    rows, names, study, truths = made(folder, count, 1, 22)
    own = random.Random(220)
    first = next(i for i, name in enumerate(names) if name.startswith("D0"))
    noisy = [[*row[:first], *(f"{float(um) * math.exp(own.gauss(0, 0.02)):.1f}" for um in row[first:])] for row in rows]
    for readings, widened in ((rows, False), (noisy, True)):
        found = answer("survey", written(folder / "single.csv", names, readings), study, folder)
        stations = found["stations"]
        all_held = sum((held(stations, truths, name) for name in stations[0]["parameters"]), [])
        assert sum(all_held) / len(all_held) > 0.95 - 3.5 * math.sqrt(0.95 * 0.05 / count), sum(all_held)
        assert (found["noise_factor"] > 1.3) == widened, found["noise_factor"]
        assert any("sensors err more than that" in words for words in found["findings"]) == widened, found["findings"]


def test_whole_hundredths_of_a_millimetre_are_an_error_of_their_own():
    folder = workspace()
    rows, names, study, truths = made(folder, 24, 0, 5)
    rounded = [row[:5] + [10 * round(float(um) / 10) for um in row[5:]] for row in rows]
    result = answer("survey", written(folder / "hundredths.csv", names, rounded), study, folder)
    inside = sum((held(result["stations"], truths, name) for name in result["stations"][0]["parameters"]), [])
    assert sum(inside) >= 0.88 * len(inside), sum(inside)
    assert any("whole hundredths of a millimetre" in words and "2.9 um" in words for words in result["findings"]), result["findings"]
    assert "stated noise" not in json.dumps(result)
    exact = answer("survey", written(folder / "exact.csv", names, rows), study, folder)
    assert not any("rounding" in words for words in exact["findings"])


def test_a_sensor_or_the_section_or_the_layout_is_named():
    folder = workspace()
    rows, names, study, _ = made(folder, 12, 0, 8)
    renamed = lambda moved: [moved.get(name, name) for name in names]
    one = answer("survey", written(folder / "one.csv", renamed({"D600_um": "D655_um"}), rows), study, folder)
    assert one["suspect_sensor"] and one["suspect_sensor"]["offset_mm"] == 655, one["sensor_residuals"]
    assert not one["section_is_suspect"] and one["better_layout"] is None
    several = answer("survey", written(folder / "several.csv", renamed({"D300_um": "D400_um", "D450_um": "D650_um", "D600_um": "D850_um", "D900_um": "D1080_um"}), rows), study, folder)
    assert several["better_layout"] and several["better_layout"]["offsets_mm"] == list(OFFSETS), several["better_layout"]
    assert several["better_layout"]["rms_percent"] < 0.5 < 5 < several["better_layout"]["rms_percent_of_file"]
    assert several["suspect_sensor"] is None
    assert any("0, 200, 300, 450, 600, 900, 1200, 1500, 1800 mm" in words for words in several["findings"])
    thin = folder / "thin.toml"
    thin.write_text(study.read_text().replace("thickness_mm = 300", "thickness_mm = 110"))
    section = answer("survey", written(folder / "section.csv", names, rows), thin, folder)
    named = section["suspect_sensor"]  # nothing, or a sensor that errs with one sign: never one that only gives way
    assert named is None or any(r["one_sign"] and r["offset_mm"] == named["offset_mm"] for r in section["sensor_residuals"]), named
    sound = answer("survey", written(folder / "sound.csv", names, rows), study, folder)
    assert sound["suspect_sensor"] is None and not sound["section_is_suspect"] and sound["better_layout"] is None


def test_a_road_whose_sensors_stand_elsewhere_is_told_so_before_long():
    folder = workspace()
    rows, names, study, _ = made(folder, 9, 0, 8)
    moved = {"D300_um": "D400_um", "D450_um": "D650_um", "D600_um": "D850_um", "D900_um": "D1080_um"}
    shared = folder / "shared.toml"
    shared.write_text(re.sub(r'(name = "[a-z]+\.modulus_MPa"\n)', r'\1level = "shared"\n', study.read_text(), count=1))
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    road = answer("road", written(folder / "moved.csv", [moved.get(name, name) for name in names], rows), shared, folder, "--diagnose")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    # That of inches is 3 to 29 mm away, and the stations' asphalt is not quite alike: both may come first.
    usual = ("sensors at 0, 200, 300, 450, 600, 900, 1200, 1500, 1800 mm", "sensors at 0, 203, 305, 457, 610, 914, 1219, 1524, 1829 mm")
    first = road["diagnosis"]["candidates"][:2]
    assert {c["on"] for c in first} == set(usual) and all(c["effect"] == "sensor-position" for c in first), first
    assert all(c["p_familywise"] < 0.001 and c["chi2"] < 0.1 * road["diagnosis"]["chi2"] for c in first), first
    assert any("the sensors stand at 0, 20" in words and "with p < 1e-6" in words for words in road["findings"]), road["findings"]
    seconds = after.ru_utime - before.ru_utime
    assert seconds < 60, f"one nonlinear effect must not make all slow: {seconds} s of a processor"


def test_a_withheld_level_tells_of_load_only_what_the_fit_does_not_leave_over_anyway():
    folder = workspace()
    rows, names, study, _ = made(folder, 10, 0, 13)
    wrong = folder / "wrong.toml"
    text = study.read_text().replace("thickness_mm = 300", "thickness_mm = 110")
    wrong.write_text(text.replace('name = "asphalt.modulus_MPa"', 'name = "asphalt.modulus_MPa"\nlevel = "shared"'))
    levels = []
    for row in rows:
        for number, (pressure, softer) in enumerate(((350, 1.0), (500, 1.0), (700, 1.06))):
            um = [float(v) * pressure / 700 * (softer if o < 700 else 1.0) for v, o in zip(row[5:], OFFSETS)]
            levels.append([row[0], row[1], number + 1, row[3], pressure, *(f"{v:.4f}" for v in um)])
    result = answer("road", written(folder / "levels.csv", names, levels), wrong, folder, "--withhold", "700kPa")
    for sensor in result["withheld"]["sensors"]:
        expected = 6.0 if sensor["offset_mm"] < 700 else 0.0
        assert abs(sensor["load_percent"] - expected) < 0.02, sensor  # a linear section: nothing else changes with load
    told = [words for words in result["findings"] if "withheld" in words][0]
    assert "which is no effect of the load" in told and "900 mm +6" not in told, told
    words = json.dumps(result)
    assert " inf " not in words and "stated noise" not in words, re.findall(r"[^\"]*stated noise[^\"]*", words)


    # Softer under the highest load by 6 % is, seen from there, harder under the lowest.
    lower = answer("road", written(folder / "lower.csv", names, [row for row in levels if row[4] != 500]), wrong, folder, "--withhold", "350kPa")
    told = [words for words in lower["findings"] if "withheld" in words][0]
    assert "down to this one" in told and "hardens with load more" in told, told


def test_a_station_with_two_readings_left_does_not_end_a_road():
    folder = workspace()
    rows, names, study, _ = made(folder, 6, 0, 17)
    shared = folder / "shared.toml"
    shared.write_text(study.read_text().replace('name = "asphalt.modulus_MPa"', 'name = "asphalt.modulus_MPa"\nlevel = "shared"'))
    rows[3][7:] = [""] * len(rows[3][7:])
    road = answer("road", written(folder / "two.csv", names, rows), shared, folder)
    assert len(road["stations"]) == 6 and not any("nan" in words for words in road["findings"]), road["findings"]


def test_a_constraint_may_read_an_output_at_every_station():
    folder = workspace()
    rows, names, study, _ = made(folder, 3, 0, 19)
    road = written(folder / "three.csv", names, rows)
    plain = answer("survey", road, study, folder)["stations"]
    strains = [abs(s["outputs"]["strain"]["value"]) for s in plain]
    sign = 1 if plain[0]["outputs"]["strain"]["value"] > 0 else -1
    for name, most in (("far", 10 * max(strains)), ("near", 0.9 * min(strains))):
        constrained = folder / f"{name}.toml"
        relation = f"strain <= {most}" if sign > 0 else f"strain >= {-most}"
        constrained.write_text(study.read_text() + f'\n[[constraints]]\nthat = "{relation}"\n')
        found = answer("survey", road, constrained, folder)["stations"]
        for s, before in zip(found, plain):
            value = abs(s["outputs"]["strain"]["value"])
            assert value <= most * 1.001, (name, value, most)
            if name == "far":
                assert abs(value / abs(before["outputs"]["strain"]["value"]) - 1) < 1e-3, (value, before["outputs"])


def test_light_deflectometers_have_no_ratio_and_it_is_counted():
    folder = workspace()
    road = folder / "light.csv"
    road.write_text("station,chainage_m,diameter_mm,load_kN,drop,D0_um\n" + "".join(f"{s},{10 * s},300,7.07,{d},{400 + 31 * s + d}\n" for s in (1, 2) for d in (4, 5, 6)))
    done = run("survey", road, "--verbose", "--out", folder / "light", "--threads", "1")
    assert done.returncode == 0, done.stderr
    assert "2 stations: 0 pass, 0 fail, 2 without a ratio, 0 rejected" in " ".join(done.stdout.split()), done.stdout
    assert "kips" not in done.stdout and "?" not in done.stdout.split("Remarks")[1].split("Along the road")[0], done.stdout


def test_deflections_at_depth_are_read():
    folder = workspace()
    _, _, study, truths = made(folder, 1, 0, 2)
    text = study.read_text()
    for name in ("asphalt", "base", "subgrade"):
        text = re.sub(rf'(name = "{name}"\n(?:.*\n)*?modulus_MPa = )\S+', lambda m: m[1] + str(truths[0][f"{name}.modulus_MPa"]), text, count=1)
    for number, depth in enumerate((460, 480)):
        text += f'\n[[outputs]]\nname = "w{number}"\nload = "fwd"\nquantity = "deflection"\nunit = "um"\ndepth_mm = {depth}\n'
    deep = folder / "deep.toml"
    deep.write_text(text.replace('unit = "um"\n', ""))
    done = run("forward", deep, "--json", "--threads", "1")
    assert done.returncode == 0, done.stderr
    values = [r["value"] for r in json.loads(done.stdout)["responses"]]
    # The strain half way between is what the displacements differ by: mm over 20 mm, in microstrain.
    strain = 1e6 * (values[1] - values[2]) / 20
    assert abs(strain / (700 * truths[0]["strain_per_kPa"]) - 1) < 0.002, (strain, truths)


def test_a_drop_over_time_is_not_taken_for_a_road():
    path = workspace() / "pulse.csv"
    path.write_text("Time,Force,D1,D2\n" + "".join(f"{0.0002 * i:.4f},{i},{i},{i}\n" for i in range(40)))
    done = run("survey", path)
    assert done.returncode == 2 and done.stderr.count("\n") == 1 and "one drop over time" in done.stderr and "--pulses" in done.stderr, done.stderr


def test_another_study_in_the_place_of_the_one_before_is_said():
    folder = workspace()
    rows, names, study, _ = made(folder, 1, 1, 3)
    road, other = written(folder / "drops.csv", names, rows), folder / "other.toml"
    other.write_text(study.read_text())
    said = [run("survey", road, "--study", s, "--out", folder / "survey").stderr for s in (study, other, other)]
    assert "before" not in said[0] and "before" not in said[2], f"nothing else was there: {said}"
    assert f"was made with {study} before" in said[1] and "--out DIR" in said[1], f"the survey with the first study is replaced: {said[1]}"


DATA = pathlib.Path(__file__).parent / "data"  # roads by another transform solution, noise of 0.8 %


def test_at_one_level_of_load_a_place_is_told_from_a_gain():
    folder = workspace()
    told = answer("road", DATA / "sensor-900-stands-at-750.csv", DATA / "shared-asphalt.toml", folder, "--diagnose")["findings"]
    named = next(words for words in told if words.startswith("CAUSE NAMED"))
    assert "sensor-position (the sensor at 900 mm stands" in named, named
    assert abs(float(re.search(r"stands (\d+) mm nearer", named)[1]) - 150) < 10, named


def test_no_layout_is_accused_where_the_section_lacks_a_layer():
    # 740 mm of fill between base and subgrade that the study does not have; all sensors stand where the file says.
    folder = workspace()
    road, study = DATA / "fill-not-in-the-study.csv", DATA / "shared-asphalt.toml"
    found = answer("survey", road, study, folder)
    assert found["better_layout"] is None, found["better_layout"]
    assert found["section_trials"][0]["section"].startswith("a further layer") and found["section_trials"][0]["rms_percent"] < 0.5
    told = answer("road", road, study, folder, "--diagnose")["findings"]
    assert any("rock or anything stiff below looks alike" in words for words in told) == any("subgrade-depth-gradient" in words for words in told), told


def test_what_all_rejected_stations_show_alike_is_said():
    folder = workspace()
    rows, names, study, _ = made(folder, 8, 0, 2)
    first, second = names.index("D450_um"), names.index("D600_um")
    for row in rows:
        row[first], row[second] = row[second], row[first]
    done = run("survey", written(folder / "exchanged.csv", names, rows), "--study", study, "--out", folder / "exchanged", "--json")
    found = json.loads(done.stdout)  # no station has an answer
    assert any("As they all read, the sensors at 450 and 600 mm are exchanged" in words for words in found["findings"]), found["findings"]


def test_places_and_temperatures_in_another_unit_are_asked_about():
    folder = workspace()
    rows, names, study, _ = made(folder, 10, 0, 2)
    metres = [f"{12000 + 25 * i}" for i in range(10)]
    kilometres = [f"{12 + 0.025 * i:.3f}" for i in range(10)]
    for name, places, asked in (("metres", metres, False), ("kilometres", kilometres, True), ("mixed", kilometres[:5] + metres[5:], True)):
        road = written(folder / f"{name}.csv", names, [[row[0], place, *row[2:]] for row, place in zip(rows, places)])
        assert any("kilometres" in words for words in answer("survey", road, study, folder)["findings"]) == asked, name
    # 61 is no air temperature in Celsius; 68 beside it is no surface either.
    for air, surface, used in (("16", "20", True), ("61", "68", False), ("999", "20", True)):
        road = written(folder / f"air{air}.csv", [*names, "air_C", "surface_C"], [[*row, air, surface] for row in rows])
        stations = answer("survey", road, study, folder)["stations"]
        said = [remark for s in stations for remark in s["remarks"] if "surface temperature" in remark]
        assert (not said) == used, (air, said)
