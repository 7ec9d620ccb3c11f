"""What the commands say of their answers: nothing that the data do not support, nothing important left unsaid."""
import json
import math
import re
import shutil

import pytest

from support import *

folder = workspace()
NOISY = STUDY.replace('misfit = "log"', 'misfit = "log"\nnoise_relative = 0.05')


def made(name, study, data=DATA):
    place = folder / name
    return write_study(place, study, data)


def answer(command, study, *options):
    done = run(command, study, "--json", "--out", study.parent / command, *options)
    assert done.returncode == 0, f"{command} {study.parent.name}: {done.stderr}"
    return json.loads(done.stdout)


# A weight on the only group shapes nothing and says nothing of the noise.
plain = made("plain", NOISY)


@pytest.fixture(scope="module")
def fits():
    return {1: answer("fit", plain, "--explore", 24, "--starts", 3)}


def test_a_weight_on_the_only_group_shapes_nothing(fits):
    verdicts = {1: answer("unique", plain, "--explore", 16, "--verify", 3)["verdict"]}
    for weight in (25, 0.02):
        weighed = made(f"weight-{weight}", NOISY + f"\n[data.weights]\nfwd = {weight}\n")
        fits[weight] = answer("fit", weighed, "--explore", 24, "--starts", 3)
        u = answer("unique", weighed, "--explore", 16, "--verify", 3)
        verdicts[weight] = u["verdict"]
        assert any("weights" in sentence for sentence in u["findings"]), f"weight {weight}: unique says what became of it"
    for weight, fit in fits.items():
        assert abs(fit["noise"]["chi2"] / fits[1]["noise"]["chi2"] - 1) < 1e-3, f"weight {weight}: chi2 {fit['noise']['chi2']}"
        for name, error in fit["best"]["standard_errors"].items():
            assert error is None or abs(error / fits[1]["best"]["standard_errors"][name] - 1) < 1e-2, f"weight {weight}: standard error of {name}: {error}"
    assert len(set(verdicts.values())) == 1, f"weights do not turn a verdict: {verdicts}"


def test_fit_and_unique_say_why_they_differ():
    # fit minimises the log misfit, unique chi2: both say that they may differ for that; by the noise they are one and say nothing.
    for misfit, differs in (("log", True), ("weighted", False)):
        study = made(f"objective-{misfit}", NOISY.replace('misfit = "log"', f'misfit = "{misfit}"'))
        for command, options in (("fit", ("--explore", 24, "--starts", 3)), ("unique", ("--explore", 16, "--verify", 3))):
            said = answer(command, study, *options)["findings"]
            assert any(f"minimises the {misfit} misfit" in s for s in said) == differs, f"{command}, {misfit}: why fit and unique differ: {said}"


def test_a_twin_is_accused_of_no_error():
    # A twin without an error is accused of none, whatever the misfit; neither is one whose noise is as stated.
    for misfit in ("log", "relative", "weighted"):
        for noise in (0, 0.03):
            study = made(f"twin-{misfit}-{noise}", NOISY.replace('misfit = "log"', f'misfit = "{misfit}"').replace("noise_relative = 0.05", "noise_relative = 0.03"))
            twin = answer("twin", study, "--noise", noise, "--seed", 3)
            (study.parent / "small.csv").write_text((study.parent / "twin" / "twin.csv").read_text())
            said = answer("fit", study, "--explore", 24, "--starts", 2)["findings"]
            assert not any("wrong there" in s for s in said), f"{misfit}, noise {noise}: no reading is accused: {said}"


def test_what_the_data_contradict_stands_first():
    wrong = DATA.replace("520,um", "700,um")
    said = answer("fit", made("wrong", NOISY.replace("0.05", "0.02"), wrong), "--explore", 24, "--starts", 2)["findings"]
    assert said[0].startswith("The model does not fit"), f"what the data contradict stands first: {said[0]}"


def test_nothing_is_accused_at_a_bound():
    # Parameters on bounds follow no reading: what is within its noise stays so, though the box keeps four parameters from following it.
    others = "".join(f'\n[[parameters]]\nname = "base.{name}"\nmin = {low}\nmax = {high}\n' for name, low, high in (("k2", 0, 0.47), ("k3", -0.27, 0)))
    more = DATA + "fwd,deflection,900,0,0,0,0.12,mm,\nfwd,deflection,450,0,0,0,0.32,mm,\n"
    exact = made("exact", NOISY + others.replace("0.47", "0.6").replace("-0.27", "-0.4"), more)
    answer("twin", exact, "--noise", 0)
    bounded = made("bounded", NOISY + others, (exact.parent / "twin" / "twin.csv").read_text())
    fit = answer("fit", bounded, "--explore", 24, "--starts", 2)
    assert len(fit["at_bounds"]) > 0 and fit["noise"]["p_value"] > 0.9, f"the truth lies a little beyond the box: {fit['at_bounds']} {fit['noise']}"
    assert not any("wrong there" in s for s in fit["findings"]), f"nothing is accused at a bound: {fit['findings']}"


def test_a_sentinel_is_accused():
    sentinel = answer("fit", made("sentinel", NOISY.replace("0.05", "0.02").replace('misfit = "log"', 'misfit = "weighted"'), DATA.replace("520,um", "-9999,um")), "--explore", 24, "--starts", 2)
    said = [s for s in sentinel["findings"] if "stands out" in s]
    assert len(said) == 1 and "measured -9999" in said[0] and "p = 0 " not in said[0], f"the sentinel is accused, not what fits because of it: {said}"
    done = run("check", folder / "sentinel" / "small.toml")
    assert done.returncode == 0 and "= -9999: no pavement reads that" in " ".join(done.stdout.split()), f"check names it before anything runs: {done.stdout} {done.stderr}"


def test_noise_without_effect_is_said():
    # Noise that the study states for readings that state their own: which of its keys take effect.
    own = made("own-sigma", STUDY.replace('misfit = "log"', 'misfit = "weighted"') + "\n[data.noise]\nrelative = 0.02\nabsolute = { um = 5 }\ncommon_relative = 0.01\n",
               "".join(line + ("1e-5\n" if "strain_zz" in line else "5\n" if ",um," in line else "0.01\n" if line.startswith("fwd") else "\n") for line in DATA.splitlines()))
    WORDS = "the relative part and absolute have no effect on it; common_relative has on all"
    for command, options in (("fit", ("--explore", 24, "--starts", 2)), ("unique", ("--explore", 16, "--verify", 3))):
        said = answer(command, own, *options)["findings"]
        assert any(WORDS in s for s in said), f"{command}: keys without effect: {said}"
    done = run("check", own)
    assert done.returncode == 0 and WORDS in " ".join(done.stdout.split()), f"check: keys without effect: {done.stdout} {done.stderr}"
    assert "no effect" not in " ".join(run("check", plain).stdout.split()), "and nothing is said where they act"


def test_check_tells_the_time_of_diagnose():
    # What diagnose takes is timed with its effects by finite elements, where the study's own linear layers cost next to nothing.
    layered = made("layered", LAYERED, LAYERED_BOWL)
    times = {c["command"]: c["seconds"] for c in json.loads(run("check", layered, "--time", "--threads", 1, "--json").stdout)["commands"]}
    spent = os.times()
    answer("diagnose", layered, "--threads", 1)
    spent = os.times().children_user - spent.children_user
    assert 0.5 * spent < times["diagnose"] < 20 * spent, f"check says {times['diagnose']} s of diagnose, which takes {spent} s where the model is adequate"


def test_a_run_that_takes_too_long_ends_with_words():
    limited = made("limited", (ROOT / "grids" / "dual-nonlinear.toml").read_text().replace("[solver]", "[solver]\ntime_limit_s = 0.01"))
    done = run("forward", limited)
    assert done.returncode == 1 and "time_limit_s" in done.stderr, f"a run that takes too long: {done.returncode} {done.stderr}"


def test_more_parameters_than_readings_are_said_first():
    # More parameters than readings: said first, with what is known of which.
    few = DATA[:DATA.index("fwd,deflection,300")]
    more = made("few", NOISY, few)
    fit = answer("fit", more, "--explore", 24, "--starts", 2)
    assert "1 reading for 2 parameters" in fit["findings"][0], f"too few readings: {fit['findings'][0]}"
    assert fit["readings"] == 1 and set(fit["best"]["std_error"]) == {"base.k1", "base.n"}, "readings and errors in JSON"
    assert fit["free_parameters"] == 2 - len(fit["at_bounds"]), f"free parameters: {fit['free_parameters']} {fit['at_bounds']}"


def test_a_parameter_that_the_box_stops():
    # A parameter that the box stops: its bound, to the last digit, in fit and in unique.
    bound = made("bound", NOISY.replace("max = 8000", "max = 1000"))
    fit = answer("fit", bound, "--explore", 24, "--starts", 2)
    assert fit["at_bounds"] == ["base.k1"] and fit["best"]["std_error"]["base.k1"] is None, f"at a bound: {fit['at_bounds']}"
    assert any("base.k1 at its upper bound" in s for s in fit["findings"]), "and said"
    u = answer("unique", bound, "--explore", 16, "--verify", 3)
    k1 = next(p for p in u["profiles"] if p["name"] == "base.k1")
    assert k1["high"] == 1000, f"the profile ends at the bound: {k1['high']}"
    assert u["verdict"] != "unique" or "bound" in u["findings"][0], f"an answer that the box makes says so: {u['findings'][0]}"


def test_what_stays_open_beside_a_bound_is_in_the_first_sentence():
    study = folder / "valley" / "study.toml"
    study.parent.mkdir()
    study.write_text((ROOT / "grids/captif-p1-unique-fwd.toml").read_text())
    for data in (ROOT / "grids").glob("captif-p1*.csv"):
        shutil.copy(data, study.parent)
    fit = answer("fit", study, "--explore", 64, "--starts", 4)
    assert fit["at_bounds"], "a case with a parameter on its bound"
    scales = {p["name"]: (p["min"], p["max"], math.log if p["scale"] == "log" else float) for p in fit["parameters"]}
    def share(name, low, high):
        least, most, f = scales[name]
        return (f(high) - f(low)) / (f(most) - f(least))
    wide = [n for n, (low, high) in fit["best"]["ranges_95"].items() if share(n, low, high) >= 0.5 and n not in fit["at_bounds"]]
    assert wide and fit["best"]["not_determined"] == wide, f"{wide}: {fit['best']}"
    assert f"does not determine {', '.join(wide)} and ends on a bound with" in fit["answer"], fit["answer"]


def test_beside_a_bound_diagnose_has_the_ranges_of_the_walks():
    study = folder / "at-bound" / "a.toml"
    study.parent.mkdir()
    assert run("new", study, "--linear").returncode == 0
    u = answer("unique", study, "--explore", 32, "--verify", 4)
    d = answer("diagnose", study)
    assert any("base.modulus_MPa at its lower bound" in words for words in d["findings"]), "a case with a parameter on its bound"
    walked = {p["name"]: (p["low"], p["high"]) for p in u["profiles"]}
    # Values of the two differ in the third digit (layered theory, finite elements).
    for name, (low, high) in walked.items():
        own = d["baseline"]["parameters"][name]
        assert all(abs(a - b) < 0.1 * (high - low) for a, b in ((own["low"], low), (own["high"], high))), f"{name}: {own}, walked {low} to {high}"
    outputs = {o["name"]: o for o in d["outputs"]}
    for o in u["outputs"]:
        own = outputs[o["name"]]
        assert all(abs(own[end] - o[end]) < 0.1 * (o["high"] - o["low"]) for end in ("low", "high")), f"{o['name']}: {own}, walked {o}"
    assert not any("differ from the standard-error ranges" in words for words in u["findings"]), u["findings"]


def test_fewer_starts_than_asked_for_are_said():
    said = answer("fit", plain, "--explore", 12, "--starts", 12)
    assert said["starts"] == 12 or any(f"{said['starts']} of the 12 starts" in s for s in said["findings"]), f"fewer starts: {said['starts']}"


# Deflections of three layers, as a twin of the study's own values with this noise has them.
def bowl(name, noise, offsets, parameters):
    text = NOISY.split("[[outputs]]")[0].split("[[parameters]]")[0].replace('misfit = "log"', 'misfit = "weighted"').replace("refine = 0.4", "refine = 0.25")
    text += "".join(f'\n[[parameters]]\nname = "{p}"\nmin = {low}\nmax = {high}\nscale = "{scale}"\n' for p, low, high, scale in parameters)
    study = made(name, text, DATA.splitlines()[1] + "\n" + "".join(f"fwd,deflection,{x},0,0,0,1,mm,\n" for x in offsets))
    answer("twin", study, "--noise", noise, "--seed", 4)
    (study.parent / "small.csv").write_text((study.parent / "twin" / "twin.csv").read_text())
    return study


# Held at a bound far from the truth: fit and unique say first that the data contradict it, count alike, and no error takes it as known.
OFFSETS = (0, 200, 300, 450, 600, 900, 1200)
MODULI = (("asphalt.modulus_MPa", 500, 20000, "log"), ("subgrade.modulus_MPa", 15, 150, "log"))


def test_what_is_held_at_a_bound_is_contradicted_and_no_error_takes_it_as_known():
    held = bowl("held", 0.02, OFFSETS, (("base.k1", 500, 1500, "log"), *MODULI))
    fit, u = answer("fit", held, "--explore", 24, "--starts", 4), answer("unique", held, "--explore", 24, "--verify", 4)
    assert fit["findings"][0].startswith("base.k1 at its upper bound") and fit["findings"][1].startswith("The model does not fit"), f"fit says it first: {fit['findings'][:2]}"
    assert "contradict" in u["findings"][0] and "base.k1 at its upper bound" in u["findings"][0], f"unique too: {u['findings'][0]}"
    at = held.read_text().replace("modulus_MPa = 3000", f"modulus_MPa = {fit['best']['parameters']['asphalt.modulus_MPa']!r}").replace(
        "modulus_MPa = 45", f"modulus_MPa = {fit['best']['parameters']['subgrade.modulus_MPa']!r}").replace("k1 = 2000", "k1 = 1500")
    slopes = json.loads(run("forward", write_study(held.parent, at, None, name="at"), "--jacobian", "--json").stdout)["jacobian"]["rows"]
    sigmas = [float(line.split(",")[8]) for line in (held.parent / "small.csv").read_text().splitlines() if line.startswith("fwd")]
    normal = [[sum(row[i] * row[j] / sigma**2 for row, sigma in zip(slopes, sigmas)) for j in range(3)] for i in range(3)]
    minor = lambda i, j: normal[i][i] * normal[j][j] - normal[i][j] ** 2
    determinant = sum(normal[0][i] * (normal[1][(i + 1) % 3] * normal[2][(i + 2) % 3] - normal[1][(i + 2) % 3] * normal[2][(i + 1) % 3]) for i in range(3))
    noise = math.sqrt(fit["noise"]["chi2"] / fit["noise"]["degrees_of_freedom"])
    for i, (name, _, _, _) in enumerate((None, *MODULI)[1:], 1):
        wanted = noise * math.sqrt(minor(0, 3 - i) / determinant)
        error = fit["best"]["standard_errors"][name]
        assert abs(error / wanted - 1) < 0.01, f"the standard error of {name} with k1 unknown: {error}, not {wanted}"
    assert fit["noise"]["degrees_of_freedom"] == u["acceptance"]["degrees_of_freedom"] and abs(fit["noise"]["chi2"] / u["acceptance"]["chi2"] - 1) < 1e-6, \
        f"chi2 and its degrees of freedom: {fit['noise']}, {u['acceptance']}"


def test_what_unique_finds_anywhere_fit_does_not_call_determined():
    # Seven readings, five parameters: what unique finds anywhere in the box, fit does not call determined.
    five = bowl("five", 0.03, OFFSETS, (("base.k1", 500, 8000, "log"), ("base.k2", 0, 1, "linear"), ("base.k3", -0.9, 0, "linear"), ("base.n", 0.1, 1, "linear"), MODULI[1]))
    fit, u = answer("fit", five, "--explore", 32, "--starts", 8), answer("unique", five, "--explore", 32, "--verify", 8)
    assert (abs(fit["noise"]["chi2"] / u["acceptance"]["chi2"] - 1) < 1e-6 and fit["noise"]["degrees_of_freedom"] == u["acceptance"]["degrees_of_freedom"] and
            len(fit["minima"]) == len(u["minima"])), \
        "fit and unique: one objective, one grouping, one count"
    loose = next(s for s in u["findings"] if s.startswith("The data accept"))
    unknown = " ".join(s for s in fit["findings"] if s.startswith("Not determined") or "bound:" in s)
    for name in re.findall(r"(base\.\w+) anywhere", loose):
        assert name in unknown, f"unique: {loose} fit: {unknown}"


def test_the_valley_ends_where_the_accepted_rise_does():
    # The valley's sentence ends where the accepted rise does, between the points of the walk.
    valley = bowl("valley", 0.05, (0, 300, 600, 900), (("base.k1", 100, 20000, "log"), ("base.k2", 0, 1, "linear"), MODULI[1]))
    u = answer("unique", valley, "--explore", 32, "--verify", 4)
    words = next(s for s in u["findings"] if s.startswith("The valley was followed"))
    low = min(map(float, re.search(r"base\.k2 from ([\d.]+) to ([\d.]+)", words).groups()))
    k2 = next(p for p in u["profiles"] if p["name"] == "base.k2")
    assert k2["low"] - 1e-3 < low < 0.2, f"the valley ends where the profile does, {k2['low']}: {words}"


def test_a_range_reaches_as_far_as_any_walk_that_is_accepted():
    # A walk that points without an answer end is no border: the range reaches as far as any walk that the data accept, and the valley no further.
    hole = bowl("hole", 0.03, OFFSETS, (("base.k1", 300, 10000, "log"), ("base.k2", 0, 1, "linear"), ("base.n", 0.1, 4.5, "linear"), MODULI[1]))
    u = answer("unique", hole, "--explore", 16, "--verify", 3)
    ranges = {p["name"]: p for p in u["profiles"]}
    assert len(u["traces"]) == 2, f"a valley is followed: {u['findings']}"
    for name, value in ((n, v) for t in u["traces"] for n, v in t["accepted_end"].items()):
        p = ranges[name]
        assert p["low"] * (1 - 1e-9) <= value <= p["high"] * (1 + 1e-9), f"the valley's end is accepted: {name} {value}, {p['low']} to {p['high']}"
    for p, t in ((p, t) for t in u["traces"] for p in t["points"] if p["rise"] <= u["acceptance"]["chi2_rise_allowed"]):
        assert all(ranges[n]["low"] * (1 - 1e-9) <= v <= ranges[n]["high"] * (1 + 1e-9) for n, v in p["parameters"].items()), f"the range holds what is accepted: {p}"


def test_where_everything_ends_on_a_bound_the_box_answers():
    boxed = bowl("boxed", 0.02, OFFSETS, (("base.k1", 500, 1200, "log"), ("subgrade.modulus_MPa", 15, 40, "log")))
    u = answer("unique", boxed, "--explore", 16, "--verify", 3)
    assert all(m.get("at_bounds") for m in u["minima"][:1]) and u["verdict"] == "undecided", f"{u['verdict']}: {u['findings'][0]}"
    assert "ends on a bound" in u["findings"][0], f"and it says why: {u['findings'][0]}"


def test_where_nothing_is_determined_profiles_reach_the_bounds():
    # Nothing is determined: not the ends of the searches come first, and profiles reach their bounds.
    blind = made("blind", NOISY, "".join(line + ("30\n" if line.startswith("fwd") and ",mm," in line else "30000\n" if line.startswith("fwd,d") else "1\n" if
                                         line.startswith("fwd") else "\n") for line in DATA.splitlines()).replace('log"', 'weighted"'))
    fit, u = answer("fit", blind, "--explore", 24, "--starts", 3), answer("unique", blind, "--explore", 16, "--verify", 3)
    assert "starts ended" not in fit["findings"][0], f"nothing is determined: {fit['findings'][0]}"
    k1 = next(p for p in u["profiles"] if p["name"] == "base.k1")
    assert (k1["low"], k1["high"]) == (500, 8000), f"a profile that nothing stops ends at the bounds: {k1['low']} {k1['high']}"
    assert not any("wrong there" in s for s in fit["findings"]), f"and no reading is accused: {fit['findings']}"


def test_no_share_is_above_all_of_the_variance():
    done = run("sensitivity", made("shares", STUDY), "--samples", 8, "--out", folder / "shares" / "run")
    shares = [float(v) for v in re.findall(r"\((\d+) % of its variance", done.stdout)]
    assert done.returncode == 0 and all(share <= 100 for share in shares), f"no share above all of the variance: {shares} {done.stderr}"
    assert "too few for these shares" in done.stdout, "and what makes the estimates too large is said"


def test_another_method_confirms_what_gauss_newton_found():
    # Another method of NLopt starts at what Gauss-Newton found, with derivatives, and the page says what it made of it.
    fit = answer("fit", plain, "--explore", 24, "--starts", 3, "--threads", 1)
    seconds = [m.get("confirmed") or {} for m in fit["minima"]]
    assert all(c.get("method") == "slsqp" and c.get("agrees") for c in seconds), f"confirmed by another method: {seconds}"
    assert any("slsqp" in s for s in fit["findings"]) and sum(c.get("evaluations", 0) for c in seconds) <= fit["evaluations"] / 5 + 1, \
        f"said, and for at most a fifth of the evaluations: {seconds} {fit['evaluations']}"
    assert "slsqp" in run("fit", "--help").stdout.lower(), "fit --help names it"


def test_the_home_of_noise(fits):
    # [data.noise] is the home of noise: relative is the old key, absolute adds to it.
    home = made("home", STUDY.replace("[[parameters]]", "[data.noise]\nrelative = 0.05\n\n[[parameters]]", 1))
    same = answer("fit", home, "--explore", 24, "--starts", 3)
    assert lasting({k: v for k, v in same.items() if k != "study"}) == lasting({k: v for k, v in fits[1].items() if k != "study"}), \
        "[data.noise] relative is noise_relative"
    absolute = made("absolute", STUDY.replace("[[parameters]]", "[data.noise]\nabsolute = { mm = 0.02, microstrain = 20 }\n\n[[parameters]]", 1))
    assert answer("fit", absolute, "--explore", 24, "--starts", 3)["noise"]["source"] == "stated", "an absolute noise is stated noise"
    for text, words in (("relative = -1", "noise"), ("absolute = { furlong = 1 }", "furlong"), ("absolute = { mm = 1, um = 2 }", "um"), ("shape = 3", "shape"),
                        ("absolute = 3", "absolute")):
        done = run("check", made("bad", STUDY.replace("[[parameters]]", f"[data.noise]\n{text}\n\n[[parameters]]", 1)))
        assert done.returncode == 2 and words in done.stderr, f"[data.noise] {text}: {done.returncode} {done.stderr}"
    done = run("check", made("twice", NOISY.replace("[[parameters]]", "[data.noise]\nrelative = 0.05\n\n[[parameters]]", 1)))
    assert done.returncode == 2 and "twice" in done.stderr, f"the relative noise appears twice: {done.stderr}"
