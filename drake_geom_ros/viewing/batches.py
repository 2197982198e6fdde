"""Batches of a scene: copies of one surface, posed together in a few array operations."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry import GeometryError
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.math.batched import compose, quaternions_from_rotations
from drake_geom_ros.viewing.looks import LAYERS, Look
from drake_geom_ros.viewing.scaled_surfaces import (
    ROUND,
    DrawnSurface,
    Part,
    facets_around,
    parts_of,
)


@dataclass(frozen=True, eq=False)
class SurfaceBatch:
    """Copies of one surface in one layer, all with the same transparency.

    ``bodies`` (n,) are the rows of the poses that the copies follow, ``geometries`` (n,) the
    values of their geometries' ids, ``scales`` (n, 3) and ``colours`` (n, 3) those of the copies.
    """

    layer: str
    surface: DrawnSurface
    alpha: float
    bodies: NDArray[np.int64]
    geometries: NDArray[np.int64]
    scales: Floats
    colours: NDArray[np.uint8]
    R_GSs: Floats
    p_GSs: Floats

    def posed(self, R_WGs: Floats, p_WGs: Floats) -> tuple[Floats, Floats]:
        """Return p_WS (n, 3) [m] and the unit quaternions w x y z (n, 4) of the copies.

        R_WG (k, 3, 3) and p_WG (k, 3) [m] are the poses of all shown geometries.
        """
        R_WSs, p_WSs = compose(R_WGs[self.bodies], p_WGs[self.bodies], self.R_GSs, self.p_GSs)
        return p_WSs, np.roll(quaternions_from_rotations(R_WSs), 1, axis=1)


@dataclass(frozen=True)
class Batches:
    """All batches of a scene, and the reasons why other geometries cannot be drawn."""

    batches: list[SurfaceBatch]
    troubles: list[str]


def batches_of(
    looks: Sequence[Look],
    row_of: Callable[[int], int],
    progress: Callable[[int], None] = lambda done: None,
) -> Batches:
    """Return the batches of looks; ``row_of`` maps a geometry's id value to its row of poses.

    ``progress(done)`` is called with the number of looks done, since large meshes take time.
    Shapes that cannot be drawn, such as unreadable meshes, are skipped and reported in
    ``troubles``.
    """
    members: defaultdict[tuple[str, str, float], list[tuple[Look, Part]]] = defaultdict(list)
    troubles = []
    around = facets_around(sum(isinstance(look.shape, ROUND) for look in looks))
    for done, look in enumerate(looks, start=1):
        try:
            for part in parts_of(look.shape, look.solid, around):
                key = LAYERS[look.role], part.surface.key, look.colour[3]
                members[key].append((look, part))
        except (GeometryError, OSError) as error:
            troubles.append(f'{look.name}: {error}')
        progress(done)
    return Batches(
        [_batch(layer, alpha, group, row_of) for (layer, _, alpha), group in members.items()],
        troubles,
    )


def _batch(
    layer: str, alpha: float, members: list[tuple[Look, Part]], row_of: Callable[[int], int]
) -> SurfaceBatch:
    geometries = [look.geometry.get_value() for look, _ in members]
    X_GSs: list[RigidTransform] = [part.X_GS for _, part in members]
    return SurfaceBatch(
        layer,
        members[0][1].surface,
        alpha,
        np.array([row_of(value) for value in geometries], dtype=np.int64),
        np.array(geometries, dtype=np.int64),
        np.array([part.scale for _, part in members]),
        np.array([np.round(255.0 * np.array(look.colour[:3])) for look, _ in members], np.uint8),
        np.array([X.rotation().matrix() for X in X_GSs]),
        np.array([X.translation() for X in X_GSs]),
    )
