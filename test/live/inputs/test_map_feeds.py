"""Two sensors on one input: each has a map of its own, and none hides what the other sees."""

import numpy as np
import pytest
from live.conversions.test_depth_image import camera, image
from live.inputs.sensing_node import Node, cloud, header
from live.inputs.test_beside_bodies import MAST, STEP, WALL, Watched, ball
from live.inputs.test_obstacles import near, octomap

from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.live.inputs.point_taker import PointTaker
from drake_geom_ros.live.scene.feeds import MOST_FEEDS
from drake_geom_ros.live.scene.map_placing import sensor_ages
from drake_geom_ros.sensed_maps.cells import Cells

SEES_IT, SEES_NOTHING = 'aa', 'bb'  # publishers
NEAR = np.concatenate([ball(0.045), WALL])  # 4.5 cm from the arm


class TwoSensors(Watched):
    """A rule about an arm that two sensors look at; one of them sees what is near it."""

    def hear(self, publisher):
        self.stamp += STEP
        self.node.clock.now = self.stamp
        self.node.move(self.stamp, [0.0, 0.0, 0.0])
        points = (NEAR if publisher == SEES_IT else WALL) - MAST
        self.node.taker.take_cloud(cloud(points, 'mast', self.stamp), 0.0, publisher)
        return self.decide()


def test_what_one_of_two_sensors_sees_is_near_whoever_spoke_last():
    watched = TwoSensors()
    watched.hear(SEES_IT)
    told = [watched.hear(who) for who in 4 * (SEES_NOTHING, SEES_IT)]
    assert [(state.is_entered, scale) for state, scale in told] == 8 * [(True, 0.0)]
    (trouble,) = watched.node.input.troubles()
    assert trouble.startswith('2 sensors feed ~/obstacles/points: frame ')


def test_a_map_is_as_old_as_what_the_sensor_showed_that_died():
    watched = TwoSensors()
    for who in (SEES_NOTHING, SEES_IT, SEES_NOTHING, SEES_IT):
        watched.hear(who)
    for k in range(1, 13):
        state, scale = watched.hear(SEES_NOTHING)
        assert watched.node.age() == pytest.approx(k * STEP)
        assert (state.is_entered, scale) == (True, 0.0)
    with watched.node.live.reading() as scene:
        ages = sensor_ages(scene)
    assert sorted(ages.values()) == [0.0, pytest.approx(12 * STEP)]
    assert all(name.startswith("points: frame 'mast', publisher ") for name in ages)


def test_a_driver_that_is_started_anew_takes_the_place_of_the_one_before():
    watched = TwoSensors()
    for _ in range(3):
        watched.hear(SEES_IT)
    entered = [watched.hear(SEES_NOTHING)[0].is_entered for _ in range(4)]
    assert entered == [True, True, False, False]
    assert watched.node.age() == 0.0
    assert watched.node.input.troubles() == []


def test_frames_that_alternate_have_a_map_each_and_never_take_each_others_place():
    node = Node(self_filter='none')
    for k in range(6):
        stamp = 100.0 + k * STEP
        node.clock.now = stamp
        node.taker.take_cloud(cloud([[1.01 + k, 0.01, 0.01]], ('mast', 'world')[k > 0], stamp))
    assert near(node.centres(), [[1.05, 0.05, 2.05], [6.05, 0.05, 0.05]])
    assert node.age() == pytest.approx(5 * STEP)
    assert "frame 'mast', publisher unknown: 0.625 s old" in node.input.troubles()[0]


def test_the_stamps_of_two_sensors_need_not_ascend_together():
    node = Node(self_filter='none')
    node.taker.take_cloud(cloud([[1, 0, 0]], stamp=100.0), 0.0, 'a')
    node.taker.take_cloud(cloud([[2, 0, 0]], stamp=99.9), 0.0, 'b')
    with pytest.raises(ArgumentError, match=r'its stamp is 0\.100 s before'):
        node.taker.take_cloud(cloud([[3, 0, 0]], stamp=99.8), 0.0, 'b')
    assert len(node.centres()) == 2


def test_each_sensor_holds_cells_of_its_own_in_another_process_too():
    node = Node(self_filter='none', keep=10.0)
    for who, x in (('a', 1.0), ('b', 2.0)):
        node.taker.take_cloud(cloud([[x, 0.01, 0.01]]), 0.0, who)
    node.taker = PointTaker(node.input)
    node.clock.now = 100.1
    for who in 'ab':
        node.taker.take_cloud(cloud([[3.0, 0.01, 0.01]], stamp=100.1), 0.0, who)
    assert len(node.centres()) == 3
    assert node.input.counts.held_cells == 1  # of its own


def test_no_more_sensors_feed_a_map_than_memory_is_for():
    node = Node(self_filter='none')
    for k in range(MOST_FEEDS):
        node.taker.take_cloud(cloud([[1, k, 0]]), 0.0, f'{k}')
    assert len(node.centres()) == MOST_FEEDS
    with pytest.raises(ArgumentError, match='and 16 others feed the map'):
        node.taker.take_cloud(cloud([[1, 99, 0]]), 0.0, 'one more')
    node.input.forget()
    node.taker.take_cloud(cloud([[1, 99, 0]]), 0.0, 'one more')


def test_octomaps_of_two_servers_are_joined_in_the_coarser_grid():
    node = Node('octomap')
    node.move(100.0, [1.0, 0.0, 0.0])
    fine = Cells.of_points([[0.26, 0.06, 0.06]], 0.1)
    coarse = Cells.of_points([[3.1, 0.1, 0.1]], 0.2)
    node.input.take_octomap(octomap(fine, 'arm'), 0.0, 'a')
    node.input.take_octomap(octomap(coarse, 'world'), 0.0, 'b')
    found = node.centres()
    assert near(found[-1:], [[3.1, 0.1, 0.1]])
    assert [0.1, 0.1] in (found[:, 1:].round(9)).tolist()
    assert (abs(found[:, 0] - 1.25) <= 0.2).any()
    with node.live.reading() as scene:
        assert scene.maps.by_name['octomap'].cells.resolution == 0.2


def test_camera_infos_of_two_cameras_are_each_for_their_own_images():
    node = Node(self_filter='none')
    frames = {'mast': camera(2, 1), 'world': camera(2, 1)}
    for frame, info in frames.items():
        info.header = header(frame, 100.0)
        node.taker.take_camera(info)
    for frame in frames:
        depths = image(np.full((1, 2), 1.0))
        depths.header = header(frame, 100.0)
        node.taker.take_depth(depths)
    assert {round(z, 6) for z in node.centres()[:, 2]} == {1.05, 3.05}
