"""Patches that touch, meshes that no machine holds, what a mesh does to an answer, and horizontal readings at the bottom of thin and thick asphalt on the default mesh in three dimensions, against the layered
engine under the same patches as many small circles (tools/accuracy/mesh-errors has the whole table)."""
import functools
import importlib.machinery
import importlib.util
import json
import math
import re
import resource
import time

from support import *

loader = importlib.machinery.SourceFileLoader("mesh_errors", str(ROOT / "tools" / "accuracy" / "mesh-errors"))
errors = importlib.util.module_from_spec(importlib.util.spec_from_loader("mesh_errors", loader))
loader.exec_module(errors)
errors.PROGRAM = PROGRAM
folder = workspace()


def test_horizontal_readings_at_the_bottom_of_asphalt():
    for asphalt in (15, 80):
        for quantity in ("strain_xx", "stress_yy"):
            readings = [(quantity, asphalt - 1e-4, x) for x in errors.PLACES.values()]
            right, _ = errors.responses(asphalt, errors.many_circles(), readings, folder)
            largest = max(map(abs, right))
            for place in ("centre", "edge"):
                at = list(errors.PLACES).index(place)
                [value], _ = errors.responses(asphalt, errors.dual_wheel(), [readings[at]], folder)
                error = 100 * (value - right[at]) / largest
                assert abs(error) <= errors.ALLOWED[place], f"{quantity} under {asphalt} mm of asphalt, {place}: {error:+.2f} % of the largest"


def test_patches_that_touch_leave_no_sliver():
    # Circles that touch to rounding leave no sliver of an element between them: the deflection there is that of a millimetre between them,
    # which changes by some 1e-3.
    DUAL = (ROOT / "grids" / "dual-linear.toml").read_text().split("[[outputs]]")[0].replace('patch = "rectangle"\npatch_width_mm = 160', 'patch = "circle"')
    width = 2 * math.sqrt(20e3 / math.pi / 0.65)
    between = {}
    for apart in (0, 1e-13, 1e-6, 1e-3, 1):
        study = write_study(folder / "touch", DUAL.replace("spacing_mm = 340", f"spacing_mm = {width + width * apart!r}" if apart < 1 else f"spacing_mm = {width + 1!r}").replace(
            "[mesh]", "[mesh]\nrefine = 0.5") + '\n[[outputs]]\nname = "D"\nload = "dual"\nquantity = "deflection"\nx_mm = 0\n', None)
        done = run("forward", study, "--json")
        assert done.returncode == 0, f"patches {apart:g} of their width apart: {done.stderr}"
        between[apart] = json.loads(done.stdout)["responses"][0]["value"]
    assert all(abs(value / between[1] - 1) < 5e-3 for value in between.values()), f"the deflection between patches that touch: {between}"


# What the mesh does to an answer. A bowl of a mesh six times as fine, to 0.1 %, fitted on a coarse one: what the fit says of the next finer mesh, to first
# order from one run, is what a fit on that mesh finds.
BOWL = """schema = 1
[[layers]]
name = "asphalt"
density_kg_m3 = 2100
k0 = 0.5
thickness_mm = 80
law = "linear"
modulus_MPa = 4000
poisson = 0.35
[[layers]]
name = "base"
density_kg_m3 = 2100
k0 = 0.5
thickness_mm = 300
law = "uzan"
k1 = 1500
k2 = 0.5
k3 = -0.2
n = 0.6
poisson_12 = 0.35
poisson_31 = 0.35
[[layers]]
name = "subgrade"
density_kg_m3 = 2100
k0 = 0.5
thickness_mm = 2000
law = "linear"
modulus_MPa = 70
poisson = 0.4
[[loads]]
name = "fwd"
type = "plate"
radius_mm = 150
pressure_kPa = 700
[mesh]
refine = {refine}
"""
FITTED = """[data]
files = ["small.csv"]
misfit = "weighted"
[[parameters]]
name = "asphalt.modulus_MPa"
min = 1000
max = 12000
scale = "log"
[[parameters]]
name = "base.k1"
min = 300
max = 6000
scale = "log"
[[parameters]]
name = "subgrade.modulus_MPa"
min = 20
max = 200
scale = "log"
"""
PLACES_MM = (0, 150, 200, 300, 450, 600, 750, 900, 1200)
OUTPUTS = "".join(f'[[outputs]]\nname = "D{x}"\nload = "fwd"\nquantity = "deflection"\nx_mm = {x}\n' for x in PLACES_MM)


@functools.cache
def fine():
    """The bowl, of a mesh six times as fine."""
    return json.loads(run("forward", write_study(folder / "fine", BOWL.format(refine=2.4) + OUTPUTS, None), "--json").stdout)["responses"]


def fitted(name, refine, share):
    data = "load,quantity,x_mm,y_mm,depth_mm,gauge_mm,value,unit,sigma\n" + "".join(
        f"fwd,deflection,{x},0,0,0,{r['value']},{r['unit']},{share * r['value']}\n" for x, r in zip(PLACES_MM, fine()))
    return json.loads(run("fit", write_study(folder / name, BOWL.format(refine=refine) + FITTED, data), "--json", "--explore", "32", "--starts", "3").stdout)


def test_what_the_mesh_does_to_an_answer():
    coarse, next_one, rough = fitted("coarse", 0.4, 0.001), fitted("next", 0.6, 0.001), fitted("rough", 0.4, 0.1)
    mesh = coarse["mesh"]
    said = [f for f in coarse["findings"] if "The mesh is coarse" in f]
    assert mesh["shows"] and len(said) == 1 and "refine = 0.6" in said[0], f"a mesh that shows beside 0.1 %: {said} {mesh}"
    assert abs(mesh["finer_refine"] - 0.6) < 1e-9 and abs(mesh["chi2"] / coarse["noise"]["chi2"] - 1) < 1e-6, f"of the mesh: {mesh}"
    assert abs(mesh["chi2_finer"] - next_one["noise"]["chi2"]) < 0.1 * abs(mesh["chi2"] - next_one["noise"]["chi2"]), \
        f"chi2 {mesh['chi2']}, on the finer mesh {mesh['chi2_finer']} to first order and {next_one['noise']['chi2']} when fitted"
    for parameter, moved in ((m["parameter"], m["standard_errors"]) for m in mesh["moved"]):
        before, after, error = coarse["best"]["parameters"][parameter], next_one["best"]["parameters"][parameter], coarse["best"]["standard_errors"][parameter]
        found = math.log(after / before) * before / error
        assert abs(moved - found) < 0.1 + 0.15 * abs(found), f"{parameter}: {moved:.2f} standard errors to first order, {found:.2f} when fitted"
    assert not rough["mesh"]["shows"] and not any("The mesh is coarse" in f for f in rough["findings"]), f"beside 10 % no mesh shows: {rough['mesh']}"


# What a mesh asks for is said before anything runs, and refused where no machine has it.
def little():
    resource.setrlimit(resource.RLIMIT_AS, (3 * 2**30, 3 * 2**30))


SOLID = (ROOT / "grids" / "dual-nonlinear.toml").read_text()


def test_a_mesh_that_no_machine_holds_is_refused():
    for command in ("check", "forward"):
        begin = time.monotonic()
        done = run(command, write_study(folder / "huge", SOLID.replace("[mesh]", "[mesh]\nrefine = 16"), None), preexec_fn=None if sanitizer() else little)
        assert done.returncode == 2 and "mesh.refine" in done.stderr and "too many cells" in done.stderr and time.monotonic() - begin < 20, \
            f"{command} of what no machine holds: {done.returncode} {done.stderr}"


def test_memory_of_a_run_is_said_before_the_first():
    process = subprocess.Popen([PROGRAM, "check", str(write_study(folder / "large", SOLID.replace("[mesh]", "[mesh]\nrefine = 2"), None))], stdout=subprocess.DEVNULL,
                               stderr=subprocess.PIPE)
    said = said_until("B a thread", process, 30)
    process.kill()
    process.wait()
    assert re.search(r"asks for some [\d.]+ [MG]B a thread", said), f"memory and time of a run are said before the first: {said!r}"
