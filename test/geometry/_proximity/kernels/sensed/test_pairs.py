"""Distances of sensed maps against all their cells one by one, and depths that are known."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles.sensed_maps import KINDS, awkward_maps, grid, nearest_of_all
from oracles.shape_scenes import SHAPES, ShapeScene

from drake_geom_ros.geometry import Box, Cylinder, HalfSpace, OccupiedCells, PointCloud, Sphere
from drake_geom_ros.geometry._proximity.kinds import OPEN
from drake_geom_ros.math import RigidTransform, RotationMatrix
from truth.bodies.random_bodies import random_rotation

MAPS = awkward_maps(np.random.default_rng(1))


def random_pose(rng, reach):
    return RigidTransform(RotationMatrix(random_rotation(rng)), rng.uniform(-reach, reach, 3))


def check_row(found, shape=None):
    """Hold what every answer promises."""
    (a, b), n = (found.p_WCa[0], found.p_WCb[0]), found.nhat_BA_W[0]
    assert np.isfinite(found.distance[0])
    assert np.linalg.norm(n) == pytest.approx(1.0, abs=1e-12)
    size = 1.0 + np.abs(a).max() + np.abs(found.distance[0])
    assert np.abs(a - b - found.distance[0] * n).max() <= 1e-12 * size


@pytest.mark.parametrize('body', SHAPES)
@pytest.mark.parametrize('kind', KINDS)
def test_the_nearest_cell_is_that_of_all_one_by_one(kind, body):
    rng = np.random.default_rng(len(body))
    for number, name in enumerate(MAPS):
        edge = (1e-3, 0.1, 1e3)[number % 3] if kind is OccupiedCells else 10.0 ** (number % 7 - 3)
        shape, other = kind(edge, edge * MAPS[name]), SHAPES[body]
        reach = 0.4 + edge * (1.0 + np.abs(MAPS[name]).max())
        scene = ShapeScene(shape, other)
        for _ in range(3):
            X_WM, X_WB = random_pose(rng, reach), random_pose(rng, reach)
            found = scene.posed(X_WM, X_WB).query.signed_distance_of_pair(*scene.ids)
            check_row(found)
            truth, bound = nearest_of_all(shape, X_WM, other, X_WB)
            slack = found.error_bound[0] + bound
            if truth > 0.0 or body == 'half_space':
                assert found.distance[0] == pytest.approx(truth, abs=slack)
                assert slack <= 1e-11 * (reach + 1.0)
            else:
                # No way out is shorter than out of the deepest cell.
                assert found.distance[0] - found.error_bound[0] <= truth + bound
                assert found.distance[0] <= truth + slack


@pytest.mark.parametrize('kind', KINDS)
@pytest.mark.parametrize('body', [name for name in SHAPES if name != 'half_space'])
def test_what_is_told_as_a_way_out_parts_the_bodies(kind, body):
    """Moved by its depth along the normal, and a hair, the body touches no cell at all."""
    rng = np.random.default_rng(3)
    shape, other = kind(0.08, 0.1 * MAPS['shell']), SHAPES[body]
    scene, deep = ShapeScene(other, shape), 0
    for _ in range(12):
        X_WB = random_pose(rng, 0.25)
        found = scene.posed(X_WB, RigidTransform()).query.signed_distance_of_pair(*scene.ids)
        if found.distance[0] >= 0.0:
            continue
        deep += 1
        check_row(found)
        step = (1e-9 - found.distance[0]) * found.nhat_BA_W[0]
        if found.method[0] != OPEN:
            step *= 1.0 + 1e-9
        moved = RigidTransform(X_WB.rotation(), X_WB.translation() + step)
        truth, bound = nearest_of_all(shape, RigidTransform(), other, moved)
        assert truth >= -bound
    assert deep >= 6


def test_a_block_of_touching_cells_is_as_deep_as_the_box_that_it_fills():
    rng = np.random.default_rng(4)
    block, whole = OccupiedCells(0.1, 0.1 * grid(4, 5, 6)), Box(0.4, 0.5, 0.6)
    for body in (Sphere(0.1), Box(0.3, 0.2, 0.1)):
        cells, box = ShapeScene(body, block), ShapeScene(body, whole)
        for _ in range(10):
            X_WB = random_pose(rng, 0.3)
            truth = box.posed(X_WB, RigidTransform()).pair(X_WB, RigidTransform()).distance
            cells.posed(X_WB, RigidTransform())
            found = cells.query.signed_distance_of_pair(*cells.ids)
            assert abs(found.distance[0] - truth) <= found.error_bound[0] + 1e-12
            assert (found.distance[0] < 0.0) == (truth < 0.0)


@pytest.mark.parametrize('kind', KINDS)
@pytest.mark.parametrize('body', SHAPES)
def test_a_contact_is_found_without_a_depth_where_there_is_one(kind, body):
    rng, found = np.random.default_rng(12), {True: 0, False: 0}
    shape = kind(0.08, 0.1 * MAPS['shell'])
    decided, deep = ShapeScene(SHAPES[body], shape), ShapeScene(SHAPES[body], shape)
    for _ in range(20):
        poses = random_pose(rng, 0.45), random_pose(rng, 0.45)
        collides = decided.posed(*poses).query.HasCollisions()
        assert collides == bool(len(deep.posed(*poses).query.ComputePointPairPenetration()))
        # What was decided without a depth leaves no answer to the pair itself.
        rows = [scene.query.signed_distance_of_pair(*scene.ids) for scene in (decided, deep)]
        assert rows[0].distance[0] == rows[1].distance[0]
        assert rows[0].error_bound[0] == rows[1].error_bound[0]
        found[collides] += 1
    assert min(found.values()) >= 3


@pytest.mark.parametrize('is_map_first', [False, True])
def test_a_negative_cutoff_asks_for_depth_of_the_union(is_map_first):
    """A body within many small cells is deep in the block, and in each of them a little."""
    rng = np.random.default_rng(7)
    block, whole = OccupiedCells(0.05, 0.05 * grid(8, 10, 12)), Box(0.4, 0.5, 0.6)
    told = {True: 0, False: 0}
    for body in (Sphere(0.1), Box(0.3, 0.2, 0.1)):
        cells, box = (
            ShapeScene(*((shape, body) if is_map_first else (body, shape)))
            for shape in (block, whole)
        )
        for _ in range(8):
            poses = [random_pose(rng, 0.25), RigidTransform()][:: -1 if is_map_first else 1]
            truth = box.posed(*poses).query.signed_distance_of_pair(*box.ids).distance[0]
            cells.posed(*poses)
            for cutoff in (-0.02, -0.06, -0.15, -0.3):
                if abs(truth - cutoff) < 1e-6:
                    continue
                found = cells.query.ComputeSignedDistancePairwiseClosestPoints(cutoff)
                assert len(found) or truth > cutoff
                if len(found):
                    assert abs(found.distance[0] - truth) <= found.error_bound[0] + 1e-12
                told[bool(len(found))] += 1
    assert min(told.values()) >= 10


@pytest.mark.parametrize('kind', KINDS)
def test_points_are_answered_one_by_one_as_together(kind):
    rng = np.random.default_rng(8)
    scene = ShapeScene(kind(0.05, 0.05 * grid(4, 5, 6)))
    scene.posed(random_pose(rng, 0.3))
    p_WQs = np.concatenate((rng.uniform(-0.4, 0.4, (60, 3)), [[1e6, 0.0, 0.0]]))
    for threshold in (np.inf, 0.1, 0.0, -0.01, -0.06):
        together = _of_points(scene, p_WQs, threshold)
        alone = [_of_points(scene, p_WQ[np.newaxis], threshold) for p_WQ in p_WQs]
        assert together == [row for rows in alone for row in rows]
        assert together or threshold < 0.0


def _of_points(scene, p_WQs, threshold):
    found = scene.query.ComputeSignedDistanceToPoint(p_WQs, threshold)
    columns = found.distance, found.error_bound, found.p_GN, found.grad_W, found.method
    return [*zip(*(column.tolist() for column in columns), strict=True)]


def test_points_deep_in_a_block_of_cells_are_found_by_a_negative_threshold():
    rng = np.random.default_rng(9)
    block, whole = OccupiedCells(0.05, 0.05 * grid(8, 8, 8)), Box(0.4, 0.4, 0.4)
    cells, box = ShapeScene(block), ShapeScene(whole)
    for scene in (cells, box):
        scene.posed(RigidTransform())
    deep = 0
    for p_WQ in rng.uniform(-0.2, 0.2, (60, 3)):
        for threshold in (-0.03, -0.08, -0.15):
            truth = box.query.ComputeSignedDistanceToPoint(p_WQ, threshold)
            found = cells.query.ComputeSignedDistanceToPoint(p_WQ, threshold)
            deep += len(truth)
            assert len(found) >= len(truth)
            if len(found) and len(truth):
                slack = found.error_bound[0] + 1e-12
                assert abs(found.distance[0] - truth.distance[0]) <= slack
    assert deep >= 20


@pytest.mark.parametrize('offset', [0.0, 1e-3, 1.0, 700.0])
def test_what_fits_exactly_into_a_gap_of_cells_does_not_collide(offset):
    """A slot as wide as the box in it: touching, with a way out that is long."""
    walls = grid(9, 9, 9)
    walls = walls[(np.abs(walls) > 1.5).any(axis=1)]  # a hollow of 3 x 3 x 3 cells
    R = RotationMatrix(random_rotation(np.random.default_rng(10)))
    for X in (RigidTransform([offset, 0, 0]), RigidTransform(R, [offset, -offset, 0])):
        scene = ShapeScene(OccupiedCells(0.1, 0.1 * walls), Box(0.3, 0.3, 0.3)).posed(X, X)
        found = scene.query.signed_distance_of_pair(*scene.ids)
        # Cells at multiples of 0.1 are off by rounding, and so are the faces.
        assert abs(found.distance[0]) <= 1e-15 * (1.0 + 4.0 * abs(offset)) or (
            found.distance[0] - found.error_bound[0] <= 0.0
        )
        assert found.distance[0] + found.error_bound[0] >= 0.0


def test_a_ball_that_lies_on_a_plane_of_cells_touches_it():
    plane = OccupiedCells(0.1, 0.1 * grid(8, 8, 1))
    scene = ShapeScene(plane, Sphere(0.1))
    for x in (0.0, 0.05, 0.1234):  # on a corner of four cells, within one, on a border of two
        found = scene.posed([0, 0, 0], [x, 0.0, 0.15]).query.signed_distance_of_pair(*scene.ids)
        assert found.distance[0] == pytest.approx(0.0, abs=found.error_bound[0])
        assert found.nhat_BA_W[0] == pytest.approx([0.0, 0.0, -1.0], abs=1e-9)
        assert not scene.query.HasCollisions()
    # A face that lies flush is pushed out along its normal, whatever cells are under it.
    scene = ShapeScene(plane, Box(0.33, 0.33, 0.2))
    found = scene.posed([0, 0, 0], [0.01, 0.02, 0.14]).query.signed_distance_of_pair(*scene.ids)
    assert found.distance[0] == pytest.approx(-0.01, abs=found.error_bound[0])
    assert found.error_bound[0] <= 1e-13
    assert found.nhat_BA_W[0] == pytest.approx([0.0, 0.0, -1.0], abs=1e-9)


@pytest.mark.parametrize('body', [Box(0.33, 0.33, 0.2), Cylinder(0.2, 0.2)])
def test_of_a_floor_below_a_flush_face_the_least_cell_is_told(body):
    """All cells are as near, and only some are asked; between two floors no normal is the one."""
    rng, floor = np.random.default_rng(11), 0.1 * grid(8, 8, 1)
    both = np.concatenate((floor, floor + np.array([0.0, 0.0, 0.8])))
    for height, centres in ((0.4, floor), (0.4, both), (0.3, both)):
        told = []
        for order in (centres, rng.permutation(centres)):
            scene = ShapeScene(OccupiedCells(0.1, order), body)
            found = scene.posed([0, 0, 0], [0.01, 0.02, height]).query.signed_distance_of_pair(
                *scene.ids
            )
            assert found.distance[0] == pytest.approx(height - 0.15, abs=1e-14)
            assert found.error_bound[0] <= 1e-13
            assert found.is_nhat_BA_W_unique[0] == (centres is floor or height < 0.4)
            told.append(
                [found.distance.tolist(), found.p_WCa.tolist(), found.error_bound.tolist()]
            )
        assert told[0] == told[1]


def test_half_spaces_meet_the_lowest_cell():
    for shape in (OccupiedCells(0.2, MAPS['random']), PointCloud(0.1, MAPS['random'])):
        scene = ShapeScene(shape, anchored=[(HalfSpace(), RigidTransform())])
        for height in (5.0, 3.0, 0.0, -9.0):
            found = scene.posed([0, 0, height]).query.ComputeSignedDistancePairwiseClosestPoints()
            lowest = MAPS['random'][:, 2].min() + height - 0.1
            assert found.distance[0] == pytest.approx(lowest, abs=1e-12)
            assert found.error_bound[0] <= 1e-12


@pytest.mark.parametrize('kinds', [(a, b) for a in KINDS for b in KINDS])
def test_two_maps_walk_both_trees(kinds):
    rng = np.random.default_rng(6)
    A = kinds[0](0.1, 0.1 * MAPS['random'])
    B = kinds[1](0.07, 0.1 * MAPS['shell'])
    scene = ShapeScene(A, B)
    for _ in range(6):
        X_WA, X_WB = random_pose(rng, 0.6), random_pose(rng, 0.6)
        found = scene.posed(X_WA, X_WB).query.signed_distance_of_pair(*scene.ids)
        check_row(found)
        each = [
            nearest_of_all(A, X_WA, type(cell)(*args), X_WB @ RigidTransform(centre))
            for cell, args, centre in _cells(B)
        ]
        truth, bound = min(each)
        slack = found.error_bound[0] + bound + 1e-13
        if truth > 0.0:
            assert found.distance[0] == pytest.approx(truth, abs=slack)
        else:
            assert found.distance[0] - slack <= truth


def _cells(shape):
    if isinstance(shape, OccupiedCells):
        return [(Box(1, 1, 1), 3 * [shape.resolution()], c) for c in shape.centres()]
    return [(Sphere(1), [shape.radius()], c) for c in shape.positions()]


numbers = st.floats(-1.0, 1.0)
maps = st.tuples(
    st.sampled_from(KINDS),
    st.lists(st.tuples(numbers, numbers, numbers), min_size=1, max_size=12),
    st.sampled_from([1e-3, 0.1, 0.5]),
)


@settings(max_examples=40)
@given(
    maps, st.sampled_from(sorted(set(SHAPES) - {'half_space'})), st.randoms(use_true_random=False)
)
def test_laws(map_given, name, random):
    kind, centres, size = map_given
    rng = np.random.default_rng(random.randrange(2**32))
    shape, body = kind(size, centres), SHAPES[name]
    X_WM, X_WB, X = (random_pose(rng, 1.0) for _ in range(3))
    found = _distance(shape, X_WM, body, X_WB)
    check_row(found)
    # The order of cells decides no digit, not even of those at one place of the tree's curve.
    shuffled = kind(size, rng.permutation(np.array(centres)))
    again = _distance(shuffled, X_WM, body, X_WB)
    for field in ('distance', 'error_bound', 'nhat_BA_W', 'p_WCa', 'p_WCb', 'method'):
        assert getattr(again, field).tolist() == getattr(found, field).tolist()
    for other in (_distance(body, X_WB, shape, X_WM), _distance(shape, X @ X_WM, body, X @ X_WB)):
        slack = 1e-12 + found.error_bound[0] + other.error_bound[0]
        assert other.distance[0] == pytest.approx(found.distance[0], abs=slack)
    bound = _distance(shape, X_WM, body, X_WB, accuracy='bound')
    assert bound.distance[0] - bound.error_bound[0] <= found.distance[0] + found.error_bound[0]
    assert bound.distance[0] + bound.error_bound[0] >= found.distance[0] - found.error_bound[0]


def _distance(A, X_WA, B, X_WB, **options):
    scene = ShapeScene(A, B).posed(X_WA, X_WB)
    return scene.query.signed_distance_of_pair(*scene.ids, **options)
