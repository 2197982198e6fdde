"""The sources of a node's sensed maps, for services that clear, load, add and remove them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import IntEnum
from typing import NamedTuple, Protocol

from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.scene_files import ObstacleSource

FILE = 'file'  # the map that load_obstacles makes


class Forgetful(Protocol):
    """An input that makes a map of the messages of a topic."""

    def forget(self) -> None:
        """Hold nothing of before, nor what is being made; the scene is held."""


class SourceOrigin(IntEnum):
    """The place that names a source, as the constants of ListObstacleSources."""

    PARAMETER = 1
    SCENE_FILE = 2
    SERVICE = 3

    def in_words(self) -> str:
        """Return where to look for the source."""
        places = 'a parameter of the node', 'the scene file', 'add_obstacle_source'
        return places[self - 1]


class NamedSource(NamedTuple):
    """A source, and where it is named."""

    source: ObstacleSource
    origin: SourceOrigin


class ListedSource(NamedTuple):
    """A source that a node listens to."""

    source: ObstacleSource
    origin: SourceOrigin
    messages: int  # that were taken since its map was cleared last


def _refuse(source: object) -> int:
    raise ArgumentError('nothing here listens to topics of sensors')


@dataclass(frozen=True)
class MapSources:
    """The inputs of maps by name, their ``margin`` [m], and ``resolution()`` [m] of new ones.

    ``add(source)`` and ``remove(name)``, which returns the number of cells that went, raise
    RuntimeError to refuse.
    """

    fed: Mapping[str, Forgetful] = field(default_factory=dict)
    margin: float = 0.0
    resolution: Callable[[], float] = lambda: 0.03
    changed: Callable[[], None] = lambda: None
    add: Callable[[ObstacleSource], object] = _refuse
    remove: Callable[[str], int] = _refuse
    listed: Callable[[], list[ListedSource]] = list
