"""How triangles meet, and what that tells: by fractions, on a small lattice with all its ties."""

from fractions import Fraction

import numpy as np
import pytest

from drake_geom_ros.geometry._proximity.kernels.solids.meetings import (
    A_IS_OUT,
    B_IS_OUT,
    BESIDE,
    END_TO_END,
    NOTHING,
    OVER,
    OVERLAPPING,
    TOUCH,
    are_side_by_side,
    areas_overlap,
    meeting,
    order_on_line,
    sides_of,
)

CASES = 3000
FLOOR = ((0, 0, 0), (4, 0, 0), (0, 4, 0))  # its body is beneath it


def triangle(corners):
    return tuple((*(float(x) for x in corner), 0.0, 0.0, 0.0) for corner in corners)


def minus(a, b):
    return [x - y for x, y in zip(a, b, strict=True)]


def dot(u, v):
    return sum(x * y for x, y in zip(u, v, strict=True))


def cross(u, v):
    return [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]


def normal(T):
    return cross(minus(T[1], T[0]), minus(T[2], T[0]))


def part_of_line(T, S, along):
    """Where T meets the plane of S, from and to, or None."""
    heights, places = [dot(minus(t, S[0]), normal(S)) for t in T], []
    for k in range(3):
        m = (k + 1) % 3
        if heights[k] == 0:
            places.append(dot(T[k], along))
        if heights[k] * heights[m] < 0:
            s = heights[k] / (heights[k] - heights[m])
            places.append(dot(T[k], along) + s * dot(minus(T[m], T[k]), along))
    return (min(places), max(places)) if places else None


def expected_order(mine, its):
    (a, b), (x, y) = mine, its
    if b < x or y < a:
        return BESIDE
    return OVER if a < y and x < b else END_TO_END


def test_the_order_on_the_common_line_is_that_of_fractions():
    rng, told = np.random.default_rng(1), set()
    for _ in range(CASES):
        T, S = ([[Fraction(int(x)) for x in row] for row in rng.integers(0, 4, (3, 3))]
                for _ in range(2))  # fmt: skip
        along = cross(normal(T), normal(S))
        if not any(along):
            continue
        mine, its = part_of_line(T, S, along), part_of_line(S, T, along)
        if mine is None or its is None:
            continue
        t, s = triangle(T), triangle(S)
        got = order_on_line(t, s, sides_of(s, t, 0.0), sides_of(t, s, 0.0), 0.0)
        assert got == expected_order(mine, its), (T, S)
        told.add(got)
    assert told == {BESIDE, END_TO_END, OVER}


@pytest.mark.parametrize(
    ('other', 'told'),
    [
        (((1, 1, 1), (2, 1, 1), (1, 2, 1)), NOTHING),
        (((1, 1, -1), (2, 1, 1), (1, 2, 1)), OVERLAPPING),  # goes through
        (((1, 1, 0), (2, 1, 1), (1, 2, 1)), TOUCH | B_IS_OUT),  # a corner from above
        (((1, 1, 0), (2, 1, 0), (1, 2, 1)), TOUCH | B_IS_OUT),  # an edge from above
        (((1, 1, 0), (2, 1, -1), (1, 2, -1)), OVERLAPPING),  # a corner from beneath
        (((1, 1, 0), (2, 1, 0), (1, 2, -1)), OVERLAPPING),  # an edge from beneath
        (((0, 0, 0), (4, 0, 0), (0, 0, 1)), TOUCH),  # an edge on an edge
        (((0, 0, 0), (-1, 0, 1), (-1, 0, -1)), TOUCH),  # a corner on a corner
        (((1, 0, -1), (1, 0, 1), (1, -1, 0)), TOUCH),  # an edge across an edge
        (((1, 1, 0), (2, 1, 0), (1, 2, 0)), OVERLAPPING),  # on it, the same way
        (((1, 1, 0), (1, 2, 0), (2, 1, 0)), TOUCH | A_IS_OUT | B_IS_OUT),  # on it, facing it
        (((4, 4, 0), (4, 0, 0), (0, 4, 0)), TOUCH),  # in its plane, along an edge
        (((9, 9, 0), (9, 8, 0), (8, 9, 0)), TOUCH),  # in its plane, far off: to be asked
        (((0, 0, 1), (5, 0, -1), (0, 0, -2)), TOUCH | A_IS_OUT),  # along an edge, facing it
        (((0, 0, 1), (0, 0, -2), (5, 0, -1)), OVERLAPPING),  # the same from within
    ],
)
def test_what_a_meeting_tells(other, told):
    T, S = triangle(FLOOR), triangle(other)
    assert meeting(T, S, 0.0) == told
    swapped = told & (TOUCH | OVERLAPPING)
    swapped |= B_IS_OUT if told & A_IS_OUT else 0
    swapped |= A_IS_OUT if told & B_IS_OUT else 0
    assert meeting(S, T, 0.0) == swapped
    for k in range(3):  # whichever corner is the first
        turned = T[k:] + T[:k]
        assert meeting(turned, S, 0.0) == told


@pytest.mark.parametrize('off', [0.0, 1e-15])
@pytest.mark.parametrize('axis', range(3))
def test_triangles_side_by_side_in_a_plane_across_an_axis_touch_and_have_no_area_in_common(
    axis, off
):
    """As the signs say that are not asked then; and of some that these part nothing is said."""
    rng, told = np.random.default_rng(axis), {True: 0, False: 0}
    for _ in range(CASES):
        corners = rng.integers(0, 4, (2, 3, 3))
        corners[:, :, axis] = 2
        t, s = (triangle(x) for x in corners)
        beside = are_side_by_side(t, s)
        told[beside] += not areas_overlap(t, s, axis, off)
        if beside:
            assert not areas_overlap(t, s, axis, off)
            assert meeting(t, s, off) == TOUCH
    assert min(told.values()) > 100


def test_what_rounding_took_off_tells_whether_triangles_are_side_by_side():
    """One that begins where the other ends but for the last bits is in it, or beyond."""
    t = triangle(FLOOR)
    for more in (-1e-17, 1e-17):
        s = tuple((x + 4.0, *rest, more, 0.0, 0.0) for x, *rest in np.array(FLOOR, float).tolist())
        assert not are_side_by_side(t, s)
        assert meeting(t, s, 0.0) == (OVERLAPPING if more < 0.0 else TOUCH)
