"""Whole pulses: readings in time, wrong histories, runs that keep and know their history, and a twin whose floor is found."""
import csv
import json
import re

import pytest

from support import *

folder = workspace()

STUDY = """schema = 1
[[layers]]
name = "asphalt"
thickness_mm = 150
density_kg_m3 = 2300
k0 = 0.5
law = "linear"
modulus_MPa = 3000
poisson = 0.35

[[layers]]
name = "subgrade"
thickness_mm = 2000
density_kg_m3 = 1800
k0 = 0.5
law = "linear"
modulus_MPa = 80
poisson = 0.40

[[loads]]
name = "drop"
type = "plate"
radius_mm = 150
history = "force.csv"

[solver]
time_step_ms = 1

[mesh]
extent_m = 5
refine = 0.5

[data]
files = ["small.csv"]
misfit = "weighted"

[data.noise]
relative = 0.02
absolute = { um = 2 }

[[parameters]]
name = "subgrade.modulus_MPa"
min = 30
max = 200
scale = "log"

[[parameters]]
name = "subgrade.thickness_mm"
min = 1000
max = 4000
scale = "log"
"""
FORCE = "time_ms,force_kN\n" + "".join(f"{t},{v}\n" for t, v in ((0, 0), (5, 20), (10, 45), (13, 50), (16, 45), (20, 20), (25, 0), (40, 0)))
PLATE = 'type = "plate"\nradius_mm = 150'
HEADER = "load,quantity,x_mm,y_mm,depth_mm,gauge_mm,time_ms,value,unit,sigma\n"
DATA = HEADER + "".join(f"drop,deflection,{x},0,0,0,{t},100,um,\n" for x in (0, 600, 1800) for t in (*range(6, 40, 3), ""))


def write(name, study=STUDY, data=DATA, force=FORCE):
    path = write_study(folder / name, study, data)
    if force is not None:
        (folder / name / "force.csv").write_text(force)
    return path


@pytest.fixture(scope="module")
def forward_run():
    # Forward: a reading at its time, and one without as the largest.
    path = write("forward")
    rows = json.loads(run("forward", path, "--json").stdout)["responses"]
    return path, rows


def test_readings_at_their_times(forward_run):
    path, rows = forward_run
    for x in (0, 600, 1800):
        own = [r for r in rows if r["x_mm"] == x]
        assert [r.get("time_ms") for r in own] == [*range(6, 40, 3), None], f"times at {x} mm"
        most = max(r["value"] for r in own[:-1])
        assert most <= own[-1]["value"] < 1.05 * most, f"the largest at {x} mm: {own[-1]['value']}, not {most}"
    late = {x: max((r for r in rows if r["x_mm"] == x and "time_ms" in r), key=lambda r: r["value"])["time_ms"] for x in (0, 1800)}
    assert late[1800] >= late[0] + 6, f"far sensors peak later: {late}"
    assert " ms " in run("forward", path, "--verbose").stdout, "the table says the times"


def test_a_shift_and_a_stated_pressure(forward_run):
    _, rows = forward_run
    shifted = write("shifted", STUDY.replace('history = "force.csv"', 'history = "force.csv"\ntime_shift_ms = 3'))
    moved = json.loads(run("forward", shifted, "--json").stdout)["responses"]
    assert all(abs(moved[i]["value"] - rows[i + 1]["value"]) < 1e-9 for i in range(0, 10)), "a shift by 3 ms reads what came 3 ms later"
    halved = write("halved", STUDY.replace('history = "force.csv"', f'history = "force.csv"\npressure_kPa = {25 / 0.0225 / 3.14159265358979}'))
    half = json.loads(run("forward", halved, "--json").stdout)["responses"]
    assert all(abs(half[i]["value"] / rows[i]["value"] - 0.5) < 1e-9 for i in range(len(rows))), "half the pressure of a history"


def test_a_wheel_on_a_circle_is_a_plate(forward_run):
    _, rows = forward_run
    # A wheel on a circle is a plate: its force that of the history, its pressure stated, or the other way round; far from it the shape of the patch does not matter.
    pressure = 50 / 0.0225 / 3.14159265358979
    IN_KPA = "time_ms,pressure_kPa\n" + "".join(f"{t},{float(v) / 50 * pressure}\n" for t, v in (row.split(",") for row in FORCE.splitlines()[1:]))
    for name, stated, force in (("wheel of force", f"pressure_kPa = {pressure}", FORCE), ("wheel of pressure", "force_kN = 50", IN_KPA)):
        wheeled = write(name, STUDY.replace(PLATE, f'type = "wheel"\npatch = "circle"\n{stated}'), force=force)
        found = json.loads(run("forward", wheeled, "--json").stdout)["responses"]
        assert all(abs(found[i]["value"] / rows[i]["value"] - 1) < 1e-6 for i in range(len(rows))), f"{name} on a circle"


def test_a_square_wheel_far_from_it():
    COARSE, FINE = "extent_m = 5\nrefine = 0.5", "extent_m = 8\nrefine = 1.2"
    pressure = 50 / 0.0225 / 3.14159265358979
    square = write("square wheel", STUDY.replace(PLATE, f'type = "wheel"\npressure_kPa = {pressure}\npatch_width_mm = 266').replace(COARSE, FINE))
    found = json.loads(run("forward", square, "--json").stdout)["responses"]
    fine = json.loads(run("forward", write("fine", STUDY.replace(COARSE, FINE)), "--json").stdout)["responses"]
    for x in (600, 1800):
        own = [(f["value"], r["value"]) for f, r in zip(found, fine) if r["x_mm"] == x]
        most = max(r for _, r in own)
        assert all(abs(f - r) < 0.02 * most for f, r in own), f"a square wheel at {x} mm in three dimensions: {own}"


def test_steps_that_are_too_long_are_said():
    done = json.loads(run("forward", write("steps", STUDY.replace("time_step_ms = 1", "time_step_ms = 8")), "--json").stdout)
    assert any("time_step_ms" in w for w in done["warnings"]), f"steps that are too long: {done['warnings']}"


def test_the_force_of_a_wheel_is_part_of_the_study():
    # What was recorded is part of the study: of a wheel whose pressure is stated, the force.
    data = HEADER + "".join(f"drop,deflection,{x},0,0,0,{t},{300 if x else 900},um,\n" for x in (0, 600) for t in (9, 12, 15))
    for scale in (1, 1.5):
        text = "time_ms,force_kN\n" + "".join(f"{t},{float(v) * scale}\n" for t, v in (row.split(",") for row in FORCE.splitlines()[1:]))
        fitted = run("fit", write("kept wheel", STUDY.replace(PLATE, 'type = "wheel"\npatch = "circle"\npressure_kPa = 900'), data, text), "--explore", "4", "--starts", "1",
                     "--out", folder / "kept wheel" / "out", "--json")
        assert fitted.returncode == 0, f"a wheel with {scale} times the force: {fitted.stderr}"
        modulus = json.loads(fitted.stdout)["best"]["parameters"]["subgrade.modulus_MPa"]
        if scale == 1:
            before = modulus
    assert abs(modulus / before - 1) > 0.1, f"half as much force again, the same answer: {before} and {modulus}"


# What cannot be.
def refused(name, words, where, **files):
    done = run("fit", write(name, **files), "--out", folder / name / "out")
    message = done.stderr.strip()
    print(f"{name}\n    {message.replace(str(folder), '...')}")
    assert done.returncode == 2 and len(message.splitlines()) == 1 and not (folder / name / "out").exists(), f"{name}: {done}"
    for word in (where, *words):
        assert word in message, f"{name}: '{word}' is missing"


@cases(
    case("no file", ["history", "does not exist"], "small.toml:24:", force=None),
    case("outside", ["outside = true"], "small.toml:24:", study=STUDY.replace('"force.csv"', '"../force.csv"')),
    case("two forces", ["force_kN and pressure_kPa"], "force.csv:1:", force="time_ms,force_kN,pressure_kPa\n0,1,1\n1,1,1\n"),
    case("no time", ["column missing", "time_ms", "time, force_kN"], "force.csv:1:", force="time,force_kN\n0,1\n1,1\n"),
    case("no force", ["column missing", "force_kN"], "force.csv:1:", force="time_ms,force\n0,1\n1,1\n"),
    case("unsorted", ["increase", "1 after 2"], "force.csv:4:", force="time_ms,force_kN\n0,1\n2,1\n1,1\n"),
    case("not a number", ["force_kN", "x"], "force.csv:3:", force="time_ms,force_kN\n0,1\n2,x\n"),
    case("short row", ["cells"], "force.csv:3:", force="time_ms,force_kN\n0,1\n2\n"),
    case("nothing presses", ["above zero"], "force.csv:1:", force="time_ms,force_kN\n0,0\n2,-1\n"),
    case("one row", ["at least two rows"], "force.csv:", force="time_ms,force_kN\n0,1\n"),
    case("empty", ["no history"], "force.csv:", force="# nothing\n"),
    case("duration too", ["duration_ms", "history"], "small.toml:25:", study=STUDY.replace('"force.csv"', '"force.csv"\nduration_ms = 30')),
    case("a gear", ["gear", "wheel"], "small.toml:24:", study=STUDY.replace(PLATE, 'type = "gear"\npressure_kPa = 700')),
    case("a wheel without a pressure", ["pressure_kPa", "patch"], "small.toml:", study=STUDY.replace(PLATE, 'type = "wheel"')),
    case("a wheel without a force", ["force_kN", "patch"], "small.toml:", study=STUDY.replace(PLATE, 'type = "wheel"'), force=FORCE.replace("force_kN", "pressure_kPa")),
    case("a time without a history", ["time_ms", "history"], "small.csv:2:", study=STUDY.replace('history = "force.csv"', "pressure_kPa = 700")),
    case("a time far away", ["time_ms", "20000"], "small.csv:2:", data=HEADER + "drop,deflection,0,0,0,0,20000,100,um,\n"),
    case("secant", ["integration", "history", "incremental"], "small.toml:", study=STUDY.replace("[solver]", '[solver]\nintegration = "secant"')),
    case("inertia too", ["inertia", "history"], "small.toml:", study=STUDY + '\n[[effects]]\nname = "inertia"\n'),
    case("too many steps", ["too many steps", "time_step_ms"], "small.toml:", study=STUDY.replace("time_step_ms = 1", "time_step_ms = 0.01"),
         force=FORCE + "5000,0\n"),
)
def test_wrong_histories_are_one_message(arguments, options):
    refused(*arguments, **options)


@pytest.fixture(scope="module")
def twin(forward_run):
    path, _ = forward_run
    # A twin with 2 % noise: the modulus and the depth of the floor are found again.
    (folder / "twin").mkdir(exist_ok=True)
    shutil.copy(folder / "forward" / "force.csv", folder / "twin")
    done = run("twin", path, "--noise", 0.02, "--out", folder / "twin")
    assert done.returncode == 0, f"twin: {done.stderr}"
    made = (folder / "twin" / "twin.csv").read_text()
    assert made.count("time_ms") == 1, "the twin has its times"
    # Without the twin's own sigma, which is next to nothing where a reading passes through zero.
    (folder / "twin" / "small.csv").write_text(re.sub(r",[\d.e-]+$", ",", made, flags=re.M))
    (folder / "twin" / "small.toml").write_text(STUDY.replace("modulus_MPa = 80", "modulus_MPa = 60").replace("thickness_mm = 2000", "thickness_mm = 3000"))
    out = folder / "twin" / "out"
    done = run("fit", folder / "twin" / "small.toml", "--explore", 16, "--starts", 1, "--out", out, "--json")
    assert done.returncode == 0, f"fit: {done.stderr}"
    best = json.loads(done.stdout)["best"]
    return out, best


def test_the_floor_of_a_twin_is_found(twin):
    _, best = twin
    for name, truth in (("subgrade.modulus_MPa", 80), ("subgrade.thickness_mm", 2000)):
        assert abs(best["parameters"][name] / truth - 1) < 0.05, f"{name}: {best['parameters'][name]}, not {truth}"
        assert abs(best["parameters"][name] - truth) < 4 * best["std_error"][name], f"{name}: the standard error"


def test_the_page_has_times(twin):
    out, _ = twin
    page = run("report", out)
    assert page.returncode == 0 and "time_ms" in (out / "report.html").read_text(), f"the page: {page.stderr}"


def test_drift_of_geophones(forward_run):
    _, rows = forward_run
    # Geophones that drift: each by a rate of its own, in proportion to the time. A fit that is not told so contradicts its noise; one that is finds the
    # modulus and the floor, and what each has drifted by.
    DRIFTING = STUDY.replace("absolute = { um = 2 }", "absolute = { um = 2 }\ndrift_um_per_ms = 1")
    drifting = write("drifting", DRIFTING)
    for noise, name in ((0.02, "told"), (1e-9, "exact")):
        (folder / name).mkdir(exist_ok=True)
        shutil.copy(folder / "forward" / "force.csv", folder / name)
        done = run("twin", drifting, "--noise", noise, "--seed", 4, "--out", folder / name)
        assert done.returncode == 0, f"twin with drift: {done.stderr}"
    rates = {}
    for own, row in zip(rows, csv.DictReader(line for line in (folder / "exact" / "twin.csv").open() if line[0] != "#")):
        if row["time_ms"]:
            rates.setdefault(float(row["x_mm"]), []).append((float(row["value"]) - own["value"] * (1e3 if own["unit"] == "mm" else 1)) / float(row["time_ms"]))
    assert len(rates) == 3 and all(max(r) - min(r) < 1e-3 for r in rates.values()), f"each sensor drifts at one rate: {rates}"
    assert max(abs(r[0]) for r in rates.values()) > 0.3, f"they drift: {rates}"
    made = (folder / "told" / "twin.csv").read_text()
    (folder / "told" / "small.csv").write_text(re.sub(r",[\d.e-]+$", ",", made, flags=re.M))
    found = {}
    for name, text in (("without", STUDY), ("with", DRIFTING)):
        (folder / "told" / f"{name}.toml").write_text(text.replace("modulus_MPa = 80", "modulus_MPa = 60"))
        done = run("fit", folder / "told" / f"{name}.toml", "--explore", 16, "--starts", 1, "--out", folder / "told" / name, "--json")
        assert done.returncode == 0, f"fit {name} drift: {done.stderr}"
        found[name] = json.loads(done.stdout)
    assert found["without"]["noise"]["p_value"] < 1e-3 and "drift" not in found["without"], f"drift untold: {found['without']['noise']}"
    assert found["with"]["noise"]["p_value"] > 1e-3, f"drift told: {found['with']['noise']}"
    for sensor in found["with"]["drift"]:
        assert abs(sensor["um_per_ms"] - rates[sensor["x_mm"]][0]) < 4 * sensor["standard_error"] < 2, f"the drift at {sensor['x_mm']} mm: {sensor}, {rates}"
    assert any("Sensors drift" in words for words in found["with"]["findings"]), f"the drift in words: {found['with']['findings']}"
    best = found["with"]["best"]
    for name, truth in (("subgrade.modulus_MPa", 80), ("subgrade.thickness_mm", 2000)):
        assert abs(best["parameters"][name] - truth) < 4 * best["std_error"][name], f"{name} beside drift: {best['parameters'][name]}"
    refused("drift without a misfit by noise", ["drift_um_per_ms", 'misfit = "weighted"'], "small.toml:", study=DRIFTING.replace('misfit = "weighted"', 'misfit = "log"'))


def test_pulses_of_an_f25_file():
    # An F25 file with the histories of two drops, as the device writes them: whole numbers of kPa and um, one every 0.5 ms. `new --pulses` makes a study of it,
    # which finds the subgrade that they were computed with.
    TIMES = [0.5 * i for i in range(1, 81)]
    PEAK = 50 / 0.0225 / 3.14159265358979
    half_ms = write("f25", data=HEADER + "".join(f"drop,deflection,{x},0,0,0,{t:g},100,um,\n" for x in (0, 600, 1800) for t in TIMES))
    computed = {x: [1e3 * r["value"] if r["unit"] == "mm" else r["value"] for r in json.loads(run("forward", half_ms, "--json").stdout)["responses"] if r["x_mm"] == x] for x in (0, 600, 1800)}
    force = [[float(cell) for cell in row.split(",")] for row in FORCE.split()[1:]]
    def pressure(t):
        for (t0, f0), (t1, f1) in zip(force, force[1:]):
            if t0 <= t <= t1:
                return (f0 + (f1 - f0) * (t - t0) / (t1 - t0)) / 50 * PEAK
        return 0
    STATION = "0,1,4,3, 31.500,1,1,N0 ,,2024,06,05,14,07"
    samples = "1001,0,0,0,0\n" + "".join(f"{1002 + i},{pressure(t):.0f},{','.join(f'{computed[x][i]:.0f}' for x in computed)}\n" for i, t in enumerate(TIMES))
    peaks = f"1,{PEAK:.0f},{','.join(f'{max(v):.0f}' for v in computed.values())}\n"
    (folder / "road.f25").write_text(f"5001,25.10,1,40, 3, 1\n5020,150,0,600,1800\n5021,300,N0,N0,N0\n5301,{STATION}\n{peaks}5185,{STATION},1,{len(TIMES) + 1},500,-1\n{samples}")
    done = run("new", folder / "f25" / "made.toml", "--from", folder / "road.f25", "--pulses")
    assert done.returncode == 0 and (folder / "f25" / "made-drop-1.csv").exists(), f"new --pulses: {done}"
    text = (folder / "f25" / "made.toml").read_text()
    cut = lambda text, first, last: text[:text.index(first)] + text[text.index(last):]
    text = cut(text, '[section]', '[[loads]]').replace("[[loads]]", STUDY[STUDY.index("[[layers]]"):STUDY.index("[[loads]]")] + "[mesh]\nextent_m = 5\nrefine = 0.5\n\n[[loads]]", 1)
    text = text[:text.index("[[parameters]]")].replace("time_step_ms = 0.5 ", "time_step_ms = 1 ") + STUDY[STUDY.index("[[parameters]]"):]
    (folder / "f25" / "made.toml").write_text(text.replace("modulus_MPa = 80", "modulus_MPa = 50"))
    done = run("fit", folder / "f25" / "made.toml", "--explore", 12, "--starts", 1, "--joint-only", "--out", folder / "f25" / "fit", "--json")
    assert done.returncode == 0, f"fit of an F25 file's pulses: {done.stderr}"
    best = json.loads(done.stdout)["best"]
    for name, truth in (("subgrade.modulus_MPa", 80), ("subgrade.thickness_mm", 2000)):
        assert abs(best["parameters"][name] / truth - 1) < 0.02, f"{name} from an F25 file: {best['parameters'][name]}, not {truth}"
    done = run("new", folder / "f25" / "other.toml", "--from", ROOT / "grids" / "road-north.f25", "--pulses")
    assert done.returncode == 2 and "none of its drops has a time history" in done.stderr, f"no histories: {done.stderr}"


def test_another_history_is_another_run(twin):
    out, _ = twin
    # Another history is another run; a run keeps its own.
    before = evaluations(out)
    (folder / "twin" / "force.csv").write_text(FORCE.replace("13,50", "13,51"))
    done = run("fit", folder / "twin" / "small.toml", "--explore", 4, "--starts", 1, "--out", out, "--json")
    assert done.returncode == 0 and evaluations(out) > before, f"a changed history: {done.stderr}"
    (folder / "twin" / "force.csv").unlink()
    again = json.loads(run("rerun", out, "--json").stdout)
    assert again["same"] and again["evaluations"] == evaluations(out), f"rerun without the history: {again}"
