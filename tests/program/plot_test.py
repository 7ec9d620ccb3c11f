"""Figures as files: of every kind of run that has some, in every format, with the numbers that they show; and the landscape over pairs."""
import csv
import math
import os
import xml.etree.ElementTree

from support import *

folder = workspace()
SIGMAS = [0.04, 20.0, 0.01, 0.00004]  # of the readings, in their units
lines = DATA.strip().splitlines()
data = "\n".join(lines[:2] + [line + str(sigma) for line, sigma in zip(lines[2:], SIGMAS)]) + "\n"
study = write_study(folder / "s", STUDY.replace('misfit = "log"', 'misfit = "weighted"'), data)

done = run("unique", study, "--json", "--out", folder / "unique", "--explore", 16, "--verify", 4, "--landscape")
check(done.returncode == 0, f"unique runs: {done.stderr}")
unique = json.loads(done.stdout)
pair = unique["landscape"]["pairs"][0]
check({pair["x"], pair["y"]} == {"base.k1", "base.n"}, f"one pair of two parameters: {pair['x']}, {pair['y']}")
check(len(pair["rise"]) == len(pair["y_values"]) and all(len(row) == len(pair["x_values"]) for row in pair["rise"]), "rows by columns")
lowest = min(v for row in pair["rise"] for v in row if v is not None)
check(-1e-6 < lowest < 25, f"the rise is above the minimum: {lowest}")
# With two parameters nothing is left to fit: each node is the full model's own chi2 there, whoever asks for it.
best = unique["minima"][0]["misfit"]
low, high = {"base.k1": (500, 8000), "base.n": (0.1, 4.5)}[pair["x"]], {"base.k1": (500, 8000), "base.n": (0.1, 4.5)}[pair["y"]]
check(math.isclose(pair["x_values"][0], low[0]) and math.isclose(pair["y_values"][-1], high[1]), "the grid reaches the bounds")
i, j = len(pair["x_values"]) // 3, len(pair["y_values"]) // 3
at = {pair["x"]: pair["x_values"][i], pair["y"]: pair["y_values"][j]}
text = study.read_text().replace("k1 = 2000", f"k1 = {at['base.k1']!r}").replace("n = 0.5\n", f"n = {at['base.n']!r}\n")
forward = json.loads(run("forward", write_study(folder / "node", text, data), "--json").stdout)
compared = [r for r in forward["responses"] if "measured" in r]
chi2 = sum(((r["value"] - r["measured"]) / sigma) ** 2 for r, sigma in zip(compared, SIGMAS))
rise = pair["rise"][j][i]
check(rise is None or abs(rise - (chi2 - best ** 2)) < 0.02 * max(rise, 1.0), f"a node is chi2 there: {rise} against {chi2 - best ** 2}")

check(run("fit", study, "--out", folder / "fit", "--explore", 16, "--starts", 2).returncode == 0, "fit runs")
check(run("map", study, "--out", folder / "map", "--design", "sobol", "--points", 20).returncode == 0, "map runs")

check(run("compare", study, "--laws", "uzan,k-theta", "--explore", 8, "--verify", 2, "--out", folder / "compare").returncode == 0, "compare runs")
check(run("sensitivity", study, "--samples", 4, "--out", folder / "sensitivity").returncode == 0, "sensitivity runs")
# A diagnosis in numbers made up here: what `plot` draws of it.
made_up = folder / "made-up"
made_up.mkdir()
(made_up / "diagnose.json").write_text(json.dumps({"causes": ["load-magnitude"], "candidates": [{"effect": "load-magnitude", "on": "fwd", "delta_chi2": -9.0, "score_z": 3.0},
    {"effect": "plate-rigidity", "on": "", "delta_chi2": None, "score_z": 1.5}], "corrections": [{"channel": "depth", "layer": "base", "unit": "mm", "at": [50, 150, 250],
    "values": [0.8, 1.0, 1.3], "low": [0.7, 0.5, 1.1], "high": [0.9, 2.0, 1.5], "seen": [True, False, True]}]}))

for name, expected in (("made-up", {"candidates", "corrections"}), ("compare", {"fit"}), ("sensitivity", {"sensitivity"}), ("unique", {"landscape", "profiles", "fit", "residuals"}), ("fit", {"fit", "residuals"}), ("map", {"landscape"})):
    for form in ("svg", "pdf", "png"):
        done = run("plot", folder / name, "--format", form)
        check(done.returncode == 0, f"plot of {name} as {form}: {done.stderr}")
        files = {f.stem: f for f in (folder / name / "figures").glob(f"*.{form}")}
        check(expected <= set(files), f"figures of {name}: {sorted(files)}")
        start = {"svg": b"<?xml", "pdf": b"%PDF", "png": b"\x89PNG"}[form]
        for file in files.values():
            check(file.read_bytes().startswith(start) and file.stat().st_size > 2000, f"{file.name} is a picture")
            if form == "svg":
                xml.etree.ElementTree.parse(file)
tables = {f.name: list(csv.DictReader(f.open())) for f in (folder / "unique" / "figures" / "data").glob("*.csv")}
check(tables and all(rows for rows in tables.values()), f"numbers beside them: {sorted(tables)}")
measured = [float(r["value"]) for rows in tables.values() for r in rows if r.get("series") == "measured"]
check(sorted(measured) == sorted(r["measured"] for r in unique["responses"] if "measured" in r), f"the readings are among them: {measured}")

effects = list(csv.DictReader((made_up / "figures" / "data" / "candidates.csv").open()))
check([(r["effect"], float(r["fall_of_chi2"]), r["named"]) for r in effects] == [("load-magnitude", 9.0, "yes"), ("plate-rigidity", 2.25, "no")], f"falls of chi2: {effects}")
corrected = list(csv.DictReader((made_up / "figures" / "data" / "corrections.csv").open()))
check([(float(r["at"]), float(r["factor"]), r["seen"]) for r in corrected] == [(50, 0.8, "yes"), (150, 1.0, "no"), (250, 1.3, "yes")], f"corrections: {corrected}")
indices = json.loads((folder / "sensitivity" / "sensitivity.json").read_text())["global"]["indices"]
drawn = {(r["response"], r["parameter"], r["index"]): r["value"] for r in csv.DictReader((folder / "sensitivity" / "figures" / "data" / "sensitivity.csv").open())}
check(all(drawn[(i["response"], n, "total")] == ("" if e["value"] is None else repr(e["value"])) or math.isclose(float(drawn[(i["response"], n, "total")]), e["value"])
          for i in indices for n, e in i["total"].items()), f"indices: {drawn}")
laws = {r["series"] for r in csv.DictReader((folder / "compare" / "figures" / "data" / "fit.csv").open())}
check({"measured", "uzan", "k-theta"} <= laws, f"every law is drawn: {laws}")

pair_folder = folder / "pair"
done = run("plot", folder / "unique", "--pair", "base.n,base.k1", "--out", pair_folder)
check(done.returncode == 0 and [f.name for f in pair_folder.glob("*.svg")] in (["landscape-base.k1-base.n.svg"], ["landscape-base.n-base.k1.svg"]), f"one pair: {done.stdout}{done.stderr}")
done = run("plot", folder / "unique", "--pair", "base.n,base.k2")
check(done.returncode == 2 and "base.n,base.k2" in done.stderr and "base.k1" in done.stderr, f"a pair that there is not: {done.stderr}")

one = folder / "one"
check(run("plot", folder / "unique", "residuals", "--out", one).returncode == 0 and [f.name for f in one.glob("*.svg")] == ["residuals.svg"],
      "one figure of one's choice, elsewhere")
done = run("plot", folder / "unique", "bowl")
check(done.returncode == 2 and done.stdout == "" and "bowl" in done.stderr and "landscape" in done.stderr, f"an unknown figure: {done.stderr}")
done = run("plot", folder)
check(done.returncode == 2 and done.stdout == "", f"a folder without a run: {done.stderr}")
empty = folder / "empty"
empty.mkdir()
done = run("plot", folder / "unique", env={**os.environ, "PATH": str(empty)})
check(done.returncode == 2 and "gnuplot-nox" in done.stderr, f"without gnuplot: {done.stderr}")
finish()
