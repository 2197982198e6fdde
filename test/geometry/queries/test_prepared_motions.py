"""What checks of motions keep changes no answer: against a context that was never asked before."""

import pickle

import numpy as np
import pytest
from geometry.queries.moving_bodies import Moving, pose

from drake_geom_ros.geometry import (
    Box,
    Capsule,
    CollisionFilterDeclaration,
    FramePoseVector,
    GeometrySet,
    HalfSpace,
    PoseError,
    Sphere,
)
from drake_geom_ros.geometry.queries.context_state import PreparedMotions

APART = [pose(), pose(x=1.0), pose(y=5.0), pose(z=-9.0)]


@pytest.fixture(scope='module')
def bodies():
    return Moving([Sphere(0.1), Box(0.3, 0.2, 0.1), Capsule(0.1, 0.4), HalfSpace()])


def told(check):
    return [np.asarray(value).tolist() for value in vars(check).values()]


def vector(bodies, rows, which):
    ids = np.asarray(bodies.ids)[which]
    return FramePoseVector.FromArrays(ids, np.array(rows, float)[which])


def random_poses(rng, count):
    places, axes = rng.uniform(-1, 1, (count, 3)), rng.normal(size=(count, 3))
    angles = rng.uniform(0, 3, count)
    return [pose(*p, axis=a, angle=w) for p, a, w in zip(places, axes, angles, strict=True)]


def test_answers_do_not_depend_on_what_was_asked_before(bodies):
    rng = np.random.default_rng(4)
    context = bodies.graph.CreateDefaultContext()
    kept = bodies.graph.get_query_output_port().Eval(context)
    outcomes = set()
    for number in range(60):
        # Some frames move, others stay where the last poses put them, each time elsewhere.
        which = [[0], [0, 1], [1, 2, 3], [3]][number % 4]
        starts, ends = random_poses(rng, 4), random_poses(rng, 4)
        context.UpdateFramePoses(vector(bodies, starts, range(4)))
        asked = {'min_distance': float(rng.choice([0.0, 0.05]))}
        end = vector(bodies, ends, which)
        check = kept.CheckMotion(end, **asked)
        assert told(check) == told(bodies.query(starts).CheckMotion(end, **asked))
        assert told(check) == told(kept.CheckMotion(end, **asked))
        outcomes.add(check.outcome)
    assert outcomes == {'clear', 'contact'}


def test_a_filter_of_later_holds_and_one_of_before_does_not(bodies):
    context = bodies.graph.CreateDefaultContext()
    context.UpdateFramePoses(vector(bodies, APART, range(4)))
    query = bodies.graph.get_query_output_port().Eval(context)
    end = vector(bodies, [pose(x=2.0)] * 4, [0])
    assert query.CheckMotion(end).outcome == 'contact'
    both = GeometrySet(frame_ids=list(bodies.ids[:2]))
    manager = bodies.graph.collision_filter_manager(context)
    filtered = manager.ApplyTransient(CollisionFilterDeclaration().ExcludeWithin(both))
    assert query.CheckMotion(end).outcome == 'clear'
    manager.RemoveDeclaration(filtered)
    assert query.CheckMotion(end).outcome == 'contact'


def test_snapshots_share_what_is_prepared_and_no_pose(bodies):
    context = bodies.graph.CreateDefaultContext()
    context.UpdateFramePoses(vector(bodies, APART, range(4)))
    end = vector(bodies, [pose(x=2.0)] * 4, [0])
    snapshots = [context.what_if() for _ in range(3)]
    snapshots[1].UpdateFramePoses(vector(bodies, [pose(z=3.0)] * 4, [1]))
    of = bodies.graph.get_query_output_port().Eval
    outcomes = [of(each).CheckMotion(end).outcome for each in (*snapshots, context)]
    assert outcomes == ['contact', 'clear', 'contact', 'contact']


def test_a_frame_that_has_no_pose_any_more_is_told(bodies):
    context = bodies.graph.CreateSharedContext(partial=True)
    query = bodies.graph.get_query_output_port().Eval(context)
    end = vector(bodies, [pose(x=2.0)] * 4, [0])
    with pytest.raises(PoseError, match='never had a pose'):
        query.CheckMotion(end)
    context.UpdateFramePoses(vector(bodies, APART, range(4)))
    assert query.CheckMotion(end).outcome == 'contact'


def test_a_few_are_kept_those_of_last_use_and_each_by_one_alone():
    kept = PreparedMotions()
    for k in range(12):
        kept.keep(k, str(k))
    assert [kept.take(k) for k in (3, 4, 11)] == [None, '4', '11']
    assert kept.take(4) is None
    kept.keep(4, 'again')
    assert kept.take(4) == 'again'
    assert pickle.loads(pickle.dumps(kept)).take(5) is None


@pytest.mark.parametrize('tolerance', [1e-2, 1e-4, 1e-6])
def test_a_bound_is_as_close_as_is_asked_for(bodies, tolerance):
    rng, loose = np.random.default_rng(8), 0
    for _ in range(40):
        starts, ends = random_poses(rng, 4), random_poses(rng, 4)
        plain = bodies.check(starts, ends)
        close = bodies.check(starts, ends, bound_tolerance=tolerance)
        assert close.outcome == plain.outcome
        if plain.outcome != 'clear':
            assert told(close) == told(plain)
            continue
        assert close.times == plain.times
        assert close.lower_bound >= plain.lower_bound
        assert close.distance <= plain.distance
        assert close.distance - close.lower_bound <= tolerance
        _, distance, bound = bodies.scan(starts, ends, 'slerp')
        assert close.lower_bound <= (distance + bound).min() + 1e-12
        loose += plain.distance - plain.lower_bound > tolerance
    assert loose > 0
