"""Everything is drawn for who comes, then what moved; what is gone vanishes."""

from types import SimpleNamespace as Plain

import pytest
from live.live_scenes import Topic, live_scene
from live.outputs.marker_types import TEXT, TYPES

from drake_geom_ros.geometry import (
    Capsule,
    FramePoseVector,
    Sphere,
)
from drake_geom_ros.live.outputs import markers
from drake_geom_ros.live.outputs.marker_publisher import MarkerPublisher
from drake_geom_ros.live.scene.change import Change
from drake_geom_ros.live.scene.feeders import MESSAGES
from drake_geom_ros.math import RigidTransform, RollPitchYaw
from drake_geom_ros.viewing import looks


class Publisher(Topic):
    """Keeps what RViz would show."""

    def __init__(self):
        super().__init__()
        self.shown = {}

    def publish(self, message):
        keys = [(m.ns, m.id) for m in message.markers]
        assert len(set(keys)) == len(keys), 'RViz refuses an array with an id twice'
        super().publish(message.markers)
        for marker in message.markers:
            if marker.action == markers.DELETE_ALL:
                self.shown.clear()
            elif marker.action == markers.DELETE:
                self.shown.pop((marker.ns, marker.id), None)
            else:
                self.shown[marker.ns, marker.id] = marker

    def names(self):
        return sorted(ns for ns, _ in self.shown)


@pytest.fixture
def live():
    return live_scene(TEXT, world_frame='map')


@pytest.fixture
def publisher():
    return Publisher()


@pytest.fixture
def drawing(live, publisher):
    return MarkerPublisher(live, publisher, TYPES, lambda: 2.0, lambda *_: None)


def test_a_moving_scene_is_sent_once_and_then_what_moved(scene, publisher, drawing):
    drawing.publish()
    assert publisher.names() == [
        'distances',
        'illustration',
        'illustration',
        *['proximity'] * 4,
    ]
    capsule = [m for m in publisher.shown.values() if m.type == markers.CYLINDER]
    assert capsule[0].header.frame_id == 'map'
    assert capsule[0].pose.orientation.w == 1.0
    red = [m for m in publisher.shown.values() if m.color.r == 1.0]
    assert [m.color.a for m in red] == [0.5]
    drawing.publish()
    assert {m.ns for m in publisher.published[-1]} == {'distances', 'contacts', 'normals'}
    X_WB = RigidTransform(RollPitchYaw(0, 0, 1.0).ToRotationMatrix(), [0.15, 0, 0])
    move(scene, 'b', X_WB)
    drawing.publish()
    geometry = [m for m in publisher.published[-1] if m.ns in looks.LAYERS.values()]
    assert len(geometry) == 3
    assert {m.pose.position.x for m in geometry} == {0.15}
    # The ball now overlaps the capsule: witness points, a normal, and no distance.
    assert publisher.names().count('contacts') == 1
    assert 'distances' not in publisher.names()
    (contacts,) = [m for m in publisher.shown.values() if m.ns == 'contacts']
    assert sorted(p.x for p in contacts.points) == pytest.approx([0.05, 0.1])


def move(scene, frame, X_PF):
    scene.model.context.UpdateFramePoses(FramePoseVector({scene.model.names.frame(frame): X_PF}))


def test_who_comes_late_gets_everything(publisher, drawing):
    drawing.publish()
    whole = len(publisher.published[-1])
    publisher.listeners = 2
    drawing.publish()
    assert len(publisher.published[-1]) == whole


def test_nothing_is_drawn_for_nobody(publisher, drawing):
    publisher.listeners = 0
    drawing.publish()
    assert publisher.published == []


def test_what_is_removed_vanishes_and_ids_stay(scene, publisher, drawing):
    drawing.publish()
    before = {key for key, m in publisher.shown.items() if m.ns == 'proximity'}
    capsule = scene.model.names.geometry('a/capsule')
    source = scene.model.inspector.GetOwningSourceId(capsule)
    scene.make(Change(lambda graph, _: graph.ChangeShape(source, capsule, Sphere(0.1))))
    drawing.publish()
    after = {key for key, m in publisher.shown.items() if m.ns == 'proximity'}
    assert after < before
    assert len(before - after) == 2
    scene.make(Change(lambda graph, _: graph.RemoveGeometry(source, capsule)))
    drawing.publish()
    assert publisher.names().count('proximity') == 1
    drawing.clear()
    assert publisher.shown == {}


def test_what_never_had_a_pose_is_not_drawn_until_it_has(publisher):
    live = live_scene(TEXT.replace('{name: a, source: s, pose: {}}', '{name: a, source: s}'))
    drawing = MarkerPublisher(live, publisher, TYPES, lambda: 2.0, lambda *_: None)

    drawing.publish()
    before = publisher.names()
    with live.editing() as scene:
        poses = FramePoseVector({scene.model.names.frame('a'): RigidTransform()})
        scene.poses.pose(poses, {}, Plain(sec=0, nanosec=0), MESSAGES)
    drawing.publish()
    capsule = len(markers.parts_of(Capsule(0.1, 0.4)))
    assert publisher.names().count('proximity') == before.count('proximity') + capsule
    assert before.count('proximity') > 0


def test_what_cannot_be_drawn_is_told_once_and_the_rest_is_shown(publisher, tmp_path):
    broken = tmp_path / 'broken.obj'
    broken.write_text('f 1 2 3\n')
    live = live_scene(f"""
sources: [s]
geometries:
  - {{name: ball, source: s, shape: {{type: sphere, radius: 0.1}}}}
  - {{name: lost, source: s, shape: {{type: mesh, uri: {broken}}},
     roles: {{illustration: {{}}}}}}
""")
    told = []
    drawing = MarkerPublisher(live, publisher, TYPES, lambda: 2.0, lambda *_: None, told.append)
    drawing.publish()
    drawing.publish()
    assert publisher.names() == ['proximity']
    (text,) = told
    assert 's::world/lost' in text
