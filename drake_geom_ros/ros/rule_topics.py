"""The topics of proximity rules, with deadlines by which a listener notices a dead node."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace

from drake_geom_msgs import msg
from rclpy.duration import Duration
from rclpy.qos import DurabilityPolicy, LivelinessPolicy, QoSProfile
from std_msgs.msg import Float64

from drake_geom_ros.live.outputs.effects import Beside
from drake_geom_ros.live.outputs.rule_events import RuleEvents, RuleSettings, RuleTopics
from drake_geom_ros.ros.surface import Surface

_NO_RULE = 'no proximity rule'
# What is offered; a listener may ask for as much or for longer. A machine that others load may
# keep a thread of the node waiting for some tenths of a second.
DEADLINE = 0.5  # [s] between two values of ~/speed_scale
LEASE = 1.0  # [s] after which who sends no sign of life counts as dead
_MOST_EVENTS = 1000  # messages, each of one cycle, that are kept for who is slow to take them


def rule_events(
    surface: Surface, settings: Callable[[], RuleSettings], did: Callable[[int, float], None]
) -> RuleEvents:
    """Open the topics on ``surface``, and return what publishes on them."""
    types = SimpleNamespace(
        ProximityEvents=msg.ProximityEvents,
        ProximityRules=msg.ProximityRules,
        ProximityStates=msg.ProximityStates,
        Float64=Float64,
    )
    topics = RuleTopics(
        events=surface.publisher(msg.ProximityEvents, '~/proximity_events', _events()),
        states=surface.publisher(msg.ProximityStates, '~/proximity_states', _states()),
        speed_scale=surface.publisher(Float64, '~/speed_scale', _speed_scale()),
    )
    return RuleEvents(topics, types, settings, did)


def effect() -> Beside:
    """Return the row of ~/cycle_report with the pairs that were computed for rules alone."""
    return Beside('decide proximity rules', lambda: _NO_RULE)


def _alive(profile: QoSProfile) -> QoSProfile:
    profile.liveliness = LivelinessPolicy.AUTOMATIC
    profile.liveliness_lease_duration = Duration(seconds=LEASE)
    return profile


def _events() -> QoSProfile:
    return _alive(QoSProfile(depth=_MOST_EVENTS))


def _states() -> QoSProfile:
    return _alive(QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL))


def _speed_scale() -> QoSProfile:
    return _alive(QoSProfile(depth=1, deadline=Duration(seconds=DEADLINE)))
