"""Horizontal readings at the bottom of thin and thick asphalt on the default mesh in three dimensions, against the layered
engine under the same patches as many small circles (tools/mesh-errors has the whole table).
usage: mesh_test.py PROGRAM"""
import importlib.machinery
import importlib.util

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
finish()
