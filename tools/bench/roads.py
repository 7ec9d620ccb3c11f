#!/usr/bin/env python3
"""Two roads by this program and by an earlier one, and how near the searches by a shared reduced model come to those by the full one.

usage: tools/bench/roads.py OTHER [STATIONS [OF_OTHER]]        (200, 40)

A road of four linear layers on a floor, and one with a stress-dependent base at three load levels (tools/made_road.py), both with noise. OTHER
takes the first OF_OTHER stations, for it has no cost that stations share. Seconds are those of a processor, one thread. The answers of the
full model alone are those of the same stations in files of seven, which is too few for a reduced model.
"""
import json
import pathlib
import random
import re
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))
sys.path.insert(0, str(ROOT / "tools" / "bench"))
import made_road  # noqa: E402
from measure import Process, median, table  # noqa: E402

PROGRAM = ROOT / "build" / "release" / "explore" / "pavescape"
NOISE = made_road.Noise(0.01, 1.0)
APART = 7
LAYERS = {"asphalt": (120, 4000), "base": (200, 450), "subbase": (300, 180), "subgrade": (6000, 70)}
OFFSETS = (0, 200, 300, 450, 600, 900, 1200, 1500, 1800)


def linear_section(moduli):
    text = 'schema = 1\ntitle = "four linear layers"\n'
    for (name, (thickness, _)), modulus in zip(LAYERS.items(), moduli):
        text += (f'[[layers]]\nname = "{name}"\nthickness_mm = {thickness}\ndensity_kg_m3 = 2200\nk0 = 0.5\nlaw = "linear"\n'
                 f'modulus_MPa = {modulus}\npoisson = 0.35\n')
    return text + '[[loads]]\nname = "fwd"\ntype = "plate"\nradius_mm = 150\npressure_kPa = 707\n'


def linear_road(folder, stations):
    chance = random.Random(3)
    lines = ["station,chainage_m,drop,radius_mm,pressure_kPa," + ",".join(f"D{o}_um" for o in OFFSETS)]
    outputs = "".join(f'[[outputs]]\nname = "D{o}"\nload = "fwd"\nquantity = "deflection"\nx_mm = {o}\n' for o in OFFSETS)
    for i in range(stations):
        truth = folder / "truth.toml"
        truth.write_text(linear_section([round(m * 2 ** chance.uniform(-0.7, 0.7), 2) for _, m in LAYERS.values()]) + outputs)
        exact = [1e3 * r["value"] for r in json.loads(Process(str(PROGRAM), "forward", str(truth), "--json").out)["responses"]]
        cells = [f"{d + (0.01 * d + 1) * chance.gauss(0, 1):.3f}" for d in exact]
        lines.append(f"P{i:03},{25 * i},1,150,707," + ",".join(cells))
    study = linear_section([m for _, m in LAYERS.values()]) + '[data]\nmisfit = "relative"\n' + "".join(
        f'[[parameters]]\nname = "{name}.modulus_MPa"\nmin = {m / 8}\nmax = {m * 8}\nscale = "log"\n' for name, (_, m) in LAYERS.items())
    return lines, study


def stressed_road(stations):
    _, bowls = made_road.stations_and_bowls(PROGRAM, stations)
    lines = made_road.write_road("bench", range(stations), bowls, NOISE, 5).read_text().splitlines()
    study = re.sub(r'level = "shared".*\n', "", made_road.TEXT).replace('misfit = "weighted"', 'misfit = "relative"')
    return lines, study


def surveyed(program, folder, name, lines, study):
    """(seconds of a processor, {station: its parameters and their ranges})"""
    (folder / f"{name}.csv").write_text("\n".join(lines) + "\n")
    (folder / f"{name}.toml").write_text(study)
    run = Process(str(program), "survey", f"{folder}/{name}.csv", "--study", f"{folder}/{name}.toml", "--threads", "1", "--out", f"{folder}/{name}-out",
                  "--json")
    return run.cpu, {s["station"]: s for s in json.loads(run.out)["stations"]}


def of_stations(lines, first, last):
    return [lines[0], *(row for row in lines[1:] if first <= int(row[1:4]) < last)]


def main():
    other = sys.argv[1]
    stations = int(sys.argv[2]) if len(sys.argv) > 2 else 200
    few = int(sys.argv[3]) if len(sys.argv) > 3 else 40
    rows = []
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for words, (lines, study) in (("four linear layers", linear_road(folder, stations)),
                                      ("stress-dependent base, three levels", stressed_road(stations))):
            now, found = surveyed(PROGRAM, folder, "now", lines, study)
            then, _ = surveyed(other, folder, "then", of_stations(lines, 0, few), study)
            ratio = (then / few) / (now / stations)
            rows.append([words, f"{60 * stations / now:.0f}", f"{60 * few / then:.0f}", f"{ratio:.1f}"])
        print(table(["road", f"stations a minute, {stations}", f"earlier program, {few}", "times as fast"], rows))
        apart = []
        for first in range(0, few, APART):
            _, part = surveyed(PROGRAM, folder, f"part{first}", of_stations(lines, first, min(few, first + APART)), study)
            for station, s in part.items():
                for parameter, p in s["parameters"].items():
                    if p["determined"]:
                        apart.append(abs(found[station]["parameters"][parameter]["value"] - p["value"]) / ((p["high"] - p["low"]) / 3.92))
        apart.sort()
        print(f"{len(apart)} determined parameters of {few} stations, shared reduced model and full model, apart by standard errors: "
              f"median {median(apart):.3f}, 95 % within {apart[int(0.95 * len(apart))]:.3f}, largest {apart[-1]:.3f}")


if __name__ == "__main__":
    main()
