"""The scene as a subscriber knows it: geometries by id, with names, shapes and frames."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass
from itertools import islice
from typing import Any, NamedTuple

import numpy as np
from drake_geom_msgs.msg import Role
from numpy.typing import NDArray

from drake_geom_ros.common.counting import counted
from drake_geom_ros.common.frame_names import Frame, full_name, told_apart
from drake_geom_ros.common.geometry_names import WORLD, GeometryNames, carrier_names, matches
from drake_geom_ros.common.nearest import nearest
from drake_geom_ros.math.batched import matrices_from_poses

_MOST_KEPT = 64  # patterns of which the ids are kept: whoever watches asks for the same each time
_MOST_LOOKED_AT = 5000  # names that are compared with an unknown one, some 10 us each
_SHOWN = 4  # names of a scene in a message
_MAPS = 'obstacles'  # the source of sensed maps


class UnknownNameError(RuntimeError):
    """A name or a pattern that stands for nothing that queries report in this scene."""


@dataclass(frozen=True)
class Geometry:
    """A geometry: shape type and dimensions as in the Shape message, X_FG (4, 4) in its frame.

    ``frame_name`` is its frame's own name, ``world`` where it is anchored. ``line`` holds its
    frame and all that this hangs on, upwards, each as ``source::frame``; it is empty where the
    geometry is anchored. Queries report what ``has_proximity`` role. ``carriers`` are the names of
    what carries it as its part.
    """

    id: int
    source: str
    frame_name: str
    name: str
    shape_type: int
    dimensions: tuple[float, ...]
    X_FG: NDArray[np.float64]
    line: tuple[str, ...] = ()
    has_proximity: bool = True
    carriers: tuple[str, ...] = ()

    @property
    def anchored(self) -> bool:
        """Whether the geometry is fixed to the world."""
        return not self.line

    @property
    def called(self) -> GeometryNames:
        """Its names."""
        names = self.source, self.frame_name, self.name
        return GeometryNames(*names, self.anchored, self.carriers)

    @property
    def frame(self) -> str:
        """The full name of its frame, ``source::frame``; ``world`` where it is anchored."""
        return self.called.frame

    def X_WG(self, X_WFs: Mapping[Frame, NDArray[np.float64]]) -> NDArray[np.float64]:
        """Return its pose (4, 4) in the world, of X_WF (4, 4) by source and name of frames.

        Raises KeyError where its frame is not among them; one that is anchored needs none.
        """
        return self.X_FG if self.anchored else X_WFs[self.own_frame] @ self.X_FG

    @property
    def own_frame(self) -> Frame:
        """Its frame by source and own name: names may hold ``::``, and ``frame`` joins them."""
        return self.source, self.frame_name

    @property
    def short_name(self) -> str:
        """The name without its source: ``frame/geometry``."""
        return self.called.short_name

    @property
    def full_name(self) -> str:
        """The name that services take: ``source::frame/geometry``."""
        return self.called.full_name

    @property
    def body(self) -> str:
        """The name of the thing it is part of: its frame, or itself where it is anchored."""
        return self.called.body

    @property
    def names(self) -> tuple[str, ...]:
        """The names that it is found by: of its source, frame and carriers, and its own."""
        return self.called.found_by

    def matches(self, pattern: str) -> bool:
        """Return whether a name, or a pattern with ``*`` and ``?``, stands for the geometry.

        That is the name of its source, frame or thing, or its own, each with or without the
        source: ``left``, ``left::hand``, ``hand``, ``ball``, ``hand/ball``, ``*::hand/*``. Names
        may themselves hold ``::`` and ``/``: they are compared, and never split.
        """
        return matches(self.names, pattern)


class JointState(NamedTuple):
    """Where a joint is, as far as the node knows."""

    position: float  # [rad] or [m]; nan: it has no value, and what hangs on it waits
    velocity: float  # [rad/s] or [m/s]; nan: nobody knows
    age: float  # [s] since it was heard of; inf: never, or not since the clock jumped

    @property
    def is_known(self) -> bool:
        """Whether it has a value, be it only that of the scene file."""
        return not math.isnan(self.position)


class Joint(NamedTuple):
    """A joint of a robot that has a value of its own."""

    robot: str
    name: str
    type: str  # as in the URDF
    limits: tuple[float, float]  # [rad] or [m]; infinite where there is none
    frame: Frame | None  # of the link that it moves, by source and name; None: it is no frame
    # Where it is as far as the node knew when it was asked; a table from ~/scene alone tells None.
    state: JointState | None = None

    @property
    def full_name(self) -> str:
        """The name that services take where two robots have the joint: ``robot::name``."""
        return f'{self.robot}::{self.name}'


class SceneTable:
    """The geometries of one version of the scene, and the parents of its frames."""

    def __init__(
        self,
        geometries: list[Geometry],
        version: int = 0,
        parents: Mapping[Frame, Frame | None] | None = None,
        names_version: int = 0,
        frame_names: Mapping[int, str] | None = None,
        joints: Sequence[Joint] = (),
    ) -> None:
        """``parents`` of frames by source and own name, parents first; None is the world.

        ``frame_names`` are the same names by id; ``names_version`` is the version
        since which ids, names and roles are these.
        """
        self.geometries = {geometry.id: geometry for geometry in geometries}
        self.version = version
        self.joints = tuple(joints)
        self.names_version = names_version
        self.parents = dict(parents or {})
        self._frame_names = dict(frame_names or {})
        self._ids = np.array(sorted(self.geometries), dtype=np.int64)
        self._sources = np.array([self.geometries[i].source for i in self._ids.tolist()])
        self._found: dict[str, NDArray[np.int64]] = {}
        self._unknown: dict[str, str] = {}

    @classmethod
    def from_message(cls, message: Any) -> SceneTable:
        """Return the table of a Scene message."""
        sources = {source.id: source.name for source in message.sources}
        entries = {frame.id: frame for frame in message.frames}
        lines: dict[int, tuple[Frame, ...]] = {}
        for id, frame in entries.items():
            if frame.parent_id == id:
                lines[id] = ()
            else:
                lines[id] = (sources[frame.source_id], frame.name), *lines[frame.parent_id]
        poses = [(entry.pose.position, entry.pose.orientation) for entry in message.geometries]
        rows = np.array([(p.x, p.y, p.z, q.x, q.y, q.z, q.w) for p, q in poses]).reshape(-1, 7)
        X_FGs = np.tile(np.eye(4), (len(rows), 1, 1))
        X_FGs[:, :3, :3], X_FGs[:, :3, 3] = matrices_from_poses(rows)
        geometries = [
            Geometry(
                entry.id,
                sources[entry.source_id],
                entries[entry.frame_id].name if lines[entry.frame_id] else WORLD,
                entry.name,
                entry.shape.type,
                tuple(entry.shape.dimensions),
                X_FG,
                tuple(map(full_name, lines[entry.frame_id])),
                any(role.role == Role.PROXIMITY for role in entry.roles),
                carriers_of(entry.frame_id, entries, sources),
            )
            for entry, X_FG in zip(message.geometries, X_FGs, strict=True)
        ]
        parents = {line[0]: line[1] if line[1:] else None for line in lines.values() if line}
        frames = {id: line[0] for id, line in lines.items() if line}
        joints = [
            Joint(j.robot, j.name, j.type, (j.lower, j.upper), frames.get(j.frame_id))
            for j in message.joints
        ]
        names = {id: full_name(line[0]) if line else WORLD for id, line in lines.items()}
        versions = message.scene_version, parents, message.names_version
        return cls(geometries, *versions, names, joints)

    def with_joint_states(self, states: Mapping[str, JointState]) -> SceneTable:
        """Return the same table, the states of joints by full name with it."""
        other = copy(self)
        other.joints = tuple(
            each._replace(state=states.get(each.full_name)) for each in self.joints
        )
        return other

    def __getitem__(self, geometry_id: int) -> Geometry:
        return self.geometries[int(geometry_id)]

    def __contains__(self, geometry_id: int) -> bool:
        return int(geometry_id) in self.geometries

    def frame_name(self, frame_id: int) -> str:
        """Return the full name of a frame, ``source::frame``; empty for none of this scene."""
        return self._frame_names.get(int(frame_id), '')

    def has(self, pattern: str) -> bool:
        """Return whether a name or a pattern matches any geometry, see ``Geometry.matches``."""
        return any(geometry.matches(pattern) for geometry in self.geometries.values())

    def ids(self, pattern: str) -> NDArray[np.int64]:
        """Return the ids of the geometries that a name or a pattern matches, ascending.

        Raises UnknownNameError, with the nearest names, where there are none, or none with the
        proximity role: of those no query reports anything, ever.
        """
        if pattern not in self._found:
            found = [g for g in self.geometries.values() if g.matches(pattern)]
            if not any(geometry.has_proximity for geometry in found):
                raise UnknownNameError(self._told(pattern, len(found)))
            if len(self._found) >= _MOST_KEPT:
                self._found.clear()
            self._found[pattern] = ids = np.array(sorted(g.id for g in found), dtype=np.int64)
            ids.setflags(write=False)
        return self._found[pattern]

    def own_name(self, frame: str) -> str:
        """Return the own name of a frame that is given with its source, ``source::frame``, or not.

        Names may hold ``::``: they are compared whole. Raises UnknownNameError where there is no
        such frame, or where it depends on which one is meant.
        """
        found = [each for each in self.parents if frame in (each[1], full_name(each))]
        own = {name for _, name in found}
        if len(own) == 1:
            return own.pop()
        if found:
            both = ' and '.join(map(told_apart, found))
            raise UnknownNameError(f'{frame[:80]!r} stands for {both}')
        told = nearest(frame, islice(map(full_name, self.parents), _MOST_LOOKED_AT))
        raise UnknownNameError(
            f'there is no frame {frame[:80]!r} in the scene of version {self.version}{told}; see '
            'the topic ~/scene'
        )

    def _told(self, pattern: str, count: int) -> str:
        """Return what is wrong with a pattern, of whose geometries no query reports anything."""
        # A stream may be asked for the same name again and again.
        if pattern not in self._unknown:
            if len(self._unknown) >= _MOST_KEPT:
                self._unknown.clear()
            geometries = self.geometries.values()
            if count:
                why = f'; of that name {counted(count, "geometry")} without the proximity role'
            else:
                names = dict.fromkeys(name for g in geometries for name in g.names)
                why = nearest(pattern, islice(names, _MOST_LOOKED_AT))
            sources = sorted({repr(geometry.source) for geometry in geometries})[:_SHOWN]
            self._unknown[pattern] = (
                f'{pattern[:80]!r} stands for no geometry that queries report in the scene of '
                f'version {self.version}{why}. It holds {counted(len(geometries), "geometry")} of '
                f'{", ".join(sources) or "no source"}; see the topic ~/scene'
            )
        return self._unknown[pattern]

    def waits(self, sets: Iterable[NDArray[np.int64]], frames: Collection[str]) -> bool:
        """Return whether a geometry of one of the sets of ids hangs on one of these frames.

        Frames are given as ``source::frame``, and only what queries report counts.
        """
        waiting = set(frames)
        return any(
            not waiting.isdisjoint(geometry.line)
            for ids in sets
            for geometry in map(self.geometries.__getitem__, ids.tolist())
            if geometry.has_proximity
        )

    def have_maps(self, sets: Iterable[NDArray[np.int64]]) -> bool:
        """Return whether a geometry of one of the sets of ids is a sensed map."""
        geometries = (self.geometries[each] for ids in sets for each in ids.tolist())
        return any(geometry.source == _MAPS for geometry in geometries)

    def between(
        self, id_a: NDArray[np.int64], id_b: NDArray[np.int64], sources: tuple[str, str]
    ) -> NDArray[np.bool_]:
        """Return which of n pairs have one geometry of each of two sources (n,).

        Raises UnknownNameError for a source that is not here, or that has no geometry.
        """
        known = dict.fromkeys(g.source for g in self.geometries.values() if g.has_proximity)
        for source in sources:
            if source not in known:
                told = nearest(source, known)
                raise UnknownNameError(
                    f'no source {source[:80]!r} has a geometry that queries report in the scene '
                    f'of version {self.version}{told}; see the topic ~/scene'
                )
        source_a = self._sources[np.searchsorted(self._ids, id_a)]
        source_b = self._sources[np.searchsorted(self._ids, id_b)]
        first, second = sources
        one_way = (source_a == first) & (source_b == second)
        other_way = (source_a == second) & (source_b == first)
        return np.asarray(one_way | other_way)

    def pair_name(self, id_a: int, id_b: int) -> str:
        """Return the names of the two bodies that the geometries of a pair belong to."""
        return f'{self[id_a].body} - {self[id_b].body}'


def carriers_of(
    frame_id: int, frames: Mapping[int, Any], sources: Mapping[int, str]
) -> tuple[str, ...]:
    """Return the names of what carries a frame as its part, by SceneFrame messages by id."""
    line, frame = [], frames[frame_id]
    while frame.parent_id != frame.id:
        line.append((sources[frame.source_id], frame.name, frame.part_of_robot))
        frame = frames[frame.parent_id]
    return carrier_names(line)
