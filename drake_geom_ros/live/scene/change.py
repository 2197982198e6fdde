"""A change of the live scene, described once: made on a draft beside the cycles, or at once."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from drake_geom_ros.geometry import SceneGraph, SceneGraphContext, SourceId
from drake_geom_ros.proximity_rules import ProximityRule
from drake_geom_ros.scene_files import RobotDescription

_Scene = TypeVar('_Scene', contravariant=True)  # that of who says what belongs to the change
_Result = TypeVar('_Result', covariant=True)


def _nothing(scene: object) -> None:
    """There is nothing to look at."""


def _as_made(scene: object, made: Any) -> Any:
    """Return what was made; nothing else belongs to the change."""
    return made


def unchanged(graph: SceneGraph, context: SceneGraphContext | None) -> None:
    """Leave the scene graph as it is: rules or another scene come."""


@dataclass(frozen=True)
class Change(Generic[_Scene, _Result]):
    """A change in three parts; what the first two raise refuses it, and nothing has changed.

    - ``first`` looks at the scene that the change is about to be made of.
    - ``on`` changes the scene graph, or with a context that copy of it, and returns what it made.
    - ``then`` does what belongs to the change with the scene that has it, before anybody else has
      that scene, and returns the result.

    ``robots`` and ``rules`` come with it; the robots of sources that are ``gone``, and the rules
    ``rules_gone``, go. With ``same_content`` it changes nothing but filters, rules and shapes.
    ``maps_source`` returns, from what was made, the source of sensed maps where that may be
    another one than before, None for no maps.
    """

    on: Callable[[SceneGraph, SceneGraphContext | None], Any]
    first: Callable[[_Scene], object] = _nothing
    then: Callable[[_Scene, Any], _Result] = _as_made
    robots: Sequence[RobotDescription] = ()
    gone: Collection[str] = ()
    rules: Sequence[ProximityRule] = ()
    rules_gone: Collection[str] = ()
    same_content: bool = False
    maps_source: Callable[[Any], SourceId | None] | None = None

    def robots_after(self, robots: Sequence[RobotDescription]) -> list[RobotDescription]:
        """Return the robots of a scene that the change was made of."""
        return [*(robot for robot in robots if robot.name not in self.gone), *self.robots]

    def maps_after(self, source: SourceId | None, made: Any) -> SourceId | None:
        """Return the source of sensed maps of a scene that had ``source`` before."""
        return source if self.maps_source is None else self.maps_source(made)
