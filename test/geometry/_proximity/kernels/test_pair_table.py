"""Every row of the pair table against the support-function maximum, through the engine.

The poses are those that robots meet: apart, 2 mm apart, touching, 2 cm deep, deep and contained;
the offsets from the world's origin and the scales are those that NUMERICS promises. The figure in
each row of the table is the worst error allowed here, for bodies of about 0.2 m.
"""

import functools
import math

import numpy as np
import pytest
from oracles import closed_forms
from oracles.forms import body, signed_distance
from oracles.pairs import check_row
from oracles.worlds import (
    geometry_table,
    random_parameters,
    random_rotations,
    scaled_parameters,
)

from drake_geom_ros.geometry import ACCURACY_GAPS, ACCURACY_LEVELS
from drake_geom_ros.geometry._proximity.engine.engine import Engine
from drake_geom_ros.geometry._proximity.kernels.calling.pairs import (
    DISTANCE,
    ERROR_BOUND,
    NORMAL,
)
from drake_geom_ros.geometry._proximity.kernels.pair_table import (
    ALL_ROWS,
    MAP_TABLE,
    PAIR_TABLE,
    SHAPE_NAMES,
    SOLID_TABLE,
)
from drake_geom_ros.geometry._proximity.kinds import (
    BOX,
    CLOSED_FORM,
    CONVEX,
    OCCUPIED_CELLS,
    POINT_CLOUD,
    SOLID,
    SPHERE,
)
from drake_geom_ros.geometry._proximity.tolerances import EPS, GAPS_OF_LEVELS
from drake_geom_ros.geometry._proximity.world.world import FrameTable, World
from truth.judging.asking import PairScene

ORACLE = 1e-12  # what the oracle, a search over directions, may be off by [m]
DISTANCES = (0.2, 2e-3, 0.0, -2e-3, -0.02, -0.08)
SCALES = (1e-3, 1.0, 1e3)
OFFSETS = (1e3, 1e6)
ROWS = [
    pytest.param(row, id=f'{SHAPE_NAMES[row.type_a]}-{SHAPE_NAMES[row.type_b]}')
    for row in PAIR_TABLE
]


def pair_world(row, sizes, Rs, ps):
    """Return a world of the row's two shapes at poses Rs (2, 3, 3), ps (2, 3)."""
    frames = FrameTable(np.arange(1, 4), np.zeros(3, dtype=np.int64))
    world = World(frames, geometry_table([1, 2], [row.type_a, row.type_b], sizes))
    world.set_poses(np.array([1, 2]), Rs, np.asarray(ps))
    world.update()
    return world


def answer(world, accuracy='exact'):
    """Return the result row of the world's only pair."""
    pair = np.array([[0, 1]])
    return Engine().distance_of_pair(world, pair, GAPS_OF_LEVELS[accuracy]).rows[0]


def public_answer(row, sizes, Rs, ps):
    """Return the record that a user of the package gets for the row's two shapes."""
    forms = zip((row.type_a, row.type_b), sizes, strict=True)
    scene = PairScene(*map(body, forms, Rs, ps))
    return scene.query.ComputeSignedDistancePairClosestPoints(*scene.ids)


@functools.cache
def cases(row):
    """Return sizes, rotations, positions and the truth of pairs about DISTANCES apart.

    One more has its origins 1 cm apart, so that one body contains the other, or nearly.
    """
    rng = np.random.default_rng(1)
    found = []
    for wanted in (*DISTANCES, None):
        kinds = (row.type_a, row.type_b)
        sizes = [random_parameters(rng, t) for t in kinds]
        shapes = list(zip(kinds, sizes, strict=True))
        Rs = random_rotations(rng, 2)
        direction = rng.normal(size=3)
        ps = np.array([[0.0, 0.0, 0.0], direction / np.linalg.norm(direction)])
        # Slide B along the normal until it is about as far as wanted. The engine says where that
        # is, for it is quick; how far it is indeed, the oracle says.
        guess = answer(pair_world(row, sizes, Rs, ps))
        if wanted is None:
            ps[1] *= 0.01
        else:
            ps[1] += (guess[DISTANCE] - wanted) * guess[NORMAL : NORMAL + 3]
        # On a grid that float64 holds far from the origin too.
        ps[1] = np.round(ps[1] * 2**20) / 2**20
        phi, _ = signed_distance(shapes[0], (Rs[0], ps[0]), shapes[1], (Rs[1], ps[1]))
        found.append((sizes, Rs, ps, phi))
    return found


@pytest.mark.parametrize('scale', SCALES)
@pytest.mark.parametrize('row', ROWS)
def test_error_and_certificate(row, scale):
    for sizes, Rs, ps, phi in cases(row):
        kinds = (row.type_a, row.type_b)
        scaled = [scaled_parameters(t, s, scale) for t, s in zip(kinds, sizes, strict=True)]
        result = answer(pair_world(row, scaled, Rs, scale * ps))
        error = abs(result[DISTANCE] - scale * phi)
        assert error <= max(row.worst_error, ORACLE) * scale
        assert error <= result[ERROR_BOUND] + ORACLE * scale
        check_row(result, 1e-13 * scale)


@pytest.mark.parametrize(
    'row', [r for r in PAIR_TABLE if r.method == CLOSED_FORM and r.type_b != CONVEX]
)
def test_closed_forms_against_fifty_digits(row):
    for (size_A, size_B), (R_WA, R_WB), (p_WA, p_WB), _ in cases(row):
        truth = closed_forms.signed_distance(
            row.type_a, size_A, R_WA, row.type_b, size_B, R_WB, p_WB - p_WA
        )
        result = answer(pair_world(row, [size_A, size_B], np.array([R_WA, R_WB]), [p_WA, p_WB]))
        assert abs(result[DISTANCE] - float(truth)) <= row.worst_error


@pytest.mark.parametrize('offset', OFFSETS)
@pytest.mark.parametrize('scale', SCALES)
@pytest.mark.parametrize('row', ROWS)
def test_far_from_the_origin(row, scale, offset):
    kinds = row.type_a, row.type_b
    for sizes, Rs, ps, phi in cases(row):
        scaled = [scaled_parameters(t, s, scale) for t, s in zip(kinds, sizes, strict=True)]
        near = answer(pair_world(row, scaled, Rs, scale * ps))
        away = scale * ps + np.array([offset, -offset, offset])
        far = answer(pair_world(row, scaled, Rs, away))
        assert abs(far[DISTANCE] - scale * phi) <= far[ERROR_BOUND] + ORACLE * scale
        # The bounds of an iteration are no tighter than it was asked for, far or near.
        asked = 1e-9 * min(scale, 1.0) if row.method != CLOSED_FORM else 0.0
        assert far[ERROR_BOUND] <= near[ERROR_BOUND] + asked + 32 * EPS * offset


PRIMITIVES = [r for r in PAIR_TABLE if CONVEX not in (r.type_a, r.type_b)]


@pytest.mark.parametrize('offset', [0.0, *OFFSETS])
@pytest.mark.parametrize('row', PRIMITIVES)
def test_the_public_query_near_and_far(row, offset):
    for sizes, Rs, ps, phi in cases(row):
        away = ps + np.array([offset, -offset, offset])
        pair = public_answer(row, sizes, Rs, away)
        assert abs(pair.distance - phi) <= pair.error_bound + ORACLE
        assert pair.error_bound <= 1e-9 + 32 * EPS * offset


@pytest.mark.parametrize('level', ACCURACY_LEVELS)
@pytest.mark.parametrize('row', ROWS)
def test_the_certificate_of_every_level_contains_the_truth(row, level):
    for sizes, Rs, ps, phi in cases(row):
        result = answer(pair_world(row, sizes, Rs, ps), level)
        assert abs(result[DISTANCE] - phi) <= result[ERROR_BOUND] + ORACLE
        assert result[ERROR_BOUND] <= ACCURACY_GAPS.get(level, math.inf)


def test_the_table_holds_every_pair_but_two_half_spaces():
    pairs = {(row.type_a, row.type_b) for row in PAIR_TABLE}
    # Those of meshes and of sensed maps stand in tables of their own.
    kinds = [t for t in SHAPE_NAMES if t < SOLID]
    expected = {(a, b) for a in kinds for b in kinds if a <= b} - {(6, 6)}
    assert pairs == expected
    pairs |= {(row.type_a, row.type_b) for row in (*SOLID_TABLE, *MAP_TABLE)}
    assert pairs == {(a, b) for a in SHAPE_NAMES for b in SHAPE_NAMES if a <= b} - {(6, 6)}


def test_a_map_is_answered_for_by_the_kernel_of_its_cell():
    of_pair = {(row.type_a, row.type_b): row.kernel for row in ALL_ROWS}
    cell = {OCCUPIED_CELLS: BOX, POINT_CLOUD: SPHERE}
    for row in MAP_TABLE:
        leaf = tuple(sorted(cell.get(kind, kind) for kind in (row.type_a, row.type_b)))
        assert row.is_of_map
        assert row.kernel == of_pair[leaf]


def test_worst_errors_are_powers_of_ten_and_as_small_as_promised():
    for row in PAIR_TABLE:
        digits = -math.log10(row.worst_error)
        assert digits == pytest.approx(round(digits), abs=1e-12)
        assert 10 <= digits <= 14
