"""pavescape sample as a user meets it: the promised keys, the same bits for any number of threads, killed and continued."""

from support import *

folder = workspace()
TWO = LAYERED + """
[[parameters]]
name = "subgrade.modulus_MPa"
min = 20
max = 200
scale = "log"

[[outputs]]
name = "top-strain"
load = "fwd"
quantity = "strain_zz"
depth_mm = 630
"""
study = write_study(folder / "s", TWO, LAYERED_BOWL)
options = ["--samples", 800]


def sample(out, *more):
    done = run("sample", study, "--json", "--out", folder / out, *options, *more)
    check(done.returncode == 0, f"{out}: {done.stderr}")
    return lasting(json.loads(done.stdout))


one = sample("one", "--threads", 1)
check(one["status"] == "converged" and one["log_evidence_error"] < 0.3, "converged, with an evidence")
for quantity in one["parameters"] + one["outputs"]:
    for key in ("name", "mean", "sd", "q025", "q50", "q975", "rhat", "ess"):
        check(key in quantity, f"{quantity['name']} has {key}")
    check(quantity["rhat"] <= 1.05 and quantity["ess"] >= 200, f"{quantity['name']}: enough draws")
check(one == sample("two", "--threads", 2), "one thread and two give the same draws")

# Next to linear within its noise: the posterior's 95 % range is the profile's.
unique = json.loads(run("unique", study, "--json", "--out", folder / "u", "--explore", 16, "--verify", 4).stdout)
for quantity, profile in zip(one["parameters"] + one["outputs"], unique["profiles"] + unique["outputs"]):
    width = profile["high"] - profile["low"]
    check(abs(quantity["q025"] - profile["low"]) < 0.2 * width and abs(quantity["q975"] - profile["high"]) < 0.2 * width,
          f"{quantity['name']}: {quantity['q025']} to {quantity['q975']}, profile {profile['low']} to {profile['high']}")

total = evaluations(folder / "one")
before = kill_at(total // 3, folder / "cut", "sample", study, "--json", *options)
check(sample("cut") == one, "a run that was killed and continued ends with the same draws")
check(0 < before < total and evaluations(folder / "cut") == total, "and repeats nothing that was finished")
check(len((folder / "cut" / "samples.csv").read_text().splitlines()) == 801, "a line a draw")

bare = write_study(folder / "bare", TWO, LAYERED_BOWL.split("\n")[0] + "\nfwd,deflection,0,0,0,0,0.5,mm,\n")
done = run("sample", bare, "--out", folder / "b")
check(done.returncode == 2 and done.stdout == "" and "noise" in done.stderr, "without noise: refused")
finish()
