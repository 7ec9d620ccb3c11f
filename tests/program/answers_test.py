"""Answers on the terminal: the verdict first, short and within 80 columns; all of it with --verbose, the verdict with --quiet."""
import json

import pytest

from support import run, workspace

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
    made = run("new", folder / "one.toml", "--from", folder / "road.csv", "--station", "S01")
    assert made.returncode == 0, made.stderr
    return folder


def call(place, command):
    return [command, place / "road.csv", "--study", place / "section.toml"] if command == "survey" else [command, place / "one.toml"]


@pytest.mark.parametrize("command, most", [("fit", 25), ("unique", 25), ("survey", 30)])
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
    assert kept["findings"] and all(words in full.stdout for words in kept["findings"]), "all findings stand in the full text"


def test_a_survey_names_its_weak_station_first(place):
    first = run(*call(place, "survey"), "--threads", 1, "--out", place / "named", "--quiet").stdout
    assert first.startswith(f"Weak station: {WEAK} at 100 m (D0 40 %" ) or first.startswith(f"Weak station: {WEAK} at 100 m (D0 39 %"), first


def test_a_mistyped_command_or_option_gets_a_suggestion(place):
    for arguments, meant in ((["unik", place / "one.toml"], "unique"), (["fit", place / "one.toml", "--strats", 3], "--starts")):
        told = run(*arguments)
        assert told.returncode == 2 and f'did you mean "{meant}"?' in told.stderr and told.stderr.count("\n") == 1, told.stderr
