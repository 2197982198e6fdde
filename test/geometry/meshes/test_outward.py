"""Surfaces turned outward piece by piece: cavities stay, and what has no outside is refused."""

import numpy as np
import pytest

from drake_geom_ros.geometry import MeshFileError
from drake_geom_ros.geometry.meshes._outward import turned_outward

CORNERS = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
SQUARES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
CUBE = np.array([t for a, b, c, d in SQUARES for t in ((a, b, c), (a, c, d))])
OUT, IN = 1, -1


def cubes(*parts):
    """Return vertices and triangles of cubes, each half a size, a middle, and a turn."""
    vertices = [half * CORNERS + middle for half, middle, _ in parts]
    triangles = [CUBE[:, ::turn] + 8 * k for k, (_, _, turn) in enumerate(parts)]
    return np.vstack(vertices), np.vstack(triangles)


def volumes(vertices, triangles, counts):
    """Return the signed volume within each part of so many triangles, in order."""
    a, b, c = np.moveaxis(vertices[triangles], 1, 0)
    six = (np.cross(a, b) * c).sum(axis=1)
    return [round(float(part.sum()) / 6.0, 9) for part in np.split(six, np.cumsum(counts)[:-1])]


HERE, FAR, ASIDE = (0.5, 0.3, 0.1), (9.0, 0.0, 0.0), (0.5, 1.9, 0.1)


@pytest.mark.parametrize(
    ('parts', 'expected'),
    [
        ([(1, HERE, OUT)], [8]),
        ([(1, HERE, IN)], [8]),
        ([(2, HERE, OUT), (1, FAR, IN)], [64, 8]),
        ([(1, FAR, IN), (2, HERE, OUT)], [8, 64]),
        ([(2, HERE, OUT), (1, HERE, IN)], [64, -8]),
        ([(2, HERE, IN), (1, HERE, OUT)], [64, -8]),
        ([(2, HERE, IN), (1, HERE, IN)], [64, 8]),
        ([(3, HERE, IN), (2, HERE, OUT), (1, HERE, IN)], [216, -64, 8]),
        ([(3, HERE, OUT), (2, HERE, IN), (1, FAR, IN)], [216, -64, 8]),
        # Pieces that cross are bodies, none a cavity of another.
        ([(2, HERE, OUT), (1, ASIDE, IN)], [64, 8]),
        # A cavity that touches the wall from inside.
        ([(2, (0, 0, 0), OUT), (1, (1, 1, 1), IN)], [64, -8]),
        # Two that have an edge in common, and one of them a vertex with a third.
        ([(1, (0, 0, 0), OUT), (1, (2, 2, 0), IN), (1, (4, 4, 2), IN)], [8, 8, 8]),
    ],
)
def test_each_closed_piece_is_turned_with_the_one_around_it(parts, expected):
    vertices, triangles = turned_outward(*cubes(*parts), 'cubes')
    assert volumes(vertices, triangles, [12] * len(parts)) == expected


def test_a_wall_between_two_is_no_part_of_an_inverted_body():
    vertices, triangles = cubes((1, (0, 0, 0), IN), (1, (2, 0, 0), IN))
    vertices, triangles = turned_outward(vertices, triangles, 'cubes')
    assert volumes(vertices, triangles, [len(triangles)]) == [16]


def test_open_pieces_stay_as_they_are():
    vertices, triangles = cubes((1, (0, 0, 0), IN), (1, FAR, IN))
    lidless = triangles[2:]
    vertices, turned = turned_outward(vertices, lidless, 'cubes')
    p, q = turned[:10], turned[10:]
    closed = volumes(vertices, q, [12])
    assert closed == [8]
    as_given, _ = cubes((1, (0, 0, 0), IN), (1, FAR, IN))
    np.testing.assert_array_equal(vertices[p], as_given[lidless[:10]])


def test_what_is_right_comes_back_to_the_bit():
    given = cubes((2, HERE, OUT), (1, HERE, IN))
    for before, after in zip(given, turned_outward(*given, 'cubes'), strict=True):
        assert before is after


@pytest.mark.parametrize('dropped', [0, 1, 6])
def test_a_triangle_turned_against_its_neighbours_is_refused(dropped):
    vertices, triangles = cubes((1, (0, 0, 0), OUT))
    triangles[-1] = triangles[-1, ::-1]
    with pytest.raises(MeshFileError, match=r'cubes has no outside: of its edges [123] have two'):
        turned_outward(vertices, triangles[dropped:], 'cubes')


def test_three_sheets_at_an_edge_are_left_alone():
    vertices = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1)], dtype=float)
    fan = np.array([(0, 1, 2), (1, 0, 3), (0, 1, 4)])
    assert turned_outward(vertices, fan, 'fan')[1] is fan
