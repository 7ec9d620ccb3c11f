#!/usr/bin/env python3
"""Back-calculates basins of known structures and says how far the moduli are off: the depth of the floor is free.

usage: tools/basins.py PAVESCAPE BASINS.csv [--bottom rigid | half-space] [--floor METRES] [--radius MM] [--pressure KPA] [--poisson NU]

BASINS.csv: id, ac_m, base_m, subbase_m, E_ac_MPa, E_base_MPa, E_subbase_MPa, E_subgrade_MPa, then a column D<offset in mm>_mm
a sensor. --bottom rigid (the default) leaves the depth of the floor free, --floor holds it at that many metres of subgrade.
"""
import argparse
import csv
import json
import pathlib
import re
import statistics
import subprocess
import tempfile

LAYERS = (("asphalt", "ac", 300, 20000), ("base", "base", 30, 5000), ("subbase", "subbase", 15, 3000), ("subgrade", "subgrade", 8, 800))


def study(row, options):
    text = f'schema = 1\n\n[section]\nbottom = "{options.bottom}"\n'
    for name, key, _, _ in LAYERS:
        text += f'\n[[layers]]\nname = "{name}"\n'
        if f"{key}_m" in row:
            text += f"thickness_mm = {1e3 * float(row[key + '_m'])!r}\n"
        elif options.bottom == "rigid":
            text += f"thickness_mm = {1e3 * (options.floor or 6.0)!r}\n"
        start = {"asphalt": 3000, "base": 400, "subbase": 200, "subgrade": 70}[name]
        text += f'density_kg_m3 = 2200\nk0 = 0.5\nlaw = "linear"\nmodulus_MPa = {start}\npoisson = {options.poisson}\n'
    text += f'\n[[loads]]\nname = "fwd"\ntype = "plate"\nradius_mm = {options.radius}\npressure_kPa = {options.pressure}\n'
    text += '\n[data]\nfiles = ["basin.csv"]\nmisfit = "relative"\n'
    for name, _, low, high in LAYERS:
        text += f'\n[[parameters]]\nname = "{name}.modulus_MPa"\nmin = {low}\nmax = {high}\nscale = "log"\n'
    if options.bottom == "rigid" and not options.floor:
        text += '\n[[parameters]]\nname = "subgrade.thickness_mm"\nmin = 1500\nmax = 60000\nscale = "log"\n'
    return text


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("pavescape")
    parser.add_argument("basins")
    parser.add_argument("--bottom", default="rigid", choices=("rigid", "half-space"))
    parser.add_argument("--floor", type=float)
    parser.add_argument("--radius", type=float, default=150.0)
    parser.add_argument("--pressure", type=float, default=700.0)
    parser.add_argument("--poisson", type=float, default=0.35)
    options = parser.parse_args()
    errors = {name: [] for name, *_ in LAYERS}
    with open(options.basins, encoding="utf-8") as file, tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for row in csv.DictReader(file):
            bowl = [(m[1], value) for key, value in row.items() if (m := re.fullmatch(r"D(\d+)_mm", key))]
            (folder / "basin.csv").write_text("load,quantity,x_mm,y_mm,depth_mm,gauge_mm,value,unit,sigma\n" + "".join(
                f"fwd,deflection,{offset},0,0,0,{value},mm,\n" for offset, value in bowl))
            (folder / "basin.toml").write_text(study(row, options))
            done = subprocess.run([options.pavescape, "fit", folder / "basin.toml", "--json", "--out", folder / row["id"]],
                                  capture_output=True, text=True, check=True)
            best = json.loads(done.stdout)["best"]
            off = {layer: best["parameters"][f"{layer}.modulus_MPa"] / float(row[f"E_{key}_MPa"]) - 1 for layer, key, _, _ in LAYERS}
            for layer, value in off.items():
                errors[layer].append(abs(value))
            floor = best["parameters"].get("subgrade.thickness_mm")
            print(row["id"], " ".join(f"{layer} {100 * value:+.1f} %" for layer, value in off.items()),
                  f"floor {floor / 1e3:.1f} m below the subbase" if floor else "", f"misfit {best['misfit']:.2g}", flush=True)
    for layer, list_ in errors.items():
        print(f"{layer}: mean error {100 * statistics.mean(list_):.1f} %, largest {100 * max(list_):.1f} %")
    print(f"all: mean error {100 * statistics.mean(sum(errors.values(), [])):.1f} %")


if __name__ == "__main__":
    main()
