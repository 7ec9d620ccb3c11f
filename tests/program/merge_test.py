"""`merge`: two runs of one study become one; where they cannot, neither is touched."""
import json

import pytest

from support import *

folder = workspace()
study = write_study(folder)


def mapped(name, points, *more):
    out = folder / name
    done = run("map", study, "--design", "sobol", "--points", points, "--out", out, *more)
    assert done.returncode == 0, done.stderr
    return out


def rows(out, command):
    """{(start, number): (status, parameters, responses)} of the runs of a command"""
    database = sqlite3.connect(out / "run.sqlite")
    found = database.execute("SELECT start, number, status, parameters, responses FROM evaluation JOIN run ON run = run.id WHERE command = ?", (command,))
    return {(start, number): values for start, number, *values in found}


@pytest.fixture(scope="module")
def halves():
    """A map of some points, and one of more with a fit: what two machines may have done of the same work."""
    first, second = mapped("first", 12), mapped("second", 24)
    fit = run("fit", study, "--explore", 24, "--starts", 2, "--out", second)
    assert fit.returncode == 0, fit.stderr
    return first, second


def copied(out, name):
    return shutil.copytree(out, folder / name)


def test_the_first_gets_what_the_second_has_and_continues_as_if_it_had_done_it_all(halves):
    first, second = copied(halves[0], "whole"), halves[1]
    told = json.loads(run("merge", first, second, "--json").stdout)
    assert told["compared"] == 12 and told["added"] == evaluations(second) - 12 and told["evaluations"] == evaluations(second), told
    for command in ("map", "fit"):
        assert rows(first, command) == rows(second, command), command
    again = run("fit", study, "--explore", 24, "--starts", 2, "--json", "--out", first)
    assert evaluations(first) == evaluations(second), "a command that is repeated there computes nothing"
    assert without_run(json.loads(again.stdout)) == without_run(result(second, "fit")[0])
    twice = json.loads(run("merge", first, second, "--json").stdout)
    assert twice["added"] == 0 and twice["evaluations"] == told["evaluations"], twice


def test_a_new_folder_holds_both_and_the_two_stay_as_they_were(halves):
    before = [(out / "run.sqlite").read_bytes() for out in halves]
    done = run("merge", *halves, "--out", folder / "both")
    assert done.returncode == 0 and "now holds" in done.stdout, done.stderr
    assert rows(folder / "both", "map") == rows(halves[1], "map")
    assert [(out / "run.sqlite").read_bytes() for out in halves] == before


def refused(first, second, *words):
    before = rows(first, "map")
    done = run("merge", first, second)
    assert done.returncode == 2 and len(done.stderr.strip().splitlines()) == 1, done.stderr
    assert all(word in done.stderr for word in words), done.stderr
    assert rows(first, "map") == before


def test_one_bit_that_differs_is_named_and_nothing_is_merged(halves):
    first, second = halves[0], copied(halves[1], "spoilt")
    database = sqlite3.connect(second / "run.sqlite")
    where = "run = (SELECT id FROM run WHERE command = 'map') AND number = 7"
    bits = bytearray(database.execute(f"SELECT responses FROM evaluation WHERE {where}").fetchone()[0])
    bits[0] ^= 1
    database.execute(f"UPDATE evaluation SET responses = ? WHERE {where}", (bytes(bits),))
    database.commit()
    database.close()
    refused(first, second, "differ", "point 7")


def test_other_studies_folders_without_a_run_and_a_run_with_itself_are_refused(halves):
    other = folder / "other"
    other.mkdir()
    elsewhere = write_study(other, STUDY.replace("modulus_MPa = 3000", "modulus_MPa = 3100", 1))
    out = folder / "strange"
    done = run("map", elsewhere, "--design", "sobol", "--points", 4, "--out", out)
    assert done.returncode == 0, done.stderr
    refused(halves[0], out, "another study", "line")
    refused(halves[0], folder, "run")
    refused(halves[0], halves[0], "with itself")
    assert run("merge", *halves, "--out", halves[1]).returncode == 2
