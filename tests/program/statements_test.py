"""What the commands say of their answers: nothing that the data do not support, nothing important left unsaid."""
import json
import re

from support import *

folder = workspace()
NOISY = STUDY.replace('misfit = "log"', 'misfit = "log"\nnoise_relative = 0.05')


def made(name, study, data=DATA):
    place = folder / name
    return write_study(place, study, data)


def answer(command, study, *options):
    done = run(command, study, "--json", "--out", study.parent / command, *options)
    check(done.returncode == 0, f"{command} {study.parent.name}: {done.stderr}")
    return json.loads(done.stdout)


# A weight on the only group shapes nothing and says nothing of the noise.
plain = made("plain", NOISY)
fits = {1: answer("fit", plain, "--explore", 24, "--starts", 3)}
verdicts = {1: answer("unique", plain, "--explore", 16, "--verify", 3)["verdict"]}
for weight in (25, 0.02):
    weighed = made(f"weight-{weight}", NOISY + f"\n[data.weights]\nfwd = {weight}\n")
    fits[weight] = answer("fit", weighed, "--explore", 24, "--starts", 3)
    u = answer("unique", weighed, "--explore", 16, "--verify", 3)
    verdicts[weight] = u["verdict"]
    check(any("weights" in sentence for sentence in u["findings"]), f"weight {weight}: unique says what became of it")
for weight, fit in fits.items():
    check(abs(fit["noise"]["chi2"] / fits[1]["noise"]["chi2"] - 1) < 1e-3, f"weight {weight}: chi2 {fit['noise']['chi2']}")
    for name, error in fit["best"]["standard_errors"].items():
        check(error is None or abs(error / fits[1]["best"]["standard_errors"][name] - 1) < 1e-2, f"weight {weight}: standard error of {name}: {error}")
check(len(set(verdicts.values())) == 1, f"weights do not turn a verdict: {verdicts}")

# A twin without an error is accused of none, whatever the misfit; neither is one whose noise is as stated.
for misfit in ("log", "relative", "weighted"):
    for noise in (0, 0.03):
        study = made(f"twin-{misfit}-{noise}", NOISY.replace('misfit = "log"', f'misfit = "{misfit}"').replace("noise_relative = 0.05", "noise_relative = 0.03"))
        twin = answer("twin", study, "--noise", noise, "--seed", 3)
        (study.parent / "small.csv").write_text((study.parent / "twin" / "twin.csv").read_text())
        said = answer("fit", study, "--explore", 24, "--starts", 2)["findings"]
        check(not any("stands out" in s for s in said), f"{misfit}, noise {noise}: no reading is accused: {said}")
wrong = DATA.replace("520,um", "700,um")
said = answer("fit", made("wrong", NOISY.replace("0.05", "0.02"), wrong), "--explore", 24, "--starts", 2)["findings"]
check(said[0].startswith("The model does not fit"), f"what the data contradict stands first: {said[0]}")
# Parameters on bounds follow no reading: what is within its noise stays so, though the box keeps four parameters from following it.
others = "".join(f'\n[[parameters]]\nname = "base.{name}"\nmin = {low}\nmax = {high}\n' for name, low, high in (("k2", 0, 0.47), ("k3", -0.27, 0)))
more = DATA + "fwd,deflection,900,0,0,0,0.12,mm,\nfwd,deflection,450,0,0,0,0.32,mm,\n"
exact = made("exact", NOISY + others.replace("0.47", "0.6").replace("-0.27", "-0.4"), more)
answer("twin", exact, "--noise", 0)
bounded = made("bounded", NOISY + others, (exact.parent / "twin" / "twin.csv").read_text())
fit = answer("fit", bounded, "--explore", 24, "--starts", 2)
check(len(fit["at_bounds"]) > 0 and fit["noise"]["p_value"] > 0.9, f"the truth lies a little beyond the box: {fit['at_bounds']} {fit['noise']}")
check(not any("stands out" in s for s in fit["findings"]), f"nothing is accused at a bound: {fit['findings']}")
sentinel = answer("fit", made("sentinel", NOISY.replace("0.05", "0.02").replace('misfit = "log"', 'misfit = "weighted"'), DATA.replace("520,um", "-9999,um")), "--explore", 24, "--starts", 2)
said = [s for s in sentinel["findings"] if "stands out" in s]
check(len(said) == 1 and "measured -9999" in said[0] and "p = 0 " not in said[0], f"the sentinel is accused, not what fits because of it: {said}")
done = run("check", folder / "sentinel" / "small.toml")
check(done.returncode == 0 and "= -9999: no pavement reads that" in done.stdout, f"check names it before anything runs: {done.stdout} {done.stderr}")

# A run in three dimensions that takes too long ends with words.
limited = made("limited", (ROOT / "grids" / "dual-nonlinear.toml").read_text().replace("[solver]", "[solver]\ntime_limit_s = 0.01"))
done = run("forward", limited)
check(done.returncode == 1 and "time_limit_s" in done.stderr, f"a run that takes too long: {done.returncode} {done.stderr}")

# More parameters than readings: said first, with what is known of which.
few = DATA[:DATA.index("fwd,deflection,300")]
more = made("few", NOISY, few)
fit = answer("fit", more, "--explore", 24, "--starts", 2)
check("1 reading for 2 parameters" in fit["findings"][0], f"too few readings: {fit['findings'][0]}")
check(fit["readings"] == 1 and set(fit["best"]["std_error"]) == {"base.k1", "base.n"}, "readings and errors in JSON")
check(fit["free_parameters"] == 2 - len(fit["at_bounds"]), f"free parameters: {fit['free_parameters']} {fit['at_bounds']}")

# A parameter that the box stops: its bound, to the last digit, in fit and in unique.
bound = made("bound", NOISY.replace("max = 8000", "max = 1000"))
fit = answer("fit", bound, "--explore", 24, "--starts", 2)
check(fit["at_bounds"] == ["base.k1"] and fit["best"]["std_error"]["base.k1"] is None, f"at a bound: {fit['at_bounds']}")
check(any("base.k1 at its upper bound" in s for s in fit["findings"]), "and said")
u = answer("unique", bound, "--explore", 16, "--verify", 3)
k1 = next(p for p in u["profiles"] if p["name"] == "base.k1")
check(k1["high"] == 1000, f"the profile ends at the bound: {k1['high']}")
check(u["verdict"] != "unique" or "bound" in u["findings"][0], f"an answer that the box makes says so: {u['findings'][0]}")

# Fewer starts than asked for are said.
said = answer("fit", plain, "--explore", 12, "--starts", 12)
check(said["starts"] == 12 or any(f"{said['starts']} of the 12 starts" in s for s in said["findings"]), f"fewer starts: {said['starts']}")

# [data.noise] is the home of noise: relative is the old key, absolute adds to it.
home = made("home", STUDY.replace("[[parameters]]", "[data.noise]\nrelative = 0.05\n\n[[parameters]]", 1))
same = answer("fit", home, "--explore", 24, "--starts", 3)
check(lasting({k: v for k, v in same.items() if k != "study"}) == lasting({k: v for k, v in fits[1].items() if k != "study"}), "[data.noise] relative is noise_relative")
absolute = made("absolute", STUDY.replace("[[parameters]]", "[data.noise]\nabsolute = { mm = 0.02, microstrain = 20 }\n\n[[parameters]]", 1))
check(answer("fit", absolute, "--explore", 24, "--starts", 3)["noise"]["source"] == "stated", "an absolute noise is stated noise")
for text, words in (("relative = -1", "noise"), ("absolute = { furlong = 1 }", "furlong"), ("absolute = { mm = 1, um = 2 }", "um"), ("shape = 3", "shape"),
                    ("absolute = 3", "absolute")):
    done = run("check", made("bad", STUDY.replace("[[parameters]]", f"[data.noise]\n{text}\n\n[[parameters]]", 1)))
    check(done.returncode == 2 and words in done.stderr, f"[data.noise] {text}: {done.returncode} {done.stderr}")
done = run("check", made("twice", NOISY.replace("[[parameters]]", "[data.noise]\nrelative = 0.05\n\n[[parameters]]", 1)))
check(done.returncode == 2 and "twice" in done.stderr, f"the relative noise appears twice: {done.stderr}")
finish()
