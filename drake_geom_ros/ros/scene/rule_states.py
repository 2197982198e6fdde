"""The states of proximity rules as a message. No ROS import."""

from __future__ import annotations

import math
from typing import Any

from drake_geom_ros.ros.conversions.fields import stamp_seconds
from drake_geom_ros.ros.conversions.proximity_rules import fill_states
from drake_geom_ros.ros.scene.held_scene import HeldScene


def fill_rule_states(message: Any, scene: HeldScene) -> None:
    """Fill a ProximityStates message."""
    node, steady = scene.clocks.node(), scene.clocks.steady()
    message.header.frame_id = scene.world_frame
    stamp_seconds(message.header.stamp, node)
    message.scene_version, message.next_sequence = scene.version, scene.rules.next_sequence
    states = scene.rules.states()
    fill_states(message, states)
    for state in states:
        since = type(message.header.stamp)()
        if state.since > -math.inf:
            stamp_seconds(since, max(0.0, node - (steady - state.since)))
        message.since.append(since)
