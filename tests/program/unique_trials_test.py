"""`pavescape unique` on twins whose layout is deficient or rich (tests/blind/unique_trials.py). --count: twins of each kind for the rates."""
import argparse
import sys

import pytest

from support import *

sys.path.insert(0, str(ROOT / "tests" / "blind"))
import unique_trials  # noqa: E402

OPTIONS = argparse.Namespace(program=PROGRAM, count=COUNT or 4, first=1, correlated=False, other=None)


def test_a_deficient_layout_is_called_non_unique_and_its_direction_named():
    called, named = unique_trials.deficient(OPTIONS, 1)
    assert called, "two readings for three parameters are not unique"
    assert named, "the flat direction is the null vector"


def test_a_rich_layout_is_called_unique():
    called, inside = unique_trials.rich(OPTIONS, 1)
    assert called, "deflections, strains and stresses determine four parameters"
    assert sum(inside.values()) >= len(inside) - 1, f"of five ranges of 95 % one may miss the truth: {inside}"


@pytest.mark.long
def test_rates():
    assert not (wrong := unique_trials.rates(OPTIONS)), wrong
