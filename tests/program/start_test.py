"""The first steps of a user: `new` writes a study, `check` says what would run, `fit` runs it."""
import json
import math

from support import *

folder = workspace()
study = folder / "road.toml"
done = run("new", study)
check(done.returncode == 0 and study.exists() and (folder / "road.csv").exists(), f"new writes a study and its readings: {done.stderr}")
check(str(study) in done.stdout, "new says what it wrote")
text = study.read_text()
again = run("new", study)
check(again.returncode == 2 and "there already" in again.stderr and study.read_text() == text, "new overwrites nothing")
for name, word in (("road.txt", "NAME.toml"), ('a"b.toml', "letters")):
    wrong = run("new", folder / name)
    check(wrong.returncode == 2 and word in wrong.stderr, f"new refuses {name}: {wrong.stderr}")

page = run("check", study)
check(page.returncode == 0, f"check of a new study: {page.stderr}")
for word in ("fwd.deflection: 8", "noise stated", "2 outputs", "map", "fit", "with derivatives"):
    check(word in page.stdout, f"check says '{word}':\n{page.stdout}")
found = json.loads(run("check", study, "--json").stdout)
check(found["readings"] == 8 and found["parameters"] == 3, "check counts readings and parameters")
check({"unique", "diagnose", "compare", "sensitivity"} <= {c["command"] for c in found["commands"]}, f"every command has an estimate: {found['commands']}")
times = {c["command"]: c["seconds"] for c in found["commands"]}
check(0 < times["forward"] < times["map"] and times["forward --jacobian"] < times["fit"], f"times: {times}")

fitted = json.loads(run("fit", study, "--explore", "16", "--starts", "2", "--out", folder / "run", "--json").stdout)
check(fitted["best"]["converged"], "the new study can be fitted as it stands")
check(fitted["at_bounds"] == [] and fitted["noise"]["p_value"] > 0.05, f"with a sensible answer: {fitted['at_bounds']} {fitted['noise']}")
for name, truth in (("asphalt.modulus_MPa", 3500), ("base.k1", 1400), ("subgrade.modulus_MPa", 65)):
    value, error = fitted["best"]["parameters"][name], fitted["best"]["std_error"][name]
    check(abs(value - truth) < 3 * error and error < 0.3 * value, f"{name}: {value} +- {error}, the readings were made with {truth}")

# Of a station of an FWD file: its drops by hand.
station = folder / "station.toml"
done = run("new", station, "--from", ROOT / "grids" / "road-north.f25", "--station", "100")
check(done.returncode == 0 and str(station) in done.stdout, f"new writes a study of a station: {done.stderr}")
drops = [[565, 468, 371, 300, 219, 156, 75], [571, 470, 374, 304, 221, 158, 76]]  # pressure, deflections; the first of three seats the plate
pressure = sum(d[0] for d in drops) / 2
rows = [line.split(",") for line in (folder / "station.csv").read_text().splitlines() if line.startswith("fwd-568kPa")]
check(f"pressure_kPa = {pressure:g} " in station.read_text() and len(rows) == 6, f"the load and the sensors: {rows}")
for row, offset, own in zip(rows, (0, 200, 300, 450, 600, 900), zip(*(d[1:] for d in drops))):
    median = sum(v * pressure / d[0] for v, d in zip(own, drops)) / 2
    check(float(row[2]) == offset and abs(float(row[6]) - median) < 0.006 and row[7] == "um", f"the median of its drops: {row}, {median}")
    check(math.sqrt(1 + (0.01 * median) ** 2) < float(row[8]) < math.sqrt(1 + (0.02 * median) ** 2), f"its noise: {row}")
done = run("fit", station, "--explore", "16", "--starts", "2", "--out", folder / "station", "--json")
check(done.returncode == 0 and json.loads(done.stdout)["best"]["converged"], f"and fits: {done.stderr}")
levels = folder / "levels.csv"
levels.write_text("station,drop,radius_mm,pressure_kPa,D0_um,D300_um,D600_um,D900_um,D1200_um\n" + "".join(
    f"7,{k},150,{p},{p * a:.1f},{p * 0.6 * a:.1f},{p * 0.3 * a:.1f},{p * 0.2 * a:.1f},{p * 0.14 * a:.1f}\n" for k, (p, a) in enumerate(((400, 0.9), (560, 0.88), (800, 0.86)), 1)))
done = run("new", "--from", levels, "--station", "7", cwd=folder)
check(done.returncode == 0 and (folder / "levels-7.toml").exists(), f"a name of its own: {done.stdout} {done.stderr}")
check((folder / "levels-7.toml").read_text().count("[[loads]]") == 3 and json.loads(run("forward", folder / "levels-7.toml", "--json").stdout)["status"] == "converged",
      "every level is a load")
for arguments, word in ((("--station", "9"), "7"), ((folder / "x.toml", "--station", "7"), "--from"), ((), "FILE")):
    done = run("new", *(("--from", levels) if word == "7" else ()), *arguments, cwd=folder)
    check(done.returncode == 2 and done.stdout == "" and word in done.stderr, f"new {arguments}: {done.returncode} {done.stderr}")

study.write_text(text.replace("pressure_kPa", "presure_kPa"))
wrong = run("check", study)
check(wrong.returncode == 2 and "presure_kPa" in wrong.stderr, "check finds a misspelt key")

finish()
