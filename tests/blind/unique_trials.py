"""Twin experiments on `pavescape unique`: COUNT sections and layouts drawn from seeds, of each kind.

deficient: two readings for three parameters, so that the Jacobian has a null vector. The verdict must be non-unique, the
           flat direction that null vector (the cross product of the rows of `forward --jacobian` at the best parameters), and every combination said to be fixed must not change along it.
rich:      deflections, strains and stresses at 1 % noise. The verdict must be unique; the 95 % ranges of the parameters and
           outputs are counted against the truth.

usage: unique_trials.py [--program PROGRAM] [--count COUNT] [--first SEED] [--correlated | --other PROGRAM]
           --correlated: errors are tied as those of repeated drops are (docs/evidence/ranges.md), and the study says so; --other: what another build
           says of these readings, to which errors are independent, each as large
"""
import argparse
import json
import math
import pathlib
import random
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "program"))
from support import STUDY, workspace, write_study  # noqa: E402

COMMON, LENGTH_MM = 0.6, 600  # of the noise of a reading

BOXES = {  # name: low, high, logarithmic, truth drawn from
    "base.k1": (300.0, 8000.0, True, (1200.0, 3000.0)),
    "base.k2": (0.1, 1.0, False, (0.4, 0.7)),
    "base.n": (0.1, 1.0, False, (0.35, 0.7)),
    "subgrade.modulus_MPa": (15.0, 150.0, True, (35.0, 80.0)),
}


def answer(program, *command):
    done = subprocess.run([program, *map(str, command), "--json"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def unit_slope(name, value):
    low, high, logarithmic, _ = BOXES[name]
    return value * math.log(high / low) if logarithmic else high - low


def study(truth, files):
    text = STUDY
    for key, name in (("k1", "base.k1"), ("k2", "base.k2"), ("n", "base.n"), ("modulus_MPa", "subgrade.modulus_MPa")):
        if name in truth:
            head, tail = text.split('name = "base"' if name.startswith("base") else 'name = "subgrade"', 1)
            start = tail.index(f"\n{key} = ") + 1
            end = tail.index("\n", start)
            text = head + ('name = "base"' if name.startswith("base") else 'name = "subgrade"') + tail[:start] + \
                f"{key} = {truth[name]!r}" + tail[end:]
    begin, end = text.index("[[parameters]]"), text.index("[[outputs]]")
    parameters = ""
    for name in truth:
        low, high, logarithmic, _ = BOXES[name]
        parameters += f'[[parameters]]\nname = "{name}"\nmin = {low}\nmax = {high}\nscale = "{"log" if logarithmic else "linear"}"\n\n'
    return text[:begin].replace("small.csv", files) + parameters + text[end:]


def tied(text):
    """The study with the errors of its readings tied."""
    return text.replace('misfit = "log"', f'misfit = "weighted"\n\n[data.noise]\nrelative = 0.01\ncommon_relative = {COMMON * 0.01}\ncorrelation_mm = {LENGTH_MM}')


def as_independent(file):
    """Adds the error in common to what is stated of each reading."""
    head, *rows = [line for line in file.read_text().splitlines() if not line.startswith("#")]
    column = head.split(",").index("sigma")
    for i, row in enumerate(rows):
        cells = row.split(",")
        cells[column] = repr(float(cells[column]) * math.hypot(1.0, COMMON))
        rows[i] = ",".join(cells)
    file.write_text("\n".join([head, *rows]) + "\n")


def twin(options, folder, truth, rows, noise, seed):
    """A study whose data are the truth's responses with noise; returns its path and the exact output."""
    words = tied if options.correlated or options.other else lambda text: text
    write_study(folder, words(study(truth, "small.csv")), "load,quantity,x_mm,y_mm,depth_mm,gauge_mm,value,unit,sigma\n" + rows, "truth")
    answer(options.program, "twin", folder / "truth.toml", "--noise", noise, "--seed", seed, "--out", folder / "twin")
    shutil.copy(folder / "twin" / "twin.csv", folder / "twin.csv")
    (folder / "study.toml").write_text(words(study(truth, "twin.csv")))
    if options.other:
        as_independent(folder / "twin.csv")
        (folder / "study.toml").write_text(study(truth, "twin.csv").replace('misfit = "log"', 'misfit = "weighted"'))
    exact = answer(options.program, "forward", folder / "truth.toml")
    return folder / "study.toml", exact["responses"][-1]["value"]


def analyse(options, path):
    return answer(options.other or options.program, "unique", path, "--out", path.parent / "run", "--explore", 32, "--verify", 6)


def null_vector(options, folder, truth, best):
    """Of d(readings)/d(unit coordinates) / reading at the best parameters."""
    (folder / "best.toml").write_text(study(best, "twin.csv"))
    done = answer(options.program, "forward", folder / "best.toml", "--jacobian")
    rows = []
    for response, row in list(zip(done["responses"], done["jacobian"]["rows"]))[:-1]:
        rows.append([d / response["value"] * unit_slope(name, best[name])
                     for d, name in zip(row, done["jacobian"]["parameters"])])
    (a, b, c), (d, e, f) = rows
    cross = (b * f - c * e, c * d - a * f, a * e - b * d)
    length = math.hypot(*cross)
    return [x / length for x in cross], done["jacobian"]["parameters"]


def deficient(options, seed):
    """(whether the verdict is non-unique, whether the combination is named)"""
    draw = random.Random(seed)
    names = ["base.k1", draw.choice(["base.k2", "base.n"]), "subgrade.modulus_MPa"]
    truth = {name: draw.uniform(*BOXES[name][3]) for name in names}
    rows = f"fwd,deflection,0,0,0,0,1,mm,\nfwd,deflection,{draw.choice([600, 900, 1200])},0,0,0,1,mm,\n"
    folder = workspace()
    path, _ = twin(options, folder, truth, rows, 0.01, seed)
    result = analyse(options, path)
    right = result["verdict"] == "non-unique"
    best = result["minima"][0]["parameters"]
    vector, order = null_vector(options, folder, truth, best)
    inside = all(BOXES[n][0] * (1 + 1e-6) < best[n] < BOXES[n][1] * (1 - 1e-6) for n in names)
    named = True
    if inside:  # on a bound the parameter there has no part in the direction
        flattest = result["directions"][-1]
        named = flattest["flat"] and abs(sum(flattest["vector"][n] * v for n, v in zip(order, vector))) > 0.99
        for combination in result["spectrum"]["fixed_combinations"]:
            # d(combination) along the null vector, against the size of its terms
            terms = [c * v * unit_slope(n, best[n]) / (best[n] if BOXES[n][2] else 1.0)
                     for n, v in zip(order, vector) if (c := combination["coefficients"].get(n)) is not None]
            named = named and abs(sum(terms)) < 0.05 * max(map(abs, terms))
        named = named and len(result["spectrum"]["fixed_combinations"]) > 0
    return right, named


def rich(options, seed):
    """(whether the verdict is unique, {name: whether its range holds the truth})"""
    draw = random.Random(1000 + seed)
    truth = {name: draw.uniform(*box[3]) for name, box in BOXES.items()}
    rows = "".join(f"fwd,deflection,{x},0,0,0,1,mm,\n" for x in (0, 200, 300, 450, 600, 900, 1200))
    rows += "".join(f"fwd,strain_zz,0,0,{z},75,1,microstrain,\n" for z in (90, 165, 240, 330, 450, 600))
    rows += "".join(f"fwd,stress_zz,0,0,{z},0,1,kPa,\n" for z in (150, 300))
    path, output = twin(options, workspace(), truth, rows, 0.01, seed)
    result = analyse(options, path)
    inside = {p["name"]: p["low"] <= truth[p["name"]] <= p["high"] for p in result["profiles"]}
    inside["output"] = result["outputs"][0]["low"] <= output <= result["outputs"][0]["high"]
    return result["verdict"] == "unique", inside


def rates(options):
    """What goes wrong of `options.count` trials, in sentences; none: nothing that chance does not do."""
    called = named = unique = 0
    covered = {name: 0 for name in (*BOXES, "output")}
    for seed in range(options.first, options.first + options.count):
        right, name = (True, True) if options.other else deficient(options, seed)
        called += right
        named += name
        well, inside = rich(options, seed)
        unique += well
        for key, value in inside.items():
            covered[key] += value
        print(f"{seed - options.first + 1}: deficient called non-unique {called}, combination named {named}; rich called unique {unique}; "
              f"truth in the 95 % range {covered}", flush=True)
    if options.other:
        return []
    count = options.count
    # Of few trials one may go wrong by chance; of many, one in twenty. 95 % coverage within four binomial standard deviations; at 100 trials at least 90.
    most = max(1, count // 20)
    least = 0.95 * count - max(5.0, 4.0 * math.sqrt(0.95 * 0.05 * count)) if count < 100 else 0.90 * count
    wrong = [f"{words} in {right} of {count}" for words, right in (("deficient layouts: called non-unique", called), ("deficient layouts: the combination named", named),
                                                                   ("rich layouts: called unique", unique)) if right < count - most]
    return wrong + [f"{key}: {held} of {count} ranges hold the truth" for key, held in covered.items() if held < least]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=str(ROOT / "build/release/explore/pavescape"))
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--first", type=int, default=1)
    parser.add_argument("--correlated", action="store_true")
    parser.add_argument("--other")
    if wrong := rates(parser.parse_args()):
        sys.exit("\n".join(wrong))


if __name__ == "__main__":
    main()
