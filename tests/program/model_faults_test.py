"""What goes wrong around a model of one's own: servers that are late, or die and come back, and disks without room: one message each, nothing lost."""
import resource
import signal
import time

from any_model_test import Model, ROSENBROCK, decay, rosenbrock, serve
from support import *


class Late(Model):
    """Answers in time until `patience` answers are given, then a minute later."""

    def __init__(self, patience):
        self.patience = patience

    def __call__(self, k):
        self.patience -= 1
        if self.patience < 0:
            time.sleep(60)
        return super().__call__(k)


def one_message(done, *words):
    lines = [line for line in done.stderr.strip().splitlines() if line.startswith("pavescape:")]
    assert done.returncode == 1 and len(lines) == 1 and all(word in lines[0] for word in words), done.stderr


def test_a_server_that_answers_late():
    folder = workspace()
    url, _, server = serve(Late(0))
    begin = time.monotonic()
    one_message(run("forward", decay(folder, url, keys="time_limit_s = 0.5")), "did not answer within time_limit_s = 0.5")
    assert time.monotonic() - begin < 30
    server.shutdown()


def test_a_server_that_dies_and_comes_back_costs_what_it_was_computing():
    folder = workspace()
    url, _, server = serve(Model())
    study = decay(folder, url)
    asked = ("map", study, "--design", "grid", "--points", 12, "--threads", 1, "--json")
    whole = run(*asked, "--out", folder / "whole")
    assert whole.returncode == 0, whole.stderr
    server.shutdown()
    # The same address, whose server gives fifty answers and hangs.
    server.server_close()
    port = int(url.rsplit(":", 1)[1])
    url, late, dying = serve(Late(50), port=port)
    study.write_text(study.read_text().replace('name = "decay"', 'name = "decay"\ntime_limit_s = 0.2', 1))
    killed = subprocess.Popen([PROGRAM, *map(str, asked), "--out", str(folder / "out")], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    while evaluations(folder / "out") < 50 and killed.poll() is None:
        time.sleep(0.02)
    dying.shutdown()
    dying.server_close()
    killed.send_signal(signal.SIGINT)
    killed.wait(60)
    kept = evaluations(folder / "out")
    assert kept == 50, "the answers of before are kept, what had none is not"
    url, again, server = serve(Model(), port=port)
    done = run(*asked, "--out", folder / "out")
    server.shutdown()
    assert done.returncode == 0, done.stderr
    assert again.count("/Evaluate") == 144 - 50, "nothing is asked for twice"
    assert json.loads(done.stdout)["lowest"] == json.loads(whole.stdout)["lowest"]


def limited():
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (300_000, 300_000))


def test_a_disk_without_room_for_what_a_program_reads():
    folder = workspace()
    study = rosenbrock(folder, template="{{x}}\n{{y}}\n", script=ROSENBROCK.replace('open("in.txt"))', 'open("in.txt") if line.strip())'))
    (folder / "in.tmpl").write_text("{{x}}\n{{y}}\n" + " " * 400_000 + "\n")
    asked = ("map", study, "--design", "grid", "--points", 2, "--out", folder / "out")
    one_message(run(*asked, preexec_fn=limited), "in.txt cannot be written", "File too large", "another attempt may have an answer")
    assert evaluations(folder / "out") == 0, "a point without room is not kept as one without an answer"
    done = run(*asked)
    assert done.returncode == 0 and evaluations(folder / "out") == 4, done.stderr


def on_small_disk(script, *arguments):
    """Runs a shell script in a mount namespace of its own; skips where none can be made. $1: a folder to mount on."""
    done = subprocess.run(["unshare", "-m", "sh", "-c", script, "sh", *map(str, arguments)], capture_output=True, text=True)
    if "unshare" in done.stderr or "mount:" in done.stderr:
        pytest.skip(f"no disk of one's own can be mounted here: {done.stderr.strip()}")
    return done


# What is written is cut off where the disk is full; more is an error.
CUT_OFF = "open('big.dat', 'wb', buffering=0).write(bytes(3_000_000))"


@pytest.mark.parametrize("writes, ending", [(f"{CUT_OFF}; open('more.dat', 'wb', buffering=0).write(b'1')", "ended with status"),
                                            (CUT_OFF, "ended well, but no room is left in"),
                                            (f"{CUT_OFF}; import os; os.remove('big.dat'); raise SystemExit(os.strerror(28))", "No space left on device")],
                         ids=["fails", "notices nothing", "tidies up"])
def test_a_program_that_fills_the_disk(writes, ending):
    folder = workspace()
    disk, script = folder / "disk", f'open("out.json", "w").write(\'{{"readings": [1, 2]}}\')\nif {str(folder / "disk")!r} in __import__("os").getcwd():\n    {writes}'
    disk.mkdir()
    study = rosenbrock(folder, script=script)
    asked = f"{PROGRAM} map {study} --design grid --points 2 --threads 1 --out {folder}/out"
    full = on_small_disk(f"mount -t tmpfs -o size=1m tmpfs $1 || exit 99\nTMPDIR=$1 {asked}", disk)
    one_message(full, ending, "another attempt may have an answer")
    assert evaluations(folder / "out") == 0, "a point without room is not kept as one without an answer"
    done = subprocess.run(asked.split(), capture_output=True, text=True)
    assert done.returncode == 0 and evaluations(folder / "out") == 4, done.stderr


def test_a_full_disk_under_the_results():
    folder = workspace()
    disk, study = folder / "disk", rosenbrock(folder)
    disk.mkdir()
    asked = f"{PROGRAM} map {study} --design grid --points 24 --threads 1 --json"
    whole = subprocess.run([*asked.split(), "--out", folder / "whole"], capture_output=True, text=True)
    assert whole.returncode == 0, whole.stderr
    # Room for some of the store and its journal, then for both.
    done = on_small_disk(f"mount -t tmpfs -o size=400k tmpfs $1 || exit 99\n"
                         f"{asked} --out $1/out >$2/first 2>$2/first.txt; echo $? >>$2/first.txt\n"
                         f"mkdir $2/kept; cp $1/out/run.sqlite* $2/kept; mount -o remount,size=50m $1\n"
                         f"{asked} --out $1/out >$2/second 2>$2/second.txt; echo $? >>$2/second.txt", disk, folder)
    first, second = ((folder / f"{name}.txt").read_text().strip().splitlines() for name in ("first", "second"))
    messages = [line for line in first if line.startswith("pavescape:")]
    assert first[-1] == "1" and len(messages) == 1 and "no room" in messages[0], (first, done.stderr)
    kept = evaluations(folder / "kept")
    assert 0 < kept < 24 * 24 and second[-1] == "0", (kept, second)
    again = json.loads((folder / "second").read_text())
    assert (again["lowest"], again["statuses"]) == ((whole := json.loads(whole.stdout))["lowest"], whole["statuses"])


def test_no_folder_for_a_run():
    folder = workspace()
    one_message(run("forward", rosenbrock(folder), env={**os.environ, "TMPDIR": "/proc"}), "no folder can be made in /proc")


def test_a_program_that_does_not_exist():
    folder = workspace()
    study = rosenbrock(folder)
    study.write_text(study.read_text().replace('"/usr/bin/python3"', '"no-such-program"', 1))
    done = run("forward", study)
    assert done.returncode in (1, 2) and "no-such-program" in done.stderr and len(done.stderr.strip().splitlines()) == 1, done.stderr
