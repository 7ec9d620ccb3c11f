"""The options that the tools have in common: --program, --out, --count."""
import argparse
import os
import pathlib

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAM = ROOT / "build" / "release" / "explore" / "pavescape"


def program(path):
    if not os.access(path, os.X_OK):
        raise argparse.ArgumentTypeError(f"{path} is not there (built by: cmake --build --preset release)")
    return pathlib.Path(path).resolve()


def parser(doc, count=None, of="cases", out=None):
    """--program; with `count` --count and with `out` --out, which have these defaults."""
    made = argparse.ArgumentParser(description=doc, formatter_class=argparse.RawDescriptionHelpFormatter)
    made.add_argument("--program", type=program, default=str(PROGRAM), help="the program (build/release/explore/pavescape)")
    if count is not None:
        made.add_argument("--count", type=int, default=count, help=f"how many: {of} ({count})")
    if out is not None:
        made.add_argument("--out", type=pathlib.Path, default=ROOT / out, help=f"where it writes ({out})")
    return made


def built(program, name):
    """Another program of the same build: "tests/blind_generator"."""
    path = program.parents[1] / name
    if not path.exists():
        raise SystemExit(f"{path} is not there (built by: cmake --build --preset release)")
    return path
