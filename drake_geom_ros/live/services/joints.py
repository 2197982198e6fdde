"""The service ``get_joint_positions``: values of joints, as far as the node has them."""

from __future__ import annotations

import math
from typing import Any

from drake_geom_ros.live.scene.clocks import UNKNOWN
from drake_geom_ros.live.scene.live_scene import LiveScene


def get_joint_positions(live: LiveScene, request: Any, response: Any) -> None:
    """Report the value, the speed and the age of each joint."""
    with live.reading() as scene:
        robots = scene.model.joints.robots
        places = scene.model.joints.places(request.names)
        if not request.names:
            places = scene.model.joints.every_place()
        age = live.clocks.ages()
        for place in places:
            robot = robots[place.robot]
            value = robot.values[place.column]
            heard = value is not None and value.since != UNKNOWN
            response.names.append(robot.full_names[place.column])
            response.positions.append(math.nan if value is None else value.position)
            response.velocities.append(math.nan if value is None else value.speed)
            response.ages.append(age(value.since) if value is not None and heard else math.inf)
            response.waiting.append(value is None)
