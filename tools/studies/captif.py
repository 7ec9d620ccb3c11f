"""The studies of grids/ as they are varied for the paper: what tools/studies/paper and tools/studies/paper-laws share. Runs that were cut off continue where
they stopped."""
import json
import math
import pathlib
import re
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "shared"))
from options import ROOT, parser  # noqa: E402

options = parser(sys.modules["__main__"].__doc__, out="output/paper").parse_args()
PROGRAM, WORK = options.program, options.out
# A 3D run takes seconds. More points and searches make a missed minimum less likely and the page slower.
SEARCH_3D = ("--explore", "48", "--starts", "4")


def variant(name, study, *changes):
    """Writes NAME.toml: grids/STUDY.toml without its comment lines and with each (old, new) replaced."""
    text = "".join(line for line in (ROOT / f"grids/{study}.toml").read_text().splitlines(True) if line[0] != "#")
    for old, new in changes:
        assert re.search(old, text, re.M), f"{study}: nothing matches {old}"
        text = re.sub(old, new, text, flags=re.M)
    folder = WORK / name
    folder.mkdir(parents=True, exist_ok=True)
    for file in re.findall(r'"([\w-]+\.csv)"', text):
        (folder / file).write_text((ROOT / "grids" / file).read_text())
    (folder / f"{name}.toml").write_text(text)
    return folder / f"{name}.toml"


def between_the_tyres(study):
    """Moves the gauges of a variant from under a tyre to between the tyres."""
    for file in study.parent.glob("*-strain.csv"):
        file.write_text(file.read_text().replace("strain_zz,170,", "strain_zz,0,"))
    study.write_text(study.read_text().replace("x_mm = 170", "x_mm = 0"))
    return study


def run(command, study, *options, folder=None):
    print(f"{command} {study.stem}", file=sys.stderr, flush=True)
    done = subprocess.run([PROGRAM, command, study, "--json", "--out", folder or study.parent / command, *options],
                          stdout=subprocess.PIPE, text=True)
    if done.returncode not in (0, 1):
        raise SystemExit(f"{command} {study} ended with {done.returncode}")
    return json.loads(done.stdout)


def forward(name, study, *changes, between=False):
    file = variant(name, study, *changes)
    return run("forward", between_the_tyres(file) if between else file)


def fit(name, study, *changes, between=False, options=SEARCH_3D):
    file = variant(name, study, *changes)
    return run("fit", between_the_tyres(file) if between else file, *options)


def value_of(key, value):
    """The change of a key of the base."""
    return (rf"^{key} = [-\d.]+", f"{key} = {value}")


def three(value):
    """Three significant digits, without an exponent."""
    if value is None:
        return "none"
    if value == 0:
        return "0"
    digits = 2 - math.floor(math.log10(abs(value)))
    return f"{round(value, digits):.{max(0, digits)}f}"


def table(header, rows):
    lines = ["| " + " | ".join(header) + " |", "|" + "---|" * len(header)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows])
