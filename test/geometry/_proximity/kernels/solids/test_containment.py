"""Solids in one another whose surfaces do not cross, or do so along edges only.

The truth is that of the boxes that they are unions of.
"""

import itertools

import numpy as np
import pytest
from numba import config
from oracles.forms import HERE, kernel_form, row_of
from oracles.solids import parts_gap
from oracles.voxels import KINDS, filled_cells

from drake_geom_ros.cross_check.bodies import Body
from drake_geom_ros.geometry._proximity.kernels.calling import pairs as calling
from drake_geom_ros.geometry._proximity.kinds import SOLID
from drake_geom_ros.geometry._proximity.tolerances import EPS
from truth.bodies.grids import surface
from truth.bodies.random_bodies import random_rotation

SEEDS = 6 if config.DISABLE_JIT else 60


def of_cells(cells, lines, p=(0.0, 0.0, 0.0)):
    """A union of cells between lines, as a body and as the boxes that it is made of."""
    cells = [tuple(cell) for cell in cells]
    vertices, triangles = surface(cells, lines)
    boxes = []
    for cell in cells:
        low, high = (np.array([lines[k][cell[k] + i] for k in range(3)]) for i in (0, 1))
        boxes.append(Body('Box', tuple(high - low), p=0.5 * (low + high)))
    at = np.array(p, dtype=float)
    return Body('Solid', vertices, p=at, triangles=triangles, parts=tuple(boxes))


def check(A, B, out, size=10.0):
    """Check an answer against the boxes: how far apart, how deep at least, and the way out."""
    distance, bound = out[calling.DISTANCE], out[calling.ERROR_BOUND]
    gap, off = parts_gap(A, B)
    slack = off + 200 * EPS * size
    if gap >= -slack:
        assert abs(distance - gap) <= bound + slack
        return False
    assert distance - bound <= gap + slack
    moved, off = parts_gap(A.at(A.p - distance * out[1:4]), B)
    assert moved >= -off - 200 * EPS * size
    return True


L = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]


@pytest.mark.parametrize('thin', [0.2, 0.01, 1e-6])
def test_a_body_whose_surface_runs_close_around_a_cavity(thin):
    """What is inside it is in the cavity, what is inside the wall far off: its surface tells."""
    cavity = {(x + 1, y + 1, 1) for x, y, _ in L}
    block = [cell for cell in np.ndindex(4, 4, 3) if cell not in cavity]
    B = of_cells(block, [np.arange(5.0)] * 3)
    lines = [np.array([1 - thin, 2 + thin, 3 + thin])] * 2 + [np.array([1 - thin, 2 + thin])]
    A = of_cells(L, lines)
    for a, b in ((A, B), (B, A)):
        assert check(a, b, row_of(a, b))
    free = of_cells(L, [np.array([1 + thin, 2 - thin, 3 - thin])] * 2 + [np.array([1.1, 1.9])])
    assert row_of(free, B)[0] == pytest.approx(min(thin, 0.1), abs=1e-13)


@pytest.mark.parametrize('n', [4, 6] if config.DISABLE_JIT else [6, 24])
@pytest.mark.parametrize('corner', list(itertools.product((1, -2), repeat=2)))
def test_a_bump_beneath_a_slab_that_lies_flush(n, corner):
    """Thousands of triangles touch, and only those of the bump are in the other body."""
    lines = [np.arange(n + 3.0)] * 3
    slab = [(x, y, 0) for x, y in np.ndindex(n, n)]
    at = tuple(k % n for k in corner)
    A = of_cells([*slab, *((x, y, 1) for x, y, _ in slab), (0, 0, 2)], lines, [0, 0, 1])
    B = of_cells([*slab, (*at, 1)], lines)
    assert kernel_form(A)[0] == kernel_form(B)[0] == SOLID
    out = row_of(A, B)
    assert out[calling.DISTANCE] == pytest.approx(-1.0, abs=1e-11)
    assert out[calling.ERROR_BOUND] <= 1e-11
    beneath = of_cells([*((x, y, 1) for x, y, _ in slab), (0, 0, 0)], lines, [0, 0, -1])
    assert row_of(A, beneath)[0] == pytest.approx(0.0, abs=1e-11)


@pytest.mark.parametrize('turned', [False, True])
def test_cells_of_grids_in_one_another(turned):
    """On lattices of both, half-way between, a hair off them, and anywhere."""
    overlapping = apart = 0
    for seed in range(SEEDS):
        rng = np.random.default_rng([seed, turned])
        bodies = []
        for scale in (1.0, rng.choice([1.0, 0.5, 1.5, 0.3])):
            filled = filled_cells(rng, KINDS[rng.integers(len(KINDS))], int(rng.integers(2, 5)))
            lines = [scale * np.arange(len(filled) + 1.0)] * 3
            bodies.append(of_cells(np.argwhere(filled).tolist(), lines))
        A, B = bodies
        if kernel_form(A)[0] != SOLID or kernel_form(B)[0] != SOLID:
            continue
        step = rng.integers(-2, 5, 3) * rng.choice([1.0, 0.5]) + rng.choice(
            [0, 0, 1e-9, 1e-3, 0.3]
        )
        A = A.at(step * rng.choice([1.0, -1.0]))
        if turned:
            R = random_rotation(rng)
            A, B = (body.moved(R, HERE) for body in (A, B))
        if check(A, B, row_of(A, B)):
            overlapping += 1
        else:
            apart += 1
    assert overlapping
    assert apart


ON_AXES = {'as they are': np.eye(3), 'axes in a ring': np.roll(np.eye(3), 1, axis=0)}
SLOT = [(0, 0, 0), (0, 1, 0), (1, 0, 0), (2, 0, 0), (2, 1, 0)]
CAP_AND_STEM = [(0, 1, 0), (1, 1, 0), (2, 1, 0), (1, 0, 0)]


def slot_and_block(more, origin, unit=1.0):
    """A U and a T whose stem, wider by ``more``, goes into its slot down to the floor."""
    at = np.array(origin)
    lines = [unit * np.array([0, 1, 2, 3.0]), unit * np.array([0, 1, 2.0]), unit * np.arange(2.0)]
    low = [unit * 0.5, unit, 2.0 * unit + more, 2.5 * unit + more]
    other = [np.array(low), unit * np.array([1, 2, 2.5]), lines[2]]
    return (
        of_cells(CAP_AND_STEM, [x + y for x, y in zip(other, at, strict=True)]),
        of_cells(SLOT, [x + y for x, y in zip(lines, at, strict=True)]),
    )


@pytest.mark.parametrize('turn', ON_AXES)
@pytest.mark.parametrize(
    ('more', 'origin'),
    [
        (2.0**-50, (0.0, 0.0, 0.0)),
        (1e-12, (0.0, 0.0, 0.0)),
        (1e-9, (0.0, 0.0, 0.0)),
        (2.0**-30, (5e5, 4e6, 0.0)),  # one spacing of floats there
        (2.0**-7, (5e5, 4e6, 0.0)),
    ],
)
def test_a_block_too_wide_for_its_slot_by_the_last_bit(turn, more, origin):
    """All other walls are flush: the only way out is up, however little it is too wide."""
    A, B = slot_and_block(more, origin)
    R = ON_AXES[turn]
    A, B = (body.moved(R, HERE) for body in (A, B))
    size = 1e-12 * max(1.0, *np.abs(origin))
    for a, b in ((A, B), (B, A)):
        out = row_of(a, b)
        assert out[calling.DISTANCE] == pytest.approx(-1.0, abs=size)
    fits, B = slot_and_block(0.0, origin)
    fits, B = (body.moved(R, HERE) for body in (fits, B))
    for a, b in ((fits, B), (B, fits)):
        out = row_of(a, b)
        assert out[calling.DISTANCE] == pytest.approx(0.0, abs=size)
        assert out[calling.ERROR_BOUND] <= size


@pytest.mark.parametrize('kind', ['Box', 'Convex'])
@pytest.mark.parametrize(('more', 'truth'), [(2.0**-51, -1.0), (1e-13, -1.0), (0.0, 0.0)])
def test_a_box_too_wide_for_its_slot_by_the_last_bit(kind, more, truth):
    B = slot_and_block(0.0, HERE)[1]
    half = 0.5 * np.array([1.0 + more, 1.0, 1.0])
    at = np.array([1.0, 1.0, 0.0]) + half
    if kind == 'Box':
        A = Body('Box', tuple(2.0 * half), p=at)
    else:
        A = Body('Convex', at + half * (2.0 * np.array(list(np.ndindex(2, 2, 2))) - 1.0))
    out = row_of(A, B)
    assert out[calling.DISTANCE] == pytest.approx(truth, abs=1e-12)
    assert (out[calling.ERROR_BOUND] <= 1e-12) or truth


@pytest.mark.parametrize(
    ('thin', 'origin'),
    [
        (2.0**-29, (0.0, 0.0, 0.0)),
        (2.0**-7, (0.0, 0.0, 0.0)),
        (2.0**-7, (5e5, 4e6, 0.0)),
        (2.0**-20, (5e5, 4e6, 0.0)),
    ],
)
def test_a_sheet_that_fills_its_slot_touches(thin, origin):
    """Of 1.9e-9 m and of 8 mm: no wall of the slot is crossed, and none is cleared."""
    x, y, z = origin
    lines = [x + np.array([0, 1, 1 + thin, 2 + thin]), y + np.arange(3.0), z + np.arange(2.0)]
    other = [x + np.array([0.5, 1, 1 + thin, 1.5 + thin]), y + np.array([1, 2, 2.5]), lines[2]]
    A, B = of_cells(CAP_AND_STEM, other), of_cells(SLOT, lines)
    for a, b in ((A, B), (B, A)):
        out = row_of(a, b)
        assert out[calling.DISTANCE] == pytest.approx(0.0, abs=1e-13 * max(1.0, y))
        assert out[calling.ERROR_BOUND] <= 1e-13 * max(1.0, y)


@pytest.mark.parametrize(
    ('unit', 'origin', 'deep'),
    [
        (1.0, (0.0, 0.0, 0.0), 3e-9),
        (1e4, (0.0, 0.0, 0.0), 3e-5),
        (2.0, (5e5, 4e6, 0.0), 2.0**-7),
        (1.0, (0.0, 0.0, 0.0), 2.0**-40),
    ],
)
@pytest.mark.parametrize('face', range(6))
def test_prisms_with_walls_in_line_that_overlap_a_little(unit, origin, deep, face):
    lines = [unit * np.arange(4.0) + x for x in origin]
    A, B = of_cells(L, lines), of_cells(L, lines)
    axis, sign = face // 2, 1.0 - 2.0 * (face % 2)
    step = np.zeros(3)
    step[axis] = sign * ((2.0 if axis < 2 else 1.0) * unit - deep)
    out = row_of(A.at(step), B)
    assert abs(out[calling.DISTANCE] + deep) <= out[calling.ERROR_BOUND]
    assert out[calling.DISTANCE] < -0.5 * deep
