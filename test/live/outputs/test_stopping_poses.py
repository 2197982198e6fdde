"""Poses of a rod on the way of its stop, against the angle that it turns until it stands."""

import numpy as np
import pytest
from drake_geom_msgs.msg import GeometryPoses
from live.live_scenes import Topic
from live.scene.test_scene_stopping import Cell

from drake_geom_ros.live.outputs.stopping_poses import StoppingPoses

ANGLE, SPEED, BRAKING = 0.3, 1.2, 2.0  # [rad], [rad/s], [rad/s^2]


@pytest.fixture
def cell(tmp_path):
    return Cell(tmp_path)


@pytest.fixture
def poses(cell):
    topic = Topic()
    return topic, StoppingPoses(cell.live, topic, GeometryPoses, lambda count, seconds: None)


def angles(message):
    """Return the angles [rad] about z of the poses of a message, whose origins turn with them."""
    x, y, _, *quaternions = np.reshape(message.poses, (-1, 7)).T
    np.testing.assert_allclose(np.hypot(x, y), 0.5, rtol=1e-12)
    turned = 2.0 * np.arctan2(quaternions[2], quaternions[3])
    np.testing.assert_allclose(turned, np.arctan2(y, x), rtol=0, atol=1e-12)
    return turned


def test_the_last_place_is_where_the_rod_stands(cell, poses):
    topic, output = poses
    cell.cycle(ANGLE, SPEED)
    stop = cell.cycle(ANGLE, SPEED)
    output.publish()
    (message,) = topic.published
    travel = SPEED * (stop.reaction_time[0] + 0.5 * SPEED / BRAKING)
    expected = ANGLE + travel * np.array([0.25, 0.5, 0.75, 1.0])
    np.testing.assert_allclose(angles(message), expected, rtol=0, atol=1e-9)
    with cell.live.reading() as scene:
        names = {scene.model.names.name_of_value(int(value)) for value in message.ids}
    assert names == {'rod::rod/collision_0'}


def test_a_rod_that_stands_has_no_way(cell, poses):
    topic, output = poses
    cell.cycle(ANGLE, 0.0)
    output.publish()
    assert topic.published == []
    cell.cycle(ANGLE, SPEED)
    output.publish()
    cell.cycle(ANGLE, 0.0)
    output.publish()
    output.publish()
    assert [len(message.ids) for message in topic.published] == [4, 0]


def test_a_rod_of_unknown_speed_has_no_way(cell, poses):
    topic, output = poses
    cell.cycle(ANGLE)
    output.publish()
    assert topic.published == []


def test_nothing_is_computed_without_a_listener(cell, poses):
    topic, output = poses
    topic.listeners = 0
    cell.cycle(ANGLE, SPEED)
    output.publish()
    assert topic.published == []
