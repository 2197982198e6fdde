"""Points that are shared out to threads are answered as by one, to the bit."""

import tracemalloc

import numpy as np
import pytest
from batch.floating_bodies import Floating
from batch.test_evaluation import same
from oracles.solids import surface_of

from drake_geom_ros.batch import evaluate
from drake_geom_ros.geometry import Box, Cylinder, FramePoseVector, Mesh, Sphere
from drake_geom_ros.geometry._proximity.kernels.calling.points import POINT_WIDTH
from drake_geom_ros.geometry._proximity.kinds import SPHERE
from drake_geom_ros.geometry._proximity.points import point_query, sharing
from drake_geom_ros.geometry._proximity.runtime.threads import THREADS
from drake_geom_ros.geometry._proximity.states import state_loops
from drake_geom_ros.geometry._proximity.world.world import PointShapes

MANY = 5000


@pytest.fixture(scope='module')
def bodies():
    """A solid among others."""
    solid = Mesh.FromMeshData(surface_of('ring', cuts=2), 0.2)
    return Floating([Sphere(0.1), solid, Box(0.1, 0.2, 0.3), Cylinder(0.1, 0.2)])


def points():
    """Points in the cube of 2 m."""
    return np.random.default_rng(1).uniform(-1, 1, (MANY, 3))


def posed(bodies):
    """Return a query of the bodies somewhere in the cube of 1 m."""
    context = bodies.graph.CreateDefaultContext()
    ids = np.array([frame.get_value() for frame in bodies.ids])
    poses = bodies.states(np.random.default_rng(2), 1, 0.5)[0]
    context.UpdateFramePoses(FramePoseVector.FromArrays(ids, poses))
    return bodies.graph.get_query_output_port().Eval(context)


@pytest.mark.parametrize(
    ('threshold', 'block'), [(np.inf, 1), (0.2, 1), (0.2, 999), (0.2, 10**6), (-1.0, 999)]
)
def test_a_query_in_blocks_and_threads_is_that_of_one_call(bodies, threshold, block, monkeypatch):
    monkeypatch.setattr(sharing, 'ROWS_A_BLOCK', block)
    query = posed(bodies)
    shared = query.ComputeSignedDistanceToPoint(points(), threshold)
    told = query.effects()
    for module in (point_query, state_loops):
        monkeypatch.setattr(module, 'is_worth_sharing', lambda each, count: False)
    alone = query.ComputeSignedDistanceToPoint(points(), threshold)
    for column in ('id_G', 'point_index', 'distance', 'error_bound', 'grad_W', 'p_GN', 'method'):
        np.testing.assert_array_equal(getattr(shared, column), getattr(alone, column))
    assert len(shared) == (4 * MANY if np.isinf(threshold) else len(alone))
    assert told.pairs_by_method == query.effects().pairs_by_method
    assert told.far_pairs == query.effects().far_pairs


def test_a_threshold_bounds_the_memory_by_what_is_near(bodies):
    query = posed(bodies)
    p_WQs = np.random.default_rng(4).uniform(-50, 50, (200_000, 3))
    tracemalloc.start()
    try:
        found = len(query.ComputeSignedDistanceToPoint(p_WQs, 0.1))
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert found < 1000
    # The copy of the points, a block a thread and its flags, not 4 rows a point.
    assert peak < 2 * p_WQs.nbytes + THREADS * 200 * sharing.ROWS_A_BLOCK
    assert peak < len(p_WQs) * 4 * 8 * POINT_WIDTH


def arrays_of(results):
    return tuple(value for value in vars(results).values() if isinstance(value, np.ndarray))


@pytest.mark.skipif(THREADS == 1, reason='one thread')
@pytest.mark.parametrize('count', [1, 3])
def test_a_batch_of_few_states_is_that_of_one_thread(bodies, count):
    poses = bodies.states(np.random.default_rng(3), count, 0.5)
    asked = {'want': 'points', 'points': points(), 'max_distance': 0.3}
    shared = evaluate(bodies.graph, bodies.ids, poses, **asked)
    alone = evaluate(bodies.graph, bodies.ids, poses, threads=1, **asked)
    assert same(arrays_of(shared), arrays_of(alone))


@pytest.mark.parametrize(
    ('kinds', 'count', 'worth'), [([SPHERE], 100, False), ([SPHERE], MANY**2, True)]
)
def test_few_points_are_not_worth_it(kinds, count, worth):
    shapes = PointShapes(np.array(kinds), np.array([0, 1]), np.ones(1), frozenset(kinds))
    each = sharing.seconds_a_point(shapes)
    assert sharing.is_worth_sharing(each, count) == worth
