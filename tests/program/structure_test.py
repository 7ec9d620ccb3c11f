"""Layers never point upwards, only study/ and what stands above the analyses know the forward model, each file is in the build, the map of
CONTRIBUTING is true, sizes stay within bounds, and the commands and tools that README, CONTRIBUTING and docs/commands.md show exist."""
import re

from support import *

SRC = ["base", "mechanics", "material", "layered", "mesh", "fe", "pavement", "reduced"]
EXPLORE = ["data", "problem", "study", "search", "optimise", "run", "landscape", "diagnose", "analysis", "report", "cli"]
# Above the forward model's own base/, these may include src/.
KNOWS_PAVEMENTS = {"study", "analysis", "report", "cli"}


def includes(path):
    return re.findall(r'^#include "([^"]+)"', path.read_text(), re.M)


def layer(include):
    return include.split("/")[0]


for folder, layers in (("src", SRC), ("explore", EXPLORE)):
    for path in sorted((ROOT / folder).rglob("*")):
        if path.suffix not in (".h", ".cpp"):
            continue
        own = path.relative_to(ROOT / folder).parts[0]
        check(own in layers, f"{path}: in no layer")
        for include in includes(path):
            other = layer(include)
            if other in layers:
                check(layers.index(other) <= layers.index(own), f"{path.relative_to(ROOT)} points upwards to {include}")
            elif folder == "explore" and other in SRC:
                check(other == "base" or own in KNOWS_PAVEMENTS, f"{path.relative_to(ROOT)} knows the forward model: {include}")
            else:
                check(False, f"{path.relative_to(ROOT)}: {include} is in no layer it may see")
        if path.suffix == ".cpp":
            relative = path.relative_to(ROOT / folder)
            listed = (ROOT / folder / "CMakeLists.txt").read_text()
            check(str(relative) in listed or f"{own}/*.cpp" in listed or re.search(rf"set\(layers [^)]*\b{own}\b", listed), f"{path} is not built")

# The map of CONTRIBUTING names every folder of src/ and explore/ once, and no other.
contributing = (ROOT / "CONTRIBUTING.md").read_text()
named = re.findall(r"^    (\S+/\S+) ", contributing.split("<!-- map -->")[1].split("<!-- end -->")[0], re.M)
folders = [f"{top}/{folder.name}" for top in ("src", "explore") for folder in (ROOT / top).iterdir() if folder.is_dir()]
check(sorted(named) == sorted(folders), f"CONTRIBUTING's map against the folders: {sorted(set(named) ^ set(folders)) or 'named twice'}")
for layers, top in ((SRC, "src"), (EXPLORE, "explore")):
    check([name for name in named if name.startswith(top + "/")] == [f"{top}/{layer}" for layer in layers], f"CONTRIBUTING's map lists {top}/ lowest first")

MOST_LINES = 500
# Longer files, each with the reason why it is one file.
LONGER = {
    "explore/diagnose/diagnosis.cpp": "one class: the steps of the diagnosis share the models that it has fitted",
    "explore/landscape/uniqueness.cpp": "one class: the steps of the analysis share its minima, walks and chain numbers",
    "explore/landscape/posterior.cpp": "one sampler: its populations, kernels and schedule share the particles",
    "explore/report/web/report.js": "one page: its sections share the building blocks at the top, and one script is what a page embeds",
    "explore/run/cluster.cpp": "both ends of one protocol stand side by side",
    "src/pavement/load_model.cpp": "one template: the finite element model of a load, at rest, over time and with its derivatives",
    "src/fe/solver_work.h": "what the integrations share for both kinds of element, in one template",
}


def lines_of(path):
    return len(path.read_text().splitlines())


for top in ("src", "explore", "python", "tools"):
    for path in (ROOT / top).rglob("*"):
        if path.suffix in (".h", ".cpp", ".js"):
            name = str(path.relative_to(ROOT))
            check(lines_of(path) <= MOST_LINES or name in LONGER, f"{name} has {lines_of(path)} lines, more than {MOST_LINES}")
for name in LONGER:
    check((ROOT / name).exists() and lines_of(ROOT / name) > MOST_LINES, f"{name} is no longer a file of more than {MOST_LINES} lines: take it off the list")
cli = sum(lines_of(path) for path in (ROOT / "explore" / "cli").iterdir())
check(cli < 2000, f"explore/cli has {cli} lines: what computes belongs into explore/analysis, what renders into explore/report")
check(lines_of(ROOT / "README.md") <= 100, f"README has {lines_of(ROOT / 'README.md')} lines, more than 100")

for page, least in (("README.md", 1), ("docs/commands.md", 15), ("CONTRIBUTING.md", 0)):
    text = (ROOT / page).read_text()
    commands = re.findall(r"^ +(?:\$ )?pavescape (\w+) ?(\S*)", text, re.M)
    check(len(commands) >= least, f"{page} shows the commands")
    for name, study in commands:
        check(run(name, "--help").returncode == 0, f"{page}: pavescape {name} is not a command")
        if study.startswith("grids/"):
            check((ROOT / study).exists(), f"{page}: {study} is not there")
    for script in re.findall(r"`(tools/[\w./-]+)", text):
        check((ROOT / script).exists(), f"{page}: {script} is not there")
# Every command and every tool is described, and no page points to one that is not there.
shown = (ROOT / "docs" / "commands.md").read_text()
for name in re.findall(r'^        \{"(\w+)", add_', (ROOT / "explore" / "cli" / "commands.cpp").read_text(), re.M):
    check(f"    pavescape {name}" in shown, f"docs/commands.md does not show {name}")
for path in (ROOT / "tools").iterdir():
    if path.is_file() and "." not in path.name:
        check(f"tools/{path.name}" in contributing, f"CONTRIBUTING does not name tools/{path.name}")
for page in [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *(ROOT / "docs").glob("*.md")]:
    for target in re.findall(r"\]\(([\w./-]+\.(?:md|svg))[)#]", page.read_text()):
        check((page.parent / target).exists(), f"{page.name}: {target} is not there")
    for target in re.findall(r"`(docs/[\w-]+\.md)`", page.read_text()):
        check((ROOT / target).exists(), f"{page.name}: {target} is not there")
finish()
