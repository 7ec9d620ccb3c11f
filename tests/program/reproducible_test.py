"""The same bits for any number of threads, and for a run that is killed half way and continued; nothing is repeated."""
import json
import signal
import time

from support import *

folder = workspace()
study = write_study(folder)


def export(out):
    done = run("export", out)
    check(done.returncode == 0, f"export {out}: {done.stderr}")
    return done.stdout


commands = {"map": ("map", study, "--design", "sobol", "--points", 300),
            "fit": ("fit", study, "--explore", 60, "--starts", 6)}
for name, command in commands.items():
    tables = {}
    results = {}
    for threads in (1, 2, 4):
        out = folder / f"{name}-{threads}"
        done = run(*command, "--threads", threads, "--out", out, "--json")
        check(done.returncode == 0, f"{name} with {threads} threads: {done.stderr}")
        results[threads] = json.loads(done.stdout)
        tables[threads] = export(out)
    check(tables[1] == tables[2] == tables[4], f"{name}: the tables of 1, 2 and 4 threads differ")
    lines = len(tables[1].splitlines()) - 1
    print(f"{name}: {lines} evaluations, the same for 1, 2 and 4 threads")
    check(lines >= 60, f"{name}: too few evaluations")
    if name == "map":
        check(results[1]["statuses"]["invalid-parameters"] > 0 and results[1]["statuses"]["converged"] > 0,
              "the map should hold points with and without an answer")

    # Kill it twice on the way, then let it end.
    out = folder / f"{name}-killed"
    kept = 0
    for share in (0.25, 0.6):
        process = subprocess.Popen([PROGRAM, *map(str, command), "--out", str(out)], stdout=subprocess.DEVNULL)
        while evaluations(out) < share * lines and process.poll() is None:
            time.sleep(0.01)
        process.send_signal(signal.SIGKILL)
        process.wait()
        now = evaluations(out)
        check(kept < now < lines, f"{name}: killed with {now} of {lines} evaluations")
        kept = now
    done = run(*command, "--out", out, "--json")
    check(done.returncode == 0, f"{name} continued: {done.stderr}")
    check(export(out) == tables[1], f"{name}: the table of the killed and continued run differs")
    if name == "map":
        result = json.loads(done.stdout)
        check(result["kept"] == kept, f"map: {result['kept']} kept, {kept} were finished")
        check(result["computed"] == lines - kept, "map: something finished was computed again")
    print(f"{name}: killed at {kept} of {lines}, continued, the same table")

    # Ctrl-C: exit status 130, and what is done is kept.
    out = folder / f"{name}-interrupted"
    process = subprocess.Popen([PROGRAM, *map(str, command), "--out", str(out)], stdout=subprocess.DEVNULL,
                               stderr=subprocess.PIPE, text=True)
    while evaluations(out) < 0.3 * lines and process.poll() is None:
        time.sleep(0.01)
    process.send_signal(signal.SIGINT)
    message = process.communicate()[1]
    check(process.returncode == 130, f"{name}: interrupted, exit status {process.returncode}")
    check("kept" in message, f"{name}: the interrupt says what is kept: {message}")
    check(0 < evaluations(out) < lines, f"{name}: interrupted with {evaluations(out)} evaluations")
    run(*command, "--out", out)
    check(export(out) == tables[1], f"{name}: the table of the interrupted and continued run differs")

finish()
