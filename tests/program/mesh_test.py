"""Patches that touch, meshes that no machine holds, and horizontal readings at the bottom of thin and thick asphalt on the default mesh in three dimensions, against the layered
engine under the same patches as many small circles (tools/mesh-errors has the whole table).
usage: mesh_test.py PROGRAM"""
import importlib.machinery
import importlib.util
import json
import math
import resource
import time

from support import *

loader = importlib.machinery.SourceFileLoader("mesh_errors", str(ROOT / "tools" / "mesh-errors"))
errors = importlib.util.module_from_spec(importlib.util.spec_from_loader("mesh_errors", loader))
loader.exec_module(errors)
errors.PROGRAM = PROGRAM
folder = workspace()
for asphalt in (15, 30, 80):
    for quantity in ("strain_xx", "stress_yy"):
        readings = [(quantity, asphalt - 1e-4, x) for x in errors.PLACES.values()]
        right, _ = errors.responses(asphalt, errors.many_circles(), readings, folder)
        largest = max(map(abs, right))
        for place in ("centre", "edge"):
            at = list(errors.PLACES).index(place)
            [value], _ = errors.responses(asphalt, errors.dual_wheel(), [readings[at]], folder)
            error = 100 * (value - right[at]) / largest
            check(abs(error) <= errors.ALLOWED[place], f"{quantity} under {asphalt} mm of asphalt, {place}: {error:+.2f} % of the largest")

# Circles that touch to rounding leave no sliver of an element between them: the deflection there is that of a millimetre between them,
# which changes by some 1e-3.
DUAL = (ROOT / "grids" / "dual-linear.toml").read_text().split("[[outputs]]")[0].replace('patch = "rectangle"\npatch_width_mm = 160', 'patch = "circle"')
width = 2 * math.sqrt(20e3 / math.pi / 0.65)
between = {}
for apart in (0, 1e-13, 1e-6, 1e-3, 1):
    study = write_study(folder / "touch", DUAL.replace("spacing_mm = 340", f"spacing_mm = {width + width * apart!r}" if apart < 1 else f"spacing_mm = {width + 1!r}").replace(
        "[mesh]", "[mesh]\nrefine = 0.5") + '\n[[outputs]]\nname = "D"\nload = "dual"\nquantity = "deflection"\nx_mm = 0\n', None)
    done = run("forward", study, "--json")
    check(done.returncode == 0, f"patches {apart:g} of their width apart: {done.stderr}")
    between[apart] = json.loads(done.stdout)["responses"][0]["value"] if done.returncode == 0 else math.nan
check(all(abs(value / between[1] - 1) < 5e-3 for value in between.values()), f"the deflection between patches that touch: {between}")


# What a mesh asks for is said before anything runs, and refused where no machine has it.
def little():
    resource.setrlimit(resource.RLIMIT_AS, (3 * 2**30, 3 * 2**30))


SOLID = (ROOT / "grids" / "dual-nonlinear.toml").read_text()
for command in ("check", "forward"):
    begin = time.monotonic()
    done = run(command, write_study(folder / "huge", SOLID.replace("[mesh]", "[mesh]\nrefine = 16"), None), preexec_fn=None if sanitizer() else little)
    check(done.returncode == 2 and "mesh.refine" in done.stderr and "too many cells" in done.stderr and time.monotonic() - begin < 20,
          f"{command} of what no machine holds: {done.returncode} {done.stderr}")
process = subprocess.Popen([PROGRAM, "check", str(write_study(folder / "large", SOLID.replace("[mesh]", "[mesh]\nrefine = 2"), None))], stdout=subprocess.DEVNULL,
                           stderr=subprocess.PIPE)
said = said_until("GB a thread", process, 30)
process.kill()
process.wait()
check("GB a thread" in said, f"memory and time of a run are said before the first: {said!r}")
finish()
