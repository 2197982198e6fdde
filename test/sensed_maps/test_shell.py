"""Cells beside bodies: joined, taken apart, each once and in order."""

import numpy as np

from drake_geom_ros.sensed_maps.cells import Cells
from drake_geom_ros.sensed_maps.keeping import KeptCells
from drake_geom_ros.sensed_maps.shell import Shell

POINTS = np.array([[0.12, 0.0, 0.0], [0.11, 0.0, 0.0], [-0.31, 0.0, 0.0], [0.55, 0.2, 0.1]])
DISTANCES = np.array([0.02, 0.03, 0.04, 0.01])


def of_points(now=1.0):
    return Shell.of_points(POINTS, DISTANCES, 0.1, now)


def test_of_a_cell_the_place_is_the_point_that_is_nearest_to_a_body():
    shell = of_points()
    assert shell.places.tolist() == POINTS[[2, 0, 3]].tolist()
    assert shell.cells.packed.tolist() == Cells.of_points(POINTS, 0.1).packed.tolist()
    assert shell.seen.tolist() == [1.0] * 3
    assert len(Shell.of_points(POINTS[:0], DISTANCES[:0], 0.1, 1.0).cells) == 0


def test_what_is_joined_is_there_once_as_the_first_of_two_has_it():
    more = np.array([[0.19, 0.0, 0.0], [2.0, 0.0, 0.0]])
    other = Shell.of_points(more, np.zeros(2), 0.1, 0.5)
    both = of_points().and_others(other)
    assert (np.diff(both.cells.packed) > 0).all()
    assert both.places.tolist() == [*POINTS[[2, 0, 3]].tolist(), [2.0, 0.0, 0.0]]
    assert both.seen.tolist() == [1.0, 1.0, 1.0, 0.5]
    left = both.without(other.cells.packed)
    assert left.places.tolist() == POINTS[[2, 3]].tolist()


def test_cells_of_a_map_are_seen_at_their_centres_when_they_were():
    cells = Cells.of_points(POINTS, 0.1)
    shell = Shell.of_map(KeptCells(cells, np.array([1.0, 2.0, 3.0])))
    assert shell.places.tolist() == cells.centres().tolist()
    assert shell.seen.tolist() == [1.0, 2.0, 3.0]
    assert shell.as_seen_at(9.0).seen.tolist() == [9.0] * 3


def test_no_point_of_a_cell_is_beyond_the_reach_of_its_centre():
    rng = np.random.default_rng(3)
    points = rng.uniform(-1.0, 1.0, (500, 3))
    shell = Shell.of_points(points, np.zeros(500), 0.3, 0.0)
    away = np.linalg.norm(shell.places - shell.cells.centres(), axis=1)
    assert 0.2 < away.max() <= shell.reach
