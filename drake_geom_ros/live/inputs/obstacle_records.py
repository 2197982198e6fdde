"""Records about maps that messages of sensors make: names, settings, counts."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from drake_geom_ros.live.scene.self_filter import BodiesThen
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.scene_files import OCCUPIED
from drake_geom_ros.sensed_maps.cells import Keys
from drake_geom_ros.sensed_maps.keeping import KeptCells
from drake_geom_ros.sensed_maps.shell import Shell

POINTS, DEPTH, OCTOMAP = 'points', 'depth', 'octomap'
INPUTS = (POINTS, DEPTH, OCTOMAP)
SELF_FILTERS = ('none', 'robots', 'scene')


class ObstacleSettings(NamedTuple):
    """Settings of maps: the parameters obstacle_..."""

    resolution: float  # [m]
    reach: float  # [m] from the sensor
    padding: float  # [m] from bodies, within which points are in no map
    noise: float  # [m] from bodies, within which they count as on them
    self_filter: str
    least_points: int
    keep: float  # [s]
    rays: bool
    margin: float  # [m]
    box: tuple[float, ...] = ()  # its corners (6,) [m] in the world; none: no limit
    # Lowest and highest height [m] in the world that each seen cell stands for; none: its own.
    extrude: tuple[float, float] | None = None
    # Paddings [m] of bodies by name or pattern; of those that fit the last one counts.
    paddings: tuple[tuple[str, float], ...] = ()
    # How long [s] cells in the shadow of a body stay after a sensor saw them last.
    keep_hidden: float = math.inf
    may_be_empty: bool = False  # whether a cloud or an image without points is taken
    threshold: int = 65  # least value of the occupied cells of an occupancy grid
    unknown: str = OCCUPIED  # what unknown cells of such a grid count as

    @property
    def told_apart(self) -> float:
        """The distance [m] from a body from which on the map alone says what is there."""
        is_filtered = self.self_filter != 'none'
        paddings = self.padding, *(padding for _, padding in self.paddings)
        return max(self.resolution, max(paddings) if is_filtered else 0.0)

    def corners(self) -> tuple[Floats, Floats]:
        """Return the corners (3,), (3,) [m] of what is taken, in the world."""
        limits = self.box or (*3 * [-np.inf], *3 * [np.inf])
        return np.array(limits[:3]), np.array(limits[3:])


@dataclass(frozen=True)
class MapCounts:
    """Counts of the messages of a map, and of the points of the last one."""

    taken: int = 0
    missed: int = 0  # lost on their way, or replaced by newer ones before they were taken
    seconds: float = 0.0  # that the last one took, from its callback until it was in the scene
    points: int = 0
    not_finite: int = 0
    out_of_reach: int = 0
    on_bodies: int = 0
    in_shell: int = 0  # beside bodies, within their padding
    out_of_box: int = 0
    in_sparse_cells: int = 0  # in cells with too few points to make one, where none is held
    cells: int = 0
    held_cells: int = 0  # of these, that are there by those before the last one alone
    shell_cells: int = 0  # beside bodies, in no map
    held_shell_cells: int = 0  # of these, that are there by those before the last one alone
    shadow_cells: int = 0  # of the map, that bodies hide from the sensor


class Held(NamedTuple):
    """Cells of a message that later maps may hold."""

    kept: KeptCells
    epoch: float  # of the node's time, by which they were seen
    generation: int  # of the map
    shell: Shell


class Turn(NamedTuple):
    """The pose of a sensor's frame at the end of a message, in that at its beginning."""

    R_FE: Floats  # (3, 3)
    p_FE: Floats  # (3,) [m]


class Place(NamedTuple):
    """Place and time at which points were measured, and the settings of their map."""

    R_WF: Floats  # (3, 3) of the sensor's frame
    p_WF: Floats  # (3,) [m]
    held: float  # [s] of the node's time, when they were measured
    epoch: float  # of the node's time
    generation: int  # of the map: cells of another one are not kept
    bodies: BodiesThen  # on which points are left out, where they were
    settings: ObstacleSettings
    before: Held | None  # of the sensor's message before, which another process may have taken
    feed: tuple[str, str]  # the sensor: its frame and its publisher
    turn: Turn | None = None  # while the points were measured; None: it stood still
    # The pose X_SF of the frame of the message in that of the sensor, which the place then is of;
    # None: points are given in the sensor's frame.
    in_sensor: tuple[Floats, Floats] | None = None


class Found(NamedTuple):
    """The map that was made of the points of a message."""

    kept: KeptCells
    counts: MapCounts
    shell: Shell
    nearest: float  # [m] least distance of a point in the shell from a body; inf: there is none
    range: float = np.inf  # [m] beyond which the sensor measures nothing, where it says so
    shadow: Keys = np.zeros(0, dtype=np.int64)  # keys of cells of the map that bodies hide
