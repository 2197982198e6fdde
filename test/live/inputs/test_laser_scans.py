"""Laser scans in the scene: cells, rays of a base that turns, columns, frames, ages. No ROS."""

import math

import numpy as np
import pytest
from live.inputs.sensing_node import Node, cloud, scan

from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.scene_files import ObstacleSource
from drake_geom_ros.sensed_maps import Cells

RES = 0.1  # [m]


def node_of(**keys):
    """Return a node with a source of scans, and its arm far away."""
    node = Node(source=ObstacleSource('front', 'laser_scan', '/scan', **keys))
    node.move(100.0, [0, 0, -5])
    return node


def seen(points):
    return Cells.of_points(points, RES).centres().tolist()


def test_a_scan_becomes_cells_where_it_ended():
    node = node_of()
    node.taker.take_scan(scan([1.0, 2.03, 1.0]))
    assert node.centres().tolist() == seen([[0, -1, 2], [2.03, 0, 2], [0, 1, 2]])
    assert node.input.counts.points == 3


def test_a_scan_without_a_ray_is_refused_and_the_map_grows_old():
    """Ranges that are none are no sight of free space."""
    node = node_of()
    node.taker.take_scan(scan([1.0, 2.0, 1.0]))
    before = node.centres().tolist()
    node.clock.now = 101.0
    node.move(101.0, [0, 0, -5])
    with pytest.raises(ArgumentError, match='shows nothing'):
        node.taker.take_scan(scan([math.nan, 0.01, 11.0], stamp=101.0))
    assert node.centres().tolist() == before
    assert node.age() == pytest.approx(1.0)


def test_a_scan_by_rays_without_an_echo_empties_its_map_and_keeps_it_fresh():
    node = node_of()
    never, _ = node.pairs()
    node.taker.take_scan(scan([1.0, 2.0, 1.0]))
    assert node.pairs() != (never, 0)
    node.clock.now = 101.0
    node.move(101.0, [0, 0, -5])
    node.taker.take_scan(scan([math.inf, math.nan, math.inf], stamp=101.0))
    assert node.centres().tolist() == []
    assert node.age() == 0.0
    assert node.pairs() == (never, 0)  # no pair waits, as one does before the first message
    node.taker.take_scan(scan([1.0, math.inf, math.inf], stamp=101.0))
    assert len(node.centres()) == 1


def test_cells_of_before_are_held_where_no_ray_has_an_echo():
    node = node_of(keep=2.0)
    node.taker.take_scan(scan([1.0, math.inf, math.inf]))
    for stamp, cells in ((101.0, 1), (102.5, 0)):
        node.clock.now = stamp
        node.move(stamp, [0, 0, -5])
        node.taker.take_scan(scan([math.inf] * 3, stamp=stamp))
        assert len(node.centres()) == cells


def test_each_ray_ends_where_the_sensor_was_at_its_time():
    """The base makes a quarter turn while the scan is measured, and drives on by 1 m."""
    node = node_of()
    node.move(100.5, [1, 0, -5], yaw=math.pi / 2)
    node.clock.now = 100.5
    rays = scan(
        [2.0, 2.0, 2.0], frame='arm', angle_min=0.0, angle_increment=0.0, time_increment=0.25
    )
    node.taker.take_scan(rays)
    half = 2.0 * math.sqrt(0.5)
    assert node.centres().tolist() == seen([[2, 0, -5], [0.5 + half, half, -5], [1, 2, -5]])


def test_what_a_flat_scan_sees_stands_for_a_column():
    node = node_of(extrude=(0.0, 1.0))
    node.taker.take_scan(scan([1.0, 2.03, 1.0]))
    columns = [[x, y, z] for x, y in ((0, -1), (2.03, 0), (0, 1)) for z in np.arange(0.05, 1, RES)]
    assert node.centres().tolist() == seen([*columns, [0, -1, 2], [2.03, 0, 2], [0, 1, 2]])


def test_a_column_goes_as_soon_as_its_scan_does():
    """A lidar sees past no cell above its plane: these do not stay on that account."""
    node = node_of(extrude=(0.0, 2.5))
    node.taker.take_scan(scan([1.0, 3.3, 1.0]))
    node.clock.now = 100.1
    node.move(100.1, [0, 0, -5])
    node.taker.take_scan(scan([1.0, 9.0, 1.0], stamp=100.1))
    assert not any(abs(x - 3.3) < 0.2 for x, _, _ in node.centres().tolist())


def test_the_frame_of_the_source_counts():
    node = node_of(frame='mast')
    node.taker.take_scan(scan([1.0, 2.0, 1.0], frame='whatever'))
    assert len(node.centres()) == 3


def test_settings_of_a_source_go_before_those_of_the_node():
    node = node_of(resolution=0.5, range=1.5)
    node.taker.take_scan(scan([1.0, 2.0, 1.0]))
    with node.live.reading() as scene:
        assert scene.maps.by_name['front'].cells.resolution == 0.5
    assert len(node.centres()) == 2  # the third ray ended beyond its range


@pytest.mark.parametrize(('timeout', 'is_stale'), [(None, True), (0.5, True), (5.0, False)])
def test_a_map_is_stale_from_the_timeout_of_its_source_on(timeout, is_stale):
    node = node_of(timeout=timeout)
    node.taker.take_scan(scan([1.0, 2.0, 1.0]))
    node.clock.now = 102.0
    with node.live.reading() as scene:
        frame = scene.maps.by_name['front'].frame.get_value()
        assert (frame in scene.blind_frames(1.0).stale) == is_stale
        assert (frame in scene.view(stale_after=1.0).stale) == is_stale


def test_a_map_that_is_not_required_blinds_no_rule_but_is_named_as_stale():
    node = node_of(required=False)
    with node.live.reading() as scene:
        frame = scene.maps.by_name['front'].frame.get_value()
        assert frame not in scene.blind_frames(1.0).absent
    node.taker.take_scan(scan([1.0, 2.0, 1.0]))
    node.clock.now = 102.0
    with node.live.reading() as scene:
        assert frame not in scene.blind_frames(1.0).stale
        assert frame in scene.view(stale_after=1.0).stale


@pytest.mark.parametrize('required', [True, False])
def test_a_map_that_is_not_required_is_no_evidence_that_a_body_is_seen(required):
    node = node_of(required=required)
    node.taker.take_scan(scan([1.0, 2.0, 1.0]))
    with node.live.reading() as scene:
        assert bool(scene.maps.sights()) == required


def test_a_scan_sees_no_farther_than_its_range():
    node = node_of(range=5.0)
    node.taker.take_scan(scan([1.0, 2.0, 1.0], range_max=2.5))
    with node.live.reading() as scene:
        ((_, (sight,)),) = scene.maps.sights()
    assert sight.reach == 2.5


def test_too_many_rays_are_refused(monkeypatch):
    monkeypatch.setattr('drake_geom_ros.live.inputs.point_taker.MOST_POINTS', 2)
    node = node_of()
    with pytest.raises(ArgumentError, match='3 rays'):
        node.taker.take_scan(scan([1.0, 1.0, 1.0]))
    with pytest.raises(ArgumentError, match='rows'):
        node.taker.take_cloud(cloud([[1, 0, 0]] * 3))


BESIDE = [math.nan, 2.0, math.nan]  # [m] a point that the middle ray of a scan ends at


@pytest.mark.parametrize(
    ('ranges', 'cells'), [([math.nan, math.nan, 1.0], 1), ([math.inf] * 3, 0)]
)
def test_a_cell_beside_a_body_goes_with_rays_past_it(ranges, cells):
    """One that a ray without an echo passes is free; ranges that are none say nothing of it."""
    node = node_of(padding=0.3)
    node.move(100.0, [2.0, 0.3, 2.0])  # the hand, 0.2 m from the point
    node.taker.take_scan(scan(BESIDE))
    assert node.input.counts.shell_cells == 1
    node.clock.now = 100.1
    node.move(100.1, [2.0, 0.3, 2.0])
    node.taker.take_scan(scan(ranges, stamp=100.1))
    assert node.input.counts.shell_cells == cells


@pytest.mark.parametrize(
    ('ranges', 'cells'), [([math.nan, math.nan, 1.0], 2), ([math.inf] * 3, 0)]
)
def test_a_held_cell_goes_with_rays_past_it(ranges, cells):
    node = node_of(keep=9.0, rays=True)
    node.taker.take_scan(scan(BESIDE))
    node.clock.now = 100.1
    node.move(100.1, [0, 0, -5])
    node.taker.take_scan(scan(ranges, stamp=100.1))
    assert len(node.centres()) == cells


def test_rays_without_an_echo_turn_with_the_base():
    """The middle ray points along y when it is measured, and passes what was there."""
    node = node_of(keep=9.0, rays=True)
    node.taker.take_scan(scan([2.0], frame='arm', angle_min=math.pi / 2))
    node.move(101.0, [0, 0, -5])
    node.move(102.0, [0, 0, -5], yaw=math.pi)
    node.clock.now = 102.0
    turning = {'angle_min': 0.0, 'angle_increment': 0.0, 'time_increment': 0.5}
    rays = [math.nan, math.inf, math.nan]
    node.taker.take_scan(scan(rays, frame='arm', stamp=101.0, **turning))
    assert len(node.centres()) == 0
