"""Every study in grids/ runs, and gives what its '# test:' lines say.

# test: forward FIRST-LAST = VALUE VALUE ... within PERCENT %      rows counted from 1, values in the unit of the data
"""
import json
import re

import pytest

from support import *

STUDIES = sorted((ROOT / "grids").glob("*.toml"))
# Seconds each, of kinds of which there are others.
SLOW = {"captif-p1-joint", "captif-p1-rlt", "captif-p1-unique-joint", "captif-p3", "captif-p4", "pulse-dual"}


def test_there_are_studies():
    assert STUDIES


@pytest.mark.parametrize("study", [pytest.param(s, marks=[pytest.mark.long] if s.stem in SLOW else [], id=s.stem) for s in STUDIES])
def test_a_study_gives_what_it_says(study):
    done = run("forward", study, "--json")
    assert done.returncode == 0, f"{study.name}: {done.stderr}"
    values = [r["value"] for r in json.loads(done.stdout)["responses"]]
    tests = re.findall(r"^# test: (.*)$", study.read_text(), re.M)
    assert tests, f"{study.name} says what it must give"
    for line in tests:
        match = re.fullmatch(r"forward (\d+)-(\d+) = ([-\d. e]+) within ([\d.]+) %", line)
        assert match, f"{study.name}: '{line}' is not understood"
        first, last = int(match[1]), int(match[2])
        wanted = [float(v) for v in match[3].split()]
        assert len(wanted) == last - first + 1, f"{study.name}: '{line}' names as many rows as values"
        for value, want in zip(values[first - 1:last], wanted):
            assert abs(value / want - 1) <= float(match[4]) / 100, f"{study.name}: {value}, not {want}"
