"""Nothing finished is lost, nothing is repeated, nothing is spoilt: killed at random moments, without room, two at once, with a
clock that jumps, without memory. --count: kills of each command in the second tier."""
import os
import random
import resource
import signal
import time

import pytest

from support import *

JUMPING_CLOCK = BUILD / "tests" / "libjumping_clock.so"
seed = random.SystemRandom().randrange(10**6)
random.seed(seed)
folder = workspace()
study = write_study(folder, STUDY.replace('misfit = "log"', 'misfit = "log"\nnoise_relative = 0.05'))
commands = {"map": ["--design", "sobol", "--points", 300],
            "fit": ["--explore", 60, "--starts", 6],
            "unique": ["--explore", 32, "--verify", 8],
            "diagnose": ["--explore", 8, "--starts", 1, "--bootstrap", 2]}


def start(name, out, *options, **settings):
    return subprocess.Popen([PROGRAM, name, str(study), *map(str, commands[name]), "--out", str(out), *map(str, options)],
                            stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, **settings)


def ended(process, statuses, label):
    """One clear message, or none where it went well."""
    message = process.communicate(timeout=120)[1].strip()
    assert process.returncode in statuses, f"{label}: exit status {process.returncode}: {message}"
    if process.returncode != 0:
        assert len(message.splitlines()) == 1 and "terminate" not in message, f"{label}: one message: {message}"
        print(f"{label}: exit status {process.returncode}\n    {message.replace(str(folder), '...')}")
    return message


@pytest.fixture(scope="module")
def undisturbed():
    truth, seconds = {}, {}
    for name in commands:
        out = folder / f"{name}-undisturbed"
        begin = time.monotonic()
        assert start(name, out).wait() == 0, f"{name}: undisturbed"
        seconds[name] = time.monotonic() - begin
        truth[name] = result(out, name)
    return truth, seconds


def survives(undisturbed, name, most):
    """Kills a command so many times at random moments, as many runs as it takes: each ends with the right result, and nothing is repeated."""
    truth, seconds = undisturbed
    print(f"seed {seed}")
    kills, runs = 0, 0
    while kills < most:
        runs += 1
        out = folder / f"{name}-killed-{most}-{runs}"
        while True:
            process = start(name, out, "--threads", random.choice((1, 2)))
            try:
                process.wait(random.uniform(0, seconds[name] / 3) if kills < most else 900)
                break
            except subprocess.TimeoutExpired:
                process.send_signal(signal.SIGKILL)
                process.wait()
                kills += 1
        assert process.returncode == 0, f"{name}: continued after kills: {process.communicate()[1]}"
        assert result(out, name) == truth[name], f"{name}: the killed and continued run differs from the undisturbed one"
        finished, computed = counted(out)
        assert finished == computed, f"{name}: {computed:g} computed for {finished} finished evaluations"
    print(f"{name}: killed {kills} times in {runs} runs of {seconds[name]:.1f} s, the same result, nothing repeated")


@pytest.mark.parametrize("name", commands)
def test_a_run_that_is_killed_and_continued_ends_with_the_same_bits(undisturbed, name):
    survives(undisturbed, name, 6)


@pytest.mark.long
@pytest.mark.parametrize("name", commands)
def test_a_run_that_is_killed_many_times_ends_with_the_same_bits(undisturbed, name):
    survives(undisturbed, name, COUNT or 50)


def test_sigterm_is_an_interrupt(undisturbed):
    truth, _ = undisturbed
    # SIGTERM is an interrupt as Ctrl-C is.
    out = folder / "terminated"
    process = start("map", out)
    while evaluations(out) < 20 and process.poll() is None:
        time.sleep(0.01)
    process.send_signal(signal.SIGTERM)
    message = process.communicate()[1]
    assert process.returncode == 130 and "kept" in message, f"SIGTERM: {process.returncode}: {message}"
    assert start("map", out).wait() == 0 and result(out, "map") == truth["map"], "after SIGTERM the same result"


def test_two_processes_on_one_store(undisturbed):
    truth, _ = undisturbed
    for name in ("map", "fit"):
        out = folder / f"{name}-twice"
        pair = [start(name, out), start(name, out)]
        for process in pair:
            ended(process, [0], f"{name}, two at once")
        assert result(out, name) == truth[name], f"{name}: two at once give another result"
        counted(out)


# No room: a file cannot grow beyond some size, at ever later moments.
def limited(what, amount):
    def before():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(what, (amount, amount))
    return before


def test_no_room(undisturbed):
    truth, _ = undisturbed
    out = folder / "full"
    for room in (1_000, 30_000, 60_000, 120_000):
        message = ended(start("fit", out, preexec_fn=limited(resource.RLIMIT_FSIZE, room)), [1], f"room for {room} bytes")
        assert "room" in message, f"room for {room} bytes: the message says what is missing: {message}"
    assert start("fit", out).wait() == 0 and result(out, "fit") == truth["fit"], "with room again: the same result"


def test_standard_output_is_full():
    with open("/dev/full", "w") as full:
        process = subprocess.run([PROGRAM, "forward", study], stdout=full, stderr=subprocess.PIPE, text=True)
    assert process.returncode == 1 and "written" in process.stderr, f"standard output is full: {process.stderr}"


def test_a_place_that_cannot_be_written():
    # A place that cannot be written, and a store of another version.
    ended(start("map", "/proc/pavescape"), [2], "a folder that cannot be made")
    (folder / "file").write_text("")
    ended(start("map", folder / "file"), [2], "a file where the folder should be")


def test_a_store_of_another_version_is_left_as_it_was():
    out = folder / "version"
    shutil.copytree(folder / "map-undisturbed", out)
    database = sqlite3.connect(out / "run.sqlite")
    database.execute("PRAGMA user_version = 1")
    database.close()
    before = (out / "run.sqlite").read_bytes()
    assert "version 1" in ended(start("map", out), [2], "a store of another version"), "the version is named"
    assert (out / "run.sqlite").read_bytes() == before, "the store of another version is left as it was"


@pytest.mark.skipif(sanitizer() is not None, reason="a sanitizer allows no other clock")
def test_a_clock_that_jumps(undisturbed):
    truth, _ = undisturbed
    # A clock that jumps back and forth.
    out = folder / "clock"
    process = start("fit", out, env={**os.environ, "LD_PRELOAD": str(JUMPING_CLOCK)})
    ended(process, [0], "a clock that jumps")
    assert result(out, "fit") == truth["fit"], "a clock that jumps changes the result"


@pytest.mark.skipif(sanitizer() is not None, reason="a sanitizer needs memory of its own")
def test_memory_runs_out(undisturbed):
    truth, _ = undisturbed
    # Memory runs out, at ever later moments: a message and a sound store, or the right result.
    out = folder / "memory"
    ends = []
    for megabytes in (150, 200, 250, 300, 350, 400, 450, 500, 600, 700):
        process = start("fit", out, "--threads", 2, preexec_fn=limited(resource.RLIMIT_AS, megabytes * 2**20))
        ended(process, [0, 1, 2], f"{megabytes} MB of memory")
        ends.append(process.returncode)
        if (out / "run.sqlite").exists():
            counted(out)
    print("ends without memory:", ends)
    assert start("fit", out).wait() == 0 and result(out, "fit") == truth["fit"], "with memory again: the same result"
