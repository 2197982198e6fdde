"""Unions of cells: closed surfaces of the boxes that they are made of, however finely cut."""

import numpy as np
import pytest

from drake_geom_ros.evidence import grids
from drake_geom_ros.geometry._solid_mesh import merged, volume

CELLS = {'L': grids.L, 'U': grids.U, 'ring': grids.RING, 'hollow': grids.HOLLOW}
names = pytest.mark.parametrize('name', CELLS)


@names
@pytest.mark.parametrize('cuts', [1, 3])
def test_the_surface_is_closed_and_looks_out(name, cuts):
    body = grids.solid(CELLS[name], cuts=cuts, scale=0.5)
    assert volume(body.corners) == pytest.approx(len(CELLS[name]) / 8.0)
    vertices, triangles = merged(np.array(body.size), np.array(body.triangles))
    assert len(vertices) == len(body.size)  # none stands twice
    sides = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    assert (np.unique(sides, axis=0, return_counts=True)[1] == 2).all()
    assert len(triangles) == cuts**2 * len(grids.surface(CELLS[name])[1])


@names
def test_the_boxes_are_the_body(name):
    parts = grids.boxes(CELLS[name])
    middles = np.array(CELLS[name]) + 0.5
    inside = [(np.abs(middles - box.p) < 0.5 * np.array(box.size)).all(axis=1) for box in parts]
    assert np.any(inside, axis=0).all()
    holes = np.array([cell for cell in np.ndindex(4, 4, 4) if cell not in CELLS[name]]) + 0.5
    assert not any((np.abs(holes - b.p) < 0.5 * np.array(b.size)).all(axis=1).any() for b in parts)


def test_only_the_largest_boxes_are_told():
    sizes = sorted(box.size for box in grids.boxes(grids.U))
    assert sizes == [(1.0, 2.0, 1.0), (1.0, 2.0, 1.0), (3.0, 1.0, 1.0)]
    assert [box.size for box in grids.boxes(grids.CUBE)] == [(1.0, 1.0, 1.0)]


def test_lines_may_lie_anywhere():
    lines = [np.array([-1.0, 0.0, 4.0]), np.array([0.0, 0.5, 1.0]), np.array([2.0, 3.0])]
    body = grids.solid(grids.L, lines, cuts=2)
    assert volume(body.corners) == pytest.approx(1.0 * 0.5 + 4.0 * 0.5 + 1.0 * 0.5)
    assert sorted(box.size for box in body.parts) == [(1.0, 1.0, 1.0), (5.0, 0.5, 1.0)]
    np.testing.assert_array_equal(
        np.unique(np.array(body.size)[:, 0]), [-1.0, -0.5, 0.0, 2.0, 4.0]
    )
