"""Terrain over a grid: the shape ``HeightField``."""

from __future__ import annotations

from typing import NoReturn

import numpy as np
from numpy.typing import ArrayLike

from drake_geom_ros.geometry.errors import ArgumentError, ArgumentTypeError
from drake_geom_ros.geometry.meshes.source import MeshData
from drake_geom_ros.geometry.shapes.from_meshes import Mesh
from drake_geom_ros.math.array_types import Floats, Indices
from drake_geom_ros.math.tolerances import FARTHEST

MOST_HEIGHTS = 2**19  # 524 288: a solid of 1 million triangles


class HeightField(Mesh):
    """The solid between a terrain and a flat bottom.

    The terrain passes through the points (xs[i], ys[j], heights[i, j]). Each cell of the grid is
    two triangles, which share the edge from (i, j) to (i + 1, j + 1), as in MuJoCo. Queries,
    images and messages treat it as a Mesh with the property ('mesh', 'solid'), which registration
    adds.

    Args:
        xs: Positions (m,) [m] along x, ascending, at least two.
        ys: Positions (n,) [m] along y, ascending, at least two.
        heights: Heights (m, n) [m] of the terrain along z.
        base: Height [m] of the flat bottom, below all heights.

    Raises:
        RuntimeError: Numbers are not finite, not ascending, of other shapes or not above ``base``.

    >>> ramp = HeightField([0, 1, 2], [0, 1], [[0, 0], [1, 1], [1, 1]], base=-0.5)
    >>> ramp.heights().shape
    (3, 2)
    """

    __slots__ = ('_base', '_heights', '_xs', '_ys')

    def __init__(self, xs: ArrayLike, ys: ArrayLike, heights: ArrayLike, base: float) -> None:
        self._xs, self._ys = _ascending('xs', xs), _ascending('ys', ys)
        self._heights = _numbers('heights', heights)
        self._base = float(_numbers('base', base))
        shape = len(self._xs), len(self._ys)
        if self._heights.shape != shape:
            raise ArgumentError(
                f'HeightField: heights {self._heights.shape} must be (len(xs), len(ys)) = {shape}'
            )
        if self._heights.size > MOST_HEIGHTS:
            raise ArgumentError(
                f'HeightField: {self._heights.size} heights; at most {MOST_HEIGHTS} are taken: '
                'make the grid coarser, by the highest of each block'
            )
        if not self._base < self._heights.min():
            raise ArgumentError(
                f'HeightField: base = {self._base} must be below all heights, and the lowest is '
                f'{self._heights.min()}'
            )
        surface = _closed_surface(self._xs, self._ys, self._heights, self._base)
        self._measures = MeshData(*surface), (1.0, 1.0, 1.0)

    @classmethod
    def FromMeshData(cls, data: MeshData, scale: ArrayLike = 1.0) -> NoReturn:
        """Raise RuntimeError: a height field is made of heights."""
        raise ArgumentTypeError('HeightField.FromMeshData: use HeightField(xs, ys, heights, base)')

    def xs(self) -> Floats:
        """Return the positions (m,) [m] along x, read-only."""
        return self._xs

    def ys(self) -> Floats:
        """Return the positions (n,) [m] along y, read-only."""
        return self._ys

    def heights(self) -> Floats:
        """Return the heights (m, n) [m] of the terrain, read-only."""
        return self._heights

    def base(self) -> float:
        """Return the height [m] of the bottom."""
        return self._base

    def __repr__(self) -> str:
        (m, n), (low, high) = self._heights.shape, (self._heights.min(), self._heights.max())
        return (
            f'<HeightField of {m} x {n} heights from {low:g} to {high:g} m, base {self._base:g} m>'
        )


def _numbers(name: str, values: ArrayLike) -> Floats:
    """Return values as a read-only array of finite numbers up to FARTHEST."""
    try:
        array = np.array(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ArgumentTypeError(f'HeightField: {name} are no numbers: {error}') from None
    wrong = array[~(np.abs(array) <= FARTHEST)]
    if wrong.size:
        raise ArgumentError(
            f'HeightField: {name} has {wrong.flat[0]}; all must be finite, up to {FARTHEST:.3g} m'
        )
    array.flags.writeable = False
    return array


def _ascending(name: str, values: ArrayLike) -> Floats:
    array = _numbers(name, values)
    if array.ndim != 1 or len(array) < 2 or not (np.diff(array) > 0.0).all():
        raise ArgumentError(
            f'HeightField: {name} {array.shape} must be two numbers or more, each above the last'
        )
    return array


def _closed_surface(
    xs: Floats, ys: Floats, heights: Floats, base: float
) -> tuple[Floats, Indices]:
    """Return vertices (k, 3) [m] and triangles, counter-clockwise from outside, of the solid.

    The terrain comes first. The bottom is a fan about its middle, so that it has no more edges
    than the walls need.
    """
    m, n = heights.shape
    top = np.stack((*np.meshgrid(xs, ys, indexing='ij'), heights), axis=-1).reshape(-1, 3)
    at = np.arange(m * n).reshape(m, n)
    a, b, c, d = (x.ravel() for x in (at[:-1, :-1], at[1:, :-1], at[1:, 1:], at[:-1, 1:]))
    terrain = [np.column_stack((a, b, c)), np.column_stack((a, c, d))]
    # Around the terrain, counter-clockwise from above.
    rim = np.concatenate((at[:-1, 0], at[-1, :-1], at[:0:-1, -1], at[0, :0:-1]))
    ahead = np.roll(rim, -1)
    low = len(top) + np.arange(len(rim))
    low_ahead, middle = np.roll(low, -1), np.full(len(rim), len(top) + len(rim))
    walls = [np.column_stack((low, low_ahead, ahead)), np.column_stack((low, ahead, rim))]
    bottom = np.column_stack((low_ahead, low, middle))
    floor = top[rim].copy()
    floor[:, 2] = base
    centre = [[0.5 * (xs[0] + xs[-1]), 0.5 * (ys[0] + ys[-1]), base]]
    return np.vstack((top, floor, centre)), np.concatenate((*terrain, *walls, bottom))
