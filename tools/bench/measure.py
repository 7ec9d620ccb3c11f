"""Runs the benchmarks of a build and writes their tables into docs/evidence/performance.md. Called by tools/bench/run.

Every figure is a median over rounds in which each thing is measured once, in turn, so that ratios hold where the machine
drifts. Work of one thread is measured in CPU seconds, which other programs on the machine disturb least.
"""
import csv
import io
import json
import os
import re
import shutil
import statistics
import subprocess
import sys
import tempfile
import time

PLANE = "grids/captif-p1-fwd.toml"
BOWL = "grids/captif-p1-unique-fwd.toml"
SOLID = "grids/dual-nonlinear.toml"
DOCUMENT = "docs/evidence/performance.md"
STARTS = 32
ROAD = "grids/road-example.toml"
STATIONS = 200


class Process:
    """One run of a command: CPU and wall seconds, peak memory [MB], standard output."""

    def __init__(self, *command, cwd=None):
        begin = time.monotonic()
        with tempfile.TemporaryFile("w+") as out:
            child = subprocess.Popen(command, stdout=out, stderr=subprocess.DEVNULL, cwd=cwd,
                                     env=dict(os.environ, OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1"))
            _, status, usage = os.wait4(child.pid, 0)
            child.returncode = os.waitstatus_to_exitcode(status)
            self.wall = time.monotonic() - begin
            out.seek(0)
            self.out = out.read()
        if child.returncode != 0:
            sys.exit(f"{' '.join(command)}: exit status {child.returncode}")
        self.cpu = usage.ru_utime + usage.ru_stime
        self.memory = usage.ru_maxrss / 1024.0


def median(values):
    return statistics.median(values)


def table(header, rows):
    lines = ["| " + " | ".join(header) + " |", "|---" + "|---:" * (len(header) - 1) + "|"]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows]) + "\n"


def inside(build, rounds):
    """The Google Benchmark program: medians of CPU milliseconds and the counters."""
    out = Process(f"{build}/tools/bench/benchmarks", "--benchmark_format=json", f"--benchmark_repetitions={rounds}",
                  "--benchmark_enable_random_interleaving=true", "--benchmark_min_time=0.2").out
    times, counters = {}, {}
    for run in json.loads(out)["benchmarks"]:
        name = run["run_name"].removesuffix("/process_time")
        if run["run_type"] == "iteration":
            times.setdefault(name, []).append(run["cpu_time"])
            counters[name] = run
    return {name: median(values) for name, values in times.items()}, counters


def inside_table(build, rounds):
    ms, counters = inside(build, rounds)
    rows = []
    for kind, title in (("plane", "axisymmetric"), ("solid", "3D")):
        unit = ms[f"{kind}/factorisation"]
        n = int(counters[f"{kind}/factorisation"]["unknowns"])
        rows.append([f"one CHOLMOD factorisation, {title}, {n:,} unknowns", f"{unit:.2f}", "1", ""])
        forward = ms[f"{kind}/forward"]
        c = counters[f"{kind}/forward"]
        steps = f"{int(c['load_steps'])} load steps, {int(c['factorizations'])} factorisations" + (
            f", {int(c['iterations'])} conjugate gradient steps" if c["iterations"] else "")
        rows.append([f"forward run ({steps})", f"{forward:.1f}", f"{forward / unit:.1f}", "1"])
        if kind == "plane":
            bowl = ms["layered/jacobian"]
            rows.append(["for comparison: a bowl of 4 linear layers, 9 sensors, with 4 derivatives, without a mesh",
                         f"{bowl:.3f}", f"{bowl / unit:.2f}", ""])
        for name, words in (("jacobian", "with 5 derivatives"), ("geometry", "with 2 derivatives by geometry")):
            if f"{kind}/{name}" in ms:
                value = ms[f"{kind}/{name}"]
                rows.append([words, f"{value:.1f}", f"{value / unit:.1f}", f"{value / forward:.2f}"])
    return table(["in one process, one thread", "CPU ms", "factorisations", "forward runs"], rows)


def process_table(build, rounds):
    program = f"{build}/explore/pavescape"
    Process(f"{build}/tools/accuracy/calculix/compare_calculix", SOLID)  # writes the input of CalculiX
    deck = "output/compare-calculix/" + os.path.basename(SOLID).removesuffix(".toml")
    runs = {"ccx": [], "forward": [], "plane": []}
    for _ in range(rounds):
        runs["ccx"].append(Process("ccx", "model", cwd=deck))
        runs["forward"].append(Process(program, "forward", SOLID, "--json"))
        runs["plane"].append(Process(program, "forward", PLANE, "--json"))
    unit = median([r.cpu for r in runs["ccx"]])
    rows = []
    for name, words in (("ccx", "one linear solution by CalculiX, 3D"), ("forward", "nonlinear forward run, 3D"),
                        ("plane", "nonlinear forward run, axisymmetric")):
        cpu = median([r.cpu for r in runs[name]])
        rows.append([words, f"{cpu:.2f}", f"{cpu / unit:.2f}", f"{median([r.memory for r in runs[name]]):.0f}"])
    return table(["whole process, one thread", "CPU s", "CalculiX runs", "peak MB"], rows)


def fit(program, folder, *options):
    process = Process(program, "fit", PLANE, "--out", folder, "--starts", str(STARTS), "--joint-only", "--json", *options)
    return process, json.loads(process.out)


def throughput_table(build, rounds, folder):
    program = f"{build}/explore/pavescape"
    rate = {1: [], 2: []}
    seconds = {1: [], 2: []}
    memory = {}
    number = 0
    for _ in range(rounds):
        for threads in (1, 2):
            number += 1
            process = Process(program, "map", PLANE, "--design", "sobol", "--points", "512", "--threads", str(threads),
                              "--out", f"{folder}/map{number}", "--json")
            rate[threads].append(json.loads(process.out)["runs_per_second"])
            process, _ = fit(program, f"{folder}/fit{number}", "--threads", str(threads))
            seconds[threads].append(process.wall)
            memory[threads] = process.memory
    gain = median([b / a for a, b in zip(rate[1], rate[2])])
    fit_gain = median([a / b for a, b in zip(seconds[1], seconds[2])])
    rows = [["map, forward runs per second", f"{median(rate[1]):.0f}", f"{median(rate[2]):.0f}", f"{gain:.2f}"],
            [f"fit from {STARTS} starts, wall seconds", f"{median(seconds[1]):.1f}", f"{median(seconds[2]):.1f}",
             f"{fit_gain:.2f}"],
            ["peak memory of the fit [MB]", f"{memory[1]:.0f}", f"{memory[2]:.0f}", ""]]
    return table(["axisymmetric demo study", "1 thread", "2 threads", "gain"], rows)


def survey_table(build, rounds, folder):
    """A long road of known moduli, with noise: how fast, and how near the moduli come back."""
    program = f"{build}/explore/pavescape"
    road = f"{folder}/road.csv"
    text = Process("tools/data/road-example", "--program", program, "--count", str(STATIONS)).out
    with open(road, "w", encoding="utf-8") as f:
        f.write(text)
    truth = {name: [float(v) for v in values.split()] for name, values in re.findall(r"^# (P\d+): (.*)$", text, re.M)}
    seconds = {1: [], 2: []}
    for number in range(rounds):
        for threads in (1, 2):
            process = Process(program, "survey", road, "--study", ROAD, "--threads", str(threads), "--out",
                              f"{folder}/road{number}{threads}", "--json")
            seconds[threads].append(process.wall)
    survey = json.loads(process.out)
    counts = survey["counts"]
    fitted = [s for s in survey["stations"] if "fit" in s]
    errors = {}
    for s in fitted:
        for (name, value), true in zip(s["fit"]["parameters"].items(), truth[s["station"]]):
            errors.setdefault(name, []).append(abs(value / true - 1.0))
    rows = [["wall seconds", f"{median(seconds[1]):.1f}", f"{median(seconds[2]):.1f}"],
            ["stations back-calculated per minute", *(f"{60 * counts['fitted'] / median(seconds[n]):.0f}" for n in (1, 2))]]
    end = (f"\n{counts['stations']} stations: {counts['fitted']} back-calculated, {counts['rejected']} rejected with their reasons, "
           f"{counts['failed']} failed. Median error under 0.5 % noise: "
           + ", ".join(f"{name} {100 * median(list_):.1f} %" for name, list_ in errors.items()) + ".\n")
    return table(["survey of a road", "1 thread", "2 threads"], rows) + end


def own_model_table(build, rounds, folder):
    """What a server or a program costs beside the work it does: maps of one thread, wall milliseconds a run."""
    program, points = f"{build}/explore/pavescape", 2000
    own = f"{folder}/own"
    os.makedirs(own)

    def write(name, text):
        with open(f"{own}/{name}", "w", encoding="utf-8") as f:
            f.write(text)

    with open("grids/layered-bowl.toml", encoding="utf-8") as f:
        section = f.read().split("[[outputs]]")[0]
    search = '[data]\nfiles = ["{}.csv"]\nmisfit = "relative"\n[[parameters]]\nname = "base.modulus_MPa"\nmin = 100\nmax = 1500\n'
    write("bowl.csv", "load,quantity,x_mm,y_mm,depth_mm,gauge_mm,value,unit,sigma\n"
          + "".join(f"fwd,deflection,{x},0,0,0,0.3,mm,\n" for x in (0, 300, 600, 900, 1800)))
    write("one.csv", "name,value\none,1\n")
    write("direct.toml", section + search.format("bowl"))
    write("one.in", "name,value\none,{{base.modulus_MPa}}\n")
    write("program.toml", 'schema = 1\n[model]\ntype = "program"\ncommand = ["cp", "one.txt", "one.csv"]\n'
          'inputs = [{ template = "one.in", file = "one.txt" }]\noutputs = [{ file = "one.csv", by = ["name"] }]\n' + search.format("one"))
    server = subprocess.Popen([program, "serve", f"{own}/direct.toml", "--port", "0", "--threads", "1"], stdout=subprocess.PIPE,
                              stderr=subprocess.DEVNULL, text=True)
    try:
        url = server.stdout.readline().split(" at ")[1].strip()
        write("server.toml", f'schema = 1\n[model]\ntype = "um-bridge"\nurl = "{url}"\n' + search.format("bowl"))
        ms = {name: [] for name in ("direct", "server", "program", "cp")}
        for number in range(rounds):
            for name in ("direct", "server", "program"):
                out = Process(program, "map", f"{own}/{name}.toml", "--design", "sobol", "--points", str(points), "--threads", "1", "--out",
                              f"{own}/{name}{number}", "--json").out
                ms[name].append(1e3 / json.loads(out)["runs_per_second"])
            begin = time.monotonic()
            for _ in range(points):
                os.waitpid(os.posix_spawnp("cp", ["cp", f"{own}/one.in", f"{own}/one.out"], os.environ), 0)
            ms["cp"].append(1e3 * (time.monotonic() - begin) / points)
    finally:
        server.terminate()
        server.wait()
    rows = []
    for name, alone, words in (("server", "direct", "a bowl of four linear layers through `serve` and the UM-Bridge client"),
                               ("program", "cp", "a program that does nothing (`cp`): folder, template, start, reading")):
        extra = median([a - b for a, b in zip(ms[name], ms[alone])])
        rows.append([words, f"{median(ms[name]):.2f}", f"{median(ms[alone]):.2f}", f"{extra:.2f}"])
    return table(["a model of your own, one thread", "wall ms a run", "its own work", "beyond it"], rows)


def report_table(build, rounds, folder):
    """Reports in a browser: from its start to a picture of the page, against an empty page."""
    program = f"{build}/explore/pavescape"
    runs = {"fit of the demo study": ["fit", PLANE, "--starts", str(STARTS)],
            "diagnosis": ["diagnose", "grids/captif-p1-diagnose-strain.toml"],
            "survey of a road": ["survey", "grids/road-example.csv", "--study", ROAD]}
    pages = {}
    for number, (name, command) in enumerate(runs.items()):
        Process(program, *command, "--out", f"{folder}/run{number}")
        pages[name] = f"{folder}/run{number}/report.html"
        Process(program, "report", f"{folder}/run{number}")
    pages["an empty page"] = f"{folder}/empty.html"
    with open(pages["an empty page"], "w", encoding="utf-8") as f:
        f.write("<!doctype html><title>empty</title>")
    seconds = {name: [] for name in pages}
    for _ in range(rounds):
        for name, page in pages.items():
            seconds[name].append(Process(
                "chromium", "--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking",
                "--disable-component-update", "--disable-sync", f"--user-data-dir={folder}/profile",
                f"--screenshot={folder}/page.png", "--window-size=1200,8000", f"file://{page}").wall)
    rows = [[name, f"{os.path.getsize(page) / 1e6:.1f}", f"{median(seconds[name]):.1f}"] for name, page in pages.items()]
    return table(["report", "MB", "wall seconds"], rows)


def landscape_table(build, rounds, folder):
    """The corner figure of the demo: the whole of `unique` by the reduced model, which is built in it, against full forward runs."""
    program = f"{build}/explore/pavescape"
    points = 512
    runs, whole = [], []
    for number in range(rounds):
        runs.append(Process(program, "map", PLANE, "--design", "sobol", "--points", str(points), "--threads", "1", "--out",
                            f"{folder}/runs{number}", "--json").cpu / points)
        whole.append(Process(program, "unique", PLANE, "--model", "auto", "--threads", "1", "--out", f"{folder}/corner{number}", "--json"))
    landscape = json.loads(whole[0].out)["landscape"]
    nodes = sum(len(p["x_values"]) * len(p["y_values"]) for p in landscape["pairs"])
    unit, cpu = median(runs), median([w.cpu for w in whole])
    rows = [["a full forward run", f"{unit:.4f}", "1"],
            [f"`unique --model auto`, all of it: the reduced model built, {len(landscape['pairs'])} pairs of {nodes:,} nodes", f"{cpu:.1f}",
             f"{median([w.cpu / r for w, r in zip(whole, runs)]):,.0f}"]]
    return table(["the corner figure of the demo study, one thread", "CPU s", "forward runs"], rows)


def posterior_table(build, steps, folder):
    """10,000 effective draws of the posterior of the demo's bowl, and how many runs one of them costs an ensemble through Python."""
    study = f"{folder}/posterior/study.toml"
    os.makedirs(os.path.dirname(study))
    with open(BOWL, encoding="utf-8") as f:
        text = f.read().split("[[outputs]]")[0]  # an output under another load would be most of the work
    with open(study, "w", encoding="utf-8") as f:
        f.write(text)
    shutil.copy("grids/captif-p1-fwd-near.csv", os.path.dirname(study))
    own = Process(f"{build}/explore/pavescape", "sample", study, "--samples", "12000", "--threads", "1", "--out", f"{folder}/sample", "--json")
    sample = json.loads(own.out)
    ensemble = json.loads(Process("/usr/bin/python3", "tools/bench/posterior.py", f"{build}/python", study, f"{folder}/sample/samples.csv",
                                  str(steps)).out)
    effective = min(p["ess"] for p in sample["parameters"])
    unit = ensemble["run_with_derivatives_s"]
    full = sample["reduced_model"]["loads"][0]["full_runs"] + sample["correction"]["full_runs"]
    rows = [["a full run with derivatives", f"{unit:.4f}", "1", "", "", ""],
            ["`sample --samples 12000`, the reduced model built in it", f"{own.cpu:.1f}", f"{own.cpu / unit:,.0f}", f"{effective:,.0f}",
             f"{full:,}", f"{full / effective:.2f}"],
            [f"ensemble of stretch moves, {steps:,} steps", f"{ensemble['seconds']:.1f}", f"{ensemble['seconds'] / unit:,.0f}",
             f"{ensemble['effective']:,.0f}", f"{ensemble['runs']:,}", f"{ensemble['runs'] / ensemble['effective']:.0f}"]]
    return table(["the posterior of five parameters, one thread", "CPU s", "of a run with derivatives", "effective draws", "full runs",
                  "full runs a draw"], rows)


def method_table(build, folder):
    program = f"{build}/explore/pavescape"
    names = re.search(r"\{([\w,-]*gauss-newton[\w,-]*)\}", Process(program, "fit", "--help").out)[1].split(",")
    rows = []
    for name in names:
        process, result = fit(program, f"{folder}/{name}", "--method", name)
        minima = result["minima"]
        close = [m for m in minima if m["misfit"] <= best_misfit(minima) * (1 + 1e-3)]
        at_best = sum(len(m["starts"]) for m in close)
        on_bound = sum(len(m["starts"]) for m in minima if m["on_bound"] and m not in close)
        rows.append([name, f"{median([e['evaluations'] for e in result['ends']]):g}", f"{best_misfit(minima):.6f}",
                     f"{100 * at_best / result['starts']:.0f} %", f"{100 * on_bound / result['starts']:.0f} %",
                     f"{process.cpu:.1f}"])
    return table([f"{STARTS} starts", "evaluations a start, median", "best misfit", "ended in the best minimum",
                  "elsewhere on a bound", "CPU s"], rows)


def best_misfit(minima):
    return min(m["misfit"] for m in minima)


def scipy_table(build, folder, count):
    """The inversion from 32 starts, and the first of these starts once more by scipy, one after the other."""
    program = f"{build}/explore/pavescape"
    process, result = fit(program, f"{folder}/scipy", "--threads", "1")
    both, _ = fit(program, f"{folder}/scipy2")
    with open(PLANE, "rb") as f:
        import tomllib
        parameters = tomllib.load(f)["parameters"]
    exported = Process(program, "export", f"{folder}/scipy", "--command", "fit").out
    rows = list(csv.DictReader(io.StringIO("\n".join(l for l in exported.splitlines() if not l.startswith("#")))))
    firsts = {}
    for row in rows:
        if int(row["start"]) >= 0 and row["start"] not in firsts:
            firsts[row["start"]] = [unit_of(p, float(row[p["name"]])) for p in parameters]
    starts = [",".join(repr(u) for u in firsts[key]) for key in sorted(firsts, key=int)][:count]
    outcomes = [json.loads(line) for line in Process("/usr/bin/python3", "tools/bench/scipy_inversion.py", program,
                                                     PLANE, *starts).out.splitlines()]
    best = best_misfit(result["minima"])
    arrived = [o for o in outcomes if o["misfit"] <= best * (1 + 1e-3)]
    theirs = STARTS * median([o["seconds"] for o in outcomes])
    at_best = sum(len(m["starts"]) for m in result["minima"] if m["misfit"] <= best * (1 + 1e-3))
    rows = [[f"`scipy.optimize.least_squares`: {STARTS} times the median of {len(outcomes)} of the starts", f"{theirs:.0f}",
             f"{STARTS * median([o['runs'] for o in outcomes]):.0f}", f"{len(arrived)} of {len(outcomes)}", "1"]]
    for words, own in (("`pavescape fit`, exploration included, one thread", process), (f"the same, {os.cpu_count()} threads", both)):
        rows.append([words, f"{own.wall:.1f}", str(result["evaluations"]), f"{at_best} of {result['starts']}", f"{theirs / own.wall:.0f}"])
    return table([f"inversion from {STARTS} starts", "wall s", "forward runs", "in the best minimum", "times as fast"], rows)


def unit_of(parameter, value):
    import math
    low, high = parameter["min"], parameter["max"]
    if parameter.get("scale") == "log":
        return math.log(value / low) / math.log(high / low)
    return (value - low) / (high - low)


def main():
    build = sys.argv[1]
    quick = "--quick" in sys.argv[2:]
    rounds = 1 if quick else 7
    few = 1 if quick else 3
    with tempfile.TemporaryDirectory() as folder:
        makers = {
            "inside": lambda: inside_table(build, rounds),
            "process": lambda: process_table(build, rounds),
            "throughput": lambda: throughput_table(build, few, folder),
            "survey": lambda: survey_table(build, few, folder),
            "own-model": lambda: own_model_table(build, few, folder),
            "landscape": lambda: landscape_table(build, few, folder),
            "posterior": lambda: posterior_table(build, 100 if quick else 1000, folder),
            "reports": lambda: report_table(build, rounds, folder),
            "methods": lambda: method_table(build, folder),
            "scipy": lambda: scipy_table(build, folder, 1 if quick else 8),
        }
        asked = [name for name in sys.argv[2:] if name != "--quick"] or list(makers)
        if unknown := set(asked) - set(makers):
            sys.exit(f"no table {', '.join(unknown)}; there are {', '.join(makers)}")
        tables = {name: makers[name]() for name in asked}
    for text in tables.values():
        print(text)
    if quick:
        return
    with open(DOCUMENT, encoding="utf-8") as f:
        document = f.read()
    for name, text in tables.items():
        document, found = re.subn(rf"(<!-- {name} -->\n).*?(<!-- end -->)", lambda m: m[1] + text + m[2], document,
                                  flags=re.S)
        assert found == 1, name
    with open(DOCUMENT, "w", encoding="utf-8") as f:
        f.write(document)


if __name__ == "__main__":
    main()
