"""Poses of all geometries, flat: for those who look, and the same as the core's."""

from types import SimpleNamespace as Plain

import numpy as np
import pytest
from live.live_scenes import live_scene

from drake_geom_ros.geometry import GeometryId
from drake_geom_ros.live.outputs.geometry_poses import GeometryPoses
from drake_geom_ros.live.scene.change import Change

TEXT = """
sources: [s]
frames:
  - {name: a, source: s, pose: {position: [1, 2, 3], rpy: [0.3, 0.2, 0.1]}}
  - {name: b, source: s, parent: a, pose: {position: [0, 1, 0]}}
  - {name: lost, source: s}
geometries:
  - {name: post, source: s, shape: {type: sphere, radius: 0.1}, pose: {position: [9, 0, 0]}}
  - {name: ball, source: s, frame: b, shape: {type: sphere, radius: 0.1},
     pose: {position: [0, 0, 4], rpy: [1, 2, 3]}}
  - {name: seen, source: s, frame: a, shape: {type: sphere, radius: 0.2},
     roles: {illustration: {}}}
  - {name: nowhere, source: s, frame: lost, shape: {type: sphere, radius: 0.2}}
"""


class Publisher:
    def __init__(self):
        self.listeners, self.messages = 1, []

    def get_subscription_count(self):
        return self.listeners

    def publish(self, message):
        self.messages.append(message)


@pytest.fixture
def live():
    return live_scene(TEXT, world_frame='map')


def test_every_geometry_that_has_a_place_is_told(live):
    publisher, did = Publisher(), []
    poses = GeometryPoses(
        live, publisher, lambda: Plain(header=Plain(stamp=None)), lambda *how: did.append(how)
    )
    poses.publish()
    (message,) = publisher.messages
    view = live.view()
    names = [view.query.inspector().GetName(GeometryId(id)) for id in message.ids]
    assert sorted(names) == ['ball', 'post', 'seen']
    assert list(message.ids) == sorted(message.ids)
    for id, row in zip(message.ids, np.reshape(message.poses, (-1, 7)), strict=True):
        X_WG = view.query.X_WG(GeometryId(id))
        np.testing.assert_allclose(row, X_WG.ToArray(), rtol=0, atol=1e-14)
    assert message.header.frame_id == 'map'
    assert message.scene_version == view.moment.version
    assert did[0][0] == 3


def test_nothing_is_done_for_nobody(live):
    publisher, did = Publisher(), []
    publisher.listeners = 0
    GeometryPoses(live, publisher, None, lambda *how: did.append(how)).publish()
    assert (publisher.messages, did) == ([], [])


def test_a_changed_scene_is_seen(live):
    publisher = Publisher()
    poses = GeometryPoses(
        live, publisher, lambda: Plain(header=Plain(stamp=None)), lambda *_: None
    )
    poses.publish()
    with live.editing() as scene:
        seen = scene.model.names.geometry('a/seen')
        source = scene.model.inspector.GetOwningSourceId(seen)
        scene.make(Change(lambda graph, _: graph.RemoveGeometry(source, seen)))
    poses.publish()
    assert [len(message.ids) for message in publisher.messages] == [3, 2]
