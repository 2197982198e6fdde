"""Interface of scenes for a page, for scenes of files and of running nodes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.math import RigidTransform, RotationMatrix
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.viewing.bodies import ShownBody
from drake_geom_ros.viewing.cell_layers import CellLayer
from drake_geom_ros.viewing.looks import Look
from drake_geom_ros.viewing.patches import Patches
from drake_geom_ros.viewing.rules import ShownRule
from drake_geom_ros.viewing.short_names import short_names
from drake_geom_ros.viewing.shown_pairs import ReportedPairs
from drake_geom_ros.viewing.tables import TextTable


@dataclass(frozen=True, eq=False)
class ShownGeometries:
    """The shown geometries; the object is replaced only when they change.

    ``ids`` (k,) are the id values of the geometries with a pose, ascending, and ``looks`` their
    looks, one for each role. ``names`` are those of all geometries, ``waiting`` the frames
    without a pose.
    """

    ids: NDArray[np.int64]
    looks: Sequence[Look]
    names: Mapping[int, str]
    waiting: Sequence[str] = ()

    def row_of(self, value: int) -> int:
        """Return the row in ``ids`` of a geometry's id value."""
        return int(np.searchsorted(self.ids, value))

    @cached_property
    def short_names(self) -> Mapping[int, str]:
        """Short names by id value, which still differ from each other."""
        short = short_names(self.names.values())
        return {value: short[name] for value, name in self.names.items()}


class Ghost(NamedTuple):
    """A place of robots on the way of their stop: ``ids`` (g,) of bodies, with their poses."""

    ids: NDArray[np.int64]
    R_WGs: Floats
    p_WGs: Floats


@dataclass(frozen=True, eq=False)
class ShownMoment:
    """Poses of the shown geometries at one moment, and query results.

    R_WG (k, 3, 3) and p_WG (k, 3) [m] are the poses of the geometries, R_WF (m, 3, 3) and p_WF
    (m, 3) [m] those of the frames that have one.
    """

    geometries: ShownGeometries
    R_WGs: Floats
    p_WGs: Floats
    pairs: ReportedPairs
    R_WFs: Floats
    p_WFs: Floats
    # Remarks about the moment, such as its age.
    remarks: Sequence[str] = field(default=())
    rules: Sequence[ShownRule] = field(default=())
    # Contact surfaces if requested; the remarks report contacts that they do not show.
    patches: Patches = field(default_factory=Patches.none)
    cells: Sequence[CellLayer] = field(default=())
    # What a running node says beside its results: ages, sensors, events.
    tables: Sequence[TextTable] = field(default=())
    ghosts: Sequence[Ghost] = field(default=())

    def pose_of(self, value: int) -> RigidTransform | None:
        """Return X_WG of a geometry by its id value; None if it is not shown."""
        row = self.geometries.row_of(value)
        if row >= len(self.geometries.ids) or self.geometries.ids[row] != value:
            return None
        return RigidTransform(RotationMatrix(self.R_WGs[row]), self.p_WGs[row])


class ShownScene(Protocol):
    """Protocol of a scene that a page shows, whose methods any thread may call."""

    def moment(self, max_distance: float, accuracy: str, *, contacts: bool = False) -> ShownMoment:
        """Return current poses, the pairs up to a distance [m], and contact surfaces."""

    def explain(self, pair: tuple[int, int]) -> list[str]:
        """Return why a pair of geometries, by id values, is not reported; empty if it is.

        Raises RuntimeError for geometries that no query reports.
        """

    def body(self, value: int) -> ShownBody | None:
        """Return a geometry by its id value as it is registered; None if that is not known."""

    def version(self) -> object:
        """Return a value that changes with every change of the scene."""
