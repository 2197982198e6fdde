"""What the demo knows of the scene: its geometries by id, with names, shapes and frames."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

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
    def full_name(self) -> str:
        """The name that services take: ``source::frame/geometry``."""
        frame = self.frame.rpartition('::')[2]
        return f'{self.source}::{frame}/{self.name}'

    @property
    def body(self) -> str:
        """The name of the thing it is part of: its frame, or itself where it is anchored."""
        return f'{self.source}::{self.name}' if self.anchored else self.frame


class SceneTable:
    """The geometries of one version of the scene."""

    def __init__(self, geometries: list[Geometry], version: int = 0):
        self.geometries = {geometry.id: geometry for geometry in geometries}
        self.version = version
        self._ids = np.array(sorted(self.geometries), dtype=np.int64)
        self._sources = np.array([self.geometries[i].source for i in self._ids.tolist()])

    def __getitem__(self, geometry_id: int) -> Geometry:
        return self.geometries[int(geometry_id)]

    def between(
        self, id_a: NDArray[np.int64], id_b: NDArray[np.int64], sources: tuple[str, str]
    ) -> NDArray[np.bool_]:
        """Return which pairs (n,) have one geometry of each of two sources."""
        source_a = self._sources[np.searchsorted(self._ids, id_a)]
        source_b = self._sources[np.searchsorted(self._ids, id_b)]
        first, second = sources
        one_way = (source_a == first) & (source_b == second)
        other_way = (source_a == second) & (source_b == first)
        return np.asarray(one_way | other_way)

    def pair_name(self, id_a: int, id_b: int) -> str:
        """Return the names of the two things that a pair's geometries are part of."""
        return f'{self[id_a].body} - {self[id_b].body}'
