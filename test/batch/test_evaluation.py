"""The law: a batch is, to the bit, what queries tell that see one state each."""

import math

import numpy as np
import pytest

from drake_geom_ros.batch import Joints, evaluate
from drake_geom_ros.geometry import (
    ACCURACY_LEVELS,
    ArgumentError,
    CollisionFilterDeclaration,
    FrameId,
    FramePoseVector,
    GeometrySet,
    PoseError,
)
from drake_geom_ros.trajectories.kinematics import Kinematics
from drake_geom_ros.trajectories.pose_matrices import matrices_of_poses

PAIR_COLUMNS = (
    *('id_A', 'id_B', 'distance', 'error_bound', 'method'),
    *('nhat_BA_W', 'is_nhat_BA_W_unique', 'p_WCa', 'p_WCb'),
)
POINTS = [[0.0, 0.0, 0.5], [0.5, 0.2, 0.3], [-0.6, 0.1, 0.6]]


def same(a, b):
    """Tell whether two results of evaluate are the same bits."""
    pairs = zip(a, b, strict=True) if isinstance(a, tuple) else [(a, b)]
    return all(x.dtype == y.dtype and x.tobytes() == y.tobytes() for x, y in pairs)


@pytest.mark.parametrize('accuracy', ACCURACY_LEVELS)
def test_collisions_are_those_of_single_queries(cell, accuracy):
    states = cell.states(60)
    found = evaluate(
        cell.scene_graph, want='collision', states=states, joints=cell.joints, accuracy=accuracy
    )
    expected = [query.HasCollisions(accuracy=accuracy) for query in cell.each(states)]
    assert found.tolist() == expected
    assert accuracy == 'bound' or 0 < sum(expected) < len(expected)


@pytest.mark.parametrize('accuracy', ACCURACY_LEVELS)
@pytest.mark.parametrize('max_distance', [math.inf, 0.1, -0.01])
def test_pairs_within_are_those_of_single_queries(cell, accuracy, max_distance):
    states = cell.states(20)
    how = {'max_distance': max_distance, 'accuracy': accuracy}
    found = evaluate(cell.scene_graph, want='within', states=states, joints=cell.joints, **how)
    for k, query in enumerate(cell.each(states)):
        rows = slice(*found.offsets[k : k + 2])
        expected = query.ComputeSignedDistancePairwiseClosestPoints(**how)
        for name in PAIR_COLUMNS:
            np.testing.assert_array_equal(getattr(found, name)[rows], getattr(expected, name))
        gradients = [np.concatenate(pair.gradient()) for pair in expected]
        np.testing.assert_array_equal(found.gradient[rows], np.reshape(gradients, (-1, 12)))


@pytest.mark.parametrize('accuracy', ACCURACY_LEVELS)
@pytest.mark.parametrize('max_distance', [math.inf, 0.05])
@pytest.mark.parametrize('count', [1, 4])
def test_the_nearest_pairs_are_those_of_the_least_lower_bounds(
    cell, accuracy, max_distance, count
):
    states = cell.states(150)
    how = {'max_distance': max_distance, 'accuracy': accuracy}
    asked = {**how, 'states': states, 'joints': cell.joints}
    found = evaluate(cell.scene_graph, want='nearest', count=count, **asked)
    every = evaluate(cell.scene_graph, want='within', **{**asked, 'max_distance': math.inf})
    for k in range(len(states)):
        rows, all_rows = slice(*found.offsets[k : k + 2]), slice(*every.offsets[k : k + 2])
        ends = (every.distance - every.error_bound)[all_rows]
        order = np.argsort(ends, kind='stable')
        order = order[ends[order] <= max_distance][:count]
        for name in (*PAIR_COLUMNS, 'gradient'):
            np.testing.assert_array_equal(
                getattr(found, name)[rows], getattr(every, name)[all_rows][order]
            )


def test_least_is_the_nearest_and_infinity_where_nothing_is_in_reach(cell):
    asked = {'states': cell.states(100), 'joints': cell.joints, 'max_distance': -0.005}
    least = evaluate(cell.scene_graph, want='least', **asked)
    nearest = evaluate(cell.scene_graph, want='nearest', **asked)
    there = np.diff(nearest.offsets) == 1
    assert there.any()
    assert not there.all()
    assert np.isinf(least.distance[~there]).all()
    assert not least.id_A[~there].any()
    for name in (*PAIR_COLUMNS, 'gradient'):
        np.testing.assert_array_equal(getattr(least, name)[there], getattr(nearest, name))


@pytest.mark.parametrize('threshold', [math.inf, 0.2])
def test_points_are_those_of_single_queries(cell, threshold):
    states = cell.states(20)
    found = evaluate(
        cell.scene_graph,
        want='points',
        points=POINTS,
        max_distance=threshold,
        states=states,
        joints=cell.joints,
    )
    for k, query in enumerate(cell.each(states)):
        rows = slice(*found.offsets[k : k + 2])
        expected = query.ComputeSignedDistanceToPoint(POINTS, threshold)
        for name in found._fields[1:]:
            np.testing.assert_array_equal(getattr(found, name)[rows], getattr(expected, name))


@pytest.mark.parametrize('want', ['collision', 'least', 'within'])
def test_threads_blocks_and_order_change_no_bit(cell, want):
    states = cell.states(97)
    asked = {'want': want, 'max_distance': 0.2, 'joints': cell.joints}
    once = evaluate(cell.scene_graph, states=states, threads=1, block_size=97, **asked)
    for threads, block_size in ((1, 1), (2, 10), (3, 96)):
        again = evaluate(
            cell.scene_graph, states=states, threads=threads, block_size=block_size, **asked
        )
        assert same(once, again)
    if want != 'within':
        back = evaluate(cell.scene_graph, states=states[::-1], **asked)
        turned = once[::-1] if want == 'collision' else [column[::-1] for column in once]
        assert same(back, turned if want == 'collision' else type(once)(*map(np.copy, turned)))


def test_poses_of_frames_are_states_too(cell):
    states = cell.states(30)
    ids, poses = cell.joints.frame_ids, cell.joints.poses(states)
    assert same(
        evaluate(cell.scene_graph, ids, poses, 'least'),
        evaluate(cell.scene_graph, want='least', states=states, joints=cell.joints),
    )


def test_frames_that_no_state_names_stay_where_the_context_has_them(cell):
    tray = cell.loaded.frames['things', 'tray']
    poses = np.tile([0.6, 0.1, 0.4, 0.0, 0.0, 0.0, 1.0], (5, 1, 1))
    poses[:, 0, 2] += np.linspace(0.0, 0.4, 5)
    context = cell.scene_graph.CreateDefaultContext()
    with pytest.raises(PoseError, match="never had a pose: 'upper'"):
        evaluate(context, [tray], poses, 'least')
    arm = FramePoseVector.FromArrays(cell.joints.frame_ids, cell.joints.poses(cell.states(1))[0])
    context.UpdateFramePoses(arm)
    found = evaluate(context, [tray], poses, 'within', 0.5)
    for k, pose in enumerate(poses):
        alone = cell.scene_graph.CreateDefaultContext()
        alone.UpdateFramePoses(arm)
        alone.UpdateFramePoses(FramePoseVector.FromArrays([tray], pose))
        query = cell.scene_graph.get_query_output_port().Eval(alone)
        expected = query.ComputeSignedDistancePairwiseClosestPoints(0.5)
        rows = slice(*found.offsets[k : k + 2])
        np.testing.assert_array_equal(found.distance[rows], expected.distance)


def test_the_filters_of_the_context_hold(cell):
    states = {'states': cell.states(50), 'joints': cell.joints}
    context = cell.scene_graph.CreateDefaultContext()
    manager = cell.scene_graph.collision_filter_manager(context)
    every = GeometrySet(cell.scene_graph.model_inspector().GetAllGeometryIds())
    manager.Apply(CollisionFilterDeclaration().ExcludeWithin(every))
    assert evaluate(cell.scene_graph, want='collision', **states).any()
    assert not evaluate(context, want='collision', **states).any()
    assert not len(evaluate(context, want='within', **states).distance)


def test_no_states_give_empty_results(cell):
    empty = np.zeros((0, cell.joints.count))
    for want in ('collision', 'least', 'within'):
        found = evaluate(cell.scene_graph, want=want, states=empty, joints=cell.joints)
        assert len(found if want == 'collision' else found.distance) == 0


def test_what_cannot_be_asked_is_refused_by_name(cell):
    asked = {'states': cell.states(2), 'joints': cell.joints}
    for bad, words in (
        ({'want': 'least?'}, 'want='),
        ({'accuracy': 'good'}, 'accuracy='),
        ({'max_distance': math.nan}, 'NaN'),
        ({'count': 3}, 'count=3'),
        ({'points': POINTS}, 'points'),
        ({'states': np.zeros((2, 3))}, r'\(N, 4\)'),
        ({'joints': None}, 'states'),
    ):
        with pytest.raises(ArgumentError, match=words):
            evaluate(cell.scene_graph, **{**asked, **bad})
    with pytest.raises(ArgumentError, match='states=states, joints=joints'):
        evaluate(cell.scene_graph, cell.joints, cell.states(2))


def test_a_state_that_is_none_is_refused_with_its_number(cell):
    poses = cell.joints.poses(cell.states(30))
    poses[17, 2, 3:] = 0.5, 0.5, 0.5, 0.6
    with pytest.raises(PoseError, match='17'):
        evaluate(cell.scene_graph, cell.joints.frame_ids, poses, 'least', block_size=10)


def test_unknown_frames_are_refused(cell):
    poses = np.tile([0.0, 0, 0, 0, 0, 0, 1], (2, 1, 1))
    with pytest.raises(PoseError, match='not in this scene'):
        evaluate(cell.scene_graph, [FrameId.get_new_id()], poses, 'least')


def test_joints_without_a_column_rest_at_zero_or_their_nearest_limit(cell):
    some = Joints.of(cell.loaded, ['arm::slide', 'arm::turn'])
    states = cell.states(10)
    whole = np.zeros((10, 4))
    whole[:, [3, 0]] = states[:, :2]
    assert cell.joints.names == ('arm::turn', 'arm::bend', 'arm::roll', 'arm::slide')
    np.testing.assert_array_equal(some.poses(states[:, :2]), cell.joints.poses(whole))
    for names, words in ((['arm::x'], 'arm::x'), (['arm::turn'] * 2, 'named twice')):
        with pytest.raises(ArgumentError, match=words):
            Joints.of(cell.loaded, names)


def test_poses_of_states_of_another_size_are_refused(cell):
    for bad in (np.zeros((2, 3)), np.zeros(4), np.zeros((1, 2, 4)), np.zeros((2, 5))):
        with pytest.raises(ArgumentError, match=r'\(N, 4\), one value each for arm::turn'):
            cell.joints.poses(bad)


def test_poses_of_joints_are_those_of_forward_kinematics(cell):
    arm = cell.loaded.robots['arm']
    kinematics, states = Kinematics(str(arm.urdf)), cell.states(20)
    X_WLs = kinematics.link_transforms(states, arm.X_WB.GetAsMatrix4())
    for k, frame in enumerate(cell.joints.frame_ids):
        name = cell.scene_graph.model_inspector().GetName(frame)
        expected = X_WLs[:, kinematics.link_names.index(name)]
        found = matrices_of_poses(cell.joints.poses(states)[:, k])
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-15)
