"""The scene is published once a version, and a large one not too often; without ROS."""

import time
from types import SimpleNamespace as Plain

import pytest
from live.live_scenes import Topic, live_scene

from drake_geom_ros.geometry import GeometryInstance, Sphere
from drake_geom_ros.live.outputs import scene_topic
from drake_geom_ros.live.outputs.scene_topic import SceneTopic
from drake_geom_ros.live.scene.change import Change
from drake_geom_ros.live.scene.changes.attachment import attachment
from drake_geom_ros.math import RigidTransform

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


def register_source(scene, name):
    return scene.make(Change(lambda graph, _: graph.RegisterSource(name)))


def register_ball(scene, source, ball):
    return scene.make(Change(lambda graph, _: graph.RegisterAnchoredGeometry(source, ball)))


def test_each_version_is_published_once(scene, topic, publisher, did):
    for _ in range(3):
        topic.publish()
    (message,) = publisher.published
    assert (message.header.frame_id, message.header.stamp) == ('map', 'now')
    assert message.scene_version == scene.model.version
    ((count, seconds),) = did
    assert (count, seconds > 0.0) == (0, True)
    assert 'a' in [frame.name for frame in message.frames]
    register_source(scene, 't')
    while len(publisher.published) < 2:
        topic.publish()
    assert [m.scene_version for m in publisher.published] == [
        scene.model.version - 1,
        scene.model.version,
    ]


def test_all_names_that_answers_refer_to_are_published_in_order_and_shapes_when_there_is_time(
    scene, topic, publisher, monkeypatch
):
    monkeypatch.setattr(scene_topic, 'fill_scene', lambda *_: None)  # versions are enough here
    source = register_source(scene, 't')
    named = []
    for k in range(5):
        instance = GeometryInstance(RigidTransform(), Sphere(0.1), f'ball {k}')
        ball = register_ball(scene, source, instance)
        if k != 3:  # to which nobody refers
            named.append(scene.moment().names_version)
    monkeypatch.setattr(time, 'monotonic', lambda: 100.0)
    topic.publish()
    assert [m.names_version for m in publisher.published] == named
    scene.make(Change(lambda graph, _: graph.ChangeShape(source, ball, Sphere(0.2))))
    assert scene.moment().names_version == named[-1] < scene.moment().version
    monkeypatch.setattr(topic, '_next', 101.0)
    topic.publish()
    assert len(publisher.published) == 4
    monkeypatch.setattr(topic, '_next', 99.0)
    topic.publish()
    assert publisher.published[-1].names_version == named[-1]
    assert publisher.published[-1].scene_version == scene.model.version


def test_what_cannot_be_published_in_time_is_counted(scene, topic, publisher):
    for k in range(scene_topic._MOST_WAITING + 3):
        register_source(scene, f'{k}')
        scene.moment()
    assert topic.unpublished == 3
    topic.publish()
    assert len(publisher.published) == scene_topic._MOST_WAITING


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
        register_source(scene, f'after {now[0]}')
        topic.publish()
        assert len(publisher.published) == count


HAND = """
frames: [{name: hand, source: s, pose: {}}, {name: part, source: s, pose: {position: [1, 0, 0]}}]
geometries:
- {name: hand, source: s, frame: hand, shape: {type: sphere, radius: 0.1}}
- {name: part, source: s, frame: part, shape: {type: sphere, radius: 0.1}}
"""


def no_pose():
    """Return a geometry_msgs/Pose."""
    return Plain(
        position=Plain(x=0.0, y=0.0, z=0.0), orientation=Plain(x=0.0, y=0.0, z=0.0, w=1.0)
    )


class Frame(Plain):
    """A SceneFrame."""

    def __init__(self, **fields):
        super().__init__(attached_pose=no_pose(), touch_links=[], **fields)


class Geometry(Plain):
    """A SceneGeometry."""

    def __init__(self, **fields):
        shape = Plain(mesh_uri='', vertices=[], triangles=[])
        super().__init__(pose=no_pose(), shape=shape, roles=[], **fields)


def test_an_attachment_is_told_with_its_pose_and_until_its_filter_ends(publisher):
    live, (part, hand) = live_scene(HAND), ('s::part', 's::hand')
    kinds = {
        'SceneFrame': Frame,
        'SceneGeometry': Geometry,
        'Role': lambda **_: Plain(properties=[]),
    }
    types = Plain(Scene=Message, SceneSource=Plain, **kinds)
    topic = SceneTopic(live, publisher, types, lambda: 'now', lambda *_: None)

    def published():
        topic._next = 0.0
        topic.publish()
        return next(f for f in publisher.published[-1].frames if f.name == 'part')

    with live.editing() as scene:
        names = scene.model.names
        frame, parent = names.frame(part), names.frame(hand)
        touching = [names.geometry(f'{hand}/hand')]
        scene.make(attachment(scene, frame, parent, touching=touching))
    there = published()
    assert there.is_attached
    assert there.attached_pose.position.x == 1.0
    assert there.touch_links == [f'{hand}/hand']
    with live.editing() as scene:
        scene.model.filter_manager.RemoveDeclaration(scene.filters.touch_links.filter_of(frame))
    there = published()
    assert there.is_attached
    assert there.touch_links == []
    count = len(publisher.published)
    published()
    assert len(publisher.published) == count
