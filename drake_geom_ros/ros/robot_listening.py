"""Listens to the robots of the parameter ``robot_descriptions``, each on topics of its own."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from rclpy.callback_groups import CallbackGroup
from std_msgs.msg import String

from drake_geom_ros.live.guard import Guard
from drake_geom_ros.live.inputs.robot_description import RobotInput
from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.ros.surface import Surface, latched
from drake_geom_ros.scene_files import robot_topics_of_text


def listen_to_robots(
    surface: Surface,
    live: LiveScene,
    guard: Guard,
    group: CallbackGroup,
    text: str,
    log: Callable[[str], object],
) -> None:
    """Listen to the topics of the robots that a text names; ``log`` gets what became of each."""

    def take(handle: Callable[[str], str], message: Any) -> None:
        if done := handle(message.data):
            log(done)

    for topics in robot_topics_of_text(text, 'robot_descriptions') if text.strip() else ():
        robot = RobotInput(live, topics)
        handles = (topics.topic, robot.take), (topics.semantic_topic, robot.take_semantics)
        for topic, handle in handles:
            if topic:
                hear = partial(guard.take, topic, partial(take, handle))
                surface.subscription(String, topic, hear, latched(), group)
