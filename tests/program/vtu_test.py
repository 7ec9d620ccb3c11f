"""`forward --vtu`, read back by meshio: the fields agree with the responses, the statics and the study."""
import json

import meshio
import numpy as np

import pytest

from support import *

folder = workspace()


def field_of(study, file):
    done = run("forward", study, "--json", "--vtu", file)
    assert done.returncode == 0, f"forward --vtu: {done.stderr}"
    found = json.loads(done.stdout)
    return found["responses"], [meshio.read(f) for f in found["vtu"]]


def nodal(mesh, name, at):
    """Values of a point array at the nodes that lie at a place."""
    near = np.linalg.norm(mesh.points - np.array(at), axis=1) < 1e-9
    return mesh.point_data[name][near]


@pytest.fixture(scope="module")
def fields():
    # Axisymmetric: a plate of 150 mm at 595 kPa on asphalt, a cross-anisotropic base (n = 0.4) and a linear subgrade.
    responses, (plate,) = field_of(ROOT / "grids" / "captif-p1-fwd.toml", folder / "plate.vtu")
    return responses, plate


def test_cells_and_deflections_of_the_plane(fields):
    responses, plate = fields
    assert [c.type for c in plate.cells] == ["quad8"], f"quadratic quadrilaterals: {plate.cells}"
    compared = 0
    for r in responses:
        values = nodal(plate, "deflection_mm", (r["x_mm"] / 1000, 0.0, 0.0))
        if r["quantity"] == "deflection" and len(values) > 0:
            compared += 1
            assert np.allclose(values, r["value"], rtol=1e-9), f"deflection at {r['x_mm']} mm: {values} {r['value']}"
            assert np.allclose(-1000 * nodal(plate, "displacement_m", (r["x_mm"] / 1000, 0.0, 0.0))[:, 2], r["value"], rtol=1e-9), "downwards is -z"
    assert compared >= 1, "deflections were compared"


@pytest.fixture(scope="module")
def of_points(fields):
    _, plate = fields
    layer = plate.cell_data["layer"][0]
    assert set(layer) == {1, 2, 3}, f"three layers: {set(layer)}"
    of_points = np.empty(len(plate.points), int)
    for cell, number in zip(plate.cells[0].data, layer):
        of_points[cell] = number
    return of_points


def test_layers_have_their_anisotropy_and_modulus(fields, of_points):
    _, plate = fields
    for number, n in ((1, 1.0), (2, 0.4), (3, 1.0)):
        assert np.allclose(plate.point_data["n"][of_points == number], n, rtol=1e-9), f"n of layer {number}"
    assert np.allclose(plate.point_data["vertical_modulus_MPa"][of_points == 3], 40.0, rtol=1e-9), "the modulus of the subgrade is the study's"


def test_statics_of_the_plane(fields):
    _, plate = fields
    # Statics: below the plate the asphalt carries its pressure; on a level the vertical stress carries the whole load.
    under = plate.point_data["stress_kPa"][(np.abs(plate.points[:, 2]) < 1e-9) & (plate.points[:, 0] < 0.1)][:, 2]
    assert abs(under.mean() / 595 - 1) < 0.05, f"pressure under the plate: {under.mean():.0f} kPa"
    # Far from the load theta is that of the weight: 2200 kg/m3, k0 = 0.5, 1.5 m deep at the floor.
    far = (plate.points[:, 0] > 3.9) & (plate.points[:, 2] < -1.4999)
    assert np.allclose(plate.point_data["theta_kPa"][far], 2 * 2200 * 9.81 * 1.5 / 1000, rtol=0.02), "theta far away is that of the weight"


def test_the_subgrade_obeys_hookes_law(fields, of_points):
    _, plate = fields
    # The theory of elasticity: on the axis of a linear section Hooke's law holds at every node.
    e3 = 40.0
    nu = 0.4
    strain = plate.point_data["strain_microstrain"][of_points == 3] * 1e-6
    stress = plate.point_data["stress_kPa"][of_points == 3] / 1000
    expected = (stress[:, 2] - nu * (stress[:, 0] + stress[:, 1])) / e3
    assert np.allclose(strain[:, 2], expected, atol=1e-9 + 1e-6 * np.abs(expected).max()), "stress and strain of the subgrade obey Hooke's law"
    assert np.allclose(strain[:, 5] * e3 / (1 + nu), stress[:, 5], atol=1e-6 * np.abs(stress[:, 5]).max() + 1e-12), "shear too, as a tensor"


def test_the_solid_fills_the_section_and_carries_the_load():
    # 3D: cells of positive volume, the load in equilibrium with the vertical stress on a level.
    responses, (dual,) = field_of(ROOT / "grids" / "dual-nonlinear.toml", folder / "sub" / "dual.vtu")
    assert [c.type for c in dual.cells] == ["hexahedron20"], f"quadratic hexahedra: {dual.cells}"
    cells = dual.cells[0].data
    corner = dual.points[cells]
    a, b, c = corner[:, 1] - corner[:, 0], corner[:, 3] - corner[:, 0], corner[:, 4] - corner[:, 0]
    volume = np.einsum("ij,ij->i", np.cross(a, b), c)
    assert (volume > 0).all(), "no cell is inside out"
    middle = (corner[:, 8] - (corner[:, 0] + corner[:, 1]) / 2)
    assert np.abs(middle).max() < 1e-9 and np.abs(corner[:, 16] - (corner[:, 0] + corner[:, 4]) / 2).max() < 1e-9, "nodes between corners lie between them"
    extent = dual.points.max(axis=0)
    assert np.isclose(volume.sum(), extent[0] * extent[1] * -dual.points[:, 2].min(), rtol=1e-9), "the cells fill the section"
    # Vertical stress over the top faces of a level in the subgrade: quadrature by the mean of the face's eight nodes would
    # not be exact, that of its four corners and midsides with Simpson's weights for serendipity faces is: -1/12 and 1/3.
    levels = np.unique(np.round(corner[:, 4, 2], 9))  # of the upper faces
    level = levels[len(levels) // 3]
    here = np.isclose(corner[:, 4, 2], level)
    area = (np.linalg.norm(a, axis=1) * np.linalg.norm(b, axis=1))[here]
    szz = dual.point_data["stress_kPa"][cells[here]][:, :, 2]
    carried = 4 * (area * (szz[:, 4:8].sum(axis=1) * (-1 / 12) + szz[:, 12:16].sum(axis=1) / 3)).sum()
    force = float(next(line for line in (ROOT / "grids" / "dual-nonlinear.toml").read_text().splitlines() if line.startswith("force_kN")).split("=")[1].split("#")[0])
    assert abs(carried / force - 1) < 0.03, f"the level at {level:.2f} m carries {carried:.2f} of {force:.2f} kN"


def test_one_file_a_load():
    # One file a load; what cannot be written is said.
    two = (ROOT / "grids" / "captif-p1-diagnose-strain.toml")
    _, both = field_of(two, folder / "both.vtu")
    assert len(both) == 2 and (folder / "both-dual650.vtu").exists() and (folder / "both-dual750.vtu").exists(), "one file a load"


def test_what_cannot_be_written_is_said():
    wrong = run("forward", ROOT / "grids" / "captif-p1-fwd.toml", "--vtu", "/proc/none/x.vtu")
    assert wrong.returncode == 2 and "cannot be written" in wrong.stderr, f"says what cannot be written: {wrong.stderr}"
