"""A model of one's own as the paper has it: CalculiX with a template, the linear dual wheel, three moduli. It ends where the built-in model ends, whatever the
threads and processes, killed or not. The template is what tools/accuracy/compare-calculix writes, with places for the moduli."""
import math
import re

import numpy as np
import pytest

from mpi_test import ENVIRONMENT, MPIRUN
from support import *

COMPARE = BUILD / "tools/accuracy/calculix/compare_calculix"
pytestmark = [pytest.mark.long, pytest.mark.skipif(shutil.which("ccx") is None, reason="CalculiX (package calculix-ccx) is not installed"),
              pytest.mark.skipif(sanitizer() is not None, reason="nearly all of it is CalculiX")]
ONE_THREAD = {**ENVIRONMENT, "OMP_NUM_THREADS": "1"}  # threads of CalculiX add up in another order each time

MODULI = {"asphalt": (1000, 9000, 3000), "base": (100, 900, 300), "subgrade": (15, 120, 40)}
# Where deflections are read [m]: under a wheel, between the wheels, ahead of them, and in the depth under a wheel.
PLACES = [(0.17, 0, 0), (0, 0, 0), (0.17, 0.2, 0), (0, 0.3, 0), (0, 0.5, 0), (0, 0.8, 0), (0, 1.2, 0), (0.17, 0, 0.307), (0.17, 0, 0.6)]
SIGMA_MM = 0.001
SEARCH = ("--explore", 8, "--starts", 1, "--joint-only")


def built_in(folder, name, refine, nodes, values):
    head = (ROOT / "grids/dual-linear.toml").read_text().split("[mesh]")[0]
    head += f'[mesh]\nextent_m = 2.0\nrefine = {refine}\n[data]\nfiles = ["{name}.csv"]\nmisfit = "weighted"\n'
    for layer, (low, high, _) in MODULI.items():
        head += f'[[parameters]]\nname = "{layer}.modulus_MPa"\nmin = {low}\nmax = {high}\nscale = "log"\n'
    rows = [f"dual,deflection,{1e3 * x},{1e3 * y},{1e3 * z},0,{v!r},mm,{SIGMA_MM}\n" for (x, y, z), v in zip(nodes, values)]
    (folder / f"{name}.csv").write_text("load,quantity,x_mm,y_mm,depth_mm,gauge_mm,value,unit,sigma\n" + "".join(rows))
    (folder / f"{name}.toml").write_text(head)
    return folder / f"{name}.toml"


def forward(study, *more):
    done = run("forward", study, "--json", *more, env=ONE_THREAD)
    assert done.returncode == 0, done.stderr
    answer = json.loads(done.stdout)
    return np.array([r["value"] for r in answer["responses"]]), np.array(answer.get("jacobian", {}).get("rows", []))


def template_of(folder):
    """Writes the template: input of CalculiX with places for the moduli, printing the sensors alone. Gives their nodes, which lie where the built-in model's do."""
    places, nodes = None, np.array(PLACES)
    while not np.array_equal(places, nodes):  # the mesh follows the sensors
        places = nodes
        study = built_in(folder, "coarse", 0.5, places, [1.0] * len(places))
        made = subprocess.run([COMPARE, study], capture_output=True, text=True, cwd=folder, env=ONE_THREAD)
        assert made.returncode == 0, made.stderr
        text = (folder / "output/compare-calculix/coarse/model.inp").read_text()
        all_nodes = np.array([[float(v) for v in line.split(",")[1:]] for line in re.search(r"\*NODE, NSET=ALL\n((?:\d.*\n)+)", text)[1].splitlines()])
        chosen = [int(np.argmin(((all_nodes - place) ** 2).sum(axis=1))) for place in places]
        nodes = all_nodes[chosen]
    for number, layer in enumerate(MODULI, 1):
        text, found = re.subn(rf"(NAME=LAYER{number}\n\*ELASTIC\n)[^,]*,", rf"\g<1>{{{{{layer}.modulus_MPa:%14.8f}}}}E6,", text)  # Pa
        assert found == 1, layer
    head, step = text.split("*STEP\n")
    step = step.split("*NODE PRINT")[0] + "*NODE PRINT, NSET=SENSORS\nU\n*END STEP\n"
    (folder / "dual.inp.in").write_text(head + "*NSET, NSET=SENSORS\n" + "".join(f"{n + 1}\n" for n in chosen) + "*STEP\n" + step)
    return nodes


@pytest.fixture(scope="module")
def studies():
    folder = workspace()
    nodes = template_of(folder)
    # Readings: what the finer mesh says for the moduli of the study.
    fine = built_in(folder, "fine", 1.0, nodes, [1.0] * len(nodes))
    readings = forward(fine)[0]
    fine, coarse = built_in(folder, "fine", 1.0, nodes, readings), built_in(folder, "coarse", 0.5, nodes, readings)
    (folder / "calculix.csv").write_text("name,value,unit,sigma\n" + "".join(f"node {k},{v / 1e3!r},m,{SIGMA_MM / 1e3}\n" for k, v in enumerate(readings, 1)))
    outputs = "".join(f'  {{ reading = "node {k}", file = "dual.dat", line = "{k + 1} after \'displacements\'", column = 4 }},\n' for k in range(1, len(nodes) + 1))
    text = ('schema = 1\n[model]\ntype = "program"\ncommand = ["ccx", "dual"]\ninputs = [{ template = "dual.inp.in", file = "dual.inp" }]\n'
            f'outputs = [\n{outputs}]\ntime_limit_s = 120\n[data]\nfiles = ["calculix.csv"]\nmisfit = "weighted"\n')
    for layer, (low, high, value) in MODULI.items():
        text += f'[[parameters]]\nname = "{layer}.modulus_MPa"\nmin = {low}\nmax = {high}\nscale = "log"\nvalue = {value}\n'
    (folder / "calculix.toml").write_text(text)
    return {"calculix": folder / "calculix.toml", "coarse": coarse, "fine": fine, "readings": readings}


def best(study, out, *options):
    done = run("fit", study, "--json", *options, "--out", out, env=ONE_THREAD)
    assert done.returncode == 0, done.stderr
    return np.array(list(json.loads(done.stdout)["best"]["parameters"].values()))


def test_the_template_gives_what_the_built_in_model_gives_on_the_same_mesh(studies):
    own, (direct, _) = forward(studies["calculix"])[0], forward(studies["coarse"])
    assert 1e3 * own == pytest.approx(direct, rel=2e-6), "CalculiX prints seven digits"
    assert own * 1e3 != pytest.approx(studies["readings"], rel=1e-4), "the meshes differ by more than that"


@pytest.fixture(scope="module")
def fitted(studies):
    out = workspace()
    return best(studies["calculix"], out / "out", *SEARCH, "--threads", 2), result(out / "out", "fit"), evaluations(out / "out")


def test_fit_ends_where_the_built_in_model_ends(studies, fitted):
    found = fitted[0]
    on_same, on_fine = (best(studies[name], workspace() / "out", *SEARCH) for name in ("coarse", "fine"))
    truth = np.array([value for _, _, value in MODULI.values()])
    assert on_fine == pytest.approx(truth, rel=1e-4)
    assert found == pytest.approx(on_same, rel=1e-3), "the same mesh"
    # Of another mesh: where least squares move for the difference of the responses, d = -(J'J)^-1 J'r in logarithms.
    responses, jacobian = forward(studies["coarse"], "--jacobian")
    moved = -np.linalg.lstsq(jacobian * truth, responses - studies["readings"], rcond=None)[0]
    print("built-in, fine", on_fine, "built-in, coarse", on_same, "CalculiX", found, "expected", truth * np.exp(moved))
    assert np.log(found / truth) == pytest.approx(moved, rel=0.1, abs=2e-3), "the difference of the meshes"


def test_unique_says_what_it_says_of_the_built_in_model(studies):
    answers = []
    for name in ("coarse", "calculix"):
        done = run("unique", studies[name], "--json", "--out", workspace() / "out", "--threads", 2, env=ONE_THREAD)
        assert done.returncode == 0, done.stderr
        answers.append(json.loads(done.stdout))
        print(name, answers[-1]["verdict"], [(p["name"], p["low"], p["high"]) for p in answers[-1]["profiles"]], answers[-1]["minima"][0]["parameters"])
    direct, own = answers
    assert own["verdict"] == direct["verdict"]
    assert len(own["minima"]) == len(direct["minima"])
    for a, b in zip(own["profiles"], direct["profiles"]):
        for end in ("low", "high"):
            width = math.log(b["high"] / b["low"])
            assert abs(math.log(a[end] / b[end])) < 0.05 * width, (a["name"], end, a[end], b[end])


def test_one_thread_and_two_processes_end_with_the_same_bits(studies, fitted):
    out = workspace()
    best(studies["calculix"], out / "one", *SEARCH, "--threads", 1)
    assert result(out / "one", "fit") == fitted[1]
    if MPIRUN is None:
        return
    done = subprocess.run([MPIRUN, "-n", "2", "--oversubscribe", PROGRAM, "fit", studies["calculix"], *map(str, SEARCH), "--threads", "1", "--out", out / "two"],
                          capture_output=True, text=True, env=ONE_THREAD, timeout=1800)
    assert done.returncode == 0, done.stderr
    assert re.search(r"2 processes: [1-9]\d* evaluations by the others", done.stderr), done.stderr
    assert result(out / "two", "fit") == fitted[1]


def test_killed_and_continued(studies, fitted, monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "1")
    out = workspace() / "cut"
    kept = kill_at(fitted[2] // 2, out, "fit", studies["calculix"], *SEARCH, "--threads", 2)
    assert fitted[2] // 2 <= kept < fitted[2], kept
    best(studies["calculix"], out, *SEARCH, "--threads", 2)
    assert result(out, "fit") == fitted[1]
