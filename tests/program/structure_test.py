"""Layers never point upwards, only study/ and the program's commands know the forward model, each file is in the build,
and the README's commands exist."""
import re

from support import *

SRC = ["base", "mechanics", "material", "layered", "mesh", "fe", "pavement", "reduced"]
EXPLORE = ["data", "problem", "study", "search", "optimise", "run", "landscape", "diagnose", "report", "cli"]
# Above the forward model's own base/, these may include src/.
KNOWS_PAVEMENTS = {"study", "report", "cli"}


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
            listed = (ROOT / folder / "CMakeLists.txt").read_text()
            check(str(path.relative_to(ROOT / folder)) in listed, f"{path} is not built")

readme = (ROOT / "README.md").read_text()
commands = re.findall(r"^ +pavescape (\w+) ?(\S*)", readme, re.M)
check(len(commands) >= 6, "the README shows the commands")
for name, study in commands:
    check(run(name, "--help").returncode == 0, f"README: pavescape {name} is not a command")
    if study.startswith("grids/"):
        check((ROOT / study).exists(), f"README: {study} is not there")
for script in re.findall(r"`(tools/[\w-]+)`", readme):
    check((ROOT / script).exists(), f"README: {script} is not there")
finish()
