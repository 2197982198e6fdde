"""The scene as a subscriber knows it: geometries by id, with names, shapes and frames."""

from __future__ import annotations

from dataclasses import dataclass
from fnmatch import fnmatchcase
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.math.batched import matrices_from_poses

WORLD = 'world'


@dataclass(frozen=True)
class Geometry:
    """A geometry: shape type and dimensions as in the Shape message, X_FG (4, 4) in its frame.

    ``frame`` is ``source::frame``, or ``world`` where the geometry is anchored.
    """

    id: int
    source: str
    frame: str
    name: str
    shape_type: int
    dimensions: tuple[float, ...]
    X_FG: NDArray[np.float64]

    @property
    def anchored(self) -> bool:
        """Whether the geometry is fixed to the world."""
        return self.frame == WORLD

    @property
    def short_name(self) -> str:
        """The name without its source: ``frame/geometry``."""
        return f'{self.frame.rpartition("::")[2]}/{self.name}'

    @property
    def full_name(self) -> str:
        """The name that services take: ``source::frame/geometry``."""
        return f'{self.source}::{self.short_name}'

    @property
    def body(self) -> str:
        """The name of the thing it is part of: its frame, or itself where it is anchored."""
        return f'{self.source}::{self.name}' if self.anchored else self.frame

    def matches(self, pattern: str) -> bool:
        """Return whether a name, or a pattern with ``*`` and ``?``, stands for the geometry.

        That is the name of its source, frame or thing, or its own, each with or without the
        source: ``left``, ``left::hand``, ``hand``, ``ball``, ``hand/ball``, ``*::hand/*``.
        """
        frame = self.frame.rpartition('::')[2]
        own = (self.name, self.short_name, self.full_name)
        names = (self.source, self.frame, frame, self.body, *own)
        return any(fnmatchcase(name, pattern) for name in names)


class SceneTable:
    """The geometries of one version of the scene, and the parents of its frames by name."""

    def __init__(
        self,
        geometries: list[Geometry],
        version: int = 0,
        parents: dict[str, str] | None = None,
        names_version: int = 0,
    ) -> None:
        """``parents`` of frames, each ``source::frame`` or ``world``, parents first.

        ``names_version`` is the version since which ids, names and roles are these.
        """
        self.geometries = {geometry.id: geometry for geometry in geometries}
        self.version = version
        self.names_version = names_version
        self.parents = parents or {}
        self._ids = np.array(sorted(self.geometries), dtype=np.int64)
        self._sources = np.array([self.geometries[i].source for i in self._ids.tolist()])

    @classmethod
    def from_message(cls, message: Any) -> SceneTable:
        """Return the table of a Scene message."""
        sources = {source.id: source.name for source in message.sources}
        frames = {
            frame.id: WORLD
            if frame.parent_id == frame.id
            else f'{sources[frame.source_id]}::{frame.name}'
            for frame in message.frames
        }
        poses = [(entry.pose.position, entry.pose.orientation) for entry in message.geometries]
        rows = np.array([(p.x, p.y, p.z, q.x, q.y, q.z, q.w) for p, q in poses]).reshape(-1, 7)
        X_FGs = np.tile(np.eye(4), (len(rows), 1, 1))
        X_FGs[:, :3, :3], X_FGs[:, :3, 3] = matrices_from_poses(rows)
        geometries = [
            Geometry(
                entry.id,
                sources[entry.source_id],
                frames[entry.frame_id],
                entry.name,
                entry.shape.type,
                tuple(entry.shape.dimensions),
                X_FG,
            )
            for entry, X_FG in zip(message.geometries, X_FGs, strict=True)
        ]
        parents = {
            frames[frame.id]: frames[frame.parent_id]
            for frame in message.frames
            if frame.parent_id != frame.id
        }
        return cls(geometries, message.scene_version, parents, message.names_version)

    def __getitem__(self, geometry_id: int) -> Geometry:
        return self.geometries[int(geometry_id)]

    def __contains__(self, geometry_id: int) -> bool:
        return int(geometry_id) in self.geometries

    def ids(self, pattern: str) -> NDArray[np.int64]:
        """Return the ids of the geometries that a name or a pattern matches, ascending."""
        found = [g.id for g in self.geometries.values() if g.matches(pattern)]
        return np.array(sorted(found), dtype=np.int64)

    def between(
        self, id_a: NDArray[np.int64], id_b: NDArray[np.int64], sources: tuple[str, str]
    ) -> NDArray[np.bool_]:
        """Return which of n pairs have one geometry of each of two sources (n,)."""
        source_a = self._sources[np.searchsorted(self._ids, id_a)]
        source_b = self._sources[np.searchsorted(self._ids, id_b)]
        first, second = sources
        one_way = (source_a == first) & (source_b == second)
        other_way = (source_a == second) & (source_b == first)
        return np.asarray(one_way | other_way)

    def pair_name(self, id_a: int, id_b: int) -> str:
        """Return the names of the two bodies that the geometries of a pair belong to."""
        return f'{self[id_a].body} - {self[id_b].body}'
