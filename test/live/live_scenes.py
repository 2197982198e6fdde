"""Live scenes for tests without ROS, and the clocks and topics that stand for those of a node."""

import time

from drake_geom_ros.live.scene.changes.addition import addition
from drake_geom_ros.live.scene.clocks import Clocks
from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.scene_files import read_scene

# Two balls that move over a floor, beside a post.
TWO_BALLS = """
sources: [s]
frames: [{name: a, source: s, pose: {}}, {name: b, source: s, pose: {}}]
geometries:
- {name: floor, source: s, shape: {type: half_space}, pose: {position: [0, 0, -1]}}
- {name: post, source: s, shape: {type: box, size: [0.1, 0.1, 1]}}
- {name: ball, source: s, frame: a, shape: {type: sphere, radius: 0.1}}
- {name: ball, source: s, frame: b, shape: {type: sphere, radius: 0.1}}
"""


class Clock:
    """A clock [s] that the test sets."""

    def __init__(self, now=100.0):
        self.now = now

    def __call__(self):
        return self.now


class Topic:
    """A publisher with so many subscribers that keeps what it was given."""

    def __init__(self, listeners=1):
        self.listeners = listeners
        self.published = []

    def get_subscription_count(self):
        return self.listeners

    def publish(self, message):
        self.published.append(message)


def live_scene(text, now=time.monotonic, world_frame='world'):
    """Return a live scene of a file or a text, where steady time is the node's."""
    live = LiveScene('exact', Clocks(now, now), world_frame)
    with live.editing() as scene:
        scene.make(addition(read_scene(text)))
    return live
