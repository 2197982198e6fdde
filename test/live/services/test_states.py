"""``evaluate_states`` and "what if" by joints on a live scene, without ROS."""

import math
from types import SimpleNamespace as Plain

import numpy as np
import pytest
from live.inputs.test_joint_input import ARM, AT, JOINTS_OF_ARM, state
from live.live_scenes import Clock, live_scene

from drake_geom_ros.batch import Joints, evaluate
from drake_geom_ros.geometry import GeometryFrame, SceneGraph
from drake_geom_ros.live.inputs.joint_input import JointInput
from drake_geom_ros.live.scene.change import Change
from drake_geom_ros.live.services.states import FREE, OUTSIDE_LIMITS, TOO_NEAR, evaluate_states
from drake_geom_ros.scene_files import load_scene

OBSTACLES = """
geometries:
- {name: post, source: cell, shape: {type: box, size: [0.2, 0.2, 3]}, pose: {position: [2, 2, 4]}}
- {name: ball, source: cell, frame: free, shape: {type: sphere, radius: 0.1}}
frames: [{name: free, source: cell, pose: {position: [9, 9, 9]}}]
"""
NO_POSES = Plain(
    header=Plain(frame_id='', stamp=Plain(sec=0, nanosec=0)),
    source='',
    frame_names=[],
    frame_ids=[],
    poses=[],
)
BOUNDS = [-1.0, -3.0, 0.0], [2.0, 3.0, 0.1]


def cell_in(folder, *more):
    """Return the text of a scene of the arm, whose file is written to a folder, and obstacles.

    ``more`` are further keys of the robot.
    """
    (folder / 'arm.urdf').write_text(ARM)
    keys = ', '.join((f'urdf: {folder}/arm.urdf', 'name: arm', AT, *more))
    return f'robots:\n- {{{keys}}}\n{OBSTACLES}'


@pytest.fixture
def text(tmp_path):
    return cell_in(tmp_path, 'adjacent_links: filtered')


@pytest.fixture
def live(text):
    return live_scene(text, Clock(1000.0))


@pytest.fixture
def states():
    return np.random.default_rng(5).uniform(*BOUNDS, size=(1500, 3))


def request(states, names=JOINTS_OF_ARM, want='collision', **fields):
    positions = np.asarray(states, dtype=np.float64).ravel()
    given = {
        'clearance': 0.0,
        'max_distance': 0.0,
        'stop_at_first': False,
        'ignore_limits': False,
        'accuracy': '',
        'poses': NO_POSES,
    }
    given |= {'positions': positions, 'joint_names': list(names), 'want': want}
    return Plain(**{**given, **fields})


def answer(live, *arguments, **fields):
    response = Plain()
    evaluate_states(live, request(*arguments, **fields), response)
    return response


@pytest.fixture
def batch(text):
    scene_graph = SceneGraph()
    loaded = load_scene(text, scene_graph)
    joints = Joints.of(loaded, [f'arm::{name}' for name in JOINTS_OF_ARM])

    def ask(states, **question):
        return evaluate(scene_graph, states=states, joints=joints, **question)

    return ask


@pytest.mark.parametrize('clearance', [0.0, 0.02])
@pytest.mark.parametrize('accuracy', ['bound', 'fast', 'exact'])
def test_it_answers_what_batches_answer_to_the_bit(live, batch, states, clearance, accuracy):
    collides = batch(states, want='collision', max_distance=clearance, accuracy=accuracy)
    assert 0 < collides.sum() < len(states)
    fields = {'clearance': clearance, 'accuracy': accuracy}
    plain = answer(live, states, **fields)
    least = answer(live, states, want='least', **fields)
    near = answer(live, states, want='near', max_distance=0.5, **fields)
    for found in (plain, least, near):
        assert found.free == (~collides).tolist()
        assert list(found.reason) == np.where(collides, TOO_NEAR, FREE).tolist()
        assert found.count == len(states)
        assert found.first_not_free == int(np.argmax(collides))
    expected = batch(states, want='least', accuracy=accuracy)
    assert list(least.distance) == expected.distance.tolist()
    assert list(least.error_bound) == expected.error_bound.tolist()
    pairs = batch(states, want='within', max_distance=0.5, accuracy=accuracy)
    assert list(near.offsets) == pairs.offsets.tolist()
    assert list(near.distance) == pairs.distance.tolist()


@pytest.mark.parametrize(('link', 'free'), [('upper', True), ('hand', False)])
def test_half_spaces_that_overlap_are_not_free_whatever_is_wanted(text, live, states, link, free):
    states = states[answer(live, states).free][:2]
    turned = '[[1, 0, 0], [0, -1, 0], [0, 0, -1]]'
    pose = f'{{rotation: {turned}, position: [0, 0, 40]}}'
    planes = (
        'geometries:\n- {name: floor, source: cell, pose: {position: [0, 0, -9]}, '
        'shape: {type: half_space}}\n'
        f'- {{name: plate, source: arm, frame: {link}, pose: {pose}, '
        'shape: {type: half_space}}\n'
    )
    live = live_scene(text.replace('geometries:\n', planes), Clock(1000.0))
    for want in ('collision', 'least', 'near'):
        for stop in (False, True):
            found = answer(live, states, want=want, stop_at_first=stop)
            assert found.free == ([True] * 2 if free else [False] * (1 if stop else 2))


def test_ids_are_those_of_the_live_scene(live, states):
    found = answer(live, states, want='least')
    with live.reading() as scene:
        known = {id.get_value() for id in scene.model.names.geometry_names}
    assert set(found.id_a) | set(found.id_b) <= known


def test_states_outside_limits_are_not_free_and_nothing_else_is_told(live, states):
    states = states.copy()
    states[7, 0] = 2.5
    for want in ('collision', 'least', 'near'):
        found = answer(live, states, want=want)
        assert found.reason[7] == OUTSIDE_LIMITS
        assert not found.free[7]
        ignored = answer(live, states, want=want, ignore_limits=True)
        assert ignored.reason[7] != OUTSIDE_LIMITS
    assert found.offsets[7] == found.offsets[8]
    assert math.isnan(answer(live, states, want='least').distance[7])


@pytest.mark.parametrize('want', ['collision', 'least', 'near'])
def test_it_stops_after_the_first_that_is_not_free(live, batch, states, want):
    free = states[~batch(states, want='collision', max_distance=0.0)]
    bad = states[batch(states, want='collision', max_distance=0.0)][:1]
    for place in (0, 1, 63, 64, 65, 150):
        asked = np.concatenate((free[:place], bad, free[place:]))
        found = answer(live, asked, want=want, stop_at_first=True)
        whole = answer(live, asked, want=want)
        assert found.first_not_free == whole.first_not_free == place
        assert found.count == place + 1
        assert found.free == whole.free[: place + 1]
    assert answer(live, free, stop_at_first=True).count == len(free)
    assert answer(live, free, stop_at_first=True).first_not_free == -1


def test_joints_that_are_not_named_stay_as_they_are(live, batch, states):
    joints = JointInput(live.clocks, 1.0, by_default=True)
    with pytest.raises(RuntimeError, match='nothing was heard of the joints arm::wrist, arm::fi'):
        answer(live, states[:, :1], names=['shoulder'])
    with live.editing() as scene:
        joints.take(scene, state(JOINTS_OF_ARM, (0.1, 0.7, 0.05)), 0.0)
    found = answer(live, states[:, :1], names=['shoulder'], want='least')
    whole = np.column_stack((states[:, 0], np.full((len(states), 2), (0.7, 0.05))))
    assert list(found.distance) == batch(whole, want='least').distance.tolist()


def test_poses_of_other_frames_count_in_all_states(live, states):
    before = answer(live, states, want='least')
    poses = Plain(**{**vars(NO_POSES), 'frame_names': ['free'], 'poses': [1, 2, 4, 0, 0, 0, 1.0]})
    after = answer(live, states, want='least', poses=poses)
    assert list(before.distance) != list(after.distance)
    assert list(answer(live, states, want='least').distance) == list(before.distance)
    poses.frame_names = ['arm::hand']
    with pytest.raises(RuntimeError, match='joints move arm::hand, and poses pose them'):
        answer(live, states, poses=poses)


@pytest.mark.parametrize(
    ('fields', 'words'),
    [
        ({'want': 'all'}, "want is 'all'"),
        ({'clearance': -1.0}, 'clearance is -1.0'),
        ({'clearance': math.nan}, 'clearance is nan'),
        ({'max_distance': 1.0}, 'goes with `near`'),
        ({'want': 'near', 'max_distance': math.nan}, 'max_distance is nan'),
        ({'accuracy': 'good'}, "accuracy='good'"),
        ({'names': []}, 'joint_names is empty'),
        ({'names': ['shoulder', 'wrist', 'other']}, "no joint 'other' with a value of its own"),
        ({'names': ['shoulder', 'wrist', 'wrist']}, "joint 'wrist' is named twice"),
        ({'positions': [1.0] * 4}, 'positions holds 4 numbers for 3 joints'),
    ],
)
def test_what_cannot_be_meant_is_refused(live, states, fields, words):
    with pytest.raises(RuntimeError, match=words):
        answer(live, states, **fields)


def test_numbers_that_are_none_and_answers_that_are_too_large_are_refused(live, states):
    bad = states.copy()
    bad[17, 1] = math.nan
    with pytest.raises(RuntimeError, match='state 17 of positions'):
        answer(live, bad)
    live.most_megabytes = 0.001
    with pytest.raises(RuntimeError, match='ask for at most 29 states at once'):
        answer(live, states, want='least')
    with pytest.raises(RuntimeError, match='with a smaller max_distance'):
        answer(live, states[:20], want='near')


def test_what_has_no_pose_makes_no_state_free(live, states):
    with live.editing() as scene:
        scene.make(
            Change(
                lambda graph, _: graph.RegisterFrame(
                    scene.model.names.source('cell'), GeometryFrame('new')
                )
            )
        )
    with pytest.raises(RuntimeError, match='never had a pose'):
        answer(live, states)


def test_a_what_if_by_joints_is_that_of_the_same_poses_to_the_bit(live):
    joints = Plain(names=list(JOINTS_OF_ARM), positions=[0.3, -0.8, 0.04])
    by_joints = live.view(NO_POSES, joints)
    input = JointInput(live.clocks, 1.0, by_default=True)
    other = by_joints.query.ComputeSignedDistancePairwiseClosestPoints()
    with live.editing() as scene:
        assert scene.query.num_waiting_pairs()
        input.take(scene, state(JOINTS_OF_ARM, joints.positions), 0.0)
    live_pairs = live.view().query.ComputeSignedDistancePairwiseClosestPoints()
    assert other.distance.tolist() == live_pairs.distance.tolist()
    # Some joints: the others stay. And what both would pose is refused.
    one = live.view(NO_POSES, Plain(names=['arm::wrist'], positions=[1.0]))
    input_ = state(['wrist'], [1.0])
    with live.editing() as scene:
        input.take(scene, input_, 0.0)
    same = live.view().query.ComputeSignedDistancePairwiseClosestPoints()
    found = one.query.ComputeSignedDistancePairwiseClosestPoints()
    assert found.distance.tolist() == same.distance.tolist()
    poses = Plain(**{**vars(NO_POSES), 'frame_names': ['hand'], 'poses': [0, 0, 0, 0, 0, 0, 1.0]})
    with pytest.raises(RuntimeError, match='joints move arm::hand'):
        live.view(poses, joints)
    for names, positions, words in (
        (['wrist'], [], 'positions holds 0 numbers for 1 joint name'),
        (['wrist'], [math.nan], 'must be finite'),
        (['nobody'], [0.0], "no joint 'nobody'"),
    ):
        with pytest.raises(RuntimeError, match=words):
            live.view(NO_POSES, Plain(names=names, positions=positions))


def test_an_answer_names_the_frames_whose_stale_poses_of_now_it_rests_on(text):
    clock = Clock(1000.0)
    live = live_scene(text, clock)
    live.stale_after = 1.0
    joints = JointInput(live.clocks, 1.0, by_default=True)
    moved = Plain(**{**vars(NO_POSES), 'frame_names': ['free'], 'poses': [9, 9, 9, 0, 0, 0, 1.0]})
    with live.editing() as scene:
        joints.take(scene, state(JOINTS_OF_ARM, (0.0, 0.0, 0.05)), 0.0)
        scene.poses.take(moved)

    def stale_of(names, values, poses=NO_POSES):
        found = Plain()
        evaluate_states(live, request([values], names=names, poses=poses), found)
        return found.stale_frames

    assert stale_of(JOINTS_OF_ARM, (0.0, 0.0, 0.05)) == []
    clock.now += 5.0
    assert stale_of(JOINTS_OF_ARM, (0.0, 0.0, 0.05)) == ['cell::free']
    assert stale_of(JOINTS_OF_ARM, (0.0, 0.0, 0.05), moved) == []
    # The links below a joint that keeps its value of now, which is as old.
    assert stale_of(JOINTS_OF_ARM[:1], (0.0,), moved) == ['arm::hand', 'arm::left', 'arm::right']
    with live.editing() as scene:
        joints.take(scene, state(JOINTS_OF_ARM, (0.0, 0.0, 0.05)), 0.0)
    assert stale_of(JOINTS_OF_ARM[:1], (0.0,), moved) == []
