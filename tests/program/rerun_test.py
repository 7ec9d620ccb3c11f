"""`rerun` repeats what a folder holds and finds the first bit that differs."""
import json
import struct

import pytest

from support import *

folder = workspace()
study = write_study(folder)


@pytest.fixture(scope="module")
def out():
    out = folder / "run"
    assert run("map", study, "--design", "sobol", "--points", 24, "--out", out).returncode == 0, "map"
    assert run("fit", "small.toml", "--explore", 24, "--starts", 2, f"--out={out}", cwd=folder).returncode == 0, "fit"
    return out


def test_what_is_repeated_is_the_same_to_the_last_bit(out):
    done = run("rerun", out)
    assert done.returncode == 0 and "The same to the last bit" in done.stdout and "4 runs" in done.stdout, f"the same: {done.stdout} {done.stderr}"
    same = json.loads(run("rerun", out, "--json").stdout)
    assert same["same"] and same["first_difference"] == "" and same["evaluations"] == evaluations(out), f"the same: {same}"
    assert same["then"][0]["arguments"][0] == "map" and "Eigen" in same["now"]["libraries"], "what was repeated, and with what"


def copied(out, name):
    """A run of your own, to be spoilt."""
    return shutil.copytree(out, folder / name)


def test_one_bit_or_one_evaluation_is_found(out):
    out = copied(out, "one-bit")
    database = sqlite3.connect(out / "run.sqlite")
    fits = "run = (SELECT id FROM run WHERE command = 'fit')"
    search, = database.execute(f"SELECT max(start) FROM evaluation WHERE {fits} AND number = 2").fetchone()
    where = f"{fits} AND start = {search} AND number = 2"
    responses, = database.execute(f"SELECT responses FROM evaluation WHERE {where}").fetchone()
    values = list(struct.unpack(f"{len(responses) // 8}d", responses))
    bits = bytearray(responses)
    bits[8] ^= 1
    database.execute(f"UPDATE evaluation SET responses = ? WHERE {where}", (bytes(bits),))
    database.commit()
    done = run("rerun", out)
    assert done.returncode == 1 and f"fit, search {search}, evaluation 2: response fwd.deflection@300,0,0" in " ".join(done.stdout.split()), f"one bit: {done.stdout}"
    database.execute(f"UPDATE evaluation SET responses = ? WHERE {where}", (responses,))

    # One evaluation more, and one less.
    database.execute("DELETE FROM evaluation WHERE run = 1 AND number = 5")
    database.commit()
    assert "map, point 5: not computed then" in " ".join(run("rerun", out).stdout.split()), "an evaluation that the run lacks"
    database.execute("UPDATE evaluation SET number = 99 WHERE run = 1 AND number = 6")
    database.commit()
    assert "map, point 99: not computed now" in " ".join(run("rerun", out).stdout.split()), "an evaluation that only the run has"
    database.close()


def test_what_a_store_names_is_not_obeyed(out):
    out = copied(out, "another-command")
    database = sqlite3.connect(out / "run.sqlite")
    database.execute("""UPDATE session SET arguments = '["export", "/etc"]' WHERE id = 1""")
    database.commit()
    done = run("rerun", out)
    database.close()
    assert done.returncode == 2 and '"export"' in done.stderr and done.stdout == "", f"another command: {done.stderr}"


def test_a_run_keeps_the_study_and_data_that_it_read():
    # The study and its data are changed, then gone: the run keeps what it read.
    out = folder / "other"
    (folder / "small.csv").write_text(DATA.replace("520", "521"))
    assert run("map", study, "--design", "sobol", "--points", 4, "--out", out).returncode == 0, "map"
    (folder / "small.csv").write_text(DATA)
    assert run("fit", "small.toml", "--explore", 8, "--starts", 1, f"--out={out}", cwd=folder).returncode == 0, "fit on other data"
    done = run("rerun", out)
    assert done.returncode == 0 and "The same to the last bit" in done.stdout, f"changed data: {done.stdout} {done.stderr}"
    assert done.stderr.count("changed since") == 1, f"said of the session whose data were changed: {done.stderr}"
    kept = pathlib.Path(study).read_text()
    pathlib.Path(study).unlink()
    (folder / "small.csv").unlink()
    done = run("rerun", out)
    assert done.returncode == 0 and "The same to the last bit" in done.stdout, f"no study any more: {done.stdout} {done.stderr}"
    assert run("report", out).returncode == 0, "report"
    page = (out / "report.html").read_text()
    assert "[[parameters]]" in page and "has not kept" not in page, "the page shows the study as it was run"


def test_a_changed_title_hides_nothing():
    titled = write_study(folder / "titled")
    assert run("map", titled, "--design", "sobol", "--points", 8, "--out", folder / "both").returncode == 0, "map"
    write_study(folder / "titled", titled.read_text().replace("A small study", "Another title"))
    assert run("report", folder / "both").returncode == 0, "report"
    page = (folder / "both" / "report.html").read_text()
    assert "[[layers]]" in page and "Another title" not in page, "a changed title hides nothing: the study as it was run"


def test_a_report_of_a_survey_whose_study_is_gone():
    road_study = write_study(folder / "road", (ROOT / "grids" / "road-example.toml").read_text(), None)
    road = ROOT / "grids" / "road-example.csv"
    assert run("survey", road, "--study", road_study, "--out", folder / "surveyed").returncode == 0, "survey"
    road_study.unlink()
    assert run("report", folder / "surveyed").returncode == 0, "report of a survey"
    page = (folder / "surveyed" / "report.html").read_text()
    assert "[[layers]]" in page and "can no longer be read" not in page, "and the survey's study, which is gone too"


def test_no_such_folder():
    assert run("rerun", folder / "nowhere").returncode == 2, "no such folder"
