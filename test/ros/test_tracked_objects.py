"""Trackers and a real node: bodies come by three topics, rules watch them, and they leave."""

import math
import time
from types import SimpleNamespace as Plain

import pytest
from drake_geom_msgs import msg, srv
from geometry_msgs.msg import Point
from ros.harness import LATCHED, start_node
from ros.scene_calls import accepted, poses
from visualization_msgs.msg import Marker, MarkerArray

pytestmark = pytest.mark.topics

SCENE = """
sources: [arm]
frames: [{name: hand, source: arm}]
geometries:
- {name: hand, source: arm, frame: hand, shape: {type: sphere, radius: 0.1}}
proximity_rules:
- {name: stop, set_a: arm, set_b: tracked, level: stop, enter: 0.5, leave: 0.6}
"""
# [s] a message has a cycle of its own, or shares that of poses which come fast
SLOWLY, FAST = 0.03, 0.004
LIFETIME = 0.5  # [s] shorter than stale_after: she leaves before she is stale


@pytest.fixture(scope='module')
def node(tmp_path_factory):
    folder = tmp_path_factory.mktemp('tracked')
    (folder / 'scene.yaml').write_text(SCENE)
    settings = {'tracked_markers': '/people/markers', 'stale_after': 1.0}
    process = start_node(folder / 'log', scene_file=folder / 'scene.yaml', **settings)
    yield process
    process.end()


@pytest.fixture
def tracker(node, client, request):
    return Tracker(client, getattr(request, 'param', SLOWLY))


class Tracker:
    """Sends the pose of the hand and bodies, and listens."""

    def __init__(self, client, period):
        """``period`` [s] is the shortest one of the hand's poses."""
        self.client, self.period = client, period
        self.hand = client.publisher(msg.FramePoses, 'frame_poses')
        self.bodies = client.publisher(msg.TrackedObjects, 'tracked_objects')
        self.markers = client.node.create_publisher(MarkerArray, '/people/markers', 10)
        self.states = client.listen(msg.ProximityStates, 'proximity_states', LATCHED)
        self.scenes = client.listen(msg.Scene, 'scene', LATCHED)
        self.events = client.listen(msg.ProximityEvents, 'proximity_events')
        self.now = {}

    def say(self, shape=None, **bodies):
        """Have the tracker name bodies from now on, by x; without one, that nobody is there."""
        self.now = bodies
        self.shape = shape or msg.Shape(type=msg.Shape.CAPSULE, dimensions=[0.2, 1.2])

    def speak(self):
        """Send all once."""
        self.hand.publish(poses(['hand'], [[0.0, 0.0, 0.0]]))
        message = msg.TrackedObjects(
            names=list(self.now),
            shapes=[self.shape] * len(self.now),
            lifetimes=[LIFETIME] * len(self.now),
        )
        message.header.stamp = self.client.node.get_clock().now().to_msg()
        for x in self.now.values():
            message.poses.extend([x, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0])
        self.bodies.publish(message)

    def until(self, fact, what, *, speaks=True):
        """Wait for a fact; meanwhile the tracker speaks, or does not."""

        def is_so():
            if speaks:
                self.speak()
                time.sleep(self.period)
            return fact()

        self.client.wait_for(is_so, what)

    def why(self):
        """Return why the rule is entered; None: it is not, or nothing was heard."""
        if not self.states:
            return None
        state = self.states[-1]
        return state.why[0] if state.entered[0] else 0

    def there(self):
        """Return the tracked bodies of the last scene."""
        if not self.scenes:
            return None
        scene = self.scenes[-1]
        sources = {source.id: source.name for source in scene.sources}
        names = {f.name for f in scene.frames if sources.get(f.source_id) == 'tracked'}
        return names - {'heartbeat'}


@pytest.mark.parametrize('tracker', [SLOWLY, FAST], indirect=True)
def test_a_person_comes_near_goes_and_the_tracker_dies(tracker):
    why = msg.ProximityEvents
    tracker.say()
    tracker.until(lambda: tracker.why() == 0, 'that nobody is near')
    tracker.say(anna=0.6)
    tracker.until(lambda: tracker.why() == why.NEAR, 'the stop')
    tracker.until(lambda: tracker.there() == {'anna'}, 'that the scene has her')
    tracker.say(anna=3.0)
    tracker.until(lambda: tracker.why() == 0, 'that she goes')
    tracker.say(ben=3.0)
    tracker.until(lambda: tracker.there() == {'ben'}, 'that anna has left')
    tracker.until(lambda: tracker.why() == 0, 'that the rule goes on without her')
    tracker.until(lambda: tracker.there() == set(), 'that ben has left', speaks=False)

    def stale():
        tracker.hand.publish(poses(['hand'], [[0.0, 0.0, 0.0]]))
        time.sleep(0.02)
        return tracker.why() == why.STALE

    tracker.client.wait_for(stale, 'that a silent tracker stops')


def test_a_marker_is_a_body_until_it_is_deleted(tracker):
    tracker.say()
    tracker.speak()
    marker = Marker(ns='people', id=7, type=Marker.LINE_STRIP, action=Marker.ADD)
    marker.scale.x = 0.4
    marker.points = [Point(x=2.0, y=0.0, z=0.2), Point(x=2.0, y=0.0, z=1.6)]

    def send():
        marker.header.stamp = tracker.client.node.get_clock().now().to_msg()
        tracker.markers.publish(MarkerArray(markers=[marker]))
        time.sleep(0.02)
        return 'people/7' in (tracker.there() or ())

    tracker.client.wait_for(send, 'the body of the marker')
    answer = accepted(
        tracker.client.call(
            srv.ComputeSignedDistancePair,
            'compute_signed_distance_pair',
            geometry_a='arm::hand/hand',
            geometry_b='tracked::people/7/body',
        )
    )
    assert answer.result.distance[0] == pytest.approx(math.hypot(2.0, 0.2) - 0.3, abs=1e-9)
    marker.action = Marker.DELETE
    tracker.client.wait_for(lambda: not send(), 'that it is deleted')


def test_states_and_what_ifs_know_bodies(tracker):
    tracker.say(anna=2.0)
    tracker.until(lambda: tracker.there() == {'anna'}, 'anna')
    answer = accepted(
        tracker.client.call(
            srv.ComputeSignedDistancePair,
            'compute_signed_distance_pair',
            geometry_a='arm::hand/hand',
            geometry_b='tracked::anna/body',
            poses=poses(['tracked::anna'], [[1.0, 0.0, 0.0]]),
        )
    )
    assert answer.result.distance[0] == pytest.approx(0.7, abs=1e-9)


@pytest.mark.parametrize('tracker', [FAST], indirect=True)
def test_bodies_move_on_when_fast_poses_stop(tracker):
    tracker.say(anna=2.0)
    tracker.until(lambda: tracker.there() == {'anna'}, 'anna')
    tracker.hand = Plain(publish=lambda _: None)
    tracker.say(anna=1.0)

    def has_moved():
        pair = {'geometry_a': 'arm::hand/hand', 'geometry_b': 'tracked::anna/body'}
        service = srv.ComputeSignedDistancePair, 'compute_signed_distance_pair'
        answer = accepted(tracker.client.call(*service, **pair))
        return abs(answer.result.distance[0] - 0.7) < 1e-9

    tracker.until(has_moved, 'that anna has moved')
