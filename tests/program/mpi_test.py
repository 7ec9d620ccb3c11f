"""Many processes compute what one does, to the last bit; one that is killed costs what it was computing and no more."""
import random
import re
import signal
import time

import pytest

from support import *

MPIRUN = shutil.which("mpirun")
# Open MPI's own words for: a test that runs as root in a container. It keeps what its plugins set up, and unloads them: leaks of nobody.
ENVIRONMENT = {**leaks_of_others(), "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
folder = workspace()
study = write_study(folder, STUDY.replace('misfit = "log"', 'misfit = "log"\nnoise_relative = 0.05'))
commands = {"map": ["--design", "sobol", "--points", 200],
            "fit": ["--explore", 40, "--starts", 5],
            "unique": ["--explore", 32, "--verify", 8],
            "diagnose": ["--explore", 8, "--starts", 1, "--bootstrap", 2]}


def start(ranks, name, out, *options):
    return subprocess.Popen([MPIRUN, "-n", str(ranks), "--oversubscribe", PROGRAM, name, str(study), *map(str, options),
                             "--threads", "1", "--out", str(out)],
                            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=ENVIRONMENT)


@pytest.fixture(scope="module")
def truth():
    truth = {}
    for name, options in commands.items():
        alone = run(name, study, *options, "--threads", 1, "--out", folder / name)
        assert alone.returncode == 0, f"{name}: alone"
        truth[name] = result(folder / name, name)
        out = folder / f"{name}-4"
        process = start(4, name, out, *options)
        printed, complaints = process.communicate(timeout=600)
        assert process.returncode == 0, f"{name}: four processes: {complaints}"
        assert result(out, name) == truth[name], f"{name}: four processes end with what one ends with"
        # Others did compute, and each answer came once.
        said = re.search(r"(\d+) processes: (\d+) evaluations by the others", complaints)
        assert said and said[1] == "4" and int(said[2]) > 0, f"{name}: the others help: {complaints}"
        assert printed.count(str(out)) == alone.stdout.count(str(folder / name)), f"{name}: one process speaks"
    return truth


def test_stations_of_a_road_are_computed_by_many_processes():
    example = (ROOT / "grids" / "road-together.csv").read_text().splitlines()
    (folder / "road.csv").write_text("\n".join(line for line in example if re.match(r"station,|P0[0-3],", line)) + "\n")
    (folder / "road.toml").write_text((ROOT / "grids" / "road-together.toml").read_text() + "\n[mesh]\nrefine = 0.4\n")
    road = [PROGRAM, "road", folder / "road.csv", "--study", folder / "road.toml", "--diagnose", "--threads", "1", "--json"]
    one, two = (subprocess.run([*before, *road, "--out", folder / f"road-{name}"], capture_output=True, text=True, timeout=600, env=ENVIRONMENT)
                for name, before in (("one", []), ("two", [MPIRUN, "-n", "2", "--oversubscribe"])))
    assert one.returncode == 0 and two.returncode == 0, f"road: {one.stderr} {two.stderr}"
    assert lasting(json.loads(one.stdout)) == lasting(json.loads(two.stdout)), "road: two processes end with what one ends with"
    assert re.search(r"2 processes: [1-9]\d* evaluations by the others", two.stderr), f"road: the other helps: {two.stderr}"


def test_one_process_that_is_killed_costs_what_it_was_computing(truth):
    # One of four is killed in the middle.
    seed = random.SystemRandom().randrange(10**6)
    random.seed(seed)
    print(f"seed {seed}")
    killed = 0
    while killed < 3:
        out = folder / f"killed-{killed}"
        process = start(4, "map", out, *commands["map"])
        while evaluations(out) < 20 and process.poll() is None:
            time.sleep(0.01)
        children = subprocess.run(["pgrep", "-P", str(process.pid)], capture_output=True, text=True).stdout.split()
        time.sleep(random.uniform(0.0, 0.3))
        if len(children) != 4 or process.poll() is not None:
            process.communicate()
            shutil.rmtree(out)
            continue
        try:
            os.kill(int(random.choice(children)), signal.SIGKILL)
        except ProcessLookupError: # it has just ended
            process.communicate()
            shutil.rmtree(out)
            continue
        process.communicate(timeout=60)
        kept = evaluations(out)
        if process.returncode == 0 and kept == 200: # it had ended
            shutil.rmtree(out)
            continue
        assert process.returncode != 0, "a job that lost a process says so"
        assert kept >= 20, "nothing finished is lost"
        process = start(4, "map", out, *commands["map"], "--json")
        again = json.loads(process.communicate(timeout=600)[0])
        assert again["kept"] == kept and again["computed"] == 200 - kept, f"what was finished is not repeated: {kept}, {again['kept']}"
        assert result(out, "map") == truth["map"], "the continuation ends with the same table"
        killed += 1


def test_one_message_whatever_the_number_of_processes():
    for arguments in (["map", folder / "missing.toml"], ["map", study, "--points", "many"], ["mapp", study]):
        done = subprocess.run([MPIRUN, "-n", "3", "--oversubscribe", PROGRAM, *map(str, arguments)], capture_output=True, text=True,
                              env=ENVIRONMENT, timeout=120)
        own = [line for line in done.stderr.splitlines() if line.startswith("pavescape:") or "--points:" in line]
        assert done.returncode != 0 and len(own) == 1, f"{arguments[1:]}: one message: {done.stderr}"
