"""Slips in a study and at the prompt: the message lists what is allowed and names what was meant; a command that is proposed can be pasted."""
import re
import shlex

import pytest
from support import LAYERED, LAYERED_BOWL, ROOT, STUDY, run, workspace, write_study

WHOLE = STUDY.replace("[mesh]", '[section]\nbottom = "rigid"\n\n[solver]\nintegration = "incremental"\n\n[mesh]').replace(
    'misfit = "log"', 'misfit = "weighted"\n\n[data.noise]\nrelative = 0.05').replace(
    "points = 4", "points = 4\nprior = { mean = 2000, sd = 0.5 }") + """
[[effects]]
name = "sensor-gain"
size = 1.0

[[constraints]]
that = "base.k1 <= 8000"
"""
# Where another line can be put into each table, and what is not for this entry of it.
TABLES = {
    "[section]": ('bottom = "rigid"', ()),
    "[solver]": ('integration = "incremental"', ()),
    "[mesh]": ("refine = 0.4", ()),
    "[data]": ('misfit = "weighted"', ()),
    "[data.noise]": ("relative = 0.05", ()),
    "[[loads]]": ("pressure_kPa = 600", ("patch", "wheels")),
    "[[outputs]]": ('name = "subgrade-top-strain"', ("unit",)),  # of a model of your own
    "[[parameters]]": ('name = "base.n"', ("value",)),  # of a model of your own
    "[[effects]]": ("size = 1.0", ("layer", "thickness_mm", "parameter", "null", "typical", "range")),  # the last four: of a model of your own
    "[[constraints]]": ('that = "base.k1 <= 8000"', ()),
}


def documented():
    """The keys of every table by the page."""
    keys, table = {}, None
    for line in (ROOT / "docs/reference/keys.md").read_text().split("\n## Layers")[0].splitlines():
        if line.startswith("### "):
            table = line[4:].strip("`")
        elif match := re.match(r"\| `(\w+)` \|", line):
            keys.setdefault(table, []).append(match[1])
    return keys


def refused_with(line, after):
    assert WHOLE.count(after) == 1, after
    study = write_study(workspace(), WHOLE.replace(after, f"{after}\n{line}"))
    done = run("forward", study)
    assert done.returncode == 2, (line, done.stderr)
    return done.stderr


def test_the_study_of_these_tests_is_sound():
    assert run("forward", write_study(workspace(), WHOLE)).returncode == 0


@pytest.mark.parametrize("table", TABLES)
def test_an_unknown_key_is_refused_with_every_key_of_its_table(table):
    after, others = TABLES[table]
    said = refused_with("something_else = 1", after)
    assert "unknown key" in said and "did you mean" not in said, said
    allowed = re.split(r"[\s,:;]+", said.split("allowed")[1])
    for key in documented()[table]:
        assert (key in allowed) == (key not in others), (key, said)


@pytest.mark.parametrize("table, slip, meant", [
    ("[data]", "noise_rel = 0.05", "noise_relative"), ("[data]", "noise_flor = 0.05", "noise_floor"), ("[data]", "held-out = []", "held_out"),
    ("[data]", "weight = 1", "weights"), ("[data.noise]", "common = 0.01", "common_relative"), ("[data.noise]", "correlation = 300", "correlation_mm"),
    ("[solver]", "time_limit = 3", "time_limit_s"), ("[mesh]", "extent = 3", "extent_m"), ("[[outputs]]", "time = 3", "time_ms"),
    ("[[parameters]]", "equal = 3", "equals"), ("[data]", "[[constraint]]", "constraints"), ("[data]", "[[output]]", "outputs"), ("[[parameters]]", "priors = 3", "prior"), ("[[effects]]", "readings = 1", "reading"),
])
def test_a_slip_in_a_key_is_answered_with_the_key_that_was_meant(table, slip, meant):
    assert f'did you mean "{meant}' in refused_with(slip, TABLES[table][0])


def test_a_tie_by_log_asks_which_one_is_meant():
    tie = '\n[[parameters]]\nname = "asphalt.modulus_MPa"\nequals = "{}(base.modulus_MPa)"\n'
    folder = workspace()
    done = run("forward", write_study(folder, LAYERED + tie.format("1000*log"), LAYERED_BOWL))
    assert done.returncode == 2 and "ln or log10" in done.stderr, done.stderr
    done = run("forward", write_study(folder, LAYERED + tie.format("1000*sin"), LAYERED_BOWL))
    assert done.returncode == 2 and '"sin" is no known name' in done.stderr and "exp, ln, log10, sqrt, abs, min, max" in done.stderr, done.stderr
    assert run("forward", write_study(folder, LAYERED + tie.format("1000*ln"), LAYERED_BOWL)).returncode == 0


@pytest.mark.parametrize("command, options", [("fit", ("--explore", 8, "--starts", 1, "--verbose")), ("map", ("--design", "sobol", "--points", 4)),
                                              ("unique", ("--explore", 8, "--verify", 1, "--verbose")), ("sensitivity", ("--samples", 2, "--verbose"))])
def test_a_command_that_is_proposed_can_be_pasted(command, options):
    folder = workspace()
    study = write_study(folder, LAYERED, LAYERED_BOWL)
    out = folder / "out put's"
    done = run(command, study, *options, "--out", out)
    assert done.returncode == 0, done.stderr
    proposed = re.search(r"pavescape (export .*?)(?: \(|$)", done.stdout, re.MULTILINE)
    words = shlex.split(proposed[1])
    assert str(out) in words, proposed[1]
    assert run(*words).returncode == 0, words


def test_a_slip_in_a_key_that_must_be_there_says_which_key_and_which_values():
    study = write_study(workspace(), WHOLE.replace("thickness_mm", "thicknes_mm", 1))
    done = run("forward", study)
    assert done.returncode == 2 and 'did you mean "thickness_mm"?' in done.stderr and "allowed: thickness_mm = 0 < value" in done.stderr, done.stderr
