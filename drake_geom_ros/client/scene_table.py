"""Table of a scene for subscribers: geometries by id, with names, shapes and frames."""

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
from drake_geom_ros.common.frame_names import Frame, full_name, unambiguous_name
from drake_geom_ros.common.geometry_names import WORLD, GeometryNames, carrier_names, matches
from drake_geom_ros.common.nearest import nearest
from drake_geom_ros.math.batched import matrices_from_poses

_MOST_CACHED = 64  # patterns whose ids are cached: callers repeat the same few
_MOST_LOOKED_AT = 5000  # names that are compared with an unknown one, about 10 us each
_SHOWN = 4  # names of a scene in an error text
_MAPS = 'obstacles'  # the source of sensed maps


class UnknownNameError(RuntimeError):
    """A name or pattern that matches no geometry that queries report in this scene."""


@dataclass(frozen=True)
class Geometry:
    """A geometry: shape type and dimensions as in the Shape message, pose X_FG (4, 4) [m].

    ``frame_name`` is its frame's own name, ``world`` if it is anchored. ``line`` holds its frame
    and that frame's ancestors, upwards, each as ``source::frame``; it is empty if the geometry is
    anchored. Queries report only geometries with ``has_proximity``. ``carriers`` are the names
    of the robots and frames that carry it as a part.
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
        """True if the geometry is fixed to the world."""
        return not self.line

    @property
    def called(self) -> GeometryNames:
        """The names of the geometry, as a ``GeometryNames``."""
        names = self.source, self.frame_name, self.name
        return GeometryNames(*names, self.anchored, self.carriers)

    @property
    def frame(self) -> str:
        """The full name of its frame, ``source::frame``; ``world`` if it is anchored."""
        return self.called.frame

    def X_WG(self, X_WFs: Mapping[Frame, NDArray[np.float64]]) -> NDArray[np.float64]:
        """Return its pose X_WG (4, 4), by X_WF (4, 4) of frames by source and own name.

        Raises KeyError if its frame is not among them; an anchored geometry needs none.
        """
        return self.X_FG if self.anchored else X_WFs[self.own_frame] @ self.X_FG

    @property
    def own_frame(self) -> Frame:
        """Its frame as (source, own name), which is unambiguous where names hold ``::``."""
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
        """The name of the body it is part of: its frame, or itself if it is anchored."""
        return self.called.body

    @property
    def names(self) -> tuple[str, ...]:
        """The names that patterns match: of its source, frame and carriers, and its own."""
        return self.called.found_by

    def matches(self, pattern: str) -> bool:
        """Return whether a name, or a pattern with ``*`` and ``?``, matches the geometry.

        It matches by the name of its source, frame or carrier, or by its own, each with or
        without the source: ``left``, ``left::hand``, ``hand``, ``ball``, ``hand/ball``,
        ``*::hand/*``. Names may contain ``::`` and ``/``: they are compared whole.
        """
        return matches(self.names, pattern)


class JointState(NamedTuple):
    """Position, velocity and age of a joint, as the node knows them."""

    position: float  # [rad] or [m]; nan: no value yet, and queries omit the links it moves
    velocity: float  # [rad/s] or [m/s]; nan: unknown
    age: float  # [s] since the last message about it; inf: none, or none since the clock jumped

    @property
    def is_known(self) -> bool:
        """True if it has a value, possibly only that of the scene file."""
        return not math.isnan(self.position)


class Joint(NamedTuple):
    """Joint of a robot with a value of its own."""

    robot: str
    name: str
    type: str  # as in the URDF
    limits: tuple[float, float]  # [rad] or [m]; infinite if there is none
    frame: Frame | None  # of the link that it moves, by source and name; None: no such frame
    # As of the call of get_joint_positions; None in a table that comes from ~/scene alone.
    state: JointState | None = None

    @property
    def full_name(self) -> str:
        """The name that services take if two robots have the joint: ``robot::name``."""
        return f'{self.robot}::{self.name}'


class SceneTable:
    """Geometries, frames and joints of one version of the scene."""

    def __init__(
        self,
        geometries: list[Geometry],
        version: int = 0,
        parents: Mapping[Frame, Frame | None] | None = None,
        names_version: int = 0,
        frame_names: Mapping[int, str] | None = None,
        joints: Sequence[Joint] = (),
    ) -> None:
        """Index ``geometries`` by id.

        ``parents`` maps frames, by source and own name, to their parents, in an order in which
        parents come first; None is the world. ``frame_names`` are the full names by id.
        ``names_version`` is the version in which ids, names and roles changed last.
        """
        self.geometries = {geometry.id: geometry for geometry in geometries}
        self.version = version
        self.joints = tuple(joints)
        self.names_version = names_version
        self.parents = dict(parents or {})
        self._frame_names = dict(frame_names or {})
        self._ids = np.array(sorted(self.geometries), dtype=np.int64)
        self._sources = np.array([self.geometries[i].source for i in self._ids.tolist()])
        self._ids_by_pattern: dict[str, NDArray[np.int64]] = {}
        self._refusals: dict[str, str] = {}  # error texts by pattern

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
        """Return a copy of the table whose joints have these states, by full name."""
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
        """Return the full name of a frame, ``source::frame``; empty if the scene lacks it."""
        return self._frame_names.get(int(frame_id), '')

    def has(self, pattern: str) -> bool:
        """Return whether a name or a pattern matches any geometry, see ``Geometry.matches``."""
        return any(geometry.matches(pattern) for geometry in self.geometries.values())

    def ids(self, pattern: str) -> NDArray[np.int64]:
        """Return the ids of the geometries that a name or a pattern matches, ascending.

        Raises UnknownNameError, with the nearest names, if no geometry with the proximity role
        matches: queries never report others.
        """
        if pattern not in self._ids_by_pattern:
            matching = [g for g in self.geometries.values() if g.matches(pattern)]
            if not any(geometry.has_proximity for geometry in matching):
                raise UnknownNameError(self._refusal(pattern, len(matching)))
            if len(self._ids_by_pattern) >= _MOST_CACHED:
                self._ids_by_pattern.clear()
            ids = np.array(sorted(g.id for g in matching), dtype=np.int64)
            ids.setflags(write=False)
            self._ids_by_pattern[pattern] = ids
        return self._ids_by_pattern[pattern]

    def own_name(self, frame: str) -> str:
        """Return the own name of a frame, by its own or its full name, ``source::frame``.

        Names may contain ``::``: they are compared whole. Raises UnknownNameError if there is no
        such frame, or if frames with different own names match.
        """
        frames = [each for each in self.parents if frame in (each[1], full_name(each))]
        own_names = {name for _, name in frames}
        if len(own_names) == 1:
            return own_names.pop()
        if frames:
            both = ' and '.join(map(unambiguous_name, frames))
            raise UnknownNameError(f'{frame[:80]!r} stands for {both}')
        like = nearest(frame, islice(map(full_name, self.parents), _MOST_LOOKED_AT))
        raise UnknownNameError(
            f'there is no frame {frame[:80]!r} in the scene of version {self.version}{like}; see '
            'the topic ~/scene'
        )

    def _refusal(self, pattern: str, count: int) -> str:
        """Return the error text for a pattern that matches no geometry that queries report.

        ``count`` geometries without the proximity role match it.
        """
        # Callers may repeat the same wrong name with every message of a stream.
        if pattern not in self._refusals:
            if len(self._refusals) >= _MOST_CACHED:
                self._refusals.clear()
            geometries = self.geometries.values()
            if count:
                why = f'; of that name {counted(count, "geometry")} without the proximity role'
            else:
                names = dict.fromkeys(name for g in geometries for name in g.names)
                why = nearest(pattern, islice(names, _MOST_LOOKED_AT))
            sources = sorted({repr(geometry.source) for geometry in geometries})[:_SHOWN]
            self._refusals[pattern] = (
                f'{pattern[:80]!r} stands for no geometry that queries report in the scene of '
                f'version {self.version}{why}. It holds {counted(len(geometries), "geometry")} of '
                f'{", ".join(sources) or "no source"}; see the topic ~/scene'
            )
        return self._refusals[pattern]

    def waits(self, sets: Iterable[NDArray[np.int64]], frames: Collection[str]) -> bool:
        """Return whether a geometry in any of the sets of ids descends from one of the frames.

        ``frames`` are full names, ``source::frame``. Only geometries that queries report count.
        """
        waiting = set(frames)
        return any(
            not waiting.isdisjoint(geometry.line)
            for ids in sets
            for geometry in map(self.geometries.__getitem__, ids.tolist())
            if geometry.has_proximity
        )

    def have_maps(self, sets: Iterable[NDArray[np.int64]]) -> bool:
        """Return whether any of the sets of ids includes a sensed map."""
        geometries = (self.geometries[each] for ids in sets for each in ids.tolist())
        return any(geometry.source == _MAPS for geometry in geometries)

    def between(
        self, id_a: NDArray[np.int64], id_b: NDArray[np.int64], sources: tuple[str, str]
    ) -> NDArray[np.bool_]:
        """Return a mask (n,) of the pairs that have one geometry of each of two sources.

        Raises UnknownNameError for a source without a geometry that queries report.
        """
        names = dict.fromkeys(g.source for g in self.geometries.values() if g.has_proximity)
        for source in sources:
            if source not in names:
                like = nearest(source, names)
                raise UnknownNameError(
                    f'no source {source[:80]!r} has a geometry that queries report in the scene '
                    f'of version {self.version}{like}; see the topic ~/scene'
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
    """Return the names that carry a frame as a part, from SceneFrame messages by id."""
    line, frame = [], frames[frame_id]
    while frame.parent_id != frame.id:
        line.append((sources[frame.source_id], frame.name, frame.part_of_robot))
        frame = frames[frame.parent_id]
    return carrier_names(line)
