"""`rerun` repeats what a folder holds and finds the first bit that differs."""
import json
import struct

from support import *

folder = workspace()
study = write_study(folder)
out = folder / "run"
check(run("map", study, "--design", "sobol", "--points", 24, "--out", out).returncode == 0, "map")
check(run("fit", "small.toml", "--explore", 24, "--starts", 2, f"--out={out}", cwd=folder).returncode == 0, "fit")

done = run("rerun", out)
check(done.returncode == 0 and "The same to the last bit" in done.stdout and "4 runs" in done.stdout, f"the same: {done.stdout} {done.stderr}")
same = json.loads(run("rerun", out, "--json").stdout)
check(same["same"] and same["first_difference"] == "" and same["evaluations"] == evaluations(out), f"the same: {same}")
check(same["then"][0]["arguments"][0] == "map" and "Eigen" in same["now"]["libraries"], "what was repeated, and with what")

# One bit of one response.
database = sqlite3.connect(out / "run.sqlite")
fits = "run = (SELECT id FROM run WHERE command = 'fit')"
search, = database.execute(f"SELECT max(start) FROM evaluation WHERE {fits}").fetchone()
where = f"{fits} AND start = {search} AND number = 2"
responses, = database.execute(f"SELECT responses FROM evaluation WHERE {where}").fetchone()
values = list(struct.unpack(f"{len(responses) // 8}d", responses))
bits = bytearray(responses)
bits[8] ^= 1
database.execute(f"UPDATE evaluation SET responses = ? WHERE {where}", (bytes(bits),))
database.commit()
done = run("rerun", out)
check(done.returncode == 1 and f"fit, search {search}, evaluation 2: response fwd.deflection@300,0,0" in done.stdout, f"one bit: {done.stdout}")
database.execute(f"UPDATE evaluation SET responses = ? WHERE {where}", (responses,))

# One evaluation more, and one less.
database.execute("DELETE FROM evaluation WHERE run = 1 AND number = 5")
database.commit()
check("map, point 5: not computed then" in run("rerun", out).stdout, "an evaluation that the run lacks")
database.execute("UPDATE evaluation SET number = 99 WHERE run = 1 AND number = 6")
database.commit()
check("map, point 99: not computed now" in run("rerun", out).stdout, "an evaluation that only the run has")

# What a store names is not obeyed.
database.execute("""UPDATE session SET arguments = '["export", "/etc"]' WHERE id = 1""")
database.commit()
done = run("rerun", out)
check(done.returncode == 2 and '"export"' in done.stderr and done.stdout == "", f"another command: {done.stderr}")
database.close()

# The study and its data are changed, then gone: the run keeps what it read.
out = folder / "other"
(folder / "small.csv").write_text(DATA.replace("520", "521"))
check(run("map", study, "--design", "sobol", "--points", 4, "--out", out).returncode == 0, "map")
(folder / "small.csv").write_text(DATA)
check(run("fit", "small.toml", "--explore", 8, "--starts", 1, f"--out={out}", cwd=folder).returncode == 0, "fit on other data")
done = run("rerun", out)
check(done.returncode == 0 and "The same to the last bit" in done.stdout, f"changed data: {done.stdout} {done.stderr}")
check(done.stderr.count("changed since") == 1, f"said of the session whose data were changed: {done.stderr}")
kept = pathlib.Path(study).read_text()
pathlib.Path(study).unlink()
(folder / "small.csv").unlink()
done = run("rerun", out)
check(done.returncode == 0 and "The same to the last bit" in done.stdout, f"no study any more: {done.stdout} {done.stderr}")
check(run("report", out).returncode == 0, "report")
page = (out / "report.html").read_text()
check("[[parameters]]" in page and "has not kept" not in page, "the page shows the study as it was run")
titled = write_study(folder / "titled")
check(run("map", titled, "--design", "sobol", "--points", 8, "--out", folder / "both").returncode == 0, "map")
write_study(folder / "titled", titled.read_text().replace("A small study", "Another title"))
check(run("report", folder / "both").returncode == 0, "report")
page = (folder / "both" / "report.html").read_text()
check("[[layers]]" in page and "Another title" not in page, "a changed title hides nothing: the study as it was run")
road_study = write_study(folder / "road", (ROOT / "grids" / "road-example.toml").read_text(), None)
road = ROOT / "grids" / "road-example.csv"
check(run("survey", road, "--study", road_study, "--out", folder / "surveyed").returncode == 0, "survey")
road_study.unlink()
check(run("report", folder / "surveyed").returncode == 0, "report of a survey")
page = (folder / "surveyed" / "report.html").read_text()
check("[[layers]]" in page and "can no longer be read" not in page, "and the survey's study, which is gone too")
check(run("rerun", folder / "nowhere").returncode == 2, "no such folder")

finish()
