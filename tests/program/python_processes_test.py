"""A Python function computed by processes of its own: the same bits, what goes wrong in them, and that nothing of them is left."""
import json
import os
import subprocess
import time

from support import evaluations, workspace
from python_test import environment, python

HEAD = """
import json, os, signal, sys, time
import numpy as np, pavescape
times = np.arange(1.0, 11.0)
def decay(x):
    if x[0] > 10:
        raise ValueError("the tank runs over")
    return (np.exp(-times / x[0]) + np.exp(-times / x[1])) / 2
def slopes(x):
    return np.column_stack([np.exp(-times / t) * times / t**2 / 2 for t in x])
ranges = [("fast", 0.2, 20), ("slow", 0.2, 20)]
readings = (decay([1.2, 7.0]), 0.01)
def of(function, processes, jacobian=None):
    return pavescape.Problem(ranges, readings, function, jacobian, processes=processes)
"""


def script(text, *arguments, status=0):
    """What a script prints, whose main part is `text`; it has to end by itself."""
    file = workspace() / "script.py"
    file.write_text(HEAD + text)
    done = subprocess.run(["/usr/bin/python3", str(file), *map(str, arguments)], capture_output=True, text=True, timeout=300, env=environment())
    assert done.returncode == status, done.stderr
    return done


def test_processes_end_with_the_same_bits_and_take_the_work_from_this_one():
    said = json.loads(script("""
def by_whom(x):
    return [*decay(x)[:9], os.getpid()]
if __name__ == "__main__":
    found = []
    for processes in (0, 2):
        for jacobian in (None, slopes):
            problem = of(decay, processes, jacobian)
            result, x, misfit = problem.map(points=60, threads=2)
            found.append([problem.fit(explore=32, starts=2, threads=2).x.tobytes().hex(), misfit.tobytes().hex(), result.statuses["failed"]])
    here = bool(of(by_whom, 0).forward([1.0, 2.0])[9] == os.getpid())
    there = bool(of(by_whom, 1).forward([1.0, 2.0])[9] != os.getpid())
    print(json.dumps([found, here, there]))
""").stdout)
    (plain, with_slopes, again, again_with_slopes), here, there = said
    assert plain == again and with_slopes == again_with_slopes and plain[2] > 10, said
    assert here and there


def test_two_processes_work_at_once():
    said = json.loads(script("""
def late(x):
    time.sleep(0.25)
    return [os.getpid(), time.monotonic()]
if __name__ == "__main__":
    problem = pavescape.Problem([("a", 0, 1)], ([1.0, 1.0], 1.0), late, processes=2)
    problem.map(points=4, threads=2)
    begin = time.monotonic()
    problem.map(points=16, threads=2)
    print(json.dumps(time.monotonic() - begin))
""").stdout)
    assert 8 * 0.25 <= said < 14 * 0.25, "sixteen calls of 0.25 s, two at a time"


def test_a_process_that_dies_is_a_point_without_an_answer_and_another_takes_its_place():
    folder = workspace() / "run"
    said = json.loads(script("""
def dies(x):
    if x[0] > 15:
        os.kill(os.getpid(), signal.SIGKILL)
    if x[1] > 15:
        os._exit(3)
    return decay(x)
if __name__ == "__main__":
    reasons = []
    for at in ([16.0, 1.0], [1.0, 16.0]):
        try:
            of(dies, 1).forward(at)
        except pavescape.NoAnswer as error:
            reasons.append(str(error))
    result, points, misfit = of(dies, 2).map(points=64, threads=2, out=sys.argv[1])
    print(json.dumps([reasons, int(np.isnan(misfit).sum()), int(((points[:, 0] > 10) | (points[:, 1] > 15)).sum())]))
""", folder).stdout)
    reasons, holes, outside = said
    assert "ended with signal 9" in reasons[0] and "ended with status 3" in reasons[1], reasons
    assert holes == outside > 10, said
    assert evaluations(folder) == 64, "all are kept: the others with their answers"


def test_what_cannot_be_handed_over_is_refused():
    said = json.loads(python(HEAD + """
said = []
for function, processes in ((lambda x: decay(x), 2), (decay, -1), (decay, 2.5), (decay, True)):
    try:
        of(function, processes)
        said.append("nothing")
    except ValueError as error:
        said.append(str(error))
try:
    of(decay, 2).forward([1.0, 2.0])  # of no file
except pavescape.NoAnswer as error:
    said.append(str(error))
print(json.dumps(said))
"""))
    assert "cannot be handed to another process" in said[0] and "processes = 0" in said[0], said
    assert all(text.startswith("processes = ") and "whole numbers" in text for text in said[1:4]), said
    assert "no process for the function" in said[4], said


def test_a_script_that_does_not_wait_to_be_run_is_told_so_and_ends():
    begin = time.monotonic()
    done = script("print(of(decay, 2).map(points=8).statuses)\n", status=1)
    assert time.monotonic() - begin < 60
    assert 'does the script call from under if __name__ == "__main__"?' in done.stderr, done.stderr


def test_nothing_is_left_of_them():
    file = workspace() / "pids"
    said = json.loads(script("""
import gc
def noted(x):
    with open(sys.argv[1], "a") as f:
        f.write(f"{os.getpid()}\\n")
    return decay(x)
def alive():
    return [pid for pid in {int(line) for line in open(sys.argv[1])} if os.path.exists(f"/proc/{pid}")]
if __name__ == "__main__":
    problem = of(noted, 2)
    problem.map(points=16, threads=2)
    before = alive()
    del problem
    gc.collect()
    after = alive()
    of(noted, 2).fit(explore=8, starts=1, threads=2)
    kept = of(noted, 1)
    kept.forward([1.0, 2.0])
    print(json.dumps([len(before), len(after)]))
""", file).stdout)
    assert 1 <= said[0] <= 2 and said[1] == 0, said
    assert not [pid for pid in file.read_text().split() if os.path.exists(f"/proc/{pid}")], "nor after the end"
