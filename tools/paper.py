#!/usr/bin/env python3
"""Makes docs/paper.md: the study of Kathirgamanathan and Vignarajah beside what Pavescape gives. Started by tools/paper.
usage: tools/paper.py

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
SEARCH_3D = ("--explore", "48", "--starts", "4")


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


def run(command, study, *options, folder=None):
    print(f"{command} {study.stem}", file=sys.stderr, flush=True)
    done = subprocess.run([PROGRAM, command, study, "--json", "--out", folder or study.parent / command, *options],
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


def forwards():
    def n_scaled(factor):
        return forward(f"n-{factor}", "captif-p1-joint", value_of("n", 0.4 * factor))
    runs = {
        "table2": forward("table2", "captif-p1-table2"),
        "table2-k3-30": forward("table2-k3-30", "captif-p1-table2", value_of("k3", "30")),
        "table2-vertical": forward("table2-vertical", "captif-p1-table2", ('"horizontal"', '"vertical"')),
        "table2-between": forward("table2-between", "captif-p1-table2", between=True),
        "table2-320": forward("table2-320", "captif-p1-table2", ("spacing_mm = 340", "spacing_mm = 320")),
        "table2-360": forward("table2-360", "captif-p1-table2", ("spacing_mm = 340", "spacing_mm = 360")),
        "table5": forward("table5", "captif-p1-fwd"),
        "table5-secant": forward("table5-secant", "captif-p1-fwd", ('"incremental"', '"secant"')),
        "table5-vertical": forward("table5-vertical", "captif-p1-fwd", ('"horizontal"', '"vertical"')),
        "table5-n5": forward("table5-n5", "captif-p1-fwd", value_of("n", "0.5")),
        "rlt": forward("rlt", "captif-p1-rlt"),
        "rlt-plus": forward("rlt-plus", "captif-p1-rlt", value_of("k3", "0.35")),
        "rlt-35": forward("rlt-35", "captif-p1-rlt", value_of("k3", "35")),
    }
    for p in "234":
        runs[f"p{p}"] = forward(f"p{p}", f"captif-p{p}")
        runs[f"p{p}-k3-4"] = forward(f"p{p}-k3-4", f"captif-p{p}", value_of("k3", "4"))
    for factor in (0.5, 0.75, 1, 1.25, 1.5):
        runs[f"n-{factor}"] = n_scaled(factor)
    runs["survey"] = run("survey", ROOT / "grids/road-example.csv", folder=WORK / "survey")
    return runs


def three(value):
    """Three significant digits, without an exponent."""
    if value is None:
        return "none"
    if value == 0:
        return "0"
    digits = 2 - math.floor(math.log10(abs(value)))
    return f"{round(value, digits):.{max(0, digits)}f}"


def rows_of(result, load=None):
    return [r for r in result.get("responses", []) if "measured" in r and load in (None, r["load"])]


def rms(result, load, floor=0.05):
    """Root mean square of the logarithmic residual, as log_floor defines it; None without an answer."""
    rows = rows_of(result, load)
    if not rows:
        return None
    scale = 2 * floor * max(abs(r["measured"]) for r in rows)
    return math.sqrt(sum((math.asinh(r["value"] / scale) - math.asinh(r["measured"] / scale)) ** 2 for r in rows) / len(rows))


def table(header, rows):
    lines = ["| " + " | ".join(header) + " |", "|" + "---|" * len(header)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows])


def beside(load, columns, place):
    """Measured values of a load beside columns (name, result), with the root mean square of each below."""
    first = next(result for _, result in columns if rows_of(result, load))
    rows = []
    for i, reading in enumerate(rows_of(first, load)):
        values = [rows_of(result, load) for _, result in columns]
        rows.append([f"{reading[place]:g}", f"{reading['measured']:g}"]
                    + [three(v[i]["value"]) if v else result_status(c[1]) for v, c in zip(values, columns)])
    rows.append(["rms log error", ""] + [three(rms(result, load)) for _, result in columns])
    return table([place.replace("_", " "), "measured"] + [name for name, _ in columns], rows)


def result_status(result):
    return result.get("status", "no answer")


PARAMETERS = ("base.k1", "base.k2", "base.k3", "base.n", "subgrade.modulus_MPa")


def at_bound(minimum, name):
    return any(bound.startswith(name + " ") for bound in minimum["on_bound"])


def determined(minimum, name):
    """Not on a bound, and with a standard error of at most half the value."""
    error = minimum["standard_errors"][name]
    return not at_bound(minimum, name) and error is not None and error <= 0.5 * abs(minimum["parameters"][name])


def estimate(minimum, name):
    """A parameter with its standard error, or why it is none."""
    value = three(minimum["parameters"][name])
    if at_bound(minimum, name):
        return f"at its bound {value}"
    if not determined(minimum, name):
        return f"not determined (search ended at {value})"
    others = " while others are at bounds" if minimum["on_bound"] else ""
    return f"{value} ± {three(minimum['standard_errors'][name])}{others}"


FIT_NAMES = {"fwd": "pavement 1, FWD", "fwd-secant": "pavement 1, FWD, secant", "joint": "pavement 1, FWD and 650 kPa strains",
             "p1-between": "pavement 1, 650 kPa strains, gauges between the tyres", "p2": "pavement 2", "p3": "pavement 3",
             "p4": "pavement 4"}


def parameter_table(f):
    rows = []
    for key, name in FIT_NAMES.items():
        if key in f:
            r = f[key]
            rows.append([name, *[estimate(r["best"], p) for p in PARAMETERS], f"{len(r['minima'])} ({r['starts']})"])
    strains = alone(f["joint"], "dual650.strain_zz")
    rows.append(["pavement 1, 650 kPa strains", *[estimate(strains, p) for p in PARAMETERS], ""])
    return table(["fit", *PARAMETERS, "minima (searches)"], rows)


def cross_table(joint):
    groups = [g["name"] for g in joint["groups"]]
    rows = [["FWD and 650 kPa strains"] + [three(g["rms"]) for g in joint["groups"]]]
    rows += [[f"{a['fitted']} alone"] + [three(a["rms"][g]) for g in groups] for a in joint["alone"]]
    return table(["fitted", *groups], rows)


def alone(joint, name):
    return next(a for a in joint["alone"] if a["fitted"] == name)


def outputs_of(result):
    """The responses after the measured ones: d0, base strain, subgrade-top strain."""
    return [r["value"] for r in result["responses"] if "measured" not in r]


def apart(low, high):
    """By how many standard errors n of the second minimum exceeds that of the first; None when one is not determined."""
    if not (determined(low, "base.n") and determined(high, "base.n")):
        return None
    error = math.hypot(low["standard_errors"]["base.n"], high["standard_errors"]["base.n"])
    return (high["parameters"]["base.n"] - low["parameters"]["base.n"]) / error


def verdict(distances):
    """Of a claim that each of these steps goes up."""
    if None in distances:
        return "**the data cannot tell**, for n is not determined in every fit it needs"
    if all(d > 2 for d in distances):
        return "**supported**"
    if any(d < -2 for d in distances):
        return "**contradicted**"
    return "**the data cannot tell**: the differences are within two standard errors"


def n_claims(f):
    """What the fits say of the paper's claims on n: under the wheel against the FWD, and over base thickness."""
    wheel = alone(f["joint"], "dual650.strain_zz")
    fwd = f["fwd"]["best"]
    bases = [(144, f["p2"]["best"]), (150, f["p3"]["best"]), (277, wheel), (300, f["p4"]["best"])]
    by_base = "; ".join(f"{mm} mm: {estimate(m, 'base.n')}" for mm, m in bases)
    steps = [apart(a, b) for (_, a), (_, b) in zip(bases, bases[1:])]
    under = f"under the wheel {estimate(wheel, 'base.n')}, FWD {estimate(fwd, 'base.n')}"
    return f"{verdict([apart(wheel, fwd)])} ({under})", f"{verdict(steps)} ({by_base})"


def ratios(survey):
    """What a survey found, in words."""
    known = [s["deflection_ratio"] for s in survey["stations"] if s.get("deflection_ratio") is not None]
    return (f"{len(known)} of {len(survey['stations'])} stations have a ratio, from {three(min(known))} to {three(max(known))}; "
            f"below the limit: {sum(x < 0.6 for x in known)}")


def page(f, r):
    joint = f["joint"]
    fitted, predicted = (next(g["rms"] for g in joint["groups"] if g["name"] == f"dual{p}.strain_zz") for p in (650, 750))
    own = alone(joint, "dual650.strain_zz")["rms"]
    fwd_alone = alone(joint, "fwd.deflection")["rms"]
    fwd_n, trend = n_claims(f)
    worse = "not worse than" if own["dual750.strain_zz"] <= own["dual650.strain_zz"] else "worse than"
    sub = [(v["measured"] / v["value"]) for v in rows_of(r["table2"], "dual650")[3:6]]
    sub_mean = math.exp(sum(map(math.log, sub)) / len(sub))
    last = rows_of(r["table2"], "dual650")
    decay = (last[3]["measured"] / last[6]["measured"], last[3]["value"] / last[6]["value"])
    far = rows_of(r["table5"])[5]
    change = [[100 * (a / b - 1) for a, b in zip(outputs_of(r[f"n-{x}"]), outputs_of(r["n-1"]))] for x in (0.5, 0.75, 1, 1.25, 1.5)]
    text = f"""# The paper and Pavescape

Kathirgamanathan and Vignarajah fitted Uzan's law with a cross-anisotropic base to strains and deflections of four test
sections. With the printed values, k3 of table 2 read as .30 where 30 is printed, Pavescape gives the measured 650 kPa
strains of pavement 1 with a root mean square (rms) log error of {three(rms(r['table2'], 'dual650'))} and the falling weight
deflectometer (FWD) basin with {three(rms(r['table5'], 'fwd'))}. Fitted strains at 650 kPa predict the strains at 750 kPa, which
were never fitted, with {three(own['dual750.strain_zz'])}, {worse} the fit's own {three(own['dual650.strain_zz'])}; the joint fit of strains and
FWD predicts them with {three(predicted)}, against {three(fitted)} at 650 kPa. Whether n is smaller under the wheel than under the FWD: {fwd_n}.
Whether it grows with base thickness: {trend}.

This page is made by `tools/paper`. All errors are rms values of the logarithmic residual with a floor of 5 % of the largest
reading; 0.10 is about 10 %. Where the paper is silent (densities, k0, Poisson's ratios, tyre spacing, patch, gauge length and
position) the studies in `grids/` state what is assumed.

## Tables 2 and 3: strains of pavement 1 (microstrain)

At 650 kPa; depth in mm, gauges under a tyre. "Joint" is fitted to FWD and these strains together.

{beside("dual650", [("table 2, k3 .30", r["table2"]), ("table 2, k3 30", r["table2-k3-30"]), ("E vertical", r["table2-vertical"]), ("between tyres", r["table2-between"]), ("our joint fit", joint)], "depth_mm")}

At 750 kPa, never fitted:

{beside("dual750", [("table 2, k3 .30", r["table2"]), ("table 2, k3 30", r["table2-k3-30"]), ("our joint fit", joint)], "depth_mm")}

- k3 printed 30 or .30: rms log error {three(rms(r["table2-k3-30"], "dual650"))} against {three(rms(r["table2"], "dual650"))}.
- Tyre spacing 320, 340, 360 mm: {three(rms(r["table2-320"], "dual650"))}, {three(rms(r["table2"], "dual650"))}, {three(rms(r["table2-360"], "dual650"))}.
- k2 = 2.10 and 1.5 are above 1. Then the modulus grows faster than the stress and the secant definition has no stable
  equilibrium; the incremental definition, used for the strains, still has an answer.
- Subgrade strains (three upper pairs) are measured {three(sub_mean)} times as large as table 2's values give. From 337.5 to 562.5 mm they fall
  by a factor of {three(decay[0])} measured and {three(decay[1])} computed: a uniform elastic subgrade cannot follow.
"""
    if "p1-between" in f:
        a, b = own["dual650.strain_zz"], rms(f["p1-between"], "dual650")
        text += f"- Gauges under or between the tyres, both fitted to the 650 kPa strains: {three(a)} under, {three(b)} between.\n"
    text += f"""
## Tables 4 and 5: FWD on pavement 1 (mm)

{beside("fwd", [("table 5, n .40", r["table5"]), ("n .5 (its text)", r["table5-n5"]), ("E vertical", r["table5-vertical"]), ("secant", r["table5-secant"]), ("our fit", f["fwd"]), ("our fit, secant", f["fwd-secant"]), ("joint fit", joint)], "x_mm")}

- At 1800 mm {three(far["measured"])} mm is measured and {three(far["value"])} mm computed: a static model on a rigid floor gives the wrong sign there.
- 900 mm is printed as 006. Pressures are printed in MPa in places: 42 kN at 595 kPa is a plate of {three(1000 * math.sqrt(42 / 595 / math.pi))} mm radius;
  at 595 MPa it would be {three(1000 * math.sqrt(42 / 595000 / math.pi))} mm.
- Incremental and secant are two definitions: values fitted with one are not values of the other.

## Table 5: laboratory values (RLT) on the field data

{table(["k3", "FWD", "650 kPa strains", "750 kPa strains"], [[name, *[three(rms(r[key], load)) for load in ("fwd", "dual650", "dual750")]] for name, key in (("-.35", "rlt"), (".35", "rlt-plus"), ("35, as printed", "rlt-35"))])}

The data prefer {min((rms(r[key], "fwd") + rms(r[key], "dual650"), name) for name, key in (("-.35", "rlt"), (".35", "rlt-plus"), ("35", "rlt-35")))[1]}. Laboratory tests on granular bases give a negative k3, as table 5's FWD column does;
every reading here leaves a larger error than the FWD fit and the strain fit do.

## Tables 6 and 7: strains of pavements 2, 3, 4 (microstrain)
"""
    for p, base in (("2", 144), ("3", 150), ("4", 300)):
        columns = [("table 7, k3 .4", r[f"p{p}"]), ("table 7, k3 4", r[f"p{p}-k3-4"])]
        columns += [("our fit", f[f"p{p}"])] if f"p{p}" in f else []
        text += f"\nPavement {p}, base {base} mm:\n\n{beside('dual800', columns, 'depth_mm')}\n"
    text += f"""
Pavement 3's strains change at the wrong depth for a 150 mm base, and values repeat exactly there and in pavement 4: they look
read off a plot or carried over. No fit of these readings should be taken as a property of the material.

## Parameters of the fits

Each search in 3D started from the best of {SEARCH_3D[1]} explored points, {SEARCH_3D[3]} searches a fit: other minima are not excluded. A value at a bound of its range, or with a standard error above half the value, is not an estimate and is named so.

{parameter_table(f)}

## Section IV: what one kind of data predicts for the other (rms log error)

{cross_table(joint)}

- Strains at 650 kPa predict 750 kPa with {three(own["dual750.strain_zz"])}; their own fit leaves {three(own["dual650.strain_zz"])}. With FWD fitted too: {three(predicted)} and {three(fitted)}.
- Strains predict the FWD with {three(own["fwd.deflection"])}, where its own fit leaves {three(fwd_alone["fwd.deflection"])}.
- FWD predicts the 650 kPa strains with {three(fwd_alone["dual650.strain_zz"])}, where their own fit leaves {three(own["dual650.strain_zz"])}.

## Figure 6: response to n (table 5's FWD values, n = .40 scaled)

{table(["n", "d0", "base strain, 187.5 mm", "strain at the top of the subgrade"], [[f"{x:+d} %", *[f"{v:+.1f} %" for v in row]] for x, row in zip((-50, -25, 0, 25, 50), change)])}

## What is not reproduced

- Figure 1, the survey of deflection ratios: the station data are not available. `pavescape survey` computes the ratio D250/D0 and
  compares it with its limit of 0.6. On the made-up road `grids/road-example.csv` {ratios(r["survey"])}.
- Figure 5, n varying with place: these fits have one n for the layer; the effect `anisotropy-distribution` lets it rise away from the load.

## The paper's claims

- *n is small under the wheel and larger in FWD data*: {fwd_n}.
- *n grows with base thickness* (144, 150, 277, 300 mm): {trend}.
- *Parameters depend on the kind of data*: fitted alone, the two kinds miss each other by {three(own["fwd.deflection"])} (FWD from strains) and
  {three(fwd_alone["dual650.strain_zz"])} (strains from FWD), against {three(fwd_alone["fwd.deflection"])} and {three(own["dual650.strain_zz"])} when fitted themselves; one joint set leaves
  {three(next(g["rms"] for g in joint["groups"] if g["name"] == "fwd.deflection"))} and {three(fitted)}.
- *d0 and strains react to n*: from -50 % to +50 % of n, d0 goes from {change[0][0]:+.1f} to {change[4][0]:+.1f} %, the base strain from {change[0][1]:+.1f} to {change[4][1]:+.1f} %,
  the strain at the top of the subgrade from {change[0][2]:+.1f} to {change[4][2]:+.1f} %.
"""
    return text


if __name__ == "__main__":
    responses = forwards()
    (ROOT / "docs").mkdir(exist_ok=True)
    (ROOT / "docs/paper.md").write_text(page(fits(), responses))
