"""The same bits for any number of threads, and for a run that is killed half way and continued; nothing is repeated."""
import json
import signal
import time

import pytest

from support import *

folder = workspace()
study = write_study(folder)
COMMANDS = {"map": ("map", study, "--design", "sobol", "--points", 300),
            "fit": ("fit", study, "--explore", 60, "--starts", 6)}
each_command = pytest.mark.parametrize("name", COMMANDS)


def export(out):
    done = run("export", out)
    assert done.returncode == 0, f"export {out}: {done.stderr}"
    return done.stdout


@pytest.fixture(scope="module")
def threads():
    """{command: {threads: (result, table of all evaluations)}}"""
    found = {}
    for name, command in COMMANDS.items():
        for count in (1, 2, 4):
            out = folder / f"{name}-{count}"
            done = run(*command, "--threads", count, "--out", out, "--json")
            assert done.returncode == 0, f"{name} with {count} threads: {done.stderr}"
            found.setdefault(name, {})[count] = json.loads(done.stdout), export(out)
    return found


def lines_of(table):
    return len(table.splitlines()) - 1


@each_command
def test_any_number_of_threads_gives_the_same_bits(threads, name):
    (result, table), *others = threads[name].values()
    assert all(other == table for _, other in others), f"{name}: the tables of 1, 2 and 4 threads differ"
    assert lines_of(table) >= 60, f"{name}: too few evaluations"
    if name == "map":
        assert result["statuses"]["invalid-parameters"] > 0 and result["statuses"]["converged"] > 0, \
            "the map should hold points with and without an answer"


@each_command
def test_a_run_that_is_killed_twice_continues_with_the_same_bits(threads, name):
    table = threads[name][1][1]
    lines = lines_of(table)
    out = folder / f"{name}-killed"
    kept = 0
    for share in (0.25, 0.6):
        now = kill_at(share * lines, out, *COMMANDS[name])
        assert kept < now < lines, f"{name}: killed with {now} of {lines} evaluations"
        kept = now
    done = run(*COMMANDS[name], "--out", out, "--json")
    assert done.returncode == 0, f"{name} continued: {done.stderr}"
    assert export(out) == table, f"{name}: the table of the killed and continued run differs"
    if name == "map":
        result = json.loads(done.stdout)
        assert result["kept"] == kept, f"map: {result['kept']} kept, {kept} were finished"
        assert result["computed"] == lines - kept, "map: something finished was computed again"


@each_command
def test_ctrl_c_keeps_what_is_done(threads, name):
    table = threads[name][1][1]
    lines = lines_of(table)
    out = folder / f"{name}-interrupted"
    process = subprocess.Popen([PROGRAM, *map(str, COMMANDS[name]), "--out", str(out)], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    while evaluations(out) < 0.3 * lines and process.poll() is None:
        time.sleep(0.01)
    process.send_signal(signal.SIGINT)
    message = process.communicate()[1]
    assert process.returncode == 130, f"{name}: interrupted, exit status {process.returncode}"
    assert "kept" in message, f"{name}: the interrupt says what is kept: {message}"
    assert 0 < evaluations(out) < lines, f"{name}: interrupted with {evaluations(out)} evaluations"
    run(*COMMANDS[name], "--out", out)
    assert export(out) == table, f"{name}: the table of the interrupted and continued run differs"
