"""Objects of MoveIt's planning scene: messages change the source ``planning_scene``, whole or not.

World objects are frames of that source by their ids, with a geometry for each shape, and they
count as anchored. Attached objects follow their link; subframes are frames on their object.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from drake_geom_ros.common.counting import counted
from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.live.conversions.allowed_collisions import AllowedCollisions
from drake_geom_ros.live.conversions.collision_objects import (
    attached_from_message,
    request_from_message,
)
from drake_geom_ros.live.conversions.planning_scene import scene_from_message
from drake_geom_ros.live.scene.changes.world_change import (
    SceneChangedError,
    adds_shapes,
    world_change,
)
from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.live.scene.world_objects import PlanningWorld

_TRIES = 5  # of a change beside others who change the scene all the time


class PlanningSceneInput:
    """Takes MoveIt's messages into the live scene.

    Each call returns in words what was done and what was ignored, for the log. It raises
    RuntimeError to refuse a message, naming the object and the reason; nothing has changed then.
    """

    def __init__(self, live: LiveScene, changed: Callable[[], object] = lambda: None) -> None:
        """Take messages into ``live``; ``changed`` is called after each that changed it."""
        self._live, self._changed = live, changed
        self._matrix: AllowedCollisions | None = None

    def take_object(self, message: Any) -> str:
        """Take a CollisionObject."""
        request = request_from_message(message)
        return self._change(lambda world: world.take(request))

    def take_attached(self, message: Any) -> str:
        """Take an AttachedCollisionObject."""
        request = attached_from_message(message)
        return self._change(lambda world: world.take_attached(request))

    def take_scene(self, message: Any) -> str:
        """Take a PlanningScene, full or a diff."""
        request = scene_from_message(message)
        return self._change(lambda world: world.take_scene(request))

    def _change(self, alter: Callable[[PlanningWorld], None]) -> str:
        """Alter the objects of the scene of now, and return what became of them."""
        for _ in range(_TRIES):
            with self._live.editing() as scene:
                world = PlanningWorld(scene, self._matrix)
                alter(world)
                change = world_change(scene, world)
            try:
                self._live.change(change, calls_for_more=adds_shapes(world))
            except SceneChangedError:
                continue
            self._matrix = world.matrix
            self._changed()
            return _in_words(world)
        raise ArgumentError('the scene changes all the time; send the message again')


def _in_words(world: PlanningWorld) -> str:
    attached = sum(each.link is not None for each in world.objects.values())
    done = (
        f'planning scene: {counted(len(world.objects) - attached, "object")} in the world, '
        f'{attached} attached'
    )
    return '; '.join([done, *world.notes])
