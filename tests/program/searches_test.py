"""What searches find and what is said of it: readings of very unequal weight, bounds, constraints, priors, copies."""
import math
import os
import signal
import subprocess
import time

from support import *

folder = workspace()
OFFSETS = (0, 200, 300, 450, 600, 900, 1200, 1500, 1800)
LAYERS = (("asphalt", 140, 3500, 0.35, 1000, 12000), ("base", 220, 380, 0.35, 100, 2000),
          ("subbase", 260, 160, 0.4, 40, 800), ("subgrade", None, 80, 0.45, 20, 300))
# Of 2 %: made up, their sum of squares about that of as many draws.
ERRORS = (0.8, -1.3, 0.4, 1.1, -0.6, -0.9, 1.6, 0.2, -1.0)


def study(files, layers=LAYERS, bounds={}, extra="", misfit="weighted"):
    text = 'schema = 1\ntitle = "A bowl of linear layers"\n\n[section]\nbottom = "half-space"\n'
    for name, thickness, modulus, poisson, _, _ in layers:
        text += f'\n[[layers]]\nname = "{name}"\ndensity_kg_m3 = 2200\nk0 = 0.5\nlaw = "linear"\nmodulus_MPa = {modulus}\npoisson = {poisson}\n'
        text += f"thickness_mm = {thickness}\n" if thickness else ""
    text += '\n[[loads]]\nname = "fwd"\ntype = "plate"\nradius_mm = 150\npressure_kPa = 700\n'
    text += f'\n[data]\nfiles = {json.dumps(files)}\nmisfit = "{misfit}"\n'
    for name, _, _, _, low, high in layers:
        low, high, line = bounds.get(name, (low, high, ""))
        text += f'\n[[parameters]]\nname = "{name}.modulus_MPa"\nmin = {low}\nmax = {high}\nscale = "log"\n{line}\n'
    return text + extra


def rows(values, sigmas):
    return "load,quantity,x_mm,y_mm,depth_mm,gauge_mm,value,unit,sigma\n" + "".join(
        f"fwd,deflection,{x},0,0,0,{v:.9g},mm,{s}\n" for x, v, s in zip(OFFSETS, values, sigmas))


def made(label, text, **files):
    here = folder / label
    here.mkdir(exist_ok=True)
    for name, content in files.items():
        (here / f"{name}.csv").write_text(content)
    (here / "study.toml").write_text(text)
    return here / "study.toml"


def answer(command, path, *options):
    done = run(command, path, "--json", "--threads", 1, "--out", path.parent / f"out-{command}", *options)
    assert done.returncode == 0, f"{path.parent.name}: {done.stdout}{done.stderr}"
    return json.loads(done.stdout)


def fit(path, explore=32, starts=5):
    return answer("fit", path, "--explore", explore, "--starts", starts, "--joint-only")


def bowl():
    """mm, of the section as it is, with errors of 2 %."""
    path = made("truth", study(["bowl.csv"]), bowl=rows([1.0] * len(OFFSETS), [0.02] * len(OFFSETS)))
    exact = [r["value"] for r in json.loads(run("forward", path, "--json").stdout)["responses"]]
    return [v * (1 + 0.02 * e) for v, e in zip(exact, ERRORS)]


BOWL = bowl()
SIGMAS = [0.02 * v for v in BOWL]


def said(result, words):
    return [f for f in result["findings"] if words in f]


def test_one_reading_far_more_exact_than_the_others_changes_no_answer():
    # A reading that is held ever closer pulls the answer to where it is met: the lowest misfit rises to that and stays.
    found = {}
    for sigma in (1e-3, 1e-5, 1e-7):
        path = made(f"exact-{sigma:g}", study(["bowl.csv"]), bowl=rows(BOWL, [sigma] + SIGMAS[1:]))
        result = fit(path)
        assert result["best"]["converged"] and not said(result, "stands out"), (sigma, result["findings"])
        assert result["best"]["confirmed"]["has_ended"] == bool(said(result, "Two methods agree")), result["findings"]
        found[sigma] = result["best"]["misfit"], len(result["minima"])
    assert abs(found[1e-5][0] / found[1e-3][0] - 1) < 5e-3 and abs(found[1e-7][0] / found[1e-5][0] - 1) < 1e-4, found
    assert len({count for _, count in found.values()}) == 1, found


def test_a_box_that_ends_too_early_is_named_before_the_model_and_no_reading_is_accused():
    path = made("narrow", study(["bowl.csv"], bounds={"subgrade": (20, 65, "")}), bowl=rows(BOWL, SIGMAS))
    narrow = fit(path)
    assert "subgrade.modulus_MPa" in narrow["at_bounds"] and narrow["noise"]["p_value"] < 1e-4, narrow["noise"]
    assert not said(narrow, "stands out"), narrow["findings"]
    order = [narrow["findings"].index(said(narrow, words)[0]) for words in ("at its upper bound", "does not fit")]
    assert order == sorted(order), narrow["findings"]
    one = (("subgrade", None, 80, 0.45, 20, 300),)
    wrong = fit(made("one-layer", study(["bowl.csv"], layers=one), bowl=rows(BOWL, SIGMAS)))
    assert wrong["noise"]["p_value"] < 1e-15 and not said(wrong, "stands out"), wrong["findings"]
    # One that is wrong is still found, though chi2 is then beyond what the noise explains.
    off = [v * (1.3 if x == 600 else 1) for x, v in zip(OFFSETS, BOWL)]
    bad = fit(made("one-wrong", study(["bowl.csv"]), bowl=rows(off, SIGMAS)))
    assert bad["noise"]["p_value"] < 0.01 and said(bad, "@600"), bad["findings"]


def test_minima_under_an_equality_are_those_of_the_tie():
    total = 540
    equal = fit(made("equal", study(["bowl.csv"], extra=f'\n[[constraints]]\nthat = "base.modulus_MPa + subbase.modulus_MPa == {total}"\n'),
                     bowl=rows(BOWL, SIGMAS)), explore=64, starts=8)
    tied = study(["bowl.csv"], bounds={"base": (100, total - 40, "")})
    begin = tied.index('name = "subbase.modulus_MPa"\n')
    end = tied.index("[[parameters]]", begin)
    tied = tied[:begin] + f'name = "subbase.modulus_MPa"\nequals = "{total} - base.modulus_MPa"\n\n' + tied[end:]
    tie = fit(made("tie", tied, bowl=rows(BOWL, SIGMAS)), explore=64, starts=8)
    lowest = [sorted(m["misfit"] for m in result["minima"]) for result in (equal, tie)]
    assert abs(lowest[0][0] / lowest[1][0] - 1) < 1e-3, lowest
    for m in equal["minima"]: # of the tie or a search that ended at none
        assert m["converged"] and any(abs(m["misfit"] / other - 1) < 2e-3 for other in lowest[1]), lowest
    evaluations = [sum(e["evaluations"] for e in r["ends"]) / len(r["ends"]) for r in (equal, tie)]
    assert evaluations[0] < 4 * evaluations[1], evaluations


def test_two_readings_without_noise_are_met_in_one_valley():
    text = study(["bowl.csv"])
    lines = rows(BOWL, [""] * len(OFFSETS)).splitlines()[:3]
    result = fit(made("few", text, bowl="\n".join(lines) + "\n"))
    assert len(result["minima"]) == 1 and not said(result, "times as large"), [m["misfit"] for m in result["minima"]]


def test_ranges_at_an_inequality_are_those_of_the_profile():
    three = tuple(l for l in LAYERS if l[0] != "subbase")
    free = fit(made("free", study(["bowl.csv"], layers=three), bowl=rows(BOWL, SIGMAS)))["best"]["parameters"]
    ratio = 0.8 * free["asphalt.modulus_MPa"] / free["base.modulus_MPa"]
    path = made("ratio", study(["bowl.csv"], layers=three, extra=f'\n[[constraints]]\nthat = "asphalt.modulus_MPa <= {ratio} * base.modulus_MPa"\n'),
                bowl=rows(BOWL, SIGMAS))
    found = fit(path)
    assert found["constraints"][0]["active"], found["constraints"]
    assert said(found, "on one side"), found["findings"]
    walked = {p["name"]: (p["low"], p["high"]) for p in answer("unique", path, "--explore", 32, "--verify", 4)["profiles"]
              if p["name"].endswith("modulus_MPa")}
    for name, (low, high) in found["best"]["ranges_95"].items(): # to first order: within a fifth of what is walked
        wanted = walked[name]
        width = math.log(wanted[1] / wanted[0])
        assert abs(math.log(low / wanted[0])) < 0.2 * width and abs(math.log(high / wanted[1])) < 0.2 * width, (name, low, high, wanted)


def half_space(readings, parameter, extra=""):
    text = study(["bowl.csv"], layers=(("subgrade", None, 70, 0.45, 20, 300),), extra=extra)
    begin = text.index("[[parameters]]")
    return text[:begin] + f'[[parameters]]\nname = "subgrade.modulus_MPa"\n{parameter}\n' + extra, readings


def test_evidence_under_a_constraint_is_that_of_what_it_allows():
    sigma, poisson = 0.15, 0.45
    deflection = lambda modulus: 2 * 0.7 * 150 * (1 - poisson ** 2) / modulus  # mm, the middle of a plate on a half-space
    measured = deflection(70)
    data = rows([measured], [sigma])
    low, high = 20, 160
    nodes = [low + (high - low) * (i + 0.5) / 4000 for i in range(4000)]
    density = lambda d: math.exp(-0.5 * ((measured - deflection(d)) / sigma) ** 2) / (sigma * 1e-3 * math.sqrt(2 * math.pi))
    wanted = math.log(sum(map(density, nodes)) / len(nodes))
    for label, parameter, extra in (("bounds", f"min = {low}\nmax = {high}", ""),
                                    ("constraint", f"min = {low}\nmax = 300", f'\n[[constraints]]\nthat = "subgrade.modulus_MPa <= {high}"\n')):
        text, _ = half_space(None, parameter, extra)
        result = answer("sample", made(f"evidence-{label}", text, bowl=data), "--samples", 1000)
        assert abs(result["log_evidence"] - wanted) < 4 * result["log_evidence_error"] + 0.02, (label, result["log_evidence"], wanted)
    assert said(result, "relative to that"), result["findings"]


def test_a_prior_that_the_readings_contradict_is_blamed_and_not_the_model():
    data = rows([2 * 0.7 * 150 * (1 - 0.45 ** 2) / 70], [0.2])
    text, _ = half_space(None, "min = 20\nmax = 300\nprior = { mean = 190, sd = 12 }")
    path = made("prior", text, bowl=data)
    result = answer("sample", path, "--samples", 1000)
    assert not said(result, "contradict the model"), result["findings"]
    assert said(result, "contradict what is known beforehand") and said(result, "190.0 +- 12.00"), result["findings"]
    page = run("sample", path, "--verbose", "--samples", 1000, "--threads", 1, "--out", path.parent / "out-sample").stdout
    page = " ".join(page.split())
    assert "every parameter was uniform" not in page and "190.0 +- 12.00" in page, page


def test_a_measurement_file_named_twice_is_refused_and_rows_that_agree_are_pointed_out():
    data = rows(BOWL, SIGMAS)
    for label, files in (("twice", ["bowl.csv", "bowl.csv"]), ("dotted", ["bowl.csv", "./bowl.csv"]), ("linked", ["bowl.csv", "link.csv"])):
        path = made(label, study(files), bowl=data)
        if label == "linked":
            (path.parent / "link.csv").symlink_to("bowl.csv")
        for command in ("check", "fit"):
            done = run(command, path, "--threads", 1)
            assert done.returncode != 0 and "named twice" in done.stderr, (label, done.stdout, done.stderr)
    one = fit(made("once", study(["bowl.csv"]), bowl=data))
    assert not said(one, "in every cell"), one["findings"]
    copied = made("copied", study(["bowl.csv", "copy.csv"]), bowl=data, copy="# the same again\n" + data)
    assert said(fit(copied), "9 readings agree in every cell"), "fit says so"
    assert "9 readings agree in every cell" in " ".join(run("check", copied, "--threads", 1).stdout.split()), "check says so"
    # Repeated drops at one place that differ are two readings.
    other = rows([v * 1.001 for v in BOWL], SIGMAS)
    drops = fit(made("drops", study(["bowl.csv", "second.csv"]), bowl=data, second=other))
    assert not said(drops, "in every cell") and drops["readings"] == 18, drops["findings"]


def test_an_error_of_half_the_range_is_no_number():
    thin = (("asphalt", 12, 3500, 0.35, 500, 20000),) + LAYERS[1:]
    path = made("thin", study(["bowl.csv"], layers=thin), bowl=rows(BOWL, [3 * s for s in SIGMAS]))
    result = fit(path)
    loose = [n for n, error in result["best"]["std_error"].items() if error is None]
    assert "asphalt.modulus_MPa" in loose, result["best"]["std_error"]
    if "asphalt.modulus_MPa" not in result["at_bounds"]:
        page = run("fit", path, "--verbose", "--explore", 32, "--starts", 5, "--joint-only", "--threads", 1, "--out", path.parent / "out-fit").stdout
        line = next(l for l in page.splitlines() if l.strip().startswith("asphalt.modulus_MPa"))
        assert "not determined" in line, line


def test_a_limit_of_time_counts_the_processor_and_what_it_ended_is_tried_again():
    slow = STUDY.replace("[mesh]", "[solver]\ntime_limit_s = 1.5\n\n[mesh]")
    path = write_study(folder / "paused", slow)
    process = subprocess.Popen([PROGRAM, "map", str(path), "--design", "sobol", "--points", "8", "--threads", "1", "--json",
                                "--out", str(folder / "paused-out")], stdout=subprocess.PIPE, text=True)
    for _ in range(3):  # wherever in a run it is
        time.sleep(0.1)
        if process.poll() is None:
            os.kill(process.pid, signal.SIGSTOP)
            time.sleep(2.0)
            os.kill(process.pid, signal.SIGCONT)
    assert json.loads(process.communicate()[0])["statuses"]["failed"] == 0, "a pause is not the run's time"
    never = write_study(folder / "never", STUDY.replace("[mesh]", "[solver]\ntime_limit_s = 0.01\n\n[mesh]").replace("refine = 0.4", "refine = 2"))
    for _ in range(2):
        done = run("map", never, "--design", "sobol", "--points", 1, "--threads", 1, "--out", folder / "never-out")
        assert "not kept" in done.stderr, done.stderr
        assert evaluations(folder / "never-out") == 0, "what the limit ended is not in the store"
