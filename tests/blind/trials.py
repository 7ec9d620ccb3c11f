"""Blind trials of `pavescape diagnose`: a generator hides effects in data, the program looks for them, this script judges.

usage: trials.py --program PROGRAM --generator GENERATOR [--one N] [--none N] [--two N] [--removed N] [--power N] [--outside N]
                 [--understated N] [--overstated N] [--heavy N] [--bad N] [--few N] [--middle N] [--common N] [--tied N] [--one_common N] [--one_tied N] [--fault N] [--layout N] [--first SEED] [--jobs J]
                 [--out FOLDER] [--keep] [--page DOCS] [--correlated [--independent]]

one:     an effect of 8 to 20 standard deviations; none: nothing hidden; two: two effects at once; removed: as `one`, but
         the effect is taken out of the catalogue; power: effects of 2 to 12 standard deviations; outside: physics
         that is neither in the catalogue nor of the form of a correction.
understated, overstated, heavy, common, tied: nothing hidden, but errors are not as stated: 1.5 times as large or as small, of Student's t, shared by the
         readings of a load, alike in neighbouring readings; one_common, one_tied: the same with an effect; bad: two or three wrong readings; few: as `one`, with 11 readings; middle: with 20 to 40; fault: of the file; layout: the file states
         another layout of the sensors than the one that was driven.
--correlated: errors are tied as those of repeated drops are, and the study says so; --independent: it says that they are not.
Writes a file a case into the folder (a run that was cut off continues), prints the rates. --page FOLDER: writes tables and pictures of FOLDER/diagnose.md too.
"""
import argparse
import concurrent.futures
import json
import pathlib
import re
import shutil
import subprocess
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "tools" / "shared"))
from svg import svg

AMISS = ("understated", "overstated", "heavy", "common", "tied")  # nothing is wrong but what is stated of the errors
LIKE = {"compaction-bulge": ["base-sublayer"]}  # of what is outside the catalogue: the same thing with other edges
WITH_EFFECT = ("few", "middle", "one_common", "one_tied")
KINDS = ("one", "none", "two", "removed", "power", "outside", *AMISS, "bad", *WITH_EFFECT, "fault", "layout")
CHEAPER = ["--explore", "48", "--starts", "5", "--bootstrap", "10"]  # than the defaults: a landscape of five parameters


def trial(options, kind, seed):
    """One case; one that was judged before, by a program no newer, is not repeated."""
    kept = pathlib.Path(options.out) / f"{kind}-{seed}.json"
    if kept.exists() and kept.stat().st_mtime > max(pathlib.Path(p).stat().st_mtime for p in (options.program, options.generator)):
        return json.loads(kept.read_text())
    result = judge(options, kind, seed)
    kept.write_text(json.dumps(result, indent=1))
    return result


def judge(options, kind, seed):
    folder = pathlib.Path(options.out) / f"{kind}-{seed}"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    what = {"one": ["one"], "none": ["none"], "two": ["two"], "removed": ["one"], "power": ["one", "2", "12"], "outside": ["outside"],
            **{kind: ["one", kind.removeprefix("one_")] for kind in WITH_EFFECT},
            **{data: ["none", data] for data in (*AMISS, "bad", "fault", "layout")}}[kind]
    made = subprocess.run([options.generator, str(seed), folder, *what, *(["correlated"] if options.correlated else [])], capture_output=True, text=True)
    truth = json.loads(made.stdout)
    names = [h["effect"] for h in truth["hidden"]]
    without = [x for name in names for x in ("--without", name)] if kind == "removed" else []
    begin = time.time()
    done = subprocess.run([options.program, "diagnose", folder / ("independent.toml" if options.independent else "study.toml"), "--out", folder / "run", "--json", "--threads", "1",
                           *CHEAPER, *without], capture_output=True, text=True)
    if done.returncode != 0:
        return {"kind": kind, "seed": seed, "truth": truth, "names": names, "verdict": "failed", "causes": [], "error": done.stderr}
    found = json.loads(done.stdout)
    result = {"kind": kind, "seed": seed, "truth": truth, "names": names, "verdict": found["verdict"], "causes": found["causes"],
              "p_value": found["baseline"]["p_value"], "p_familywise": found["baseline"]["p_familywise"],
              "chi2": found["baseline"]["chi2"], "dof": found["baseline"]["dof"], "extended_p": found["extended"]["p_value"],
              "held_out": [found["gain"]["held_out_rmse_before"], found["gain"]["held_out_rmse_after"]],
              "seconds": time.time() - begin, "candidates": found["candidates"][:6],
              "explanations": found["explanations"][:6], "corrections": found.get("corrections", []),
              "noise_factor": found["noise_factor"], "hypotheses": found.get("hypotheses", [])[:8]}
    if kind == "one":
        own = [c for c in found["candidates"] if c["effect"] == names[0]]
        result["own"] = own[0] if own else None
    if not options.keep:
        shutil.rmtree(folder, ignore_errors=True)
    return result


def share(count, total):
    return f"{count} of {total}" + (f" ({100 * count / total:.1f} %)" if total else "")


def hits(r, alike=False):
    """Whether the first correction is in the layer and by the variable of what is hidden."""
    hidden, first = r["truth"]["hidden"][0], r["corrections"][0]
    return any(c["channel"] == hidden["channel"] and c["layer"] == hidden["layer"] for c in [first, *(first["alike"] if alike else [])])


def places_seen(r):
    """[(modulus found, true modulus, whether its band holds that)] at the places that are seen, where layer and variable are right."""
    profile = r["truth"]["hidden"][0]["profile"]
    if not profile or not hits(r):
        return []
    c = r["corrections"][0]
    list = []
    for at, value, low, high, modulus, seen in zip(c["at"], c["values"], c["low"], c["high"], c["modulus_MPa"], c["seen"]):
        true = min(profile, key=lambda p: abs(p[0] - at))[1]
        if seen:
            list.append((modulus, true, low <= true / modulus * value <= high))
    return list


def rates(results):
    """The rates asked for, {name: (count, total)}."""
    of = {kind: [r for r in results if r["kind"] == kind] for kind in KINDS}
    one = of["one"]
    separable = [r for r in one if r["truth"]["ceiling"] >= 0.95]
    unlike = [r for r in of["removed"] if r["truth"]["ceiling"] >= 0.95]
    named = [r for r in one if r["verdict"] == "cause-named"]
    right = [r for r in named if r["causes"] == r["names"]]

    def same_readings(r):
        """A gain of some readings may be found as the opposite gain of the others: its size is then another."""
        hidden = r["truth"]["hidden"][0]
        if hidden["effect"] != "sensor-gain":
            return True
        return r["own"]["on"] == (f"{hidden['load']}, {hidden['quantity']}" if "load" in hidden else f"every {hidden['quantity']}")

    sized = [r for r in right if not r["truth"]["hidden"][0]["form"] and same_readings(r)]

    def holds(r):
        size, own = r["truth"]["hidden"][0]["size"], r["own"]
        # A modulus that differs between two loads may be found as that of the one or of the other.
        turned = r["names"] == ["asphalt-modulus-rate"] and (size > 1) != (own["size"] > 1)
        return own["size_low"] <= (1 / size if turned else size) <= own["size_high"]

    located = [r for r in of["outside"] if r["corrections"]]
    places = [pair for r in located for pair in places_seen(r)]
    outside = {
        "outside the catalogue: not confidently wrong":
            (sum(r["verdict"] != "cause-named" or r["causes"] == LIKE.get(r["names"][0]) for r in of["outside"]), len(of["outside"])),
        "outside the catalogue: a correction is found": (len(located), len(of["outside"])),
        "its layer (or kind of reading) first": (sum(r["corrections"][0]["layer"] == r["truth"]["hidden"][0]["layer"] for r in located), len(located)),
        "its layer and variable first": (sum(hits(r) for r in located), len(located)),
        "its layer and variable first, or nearly as likely": (sum(hits(r, alike=True) for r in located), len(located)),
        "modulus within 10 % where seen": (sum(abs(m / t - 1) < 0.1 for m, t, _ in places), len(places)),
        "modulus within its band where seen": (sum(within for *_, within in places), len(places)),
        "no correction without a hidden effect": (sum(not r.get("corrections") for r in of["none"]), len(of["none"])),
    }
    def finds_all_bad(r):
        """Whether the first explanation is all wrong readings and nothing else."""
        named = [e for e in r["explanations"][:1] for e in e["effects"]]
        return r["causes"] == ["outlier"] and sorted(int(e["on"].split()[1].rstrip(":")) for e in named) == sorted(r["truth"]["bad"])

    def names_fault(r):
        """Whether what happened to the file is the first hypothesis."""
        spoilt, first = r["truth"]["spoilt"], (r.get("hypotheses") or [{"name": "", "kind": ""}])[0]
        words = {"exchanged": "exchanged", "counted from the far end": "counted from the far end", "another unit": "another unit"}[spoilt["fault"]]
        return first["kind"] == "layout" and words in first["name"] and all(f"{at:g} " in first["name"] for at in spoilt.get("at_mm", []))

    def names_layout(r):
        """Whether the first hypothesis is the layout that was driven, or one that is nowhere more than 30 mm from it: the same in inches."""
        first = (r["hypotheses"] or [{"name": "", "kind": ""}])[0]
        named = re.search(r"sensors at ([\d., ]+) mm", first["name"])
        return first["kind"] == "layout" and named is not None and \
            all(abs(float(at) - true) <= 30 for at, true in zip(named[1].split(", "), r["truth"]["sensors_mm"]))

    told = [r for r in named if None not in r["held_out"]]  # with places to leave out

    def names_alone(r):
        """Whether one name stands alone, and it is the hidden one. A sensor out of its place that reads under one load is one wrong reading: named as such, it is right."""
        hidden = r["truth"]["hidden"][0]
        reads = [e["on"] for e in r["explanations"][0]["effects"]] if r["explanations"] else []
        same = hidden["effect"] == "sensor-position" and r["causes"] == ["outlier"] and len(reads) == 1 and reads[0].startswith(f"reading {hidden['reading']}:")
        return r["causes"] == r["names"] or same

    amiss = {
        **{f"{kind}: a name or a place where nothing is wrong": (sum(r["verdict"] in ("cause-named", "ambiguous", "located") for r in of[kind]), len(of[kind]))
           for kind in AMISS},
        "understated: adequate, and the noise larger": (sum(r["verdict"] == "adequate" and r["noise_factor"] > 1 for r in of["understated"]), len(of["understated"])),
        "two or three wrong readings, all and nothing else": (sum(map(finds_all_bad, of["bad"])), len(of["bad"])),
        **{f"{kind}: truth among the causes": (sum(r["names"][0] in r["causes"] or names_alone(r) for r in of[kind]), len(of[kind])) for kind in WITH_EFFECT},
        **{f"{kind}: named alone": (sum(r["verdict"] == "cause-named" and names_alone(r) for r in of[kind]), len(of[kind])) for kind in WITH_EFFECT},
        **{f"{kind}: wrong name alone": (sum(r["verdict"] == "cause-named" and not names_alone(r) for r in of[kind]), len(of[kind])) for kind in WITH_EFFECT},
        "another layout of the sensors: the one that was driven, first": (sum(map(names_layout, of["layout"])), len(of["layout"])),
        "another layout: something else alone": (sum(r["verdict"] == "cause-named" and not names_layout(r) for r in of["layout"]), len(of["layout"])),
        "faults of the file named": (sum(map(names_fault, of["fault"])), len(of["fault"])),
    }
    alone = [r for r in one if r["verdict"] == "cause-named" and r["causes"] == r["names"]]
    return {
        "named alone": (len(alone), len(one)),
        "right name first, where it can be told apart": (sum(r["causes"][:1] == r["names"] for r in separable), len(separable)),
        "wrong name alone": (sum(r["verdict"] == "cause-named" and r["names"][0] not in r["causes"] for r in one), len(one)),
        "truth among the causes": (sum(r["names"][0] in r["causes"] for r in one), len(one)),
        "adequate without a hidden effect": (sum(r["verdict"] == "adequate" for r in of["none"]), len(of["none"])),
        "not confidently wrong with the effect out of the catalogue":
            (sum(r["verdict"] != "cause-named" for r in of["removed"]), len(of["removed"])),
        "the same, where the effect can be told apart":
            (sum(r["verdict"] != "cause-named" for r in unlike), len(unlike)),
        "both of two effects named": (sum(set(r["names"]) <= set(r["causes"]) for r in of["two"]), len(of["two"])),
        "size of a named effect within its 95 % interval":
            (sum(map(holds, sized)), len(sized)),
        "held-out data gain from a named effect": (sum(r["held_out"][1] < r["held_out"][0] for r in told), len(told)),
        **outside,
        **amiss,
    }


def calibration(results):
    """[(from, to, hypotheses given such a probability, how many of them are true)] in steps of 10 %"""
    bins = [[0, 0] for _ in range(10)]
    for r in results:
        if r["kind"] not in ("one", "power", "none", "few"):
            continue
        for h in r["hypotheses"]:
            true = h["kind"] in ("none", "noise") if not r["names"] else h["kind"] in ("effect", "readings") and h["name"].split(" (")[0] == r["names"][0]
            at = min(9, int(10 * h["probability"]))
            bins[at][0] += 1
            bins[at][1] += true
    return [(10 * i, 10 * (i + 1), count, true) for i, (count, true) in enumerate(bins) if count]


def confusion(results):
    """{hidden: {found first: count}}"""
    table = {}
    for r in results:
        if r["kind"] == "one":
            found = r["causes"][0] if r["causes"] else r["verdict"]
            row = table.setdefault(r["names"][0], {})
            row[found] = row.get(found, 0) + 1
    return table


def power_curve(results):
    """[(strength, right name first, anything found, count)] in bins of two standard deviations."""
    bins = []
    for low in range(2, 20, 2):
        inside = [r for r in results if r["kind"] in ("one", "power") and low <= r["truth"]["hidden"][0]["strength"] < low + 2]
        if inside:
            bins.append((low + 1, sum(r["causes"][:1] == r["names"] for r in inside) / len(inside),
                         sum(r["verdict"] != "adequate" for r in inside) / len(inside), len(inside)))
    return bins


def confusion_svg(table):
    hidden = sorted(table)
    found = sorted({f for row in table.values() for f in row})
    cell, left, top = 20, 190, 190
    body = []
    for j, f in enumerate(found):
        x = left + cell * j + 14
        body.append(f'<text transform="translate({x},{top - 6}) rotate(-60)">{f}</text>')
    for i, h in enumerate(hidden):
        y = top + cell * i
        total = sum(table[h].values())
        body.append(f'<text x="{left - 6}" y="{y + 14}" text-anchor="end">{h}</text>')
        for j, f in enumerate(found):
            count = table[h].get(f, 0)
            shade = 255 - int(200 * count / total)
            body.append(f'<rect x="{left + cell * j}" y="{y}" width="{cell}" height="{cell}" '
                        f'fill="rgb({shade},{shade},255)" stroke="#ccc"/>')
            if count:
                body.append(f'<text x="{left + cell * j + cell / 2}" y="{y + 14}" text-anchor="middle" '
                            f'fill="{"white" if shade < 130 else "black"}">{count}</text>')
    body.append(f'<text x="10" y="20">rows: the effect hidden; columns: the first cause found</text>')
    return svg(left + cell * len(found) + 120, top + cell * len(hidden) + 20, "".join(body))


def power_svg(curve):
    width, height, left, bottom = 460, 300, 50, 40
    x = lambda d: left + (d - 2) / 18 * (width - left - 20)
    y = lambda rate: height - bottom - rate * (height - bottom - 30)
    body = [f'<line x1="{left}" y1="{y(0)}" x2="{width - 20}" y2="{y(0)}" stroke="black"/>',
            f'<line x1="{left}" y1="{y(0)}" x2="{left}" y2="{y(1)}" stroke="black"/>',
            f'<text x="{width / 2}" y="{height - 8}" text-anchor="middle">strength of the hidden effect, standard deviations</text>']
    for rate in (0, 0.5, 0.95, 1):
        body.append(f'<text x="{left - 6}" y="{y(rate) + 4}" text-anchor="end">{rate:g}</text>'
                    f'<line x1="{left}" y1="{y(rate)}" x2="{width - 20}" y2="{y(rate)}" stroke="#ddd"/>')
    for d in range(2, 21, 2):
        body.append(f'<text x="{x(d)}" y="{y(0) + 16}" text-anchor="middle">{d}</text>')
    for k, (colour, dash, label) in enumerate((("#1b6ca8", "", "right name first"), ("#b8651b", "6 3", "contradiction found"))):
        points = " ".join(f"{x(c[0]):.1f},{y(c[1 + k]):.1f}" for c in curve)
        body.append(f'<polyline points="{points}" fill="none" stroke="{colour}" stroke-width="2" stroke-dasharray="{dash}"/>'
                    f'<text x="{width - 24}" y="{y(0.3 - 0.1 * k)}" text-anchor="end" fill="{colour}">{label}</text>')
    return svg(width, height, "".join(body))


def run_all(options):
    counts = {kind: getattr(options, kind) for kind in KINDS}
    # Every kind at its pace, so that what is finished early stands for the whole.
    tasks = sorted(((i + 0.5) / count, kind, options.first + i) for kind, count in counts.items() for i in range(count))
    results = []
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        for future in concurrent.futures.as_completed([pool.submit(trial, options, *task[1:]) for task in tasks]):
            r = future.result()
            results.append(r)
            hidden = ", ".join(f"{h['effect']} {h['strength']:.0f}" + ("*" if h["form"] else "") for h in r["truth"]["hidden"]) or "nothing"
            print(f"[{len(results)} of {len(tasks)}] {r['kind']} {r['seed']}: hidden {hidden}: {r['verdict']} {', '.join(r['causes'])}", flush=True)
    results.sort(key=lambda r: (KINDS.index(r["kind"]), r["seed"]))
    return results


def text_of(results):
    """{name of a part of the page: its text}"""
    parts = {}
    rows = [f"| {name} | {share(count, total)} |\n" for name, (count, total) in rates(results).items() if total]
    seconds = sorted(r["seconds"] for r in results if "seconds" in r)
    if seconds:
        rows.append(f"| time of one diagnosis on one thread, median and longest | {seconds[len(seconds) // 2]:.0f} s, {seconds[-1]:.0f} s |\n")
    parts["rates"] = "| | |\n|---|---:|\n" + "".join(rows)
    curve = power_curve(results)
    parts["power"] = "| strength | right name first | contradiction found | cases |\n|---:|---:|---:|---:|\n" + "".join(
        f"| {d - 1} to {d + 1} | {100 * right:.0f} % | {100 * found:.0f} % | {count} |\n" for d, right, found, count in curve)
    rows = calibration(results)
    parts["calibration"] = "| probability | hypotheses | true |\n|---|---:|---:|\n" + "".join(
        f"| {low} to {high} % | {count} | {100 * true / count:.0f} % |\n" for low, high, count, true in rows)
    table = confusion(results)
    parts["confusion"] = "| hidden | found first |\n|---|---|\n" + "".join(
        f"| {hidden} | " + ", ".join(f"{f} {n}" for f, n in sorted(table[hidden].items(), key=lambda item: -item[1])) + " |\n"
        for hidden in sorted(table))
    return parts


def write_page(docs, results):
    page = docs / "diagnose.md"
    document = page.read_text()
    for name, text in text_of(results).items():
        if f"<!-- {name} -->" not in document:
            continue
        document, found = re.subn(rf"(<!-- {name} -->\n).*?(<!-- end -->)", lambda m: m[1] + text + m[2], document, flags=re.S)
        assert found == 1, f"{page} has one part {name}"
    page.write_text(document)
    (docs / "diagnose-confusion.svg").write_text(confusion_svg(confusion(results)))
    (docs / "diagnose-power.svg").write_text(power_svg(power_curve(results)))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", required=True)
    parser.add_argument("--generator", required=True)
    for kind in KINDS:
        parser.add_argument(f"--{kind}", type=int, default=0)
    parser.add_argument("--first", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--out", default="output/blind")
    parser.add_argument("--keep", action="store_true", help="keep studies, data and runs")
    parser.add_argument("--page")
    parser.add_argument("--correlated", action="store_true")
    parser.add_argument("--independent", action="store_true")
    options = parser.parse_args()
    if options.independent and not options.correlated:
        parser.error("--independent is for --correlated errors")
    folder = pathlib.Path(options.out)
    folder.mkdir(parents=True, exist_ok=True)
    results = run_all(options)
    print("\n" + "\n".join(text_of(results).values()))
    if options.page:
        write_page(pathlib.Path(options.page), results)


if __name__ == "__main__":
    main()
