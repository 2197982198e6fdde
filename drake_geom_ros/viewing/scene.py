"""What a page needs of a scene, whether it is a file's or that of a running node."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.viewing.looks import Look
from drake_geom_ros.viewing.pairs import Pairs
from drake_geom_ros.viewing.patches import Patches
from drake_geom_ros.viewing.rules import ShownRule
from drake_geom_ros.viewing.short_names import short_names

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Cast:
    """Which geometries are shown: it stays the same object until that changes.

    ``ids`` (k,) are the values of the ids of those that have a place, ascending; ``looks`` are
    theirs, one for each role, ``names`` those of all geometries, ``waiting`` the frames without a
    pose.
    """

    ids: NDArray[np.int64]
    looks: Sequence[Look]
    names: Mapping[int, str]
    waiting: Sequence[str] = ()

    def row_of(self, value: int) -> int:
        """Return the row of a geometry."""
        return int(np.searchsorted(self.ids, value))

    @cached_property
    def short_names(self) -> Mapping[int, str]:
        """What tells each of the names from the others."""
        short = short_names(self.names.values())
        return {value: short[name] for value, name in self.names.items()}


@dataclass(frozen=True, eq=False)
class Moment:
    """Where the geometries of a cast are, and the answer.

    R_WG (k, 3, 3) and p_WG (k, 3) [m] are theirs, R_WF (m, 3, 3) and p_WF (m, 3) [m] those of
    the frames, as far as they are known.
    """

    cast: Cast
    R_WGs: Floats
    p_WGs: Floats
    pairs: Pairs
    R_WFs: Floats
    p_WFs: Floats
    # What is to be said of the moment, such as how old it is.
    remarks: Sequence[str] = field(default=())
    rules: Sequence[ShownRule] = field(default=())
    # Contact surfaces, where they were asked for; the remarks say what they do not show.
    patches: Patches = field(default_factory=Patches.none)


class ShownScene(Protocol):
    """A scene that a page shows. Its methods are called from any thread."""

    def moment(self, max_distance: float, accuracy: str, *, contacts: bool = False) -> Moment:
        """Return where everything is, the pairs up to a distance [m], and contact surfaces."""

    def explain(self, pair: tuple[int, int]) -> list[str]:
        """Return why a pair of geometries, by id values, is not reported; empty where it is.

        Raises RuntimeError for what cannot be asked.
        """

    def version(self) -> object:
        """Return what differs when there is something new to be drawn."""
