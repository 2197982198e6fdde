"""The states of proximity rules as a message."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from drake_geom_ros.live.conversions.fields import floats, stamp_seconds
from drake_geom_ros.live.conversions.proximity_rules import fill_rules, fill_states
from drake_geom_ros.live.scene.held_scene import HeldScene


def fill_rule_states(message: Any, scene: HeldScene, rules: Any = None) -> None:
    """Fill a ProximityStates message; ``rules`` is a ProximityRules of now that was filled."""
    node, steady = scene.clocks.node(), scene.clocks.steady()
    message.header.frame_id = scene.model.world_frame
    stamp_seconds(message.header.stamp, node)
    message.scene_version, message.next_sequence = scene.model.version, scene.rules.next_sequence
    if rules is None:
        fill_rules(message.rules, scene.rules.rules)
    else:
        message.rules = rules
    states = scene.rules.table()
    fill_states(message, states)
    never = states.since == -math.inf
    since = np.where(never, 0.0, np.maximum(0.0, node - (steady - states.since)))
    message.since = floats(since)
