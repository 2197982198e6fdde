"""Winding numbers: the exact sum, its approximation by dipoles, and the signs."""

import mpmath
import numpy as np
import pytest
import trimesh
from oracles.forms import kernel_form
from oracles.solids import solid

from drake_geom_ros.geometry import MeshData
from drake_geom_ros.geometry._proximity.kernels.solids import winding as winding_module
from drake_geom_ros.geometry._proximity.kernels.solids.solid import (
    AREA,
    AREA_VECTOR,
    RADIUS,
    rounding_of_angle,
    solid_angle,
    tree_of,
)
from drake_geom_ros.geometry._proximity.kernels.solids.winding import dipole, is_inside, winding
from drake_geom_ros.geometry._proximity.kernels.trees.boxes import NODE_WIDTH
from drake_geom_ros.geometry._proximity.kinds import SOLID
from drake_geom_ros.geometry.meshes._solids import solid_of

RING = kernel_form(solid('ring', cuts=4))[1]


def torus():
    """A torus of radii 1 and 0.3 [m] of 512 triangles."""
    mesh = trimesh.creation.torus(1.0, 0.3, major_sections=32, minor_sections=8)
    kind, parameters = solid_of(MeshData(mesh.vertices, mesh.faces), (1.0, 1.0, 1.0))
    assert kind == SOLID
    return parameters


@pytest.mark.parametrize('ratio', [1.5, 3.0, 6.0, 24.0, np.inf])
def test_the_error_of_dipoles_is_never_more_than_told(ratio):
    parameters = torus()
    tree = tree_of(SOLID, parameters)
    used = 0
    for q in np.random.default_rng(1).uniform(-2, 2, (100, 3)):
        exact, none = winding(parameters, tree, tuple(q), np.inf, -1)
        near, error = winding(parameters, tree, tuple(q), ratio, -1)
        assert none == 0.0
        assert abs(exact - round(exact)) <= 1e-13
        assert abs(near - exact) <= error + 1e-13
        used += error > 0.0
    assert (used > 50) == (ratio <= 6.0)


def test_signs_on_a_grid_of_a_ring():
    tree = tree_of(SOLID, RING)
    for x, y, z in np.random.default_rng(2).uniform(-0.5, 3.5, (400, 3)):
        cell = int(np.floor(x)), int(np.floor(y)), int(np.floor(z))
        within = cell[0] in (0, 1, 2) and cell[1] in (0, 1, 2) and cell[2] == 0
        expected = within and cell[:2] != (1, 1)
        assert is_inside(RING, tree, (x, y, z)) == expected


@pytest.mark.parametrize('height', [1e-12, 1e-9, 1e-3])
def test_signs_next_to_the_surface(height):
    tree = tree_of(SOLID, RING)
    for x, y in np.random.default_rng(3).uniform(0, 1, (50, 2)):
        assert is_inside(RING, tree, (x, y, 1.0 - height))
        assert not is_inside(RING, tree, (x, y, 1.0 + height))


def half_angle(a, b, c):
    """Half the solid angle of a triangle, with fifty digits."""
    rows = [mpmath.matrix(v.tolist()) for v in (a, b, c)]
    la, lb, lc = (mpmath.norm(v) for v in rows)
    ab, bc, ca = ((rows[i].T * rows[j])[0] for i, j in ((0, 1), (1, 2), (2, 0)))
    volume = mpmath.det(mpmath.matrix([v.tolist() for v in (a, b, c)]))
    return mpmath.atan2(volume, la * lb * lc + ab * lc + bc * la + ca * lb)


def test_a_solid_angle_to_fifty_digits():
    rng = np.random.default_rng(4)
    for _ in range(50):
        a, b, c = rng.normal(size=(3, 3)) * 10 ** rng.uniform(-6, 6)
        with mpmath.workdps(50):
            truth = half_angle(a, b, c)
        assert solid_angle(tuple(a), tuple(b), tuple(c)) == pytest.approx(float(truth), abs=1e-12)


def test_beside_needles_the_angle_is_as_far_off_as_told_at_most():
    """Seen from near their middle, where both parts of the tangent lose twice what is thin."""
    rng = np.random.default_rng(6)
    told = []
    for _ in range(200):
        thin = 10 ** rng.uniform(-12, 0)
        ends = (
            np.array([[-1.0, 0, 0], [1.0, 0, 0], [1.0, 0, 0]]) + rng.uniform(-0.3, 0.3, 3)[:, None]
        )
        a, b, c = ends * [1, 0, 0] + thin * rng.normal(size=(3, 3))
        with mpmath.workdps(60):
            off = abs(half_angle(a, b, c) - solid_angle(tuple(a), tuple(b), tuple(c)))
        told.append(rounding_of_angle(tuple(a), tuple(b), tuple(c)))
        # Half of a full turn more or less is the same side seen from behind.
        assert min(off, abs(off - 2 * mpmath.pi)) <= told[-1]
    assert max(told) == np.pi
    assert np.median(told) < 1e-3


@pytest.mark.parametrize('away', [1.1, 1.5, 3.0])
def test_the_error_of_a_dipole_holds_for_the_worst_of_nodes(away):
    """Two specks of area 1 at either end of the ball, level, seen from beyond one of them."""
    node = np.zeros(NODE_WIDTH)
    node[AREA_VECTOR : AREA_VECTOR + 3] = 2.0, 0.0, 0.0
    node[AREA], node[RADIUS] = 2.0, 1.0
    half, error, radii = dipole(node, 0, (-away, 0.0, 0.0))
    exact = 0.5 / (away - 1.0) ** 2 + 0.5 / (away + 1.0) ** 2
    assert radii == away
    assert half == pytest.approx(1.0 / away**2, rel=1e-15)
    assert abs(half - exact) <= error


def test_a_sign_is_told_when_no_dipole_can_change_it(monkeypatch):
    told = iter([(0.625, 0.25), (0.375, 0.2), (0.25, 0.125), (1.0, 0.0)])
    ratios = []

    def scripted(shape, tree, q, ratio, without):
        ratios.append(ratio)
        return next(told)

    monkeypatch.setattr(winding_module, 'winding', scripted)
    look = getattr(is_inside, 'py_func', is_inside)
    assert not look(RING, tree_of(SOLID, RING), (0.5, 0.5, 0.5))
    assert ratios == [6.0, 24.0, 96.0]
    assert look(RING, tree_of(SOLID, RING), (0.5, 0.5, 0.5))
