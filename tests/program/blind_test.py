"""Blind trials of `pavescape diagnose` on a fixed subset: cases whose truth only the judge reads (tests/blind).

python3 tests/program/blind_test.py PROGRAM GENERATOR [COUNT of each kind, else six cases]
"""
import argparse
import pathlib
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "blind"))
import trials

FIRST = 1001
counts = dict(one=3, none=1, two=1, removed=1)
if len(sys.argv) > 3:
    counts = dict.fromkeys(counts, int(sys.argv[3]))
with tempfile.TemporaryDirectory(prefix="pavescape-blind-") as out:
    results = trials.run_all(argparse.Namespace(program=sys.argv[1], generator=sys.argv[2], **counts, power=0, outside=0, correlated=False, independent=False, first=FIRST, jobs=2,
                                                out=out, keep=False))
failed = False
for r in results:
    if r["verdict"] == "failed":
        print(f"{r['kind']} {r['seed']}: {r['error']}")
        failed = True
# Of so few, one may go wrong by chance, and of the two pairs one.
for name, (count, total) in trials.rates(results).items():
    wrong = count if name == "wrong name alone" else total - count
    print(f"{name}: {trials.share(count, total)}")
    failed = failed or wrong > 1
sys.exit(1 if failed else 0)
