"""Cells behind the robot, as its sensor sees it, are unknown: they stay until it looks there."""

from dataclasses import replace

import numpy as np
import pytest
from live.inputs.sensing_node import Node, cloud

from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.scene_files import ObstacleSource

# A sensor at the origin that looks along x, a plate that comes before it, and things behind.
SCENE = """
sources: [s]
frames:
- {name: arm, source: s}
- {name: eye, source: s, static: true, pose: {position: [0, 0, 0.02]}}
geometries:
- {name: plate, source: s, frame: arm, shape: {type: box, size: [0.02, 0.4, 0.4]}}
"""
AWAY, BEFORE = [0.0, 0.0, 50.0], [1.0, 0.0, 0.0]
THING, ASIDE = [2.05, 0.05, 0.03], [2.05, 1.05, 0.03]
ON_PLATE = [0.99, 0.05, 0.03]


class Sensor:
    """Sees points in the world at times, beside a plate that is somewhere then."""

    def __init__(self, **changes):
        self.node = Node(scene=SCENE, self_filter='scene', **changes)

    def see(self, stamp, plate, *points):
        self.node.clock.now = stamp
        self.node.move(stamp, plate)
        self.node.taker.take_cloud(cloud(np.array(points) - [0.0, 0.0, 0.02], 'eye', stamp))

    def cells(self):
        return {tuple(np.round(centre, 2)) for centre in self.node.centres().tolist()}


def cell(point):
    return tuple(np.round((np.floor(np.array(point) / 0.1) + 0.5) * 0.1, 2))


@pytest.mark.parametrize('rays', [False, True])
@pytest.mark.parametrize('keep', [0.0, 0.5])
def test_a_thing_that_the_plate_hides_stays_until_the_sensor_looks_there_again(keep, rays):
    sensor = Sensor(keep=keep, rays=rays)
    sensor.see(100.0, AWAY, THING, ASIDE)
    for stamp in (100.5, 101.0, 105.0):  # longer than any cell is kept
        sensor.see(stamp, BEFORE, ON_PLATE, ASIDE)
        assert sensor.cells() == {cell(THING), cell(ASIDE)}
        assert sensor.node.input.counts.shadow_cells == 1
    sensor.see(105.1, AWAY, ASIDE)
    assert (cell(THING) in sensor.cells()) == (keep > 0.0)  # it was unseen for 0.1 s
    assert sensor.node.input.counts.shadow_cells == 0
    sensor.see(106.0, AWAY, ASIDE)
    assert sensor.cells() == {cell(ASIDE)}


@pytest.mark.parametrize('keep', [0.0, 0.5, 4.0])
def test_a_hidden_cell_goes_once_it_is_unseen_for_keep_hidden(keep):
    sensor = Sensor(keep=keep, keep_hidden=2.0)
    sensor.see(100.0, AWAY, THING, ASIDE)
    sensor.see(101.9, BEFORE, ON_PLATE, ASIDE)
    assert cell(THING) in sensor.cells()
    sensor.see(102.1, BEFORE, ON_PLATE, ASIDE)
    assert (cell(THING) in sensor.cells()) == (keep > 2.0)
    assert sensor.node.input.counts.held_shell_cells == 0
    sensor.see(104.5, BEFORE, ON_PLATE, ASIDE)
    assert sensor.cells() == {cell(ASIDE)}


def test_a_cell_of_the_shell_goes_once_it_is_unseen_for_keep_hidden():
    sensor = Sensor(padding=0.2, keep_hidden=2.0)
    sensor.see(100.0, AWAY, [1.15, 0.05, 0.03], ASIDE)
    sensor.see(100.5, BEFORE, ON_PLATE, ASIDE)
    further = [0.6, 0.0, 0.0]
    for stamp, held in ((101.5, 1), (102.5, 0)):
        sensor.see(stamp, further, [0.59, 0.05, 0.03], ASIDE)
        assert sensor.node.input.counts.held_shell_cells == held


def test_no_self_filter_has_no_shadow():
    sensor = Sensor()
    sensor.node.settings = sensor.node.settings._replace(self_filter='none')
    sensor.see(100.0, AWAY, THING, ASIDE)
    sensor.see(100.5, BEFORE, ASIDE)
    assert sensor.cells() == {cell(ASIDE)}


def test_a_thing_beyond_the_range_is_not_in_the_shadow():
    sensor = Sensor(reach=5.0)
    sensor.see(100.0, AWAY, THING, ASIDE)
    sensor.node.settings = sensor.node.settings._replace(reach=1.5)
    sensor.see(100.5, BEFORE, [1.0, 0.5, 0.0])
    assert cell(THING) not in sensor.cells()


def test_a_cell_beside_the_plate_that_hides_it_is_in_the_shell_and_in_no_distance():
    sensor = Sensor(padding=0.2)
    behind = [1.15, 0.05, 0.03]
    sensor.see(100.0, AWAY, behind, ASIDE)
    sensor.see(100.5, BEFORE, ON_PLATE, ASIDE)
    assert sensor.cells() == {cell(ASIDE)}
    assert sensor.node.input.counts.held_shell_cells == 1
    further = [0.6, 0.0, 0.0]  # it hides the place from farther away: nobody knows yet
    sensor.see(101.0, further, [0.59, 0.05, 0.03], ASIDE)
    assert sensor.node.input.counts.held_shell_cells == 1
    sensor.see(101.5, AWAY, ASIDE)
    assert sensor.node.input.counts.held_shell_cells == 0


def test_points_in_the_world_have_no_sensor_whose_shadow_there_could_be():
    sensor = Sensor()
    sensor.see(100.0, AWAY, THING, ASIDE)
    node = sensor.node
    for stamp, plate, points in ((101.0, AWAY, [THING, ASIDE]), (101.5, BEFORE, [ASIDE])):
        node.clock.now = stamp
        node.move(stamp, plate)
        node.taker.take_cloud(cloud(points, 'world', stamp), 0.0, 'helper')
    assert node.input.counts.shadow_cells == 0


class InWorld(Sensor):
    """The same, of a driver that sends its clouds in the world's frame."""

    def __init__(self, **changes):
        source = ObstacleSource('points', 'point_cloud', '/points', sensor='eye')
        self.node = Node(scene=SCENE, self_filter='scene', source=source, **changes)

    def see(self, stamp, plate, *points):
        self.node.clock.now = stamp
        self.node.move(stamp, plate)
        self.node.taker.take_cloud(cloud(np.array(points), 'world', stamp))


@pytest.mark.parametrize(
    'changes',
    [{}, {'keep': 0.5, 'rays': True}, {'padding': 0.2, 'keep': 1.0}, {'reach': 2.35}],
)
def test_a_cloud_in_the_world_is_as_one_of_the_frame_that_its_source_names(changes):
    """Reach, rays, shell and shadow begin at the sensor, wherever points are given."""
    of_eye, in_world = Sensor(**changes), InWorld(**changes)
    seen = [
        (100.0, AWAY, THING, ASIDE, [1.15, 0.05, 0.03]),
        (100.4, BEFORE, ON_PLATE, ASIDE),
        (101.0, BEFORE, ON_PLATE, ASIDE, [0.5, 0.3, 0.03]),
        (105.0, AWAY, ASIDE, [3.05, 0.07, 0.04]),
    ]
    for message in seen:
        of_eye.see(*message)
        in_world.see(*message)
        assert in_world.cells() == of_eye.cells()
        first, second = of_eye.node.input.counts, in_world.node.input.counts
        assert replace(second, seconds=0.0) == replace(first, seconds=0.0)


def test_without_a_sensor_a_cloud_in_the_world_has_no_shadow():
    sensor = InWorld()
    sensor.node = Node(scene=SCENE, self_filter='scene')
    sensor.see(100.0, AWAY, THING, ASIDE)
    sensor.see(100.5, BEFORE, ON_PLATE, ASIDE)
    assert sensor.cells() == {cell(ASIDE)}


def test_a_sensor_that_is_not_known_is_refused():
    source = ObstacleSource('points', 'point_cloud', '/points', sensor='nowhere')
    node = Node(scene=SCENE, source=source)
    node.move(100.0, AWAY)
    with pytest.raises(ArgumentError, match='nowhere'):
        node.taker.take_cloud(cloud([THING], 'world'))
