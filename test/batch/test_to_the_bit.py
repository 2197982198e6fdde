"""The law of memory: a batch is, to the bit, what contexts tell that were never asked before.

A context that was asked before tells the same of solids, whatever was asked at other levels; of
other pairs, for which it starts from what it knows, no more differs than the bounds allow.
"""

import math

import numpy as np
import pytest
from batch.floating_bodies import Floating
from batch.test_evaluation import PAIR_COLUMNS
from oracles.solids import surface_of

from drake_geom_ros.batch import evaluate
from drake_geom_ros.geometry import (
    ACCURACY_LEVELS,
    Box,
    Capsule,
    Cylinder,
    Ellipsoid,
    FramePoseVector,
    Mesh,
    Sphere,
)

SAME = 1e-10  # [-] of the size: what two answers of ``exact`` may differ by
LEVELS = [level for level in ACCURACY_LEVELS if level != 'bound']
SOLIDS = [Mesh.FromMeshData(surface_of(name), 0.3) for name in ('L', 'U', 'ring')]
BODIES = [Sphere(0.2), Box(0.3, 0.2, 0.4), Capsule(0.1, 0.4), Cylinder(0.15, 0.3)]
BODIES += [Ellipsoid(0.1, 0.2, 0.3), Cylinder(0.1, 0.5), Ellipsoid(0.25, 0.2, 0.1)]


@pytest.fixture(scope='module')
def scene():
    """Solids among other bodies."""
    return Floating(SOLIDS + BODIES[:5])


def posed(scene, context, poses):
    """Return the query of a context in a state (n, 7)."""
    context.UpdateFramePoses(FramePoseVector.FromArrays(values(scene), poses))
    return scene.graph.get_query_output_port().Eval(context)


def values(scene):
    """Return the id values of the frames."""
    return np.array([frame.get_value() for frame in scene.ids])


def fresh(scene, poses):
    """Return the query of a context that was never asked, in a state (n, 7)."""
    return posed(scene, scene.graph.CreateDefaultContext(), poses)


def rows_of(results):
    """Return all that results tell, as bytes of each row, their gradients too."""
    columns = [np.asarray(getattr(results, name)) for name in PAIR_COLUMNS]
    gradients = [np.concatenate(pair.gradient()) for pair in results]
    columns.append(np.reshape(gradients, (len(results), 12)))
    return [b''.join(column[k].tobytes() for column in columns) for k in range(len(results))]


def rows_of_batch(found, k):
    """Return the same of a state of a batch."""
    rows = range(*found.offsets[k : k + 2])
    columns = [getattr(found, name) for name in PAIR_COLUMNS] + [found.gradient]
    return [b''.join(np.asarray(column[r]).tobytes() for column in columns) for r in rows]


@pytest.mark.parametrize('accuracy', ACCURACY_LEVELS)
@pytest.mark.parametrize('count', [1, 4])
def test_the_nearest_of_solids_are_those_of_fresh_contexts(scene, accuracy, count):
    poses = scene.states(np.random.default_rng(count), 40, 0.9)
    asked = {'frame_ids': scene.ids, 'poses': poses, 'accuracy': accuracy}
    nearest = evaluate(scene.graph, want='nearest', count=count, **asked)
    least = evaluate(scene.graph, want='least', **asked)
    for k, state in enumerate(poses):
        every = fresh(scene, state).ComputeSignedDistancePairwiseClosestPoints(accuracy=accuracy)
        ends = np.array(every.distance) - every.error_bound
        expected = np.array(rows_of(every), dtype=object)[np.argsort(ends, kind='stable')[:count]]
        assert rows_of_batch(nearest, k) == expected.tolist()
        assert least.distance[k] == every.distance[np.argmin(ends)]
        assert least.error_bound[k] == every.error_bound[np.argmin(ends)]


@pytest.mark.parametrize('accuracy', ACCURACY_LEVELS)
def test_how_far_is_looked_changes_no_digit(scene, accuracy):
    poses = scene.states(np.random.default_rng(3), 30, 0.9)
    asked = {'frame_ids': scene.ids, 'poses': poses, 'accuracy': accuracy}
    within = evaluate(scene.graph, want='within', max_distance=0.1, **asked)
    for k, state in enumerate(poses):
        query = fresh(scene, state)
        every = query.ComputeSignedDistancePairwiseClosestPoints(accuracy=accuracy)
        truth = query.ComputeSignedDistancePairwiseClosestPoints(accuracy='exact')
        listed = rows_of_batch(within, k)
        may_be = np.array(every.distance) - every.error_bound <= 0.1
        is_not = np.array(truth.distance) - truth.error_bound > 0.1
        for row, allowed, left_out in zip(rows_of(every), may_be, is_not, strict=True):
            assert (row in listed) <= allowed
            assert row in listed or left_out
        assert len(listed) <= may_be.sum()


def walks(scene, seed, steps=25):
    """Return states (steps, n, 7), each a small step from the one before."""
    rng = np.random.default_rng(seed)
    first, way = scene.states(rng, 2, 0.6)
    shares = 0.02 * np.arange(steps)[:, None, None]
    poses = first + shares * (way - first)
    poses[..., 3:] /= np.linalg.norm(poses[..., 3:], axis=2, keepdims=True)
    return poses


@pytest.mark.parametrize('accuracy', LEVELS)
def test_a_level_answers_as_if_no_other_was_asked(accuracy):
    scene = Floating(BODIES)
    alone, among = scene.graph.CreateDefaultContext(), scene.graph.CreateDefaultContext()
    for state in walks(scene, 4):
        others = posed(scene, among, state)
        for other in ACCURACY_LEVELS:
            if other != accuracy:
                others.ComputeSignedDistancePairwiseClosestPoints(accuracy=other)
        found = others.ComputeSignedDistancePairwiseClosestPoints(accuracy=accuracy)
        never = fresh(scene, state).ComputeSignedDistancePairwiseClosestPoints(accuracy=accuracy)
        assert rows_of(found) == rows_of(never)
        once = posed(scene, alone, state)
        first = once.ComputeSignedDistancePairwiseClosestPoints(accuracy=accuracy)
        for other in ACCURACY_LEVELS:
            once.ComputeSignedDistancePairwiseClosestPoints(accuracy=other)
        again = once.ComputeSignedDistancePairwiseClosestPoints(accuracy=accuracy)
        agree(first, again, accuracy)


@pytest.mark.parametrize('accuracy', LEVELS)
def test_of_solids_a_context_remembers_nothing_that_changes_a_digit(accuracy):
    scene = Floating([*SOLIDS, Sphere(0.2)])
    context = scene.graph.CreateDefaultContext()
    for state in walks(scene, 5, 12):
        query = posed(scene, context, state)
        for reach in (0.05, math.inf):
            asked = {'max_distance': reach, 'accuracy': accuracy}
            found = query.ComputeSignedDistancePairwiseClosestPoints(**asked)
            never = fresh(scene, state).ComputeSignedDistancePairwiseClosestPoints(**asked)
            assert rows_of(found) == rows_of(never)


def agree(one, other, accuracy):
    """Two answers to one question: no farther from each other than both bounds allow."""
    np.testing.assert_array_equal(one.id_A, other.id_A)
    np.testing.assert_array_equal(one.id_B, other.id_B)
    off = np.abs(np.array(one.distance) - other.distance)
    assert (off <= np.array(one.error_bound) + other.error_bound).all()
    if accuracy == 'exact':
        assert (off <= SAME).all()  # of bodies of about 1 m


@pytest.mark.parametrize('accuracy', LEVELS)
def test_two_answers_to_one_question_differ_by_no_more_than_their_bounds(accuracy):
    scene = Floating(BODIES)
    live, other = scene.graph.CreateDefaultContext(), scene.graph.CreateDefaultContext()
    for seed in range(4):
        for k, state in enumerate(walks(scene, seed)):
            asked = {'accuracy': accuracy}
            one = posed(scene, live, state).ComputeSignedDistancePairwiseClosestPoints(**asked)
            query = posed(scene, other, state)
            if k % 3 == 0:  # has seen other states and asked for other things
                query.ComputeSignedDistancePairwiseClosestPoints(0.1)
                two = query.ComputeSignedDistancePairwiseClosestPoints(**asked)
                agree(one, two, accuracy)
            never = fresh(scene, state)
            agree(one, never.ComputeSignedDistancePairwiseClosestPoints(**asked), accuracy)
