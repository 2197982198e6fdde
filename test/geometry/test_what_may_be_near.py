"""A pair or point is left out of what is near only if it is certified to be farther away."""

import numpy as np
import pytest
from batch.floating_bodies import Floating
from oracles.solids import surface_of

from drake_geom_ros.batch import evaluate
from drake_geom_ros.geometry import Box, Cylinder, Ellipsoid, FramePoseVector, Mesh, Sphere

LEVELS = 'fast', 'balanced', 'exact'
SOLID = Mesh.FromMeshData(surface_of('L'), 0.2)
PAIRS = {
    'cylinders': (Cylinder(0.1, 0.3), Cylinder(0.2, 0.4)),
    'ellipsoids': (Ellipsoid(0.1, 0.2, 0.3), Ellipsoid(0.3, 0.1, 0.2)),
    'cylinder and ellipsoid': (Cylinder(0.1, 0.3), Ellipsoid(0.3, 0.1, 0.2)),
    'solid and ellipsoid': (SOLID, Ellipsoid(0.3, 0.1, 0.2)),
    'boxes': (Box(0.1, 0.2, 0.3), Box(0.2, 0.2, 0.2)),
}


def states(bodies, seed, count=20):
    """States (n, 2, 7) of two bodies, of which half are mostly apart."""
    poses = bodies.states(np.random.default_rng(seed), count, 0.3)
    poses[::2, 0, :3] -= [0.5, 0.0, 0.0]
    return poses


def context_in(bodies, state, context=None):
    """A context in a state, and its query."""
    context = context or bodies.graph.CreateDefaultContext()
    ids = np.array([frame.get_value() for frame in bodies.ids])
    context.UpdateFramePoses(FramePoseVector.FromArrays(ids, state))
    return bodies.graph.get_query_output_port().Eval(context)


def listed(bodies, state, others, **asked):
    """How many pairs are listed by a fresh context, by others, and by a batch: all the same."""
    queries = context_in(bodies, state), *others
    counts = {len(q.ComputeSignedDistancePairwiseClosestPoints(**asked)) for q in queries}
    found = evaluate(bodies.graph, bodies.ids, state[None], want='within', **asked)
    counts.add(int(found.offsets[1]))
    (count,) = counts
    return count


@pytest.mark.parametrize('accuracy', LEVELS)
@pytest.mark.parametrize('name', PAIRS)
def test_a_pair_that_is_within_is_listed_and_none_that_is_certified_to_be_beyond(name, accuracy):
    """The truth is that of level exact; a looser one may report more, by up to its bound."""
    bodies = Floating(PAIRS[name])
    live = bodies.graph.CreateDefaultContext()
    for state in states(bodies, 1):
        query, kept = context_in(bodies, state), context_in(bodies, state, live)
        (pair,) = query.ComputeSignedDistancePairwiseClosestPoints(accuracy=accuracy)
        (truth,) = query.ComputeSignedDistancePairwiseClosestPoints(accuracy='exact')
        most, others = truth.distance + truth.error_bound, (query, kept)
        if most < pair.distance - 1e-13:
            reach = 0.5 * (most + pair.distance)
            assert listed(bodies, state, others, max_distance=reach, accuracy=accuracy) == 1
        assert listed(bodies, state, others, max_distance=pair.distance, accuracy=accuracy) == 1
        least = pair.distance - pair.error_bound
        reach = least - 1e-13 * max(1.0, abs(least))
        assert listed(bodies, state, others, max_distance=reach, accuracy=accuracy) == 0


@pytest.mark.parametrize('shape', [Sphere(0.1), Box(0.1, 0.2, 0.3), Cylinder(0.1, 0.3), SOLID])
def test_a_point_that_may_be_within_is_in_the_list_and_no_other(shape):
    bodies = Floating([shape])
    query = context_in(bodies, states(bodies, 2, 1)[0])
    for point in np.random.default_rng(3).uniform(-1, 1, (20, 3)):
        (found,) = query.ComputeSignedDistanceToPoint(point)
        least = found.distance - found.error_bound
        for reach, expected in (
            (found.distance, 1),
            (least - 1e-13, 0),
        ):
            assert len(query.ComputeSignedDistanceToPoint(point, reach)) == expected
