"""Every shape against solids: unions of boxes, special positions, and the laws of a result row."""

import itertools

import numpy as np
import pytest
from numba import config
from oracles.forms import HERE, PARAMETERS, body, row_of
from oracles.pairs import check_row
from oracles.solids import parts_gap, solid

from drake_geom_ros.cross_check.bodies import Body
from drake_geom_ros.geometry import MeshData
from drake_geom_ros.geometry._proximity.kernels.calling import pairs as calling
from drake_geom_ros.geometry._proximity.kinds import (
    BOUND_ONLY,
    BOX,
    CAPSULE,
    CONVEX,
    CYLINDER,
    ELLIPSOID,
    MESH,
    OPEN,
    SOLID,
    SPHERE,
)
from drake_geom_ros.geometry._proximity.tolerances import EPS
from drake_geom_ros.geometry.meshes.source import hull_vertices
from truth.bodies.random_bodies import box_corners, random_rotation
from truth.references.meshes import parts_of

NAMES = ('L', 'U', 'ring')
SIZE = 8.0  # of the pairs below [m], about
ROUNDING = 200 * EPS * SIZE
COUNT = 6 if config.DISABLE_JIT else 60


def random_body(rng, kind):
    """A body of 0.04 to 0.8 m, turned at random, aligned, or almost."""
    R = np.eye(3)
    if rng.random() < 0.8:
        R = random_rotation(rng, None if rng.random() < 0.7 else 1e-12)
    if kind == SOLID:
        name = NAMES[rng.integers(3)]
        made = solid(name, float(rng.choice([0.2, 0.5, 1.0])), int(rng.integers(1, 3)))
        return made.placed(R, HERE)
    if kind == CONVEX:
        points = MeshData(rng.normal(size=(12, 3)) * rng.uniform(0.1, 0.6))
        vertices = hull_vertices(points, np.ones(3))
        return Body('Convex', vertices, R)
    return body((kind, 0.8 * 10 ** rng.uniform(-1.3, 0, PARAMETERS[kind])), R)


def random_pairs(kind, seed, count=COUNT):
    """A body of a kind near a solid: apart, touching, on the grid of its walls, within."""
    rng = np.random.default_rng(seed)
    for _ in range(count):
        A = random_body(rng, kind)
        R = random_rotation(rng) if rng.random() < 0.5 else np.eye(3)
        B = solid(NAMES[rng.integers(3)], cuts=int(rng.choice([1, 3]))).placed(R, HERE)
        p = rng.uniform(-0.8, 3.8, 3) * [1, 1, 0.5]
        yield A.at(R @ (np.round(4 * p) / 4 if rng.random() < 0.3 else p)), B


def turned(R, *bodies):
    return (body.moved(R, HERE) for body in bodies)


@pytest.mark.parametrize('kind', [SPHERE, BOX, CAPSULE, CYLINDER, ELLIPSOID, CONVEX, SOLID])
def test_unions_of_boxes(kind):
    apart = overlapping = 0
    for A, B in random_pairs(kind, 40 + kind):
        out = row_of(A, B)
        check_row(out, ROUNDING)
        distance, bound = out[calling.DISTANCE], out[calling.ERROR_BOUND]
        gap, slack = parts_gap(A, B)
        slack += ROUNDING
        if gap >= 0.0:
            apart += 1
            assert abs(distance - gap) <= bound + slack
            assert bound <= 1.1e-9
        else:
            overlapping += 1
            # They have to move at least as far as the deepest part asks for, and need not more
            # than what is reported, for that separates them.
            assert distance - bound <= gap + slack
            moved, off = parts_gap(A.at(A.p - distance * out[1:4]), B)
            assert moved >= -off - ROUNDING
        assert out[calling.METHOD] == MESH or (gap < 0.0 and out[calling.METHOD] == OPEN)
    assert apart
    assert overlapping


@pytest.mark.parametrize('kind', [SPHERE, BOX, CYLINDER, CONVEX, SOLID])
def test_a_common_rotation_changes_nothing(kind):
    rng = np.random.default_rng(3)
    for A, B in random_pairs(kind, 60 + kind, COUNT // 3):
        R = random_rotation(rng)
        here, there = row_of(A, B), row_of(*turned(R, A, B))
        # Where overlaps are not closed another way out may be found, within the bounds.
        slack = max(here[calling.ERROR_BOUND], there[calling.ERROR_BOUND]) + ROUNDING
        assert abs(here[calling.DISTANCE] - there[calling.DISTANCE]) <= 2.0 * slack
        if here[calling.UNIQUE] and there[calling.UNIQUE] and here[0] > 1e-3:
            assert R @ here[1:4] == pytest.approx(there[1:4], abs=1e-4)


def test_exchanged_solids_answer_alike():
    for A, B in random_pairs(SOLID, 70, COUNT // 3):
        here, there = row_of(A, B), row_of(B, A)
        slack = max(here[calling.ERROR_BOUND], there[calling.ERROR_BOUND]) + ROUNDING
        assert abs(here[calling.DISTANCE] - there[calling.DISTANCE]) <= 2.0 * slack


@pytest.mark.parametrize('kind', [SPHERE, BOX, CAPSULE, SOLID])
@pytest.mark.parametrize('cutoff', [0.0, 0.3])
def test_beyond_a_cutoff_a_lower_bound_is_enough(kind, cutoff):
    beyond = 0
    for A, B in random_pairs(kind, 80 + kind, COUNT // 2):
        full, cut = row_of(A, B), row_of(A, B, cutoff=cutoff)
        check_row(cut, ROUNDING)
        if cut[calling.METHOD] == BOUND_ONLY:
            beyond += 1
            assert cut[calling.DISTANCE] >= cutoff - ROUNDING
            low, high = (s * full[calling.ERROR_BOUND] + full[0] for s in (-1, 1))
            assert cut[calling.DISTANCE] - cut[calling.ERROR_BOUND] <= high
            assert cut[calling.DISTANCE] + cut[calling.ERROR_BOUND] >= low
        else:
            assert cut[0] == pytest.approx(full[0], abs=2.0 * full[calling.ERROR_BOUND] + 1e-9)
    assert beyond


@pytest.mark.parametrize('hint', [(1.0, 0, 0), (0, 0, -3.0), (np.nan, 0, 0), (np.inf, 1, 0)])
def test_a_hint_may_be_wrong(hint):
    for A, B in random_pairs(BOX, 90, 8):
        plain, hinted = row_of(A, B), row_of(A, B, hint=hint)
        check_row(hinted, ROUNDING)
        slack = plain[calling.ERROR_BOUND] + hinted[calling.ERROR_BOUND] + ROUNDING
        assert abs(plain[0] - hinted[0]) <= 2.0 * slack


def at(kind, parameters, *p):
    return body((kind, parameters), p=p)


L = solid('L')
SPECIAL = {
    'sphere over': (at(SPHERE, [0.1], 0.5, 0.5, 1.5), 0.4, (0, 0, 1)),
    'sphere touching': (at(SPHERE, [0.1], 0.5, 0.5, 1.1), 0.0, (0, 0, 1)),
    'sphere in the notch': (at(SPHERE, [0.1], 1.05, 1.5, 0.5), -0.05, (1, 0, 0)),
    'sphere inside': (at(SPHERE, [0.1], 0.4, 0.5, 0.5), -0.5, (-1, 0, 0)),
    'centre on a wall': (at(SPHERE, [0.1], 0.0, 1.5, 0.5), -0.1, (-1, 0, 0)),
    'point inside': (at(SPHERE, [0.0], 0.4, 0.5, 0.6), -0.4, None),
    'point on a wall': (at(SPHERE, [0.0], 0.5, 0.4, 1.0), 0.0, (0, 0, 1)),
    'point in the notch': (at(SPHERE, [0.0], 1.25, 1.5, 0.5), 0.25, (1, 0, 0)),
    'box over': (at(BOX, [0.1] * 3, 0.5, 0.5, 1.5), 0.4, (0, 0, 1)),
    'box flush': (at(BOX, [0.1] * 3, 0.5, 0.5, 1.1), 0.0, (0, 0, 1)),
    'box 1 mm in': (at(BOX, [0.1] * 3, 0.5, 0.5, 1.099), -1e-3, (0, 0, 1)),
    'box flush in the notch': (at(BOX, [0.5] * 3, 1.5, 1.5, 0.5), 0.0, None),
    'box inside': (at(BOX, [0.1] * 3, 0.4, 0.5, 0.5), -0.5, (-1, 0, 0)),
    'box flush within': (at(BOX, [0.1] * 3, 0.1, 0.5, 0.5), -0.2, (-1, 0, 0)),
    'box around it all': (at(BOX, [5.0] * 3, 0.0, 0.0, 0.0), -5.0, None),
    'capsule on a wall': (at(CAPSULE, [0.1, 0.25], 1.05, 1.5, 0.5), -0.05, (1, 0, 0)),
    'cylinder in a wall': (at(CYLINDER, [0.1, 0.25], 1.09, 1.5, 0.5), -0.01, (1, 0, 0)),
    'ellipsoid in a wall': (at(ELLIPSOID, [0.1, 0.2, 0.3], 1.09, 1.5, 0.5), -0.01, (1, 0, 0)),
    'L on L': (L.at([0, 0, 1]), 0.0, (0, 0, 1)),
    'L 1 mm in L': (L.at([0, 0, 0.999]), -1e-3, (0, 0, 1)),
    'L in the notch of L': (L.at([1.2, 1.2, 0]), 0.2, None),
    'small U inside L': (solid('U', 0.05).at([0.3, 0.3, 0.3]), -0.35, (0, 0, -1)),
    'L where L is': (L, -1.0, None),
}


# Turned, their intervals may stay open: what rounding leaves of walls that fit is not cleared.
OPEN_IF_TURNED = {'L where L is', 'small U inside L'}


@pytest.mark.parametrize('name', SPECIAL)
@pytest.mark.parametrize('scale', [1e-6, 1.0, 1e4])
def test_special_position(name, scale):
    A, expected, nhat = SPECIAL[name]
    R = random_rotation(np.random.default_rng(6)) if scale != 1.0 else np.eye(3)
    out = row_of(*turned(R, A.scaled(scale), L.scaled(scale)), 1e-9 * scale)
    check_row(out, ROUNDING * scale)
    assert abs(out[0] - scale * expected) <= out[calling.ERROR_BOUND] + ROUNDING * scale
    if scale == 1.0 or name not in OPEN_IF_TURNED:
        assert out[calling.ERROR_BOUND] <= 1e-11 * scale
        assert out[0] == pytest.approx(scale * expected, abs=1e-11 * scale)
    if nhat is not None:
        assert R.T @ out[1:4] == pytest.approx(nhat, abs=1e-6)


@pytest.mark.parametrize('seed', [5, 6, 7, 11])
def test_solids_that_lie_flush_push_each_other_up_and_down(seed):
    """Rounding chose the side of the faces, so that their edges told the normal."""
    R = random_rotation(np.random.default_rng(seed))
    above, beneath = turned(R, solid('L', 1e4).at([0, 0, 1e4]), solid('L', 1e4))
    for A, B, side in ((above, beneath, 1.0), (beneath, above, -1.0)):
        out = row_of(A, B, 1e-5)
        # The bound holds both, for turned by rounded numbers they may be apart or overlap.
        assert abs(out[calling.DISTANCE]) <= out[calling.ERROR_BOUND] <= 2e-9
        assert out[1:4] == pytest.approx(side * R[:, 2], abs=1e-6)


def test_in_an_inner_corner_both_walls_push():
    A = at(SPHERE, [0.1], 1.05, 1.05, 0.5)
    out = row_of(A, L)
    assert out[0] == pytest.approx(-np.hypot(0.05, 0.05), abs=1e-12)
    assert out[1:4] == pytest.approx([np.sqrt(0.5), np.sqrt(0.5), 0], abs=1e-9)
    assert out[calling.ERROR_BOUND] >= 0.0207
    assert not out[calling.UNIQUE]


def test_a_ball_in_the_hole_of_a_ring_is_free():
    ring = solid('ring')
    out = row_of(at(SPHERE, [0.4], 1.5, 1.5, 0.5), ring)
    assert out[0] == pytest.approx(0.1, abs=1e-14)
    assert not out[calling.UNIQUE]
    assert row_of(at(SPHERE, [0.6], 1.5, 1.5, 0.5), ring)[0] < -0.1


@pytest.mark.parametrize('gap', [1e-3, 1e-9, 1e-13, 0.0, -1e-13])
@pytest.mark.parametrize('kind', [BOX, SOLID])
def test_edges_that_touch_crosswise(kind, gap):
    """An edge of a body turned by 45 degrees lies across an edge of the L, seen along both."""
    s = np.sqrt(0.5)
    up = np.array([0.0, -s, s])  # between the L's top and its wall y = 0
    across = np.column_stack(([s, s * up[1], s * up[2]], [0.0, s, s], [-s, s * up[1], s * up[2]]))
    across = across if np.linalg.det(across) > 0 else across[:, [1, 0, 2]]
    if kind == BOX:
        A = Body('Box', (0.2, 0.2, 0.2), across)
    else:
        A = solid('U', 0.1).placed(across, HERE)
    corners = np.vstack([box_corners(a.size) @ a.R.T + a.p for a in parts_of(A)])
    heights = corners @ up
    lowest = corners[heights <= heights.min() + 1e-12]
    A = A.at(np.array([0.5, 0.0, 1.0]) - lowest.mean(axis=0) + gap * up)
    out = row_of(A, L)
    truth, error = parts_gap(A, L)
    check_row(out, ROUNDING)
    assert truth == pytest.approx(gap, abs=1e-12)
    assert abs(out[0] - truth) <= out[calling.ERROR_BOUND] + error
    assert out[calling.ERROR_BOUND] <= 1e-8
    assert out[1:4] == pytest.approx(up, abs=1e-4)


def test_a_cutoff_does_not_hide_the_nearest_wall():
    """What is nearer than any wall within the cutoff was left out: the answer was not."""
    middle = np.array(
        [0.45, 1.5, 0.5]
    )  # in a wall of the ring: 0.45 from without, 0.55 from the hole
    for cuts, radius in itertools.product((1, 2, 5), (0.0, 0.125)):
        A, B = Body('Sphere', (radius,), p=middle), solid('ring', cuts=cuts)
        for cutoff in (0.0, 0.1, 0.47, 0.5, np.inf):
            out = row_of(A, B, cutoff=cutoff)
            assert out[calling.DISTANCE] == pytest.approx(-0.45 - radius, abs=1e-12)


def test_curved_bodies_of_kilometres_are_as_exact():
    """GJK loses digits by a thin simplex, and goes on with a fresh one."""
    s = 2.0**13
    egg = Body('Ellipsoid', (0.25, 0.125, 0.375), p=np.full(3, 1.5)).scaled(s)
    out = row_of(egg, solid('ring').at([0.0, 0.0, 1.0]).scaled(s))
    assert out[calling.DISTANCE] == pytest.approx(0.25 * s, abs=out[calling.ERROR_BOUND])
    assert out[calling.ERROR_BOUND] <= 1e-13 * s


def test_a_ring_stands_on_what_it_has():
    """Its lowest vertices surround a hole, in the middle of which nothing touches the floor."""
    floor = Body('HalfSpace', p=np.array([0.0, 0.0, -0.25]))
    out = row_of(floor, solid('ring'))
    assert out[calling.DISTANCE] == 0.25
    x, y, z = floor.p + out[calling.WITNESS_B : calling.WITNESS_B + 3]
    assert z == 0.0
    assert x in (0.0, 3.0) or y in (0.0, 3.0)
