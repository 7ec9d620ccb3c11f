"""Replays the kept inputs of a fuzz target and random changes of them. usage: replay.py PROGRAM TARGET [CHANGES [SEED]]"""
import pathlib
import random
import subprocess
import sys
import tarfile
import tempfile

here = pathlib.Path(__file__).resolve().parent
program, target = sys.argv[1:3]
changes = sys.argv[3] if len(sys.argv) > 3 else "20000"
seed = sys.argv[4] if len(sys.argv) > 4 else str(random.SystemRandom().randrange(10**9))
with tempfile.TemporaryDirectory() as folder:
    with tarfile.open(here / "corpus" / f"{target}.tar.gz") as kept:
        kept.extractall(folder)
    print("seed", seed)
    done = subprocess.run([program, folder, changes, seed], timeout=600)
sys.exit(done.returncode)
