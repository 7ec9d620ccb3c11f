"""Effects in the commands: studies with [[effects]], twin --effect, the catalogue, wrong input."""
import json
import re

import pytest

from support import *

folder = workspace()
NAMES = """subgrade-stress-dependence subgrade-depth-gradient weak-subgrade-top anisotropy-distribution base-residual-stress
base-tension interface-slip-asphalt-base interface-slip-base-subgrade floor-depth base-thickness asphalt-modulus-rate load-magnitude
load-offset contact-pressure-shape plate-rigidity gauge-depth gauge-length sensor-gain outlier inertia shear-ratio
wheel-wander sensor-position drift asphalt-temperature-gradient subgrade-anisotropy base-modulus-gradient
damping asphalt-relaxation density base-sublayer interface-slip-in-asphalt""".split()


def extended(text, parameter=""):
    at = STUDY.index("[[parameters]]")
    return STUDY[:at] + text + "\n" + parameter + "\n" + STUDY[at:]


def responses(path, *options):
    done = run("forward", path, "--json", *options)
    assert done.returncode == 0, f"forward {path.name}: {done.stderr}"
    return [r["value"] for r in json.loads(done.stdout)["responses"]]


@pytest.fixture(scope="module")
def catalogue():
    # The catalogue.
    return json.loads(run("effects", "--json").stdout)


def test_the_catalogue_holds_every_effect(catalogue):
    assert sorted(e["name"] for e in catalogue) == sorted(NAMES), "the catalogue holds every name"
    assert all(e["low"] <= e["null"] <= e["high"] and e["mechanism"] and e["source"] and e["unit"] for e in catalogue), "every effect says what it is"
    table = run("effects").stdout
    assert all(name in table for name in NAMES), "the table holds every name"

    

plain = write_study(folder, name="plain")


def test_an_effect_of_no_size_is_none_and_a_sized_one_is_that_of_the_twin(catalogue):
    # A study with an effect of no size is the study without it; with a size it is what the twin makes.
    base = responses(plain)
    for effect in catalogue:
        name = effect["name"]
        if name in ("wheel-wander", "drift", "damping", "asphalt-relaxation", "density"):
            continue  # no wheel, no second load and no history in this study
        null = write_study(folder, extended(f'[[effects]]\nname = "{name}"\nsize = {effect["null"]}'), name="null")
        assert responses(null) == base, f"{name}: no bit changes at its null size"
        sized = write_study(folder, extended(f'[[effects]]\nname = "{name}"\nsize = {effect["typical"]}'), name="sized")
        values = responses(sized)
        # One requested response, not measured: the instruments do not change it.
        if name in ("sensor-gain", "sensor-position", "outlier", "gauge-depth", "gauge-length", "load-offset"):
            assert abs(values[4] / base[4] - 1) < 2e-3, f"{name}: what is not measured changes with the mesh only"
        assert values[:4] != base[:4], f"{name}: the readings change"
        done = run("twin", plain, "--effect", f"{name}={effect['typical']}", "--out", folder / "twin", "--json")
        assert done.returncode == 0, f"twin --effect {name}: {done.stderr}"
        made = [m["exact"] for m in json.loads(done.stdout)["measurements"]]
        assert made == values[:4], f"{name}: the twin is the extended study"
    done = run("twin", plain, "--effect", "weak-subgrade-top=0.7", "--effect", "sensor-gain=1.1", "--out", folder / "twin")
    assert "# effect: weak-subgrade-top = 0.7 [-]" in done.stdout and "# effect: sensor-gain = 1.1 [factor]" in done.stdout, "the twin says what it holds"


def test_a_sublayer_is_as_thick_as_the_study_says():
    weak = '[[effects]]\nname = "weak-subgrade-top"\nsize = 0.7\n'
    assert responses(write_study(folder, extended(weak + "thickness_mm = 200"), name="thick")) == responses(write_study(folder, extended(weak), name="thick")), \
        "200 mm unless stated"
    assert responses(write_study(folder, extended(weak + "thickness_mm = 100"), name="thin")) != responses(write_study(folder, extended(weak), name="thick")), \
        "thickness_mm counts"


def test_the_wall_follows_the_floor_unless_it_is_stated():
    deep = extended('[[effects]]\nname = "floor-depth"\nsize = 3000')
    near = "nearer than twice the depth"
    done = run("forward", write_study(folder, deep, name="deep"))
    assert near in done.stdout + done.stderr, f"a stated wall stays: {done.stdout} {done.stderr}"
    done = run("forward", write_study(folder, deep.replace("extent_m = 3.0\n", ""), name="deep"))
    assert done.returncode == 0 and near not in done.stdout + done.stderr, "the wall follows the effect"


def test_the_size_of_an_effect_is_a_parameter_like_any_other():
    # Its size is a parameter like any other: forward, map, fit and sensitivity take it.
    size = '[[parameters]]\nname = "weak-subgrade-top.size"\nmin = 0\nmax = 2\npoints = 3\n'
    effect = '[[effects]]\nname = "weak-subgrade-top"\nsize = 0.7\n'
    done = run("twin", plain, "--effect", "weak-subgrade-top=0.7", "--out", folder / "truth", "--json")
    rows = json.loads(done.stdout)["measurements"]
    data = DATA.splitlines()[1] + "\n" + "".join(
        f"{m['load']},{m['quantity']},{m['x_mm']},{m['y_mm']},{m['depth_mm']},{m['gauge_mm']},{m['value']},{m['unit']},\n" for m in rows)
    fitted = STUDY[:STUDY.index("[[parameters]]")] + effect.replace("0.7", "0") + size + STUDY[STUDY.index("[[outputs]]"):]
    study = write_study(folder / "fit", fitted, data, name="fit")
    done = run("forward", study, "--jacobian", "--json")
    assert done.returncode == 0 and json.loads(done.stdout)["jacobian"]["parameters"] == ["weak-subgrade-top.size"], "forward --jacobian"
    done = run("fit", study, "--out", folder / "fit-out", "--json")
    assert done.returncode == 0, f"fit: {done.stderr}"
    best = json.loads(done.stdout)["best"]["parameters"]["weak-subgrade-top.size"]
    assert abs(best - 0.7) < 0.01, f"the fit gives the size of the twin back: {best}"
    assert run("map", study, "--out", folder / "map-out").returncode == 0, "map"
    assert run("sensitivity", study, "--samples", "0", "--out", folder / "sensitivity-out").returncode == 0, "sensitivity"
    # Another size is another run: nothing is taken over.
    other = write_study(folder / "fit", fitted.replace("size = 0\n", "size = 1\n"), data, name="fit")
    done = run("map", other, "--out", folder / "map-out")
    assert done.returncode == 0 and evaluations(folder / "map-out") >= 6, "the study's hash covers its effects"


# Wrong input.
def expect(text, words, parameter="", line=None):
    content = extended(text, parameter)
    path = write_study(folder / "wrong", content)
    done = run("forward", path, "--json")
    message = done.stderr.strip()
    print("   ", message)
    assert done.returncode == 2 and len(message.splitlines()) == 1 and done.stdout == "", f"{text}: {done.returncode}"
    for word in words:
        assert word in message, f"'{word}' is missing in: {message}"
    if line:
        number = next(i for i, found in enumerate(content.splitlines(), 1) if line in found)
        assert re.search(rf":{number}:", message), f"line {number} is not named: {message}"


def test_a_wrong_effect_is_one_message():
    expect('[[effects]]\nname = "weak-subgrade-tip"', ["did you mean \"weak-subgrade-top\"", "gauge-depth"], line="weak-subgrade-tip")
    expect('[[effects]]\nname = "base-thickness"\nsize = 500', ["size", "500", "-100 <= value <= 100"], line="size = 500")
    expect('[[effects]]\nname = "wheel-wander"\nsize = 50', ["no reading under a wheel"], line='name = "wheel-wander"')
    expect('[[effects]]\nname = "outlier"\nreading = 9', ["reading", "1 to 4"], line="reading = 9")
    expect('[[effects]]\nname = "base-tension"\nreading = 1', ["reading", "unknown key", "layer, name, size"], line="reading = 1")
    expect('[[effects]]\nname = "base-tension"\nthickness_mm = 100', ["thickness_mm", "unknown key"], line="thickness_mm = 100")
    expect('[[effects]]\nname = "weak-subgrade-top"\nthickness_mm = 0', ["thickness_mm", "0 < value"], line="thickness_mm = 0")
    expect('[[effects]]\nname = "drift"', ["second load"], line="drift")
    expect('[[effects]]\nname = "damping"', ["history"], line="damping")
    expect('[[effects]]\nname = "base-tension"\nlayer = "subgrade"', ["floor of theta"], line="base-tension")
    expect('[[effects]]\nname = "load-magnitude"\nload = "fdw"', ["load", "fwd"], line="fdw")
    expect('[[effects]]\nname = "inertia"\n[[effects]]\nname = "inertia"', ["each once"])
    expect("", ["gauge-depth.size", "base.k1"], parameter='[[parameters]]\nname = "gauge-depth.size"\nmin = 0\nmax = 1', line="gauge-depth.size")


def test_a_wrong_effect_of_a_twin_writes_nothing():
    for wrong, word in (("nonsense=1", "interface-slip"), ("weak-subgrade-top", "NAME=SIZE"), ("weak-subgrade-top=9", "2.5"),
                        ("wheel-wander=50", "wheel")):
        done = run("twin", plain, "--effect", wrong, "--out", folder / "nothing")
        assert done.returncode == 2 and word in done.stderr and not (folder / "nothing").exists(), f"--effect {wrong}: {done.stderr}"


def test_the_range_of_every_effect_is_read_again(catalogue):
    # What a diagnosis writes of every effect, its whole range as it is listed, is read again.
    for effect in catalogue:
        if effect["low"] > 0:
            path = folder / "range.toml"
            path.write_text(extended(f'[[effects]]\nname = "{effect["name"]}"', f'[[parameters]]\nname = "{effect["name"]}.size"\n'
                                     f'min = {effect["low"]}\nmax = {effect["high"]}\nscale = "log"'))
            done = run("check", path)
            assert done.returncode == 0 or "cannot have this effect" in done.stderr, f"the range of {effect['name']}: {done.stderr}"
