"""Blind trials of `pavescape diagnose` on a fixed subset: twenty cases whose truth only the judge reads (tests/blind).

python3 tests/program/blind_test.py PROGRAM GENERATOR
"""
import argparse
import pathlib
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "blind"))
import trials

FIRST = 1001
options = argparse.Namespace(program=sys.argv[1], generator=sys.argv[2], one=12, none=5, two=2, removed=1, power=0, first=FIRST,
                             jobs=2, out=tempfile.mkdtemp(prefix="pavescape-blind-"), keep=False)
rates = trials.rates(trials.run_all(options))
# Of so few, one may go wrong by chance, and of the two pairs one.
failed = False
for name, (count, total) in rates.items():
    wrong = count if name == "wrong name alone" else total - count
    print(f"{name}: {trials.share(count, total)}")
    failed = failed or wrong > 1
sys.exit(1 if failed else 0)
