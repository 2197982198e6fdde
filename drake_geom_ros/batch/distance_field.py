"""``sample_sdf``: signed distances of a scene at the points of a grid."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from drake_geom_ros.batch.evaluation import context_of
from drake_geom_ros.batch.running import cores
from drake_geom_ros.batch.volume_files import write_nrrd, write_vdb
from drake_geom_ros.common.whole_files import whole_file
from drake_geom_ros.geometry import (
    ArgumentError,
    GeometryId,
    PointDistanceResults,
    SceneGraph,
    SceneGraphContext,
)
from drake_geom_ros.geometry.checks import as_number
from drake_geom_ros.geometry.queries.packed_scene import PackedScene
from drake_geom_ros.geometry.queries.state_queries import StateQueries
from drake_geom_ros.math.array_types import Flags, Floats, Indices

_FORMATS = ('.npz', '.npy', '.nrrd', '.vdb')
_SIDE = 16  # points of a block along each axis, whose geometries are chosen by its centre
_STILL = np.zeros((1, 0, 7))  # the state in which nothing moves
_SLACK = 1.0 + 2.0**-20  # more than rounding


class DistanceField(NamedTuple):
    """Signed distances of the nearest geometry at the points of a grid.

    Point (i, j, k) is at ``origin + resolution * (i, j, k)`` in World. A distance is within
    ``error_bound`` of the smallest signed distance of all geometries. That is the distance of
    their union outside of it; inside of overlapping geometries the union is at least as deep.
    Between points the distance changes by at most the length of the way.
    """

    origin: Floats  # (3,) [m]
    resolution: float  # [m]
    distance: Floats  # (nx, ny, nz) [m]
    error_bound: Floats  # (nx, ny, nz) [m]
    gradient: Floats  # (nx, ny, nz, 3) by the point's position
    is_gradient_unique: Flags  # (nx, ny, nz)
    id_G: Indices  # (nx, ny, nz) id values of the nearest geometries

    @property
    def points(self) -> Floats:
        """The points (nx, ny, nz, 3) [m] of the grid in World."""
        axes = np.moveaxis(np.indices(self.distance.shape), 0, -1)
        points: Floats = self.origin + self.resolution * axes
        return points

    def save(self, path: str | Path) -> None:
        """Write the field to a file, in the format of its suffix.

        ``.npz`` holds all arrays by name; ``.npy`` the distances alone; ``.nrrd`` the distances
        with origin and spacing [m] for volume viewers, and needs the extra ``nrrd``; ``.vdb`` the
        distances as a level set in single precision, and needs OpenVDB's Python module. An
        existing file is replaced at the end. Raises ArgumentError for another suffix, ImportError
        for a missing library, OSError.
        """
        suffix = Path(path).suffix
        if suffix not in _FORMATS:
            formats = f'{", ".join(_FORMATS[:-1])} or {_FORMATS[-1]}'
            raise ArgumentError(f'path={str(path)!r} must end with {formats}')
        with whole_file(path, 'wb') as file:
            if suffix == '.npz':
                np.savez_compressed(file, **self._asdict())
            elif suffix == '.npy':
                np.save(file, self.distance)
            elif suffix == '.nrrd':
                write_nrrd(file, self.distance, self.origin, self.resolution)
            else:
                bound = float(self.error_bound.max())
                write_vdb(file, self.distance, bound, self.origin, self.resolution)


def sample_sdf(
    scene_graph: SceneGraph | SceneGraphContext,
    bounds: ArrayLike,
    resolution: float,
    geometries: Sequence[GeometryId] | None = None,
    threads: int = 0,
) -> DistanceField:
    """Return the signed distances of a scene, or of some of its bodies, on a grid of points.

    Args:
        scene_graph: a scene with its first poses, or a context with its own.
        bounds: lower and upper corner (2, 3) [m] in World. The grid begins at the lower one and
            reaches the upper one or beyond.
        resolution: [m] distance of neighbouring points.
        geometries: ids of geometries with the proximity role; None: all of them.
        threads: 0: one for each core. They do not change the result.

    Returns:
        ``DistanceField``. Distances to points are closed forms at every level of accuracy.

    Raises:
        ArgumentError: bounds that are not finite or crossed, a resolution that is not above 0, an
            unknown geometry, a scene without any.
        PoseError: frames without a pose.

        >>> scene_graph = SceneGraph()
        >>> _ = load_scene('scenes/minimal.yaml', scene_graph)
        >>> sample_sdf(scene_graph, [[0, 0, 0], [0.3, 0.2, 0.1]], 0.1).distance.shape
        (4, 3, 2)
    """
    origin, counts = _grid_of(bounds, resolution)
    if threads < 0:
        raise ArgumentError(f'threads={threads} must be >= 0')
    none = np.zeros(0, dtype=np.int64)
    scene, ids = PackedScene.of(context_of(scene_graph), none)
    chosen = _chosen(ids, geometries)
    scene, ids = scene.with_geometries(chosen), ids[chosen]
    field = DistanceField(
        origin,
        float(resolution),
        np.empty(counts),
        np.empty(counts),
        np.empty((*counts, 3)),
        np.empty(counts, dtype=np.bool_),
        np.empty(counts, dtype=np.int64),
    )
    blocks = list(_blocks(counts))
    shares = [blocks[first :: threads or cores()] for first in range(threads or cores())]
    stop = np.zeros(1, dtype=np.int64)

    def fill(share: list[tuple[slice, ...]]) -> None:
        queries = StateQueries(scene)
        for block in share:
            _fill(field, block, scene, queries, stop)

    with ThreadPoolExecutor(len(shares)) as pool:
        try:
            for _ in pool.map(fill, shares):
                pass
        finally:
            stop[0] = 1  # ends the others after an error or an interrupt
    return field._replace(id_G=ids[field.id_G])


def _grid_of(bounds: ArrayLike, resolution: float) -> tuple[Floats, tuple[int, ...]]:
    """Return the first point and the numbers of points of a grid; raises ArgumentError."""
    corners, step = np.array(bounds, dtype=np.float64), as_number(resolution)
    if corners.shape != (2, 3) or not np.isfinite(corners).all():
        raise ArgumentError(
            f'bounds={corners.tolist()} must be two corners (2, 3), lower and upper, in metres'
        )
    if not (corners[0] <= corners[1]).all():
        raise ArgumentError(f'bounds={corners.tolist()}: the lower corner is above the upper one')
    if step is None or not 0.0 < step < math.inf:
        raise ArgumentError(f'resolution={resolution!r} must be a number above 0, in metres')
    counts = np.ceil((corners[1] - corners[0]) / step / _SLACK).astype(np.int64) + 1
    return corners[0], tuple(counts.tolist())


def _chosen(ids: Indices, geometries: Sequence[GeometryId] | None) -> Indices:
    """Return the places (k,) of chosen geometries; raises ArgumentError for unknown ones."""
    place_of = {value: place for place, value in enumerate(ids.tolist())}
    values = list(place_of)
    if geometries is not None:
        values = [g.get_value() if isinstance(g, GeometryId) else g for g in geometries]
    unknown = [value for value in values if value not in place_of]
    if unknown:
        raise ArgumentError(
            f'geometries has {unknown[0]!r}, which is not in the scene, or has no proximity role'
        )
    if not values:
        raise ArgumentError('no geometry has the proximity role: there is no distance to sample')
    return np.unique([place_of[value] for value in values])


def _blocks(counts: tuple[int, ...]) -> Iterator[tuple[slice, ...]]:
    """Yield blocks of a grid, as slices along its axes."""
    firsts = [range(0, count, _SIDE) for count in counts]
    for i in firsts[0]:
        for j in firsts[1]:
            for k in firsts[2]:
                starts = zip((i, j, k), counts, strict=True)
                yield tuple(slice(first, min(first + _SIDE, count)) for first, count in starts)


def _fill(
    field: DistanceField,
    block: tuple[slice, ...],
    scene: PackedScene,
    queries: StateQueries,
    stop: NDArray[np.int64],
) -> None:
    """Fill a block of a field, with places of geometries for ids.

    The geometry that is nearest to a point is no farther from the centre of the block than the
    centre's nearest one, plus twice the way from the centre.
    """
    axes = [np.arange(each.start, each.stop) for each in block]
    shape = tuple(len(axis) for axis in axes)
    grid = np.stack(np.meshgrid(*axes, indexing='ij'), axis=-1).reshape(-1, 3)
    points = field.origin + field.resolution * grid
    centre = 0.5 * (points[0] + points[-1])
    around = _answers(queries, centre[None], stop)
    way = float(np.linalg.norm(points[-1] - centre))
    reach = float((around.distance + around.error_bound).min()) + 2.0 * way
    reach += (_SLACK - 1.0) * (abs(reach) + way + float(np.abs(points).max()))
    is_near = around.distance - around.error_bound <= reach
    places = np.sort(around.id_G[is_near])
    some = queries if len(places) == len(scene.types) else _of_some(scene, places)
    answers = _answers(some, points, stop)
    # Each point has an answer of each geometry.
    lower = (answers.distance - answers.error_bound).reshape(len(points), -1)
    nearest = np.arange(len(points)) * lower.shape[1] + np.argmin(lower, axis=1)
    field.distance[block] = answers.distance[nearest].reshape(shape)
    field.error_bound[block] = answers.error_bound[nearest].reshape(shape)
    field.gradient[block] = answers.grad_W[nearest].reshape(*shape, 3)
    field.is_gradient_unique[block] = answers.is_grad_W_unique[nearest].reshape(shape)
    own = places if some is not queries else np.arange(len(scene.types))
    field.id_G[block] = own[answers.id_G[nearest]].reshape(shape)


def _of_some(scene: PackedScene, places: Indices) -> StateQueries:
    """Return queries about some geometries of a scene, in the order of their places."""
    return StateQueries(scene.with_geometries(places))


def _answers(
    queries: StateQueries, points: Floats, stop: NDArray[np.int64]
) -> PointDistanceResults:
    """Return the distances of all geometries to points, sorted by point and geometry."""
    _, results = queries.points(_STILL, points, math.inf, stop)
    assert isinstance(results, PointDistanceResults)
    return results
