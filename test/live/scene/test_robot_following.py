"""Links follow the base of their robot in "what if" questions as they do live; without ROS."""

from types import SimpleNamespace as Plain

import numpy as np
import pytest
from live.inputs.test_joint_input import AT, JOINTS_OF_ARM, state
from live.live_scenes import Clock, live_scene
from live.services.test_motions import CLEAR, CONTACT, answer, joint_values, poses
from live.services.test_states import NO_POSES, cell_in, request

from drake_geom_ros.live.inputs.joint_input import JointInput
from drake_geom_ros.live.inputs.pose_inputs import PoseInputs
from drake_geom_ros.live.scene.changes.attachment import attachment
from drake_geom_ros.live.services.queries import (
    compute_signed_distance_to_point,
    find_collision_candidates,
    has_collisions,
)
from drake_geom_ros.live.services.states import evaluate_states
from drake_geom_ros.math import RigidTransform, RollPitchYaw

NOW = (0.0, 0.0, 0.1)
# The hand is 1 m beside the base and 1 m above it, and the post stands at (2, 2) from 2.5 to 5.5.
WITH_HAND_IN_POST = [1.0, 2.0, 3.0, 0, 0, 0, 1.0]
FAR = [-5.0, -5.0, 0.0, 0, 0, 0, 1.0]
TURNED = [*FAR[:3], 0, 0, 1.0, 0]


class Live:
    """A live scene and what poses it."""

    def __init__(self, text, names=JOINTS_OF_ARM):
        self.live = live_scene(text, Clock(1000.0))
        self.inputs = PoseInputs(joints=JointInput(self.live.clocks, 1.0, by_default=True))
        with self.live.editing() as scene:
            self.inputs.take_joint_states(scene, state(names, NOW))

    def pose(self, **frames):
        with self.live.editing() as scene:
            self.inputs.take_poses(scene, poses(**frames))

    def frames(self, view=None):
        with self.live.reading() as scene:
            query = scene.query if view is None else view.query
            labels = scene.model.names.labels
            return {
                label: query.X_WF(frame).GetAsMatrix4()
                for frame, label in labels.items()
                if query.is_placed(frame)
            }


@pytest.fixture
def cell(tmp_path):
    text = cell_in(tmp_path, 'adjacent_links: filtered')
    return Live(text.replace(AT, 'pose: {position: [-5, 2, 3]}'))


@pytest.fixture
def both(tmp_path):
    """Two arms, the base of the second attached to the hand of the first."""
    text = cell_in(tmp_path, 'adjacent_links: filtered')
    second = f'- {{urdf: {tmp_path}/arm.urdf, name: other, adjacent_links: filtered}}'
    text = text.replace('\n\n', f'\n{second}\n', 1)
    cell = Live(text, [f'arm::{name}' for name in JOINTS_OF_ARM])
    with cell.live.editing() as scene:
        names = [f'other::{name}' for name in JOINTS_OF_ARM]
        cell.inputs.take_joint_states(scene, state(names, NOW))
        frame, parent = (
            scene.model.names.frame('other::base'),
            scene.model.names.frame('arm::hand'),
        )
        scene.make(attachment(scene, frame, parent, RigidTransform([0.0, 0.0, 0.5])))
        cell.inputs.follow(scene)
    return cell


def test_links_stand_in_a_question_as_they_stand_live_when_the_base_stands_there(cell):
    asked = cell.live.view(poses(base=TURNED))
    inside = cell.frames(asked)
    cell.pose(base=TURNED)
    live = cell.frames()
    assert inside.keys() == live.keys()
    assert all(np.array_equal(inside[label], live[label]) for label in live)


def test_every_question_with_the_pose_of_a_base_is_about_its_links(cell):
    response = Plain(result=Plain(), message='')
    at_post = poses(base=WITH_HAND_IN_POST)
    has_collisions(cell.live, Plain(poses=at_post, joints=joint_values()), response)
    assert response.has_collisions
    has_collisions(cell.live, Plain(poses=NO_POSES, joints=joint_values()), response)
    assert not response.has_collisions
    find_collision_candidates(cell.live, Plain(poses=at_post, joints=joint_values()), response)
    assert len(response.id_a)
    message = Plain(header=Plain(stamp=None))
    asked = Plain(
        points=[2.0, 2.0, 4.0], threshold=0.15, poses=at_post, joints=joint_values(), accuracy=''
    )
    compute_signed_distance_to_point(cell.live, asked, Plain(result=message, message=''))
    assert len(message.id_g) > 1


def test_states_and_questions_agree_about_a_base_that_stands_elsewhere(cell):
    at_post, found = poses(base=WITH_HAND_IN_POST), Plain()
    evaluate_states(cell.live, request([NOW], want='least', poses=at_post), found)
    view = cell.live.view(at_post)
    distances = view.query.ComputeSignedDistancePairwiseClosestPoints(np.inf)
    assert found.distance[0] == min(distances.distance)


def test_a_motion_of_a_base_takes_its_links_along(cell):
    found = answer(cell.live, start=poses(base=FAR), end=poses(base=WITH_HAND_IN_POST))
    assert found.outcome == CONTACT
    above = [1.0, 2.0, 9.0, 0, 0, 0, 1.0]
    assert answer(cell.live, start=poses(base=FAR), end=poses(base=above)).outcome == CLEAR


def test_a_turn_of_a_base_takes_its_links_along_by_a_screw_and_is_refused_otherwise(cell):
    ends = {'start': poses(base=[1.0, 2.0, 9.0, 0, 0, 0, 1]), 'end': poses(base=TURNED)}
    with pytest.raises(RuntimeError, match=r"end turns the base of 'arm'.*'screw'"):
        answer(cell.live, **ends)
    assert answer(cell.live, **ends, interpolation='screw').outcome == CLEAR
    half = RigidTransform(RollPitchYaw(0.0, 0.0, np.pi), [2.0, 2.0, 3.0]).ToArray()
    swings = {'start': poses(base=[2.0, 2.0, -9.0, 0, 0, 0, 1]), 'end': poses(base=half.tolist())}
    assert answer(cell.live, **swings, interpolation='screw').outcome == CONTACT


def test_links_that_the_question_poses_itself_stand_where_it_says(cell):
    hand = [7.0, 7.0, 7.0, 0, 0, 0, 1.0]
    view = cell.live.view(poses(base=FAR, hand=hand))
    frames = cell.frames(view)
    assert frames['arm', 'hand'][:3, 3].tolist() == hand[:3]
    assert not np.array_equal(frames['arm', 'upper'], cell.frames()['arm', 'upper'])


def test_links_that_messages_pose_one_by_one_stay_as_they_do_live(tmp_path):
    cell = Live(cell_in(tmp_path))
    cell.inputs.joints = None
    with cell.live.editing() as scene:
        for robot in scene.model.joints.robots.values():
            robot.base = None
    cell.pose(base=[0, 0, 0, 0, 0, 0, 1.0], hand=[0, 0, 1, 0, 0, 0, 1.0])
    frames = cell.frames(cell.live.view(poses(base=FAR)))
    assert np.array_equal(frames['arm', 'hand'], cell.frames()['arm', 'hand'])


def test_a_base_without_a_pose_brings_its_links_along_in_the_question(tmp_path):
    cell = Live(cell_in(tmp_path).replace(AT, 'adjacent_links: filtered'))
    assert ('arm', 'hand') not in cell.frames()
    frames = cell.frames(cell.live.view(poses(base=FAR)))
    assert frames['arm', 'hand'][:3, 3].tolist() == [-4.0, -5.0, 1.0]


def test_a_robot_on_a_link_that_follows_follows_too(both):
    at = RigidTransform([1.0, 2.0, 3.0]).ToArray().tolist()
    inside = both.frames(both.live.view(poses(**{'arm::base': at})))
    by_joints = both.frames(both.live.view(NO_POSES, joint_values(**{'arm::shoulder': 1.0})))
    both.pose(**{'arm::base': at})
    live = both.frames()
    assert all(np.allclose(inside[label], live[label], rtol=0.0, atol=1e-12) for label in live)
    hand, carried = by_joints['arm', 'hand'], by_joints['other', 'upper']
    relative = np.linalg.inv(live['arm', 'hand']) @ live['other', 'upper']
    assert np.allclose(np.linalg.inv(hand) @ carried, relative, rtol=0.0, atol=1e-12)


def test_states_and_paths_that_move_what_a_robot_is_attached_to_are_refused(both):
    told = "the base of 'other' is attached to arm::hand, which moves"
    names = [f'arm::{name}' for name in JOINTS_OF_ARM]
    with pytest.raises(RuntimeError, match=told):
        evaluate_states(both.live, request([NOW], names=names), Plain())
    with pytest.raises(RuntimeError, match=told):
        answer(both.live, end=poses(**{'arm::base': FAR}))
