"""A limit of time: the best answer so far, said as such, and what was cut off goes on to the same end; the same of searches."""
import csv
import time

from support import *

folder = workspace()
# A bowl of three linear layers, made up: some ten thousand points a second.
READINGS = ((0, 0.512), (200, 0.402), (300, 0.343), (600, 0.221), (900, 0.156), (1500, 0.092))
STUDY = 'schema = 1\ntitle = "A bowl"\n' + "".join(
    f'\n[[layers]]\nname = "{name}"\nthickness_mm = {thickness}\ndensity_kg_m3 = 2200\nk0 = 0.5\nlaw = "linear"\nmodulus_MPa = {modulus}\npoisson = 0.4\n'
    for name, thickness, modulus in (("asphalt", 150, 4000), ("base", 300, 300), ("subgrade", 5000, 80))) + """
[[loads]]
name = "fwd"
type = "plate"
radius_mm = 150
pressure_kPa = 700

[data]
files = ["bowl.csv"]
noise_relative = 0.02
""" + "".join(f'\n[[parameters]]\nname = "{name}.modulus_MPa"\nmin = {low}\nmax = {high}\nscale = "log"\n'
              for name, low, high in (("asphalt", 1000, 12000), ("base", 80, 1500), ("subgrade", 20, 300)))
(folder / "study.toml").write_text(STUDY)
(folder / "bowl.csv").write_text("load,quantity,x_mm,y_mm,depth_mm,gauge_mm,value,unit,sigma\n" +
                                 "".join(f"fwd,deflection,{x},0,0,0,{v},mm,\n" for x, v in READINGS))
study = folder / "study.toml"


def table(out, *options):
    lines = [line for line in run("export", out, *options).stdout.splitlines() if not line.startswith("#")]
    return list(csv.DictReader(lines))


@pytest.mark.parametrize("command, options", [("map", ("--design", "sobol", "--points", 400_000)), ("fit", ("--explore", 400_000)),
                                              ("unique", ("--explore", 100_000)), ("diagnose", ("--explore", 100_000)),
                                              ("sample", ("--samples", 1_000_000))])
def test_when_the_time_is_over_the_best_so_far_is_said_as_such(command, options):
    out = folder / command
    begin = time.monotonic()
    done = run(command, study, *options, "--threads", 1, "--time", "0.8s", "--json", "--out", out)
    assert time.monotonic() - begin < 10.0, "all of it takes minutes"
    assert done.returncode == 130, (done.returncode, done.stderr)
    answer = json.loads(done.stdout)
    assert answer["complete"] is False and answer["time_s"] == 0.8 and not (out / f"{command}.json").exists(), answer
    rows = table(out, "--command", command)
    assert answer["evaluations"] >= len(rows) > 10, (answer["evaluations"], len(rows))
    lowest = min((row for row in rows if row["status"] == "converged"), key=lambda row: float(row["misfit"]))
    assert abs(answer["best"]["misfit"] / float(lowest["misfit"]) - 1) < 1e-6, (answer["best"], lowest)
    for name, value in answer["best"]["parameters"].items():
        assert abs(float(lowest[name]) / value - 1) < 1e-6, (name, lowest)
    for seconds in ("1.2s", "6s", "30s"):  # a busy machine may need the time to get to where it was
        text = run(command, study, *options, "--threads", 1, "--time", seconds, "--out", out).stdout
        assert text.startswith("NOT FINISHED") and "goes on" in text and "subgrade.modulus_MPa" in text, text
        if len(table(out, "--command", command)) > len(rows):
            break
    assert len(table(out, "--command", command)) > len(rows), "the same command goes on"


def test_a_fit_that_runs_out_of_time_again_and_again_ends_with_the_same_bits():
    asked = ("fit", study, "--explore", 20_000, "--starts", 4, "--threads", 1, "--json")
    whole = run(*asked, "--out", folder / "whole")
    assert whole.returncode == 0, whole.stderr
    times = 0
    while (done := run(*asked, "--out", folder / "pieces", "--time", "0.6s")).returncode == 130:
        times += 1
        assert times < 200
    assert done.returncode == 0 and times > 0, (times, done.stderr)
    assert table(folder / "pieces") == table(folder / "whole")
    one, other = (json.loads(result.stdout) for result in (whole, done))
    assert one["best"] == other["best"] and one["minima"] == other["minima"]
    enough = run(*asked, "--out", folder / "enough", "--time", "1h")
    assert enough.returncode == 0 and json.loads(enough.stdout)["best"] == one["best"], enough.stderr


@pytest.mark.parametrize("words", ["10", "10 weeks", "-3s", "0s", "min", "1e9h", "nans"])
def test_what_is_no_time_is_refused(words):
    done = run("fit", study, f"--time={words}", "--out", folder / "refused")
    assert done.returncode == 2 and words in done.stderr and "10min" in done.stderr and not (folder / "refused").exists(), done.stderr


def test_searches_that_had_not_converged_when_they_were_ended_go_on():
    asked = ("fit", study, "--explore", 32, "--starts", 4, "--threads", 1, "--joint-only", "--json")
    short = json.loads(run(*asked, "--evaluations", 2, "--out", folder / "on").stdout)
    assert all(not end["converged"] and end["evaluations"] == 2 for end in short["ends"]), short["ends"]
    said = [f for f in short["findings"] if "--evaluations 8 goes on with them" in f]
    assert said and said[0].startswith("4 searches had not converged when they were ended after 2 evaluations"), short["findings"]
    begun = {tuple(row.values()) for row in table(folder / "on")}
    on, fresh = (json.loads(run(*asked, "--evaluations", 60, "--out", folder / name).stdout) for name in ("on", "afresh"))
    assert all(end["converged"] for end in on["ends"]) and not [f for f in on["findings"] if "--evaluations" in f], on["findings"]
    assert on["ends"] == fresh["ends"] and on["best"]["misfit"] < short["best"]["misfit"]
    stored, computed = counted(folder / "on")
    assert begun <= {tuple(row.values()) for row in table(folder / "on")} and stored == computed, "nothing is computed twice"
