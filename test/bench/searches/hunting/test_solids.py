"""The truth of a lattice, and the search among solids on it."""

import numpy as np
import pytest

from bench.searches.hunting.lattice import Lattice, truth, with_junction
from bench.searches.hunting.solids import LAWS, SolidHunt
from drake_geom_ros.geometry import MeshData
from drake_geom_ros.geometry.meshes._solids import volume
from truth.bodies import grids


def lattice(cells):
    """A plain lattice of cells of 1 m."""
    lines = np.tile(np.arange(4.0), (3, 1))
    vertices, triangles = grids.surface(cells, list(lines))
    return Lattice(tuple(cells), lines, np.array(vertices), tuple(triangles), 'unit 1')


@pytest.mark.parametrize(
    ('p', 'expected'),
    [
        ((3.0, 0.0, 0.0), (1.0, 1.0)),
        ((3.0, 3.0, 0.0), (5**0.5, 5**0.5)),  # from the end of an arm
        ((2.0, 0.0, 0.0), (0.0, 0.0)),
        ((1.75, 0.0, 0.0), (-0.25, -0.25)),
        ((1.0, 1.0, 0.0), (0.0, 0.0)),  # in the notch
    ],
)
def test_the_truth_of_an_l_and_a_cube(p, expected):
    cube = lattice(grids.CUBE)
    found = truth(lattice(grids.L).boxes(np.zeros(3)), cube.boxes(np.array(p)))
    assert found == pytest.approx(expected, abs=1e-15)


def test_points_of_an_l():
    found = [lattice(grids.L).signed_distance(np.array(q)) for q in ([1.3, 1.3, 0.5], [0.5] * 3)]
    assert found == pytest.approx([0.3, -0.5], abs=1e-15)


def test_a_junction_leaves_the_surface_closed_and_the_body_the_same():
    body = lattice(grids.L)
    rng = np.random.default_rng(2)
    vertices, triangles = with_junction(rng, body.vertices, list(body.triangles))
    MeshData(vertices, triangles)
    rows = np.array(triangles)
    assert volume(vertices[rows]) == pytest.approx(3.0)
    edges = rows[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    assert {tuple(e) for e in edges.tolist()} == {tuple(e[::-1]) for e in edges.tolist()}


def test_a_search_is_the_same_for_a_seed_and_judges_by_all_laws():
    hunts = [SolidHunt(4), SolidHunt(4)]
    for hunt in hunts:
        for _ in range(2):
            hunt.generation()
    assert hunts[0].worst == hunts[1].worst
    assert {law for law, _ in hunts[0].worst} == set(LAWS)
    assert hunts[0].judged > 0
