"""The scene is published once a version, and a large one not too often; without ROS."""

import time
from types import SimpleNamespace as Plain

import pytest
from ros.live_scenes import Topic, live_scene

from drake_geom_ros.ros.outputs.scene_topic import SceneTopic

TEXT = 'sources: [s]\nframes: [{name: a, source: s}]\n'


class Message(Plain):
    """A message of any kind: what is not given is there and empty."""

    def __init__(self, **fields):
        super().__init__(header=Plain(), sources=[], frames=[], geometries=[], **fields)


class SlowTopic(Topic):
    """A publisher that takes some time."""

    def takes(self):
        """Let time pass: the test says how."""

    def publish(self, message):
        super().publish(message)
        self.takes()


@pytest.fixture
def live():
    return live_scene(TEXT, world_frame='map')


@pytest.fixture
def publisher():
    return SlowTopic()


@pytest.fixture
def did():
    return []


@pytest.fixture
def topic(live, publisher, did):
    types = Plain(Scene=Message, SceneSource=Plain, SceneFrame=Plain, SceneGeometry=Plain)
    return SceneTopic(live, publisher, types, lambda: 'now', lambda *what: did.append(what))


def test_each_version_is_published_once(scene, topic, publisher, did):
    for _ in range(3):
        topic.publish()
    (message,) = publisher.published
    assert (message.header.frame_id, message.header.stamp) == ('map', 'now')
    assert message.scene_version == scene.version
    ((count, seconds),) = did
    assert (count, seconds > 0.0) == (0, True)
    assert 'a' in [frame.name for frame in message.frames]
    scene.scene_graph.RegisterSource('t')
    topic.publish()
    assert [m.scene_version for m in publisher.published] == [scene.version - 1, scene.version]


def test_a_scene_that_takes_long_is_not_published_at_once_again(
    scene, topic, publisher, monkeypatch
):
    now = [100.0]
    monkeypatch.setattr(time, 'monotonic', lambda: now[0])

    def slowly():
        now[0] += 1.0

    publisher.takes = slowly
    for seconds, count in ((0.0, 1), (9.9, 1), (0.2, 2)):
        now[0] += seconds
        scene.scene_graph.RegisterSource(f'after {now[0]}')
        topic.publish_soon()
        assert len(publisher.published) == count
