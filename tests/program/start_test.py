"""The first steps of a user: `new` writes a study, `check` says what would run, `fit` runs it."""
import json

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
for word in ("fwd.deflection: 8", "noise stated", "1 output", "map", "fit", "with derivatives"):
    check(word in page.stdout, f"check says '{word}':\n{page.stdout}")
found = json.loads(run("check", study, "--json").stdout)
check(found["readings"] == 8 and found["parameters"] == 3, "check counts readings and parameters")
times = {c["command"]: c["seconds"] for c in found["commands"]}
check(0 < times["forward"] < times["map"] and times["forward --jacobian"] < times["fit"], f"times: {times}")

fitted = json.loads(run("fit", study, "--explore", "16", "--starts", "2", "--out", folder / "run", "--json").stdout)
check(fitted["best"]["converged"], "the new study can be fitted as it stands")

study.write_text(text.replace("pressure_kPa", "presure_kPa"))
wrong = run("check", study)
check(wrong.returncode == 2 and "presure_kPa" in wrong.stderr, "check finds a misspelt key")

finish()
