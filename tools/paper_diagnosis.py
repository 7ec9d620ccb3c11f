#!/usr/bin/env python3
"""Diagnoses the studies of the paper's pavements and writes the table and the picture of docs/diagnose.md. Started by
tools/paper-diagnosis.
usage: tools/paper_diagnosis.py"""
import csv
import json
import pathlib
import re
import subprocess
import sys
import tomllib

from svg import svg

ROOT = pathlib.Path(__file__).resolve().parents[1]
PROGRAM = ROOT / "build/release/explore/pavescape"
WORK = ROOT / "output/paper-diagnosis"
STRAINS = {"1": "captif-p1-diagnose-strain", "2": "captif-p2-diagnose", "3": "captif-p3-diagnose", "4": "captif-p4-diagnose"}
JOINT = {"1, with deflections": "captif-p1-diagnose"}


def diagnose(study):
    print(study, file=sys.stderr, flush=True)
    done = subprocess.run([PROGRAM, "diagnose", ROOT / f"grids/{study}.toml", "--without", "floor-depth", "--json", "--out", WORK / study],
                          stdout=subprocess.PIPE, text=True, check=True)
    return json.loads(done.stdout)


def words(explanation):
    return " with ".join(e["effect"] + (f" ({e['on'].split(':')[0]})" if e["on"] else "") for e in explanation["effects"])


def fitted_alone(found, name):
    one = next(c for c in found["candidates"] if c["effect"] == name)
    return f"{one['chi2']:.1f} ({one['size']:.2f})" if one["size"] is not None else "not fitted: it promises nothing"


def table(results):
    rows = ["| pavement | chi2 of the study's model (degrees of freedom) | verdict | explanations, chi2 (p) | with a soft top (size) |\n|---|---:|---|---|---|\n"]
    for name, found in results.items():
        base = found["baseline"]
        list_ = "; ".join(f"{words(e)} {e['chi2']:.1f} ({e['p_value']:.2g})" for e in found["explanations"]) or "none"
        rows.append(f"| {name} | {base['chi2']:.1f} ({base['dof']}) | {found['verdict']} | {list_} | {fitted_alone(found, 'weak-subgrade-top')} |\n")
    return "".join(rows)


def panel(left, name, study, found):
    """Strain against depth: measured, the study's model, the extended one."""
    text = tomllib.loads((ROOT / f"grids/{study}.toml").read_text())
    lines = [line for line in (ROOT / "grids" / text["data"]["files"][0]).read_text().splitlines() if not line.startswith("#")]
    fitted = [i for i, row in enumerate(csv.DictReader(lines)) if row["load"] not in text["data"].get("held_out", [])]
    depths = [float(row["depth_mm"]) for row in csv.DictReader(lines)]
    width, height, top = 210, 300, 40
    x = lambda strain: left + strain / 4000 * width
    y = lambda depth: top + depth / 620 * height
    bottom = text["layers"][0]["thickness_mm"] + text["layers"][1]["thickness_mm"]
    body = [f'<rect x="{left}" y="{top}" width="{width}" height="{height}" fill="none" stroke="black"/>',
            f'<rect x="{left}" y="{top}" width="{width}" height="{y(bottom) - top}" fill="#eee"/>',
            f'<text x="{left + width / 2}" y="{top - 20}" text-anchor="middle" font-size="13">pavement {name}</text>',
            f'<text x="{left + width - 4}" y="{y(bottom) - 4}" text-anchor="end" fill="#666">base</text>']
    for strain in (0, 1000, 2000, 3000, 4000):
        body.append(f'<text x="{x(strain)}" y="{top - 5}" text-anchor="middle">{strain}</text>')
    for depth in (0, 200, 400, 600):
        body.append(f'<text x="{left - 4}" y="{y(depth) + 4}" text-anchor="end">{depth}</text>')
    for key, colour, dash in (("baseline", "#b8651b", "5 3"), ("extended", "#1b6ca8", "")):
        values = found["responses"][key]
        if values:
            points = " ".join(f"{x(values[i]):.1f},{y(depths[i]):.1f}" for i in fitted)
            body.append(f'<polyline points="{points}" fill="none" stroke="{colour}" stroke-width="2" stroke-dasharray="{dash}"/>')
    for i in fitted:
        value = found["responses"]["measured"][i]
        body.append(f'<line x1="{x(0.9 * value):.1f}" y1="{y(depths[i]):.1f}" x2="{x(1.1 * value):.1f}" y2="{y(depths[i]):.1f}" stroke="black"/>'
                    f'<circle cx="{x(value):.1f}" cy="{y(depths[i]):.1f}" r="3.5" fill="black"/>')
    best = words(found["explanations"][0]) if found["explanations"] else ""
    body.append(f'<text x="{left}" y="{top + height + 18}" fill="#1b6ca8">{best}</text>')
    return "".join(body)


def main():
    strains = {name: diagnose(study) for name, study in STRAINS.items()}
    joint = {name: diagnose(study) for name, study in JOINT.items()}
    page = ROOT / "docs/diagnose.md"
    text, count = re.subn(r"(<!-- paper -->\n).*?(<!-- end -->)", lambda m: m[1] + table(strains | joint) + m[2], page.read_text(), flags=re.S)
    assert count == 1, "docs/diagnose.md has one part paper"
    page.write_text(text)
    panels = "".join(panel(50 + 260 * i, name, STRAINS[name], found) for i, (name, found) in enumerate(strains.items()))
    key = ('<text x="50" y="385">vertical strain, microstrain, against depth, mm. Dots: measured, with 10 %; dashed: the study\'s model; '
           'full: with the effect written below</text>')
    (ROOT / "docs/diagnose-paper.svg").write_text(svg(1080, 400, panels + key))


if __name__ == "__main__":
    main()
