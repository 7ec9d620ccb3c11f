"""Nothing finished is lost, nothing is repeated, nothing is spoilt: killed at random moments, without room, two at once, with a
clock that jumps, without memory. usage: faults_test.py PROGRAM LIBRARY [KILLS]        LIBRARY: jumping_clock"""
import os
import random
import resource
import signal
import time

from support import *

JUMPING_CLOCK = sys.argv[2]
KILLS = int(sys.argv[3]) if len(sys.argv) > 3 else 50  # of each command
seed = random.SystemRandom().randrange(10**6)
random.seed(seed)
print(f"seed {seed}")
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
    check(process.returncode in statuses, f"{label}: exit status {process.returncode}: {message}")
    if process.returncode != 0:
        check(len(message.splitlines()) == 1 and "terminate" not in message, f"{label}: one message: {message}")
        print(f"{label}: exit status {process.returncode}\n    {message.replace(str(folder), '...')}")
    return message


truth, seconds = {}, {}
for name in commands:
    out = folder / f"{name}-undisturbed"
    begin = time.monotonic()
    check(start(name, out).wait() == 0, f"{name}: undisturbed")
    seconds[name] = time.monotonic() - begin
    truth[name] = result(out, name)

# kill -9
for name in commands:
    kills, runs = 0, 0
    while kills < KILLS:
        runs += 1
        out = folder / f"{name}-killed-{runs}"
        while True:
            process = start(name, out, "--threads", random.choice((1, 2)))
            try:
                process.wait(random.uniform(0, seconds[name] / 3) if kills < KILLS else 900)
                break
            except subprocess.TimeoutExpired:
                process.send_signal(signal.SIGKILL)
                process.wait()
                kills += 1
        check(process.returncode == 0, f"{name}: continued after kills: {process.communicate()[1]}")
        check(result(out, name) == truth[name], f"{name}: the killed and continued run differs from the undisturbed one")
        finished, computed = counted(out)
        check(finished == computed, f"{name}: {computed:g} computed for {finished} finished evaluations")
    print(f"{name}: killed {kills} times in {runs} runs of {seconds[name]:.1f} s, the same result, nothing repeated")

# SIGTERM is an interrupt as Ctrl-C is.
out = folder / "terminated"
process = start("map", out)
while evaluations(out) < 20 and process.poll() is None:
    time.sleep(0.01)
process.send_signal(signal.SIGTERM)
message = process.communicate()[1]
check(process.returncode == 130 and "kept" in message, f"SIGTERM: {process.returncode}: {message}")
check(start("map", out).wait() == 0 and result(out, "map") == truth["map"], "after SIGTERM the same result")

# Two processes on one store.
for name in ("map", "fit"):
    out = folder / f"{name}-twice"
    pair = [start(name, out), start(name, out)]
    for process in pair:
        ended(process, [0], f"{name}, two at once")
    check(result(out, name) == truth[name], f"{name}: two at once give another result")
    counted(out)


# No room: a file cannot grow beyond some size, at ever later moments.
def limited(what, amount):
    def before():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(what, (amount, amount))
    return before


out = folder / "full"
for room in (1_000, 30_000, 60_000, 120_000):
    message = ended(start("fit", out, preexec_fn=limited(resource.RLIMIT_FSIZE, room)), [1], f"room for {room} bytes")
    check("room" in message, f"room for {room} bytes: the message says what is missing: {message}")
check(start("fit", out).wait() == 0 and result(out, "fit") == truth["fit"], "with room again: the same result")
with open("/dev/full", "w") as full:
    process = subprocess.run([PROGRAM, "forward", study], stdout=full, stderr=subprocess.PIPE, text=True)
check(process.returncode == 1 and "written" in process.stderr, f"standard output is full: {process.stderr}")

# A place that cannot be written, and a store of another version.
ended(start("map", "/proc/pavescape"), [2], "a folder that cannot be made")
(folder / "file").write_text("")
ended(start("map", folder / "file"), [2], "a file where the folder should be")
out = folder / "version"
shutil.copytree(folder / "map-undisturbed", out)
database = sqlite3.connect(out / "run.sqlite")
database.execute("PRAGMA user_version = 1")
database.close()
before = (out / "run.sqlite").read_bytes()
check("version 1" in ended(start("map", out), [2], "a store of another version"), "the version is named")
check((out / "run.sqlite").read_bytes() == before, "the store of another version is left as it was")

if sanitizer():
    print("left out, for a sanitizer allows neither: a clock that jumps, memory that runs out")
    finish()

# A clock that jumps back and forth.
out = folder / "clock"
process = start("fit", out, env={**os.environ, "LD_PRELOAD": JUMPING_CLOCK})
ended(process, [0], "a clock that jumps")
check(result(out, "fit") == truth["fit"], "a clock that jumps changes the result")

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
check(start("fit", out).wait() == 0 and result(out, "fit") == truth["fit"], "with memory again: the same result")

finish()
