"""A Python function as the model, results as objects, roads and pages from Python, the notebook, and what help() and stubs say."""
import ast
import json
import re
import signal
import subprocess
import time

import numpy as np
from support import BUILD, ROOT, evaluations, workspace
from python_test import environment, layered, python

# Levels of two tanks that empty: alike for exchanged times. Readings without error, so that both minima lie at the truth.
DECAY = """
import numpy as np, pavescape
times = np.arange(1.0, 11.0)
def decay(x):
    return (np.exp(-times / x[0]) + np.exp(-times / x[1])) / 2
def slopes(x):
    return np.column_stack([np.exp(-times / t) * times / t**2 / 2 for t in x])
ranges = [pavescape.Parameter("fast", 0.2, 20, 2.0, "log"), {"name": "slow", "low": 0.2, "high": 20, "scale": "log"}]
readings = (decay([1.2, 7.0]), 0.01)
"""


def test_rosenbrock_ends_at_its_minimum():
    said = json.loads(python("""
import json, pavescape
p = pavescape.Problem([("x", -2, 2, -1.2), ("y", -1, 3, 1)], ([0.0, 0.0], 1.0), lambda x: [10 * (x[1] - x[0]**2), 1 - x[0]])
fit = p.fit(threads=2)
print(json.dumps([fit.x.tolist(), fit.best.misfit, fit.chi2, p.parameters, p.start.tolist(), p.forward().tolist(), repr(p)]))
"""))
    assert np.allclose(said[0], [1, 1], atol=1e-8) and said[1] < 1e-8 and said[2] < 1e-16, said
    assert said[3:6] == [["x", "y"], [-1.2, 1.0], [10 * (1 - 1.44), 2.2]] and "Problem" in said[6], said


def test_two_exponentials_have_two_minima_with_and_without_derivatives():
    said = json.loads(python(DECAY + """
import json
told = []
for jacobian in (None, slopes):
    problem = pavescape.Problem(ranges, readings, decay, jacobian)
    unique = problem.unique(threads=2)
    r, j = problem.residuals_and_jacobian([1.5, 6.0])
    told.append([unique.verdict, sorted(list(m.parameters.values()) for m in unique.minima), "differences" in " ".join(unique.findings),
                 float(abs(j - slopes([1.5, 6.0]) / 0.01).max() / abs(j).max()), float(abs(r - (decay([1.5, 6.0]) - readings[0]) / 0.01).max())])
print(json.dumps(told))
"""))
    for (verdict, minima, by_differences, error, residual), exact in zip(said, (False, True)):
        assert verdict == "non-unique" and np.allclose(minima, [[1.2, 7.0], [7.0, 1.2]], rtol=1e-5), minima
        assert by_differences != exact and error < (1e-12 if exact else 1e-5) and residual < 1e-9, (error, residual)


def test_exceptions_and_numbers_that_are_none_are_points_without_an_answer_with_their_reason():
    said = json.loads(python(DECAY + """
import json
def wrong(x):
    if x[0] > 10:
        raise ValueError("the tank runs over")
    if x[1] > 10:
        return decay(x) * float("nan")
    if x[1] < 0.3:
        return decay(x)[:4]
    return decay(x)
problem = pavescape.Problem(ranges, readings, wrong)
reasons = []
for x in ([11, 1], [1, 11], [1, 0.25]):
    try:
        problem.forward(x)
    except pavescape.NoAnswer as error:
        reasons.append(str(error))
result, points, misfit = problem.map(points=200, threads=2)
def always(x):
    raise RuntimeError("no licence")
try:
    pavescape.Problem(ranges, readings, always).fit(explore=4)
except pavescape.NoAnswer as error:
    reasons.append(str(error))
print(json.dumps([reasons, result.statuses, int(np.isnan(misfit).sum()), int(((points > 10).any(axis=1) | (points[:, 1] < 0.3)).sum()), problem.fit(threads=2).best.misfit]))
"""))
    reasons, statuses, holes, outside, misfit = said
    assert "ValueError: the tank runs over" in reasons[0] and "line " in reasons[0], reasons
    assert "nan for 'reading 1'" in reasons[1] and "(4,)" in reasons[2] and "(10,)" in reasons[2], reasons
    assert "no licence" in reasons[3], reasons
    assert statuses["failed"] == holes == outside > 20 and statuses["converged"] == 200 - outside, said
    assert misfit < 1e-5


def test_arguments_of_a_problem_are_checked():
    for line in json.loads(python(DECAY + """
import json
said = []
for wrong, word in (((["x"], readings, decay), "parameters"), ((ranges, readings[0], decay), "readings"), ((ranges, {"value": [1, 2], "sigma": [1]}, decay), "sigma"),
                    ((ranges, {"value": [1], "sigma": [1], "wert": [1]}, decay), "wert"), ((ranges, ([float("nan")], 1.0), decay), "finite"),
                    (([("x", 2, 1)], readings, decay), "min < max"), ((ranges, (readings[0], 0.0), decay), "standard deviation")):
    try:
        pavescape.Problem(*wrong)
        said.append("nothing")
    except ValueError as error:
        said.append("" if word in str(error) else f"{word}: {error}")
print(json.dumps(said))
""")):
        assert line == "", line


PICKLES = """
import concurrent.futures, multiprocessing, pickle, sys
import numpy as np, pavescape
times = np.arange(1.0, 11.0)
def decay(x):
    return (np.exp(-times / x[0]) + np.exp(-times / x[1])) / 2
def bits(problem):
    return problem.fit(explore=32, threads=1).x.tobytes() + problem.forward([1.0, 3.0]).tobytes()
if __name__ == "__main__":
    problem = pavescape.Problem([("fast", 0.2, 20), ("slow", 0.2, 20)], {"value": decay([1.2, 7.0]), "sigma": [0.01] * 10, "unit": ["m"] * 10}, decay)
    own = bits(problem)
    with concurrent.futures.ProcessPoolExecutor(4, mp_context=multiprocessing.get_context("spawn")) as pool:
        assert list(pool.map(bits, [problem] * 4)) == [own] * 4
    print("alike")
"""


def test_diagnose_names_the_effect_that_is_hidden_and_none_where_there_is_none():
    said = json.loads(python("""
import json, pickle
import numpy as np, pavescape
times = np.linspace(0.5, 40.0, 30)
def levels(x):
    return (np.exp(-times / x[0]) + np.exp(-times / x[1])) / 2 + x[2]
told = []
for level in (0.08, 0.0):
    readings = (levels([1.2, 7.0, level]) + 0.01 * np.random.default_rng(11).normal(size=len(times)), 0.01)
    problem = pavescape.Problem([("fast", 0.2, 3), ("slow", 3, 20)], readings, levels, effects=[("a level that stays", 0, 0.1, -0.5, 0.5)])
    found = pickle.loads(pickle.dumps(problem)).diagnose(explore=32, starts=2, bootstrap=10, threads=1)
    told.append([found.verdict, found.causes, found["hypotheses"][0]["sizes"]])
print(json.dumps(told))
""" ))
    (verdict, causes, sizes), (nothing, none, _) = said
    assert (verdict, causes) == ("cause-named", ["a level that stays"]) and (nothing, none) == ("adequate", []), said
    size = sizes[causes[0]]
    assert abs(size["value"] - 0.08) < 3 / 1.96 * (size["high"] - size["low"]) / 2, size  # three deviations


def test_pickled_problems_in_four_processes_give_the_same_bits():
    script = workspace() / "pickles.py"
    script.write_text(PICKLES)
    done = subprocess.run(["/usr/bin/python3", str(script)], capture_output=True, text=True, timeout=600, env=environment())
    assert done.stdout == "alike\n", done.stderr


INTERRUPTED = """
import sys, time, pavescape
calls = []
def slow(x):
    calls.append(time.monotonic())
    time.sleep(0.2)
    return [x[0], x[1]]
problem = pavescape.Problem([("x", 0, 1), ("y", 0, 1)], ([0.5, 0.5], 0.1), slow)
print("begins", flush=True)
try:
    problem.map(points=100, threads=2, out=sys.argv[1])
except KeyboardInterrupt:
    print(time.monotonic(), flush=True)
print(len(calls), problem.forward([0.25, 0.5])[0])
"""


def test_ctrl_c_ends_within_two_evaluations_and_what_was_done_is_kept():
    folder = workspace() / "run"
    process = subprocess.Popen(["/usr/bin/python3", "-c", INTERRUPTED, str(folder)], stdout=subprocess.PIPE, text=True, env=environment(),
                               preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler))
    assert process.stdout.readline() == "begins\n"
    time.sleep(1.0)
    asked = time.monotonic()
    process.send_signal(signal.SIGINT)
    ended = float(process.stdout.readline())
    assert ended - asked < 0.4 + 0.3, ended - asked  # two evaluations, and a slow machine
    called, value = process.stdout.readline().split()
    assert evaluations(folder) == int(called) >= 2 and float(value) == 0.25, called
    assert process.wait(60) == 0


def test_a_changed_function_begins_a_new_run():
    folder = workspace()
    said = json.loads(python("""
import json, sys, pavescape
def make(factor):
    return lambda x: [factor * x[0]]
kept = []
for factor in (2.0, 2.0, 3.0):
    problem = pavescape.Problem([("x", 0, 1)], ([1.0], 0.1), make(factor))
    kept.append(problem.map(points=16, out=sys.argv[1])["kept"])
print(json.dumps(kept))
""", folder / "run"))
    assert said == [0, 16, 0]


def test_a_function_may_ask_a_study_and_name_itself_and_searches_begin_where_they_are_told_to():
    folder = workspace()
    said = json.loads(python("""
import json, sys, numpy as np, pavescape
study = pavescape.Study(sys.argv[1])
def make():
    def bowl(x, deeper=False):
        return bowl(x) if deeper else study.forward(x)
    return bowl
problem = pavescape.Problem([("base", 100, 1500)], {"value": study.measured, "sigma": 0.01 * study.measured, "unit": ["mm"] * 5, "x_mm": [0, 300, 600, 900, 1800]}, make())
one, two = problem.fit(threads=4, explore=32, out=sys.argv[2]), study.fit(explore=32)
near = problem.fit(explore=1, starts=1, start=[{"base": 460.0}], threads=4)
again = problem.fit(explore=1, starts=1, from_=[sys.argv[2]])
wrong = []
for options in ({"start": [{"bass": 1.0}]}, {"from_": ["nowhere"]}):
    try:
        problem.fit(**options)
    except ValueError as error:
        wrong.append(str(error))
print(json.dumps([one.x.tolist(), two.x.tolist(), near.x.tolist(), again.x.tolist(), near.starts, wrong]))
""", layered(folder), folder / "run"))
    assert np.allclose(said[:4], 450.0, rtol=1e-5), said
    assert "bass" in said[5][0] and "nowhere" in said[5][1], said[5]


def test_results_are_dictionaries_with_attributes_a_short_answer_tables_and_figures():
    folder = workspace()
    said = json.loads(python("""
import copy, json, pathlib, pickle, sys, pavescape
study = pavescape.Study(sys.argv[1])
fit = study.fit(explore=8, out=sys.argv[2])
unique = study.unique(explore=16, verify=2)
result, draws, outputs, weights = sample = study.sample(samples=400)
class Axes:
    def __init__(self): self.calls = []
    def __getattr__(self, name): return lambda *a, **k: self.calls.append(name)
axes = Axes()
assert isinstance(fit, dict) and fit.best.misfit == fit["best"]["misfit"] and list(fit.keys())[0] == "best"
assert json.loads(json.dumps(fit)) == fit == pickle.loads(pickle.dumps(fit)) and copy.deepcopy(fit).best == fit.best
assert fit.chi2 == fit["noise"]["chi2"] and unique.chi2 == unique["acceptance"]["chi2"] and fit.kind == "fit" and "best" in dir(fit)
assert (sample.draws is draws) and sample["status"] == sample.status == result.status and draws.shape == (400, 1) == (len(weights), 1)
assert abs(float(draws[sample.equal_draws()].mean()) - float((draws[:, 0] * weights).sum() / weights.sum())) < 2.0
assert fit.table()["name"] == study.parameters and len(fit.table("responses")["measured"]) == 5 and set(sample.table()) == {*study.parameters, "weight"}
assert fit.plot(ax=axes) is axes and sample.plot(ax=axes) is axes and {"errorbar", "plot", "hist"} <= set(axes.calls)
figure = unique.plot("profiles")
drawn = pavescape.plot(fit, "fit")
page = pavescape.report(sys.argv[2])
said = []
for wrong in (lambda: fit.nothing, lambda: fit.plot("other"), lambda: fit.table("other"), lambda: pavescape.plot(unique)):
    try:
        wrong()
    except (AttributeError, ValueError) as error:
        said.append(str(error))
missing = []
for call, package in ((fit.to_dataframe, "pandas"), (sample.to_arviz, "arviz")):
    sys.modules[package] = None
    try:
        call()
    except ImportError as error:
        missing.append(str(error))
print(json.dumps({"fit": repr(fit), "unique": repr(unique), "sample": repr(sample), "svg": figure._repr_svg_()[:200], "files": drawn, "page": pathlib.Path(page).read_text()[:15],
                  "said": said, "missing": missing, "curve": pathlib.Path(drawn[0]).exists()}))
""", layered(folder), folder / "run"))
    assert re.search(r"base.modulus_MPa = 450 \(standard error", said["fit"]) and "chi2 = " in said["fit"], said["fit"]
    assert "UNIQUE" in said["unique"] and "accepted" in said["unique"] and "95 %" in said["sample"], said
    assert "<svg" in said["svg"] and said["files"] == [str(folder / "run/figures/fit.svg")] and said["curve"] and said["page"].lower() == "<!doctype html>", said
    assert "it has best" in said["said"][0] and "fit" in said["said"][1] and "responses" in said["said"][2] and "out=FOLDER" in said["said"][3], said["said"]
    assert len(said["said"]) == 4 and ["pip install pandas" in said["missing"][0], "pip install arviz" in said["missing"][1]] == [True, True]


def test_tables_and_draws_are_handed_to_pandas_and_arviz():
    said = json.loads(python(DECAY + """
import json, sys, types
sys.modules["pandas"] = types.SimpleNamespace(DataFrame=lambda columns: ("frame", columns))
sys.modules["arviz"] = types.SimpleNamespace(from_dict=lambda **groups: groups)
problem = pavescape.Problem([("fast", 0.2, 3), ("slow", 4, 20)], readings, lambda x: [*decay(x), x[1] / x[0]], outputs=[("ratio", "-")])
sample = problem.sample(samples=400, threads=2)
kind, columns = sample.to_dataframe()
data = sample.to_arviz()
print(json.dumps([kind, list(columns), {k: v.shape for k, v in data["posterior"].items()}, {k: v.shape for k, v in data["posterior_predictive"].items()},
                  float(abs(columns["ratio"] - columns["slow"] / columns["fast"]).max())]))
"""))
    assert said[:4] == ["frame", ["fast", "slow", "ratio", "weight"], {"fast": [1, 400], "slow": [1, 400]}, {"ratio": [1, 400]}] and said[4] < 1e-9, said


def test_roads_and_noise_answer_as_the_commands_do():
    said = json.loads(python("""
import json, sys, pavescape
noise = pavescape.noise(sys.argv[1])
survey = pavescape.survey([sys.argv[1]])
wrong = []
for call in (lambda: pavescape.road(sys.argv[1], "nothing.toml"), lambda: pavescape.road(sys.argv[1], "nothing.toml", withhold="much")):
    try:
        call()
    except ValueError as error:
        wrong.append(str(error))
print(json.dumps([noise, survey, wrong, repr(noise)]))
""", ROOT / "grids/road-north.f25"))
    for name, mine in zip(("noise", "survey"), said):
        done = subprocess.run([str(BUILD / "explore/pavescape"), name, str(ROOT / "grids/road-north.f25"), "--json", *(["--out", str(workspace())] if name == "survey" else [])],
                              capture_output=True, text=True)
        theirs = json.loads(done.stdout)
        for key in theirs:
            if key != "run":
                assert mine[key] == theirs[key], (name, key)
    assert "nothing.toml" in said[2][0] and "withhold" in said[2][1] and said[3].startswith("noise"), said[2:]


def test_the_notebook_runs_as_plain_code():
    notebook = json.loads((ROOT / "examples/bowl.ipynb").read_text())
    assert notebook["nbformat"] == 4 and all(cell.get("outputs", []) == [] for cell in notebook["cells"])
    code = ["".join(cell["source"]) for cell in notebook["cells"] if cell["cell_type"] == "code"]
    said = python("\n".join(code) + "\nprint('ended', answer.verdict, figure.name)", cwd=ROOT / "examples")
    assert said.splitlines()[-1] == "ended unique posterior", said


def test_the_examples_of_the_page_run():
    page = (ROOT / "docs/guide/python.md").read_text()
    blocks = re.findall(r"^((?:    .*\n|\n)+)", page, re.M)
    code = "\n".join(line[4:] for block in blocks for line in block.splitlines()) + "\nprint('ended')"
    folder = workspace()
    (folder / "examples").symlink_to(ROOT / "examples")
    assert python(code, cwd=folder).splitlines()[-1] == "ended"


def test_every_public_name_has_a_docstring_and_types_and_the_compiled_part_a_stub():
    said = json.loads(python("""
import inspect, json, pavescape
from pavescape import _pavescape
wrong = []
def look(name, thing):
    if not inspect.getdoc(thing):
        wrong.append(f"{name} has no docstring")
    if inspect.isfunction(thing):
        for p in list(inspect.signature(thing).parameters.values()):
            if p.name not in ("self", "cls") and p.annotation is p.empty:
                wrong.append(f"{name}({p.name}) has no type")
        if inspect.signature(thing).return_annotation is inspect.Signature.empty:
            wrong.append(f"{name} returns no type")
public = [name for name in dir(pavescape) if not name.startswith("_") and not inspect.ismodule(getattr(pavescape, name))]
for name in public:
    thing = getattr(pavescape, name)
    look(name, thing)
    if inspect.isclass(thing) and thing is not pavescape.NoAnswer:
        for member, value in inspect.getmembers(thing):
            if not member.startswith("_") and member not in dir(dict) + dir(tuple) and (callable(value) or isinstance(value, property)):
                look(f"{name}.{member}", value.fget if isinstance(value, property) else value)
print(json.dumps([wrong, sorted(public), sorted(n for n in pavescape.__all__ if not n.startswith("_")), sorted(n for n in dir(_pavescape) if not n.startswith("__")),
                  sorted(n for n in dir(_pavescape.Study) if not n.startswith("_"))]))
"""))
    wrong, public, exported, compiled, members = said
    assert wrong == [] and public == exported, (wrong, set(public) ^ set(exported))
    stub = ast.parse((ROOT / "python/pavescape/_pavescape.pyi").read_text())
    names = [getattr(node, "name", None) or node.target.id for node in stub.body if isinstance(node, (ast.FunctionDef, ast.ClassDef, ast.AnnAssign))]
    assert sorted(n for n in names if not n.startswith("__")) == compiled
    study = next(node for node in stub.body if isinstance(node, ast.ClassDef) and node.name == "Study")
    assert sorted(node.name for node in study.body if not node.name.startswith("_")) == members
    assert (ROOT / "python/pavescape/py.typed").exists()


def test_the_extension_is_several_units_and_not_part_of_the_demo():
    assert "pavescape_python" not in (ROOT / "tools/demo").read_text()
    sizes = [len(path.read_text().splitlines()) for path in (ROOT / "python").glob("*.cpp")]
    assert len(sizes) >= 6 and max(sizes) <= sum(sizes) / 3, sizes
