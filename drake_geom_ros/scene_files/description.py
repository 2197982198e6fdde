"""What scene files say, as plain records: read from a file, registered elsewhere.

Every record knows the place it was read from (``where``), so that whoever finds it wrong later
can still name file, line and key. Places do not count when records are compared.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

from drake_geom_ros.common.counting import counted
from drake_geom_ros.geometry import GeometryProperties, Mesh, Role, Shape
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.proximity_rules import ProximityRule
from drake_geom_ros.scene_files.errors import Location
from drake_geom_ros.scene_files.link_tree import LinkTree
from drake_geom_ros.sensors import CameraInfo

WORLD = 'world'
IMAGES = ('color', 'depth', 'label')
PERCEPTION = 'perception'
# Of cameras that say nothing else: depths that are seen [m], and how often a node publishes [Hz].
NEAR, FAR, RATE = 0.01, 100.0, 10.0
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
    """A frame; ``X_PF`` is where it is until a pose comes, None where the file does not say.

    ``static`` is true where its pose does not grow old, false where it is expected to move, and
    None where that shows when a pose comes. ``welded``: its geometries count as anchored.
    ``attached_to``: the frame that it follows, in which X_PF is then; ``parent`` is its home, and
    ``mounted_on`` is so where that is a frame of another source. ``part_of_robot``: what is
    attached counts as part of what carries it in sets by name.
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


@dataclass(frozen=True)
class GeometryDescription:
    """A geometry, its pose in its frame, and its roles with their properties."""

    source: str
    frame: str
    name: str
    shape: Shape
    X_FG: RigidTransform
    roles: Mapping[Role, GeometryProperties]
    where: Location = field(default=_NOWHERE, compare=False)


@dataclass(frozen=True)
class RobotOptions:
    """Which of a robot's own pairs are kept from colliding, and which of its meshes are solids.

    ``solid_meshes`` are patterns with ``*`` and ``?``, of links or of ``link/geometry``;
    ``paddings`` are such patterns, and by how much [m] their geometries are larger all around: of
    those that a geometry matches the last one counts. ``frame_prefix`` is that of the names which
    TF has for the links.
    """

    filter_adjacent_links: bool = True
    filter_self_collisions: bool = False
    solid_meshes: tuple[str, ...] = ()
    paddings: tuple[tuple[str, float], ...] = ()
    frame_prefix: str = ''

    def is_solid(self, link: str, geometry: str) -> bool:
        """Return whether a mesh is the body that its surface encloses, and not its hull."""
        return any(_matches(link, geometry, pattern) for pattern in self.solid_meshes)

    def padding(self, link: str, geometry: str) -> float:
        """Return by how much [m] a geometry is larger all around."""
        found = [r for pattern, r in self.paddings if _matches(link, geometry, pattern)]
        return found[-1] if found else 0.0


def _matches(link: str, geometry: str, pattern: str) -> bool:
    """Return whether a pattern is of a link, or of a geometry on it."""
    return any(fnmatchcase(name, pattern) for name in (link, f'{link}/{geometry}'))


@dataclass(frozen=True)
class RobotDescription:
    """A robot: the source of its name holds its links; X_WB is the pose of its root link.

    ``urdf`` is None where the URDF came as text. ``joint_states`` is the topic, if one is named,
    on which a node hears of its joints; ``tree`` are its links and joints. ``frame_prefix`` is
    what the names that TF has for its links begin with. Where it is ``mounted_on`` a frame, the
    poses of its links are those in that frame, X_WB too: W stands for what carries it.
    ``configuration`` are the values [rad] or [m] of the joints that the scene gives one.
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


@dataclass(frozen=True)
class GroupDescription:
    """A collision filter group: members, and the groups (there or not) that they ignore."""

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


class Operation(Enum):
    """What a statement does to its pairs; values are CollisionFilterDeclaration's methods."""

    EXCLUDE_WITHIN = 'ExcludeWithin'
    EXCLUDE_BETWEEN = 'ExcludeBetween'
    ALLOW_WITHIN = 'AllowWithin'
    ALLOW_BETWEEN = 'AllowBetween'

    @property
    def takes_two_sets(self) -> bool:
        """Whether the pairs are those between two sets."""
        return self in (Operation.EXCLUDE_BETWEEN, Operation.ALLOW_BETWEEN)


@dataclass(frozen=True)
class Statement:
    """One statement of a declaration; ``set_b`` is empty for the *within* kinds."""

    operation: Operation
    set_a: tuple[Member, ...]
    set_b: tuple[Member, ...] = ()


@dataclass(frozen=True)
class DeclarationDescription:
    """A persistent declaration: statements of which later ones win."""

    statements: tuple[Statement, ...]
    where: Location = field(default=_NOWHERE, compare=False)


@dataclass(frozen=True)
class DeactivationDescription:
    """Geometries that take part in no pair."""

    members: tuple[Member, ...]
    where: Location = field(default=_NOWHERE, compare=False)


FilterDescription = (
    GroupDescription | CliqueDescription | DeclarationDescription | DeactivationDescription
)


@dataclass(frozen=True)
class AwaitedFilter:
    """A filter with members of sources that come later: see the key `awaits` of scene files.

    ``bind`` makes it of the ``FileNames`` of a scene that has them; it raises SceneFileError for
    a name that is not there. ``plain`` is what the file says.
    """

    sources: tuple[str, ...]
    plain: Any
    where: Location = field(default=_NOWHERE, compare=False)
    bind: Callable[[Any], FilterDescription] | None = field(default=None, compare=False)


def hulls_in_words(geometries: Sequence[GeometryDescription]) -> str:
    """Return how many meshes count as their convex hulls, to go behind a sentence; or nothing."""
    count = sum(
        isinstance(geometry.shape, Mesh)
        and Role.kProximity in geometry.roles
        and not geometry.roles[Role.kProximity].GetPropertyOrDefault('mesh', 'solid', False)
        for geometry in geometries
    )
    return f'; of {counted(count, "mesh")} the convex hull counts' if count else ''


@dataclass(frozen=True)
class CameraDescription:
    """A camera on a frame (on the world frame without a source), and what is published of it.

    ``range`` are the least and the largest depth [m] that are seen; ``rate`` [Hz] is the most that
    a node publishes; ``images`` are of 'color', 'depth', 'label'; ``shows`` is the role of what is
    seen, 'perception' or 'proximity'.
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
    """A whole scene, robots expanded to frames, geometries and filters.

    Each part is in the order in which it is registered; of filters the last word counts.
    ``warnings`` name, with file and line, what was read and not understood, once for each kind.
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
