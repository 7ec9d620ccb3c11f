"""Effects that a study with a model of its own declares: found by `diagnose`, written as an extended study, wrong input."""
import math
import random

from any_model_test import Model, program_study, serve, study_of
from support import *

TIMES = [0.6 * (i + 1) for i in range(20)]  # until the level alone is left
SIGMA = 0.01
DECLARED = """
[[effects]]
name = "a level that stays"
parameter = "level"
null = 0.0
typical = 0.1
range = [-0.5, 0.5]

[[effects]]
name = "late clock"
parameter = "clock_s"
null = 0.0
typical = 0.1
range = [-0.2, 0.2]
"""


class Switched(Model):
    """y = exp(-k1 (t - clock)) + exp(-k2 (t - clock)) + level: two parameters, two switches."""
    times, inputs = TIMES, 4

    def __call__(self, k):
        return [math.exp(-k[0] * (t - k[3])) + math.exp(-k[1] * (t - k[3])) + k[2] for t in TIMES]


def read(seed, level=0.0, clock=0.0, wrong=None):
    """Readings of the model with k = (0.4, 1.6) and normal errors."""
    chance = random.Random(seed)
    values = [y + chance.gauss(0, SIGMA) for y in Switched()([0.4, 1.6, level, clock])]
    if wrong is not None:
        values[wrong] *= 1.25
    return [(f"y{i + 1}", repr(y), SIGMA) for i, y in enumerate(values)]


def study(folder, url, readings):
    return study_of(folder, f'type = "um-bridge"\nurl = "{url}"\nname = "decay"',
                    [("k1", 0.1, 0.8, 'scale = "log"'), ("k2", 0.9, 4, 'scale = "log"')], readings, more=DECLARED)


@pytest.fixture(scope="module")
def url():
    address, _, server = serve(Switched())
    yield address
    server.shutdown()


def diagnosed(folder, url, readings):
    done = run("diagnose", study(folder, url, readings), "--explore", 16, "--starts", 2, "--bootstrap", 10, "--json", "--out", folder / "out", "--threads", 1)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_a_declared_effect_is_named_with_its_size_and_the_extended_study_runs(url):
    folder = workspace()
    answer = diagnosed(folder, url, read(3, level=0.15))
    assert answer["verdict"] == "cause-named", answer["findings"]
    first = answer["hypotheses"][0]
    assert (first["kind"], first["name"]) == ("effect", "a level that stays"), first
    size = first["sizes"]["a level that stays"]
    deviation = (size["high"] - size["low"]) / (2 * 1.96)  # of 95 % intervals one in twenty misses: three deviations
    assert abs(size["value"] - 0.15) < 3 * deviation and deviation < 0.01, size
    assert any("level is 0.1" in text for text in answer["findings"]), answer["findings"]
    assert "late clock" in {row["name"] for row in answer["hypotheses"]}, "beside the others on equal terms"
    extended = next((folder / "out").glob("*.toml"))
    fitted = run("fit", extended, "--explore", 16, "--starts", 2, "--joint-only", "--json", "--out", folder / "out2")
    assert fitted.returncode == 0, fitted.stderr
    assert json.loads(fitted.stdout)["best"]["parameters"]["a level that stays.size"] == pytest.approx(size["value"], rel=1e-2)
    page = run("report", folder / "out")
    assert page.returncode == 0, page.stderr


def test_nothing_hidden_is_adequate(url):
    folder = workspace()
    answer = diagnosed(folder, url, read(4))
    assert answer["verdict"] == "adequate" and answer["hypotheses"][0]["kind"] == "none", answer["findings"]


def test_a_wrong_reading_is_named(url):
    folder = workspace()
    answer = diagnosed(folder, url, read(5, wrong=6))
    assert answer["verdict"] == "cause-named" and answer["hypotheses"][0]["kind"] == "readings", answer["findings"]
    assert "reading 7" in answer["hypotheses"][0]["name"], answer["hypotheses"][0]


def within(readings, low, high):
    """As an instrument gives them that is blind below and clipped above."""
    return [(name, f"<{low}" if float(value) < low else f">{high}" if float(value) > high else value, sigma) for name, value, sigma in readings]


def test_an_effect_is_named_where_some_readings_are_limits(url):
    # Of 20 readings the first is clipped, and of the last, at which the level alone is left, no more is known than that they lie below 0.17.
    answer = diagnosed(workspace(), url, (readings := within(read(3, level=0.15), 0.17, 1.2)))
    limits = sum(str(value)[0] in "<>" for _, value, _ in readings)
    assert limits >= 5 and readings[0][1] == ">1.2" and readings[-1][1] == "<0.17", readings
    assert answer["verdict"] == "cause-named" and answer["causes"] == ["a level that stays"], answer["findings"]
    first = answer["hypotheses"][0]
    size = first["sizes"]["a level that stays"]
    deviation = (size["high"] - size["low"]) / (2 * 1.96)
    assert abs(size["value"] - 0.15) < 3 * deviation and deviation < 0.01, size
    # Draws of the noise are the readings with a value, less two rates and a level.
    assert answer["extended"]["dof"] == len(TIMES) - limits - 3 and answer["extended"]["p_value"] > 0.05, answer["extended"]
    assert any(text.startswith(f"{limits} readings are limits") for text in answer["findings"]), answer["findings"]


def test_nothing_is_named_where_nothing_is_hidden_and_some_readings_are_limits(url):
    answer = diagnosed(workspace(), url, (readings := within(read(4), 0.05, 1.0)))
    assert sum(str(value)[0] in "<>" for _, value, _ in readings) >= 7, readings
    assert answer["verdict"] == "adequate" and answer["hypotheses"][0]["kind"] == "none", answer["findings"]


def test_a_limit_that_is_wrong_is_named(url):
    readings = read(5)
    name, value, sigma = readings[6]
    assert float(value) > 0.15
    readings[6] = (name, "<0.05", sigma)
    answer = diagnosed(workspace(), url, readings)
    assert answer["verdict"] == "cause-named" and answer["hypotheses"][0]["kind"] == "readings" and "reading 7" in answer["hypotheses"][0]["name"], answer["findings"]


# --- through a program, whose files an extended study has to find

LINE = """
import json
a, shift = (float(line) for line in open("in.txt"))
json.dump({"readings": [a * t + shift for t in (1, 2, 3, 4)]}, open("out.json", "w"))
"""
SHIFT = '[[effects]]\nname = "shift"\nparameter = "shift_V"\nnull = 0.0\ntypical = 1.0\nrange = [-5, 5]\n'


def line(folder, more=SHIFT, template="{{a}}\n{{shift_V}}\n"):
    return program_study(folder, LINE, [("a", 0.5, 8, "value = 2")], [(f"r{t}", 2 * t, 0.1) for t in (1, 2, 3, 4)], template=template, more=more)


def responses(study, *more):
    done = run("forward", study, "--json", *more)
    assert done.returncode == 0, done.stderr
    answer = json.loads(done.stdout)
    return [r["value"] for r in answer["responses"]], answer.get("jacobian", {}).get("rows")


def test_a_declared_effect_is_none_until_it_has_a_size():
    folder = workspace()
    assert responses(line(folder))[0] == [2, 4, 6, 8]
    assert responses(line(folder, SHIFT + "size = 0.5\n"))[0] == [2.5, 4.5, 6.5, 8.5]
    # Its size and those of what instruments do are parameters: gain (a t + shift), and of one reading (1 + error) times.
    more = SHIFT + 'size = 0.5\n[[effects]]\nname = "sensor-gain"\nsize = 1.5\n[[effects]]\nname = "outlier"\nreading = 3\nsize = 0.25\n'
    more += "".join(f'[[parameters]]\nname = "{name}.size"\nmin = {low}\nmax = {high}\n' for name, low, high in [("shift", -5, 5), ("sensor-gain", 0.5, 2), ("outlier", -1, 1)])
    values, jacobian = responses(line(folder, more), "--jacobian")
    assert values == pytest.approx([1.5 * 2.5, 1.5 * 4.5, 1.25 * 1.5 * 6.5, 1.5 * 8.5], rel=1e-14)
    assert jacobian[2] == pytest.approx([1.25 * 1.5 * 3, 1.25 * 1.5, 1.25 * 6.5, 1.5 * 6.5], rel=1e-6)
    assert responses(line(folder, more), "--set", "outlier.size=0", "--set", "shift.size=1")[0] == pytest.approx([4.5, 7.5, 10.5, 13.5])


def test_an_extended_study_finds_templates_and_files_of_another_folder():
    folder = workspace()
    elsewhere = folder / "elsewhere"
    elsewhere.mkdir()
    text = line(folder).read_text().replace('type = "program"', 'type = "program"\nfolder = ".."').replace('files = ["data.csv"]', 'files = ["../data.csv"]\noutside = true')
    (elsewhere / "study.toml").write_text(text)
    assert responses(elsewhere / "study.toml")[0] == [2, 4, 6, 8]


@pytest.mark.parametrize("change, place, words", [
    (lambda s: s.replace('"shift_V"\nnull', '"a"\nnull'), "parameter", "this parameter is fitted"),
    (lambda s: s.replace("null = 0.0", "null = 6.0"), "null", "value out of range"),
    (lambda s: s.replace("typical = 1.0", "typical = 0.0"), "typical", "a typical size is another than none"),
    (lambda s: s.replace("[-5, 5]", "[5, -5]"), "range", "two ends, the smaller first"),
    (lambda s: s.replace("[-5, 5]", "[-5, 0, 5]"), "range", "two ends"),
    (lambda s: s + SHIFT, "name", "this effect is given twice"),
    (lambda s: s + SHIFT.replace('"shift"', '"other"'), "parameter", "two effects change this parameter"),
    (lambda s: s.replace('"shift"', '"damping"'), "name", "cannot be the name of an effect"),
    (lambda s: s.replace("null = 0.0\n", ""), "null", ""),
    (lambda s: s.replace("typical", "typicall"), "typicall", "typical"),
    (lambda s: s + "size = 9\n", "size", "value out of range"),
], ids=["fitted", "null", "typical", "swapped", "three ends", "twice", "one parameter", "catalogue", "no null", "key", "size"])
def test_bad_effects(change, place, words):
    folder = workspace()
    bad = line(folder)
    bad.write_text(change(bad.read_text()))
    done = run("check", bad)
    assert done.returncode == 2 and place in done.stderr and words in done.stderr and "study.toml:" in done.stderr, done.stderr
    assert len(done.stderr.strip().splitlines()) == 1, done.stderr


def test_a_parameter_that_the_model_does_not_have():
    done = run("check", line(workspace(), template="{{a}}\n"))
    assert done.returncode == 2 and "no template has a place for this parameter" in done.stderr and "shift_V" in done.stderr and "study.toml:" in done.stderr, done.stderr


def test_an_unknown_name_that_is_known_not_to_be_there():
    done = run("diagnose", line(workspace()), "--without", "shfit")
    assert done.returncode == 2 and 'did you mean "shift"?' in done.stderr, done.stderr


def test_a_twin_with_a_declared_effect(url):
    folder = workspace()
    own = study(folder, url, read(6))

    def values(*more):
        done = run("twin", own, "--json", "--out", folder / "twin", *more)
        assert done.returncode == 0, done.stderr
        return [row["value"] for row in json.loads(done.stdout)["measurements"]]

    # At the same parameters: what is between them is the effect.
    plain, changed = values(), values("--effect", "a level that stays=0.15")
    assert [b - a for a, b in zip(plain, changed)] == pytest.approx([0.15] * len(TIMES), rel=1e-9)
    assert "y1,,model" in (folder / "twin" / "twin.csv").read_text()
    for effect, words in (("a level that stay=0.15", 'did you mean "a level that stays"?'), ("a level that stays=7", "size out of range"), ("water-table=1", "unknown effect")):
        wrong = run("twin", own, "--out", folder / "wrong", "--effect", effect)
        assert wrong.returncode == 2 and words in wrong.stderr, wrong.stderr
