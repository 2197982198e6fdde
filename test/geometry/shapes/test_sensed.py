"""The shapes of sensed maps: what they take, what they refuse, and what they are as values."""

import pickle

import numpy as np
import pytest

from drake_geom_ros.geometry import CalcObb, CalcVolume, GeometryError, OccupiedCells, PointCloud
from drake_geom_ros.geometry.shapes.primitives import for_queries
from drake_geom_ros.geometry.shapes.sensed import MOST_CELLS

KINDS = [OccupiedCells, PointCloud]
SOME = [[0.0, 0.0, 0.0], [1.0, 2.0, 3.0]]


@pytest.mark.parametrize('kind', KINDS)
@pytest.mark.parametrize(
    ('size', 'positions', 'told'),
    [
        (0.0, SOME, '= 0.0 must be from'),
        (-0.1, SOME, '= -0.1 must be from'),
        (np.nan, SOME, '= nan must be from'),
        (np.inf, SOME, '= inf must be from'),
        ('wide', SOME, "= 'wide' is not a number"),
        (0.1, np.zeros(3), r'\(3,\) must be \(n, 3\)'),
        (0.1, np.zeros((3, 2)), r'\(3, 2\) must be \(n, 3\)'),
        (0.1, [[0, 0, 0], [0, np.nan, 0]], r'1 of 2 .*\[1\] = \[0.0, nan, 0.0\]'),
        (0.1, [[np.inf, 0, 0], [0, 0, -np.inf]], r'2 of 2 .*\[0\] = \[inf, 0.0, 0.0\]'),
        (0.1, [[2e9, 0, 0]], r'1 of 1 .* beyond 1e\+09 m'),
        (0.1, [['a', 'b', 'c']], r'are no numbers \(n, 3\)'),
        (0.1, np.broadcast_to(0.0, (MOST_CELLS + 1, 3)), 'make a larger map coarser'),
    ],
)
def test_what_is_no_map_is_refused(kind, size, positions, told):
    with pytest.raises(GeometryError, match=f'{kind.__name__}: .*{told}'):
        kind(size, positions)


@pytest.mark.parametrize('kind', KINDS)
def test_a_map_is_a_value_of_its_own(kind):
    given = np.array(SOME)
    shape = kind(0.1, given)
    given[:] = 7.0
    positions = shape.centres() if kind is OccupiedCells else shape.positions()
    assert positions.tolist() == SOME
    with pytest.raises(ValueError, match='read-only'):
        positions[0] = 1.0
    assert (shape.count(), hash(shape)) == (2, hash(kind(0.1, SOME)))
    assert shape == kind(0.1, SOME) == shape.Clone() == pickle.loads(pickle.dumps(shape))
    assert shape != kind(0.2, SOME)
    assert shape != kind(0.1, SOME[::-1])
    other = KINDS[1 - KINDS.index(kind)]
    assert shape != other(0.1, SOME)
    assert repr(shape) in (
        'OccupiedCells(resolution=0.1, centres=(2, 3))',
        'PointCloud(radius=0.1, positions=(2, 3))',
    )


def test_the_box_of_a_map_holds_its_cells():
    box = CalcObb(OccupiedCells(0.2, SOME))
    assert box.center() == pytest.approx([0.5, 1.0, 1.5])
    assert box.half_width() == pytest.approx([0.6, 1.1, 1.6])
    assert CalcObb(PointCloud(0.2, SOME)).half_width() == pytest.approx([0.7, 1.2, 1.7])
    with pytest.raises(GeometryError, match=r'CalcVolume: .* may overlap'):
        CalcVolume(OccupiedCells(0.2, SOME))


def test_what_was_prepared_is_what_queries_take_and_for_its_margin_alone():
    shape = OccupiedCells(0.2, SOME)
    shape.prepare(0.1)
    assert for_queries(shape, margin=0.1).in_pairs is for_queries(shape, margin=0.1).in_pairs
    fresh = for_queries(OccupiedCells(0.2, SOME), margin=0.1).in_pairs
    other = for_queries(shape).in_pairs
    assert for_queries(shape, margin=0.1).in_pairs.parameters.tolist() == fresh.parameters.tolist()
    assert other.parameters.tolist() != fresh.parameters.tolist()


@pytest.mark.parametrize('kind', KINDS)
def test_a_map_without_cells_is_a_value_without_a_box(kind):
    empty = kind(0.2, np.zeros((0, 3)))
    assert (empty.count(), CalcObb(empty)) == (0, None)
    assert empty == pickle.loads(pickle.dumps(empty)) != kind(0.2, [[0.0, 0.0, 0.0]])
    assert [len(part) for part in empty.surface()] == [0, 0]
    empty.prepare(0.1)


def _volume(vertices, triangles):
    a, b, c = vertices[triangles].transpose(1, 0, 2)
    return float((a * np.cross(b, c)).sum() / 6.0)


def test_surfaces_enclose_the_cells_without_the_faces_between_them():
    grid = np.stack(np.meshgrid(*3 * [np.arange(3.0)]), axis=-1).reshape(-1, 3)
    vertices, triangles = OccupiedCells(1.0, grid).surface()
    assert _volume(vertices, triangles) == pytest.approx(27.0)
    assert len(triangles) == 2 * 6 * 9
    # Beside any grid all faces are there; a cell that is given twice is one.
    vertices, triangles = OccupiedCells(1.0, grid * 1.5).surface()
    assert (_volume(vertices, triangles), len(triangles)) == (pytest.approx(27.0), 27 * 12)
    assert len(OccupiedCells(1.0, np.vstack((grid, grid))).surface()[1]) == 2 * 6 * 9


@pytest.mark.parametrize('offset', [0.0, -7.3, 1e4])
@pytest.mark.parametrize('edge', [0.1, 0.03, 1.0 / 3.0])
def test_corners_of_cells_that_touch_are_the_same_numbers(edge, offset):
    """Of a slab of 30 by 30 cells there are as many corners as the slab has, to the bit."""
    places = np.stack(np.meshgrid(*2 * [np.arange(-15, 15)], [0]), axis=-1).reshape(-1, 3)
    centres = (places + 0.5) * edge + offset
    vertices, _ = OccupiedCells(edge, np.random.default_rng(0).permutation(centres)).surface()
    assert len(np.unique(vertices, axis=0)) == 31 * 31 * 2
    near = np.rint((vertices - offset) / edge) * edge + offset
    assert vertices == pytest.approx(near, abs=1e-11)


@pytest.mark.parametrize('count', [2, 10_001])
def test_balls_are_drawn_as_closed_polyhedra_with_corners_on_them(count):
    centres = 3.0 * np.arange(count)[:, None] * [1.0, 0.0, 0.0]
    vertices, triangles = PointCloud(1.0, centres).surface()
    near = np.linalg.norm(vertices[:, None] - centres[:2], axis=2).min(axis=1)
    assert near[: len(vertices) * 2 // count] == pytest.approx(1.0)
    assert 1.3 < _volume(vertices, triangles) / count < 4.0 / 3.0 * np.pi
