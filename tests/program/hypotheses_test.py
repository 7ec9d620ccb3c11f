"""`diagnose` where nothing is wrong with the model: noise of another size, wrong readings, faults of the file, rounding; and what it says of outputs and of
the next reading. Data are twins of a small study, changed by hand. How often all this is right: tools/trials/blind."""
import json

from support import *

OFFSETS = (0, 200, 300, 450, 600, 900, 1200)
HEADER = "load,quantity,x_mm,y_mm,depth_mm,gauge_mm,value,unit,sigma\n"
QUICK = ("--explore", 16, "--starts", 2, "--bootstrap", 4, "--threads", 1)
LIGHT = '[[loads]]\nname = "light"\ntype = "plate"\nradius_mm = 150\npressure_kPa = 300\n\n[mesh]'
DROPS = STUDY.replace("[mesh]", LIGHT).replace('misfit = "log"', 'misfit = "weighted"') + (
    '\n[[parameters]]\nname = "subgrade.modulus_MPa"\nmin = 10\nmax = 200\nscale = "log"\n')
LAYOUT = HEADER + "".join(f"{load},deflection,{x},0,0,0,1,mm,\n" for load in ("fwd", "light") for x in OFFSETS) + "".join(
    f"fwd,strain_zz,0,0,{z},75,1,microstrain,\n" for z in (90, 165, 240, 340, 420, 500))
_folder = workspace()


def made(name, noise, seed, change=lambda rows: rows, *options):
    """The study of a twin whose rows (lists of cells) are changed."""
    own = _folder / name
    own.mkdir()
    write_study(own, DROPS.split("[[parameters]]")[0], LAYOUT, "truth")
    done = run("twin", own / "truth.toml", "--noise", noise, "--seed", seed, "--out", own / "twin", *options)
    assert done.returncode == 0, done.stderr
    rows = [line.split(",") for line in (own / "twin" / "twin.csv").read_text().splitlines() if not line.startswith(("#", "load,"))]
    (own / "data.csv").write_text(HEADER + "".join(",".join(cells) + "\n" for cells in change(rows)))
    study = own / "study.toml"
    study.write_text(DROPS.replace("small.csv", "data.csv"))
    return study


def diagnosed(study, *options):
    done = run("diagnose", study, "--json", "--out", study.parent / "run", *QUICK, *options)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def scaled(cells, value=1.0, sigma=1.0):
    return [*cells[:6], repr(float(cells[6]) * value), cells[7], repr(float(cells[8]) * sigma)]


def test_noise_of_another_size_is_no_cause():
    found = diagnosed(made("loud", 0.03, 4, lambda rows: [scaled(c, sigma=1 / 2) for c in rows]))
    assert found["verdict"] == "adequate", found["findings"][0]
    assert 1.4 < found["noise_factor"] < 2.8
    assert found["hypotheses"][0]["kind"] == "noise"
    assert "as large as stated" in found["findings"][0]
    size = found["hypotheses"][0]["sizes"]["noise_factor"]
    assert size["low"] < 2 < size["high"]
    probabilities = [h["probability"] for h in found["hypotheses"]]
    assert abs(sum(probabilities) - 1) < 1e-6 and probabilities == sorted(probabilities, reverse=True)


def test_two_wrong_readings_are_both_named_and_can_be_fitted():
    wrong = {3: 1.3, 9: 0.8}
    study = made("wrong", 0.02, 5, lambda rows: [scaled(c, wrong.get(i, 1.0)) for i, c in enumerate(rows)])
    found = diagnosed(study)
    assert found["causes"] == ["outlier"], found["findings"][0]
    assert sorted(int(e["on"].split()[1].rstrip(":")) for e in found["explanations"][0]["effects"]) == [4, 10]
    assert found["hypotheses"][0]["kind"] == "readings"
    assert "may as well stand elsewhere" not in " ".join(found["findings"]), "each sensor reads right under another load"
    # The extended study has both, and runs.
    done = run("forward", found["extended"]["study"], "--json")
    assert done.returncode == 0, done.stderr
    model = [r["value"] for r in json.loads(done.stdout)["responses"]][: len(found["responses"]["extended"])]
    assert all(abs(a / b - 1) < 1e-6 for a, b in zip(model, found["responses"]["extended"]))


def test_exchanged_sensors_are_named_by_every_command_that_reads_them():
    def exchange(rows):
        rows = [list(c) for c in rows]
        for first in (0, len(OFFSETS)):
            rows[first + 4][6:], rows[first + 5][6:] = rows[first + 5][6:], rows[first + 4][6:]
        return rows

    study = made("exchanged", 0.02, 7, exchange)
    found = diagnosed(study)
    assert found["verdict"] == "cause-named" and found["causes"] == ["sensor-position"], found["findings"][0]
    assert found["hypotheses"][0]["kind"] == "layout" and "600 and 900 mm are exchanged" in found["hypotheses"][0]["name"]
    assert "exchanged" in found["findings"][0]
    assert any("exchanged" in words for words in json.loads(run("check", study, "--json").stdout)["doubtful"])


def test_steps_of_rounding_are_seen_and_added():
    step = 0.0254  # mm
    study = made("steps", 0.003, 9, lambda rows: [scaled([*c[:6], repr(round(float(c[6]) / step) * step), *c[7:]]) if c[1] == "deflection" else c for c in rows])
    found = diagnosed(study)
    assert found["verdict"] == "adequate", found["findings"]
    assert any("steps of 0.02540 mm" in words for words in found["findings"]), found["findings"]


def test_a_gain_of_one_geophone_and_its_place_are_both_offered():
    study = made("geophone", 0.01, 4, lambda rows: [scaled(c, 1.25) if c[1] == "deflection" and c[2] == "600" else c for c in rows])
    found = diagnosed(study)
    assert "sensor-gain" in found["causes"], found["findings"][0]
    asked = found["next_measurement"]
    assert asked["quantity"] in ("deflection", "strain_zz"), "what the study reads comes first"


def test_only_what_can_be_measured_is_proposed():
    study = made("possible", 0.02, 6, lambda rows: rows, "--effect", "weak-subgrade-top=0.9")
    study.write_text(study.read_text() + '\n[measure]\npossible = ["deflection"]\n')
    found = diagnosed(study)
    offered = [r for r in (found["next_measurement"], *found["further_measurements"]) if r]
    assert offered and all(r["quantity"] == "deflection" or r.get("again") for r in offered), offered
    study.write_text(study.read_text().replace('"deflection"]', '"deflexion"]'))
    assert run("diagnose", study, "--json").returncode == 2


def test_outputs_lie_in_their_ranges():
    for name in ("loud", "wrong", "geophone", "possible"):
        folder = _folder / name / "run" / "diagnose.json"
        if not folder.exists():
            continue
        found = json.loads(folder.read_text())
        for output in found["outputs"]:
            shown = output["after"]
            wide = output["if_wrong"]
            assert min(output["low"], wide["low"]) <= shown <= max(output["high"], wide["high"]), (name, output)
        right = any("if the model is right" in words for words in found["findings"])
        assert right == (found["verdict"] in ("adequate", "cause-named")), (name, found["verdict"])
