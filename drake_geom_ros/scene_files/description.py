"""Descriptions of scenes as plain records, which are read from files and registered later.

Every record holds the place it was read from (``where``), so that later errors can name file,
line and key. Comparisons of records ignore places.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

from drake_geom_ros.common.counting import counted
from drake_geom_ros.geometry import (
    FilterOperation,
    GeometryProperties,
    HeightField,
    Mesh,
    Role,
    Shape,
)
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.proximity_rules import ProximityRule
from drake_geom_ros.scene_files.errors import Location
from drake_geom_ros.scene_files.gates import Gate
from drake_geom_ros.scene_files.link_tree import LinkTree
from drake_geom_ros.scene_files.obstacle_sources import ObstacleSource
from drake_geom_ros.sensors import CameraInfo

WORLD = 'world'
IMAGES = ('color', 'depth', 'label')
PERCEPTION = 'perception'
# Defaults of cameras: range of depths [m], and publishing rate of a node [Hz].
NEAR, FAR, RATE = 0.01, 100.0, 10.0
LEAVE_OUT = 'leave_out'  # flat meshes
_NOWHERE = Location('<scene>')


@dataclass(frozen=True)
class Member:
    """An element of a geometry set: a frame, or one geometry with the proximity role.

    The world frame has no source; a geometry on it has one.
    """

    source: str
    frame: str
    geometry: str | None = None


@dataclass(frozen=True)
class FrameDescription:
    """A frame; ``X_PF`` is its initial pose, None if the file gives none.

    - ``static``: true if its pose never becomes stale, false if it is expected to move, None if
      its first pose decides.
    - ``welded``: its geometries count as anchored.
    - ``parent``: the registered parent; ``mounted_on`` replaces it if that is a frame of another
      source.
    - ``attached_to``: the frame that it follows; X_PF is then in that frame.
    - ``part_of_robot``: name patterns that match its carrier match the attached frame too.
    - ``gone_after``: the seconds without a pose after which it leaves; None: it never does.
    - ``touch_links``: names, patterns and groups of what it may touch while it is attached.
    """

    source: str
    name: str
    parent: str = WORLD
    group: int = 0
    X_PF: RigidTransform | None = None
    static: bool | None = None
    where: Location = field(default=_NOWHERE, compare=False)
    welded: bool = False
    attached_to: Member | None = None
    part_of_robot: bool = True
    mounted_on: Member | None = None
    touch_links: tuple[str, ...] = ()
    gone_after: float | None = None


@dataclass(frozen=True)
class GeometryDescription:
    """A geometry with its pose in its frame, and its roles with their properties."""

    source: str
    frame: str
    name: str
    shape: Shape
    X_FG: RigidTransform
    roles: Mapping[Role, GeometryProperties]
    where: Location = field(default=_NOWHERE, compare=False)


@dataclass(frozen=True)
class RobotOptions:
    """Options of reading a robot: filters between its links, meshes, padding, TF prefix.

    ``solid_meshes`` are patterns with ``*`` and ``?`` for links or ``link/geometry``.
    ``paddings`` are pairs of such a pattern and a padding [m] on all sides; the last pattern that
    matches a geometry counts. ``frame_prefix`` is the prefix of the links' names in TF.
    ``flat_meshes`` is LEAVE_OUT or a thickness [m] for flat meshes, 0 if they are refused.
    ``source`` is the name of the robot here; empty: that of its file.
    """

    filter_adjacent_links: bool = True
    filter_self_collisions: bool = False
    solid_meshes: tuple[str, ...] = ()
    paddings: tuple[tuple[str, float], ...] = ()
    frame_prefix: str = ''
    flat_meshes: str | float = 0.0
    source: str = ''

    def is_solid(self, link: str, geometry: str) -> bool:
        """Return whether a mesh stands for the solid inside its surface instead of its hull."""
        return any(_matches(link, geometry, pattern) for pattern in self.solid_meshes)

    def padding(self, link: str, geometry: str) -> float:
        """Return the padding [m] of a geometry on all sides."""
        paddings = [r for pattern, r in self.paddings if _matches(link, geometry, pattern)]
        return paddings[-1] if paddings else 0.0


def _matches(link: str, geometry: str, pattern: str) -> bool:
    """Return whether a pattern matches a link, or a geometry on it."""
    return any(fnmatchcase(name, pattern) for name in (link, f'{link}/{geometry}'))


@dataclass(frozen=True)
class RobotDescription:
    """A robot; the source of its name owns its links, and X_WB is the pose of its root link.

    - ``urdf``: its model file, None if that came as text, or if welds changed its tree.
    - ``model``: the name of the model in a file of several.
    - ``joint_states``: the topic from which a node reads its joints; may be empty.
    - ``tree``: its links and joints.
    - ``frame_prefix``: the prefix of its links' names in TF.
    - ``mounted_on``: the frame that carries it; the poses of its links, X_WB too, are then
      measured in that frame instead of the world.
    - ``configuration``: values [rad] or [m] of the joints that the scene gives one.
    - ``held_joints``: those of them that stay, until a value is heard.
    - ``groups``: the links of each group of its SRDF.
    - ``virtual_joints``: the child link of each virtual joint of its SRDF.
    """

    name: str
    urdf: Path | None
    X_WB: RigidTransform
    srdf: Path | None = None
    where: Location = field(default=_NOWHERE, compare=False)
    joint_states: str = ''
    tree: LinkTree | None = field(default=None, compare=False, repr=False)
    frame_prefix: str = ''
    mounted_on: Member | None = None
    configuration: Mapping[str, float] = field(default_factory=dict, hash=False)
    model: str = ''
    held_joints: tuple[str, ...] = ()
    groups: Mapping[str, tuple[str, ...]] = field(default_factory=dict, hash=False, compare=False)
    virtual_joints: Mapping[str, str] = field(default_factory=dict, hash=False, compare=False)


@dataclass(frozen=True)
class GroupDescription:
    """A collision filter group: its members, and the groups that they ignore, existing or not."""

    name: str
    members: tuple[Member, ...]
    ignores: tuple[str, ...] = ()
    where: Location = field(default=_NOWHERE, compare=False)


@dataclass(frozen=True)
class CliqueDescription:
    """A clique: no two of its members collide."""

    name: str
    members: tuple[Member, ...]
    where: Location = field(default=_NOWHERE, compare=False)


Operation = FilterOperation  # of a statement on its pairs


@dataclass(frozen=True)
class Statement:
    """One statement of a declaration; ``set_b`` is empty for the *within* kinds."""

    operation: Operation
    set_a: tuple[Member, ...]
    set_b: tuple[Member, ...] = ()


@dataclass(frozen=True)
class DeclarationDescription:
    """A persistent declaration; later statements override earlier ones."""

    statements: tuple[Statement, ...]
    where: Location = field(default=_NOWHERE, compare=False)


@dataclass(frozen=True)
class DeactivationDescription:
    """Deactivation of geometries: they take part in no pair."""

    members: tuple[Member, ...]
    where: Location = field(default=_NOWHERE, compare=False)


FilterDescription = (
    GroupDescription | CliqueDescription | DeclarationDescription | DeactivationDescription
)


@dataclass(frozen=True)
class AwaitedFilter:
    """A filter with members of sources that are loaded later: key `awaits` of scene files.

    ``bind`` returns the filter from the ``FileNames`` of a scene that has these sources; it raises
    SceneFileError for a missing name. ``plain`` is the plain value in the file.
    """

    sources: tuple[str, ...]
    plain: Any
    where: Location = field(default=_NOWHERE, compare=False)
    bind: Callable[[Any], FilterDescription] | None = field(default=None, compare=False)


def hulls_in_words(geometries: Sequence[GeometryDescription]) -> str:
    """Return a clause with the number of meshes that stand for their convex hulls, or ''."""
    count = sum(
        isinstance(geometry.shape, Mesh)
        and not isinstance(geometry.shape, HeightField)
        and Role.kProximity in geometry.roles
        and not geometry.roles[Role.kProximity].GetPropertyOrDefault('mesh', 'solid', False)
        for geometry in geometries
    )
    return f'; of {counted(count, "mesh")} the convex hull counts' if count else ''


@dataclass(frozen=True)
class CameraDescription:
    """A camera on a frame (without a source if that is the world), and its published images.

    ``range`` is the least and the greatest visible depth [m]; ``rate`` [Hz] is the maximum
    publishing rate of a node; ``images`` are some of 'color', 'depth', 'label'; ``shows`` is the
    role of the visible geometry, 'perception' or 'proximity'.
    """

    name: str
    source: str
    frame: str
    X_FC: RigidTransform
    intrinsics: CameraInfo
    range: tuple[float, float] = (NEAR, FAR)
    rate: float = RATE
    images: tuple[str, ...] = IMAGES
    shows: str = PERCEPTION
    where: Location = field(default=_NOWHERE, compare=False)


@dataclass(frozen=True)
class SceneDescription:
    """A whole scene, with robots expanded to frames, geometries and filters.

    Each part is in the order of its registration; later filters override earlier ones.
    ``warnings`` report, with file and line, input that was not understood, once for each kind.
    """

    file: str = '<scene>'
    sources: tuple[str, ...] = ()
    robots: tuple[RobotDescription, ...] = ()
    frames: tuple[FrameDescription, ...] = ()
    geometries: tuple[GeometryDescription, ...] = ()
    filters: tuple[FilterDescription, ...] = ()
    cameras: tuple[CameraDescription, ...] = ()
    warnings: tuple[str, ...] = field(default=(), compare=False)
    awaited: tuple[AwaitedFilter, ...] = ()
    rules: tuple[ProximityRule, ...] = ()
    obstacle_sources: tuple[ObstacleSource, ...] = ()
    gates: tuple[Gate, ...] = ()
