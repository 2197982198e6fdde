"""What is cut off by a box or by a range is not seen, and rules about it know."""

import pytest
from live.inputs.sensing_node import cloud
from live.inputs.test_beside_bodies import MAST, STEP, WALL, Watched
from live.inputs.test_obstacles import octomap

from drake_geom_ros.sensed_maps.cells import Cells

AWAY = (0.5, -1.0, -1.0, 2.0, 1.0, 1.0)  # a box without the arm


def troubles(watched):
    with watched.node.live.editing() as scene:
        return [told for told in scene.troubles() if told.startswith('no sensor sees')]


@pytest.mark.parametrize('changes', [{'box': AWAY}, {'reach': 1.5}])
def test_a_rule_about_a_body_that_no_sensor_can_see_is_entered_and_says_so(changes):
    watched = Watched(**changes)
    watched.see(WALL)
    state, scale = watched.decide()
    assert (state.is_entered, scale) == (True, 0.0)
    (told,) = troubles(watched)
    assert told.startswith('no sensor sees s::arm/forearm: beyond obstacle_reach')


@pytest.mark.parametrize(
    'changes', [{}, {'box': (0.2, -1.0, -1.0, 2.0, 1.0, 1.0)}, {'reach': 2.0}]
)
def test_a_body_that_is_in_sight_in_part_is_seen(changes):
    watched = Watched(**changes)
    watched.see(WALL)
    state, scale = watched.decide()
    assert (state.is_entered, scale) == (False, 1.0)
    assert troubles(watched) == []


def test_the_rule_is_left_where_the_arm_comes_into_sight_or_another_sensor_sees_it():
    for comes in (True, False):
        watched = Watched(box=AWAY)
        watched.see(WALL)
        assert watched.decide()[0].is_entered
        node = watched.node
        node.clock.now = watched.stamp = watched.stamp + STEP
        node.move(watched.stamp, [0.9 if comes else 0.0, 0.0, 0.0])
        if not comes:
            node.settings = node.settings._replace(box=())
        node.taker.take_cloud(cloud(WALL - MAST, 'mast', watched.stamp), 0.0, 'another')
        assert not watched.decide()[0].is_entered


def test_an_octomap_is_cut_by_the_box_alone():
    for box, entered in ((AWAY, True), ((), False)):
        watched = Watched(name='octomap', box=box, reach=0.1)
        far = Cells.of_points([[1.01, 0.01, 0.01]], 0.1)
        watched.node.input.take_octomap(octomap(far, 'world'))
        assert watched.decide()[0].is_entered == entered
