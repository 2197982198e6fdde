"""Layers of sensed maps: cells by age, shell and shadow, and what of them is sent."""

import numpy as np
import pytest
from live.inputs.sensing_node import cloud
from live.inputs.test_shadow_cells import ASIDE, AWAY, BEFORE, ON_PLATE, THING, Sensor, cell
from live.outputs.marker_types import TYPES
from live.outputs.test_marker_publisher import Publisher

from drake_geom_ros.live.outputs import obstacle_markers
from drake_geom_ros.live.outputs.marker_publisher import MarkerPublisher
from drake_geom_ros.live.outputs.markers import CUBE_LIST
from drake_geom_ros.live.outputs.obstacle_markers import colour_of, colour_step
from drake_geom_ros.viewing.looks import MAP_AGES, STALE_COLOUR


class Drawn:
    """A sensor, and what RViz shows of its map."""

    def __init__(self, **changes):
        self.sensor = Sensor(**changes)
        self.sensor.node.live.stale_after = 1.0
        self.publisher = Publisher()
        self.told = []
        live = self.sensor.node.live
        self.drawing = MarkerPublisher(
            live, self.publisher, TYPES, lambda: 0.1, lambda *_: None, self.told.append
        )

    def layers(self):
        """Return the rounded centres in the world by layer, and the markers sent of these."""
        self.drawing.publish()
        shown = {
            ns: {
                tuple(np.round(np.add([p.x, p.y, p.z], position), 2))
                for p in marker.points
                for position in [
                    [marker.pose.position.x, marker.pose.position.y, marker.pose.position.z]
                ]
            }
            for (ns, _), marker in self.publisher.shown.items()
            if marker.type == CUBE_LIST
        }
        sent = {m.ns for m in self.publisher.published[-1] if m.type == CUBE_LIST}
        return shown, sent


def test_each_layer_has_its_cells_and_is_sent_when_it_changes():
    drawn = Drawn(padding=0.2)
    assert drawn.layers() == ({}, set())
    beside = [1.0, 0.5, 0.0]
    drawn.sensor.see(100.0, AWAY, THING, ASIDE, beside)
    every = {'obstacles::points', 'shell::points', 'shadow::points'}
    cells = {cell(THING), cell(ASIDE), cell(beside)}
    assert drawn.layers() == ({'obstacles::points': cells}, every)
    assert drawn.layers() == ({'obstacles::points': cells}, set())
    drawn.sensor.see(100.5, BEFORE, ON_PLATE, ASIDE, [1.0, 0.31, 0.02])
    shown, sent = drawn.layers()
    assert sent == every
    assert shown['obstacles::points'] == {cell(THING), cell(ASIDE), cell(beside)} - {cell(beside)}
    assert shown['shadow::points'] == {cell(THING)}
    assert shown['shell::points'] == {cell([1.0, 0.31, 0.02])}
    assert drawn.told == []


def test_a_new_listener_gets_all_and_a_map_that_is_cleared_vanishes():
    drawn = Drawn()
    drawn.sensor.see(100.0, AWAY, THING, ASIDE)
    drawn.layers()
    drawn.publisher.listeners = drawn.publisher.get_subscription_count() + 1
    drawn.drawing._listeners = 0
    assert 'obstacles::points' in drawn.layers()[1]
    node = drawn.sensor.node
    with node.live.editing() as scene:
        known = scene.maps.by_name['points']
        scene.maps.by_name['points'] = known._replace(cells=None)
    assert drawn.layers()[0] == {}


def test_the_colour_tells_the_age():
    drawn = Drawn()
    drawn.sensor.see(100.0, AWAY, THING, ASIDE)
    colours = []
    for now in (100.0, 100.5, 100.99, 101.5):
        drawn.sensor.node.clock.now = now
        drawn.layers()
        colour = drawn.publisher.shown['obstacles::points', 0].color
        colours.append((colour.r, colour.g, colour.b, colour.a))
    assert colours[0] == pytest.approx(MAP_AGES[0])
    assert colours[0][0] < colours[1][0] < colours[2][0]
    assert colours[2] == pytest.approx(MAP_AGES[1])
    assert colours[3] == STALE_COLOUR


def test_steps_of_colour_grow_with_age_and_end_when_it_is_stale():
    steps = [colour_step(age, 2.0) for age in np.linspace(0.0, 2.5, 100)]
    assert steps == sorted(steps)
    assert (steps[0], steps[-1]) == (0, 8)
    assert colour_of(colour_step(2.0, 2.0)) == pytest.approx(MAP_AGES[1])
    assert colour_step(0.0, 0.0) == 0
    assert colour_step(0.1, 0.0) == colour_step(np.inf, 1.0) == 8


def test_a_large_map_is_drawn_by_larger_cells_that_cover_all(monkeypatch):
    monkeypatch.setattr(obstacle_markers, 'MOST_CELLS', 10)
    drawn = Drawn()
    points = np.random.default_rng(0).uniform([1.5, -1.0, -1.0], [3.0, 1.0, 1.0], (300, 3))
    drawn.sensor.see(100.0, AWAY, *points)
    shown, _ = drawn.layers()
    edge = drawn.publisher.shown['obstacles::points', 0].scale.x
    centres = np.array(sorted(shown['obstacles::points']))
    assert len(centres) <= 10
    for centre in drawn.sensor.node.centres():
        assert (np.abs(centres - centre).max(axis=1) <= 0.5 * edge - 0.04).any()


def test_maps_in_frames_of_their_own_are_drawn_there():
    drawn = Drawn()
    node = drawn.sensor.node
    node.move(100.0, AWAY)
    node.taker.take_cloud(cloud([[2.0, 0.0, 0.0]], 'eye'))
    assert drawn.layers()[0]['obstacles::points'] == {
        tuple(row) for row in np.round(node.centres(), 2).tolist()
    }
