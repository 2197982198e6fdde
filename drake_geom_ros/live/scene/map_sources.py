"""The sources of a node's sensed maps, for services that clear and load them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Protocol

FILE = 'file'  # the map that load_obstacles makes


class Forgetful(Protocol):
    """An input that makes a map of the messages of a topic."""

    def forget(self) -> None:
        """Hold nothing of before, nor what is being made; the scene is held."""


@dataclass(frozen=True)
class MapSources:
    """The inputs of maps by name, their ``margin`` [m], and ``resolution()`` [m] of new ones."""

    fed: Mapping[str, Forgetful] = field(default_factory=dict)
    margin: float = 0.0
    resolution: Callable[[], float] = lambda: 0.03
    changed: Callable[[], None] = lambda: None
