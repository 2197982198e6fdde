"""Links and joints of a robot as records, which scenes keep besides its shapes."""

import math
from dataclasses import dataclass, field

from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files.errors import Location

_NOWHERE = Location('<urdf>')


@dataclass(frozen=True)
class Joint:
    """A joint between two links."""

    type: str
    parent: str
    child: str


@dataclass(frozen=True)
class Mimic:
    """Coupling of a joint, at ``multiplier`` times the value of ``joint`` plus ``offset``."""

    joint: str
    multiplier: float
    offset: float


@dataclass(frozen=True)
class UrdfJoint(Joint):
    """A joint J: X_PJ in its parent link, its axis, and its limits.

    Limits are in [m] or [rad], and [m/s] or [rad/s] for the speed; infinite if the file gives
    none. ``parts`` is the chain of simple joints, of one value each or fixed, that a joint stands
    for if its child link is not where a simple joint of a URDF puts it; their names are unique in
    the robot. Otherwise it is empty.
    """

    name: str
    X_PJ: RigidTransform
    axis: tuple[float, float, float]
    lower: float = -math.inf
    upper: float = math.inf
    max_speed: float = math.inf
    mimic: Mimic | None = None
    where: Location = field(default=_NOWHERE, compare=False)
    parts: tuple['UrdfJoint', ...] = ()


@dataclass(frozen=True)
class LinkTree:
    """The name of a robot, and its links and joints in the order of its file."""

    name: str
    links: tuple[str, ...]
    joints: tuple[UrdfJoint, ...]
