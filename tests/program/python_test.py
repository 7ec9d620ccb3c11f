"""The Python module as a user of Python meets it: arguments, copies and pickles, Ctrl-C, what a call computes."""
import json
import signal
import subprocess
import time

import pytest
from support import BUILD, DATA, LAYERED, LAYERED_BOWL, STUDY, evaluations, leaks_of_others, run, sanitizer, workspace, write_study


def environment():
    env = {**leaks_of_others(), "PYTHONPATH": str(BUILD / "python")}
    if sanitizer() == "thread":
        pytest.skip("Python's interpreter is not made for the thread sanitizer")
    if sanitizer() == "address":
        libraries = (subprocess.run(["g++", f"-print-file-name={name}"], capture_output=True, text=True).stdout.strip()
                     for name in ("libasan.so", "libstdc++.so"))
        env["LD_PRELOAD"] = " ".join(libraries)
    return env


def python(script, *arguments, cwd=None):
    done = subprocess.run(["/usr/bin/python3", "-c", script, *map(str, arguments)], capture_output=True, text=True, timeout=600, env=environment(), cwd=cwd)
    assert done.returncode == 0, done.stderr
    return done.stdout


def layered(folder):
    return write_study(folder, LAYERED, LAYERED_BOWL)


WRONG = """
import json, sys
import numpy as np, pavescape
study = pavescape.Study(sys.argv[1])
calls = {
    "starts": [lambda: study.fit(starts=0), lambda: study.fit(starts=10001), lambda: study.fit(starts=10**30), lambda: study.diagnose(starts=0)],
    "explore": [lambda: study.fit(explore=-5), lambda: study.unique(explore=0), lambda: study.diagnose(explore=0), lambda: study.compare(explore=0)],
    "threads": [lambda: study.fit(threads=-1), lambda: study.map(threads=5000), lambda: pavescape.survey(["nothing.csv"], threads=-2)],
    "seed": [lambda: study.fit(seed=-1), lambda: study.sample(seed=2**64)],
    "points": [lambda: study.map(points=-1), lambda: study.map(design="adaptive", points=1), lambda: study.sensitivity(points=1)],
    "time": [lambda: study.fit(time="10"), lambda: study.map(time=0), lambda: study.unique(time=-1), lambda: study.sample(time="10 years")],
    "evaluations": [lambda: study.fit(evaluations=0)],
    "samples": [lambda: study.sample(samples=10), lambda: study.prior_check(samples=1), lambda: study.sensitivity(samples=-1)],
    "confirm": [lambda: study.sample(confirm=0)],
    "verify": [lambda: study.unique(verify=0), lambda: study.compare(verify=0)],
    "searches": [lambda: study.unique(searches=0)],
    "bootstrap": [lambda: study.diagnose(bootstrap=0)],
    "range": [lambda: study.sensitivity(range=0.0), lambda: study.sensitivity(range=float("nan"))],
    "model": [lambda: study.fit(model="best"), lambda: study.diagnose(model="reduced")],
    "model_error": [lambda: study.fit(model_error=0)],
    "method": [lambda: study.fit(method="simplex")],
    "scheme": [lambda: study.fit(scheme="other")],
    "design": [lambda: study.map(design="other")],
    "values": [lambda: study.forward(np.ones(3)), lambda: study.residuals([1, 2, 3])],
}
said = []
for name, several in calls.items():
    for number, call in enumerate(several):
        try:
            call()
            said.append([name, number, "nothing", ""])
        except Exception as error:
            said.append([name, number, type(error).__name__, str(error)])
print(json.dumps(said))
"""


def test_an_argument_out_of_its_range_is_a_value_error_with_its_name_and_the_range():
    for name, number, kind, message in json.loads(python(WRONG, layered(workspace()))):
        assert kind == "ValueError", (name, number, kind, message)
        assert message.startswith((f"{name} =", f"{name}:")), (name, number, message)
        assert "allowed: " in message, (name, number, message)


def test_the_options_of_the_command_line_are_arguments():
    told = json.loads(python("""
import json, sys, numpy as np, pavescape
study = pavescape.Study(sys.argv[1])
slow = study.fit(starts=np.int64(1), explore=8, method="lbfgs", scheme="multistart", joint_only=True)
unique = study.unique(explore=16, verify=2, landscape=True, posterior=True)
compared = study.compare(laws=["linear"], layer="base", explore=8, verify=2, evidence=True)
print(json.dumps([slow["best"]["misfit"], "landscape" in unique, "posterior" in unique["profiles"][0], "log_evidence" in compared["laws"][0]]))
""", layered(workspace())))
    assert told[0] < 0.1 and told[1:] == [True, True, True], told


def test_a_study_says_what_it_is():
    said = python("import sys, pavescape; print(repr(pavescape.Study(sys.argv[1])))", layered(workspace()))
    assert "Study" in said and "small.toml" in said and "1 parameter," in said and "5 readings" in said and "0 outputs" in said, said


PICKLES = """
import concurrent.futures, copy, json, multiprocessing, pathlib, pickle, sys
import numpy as np, pavescape

def responses(pair):
    study, factor = pair
    return study.forward(study.start * factor)

if __name__ == "__main__":
    study = pavescape.Study(sys.argv[1])
    memory = pavescape.Study.from_text(pathlib.Path(sys.argv[1]).read_text(), {"small.csv": pathlib.Path(sys.argv[2]).read_text()}, name="in memory.toml")
    stored = [pickle.dumps(s) for s in (study, memory)]
    pathlib.Path(sys.argv[1]).unlink()
    pathlib.Path(sys.argv[2]).unlink()
    factors = [0.9, 1.0, 1.1, 1.3]
    own = [responses((study, f)) for f in factors]
    with concurrent.futures.ProcessPoolExecutor(4, mp_context=multiprocessing.get_context("spawn")) as pool:
        others = list(pool.map(responses, [(study, f) for f in factors]))
    alike = [all((a == b).all() for a, b in zip(own, others))]
    for other in (*map(pickle.loads, stored), copy.copy(study), copy.deepcopy(memory)):
        alike.append(all((responses((other, f)) == mine).all() for f, mine in zip(factors, own))
                     and other.parameters == study.parameters and other.fit(starts=1, explore=4)["best"] == study.fit(starts=1, explore=4)["best"])
    print(json.dumps(alike))
"""


def test_studies_travel_to_other_processes_with_their_files_and_give_the_same_bits():
    folder = workspace()
    study = layered(folder)
    script = folder / "pickles.py"
    script.write_text(PICKLES)
    done = subprocess.run(["/usr/bin/python3", str(script), str(study), str(folder / "small.csv")], capture_output=True, text=True, timeout=600, env=environment())
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout) == [True] * 5


INTERRUPTED = """
import sys, time, pavescape
study = pavescape.Study(sys.argv[1])
print("begins", flush=True)
begin = time.monotonic()
try:
    study.map(design="sobol", points=int(sys.argv[2]), threads=1, out=sys.argv[3])
    print("finished")
except KeyboardInterrupt:
    print("KeyboardInterrupt", flush=True)
print(study.fit(starts=1, explore=4, threads=1)["best"]["misfit"])
"""


def interrupt(*arguments):
    return subprocess.Popen(["/usr/bin/python3", "-c", INTERRUPTED, *map(str, arguments)], stdout=subprocess.PIPE, text=True, env=environment(),
                            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler))


def test_ctrl_c_ends_an_analysis_keeps_what_was_computed_and_leaves_the_module_usable():
    folder = workspace()
    study = layered(folder)
    process = interrupt(study, 2_000_000, folder / "run")
    while evaluations(folder / "run") < 20 and process.poll() is None:
        time.sleep(0.02)
    process.send_signal(signal.SIGINT)
    begin = time.monotonic()
    assert process.stdout.readline() == "begins\n"
    assert process.stdout.readline() == "KeyboardInterrupt\n"
    assert time.monotonic() - begin < 5.0  # a run takes a millisecond, two million of them half an hour
    assert float(process.stdout.readline()) < 0.1
    assert process.wait(60) == 0
    kept = evaluations(folder / "run")
    assert 20 <= kept < 2_000_000
    # Another process goes on where this one was ended.
    told = run("map", study, "--design", "sobol", "--points", kept, "--out", folder / "run", "--json")
    assert json.loads(told.stdout)["kept"] == kept, told.stdout[:400]


def test_a_limit_of_time_gives_the_best_so_far_and_the_same_call_goes_on():
    folder = workspace()
    told = json.loads(python("""
import json, sys, time, pavescape
study = pavescape.Study(sys.argv[1])
begin = time.monotonic()
early = study.map(design="sobol", points=200_000, threads=1, time=0.5, out=sys.argv[2])[0]
more = study.map(design="sobol", points=200_000, threads=1, time="1s", out=sys.argv[2])[0]
alone = study.fit(explore=200_000, threads=1, time=0.5)
seconds = time.monotonic() - begin
whole = study.fit(starts=1, explore=4, threads=1, time="1h")
print(json.dumps([early, more, alone, "complete" in whole, seconds, repr(alone)]))
""", layered(folder), folder / "run"))
    early, more, alone, marked, seconds, said = told
    assert seconds < 20 and not marked
    for result in (early, more, alone):
        assert result["complete"] is False and result["best"]["status"] == "converged" and result["best"]["misfit"] > 0, result
    assert more["evaluations"] > early["evaluations"] > 0 and more["best"]["misfit"] <= early["best"]["misfit"]
    assert "not finished after 0.5 s" in said and evaluations(folder / "run") == more["evaluations"], said


def test_the_check_of_the_prior_says_what_the_command_says():
    folder = workspace()
    study = layered(folder)
    script = "import json, sys, pavescape; r = pavescape.Study(sys.argv[1]).prior_check(samples=400); print(json.dumps([r, r.table()['pit']]))"
    result, pits = json.loads(python(script, study))
    told = json.loads(run("sample", study, "--prior", "--samples", 400, "--json", "--out", folder / "run").stdout)
    assert result["readings"] == told["readings"] and result["unreached"] == told["unreached"]
    assert pits == [row["pit"] for row in told["readings"]]


def test_a_handler_that_raises_nothing_ends_nothing():
    done = python("""
import signal, sys, threading, os, time, pavescape
study = pavescape.Study(sys.argv[1])
heard = []
signal.signal(signal.SIGINT, lambda *_: heard.append(1))
threading.Timer(0.05, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
_, points, _ = study.map(design="sobol", points=20000, threads=1)
print(len(points), len(heard))
""", layered(workspace()))
    assert done.split() == ["20000", "1"], done


# A wheel in three dimensions that only an output needs.
TYRE = STUDY.replace("[mesh]", """[[loads]]
name = "wheel"
type = "wheel"
force_kN = 40
pressure_kPa = 700
patch = "rectangle"
patch_width_mm = 200

[mesh]""").replace('load = "fwd"\nquantity', 'load = "wheel"\nquantity')


def test_residuals_do_not_compute_loads_that_only_outputs_need():
    folder = workspace()
    study = write_study(folder, TYRE, DATA)
    times = json.loads(python("""
import json, sys, time
import numpy as np, pavescape
study = pavescape.Study(sys.argv[1])
values = study.start * 1.01
def cost(call):
    begin = time.process_time()
    result = call()
    return time.process_time() - begin, result
forward, responses = cost(lambda: study.forward(values))
residuals, r = cost(lambda: study.residuals(values))
jacobian, j = cost(lambda: study.residual_jacobian(values))
both, (r2, j2) = cost(lambda: study.residuals_and_jacobian(values))
own, r3 = cost(lambda: study.residuals())
# Equation 2 in its safe form, by hand.
from math import asinh
said = study.measured
groups = [p["quantity"] for p in study.responses[:len(said)]]
units = {"mm": 1e-3, "um": 1e-6, "strain": 1.0}
si = np.array([units[p["unit"]] for p in study.responses[:len(said)]])
largest = {g: max(abs(v * u) for v, u, other in zip(said, si, groups) if other == g) for g in groups}
scale = np.array([2 * 0.01 * largest[g] for g in groups])
by_hand = np.arcsinh(responses[:len(said)] * si / scale) - np.arcsinh(said * si / scale)
print(json.dumps([forward, residuals, jacobian, both, own, float(abs(by_hand - r).max()), (r == r2).all().item() and (j == j2).all().item(), len(r3)]))
""", study))
    assert times[1] < 0.3 * times[0] and times[4] < 0.3 * times[0], times
    assert times[3] < 1.5 * times[2] + 0.05, times
    assert times[5] < 1e-9 and times[6] and times[7] == 4, times
