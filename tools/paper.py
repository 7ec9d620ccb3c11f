#!/usr/bin/env python3
"""Makes docs/paper.md: the study of Kathirgamanathan and Vignarajah beside what Pavescape gives. Started by tools/paper.
usage: tools/paper.py [--runs-only]

Every run works on a study of grids/ or on a variant of it: the same text with single values replaced, kept in
output/paper/. Runs that were cut off continue where they stopped."""
import json
import math
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]
PROGRAM = ROOT / "build/release/explore/pavescape"
WORK = ROOT / "output/paper"
# A 3D run takes seconds. More points and searches make a missed minimum less likely and the page slower.
SEARCH_3D = ("--explore", "24", "--starts", "2")


def variant(name, study, *changes):
    """Writes output/paper/NAME.toml: grids/STUDY.toml without its comment lines and with each (old, new) replaced."""
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


def run(command, study, *options):
    print(f"{command} {study.stem}", file=sys.stderr, flush=True)
    done = subprocess.run([PROGRAM, command, study, "--json", "--out", study.parent / command, *options],
                          stdout=subprocess.PIPE, text=True)
    if done.returncode not in (0, 1):
        raise SystemExit(f"paper.py: {command} {study} ended with {done.returncode}")
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


HELD_FWD = (r'^held_out = .*', 'held_out = ["fwd", "dual750"]')


def fits():
    return {
        "fwd": fit("fit-fwd", "captif-p1-fwd", options=()),
        "fwd-secant": fit("fit-fwd-secant", "captif-p1-fwd", ('"incremental"', '"secant"'), options=()),
        "joint": fit("fit-joint", "captif-p1-joint"),
        "p2": fit("fit-p2", "captif-p2"),
        "p4": fit("fit-p4", "captif-p4"),
        "p3": fit("fit-p3", "captif-p3"),
        "p1-between": fit("fit-p1-between", "captif-p1-joint", HELD_FWD, between=True, options=(*SEARCH_3D, "--joint-only")),
    }
