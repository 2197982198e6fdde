"""The live scene on Drake's visualiser: loaded, drawn, and loaded again for who comes later."""

import pytest
from live.live_scenes import TWO_BALLS, live_scene

from drake_geom_ros.geometry import GeometryError
from drake_geom_ros.live.outputs import visualizer
from drake_geom_ros.live.outputs.visualizer import Visualizer

LOAD, DRAW = 'DRAKE_VIEWER_LOAD_ROBOT', 'DRAKE_VIEWER_DRAW'


class Wire:
    def __init__(self):
        self.sent = []

    def publish(self, channel, data):
        self.sent.append((channel, data))


@pytest.fixture
def wire(monkeypatch):
    wire = Wire()
    monkeypatch.setattr(visualizer, 'open_lcm', lambda url: wire)
    return wire


def test_each_drawing_is_sent_and_the_scene_before_it(wire, monkeypatch):
    now = [0.0]
    monkeypatch.setattr(visualizer.time, 'monotonic', lambda: now[0])
    drawing = Visualizer(live_scene(TWO_BALLS), 'udpm://')
    for moment in (100.0, 101.0, 102.0, 107.0):
        now[0] = moment
        drawing.draw()
    assert [channel for channel, _ in wire.sent] == [LOAD, DRAW, DRAW, DRAW, LOAD, DRAW]
    # Nothing here has the illustration role: what queries see is shown.
    assert all(name in wire.sent[0][1] for name in (b's::a\0', b's::b\0', b'world\0'))
    assert b's::b\0' in wire.sent[1][1]


def test_geometry_for_eyes_is_preferred(wire):
    text = TWO_BALLS + '- {name: seen, source: s, frame: b, shape: {type: sphere, radius: 1}, '
    drawing = Visualizer(live_scene(text + 'roles: {illustration: {}}}\n'), 'udpm://')
    drawing.draw()
    assert b's::b\0' in wire.sent[0][1]
    assert b's::a\0' not in wire.sent[0][1]


def test_without_the_library_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(__import__('sys').modules, 'lcm', None)
    with pytest.raises(GeometryError, match="extra 'lcm'"):
        Visualizer(live_scene(TWO_BALLS), 'udpm://')
