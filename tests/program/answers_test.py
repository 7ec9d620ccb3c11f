"""Answers on the terminal: the verdict first, short and within 80 columns; all of it with --verbose, the verdict with --quiet."""
import fcntl
import json
import os
import pty
import re
import shutil
import struct
import subprocess
import termios

import pytest

from support import PROGRAM, ROOT, run, workspace

LAYERS = [("asphalt", 90, 2600), ("base", 280, 320), ("subgrade", 0, 65)]
WEAK = "S04"


def study(folder):
    text = 'schema = 1\ntitle = "A linear section"\n[section]\nbottom = "half-space"\n'
    for name, thickness, modulus in LAYERS:
        text += f'[[layers]]\nname = "{name}"\nlaw = "linear"\nmodulus_MPa = {modulus}\npoisson = 0.4\ndensity_kg_m3 = 2000\nk0 = 0.5\n'
        text += f"thickness_mm = {thickness}\n" if thickness else ""
    text += '[[loads]]\nname = "fwd"\ntype = "plate"\nradius_mm = 150\npressure_kPa = 600\n[data]\nmisfit = "relative"\n'
    for name, _, modulus in LAYERS:
        text += f'[[parameters]]\nname = "{name}.modulus_MPa"\nmin = {modulus / 6}\nmax = {modulus * 6}\nscale = "log"\n'
    (folder / "section.toml").write_text(text)
    return folder / "section.toml"


@pytest.fixture(scope="module")
def place():
    """A folder with a section, the bowls of a road of seven stations of which one is weak, and a study of one station."""
    folder = workspace()
    study(folder)
    bowl = [402, 318, 262, 201, 158, 103]  # um at 0 to 900 mm
    lines = ["station,chainage_m,drop,radius_mm,pressure_kPa,D0_um,D200_um,D300_um,D450_um,D600_um,D900_um"]
    for i in range(7):
        share = (1.0, 1.03, 0.98, 1.01, 1.4, 0.97, 1.02)[i]
        lines += [f"S{i:02},{25 * i},1,150,600," + ",".join(f"{d * share:.0f}" for d in bowl)]
    (folder / "road.csv").write_text("\n".join(lines) + "\n")
    text = (folder / "section.toml").read_text()
    (folder / "road.toml").write_text(text.replace('name = "asphalt.modulus_MPa"\n', 'name = "asphalt.modulus_MPa"\nlevel = "shared"\n'))
    made = run("new", folder / "one.toml", "--from", folder / "road.csv", "--station", "S01", "--linear", "--layers", "asphalt 90, base 280, subgrade")
    assert made.returncode == 0, made.stderr
    return folder


def call(place, command):
    return [command, place / "road.csv", "--study", place / ("road.toml" if command == "road" else "section.toml")] if command in ("survey", "road") else [command, place / "one.toml"]


@pytest.mark.parametrize("command, most", [("fit", 25), ("unique", 25), ("diagnose", 30), ("survey", 30), ("road", 30)])
def test_an_answer_is_short_and_begins_with_its_verdict(place, command, most):
    arguments = [*call(place, command), "--threads", 1, "--out", place / command]
    brief, full, quiet = (run(*arguments, *more) for more in ([], ["--verbose"], ["--quiet"]))
    for shown in (brief, full, quiet):
        assert shown.returncode == 0, shown.stderr
        assert shown.stdout.startswith(quiet.stdout.split("\n")[0]), f"the verdict comes first: {shown.stdout[:200]}"
        assert "\033" not in shown.stdout, "no colour where nobody looks at a terminal"
    lines = brief.stdout.splitlines()
    assert len(lines) <= most, f"{command}: {len(lines)} lines:\n{brief.stdout}"
    assert max(map(len, lines)) <= 80, f"{command}: a line of {max(map(len, lines))} columns"
    assert "Next: " in brief.stdout
    assert len(full.stdout) > 1.5 * len(brief.stdout) > 1.5 * len(quiet.stdout)
    kept = json.loads((place / command / f"{command}.json").read_text())
    told = " ".join(full.stdout.split())
    assert kept["findings"] and all(words in told for words in kept["findings"]), "all findings stand in the full text"
    assert max(map(len, full.stdout.splitlines())) <= 80, f"{command} --verbose: a line of {max(map(len, full.stdout.splitlines()))} columns"


OTHERS = {  # command: its arguments, what its verdict says, most lines
    "check": (["one.toml"], "The study is well formed: 6 readings", 30),
    "forward": (["one.toml"], "At the study's own values the model is", 20),
    "map": (["one.toml", "--design", "sobol", "--points", 32], "The lowest misfit of 32 points", 25),
    "sensitivity": (["one.toml", "--samples", 64, "--points", 3], "within the ranges of the study.", 25),
    "compare": (["one.toml", "other.toml", "--explore", 24, "--verify", 2], "The data cannot tell these studies apart", 25),
    "sample": (["one.toml", "--samples", 500], "", 25),
    "noise": ([ROOT / "grids/road-north.f25"], "Repeated drops agree within", 35),
    "slab": ([ROOT / "grids/slab-example.csv", "--thickness", 250, "--joints", "J1,J2"], "Modulus of subgrade reaction k", 30),
    "effects": ([], "effects can be added to a study", 60),
}


@pytest.mark.parametrize("command", OTHERS)
def test_every_other_answer_begins_with_its_verdict_too(place, command):
    arguments, verdict, most = OTHERS[command]
    shutil.copy(place / "one.toml", place / "other.toml")
    arguments = [command, *arguments, *(["--threads", 1] if command in ("check", "map", "sensitivity", "compare", "sample") else [])]
    arguments += ["--out", command] if command in ("map", "sensitivity", "compare", "sample") else []
    brief, full, quiet = (run(*arguments, *more, cwd=place) for more in ([], ["--verbose"], ["--quiet"]))
    for shown in (brief, full, quiet):
        assert shown.returncode == 0, shown.stderr
        assert verdict in " ".join(quiet.stdout.split()) and shown.stdout.startswith(quiet.stdout.split("\n")[0]), f"the verdict comes first: {shown.stdout[:200]}"
        lines = shown.stdout.splitlines()
        assert max(map(len, lines)) <= 80, f"{command}: a line of {max(map(len, lines))} columns:\n{shown.stdout}"
    assert len(brief.stdout.splitlines()) <= most, brief.stdout
    assert len(quiet.stdout.splitlines()) <= 5 and len(full.stdout) > len(brief.stdout) / 2 > len(quiet.stdout) / 2


def test_what_is_not_measured_has_no_empty_columns(place):
    text = (place / "section.toml").read_text()
    (place / "outputs.toml").write_text(text[:text.index("[data]")] + '[[outputs]]\nname = "D900"\nload = "fwd"\nquantity = "deflection"\nx_mm = 900\n')
    shown = run("forward", place / "outputs.toml").stdout
    header, row = (line.split() for line in shown.splitlines()[3:5])
    assert header == ["model", "unit"] and row[0] == "D900" and row[2:] == ["mm"] and float(row[1]) > 0, shown


def test_merge_and_rerun_say_their_verdict_first(place):
    for name, points in (("less", 8), ("more", 16)):
        assert run("map", "one.toml", "--design", "sobol", "--points", points, "--out", name, cwd=place).returncode == 0
    merged = run("merge", "less", "more", cwd=place)
    again = run("rerun", "more", cwd=place)
    for shown, verdict in ((merged, "less now holds 16 evaluations"), (again, "The same to the last bit: 16 evaluations")):
        assert shown.returncode == 0 and shown.stdout.startswith(verdict), shown.stdout + shown.stderr
        assert max(map(len, shown.stdout.splitlines())) <= 80, shown.stdout
    assert "Next: " in merged.stdout


def on_a_terminal(columns, *arguments, cwd):
    """What a terminal of so many columns shows of both streams."""
    ours, its = pty.openpty()
    fcntl.ioctl(its, termios.TIOCSWINSZ, struct.pack("HHHH", 40, columns, 0, 0))
    with subprocess.Popen([PROGRAM, *map(str, arguments)], cwd=cwd, stdin=subprocess.DEVNULL, stdout=its, stderr=its) as process:
        os.close(its)
        shown = b""
        while True:
            try:
                part = os.read(ours, 65536)
            except OSError:  # the other end is closed
                break
            if not part:
                break
            shown += part
        process.wait()
    os.close(ours)
    return shown.decode().replace("\r\n", "\n")


@pytest.mark.parametrize("columns", [60, 100])
def test_an_answer_takes_the_width_of_its_terminal(place, columns):
    shown = on_a_terminal(columns, "forward", "one.toml", cwd=place)
    plain = re.sub("\033\\[[0-9;]*m", "", shown)
    widths = [len(line) for line in plain.splitlines()]
    assert plain.startswith("At the study's own values") and columns - 15 < max(widths) <= columns, shown
    assert plain != shown, "the verdict has a colour"


def test_a_complaint_takes_the_width_of_its_terminal_and_one_line_elsewhere(place):
    arguments = ("fit", "one.toml", "--start", "base.modulus=300")
    shown = on_a_terminal(60, *arguments, cwd=place)
    assert shown.startswith("pavescape: ") and max(map(len, shown.splitlines())) <= 60 < len(shown), shown
    told = run(*arguments, cwd=place).stderr
    assert told.count("\n") == 1 and " ".join(shown.split()) == " ".join(told.split()), told


def test_help_takes_the_width_of_its_terminal(place):
    whole = run("--help").stdout
    commands = re.findall(r"^  ([a-z]+) ", whole.partition("Subcommands:")[2], re.M)
    assert len(commands) > 20, whole
    for arguments in (["--help"], *([command, "--help"] for command in commands)):
        lines = run(*arguments).stdout.splitlines()
        long = [line for line in lines if len(line) > 80 and " pavescape " not in line]  # what is pasted stands in one line
        assert not long, f"{arguments}: {long}"
    narrow = on_a_terminal(50, "fit", "--help", cwd=place)
    assert max(len(line) for line in narrow.splitlines() if " pavescape " not in line and "{" not in line) <= 50, narrow
    assert re.search(r"--starts N +local searches \(default: 12,", " ".join(run("fit", "--help").stdout.split())), "range and default stand behind what it does"


def test_a_survey_names_its_weak_station_first(place):
    first = run(*call(place, "survey"), "--threads", 1, "--out", place / "named", "--quiet").stdout
    assert first.startswith(f"Weak station: {WEAK} at 100 m (D0 40 %" ) or first.startswith(f"Weak station: {WEAK} at 100 m (D0 39 %"), first


def test_the_page_takes_the_weak_stations_from_the_program(place):
    assert run(*call(place, "survey"), "--threads", 1, "--out", place / "weak").returncode == 0
    found = json.loads((place / "weak" / "survey.json").read_text())
    weak = found["weak_stations"]
    assert [found["stations"][w["station"]]["station"] for w in weak] == [WEAK], weak
    assert abs(weak[0]["times_median"] - 1.4 / 1.01) < 0.01, "D0 over the median of the others"
    few = place / "only-four.csv"
    few.write_text("\n".join((place / "road.csv").read_text().splitlines()[:5]) + "\n")
    done = run("survey", few, "--threads", 1, "--out", place / "only-four")
    assert json.loads((place / "only-four" / "survey.json").read_text())["weak_stations"] is None, "four are too few to judge"
    assert "weak" not in done.stdout, done.stdout


def test_a_mistyped_command_or_option_gets_a_suggestion(place):
    for arguments, meant in ((["unik", place / "one.toml"], "unique"), (["fit", place / "one.toml", "--strats", 3], "--starts")):
        told = run(*arguments)
        assert told.returncode == 2 and f'did you mean "{meant}"?' in told.stderr and told.stderr.count("\n") == 1, told.stderr


def test_a_mistyped_file_gets_a_suggestion(place):
    (place / "fit").mkdir(exist_ok=True)
    for arguments, meant in ((["fit", place / "oen.toml"], "one.toml"), (["survey", place / "raod.csv"], "road.csv"), (["report", place / "fti"], "fit")):
        told = run(*arguments)
        assert told.returncode == 2 and f'did you mean "{place / meant}"?' in told.stderr and told.stderr.count("\n") == 1, told.stderr
    assert "did you mean" not in run("fit", place / "quite-another-name.toml").stderr


LEVELS = [(f"at{pressure}", pressure) for pressure in (400, 700, 1100)]


def levels(folder, law, data=""):
    """A section under three levels of load, whose base follows `law`."""
    text = 'schema = 1\ntitle = "Levels"\n[mesh]\nrefine = 0.5\n'
    for name, thickness, own in [("asphalt", 60, 'law = "linear"\nmodulus_MPa = 3000\npoisson = 0.35\n'), ("base", 350, law),
                                 ("subgrade", 1600, 'law = "linear"\nmodulus_MPa = 60\npoisson = 0.4\n')]:
        text += f'[[layers]]\nname = "{name}"\nthickness_mm = {thickness}\ndensity_kg_m3 = 2000\nk0 = 0.5\n{own}'
    for name, pressure in LEVELS:
        text += f'[[loads]]\nname = "{name}"\ntype = "plate"\nradius_mm = 150\npressure_kPa = {pressure}\n'
    path = folder / f"levels{len(data)}.toml"
    path.write_text(text + data)
    return path


def test_a_step_that_is_suggested_helps():
    folder = workspace()
    uzan = 'law = "uzan"\nk1 = 900\nk2 = 0.6\nk3 = -0.1\nn = 0.6\npoisson_12 = 0.35\npoisson_31 = 0.35\n'
    places = [(load, x) for load, _ in LEVELS for x in (0, 200, 300, 450, 600, 900, 1200)]
    asked = "".join(f'[[outputs]]\nname = "o{i}"\nload = "{load}"\nquantity = "deflection"\nx_mm = {x}\n' for i, (load, x) in enumerate(places))
    truth = json.loads(run("forward", levels(folder, uzan, asked), "--json").stdout)["responses"]
    rows = [f"{load},deflection,{x},0,0,0,{r['value'] * (1 + 0.01 * (-1) ** i)},mm,{0.01 * r['value']}" for i, ((load, x), r) in enumerate(zip(places, truth))]
    (folder / "d.csv").write_text("load,quantity,x_mm,y_mm,depth_mm,gauge_mm,value,unit,sigma\n" + "\n".join(rows) + "\n")
    data = '[data]\nfiles = ["d.csv"]\nmisfit = "weighted"\n'
    sought = lambda *names: "".join(f'[[parameters]]\nname = "{name}"\nmin = {low}\nmax = {high}\nscale = "{scale}"\n' for name, low, high, scale in names)
    linear = data + sought(("base.modulus_MPa", 50, 2000, "log"), ("subgrade.modulus_MPa", 20, 200, "log"))
    told = run("fit", levels(folder, 'law = "linear"\nmodulus_MPa = 300\npoisson = 0.35\n', linear), "--explore", 16, "--starts", 2, "--out", folder / "linear")
    assert re.search(r'The base stiffens with load .* try law = "uzan"', " ".join(told.stdout.split())), told.stdout
    better = data + sought(("base.k1", 200, 4000, "log"), ("base.k2", 0, 0.9, "linear"), ("subgrade.modulus_MPa", 20, 200, "log"))
    helped = run("fit", levels(folder, uzan, better), "--explore", 16, "--starts", 2, "--joint-only", "--quiet", "--out", folder / "uzan")
    assert helped.stdout.startswith("The model fits the 21 readings within their noise"), helped.stdout


def test_a_reading_that_stands_out_is_left_out_as_the_finding_says():
    folder = workspace()
    assert run("new", folder / "bowl.toml", "--linear", "--layers", "asphalt 120, base 300, subgrade").returncode == 0
    table = folder / "bowl.csv"
    head, rows = [], []
    for line in table.read_text().splitlines():
        (rows if line.startswith("fwd") else head).append(line)
    truth = [r["value"] for r in json.loads(run("forward", folder / "bowl.toml", "--json").stdout)["responses"]][:len(rows)]
    for i, value in enumerate(truth):  # 1 % of noise; one sensor reads 15 % too much
        cells = rows[i].split(",")
        cells[6:] = [repr(value * (1 + 0.01 * (-1) ** i) * (1.15 if i == 4 else 1)), "mm", repr(0.01 * value)]
        rows[i] = ",".join(cells)
    fit = ("fit", folder / "bowl.toml", "--explore", 32, "--starts", 2)
    table.write_text("\n".join(head + rows) + "\n")
    told = run(*fit, "--verbose", "--out", folder / "with")
    words = " ".join(told.stdout.split())
    assert "does NOT fit" in words and "One reading stands out" in words and "fwd.deflection@600,0,0" in words, told.stdout
    rows[4] = "# " + rows[4]
    table.write_text("\n".join(head + rows) + "\n")
    helped = run(*fit, "--quiet", "--out", folder / "without")
    assert helped.stdout.startswith("The model fits the 7 readings within their noise"), helped.stdout + helped.stderr


def bowl(folder, name, noise=0.01, sought=("asphalt", "base", "subgrade"), changes=(), bounds={}, more="", hidden=(), moved={}):
    """A study of a linear section on a half-space, whose readings have 1 % of scatter that is stated as `noise`; `changes` [(from, to)] of its text, `hidden` of
    the road's; moved {place: where its sensor stood}."""
    text = 'schema = 1\ntitle = "A bowl"\n[section]\nbottom = "half-space"\n'
    for layer, thickness, modulus in LAYERS:
        text += f'[[layers]]\nname = "{layer}"\nlaw = "linear"\nmodulus_MPa = {modulus}\npoisson = 0.4\ndensity_kg_m3 = 2000\nk0 = 0.5\n'
        text += f"thickness_mm = {thickness}\n" if thickness else ""
    text += '[[loads]]\nname = "fwd"\ntype = "plate"\nradius_mm = 150\npressure_kPa = 600\n'
    places = (0, 200, 300, 450, 600, 900, 1200, 1500)
    road = text + "".join(f'[[outputs]]\nname = "o{x}"\nload = "fwd"\nquantity = "deflection"\nx_mm = {moved.get(x, x)}\n' for x in places)
    for before, after in hidden:
        assert before in road
        road = road.replace(before, after)
    (folder / "truth.toml").write_text(road)
    truth = [r["value"] for r in json.loads(run("forward", folder / "truth.toml", "--json").stdout)["responses"]]
    sigma = [f",{noise * value}" if noise else "," for value in truth]
    (folder / f"{name}.csv").write_text("load,quantity,x_mm,y_mm,depth_mm,gauge_mm,value,unit,sigma\n" + "".join(
        f"fwd,deflection,{x},0,0,0,{value * (1 + 0.01 * (-1) ** i)},mm{own}\n" for i, (x, value, own) in enumerate(zip(places, truth, sigma))))
    text += f'[data]\nfiles = ["{name}.csv"]\nmisfit = "weighted"\n{more}'
    for layer, _, modulus in LAYERS:
        if layer in sought:
            low, high, rest = bounds.get(layer, (modulus / 6, modulus * 6, ""))
            text += f'[[parameters]]\nname = "{layer}.modulus_MPa"\nmin = {low}\nmax = {high}\nscale = "log"\n{rest}'
    for before, after in changes:
        assert before in text
        text = text.replace(before, after)
    (folder / f"{name}.toml").write_text(text)
    return folder / f"{name}.toml"


def fitted(path):
    """(what the fit says of itself in full, its JSON)"""
    told = run("fit", path, "--explore", 64, "--starts", 3, "--threads", 1, "--verbose", "--out", path.parent / f"fit-{path.stem}")
    assert told.returncode == 0, told.stderr
    return " ".join(told.stdout.split()), json.loads((path.parent / f"fit-{path.stem}" / "fit.json").read_text())


def test_a_bound_that_is_widened_as_the_finding_says_lets_the_model_fit():
    folder = workspace()
    told, before = fitted(bowl(folder, "narrow", bounds={"base": (100, 200, "")}))
    assert "base.modulus_MPa at its upper bound" in told and "with the range opened: try that first" in told, told
    told, after = fitted(bowl(folder, "wide"))
    assert before["noise"]["p_value"] < 0.001 and after["noise"]["p_value"] > 0.05, (before["noise"], after["noise"])
    assert "at its upper bound" not in told and abs(after["best"]["parameters"]["base.modulus_MPa"] / 320 - 1) < 0.15, after["best"]


def test_a_prior_that_is_widened_as_the_finding_says_lets_the_model_fit():
    folder = workspace()
    prior = lambda spread: {"subgrade": (65 / 6, 65 * 6, f"prior = {{ mean = 90, sd = {spread} }}\n")}
    told, before = fitted(bowl(folder, "sure", bounds=prior(0.02)))
    assert "The readings contradict what is known beforehand" in told and "widen it if not" in told, told
    told, after = fitted(bowl(folder, "unsure", bounds=prior(0.7)))
    assert "The readings do not contradict what is known beforehand" in told, told
    assert abs(after["best"]["parameters"]["subgrade.modulus_MPa"] - 65) < 0.5 * abs(before["best"]["parameters"]["subgrade.modulus_MPa"] - 65)


def test_noise_that_is_stated_as_the_finding_says_judges_the_model():
    folder = workspace()
    told, before = fitted(bowl(folder, "silent", noise=None))
    assert "State it under [data.noise] to judge the model" in told and before["noise"]["p_value"] is None, told
    _, after = fitted(bowl(folder, "stated", noise=None, more="[data.noise]\nrelative = 0.01\n"))
    assert after["noise"]["p_value"] > 0.05, after["noise"]


def test_too_few_readings_know_more_once_a_parameter_is_held_as_the_finding_says():
    folder = workspace()
    keep = lambda path, rows: (path.with_suffix(".csv").write_text("".join(path.with_suffix(".csv").read_text().splitlines(True)[:1 + rows])), path)[1]
    told, before = fitted(keep(bowl(folder, "few"), 2))
    assert "2 readings for 3 parameters" in told and "Hold parameters at known values" in told, told
    told, after = fitted(keep(bowl(folder, "held", sought=("subgrade",)), 2))
    assert "readings for" not in told and after["best"]["std_error"]["subgrade.modulus_MPa"] < 0.05 * 65, after["best"]


def test_noise_of_another_size_is_stated_as_the_diagnosis_says():
    folder = workspace()
    path = bowl(folder, "quiet", noise=0.002)
    told = run("diagnose", path, "--threads", 1, "--verbose", "--out", folder / "diagnose")
    kept = json.loads((folder / "diagnose" / "diagnose.json").read_text())
    if kept["verdict"] == "adequate":
        assert "State the noise so under [data.noise]" in " ".join(told.stdout.split()), told.stdout
    _, before = fitted(path)
    _, after = fitted(bowl(folder, "louder", noise=0.01))
    assert before["noise"]["p_value"] < 0.01 < 0.05 < after["noise"]["p_value"]


AFTER_SUBGRADE = 'poisson = 0.4\ndensity_kg_m3 = 2000\nk0 = 0.5\n[[loads]]'


def on_rock(subgrade_mm):
    """Changes of the text of a study on a half-space."""
    return [('bottom = "half-space"', 'bottom = "rigid"'), (AFTER_SUBGRADE, AFTER_SUBGRADE.replace("[[loads]]", f"thickness_mm = {subgrade_mm}\n[[loads]]"))]


def test_a_floor_that_is_sought_as_the_diagnosis_says_is_found():
    folder = workspace()
    path = bowl(folder, "endless", hidden=on_rock(1800))
    told = " ".join(run("diagnose", path, "--threads", 1, "--verbose", "--out", folder / "diagnose").stdout.split())
    assert 'bottom = "rigid" under [section], with subgrade.thickness_mm as a parameter' in told, told
    _, before = fitted(path)
    sought = '[[parameters]]\nname = "subgrade.thickness_mm"\nmin = 500\nmax = 10000\nscale = "log"\n'
    path = bowl(folder, "floored", hidden=on_rock(1800), changes=on_rock(4000))
    path.write_text(path.read_text() + sought)
    _, after = fitted(path)
    assert before["noise"]["p_value"] < 0.001 and after["noise"]["p_value"] > 0.05, (before["noise"], after["noise"])
    assert abs(after["best"]["parameters"]["subgrade.thickness_mm"] / 1800 - 1) < 0.15, after["best"]


def test_a_sensor_whose_place_is_stated_as_the_diagnosis_asks_fits():
    folder = workspace()
    path = bowl(folder, "stated", moved={600: 700})
    told = " ".join(run("diagnose", path, "--threads", 1, "--verbose", "--out", folder / "diagnose").stdout.split())
    assert "deflection at 600 mm" in told and "Check where it stood" in told, told
    _, before = fitted(path)
    table = path.with_suffix(".csv")
    table.write_text(table.read_text().replace("fwd,deflection,600,", "fwd,deflection,700,"))
    _, after = fitted(path)
    assert before["noise"]["p_value"] < 0.01 < 0.05 < after["noise"]["p_value"], (before["noise"], after["noise"])
