"""What other programs use: the installed library from ten lines of C++, the Python module, the Debian package, manual pages, completion."""
import json
import os
import re
import shutil

import pytest

from support import *

folder = workspace()
study = ROOT / "grids" / "captif-p1-fwd.toml"
noisy = write_study(folder, STUDY.replace('misfit = "log"', 'misfit = "log"\nnoise_relative = 0.05'))


@pytest.fixture(scope="module")
def forward():
    return [r["value"] for r in json.loads(run("forward", study, "--json").stdout)["responses"]]


def command(*arguments, **options):
    done = subprocess.run([str(a) for a in arguments], capture_output=True, text=True, timeout=3600, **options)
    assert done.returncode == 0, f"{arguments[0]} {arguments[1]}: {done.stdout[-1500:]}{done.stderr[-1500:]}"
    return done.stdout


@pytest.fixture(scope="module")
def prefix():
    # Installed, and called from another project.
    prefix = folder / "usr"
    command("cmake", "--install", BUILD, "--prefix", prefix)
    return prefix


def example(prefix, name):
    """An example as another project builds it, with the installed library; the program."""
    # As the program was compiled.
    compiled = dict(re.findall(r"^(CMAKE_CXX_COMPILER|CMAKE_CXX_FLAGS):\w+=(.*)$", (BUILD / "CMakeCache.txt").read_text(), re.M))
    built = folder / name
    command("cmake", "-S", ROOT / "examples" / name, "-B", built, f"-DCMAKE_PREFIX_PATH={prefix}", "-DCMAKE_BUILD_TYPE=Release", "-GNinja",
            *(f"-D{key}={value}" for key, value in compiled.items()))
    command("cmake", "--build", built)
    return built / f"{name}_example"


def lines_of(name):
    text = (ROOT / "examples" / name / "main.cpp").read_text()
    return [line for line in text.splitlines() if line.strip() not in ("", "{", "}") and not line.startswith(("//", "#"))]


def test_ten_lines_of_cpp_call_the_library(forward, prefix):
    values = [float(line) for line in command(example(prefix, "forward"), study).split()]
    assert values == forward, f"ten lines of C++ give the bits of the program: {values} {forward}"
    assert len(lines_of("forward")) <= 10, "in ten lines"


def test_forty_lines_of_cpp_fit_a_function_of_ones_own(prefix):
    # Decays at 0.2 and 0.8, whose exchange fits as well: both are found.
    minima = [[float(word) for word in line.split() if word != "misfit"] for line in command(example(prefix, "function")).splitlines()]
    assert sorted((round(a, 4), round(b, 4)) for a, b, misfit in minima if misfit < 1e-3) == [(0.2, 0.8), (0.8, 0.2)], minima
    assert len(lines_of("function")) <= 40, "in forty lines"


def test_the_installed_program_runs(prefix):
    assert command(prefix / "bin" / "pavescape", "--version") == run("--version").stdout, "the installed program runs"


def test_manual_pages(prefix):
    pages = prefix / "share" / "man" / "man1"
    for page, word in (("pavescape.1", "diagnose"), ("pavescape-fit.1", "--starts"), ("pavescape-forward.1", "--vtu")):
        text = (pages / page).read_text().replace("\\-", "-") if (pages / page).exists() else ""
        assert word in text and text.lstrip().startswith((".TH", ".\\\"")), f"{page} tells of {word}"
        name = page.removesuffix(".1")
        assert f'.TH {name.upper()} "1"' in text and f"\n{name} - " in text and '"Pavescape ' in text, f"{page} has its title"


COMPLETED = [("dia", "diagnose"), ("fit --sta", "--start", "--starts"), ("fit --model a", "auto"), ("plot run --format p", "pdf", "png"), ("plot run res", "residuals"),
             ("plot run back", "back-calculation"), ("fit --starts 3",), ("slab f --foundation li", "liquid"), ("noise CMakeLists.t", "CMakeLists.txt"),
             ("slab CMakeLists.t", "CMakeLists.txt"), ("forward s --points CMakeLists.t", "CMakeLists.txt"), ("survey f --study CMakeLists.t", "CMakeLists.txt"),
             ("fit --quiet grids/captif-p1-fwd.t", "grids/captif-p1-fwd.toml"), ("report doc", "docs")]


SCRIPTS = ROOT / "cmake" / "completion"  # they need no installation


def offered_by_bash(words):
    ask = 'source {0}; COMP_WORDS=({1} {2}); COMP_CWORD={3}; _pavescape; printf "%s\\n" "${{COMPREPLY[@]}}"'
    return command("bash", "-c", ask.format(SCRIPTS / "pavescape.bash", PROGRAM, words, len(words.split())), cwd=ROOT).split()


def offered_by_fish(words):
    ask = f"source {SCRIPTS}/pavescape.fish; complete -C 'pavescape {words}'"
    environment = {**os.environ, "PATH": f"{pathlib.Path(PROGRAM).parent}:{os.environ['PATH']}", "HOME": str(folder)}
    lines = command("fish", "--private", "-c", ask, cwd=ROOT, env=environment).splitlines()
    return [line.split("\t")[0].rstrip("/") for line in lines if words.startswith("plot") or line.split("\t")[0].startswith(words.split()[-1])]


def offered_by_zsh(words):
    """What it hands to zsh: words to describe, or the pattern of files."""
    ask = f"""_files() {{ print files $* }}; _describe() {{ local list=$@[-1]; print -l -- ${{${{(P)list}}%%:*}} }}
complete() {{ local -a words=({PROGRAM} {words}); local CURRENT=$#words; source {SCRIPTS}/_pavescape }}; complete; true"""
    return command("zsh", "-f", "-c", ask, cwd=ROOT).splitlines()


@pytest.mark.parametrize("words, wanted", [(words, wanted) for words, *wanted in COMPLETED])
def test_completion_in_bash(words, wanted):
    assert sorted(offered_by_bash(words)) == wanted


@pytest.mark.skipif(not shutil.which("fish"), reason="fish is not installed")
@pytest.mark.parametrize("words, wanted", [(words, wanted) for words, *wanted in COMPLETED])
def test_completion_in_fish(words, wanted):
    assert sorted(offered_by_fish(words)) == wanted


@pytest.mark.skipif(not shutil.which("zsh"), reason="zsh is not installed")
@pytest.mark.parametrize("words, wanted", [(words, wanted) for words, *wanted in COMPLETED if wanted and "." not in words and words != "report doc"] +
                         [("fit --quiet grids/c", ["files -g *.toml"]), ("noise CMa", ["files"]), ("report doc", ["files -/"]), ("fit --starts 3", [])])
def test_completion_in_zsh(words, wanted):
    assert sorted(offered_by_zsh(words)) == wanted


def test_the_debian_package():
    command("cpack", "--config", BUILD / "CPackConfig.cmake", "-B", folder / "package", cwd=BUILD)
    packages = list((folder / "package").glob("*.deb"))
    assert len(packages) == 1, f"one package: {packages}"
    contents = command("dpkg-deb", "--contents", packages[0])
    for path in ("./usr/bin/pavescape\n", "./usr/share/man/man1/pavescape.1", "completions/pavescape\n", "zsh/vendor-completions/_pavescape\n", "fish/vendor_completions.d/pavescape.fish\n", "dist-packages/pavescape",
                 "doc/pavescape/docs/reference/commands.md", "share/pavescape/grids/captif-p1-fwd.toml"):
        assert path in contents, f"the package holds {path.strip()}"
    assert "libtbb" in command("dpkg-deb", "--field", packages[0], "Depends"), "the package names what it needs"


# Python.
ROAD = ROOT / "grids" / "road-example.csv"
script = """
import json, sys
import numpy as np, pavescape
study = pavescape.Study(sys.argv[1])
own = study.forward()
there = study.start * 1.02
responses, jacobian = study.jacobian(there)
h = 1e-4
numeric = np.stack([(study.forward(there + h * e * there) - study.forward(there - h * e * there)) / (2 * h * there @ e)
                    for e in np.eye(len(there))], axis=1)
residuals = study.residuals(there)
numeric_residuals = np.stack([(study.residuals(there + h * e * there) - study.residuals(there - h * e * there)) / (2 * h * there @ e)
                              for e in np.eye(len(there))], axis=1)
def error(kind, call):
    try:
        call()
    except kind as e:
        return str(e)
fit = study.fit(starts=3, explore=48)
best = np.array([fit["best"]["parameters"][name] for name in study.parameters])
folder = sys.argv[2]
noisy = pavescape.Study(sys.argv[3])
answers = {"fit": noisy.fit(starts=3, explore=48, out=folder + "/fit"), "unique": noisy.unique(explore=24, verify=4, out=folder + "/unique"),
           "diagnose": noisy.diagnose(explore=16, starts=2, bootstrap=4, out=folder + "/diagnose")}
mapped, points, misfits = noisy.map(design="sobol", points=20, out=folder + "/map")
answers["map"] = mapped
sampled, draws, outputs, weights = noisy.sample(samples=400, out=folder + "/sample")
answers["sample"] = sampled
answers["compare"] = noisy.compare(laws=["uzan", "k-theta"], explore=8, verify=2, out=folder + "/compare")
answers["sensitivity"] = noisy.sensitivity(samples=4, out=folder + "/sensitivity")
answers["survey"] = pavescape.survey([sys.argv[5]], out=folder + "/survey")
mean = float((weights @ draws[:, 0]) / weights.sum())
with open(sys.argv[3]) as text, open(sys.argv[4]) as readings:
    memory = pavescape.Study.from_text(text.read(), {"small.csv": readings.read()})
print(json.dumps({"forward": own.tolist(), "parameters": study.parameters, "measured": study.measured.tolist(), "again": (study.forward(there) == responses).all().item(),
                  "jacobian": float(np.abs((jacobian - numeric) * there).max() / np.abs(jacobian * there).max()),
                  "residual_jacobian": float(np.abs((study.residual_jacobian(there) - numeric_residuals) * there).max() / np.abs(numeric_residuals * there).max()),
                  "fit": fit["best"]["misfit"], "fitted": float(np.linalg.norm(study.residuals(best))), "answers": answers,
                  "lowest": float(np.nanmin(misfits)), "shape": list(points.shape), "draws": [list(draws.shape), list(outputs.shape), list(weights.shape)], "mean": mean, "in_memory": (memory.forward() == noisy.forward()).all().item(),
                  "unknown": error(ValueError, lambda: noisy.unique(model="other")), "minima": len(fit["minima"]),
                  "length": error(ValueError, lambda: study.forward(there[:-1])), "range": error(pavescape.NoAnswer, lambda: study.forward(-there)),
                  "file": error(ValueError, lambda: pavescape.Study("nothing.toml")), "units": [r["unit"] for r in study.responses]}))
"""


environment = {**leaks_of_others(), "PYTHONPATH": str(BUILD / "python")}
if sanitizer() == "address":  # before everything else, with what throws
    environment["LD_PRELOAD"] = " ".join(command("g++", f"-print-file-name={library}").strip() for library in ("libasan.so", "libstdc++.so"))
python = pytest.mark.skipif(sanitizer() == "thread", reason="Python's interpreter is not made for the thread sanitizer")


@pytest.fixture(scope="module")
def found():
    """What the script answers."""
    return json.loads(command("/usr/bin/python3", "-c", script, study, folder / "python", noisy, folder / "small.csv", ROAD, env=environment))


@python
def test_python_gives_the_bits_of_the_program(found, forward):
    assert found["forward"] == forward, "Python gives the bits of the program"
    assert found["again"], "with and without derivatives the responses are the same"
    assert found["jacobian"] < 1e-5 and found["residual_jacobian"] < 1e-5, f"derivatives against differences: {found['jacobian']} {found['residual_jacobian']}"
    assert found["length"] and "parameters" in found["length"] and found["range"] and "invalid" in found["range"] and found["file"], "errors are Python's"


@python
def test_commands_in_python_are_the_programs_to_the_last_bit(found):
    same = json.loads(run("fit", study, "--starts", 3, "--explore", 48, "--out", folder / "fit", "--json").stdout)
    assert abs(found["fit"] - same["best"]["misfit"]) < 1e-12 and found["minima"] == len(same["minima"]), "fit is the command fit"
    for name, options in (("fit", ("--starts", 3, "--explore", 48)), ("unique", ("--explore", 24, "--verify", 4)),
                          ("diagnose", ("--explore", 16, "--starts", 2, "--bootstrap", 4)), ("map", ("--design", "sobol", "--points", 20)),
                          ("sample", ("--samples", 400)), ("compare", ("--laws", "uzan,k-theta", "--explore", 8, "--verify", 2)),
                          ("sensitivity", ("--samples", 4)), ("survey", ())):
        printed = run(name, ROAD if name == "survey" else noisy, *options, "--out", folder / "program" / name, "--json").stdout.replace(str(folder / "program"), str(folder / "python"))
        assert lasting(json.loads(printed)) == lasting(found["answers"][name]), f"{name} in Python is the program's to the last bit"
        assert (folder / "python" / name / f"{name}.json").exists(), f"{name} in Python keeps its result"


@python
def test_points_and_draws_are_arrays(found):
    assert found["lowest"] == found["answers"]["map"]["lowest"][0]["misfit"] and found["shape"] == [20, 2], f"the points of a map as arrays: {found['shape']}"
    assert found["draws"][0] == [400, 2] and found["draws"][1] == [400, 1] and found["draws"][2] == [400], f"the draws as arrays: {found['draws']}"
    told = found["answers"]["sample"]["parameters"][0]["mean"]
    assert told is None or abs(found["mean"] / told - 1) < 1e-9, f"their mean is the one in the JSON: {found['mean']} {told}"
    assert found["in_memory"], "a study in memory is the one in the file"
    assert found["unknown"] and "full" in found["unknown"], "an unknown model is a message with what is allowed"
    assert abs(found["fitted"] - found["fit"]) < 1e-9 * found["fit"], "the norm of the residuals is the misfit"


@python
def test_scipy_with_exact_derivatives_finds_as_good_a_fit(found):
    inverted = command("/usr/bin/python3", ROOT / "examples" / "invert.py", study, env=environment)
    misfit = float(inverted.split("misfit ")[1].split()[0])
    assert misfit < 1.001 * found["fit"] + 0.02, f"scipy with exact derivatives finds as good a fit: {misfit} {found['fit']}"
