"""What the tests of the program share: the program and how it is run, small studies, cases of one helper."""
import atexit
import json
import os
import pathlib
import select
import shutil
import sqlite3
import subprocess
import tempfile
import time

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
# Options of conftest.py.
PROGRAM = str(pathlib.Path(os.environ.get("PAVESCAPE", ROOT / "build/release/explore/pavescape")).resolve())
COUNT = int(os.environ["PAVESCAPE_COUNT"]) if "PAVESCAPE_COUNT" in os.environ else None
BUILD = pathlib.Path(PROGRAM).parents[1]  # whose tests/ holds what else is run: generators of blind data, a clock that jumps


def run(*arguments, **options):
    """The finished program: returncode, stdout, stderr as text."""
    return subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True, timeout=3600, **options)


def case(label, *arguments, **options):
    """A call of a helper whose first argument is a label: one of `cases`."""
    return pytest.param((label, *arguments), options, id=label)


def cases(*calls):
    """A test of (arguments, options) for each call, named by its label."""
    return pytest.mark.parametrize("arguments, options", calls)


def workspace():
    """A temporary folder, removed at exit."""
    folder = pathlib.Path(tempfile.mkdtemp(prefix="pavescape-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return folder


def reader_of_pages():
    """{cwd, env} of someone who follows a page: a folder with grids/, and `pavescape` is the program under test."""
    folder = workspace()
    shutil.copytree(ROOT / "grids", folder / "grids")
    return {"cwd": folder, "env": {**os.environ, "PATH": f"{pathlib.Path(PROGRAM).resolve().parent}:{os.environ['PATH']}"}}


def sanitizer():
    """What the program is instrumented with: "address", "thread" or None."""
    binary = pathlib.Path(PROGRAM).read_bytes()
    return next((name for name in ("address", "thread") if f"__{name[0]}san_init".encode() in binary), None)


def leaks_of_others():
    """The environment where foreign software keeps memory to its end: the address sanitizer does not look for leaks."""
    return {**os.environ, "ASAN_OPTIONS": os.environ.get("ASAN_OPTIONS", "") + ":detect_leaks=0"}


def counted(out):
    """(finished evaluations of a run folder, evaluations that some process computed)"""
    database = sqlite3.connect(f"file:{out / 'run.sqlite'}?mode=ro", uri=True, timeout=10)
    try:
        assert database.execute("PRAGMA integrity_check").fetchone()[0] == "ok", f"{out.name}: the store is sound"
        return (database.execute("SELECT count(*) FROM evaluation").fetchone()[0],
                database.execute("SELECT total(evaluations) FROM session").fetchone()[0])
    finally:
        database.close()


def evaluations(out):
    """How many evaluations the store of a run folder holds."""
    if not (out / "run.sqlite").exists():
        return 0
    database = sqlite3.connect(f"file:{out / 'run.sqlite'}?mode=ro", uri=True, timeout=10)
    try:
        return database.execute("SELECT count(*) FROM evaluation").fetchone()[0]
    except sqlite3.OperationalError:
        return 0
    finally:
        database.close()


def kill_at(count, out, *arguments):
    """Starts the program with --out OUT and kills it once its store holds so many evaluations; how many it holds then."""
    process = subprocess.Popen([PROGRAM, *map(str, arguments), "--out", str(out)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    while process.poll() is None and evaluations(out) < count:
        time.sleep(0.01)
    process.kill()
    process.wait()
    return evaluations(out)


def said_until(words, process, seconds):
    """What a process has written to standard error once these words are among it, it has ended or so many seconds have passed."""
    text, until = b"", time.monotonic() + seconds
    while words.encode() not in text and process.poll() is None and time.monotonic() < until:
        if select.select([process.stderr], [], [], 0.05)[0]:
            text += os.read(process.stderr.fileno(), 65536)
    return text.decode()


def peak_MB(*arguments):
    """The most memory of the finished program."""
    process = subprocess.Popen([PROGRAM, *map(str, arguments)], stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    assert process.returncode == 0, f"{arguments[0]}: exit status {process.returncode}"
    return usage.ru_maxrss / 1024


# Of a result: what is of the process that printed it.
OF_THE_PROCESS = {"run", "runs_per_second", "computed", "kept", "seconds"}


def lasting(value):
    if isinstance(value, dict):
        return {k: lasting(v) for k, v in value.items() if k not in OF_THE_PROCESS}
    return [lasting(v) for v in value] if isinstance(value, list) else value


def without_run(result):
    """A result but for the folder of its run."""
    return {key: value for key, value in result.items() if key != "run"}


def result(out, name):
    """Everything that lasts of a finished run, out of its folder."""
    text = (out / f"{name}.json").read_text().replace(str(out), "OUT")
    tables = run("export", out, "--command", name, "--format", "csv")
    return lasting(json.loads(text)), tables.stdout if tables.returncode == 0 else tables.stderr


STUDY = """schema = 1
title = "A small study"

[[layers]]
name = "asphalt"
thickness_mm = 40
density_kg_m3 = 2300
k0 = 0.5
law = "linear"
modulus_MPa = 3000
poisson = 0.35

[[layers]]
name = "base"
thickness_mm = 250
density_kg_m3 = 2200
k0 = 0.5
law = "uzan"
k1 = 2000
k2 = 0.5
k3 = -0.3
n = 0.5
poisson_12 = 0.35
poisson_31 = 0.35

[[layers]]
name = "subgrade"
thickness_mm = 1210
density_kg_m3 = 1900
k0 = 0.5
law = "linear"
modulus_MPa = 45
poisson = 0.40

[[loads]]
name = "fwd"
type = "plate"
radius_mm = 150
pressure_kPa = 600

[mesh]
extent_m = 3.0
refine = 0.4

[data]
files = ["small.csv"]
misfit = "log"

[[parameters]]
name = "base.k1"
min = 500
max = 8000
scale = "log"
points = 4

[[parameters]]
name = "base.n"
min = 0.1
max = 4.5
points = 3

[[outputs]]
name = "subgrade-top-strain"
load = "fwd"
quantity = "strain_zz"
depth_mm = 310
"""
# What a survey fits of its layers.
SURVEYED = """[data]
misfit = "relative"

[[parameters]]
name = "base.k1"
min = 300
max = 10000
scale = "log"

[[parameters]]
name = "subgrade.modulus_MPa"
min = 20
max = 300
scale = "log"
"""

DATA = """# made up, of the right size
load,quantity,x_mm,y_mm,depth_mm,gauge_mm,value,unit,sigma
fwd,deflection,0,0,0,0,0.95,mm,
fwd,deflection,300,0,0,0,520,um,
fwd,deflection,600,0,0,0,0.21,mm,
fwd,strain_zz,0,0,180,75,0.0008,strain,
"""


# Linear layers under a plate, where a run takes a millisecond: one parameter, and the bowl of the section at 450 MPa with 1 % noise stated.
LAYERED = (ROOT / "grids" / "layered-bowl.toml").read_text().split("[[outputs]]")[0] + """
[data]
files = ["small.csv"]
misfit = "weighted"

[[parameters]]
name = "base.modulus_MPa"
min = 100
max = 1500
scale = "log"
"""
LAYERED_BOWL = "load,quantity,x_mm,y_mm,depth_mm,gauge_mm,value,unit,sigma\n" + "".join(
    f"fwd,deflection,{x},0,0,0,{v},mm,{0.01 * v}\n"
    for x, v in {0: 0.5118775, 300: 0.3770507, 600: 0.2719947, 900: 0.2076303, 1800: 0.1101516}.items())


def write_study(folder, study=STUDY, data=DATA, name="small"):
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"{name}.toml").write_text(study)
    if data is not None:
        (folder / "small.csv").write_text(data)
    return folder / f"{name}.toml"


# A half-space under a plate, whose deflections are c/E: what is expected of one stiffness has closed forms.
HALF_SPACE = """schema = 1
title = "A half-space"
[section]
bottom = "half-space"
[[layers]]
name = "subgrade"
density_kg_m3 = 2000
k0 = 0.5
law = "linear"
modulus_MPa = 100
poisson = 0.4
[[loads]]
name = "fwd"
type = "plate"
radius_mm = 150
pressure_kPa = 700
[data]
files = ["bowl.csv"]
"""
OF_HALF_SPACE = '[[parameters]]\nname = "subgrade.modulus_MPa"\nmin = 20\nmax = 400\nscale = "log"\n'


def half_space_study(here, offsets, cells, sigma, more):
    """The study of a half-space whose bowl has these cells (mm) and this sigma; more: of [data], then the parameters."""
    here.mkdir(exist_ok=True)
    (here / "bowl.csv").write_text("load,quantity,x_mm,y_mm,depth_mm,gauge_mm,value,unit,sigma\n" +
                                   "".join(f"fwd,deflection,{x},0,0,0,{v},mm,{sigma}\n" for x, v in zip(offsets, cells)))
    (here / "study.toml").write_text(HALF_SPACE + more)
    return here / "study.toml"
