"""Contact surfaces that are published long after their cycle say how old their poses are then."""

from types import SimpleNamespace as Plain

import pytest
from live.live_scenes import Clock, Topic, live_scene
from live.outputs.test_cycle import Message

from drake_geom_ros.geometry import FramePoseVector
from drake_geom_ros.geometry.queries.contact_queries import Contacts
from drake_geom_ros.live.outputs import contact_topic, long_contacts
from drake_geom_ros.math import RigidTransform

SOFT = """roles: {proximity: {hydroelastic: {compliance_type: compliant,
   hydroelastic_modulus: 1.0e6, resolution_hint: 0.1}}}"""
TEXT = f"""
sources: [s]
frames: [{{name: a, source: s}}, {{name: b, source: s}}]
geometries:
- {{name: ball, source: s, frame: a, shape: {{type: sphere, radius: 0.1}}, {SOFT}}}
- {{name: ball, source: s, frame: b, shape: {{type: sphere, radius: 0.1}}, {SOFT}}}
"""
POSED, CYCLE, PUBLISHED = 100.0, 100.5, 130.5  # [s]


class Later:
    """Publishes when the test says so, instead of a thread."""

    is_busy = False

    def __init__(self, prepare, must_stop, failed):
        self.prepare = prepare

    def ask(self, request):
        self.request = request


@pytest.fixture
def clock(monkeypatch):
    clock = Clock(POSED)
    monkeypatch.setattr(long_contacts.time, 'monotonic', clock)
    return clock


def test_ages_of_poses_go_on_until_it_is_published(clock, monkeypatch):
    monkeypatch.setattr(contact_topic, 'LongContacts', Later)
    monkeypatch.setattr(Contacts, 'late', lambda contacts: 1)
    live, topic = live_scene(TEXT, clock), Topic()
    contacts = contact_topic.ContactTopic(topic, Message, lambda: False, bool, pytest.fail)
    with live.editing() as scene:
        a, b = (scene.model.names.frame(f's::{name}') for name in 'ab')
        poses = FramePoseVector({a: RigidTransform(), b: RigidTransform([0.15, 0.0, 0.0])})
        since = scene.clocks.arrival().since(0.0)
        frames = frozenset([a.get_value(), b.get_value()])
        scene.poses.pose(poses, {frames: since}, Plain(sec=0, nanosec=0), 'test')
        clock.now = CYCLE
        distances = scene.query.ComputeSignedDistancePairwiseClosestPoints(0.0)
        contacts.answer(scene, scene.moment(), distances.penetrations(), 0.0)
    later = contacts._long
    assert not topic.published
    query, overlaps = later.request.view.query, later.request.overlaps
    clock.now = PUBLISHED
    later.prepare(later.request, query.contacts(overlaps=overlaps), 30.0)()
    (message,) = topic.published
    assert len(message.id_a) == 1
    assert message.oldest_pose_age == pytest.approx(PUBLISHED - POSED)
    assert message.oldest_frame in frames
