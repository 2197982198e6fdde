"""Drake's joints move links by joint values: in batches, in a live scene, and in recordings."""

import math

import numpy as np
import pytest
from live.inputs.test_joint_input import opened, state
from live.live_scenes import Clock
from recordings import recorder

from drake_geom_ros.batch import Joints, evaluate
from drake_geom_ros.geometry import SceneGraph
from drake_geom_ros.math import RigidTransform, RollPitchYaw, RotationMatrix
from drake_geom_ros.recordings import clearance
from drake_geom_ros.scene_files import load_scene

ROBOT = """<robot name="r" xmlns:drake="http://drake.mit.edu"><link name="p"/>
<link name="c"><collision><origin xyz="0.3 0.2 0.1"/><geometry><sphere radius="0.1"/></geometry>
</collision></link>
<drake:joint name="j" type="{}"><parent link="p"/><child link="c"/>
<origin xyz="0.5 0 0.2" rpy="0.1 0.2 0.3"/><axis xyz="0 0 1"/>{}</drake:joint></robot>
"""
SCENE = """
robots: [{name: r, urdf: r.urdf, pose: {position: [0, 0, 0]}}]
geometries: [{name: post, pose: {position: [3, 0, 0]}, shape: {type: sphere, radius: 0.5}}]
"""
PITCH = 0.4  # [m] a turn
X_PJ = RigidTransform(RollPitchYaw([0.1, 0.2, 0.3]), [0.5, 0.0, 0.2])


def ball(yaw, pitch, roll):
    return RigidTransform(RollPitchYaw([roll, pitch, yaw]), [0, 0, 0])


def universal(x, y):
    R = RotationMatrix.MakeXRotation(x) @ RotationMatrix.MakeYRotation(y)
    return RigidTransform(R, [0, 0, 0])


def planar(x, y, theta):
    return RigidTransform(RotationMatrix.MakeZRotation(theta), [x, y, 0])


def screw(angle):
    shift = PITCH * angle / math.tau
    return RigidTransform(RotationMatrix.MakeZRotation(angle), [0, 0, shift])


# The motion of each kind, by Drake's documentation, and the names of its values.
KINDS = {
    'ball': (ball, ('j/yaw', 'j/pitch', 'j/roll')),
    'universal': (universal, ('j/qx', 'j/qy')),
    'planar': (planar, ('j/x', 'j/y', 'j/theta')),
    'screw': (screw, ('j',)),
}


def distance(motion, values):
    """The distance [m] of the ball on the child from the post."""
    p = (X_PJ @ motion(*values)) @ np.array([0.3, 0.2, 0.1])
    return float(np.linalg.norm(p - [3, 0, 0])) - 0.6


@pytest.fixture(params=KINDS)
def moved(request, tmp_path):
    """A scene file, names of values, states of them, and the distance at each."""
    motion, names = KINDS[request.param]
    thread = f'<drake:screw_thread_pitch value="{PITCH}"/>' if request.param == 'screw' else ''
    (tmp_path / 'r.urdf').write_text(ROBOT.format(request.param, thread))
    path = tmp_path / 'scene.yaml'
    path.write_text(SCENE)
    states = np.random.default_rng(3).uniform(-1.2, 1.2, (8, len(names)))
    return path, names, states, [distance(motion, values) for values in states]


def test_batches(moved):
    path, names, states, distances = moved
    scene_graph = SceneGraph()
    joints = Joints.of(load_scene(path, scene_graph))
    columns = [joints.names.index(f'r::{name}') for name in names]
    assert sorted(columns) == list(range(len(names)))
    states = states[:, np.argsort(columns)]
    least = evaluate(scene_graph, states=states, joints=joints, want='least')
    np.testing.assert_allclose(least.distance, distances, rtol=0.0, atol=1e-13)


def test_live_scenes(moved):
    path, names, states, distances = moved
    text = path.read_text().replace('r.urdf', str(path.with_name('r.urdf')))
    live, inputs = opened(text, Clock(1000.0))
    with live.editing() as scene:
        for values, truth in zip(states, distances, strict=True):
            assert inputs.take(scene, state(names, values, 1000.0), 0.0) == 1
            (pair,) = scene.query.ComputeSignedDistancePairwiseClosestPoints()
            assert pair.distance == pytest.approx(truth, abs=1e-13)


def test_recordings(moved, tmp_path):
    path, names, states, distances = moved
    messages = [
        (0.1 * k, '/joint_states', recorder.joint_state(0.1 * k, names, values))
        for k, values in enumerate(states)
    ]
    over_time = clearance(recorder.record(tmp_path / 'run', messages), path)
    np.testing.assert_allclose(over_time['all'].distance, distances, rtol=0.0, atol=1e-13)
