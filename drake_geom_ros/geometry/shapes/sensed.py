"""Shapes of sensed maps: occupied cells of a grid, and measured points."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from drake_geom_ros.geometry._proximity.kinds import OCCUPIED_CELLS, POINT_CLOUD
from drake_geom_ros.geometry._proximity.tolerances import SMALLEST_CELL
from drake_geom_ros.geometry.errors import ArgumentError, ArgumentTypeError
from drake_geom_ros.geometry.shapes.primitives import PackedShape, QueriedShape, Shape
from drake_geom_ros.geometry.shapes.sensed_surfaces import surface_of_balls, surface_of_cells
from drake_geom_ros.math.array_types import Floats

MOST_CELLS = 2**23  # 8 388 608: 0.6 GB with their tree
FARTHEST_CELL = 1e9  # [m] the largest cell, and how far one may be


class SensedMap(Shape):
    """Base of the shapes of sensed maps: a union of equal cells."""

    __slots__ = ('_packed',)

    def __init__(self, size: float, positions: ArrayLike) -> None:
        if not self._TYPE:
            raise ArgumentTypeError('SensedMap: make an OccupiedCells or a PointCloud')
        self._measures = self._checked_size(size), self._checked_positions(positions)
        self._packed: dict[float, PackedShape] = {}  # by the margin

    def count(self) -> int:
        """Return the number of cells."""
        return len(self._positions)

    @property
    def _size(self) -> float:
        return float(self._measures[0])

    @property
    def _positions(self) -> Floats:
        positions: Floats = self._measures[1]
        return positions

    def _cell(self, margin: float) -> float:
        """Return half the edge of a cell, or its radius [m], with a margin added."""
        raise NotImplementedError

    def _for_queries(self, is_solid: bool = False, margin: float = 0.0) -> QueriedShape:
        return QueriedShape(self._prepared(margin))

    def prepare(self, margin: float = 0.0) -> None:
        """Pack the shape for queries with a ('map', 'margin') [m], and cache the result.

        Registration does this if necessary. Call it earlier to hold the lock of a scene shorter.
        """
        self._prepared(margin)

    def _prepared(self, margin: float) -> PackedShape:
        # Imported here: only scenes with maps need it.
        from drake_geom_ros.geometry._proximity.kernels.sensed.packing import HULL, map_parameters
        from drake_geom_ros.geometry._proximity.kernels.shapes.maps import COUNT

        packed = self._packed.get(margin)
        if packed is None:
            some = self._positions if self.count() else np.zeros((1, 3))  # a tree has a box
            parameters = map_parameters(some, self._cell(margin))
            parameters[HULL + COUNT] = self.count()
            packed = PackedShape(self._TYPE, parameters)
            self._packed = {margin: packed}
        return packed

    def box(self) -> tuple[Floats, Floats]:
        """Return the smallest and largest coordinates (3,), (3,) [m] of a union that has cells."""
        columns = self._positions.T  # NumPy is ten times as fast along this axis
        low, high = np.array([(c.min(), c.max()) for c in columns]).T
        return low - self._cell(0.0), high + self._cell(0.0)

    def surface(self) -> tuple[Floats, NDArray[np.int64]]:
        """Return vertices (n, 3) [m] and triangles (m, 3) that draw the map."""
        raise NotImplementedError

    def _checked_size(self, size: float) -> float:
        kind, name = type(self).__name__, self._NAMES[0]
        try:
            number = float(size)
        except (TypeError, ValueError):
            raise ArgumentTypeError(f'{kind}: {name} = {size!r} is not a number') from None
        if not SMALLEST_CELL <= number <= FARTHEST_CELL:
            raise ArgumentError(
                f'{kind}: {name} = {size!r} must be from {SMALLEST_CELL:g} to {FARTHEST_CELL:g} m'
            )
        return number

    def _checked_positions(self, positions: ArrayLike) -> Floats:
        """Return positions (n, 3) as a read-only array, or raise ArgumentError."""
        kind, name = type(self).__name__, self._NAMES[1]
        try:
            array = np.array(positions, dtype=np.float64, order='C')
        except (TypeError, ValueError) as problem:
            raise ArgumentTypeError(f'{kind}: {name} are no numbers (n, 3): {problem}') from None
        if array.ndim != 2 or array.shape[1] != 3:
            raise ArgumentError(f'{kind}: {name} {array.shape} must be (n, 3)')
        if len(array) > MOST_CELLS:
            raise ArgumentError(
                f'{kind}: {len(array)} {name} were given, and there may be at most {MOST_CELLS}; '
                'make a larger map coarser'
            )
        low, high = array.min(initial=0.0), array.max(initial=0.0)
        if not -FARTHEST_CELL <= low <= high <= FARTHEST_CELL:  # nor where one is NaN
            wrong = ~(np.abs(array) <= FARTHEST_CELL).all(axis=1)
            first = int(np.argmax(wrong))
            raise ArgumentError(
                f'{kind}: {np.count_nonzero(wrong)} of {len(array)} {name} are not finite or '
                f'beyond {FARTHEST_CELL:g} m, the first is {name}[{first}] = '
                f'{array[first].tolist()}'
            )
        array.flags.writeable = False
        return array

    def __eq__(self, other: object) -> bool:
        if type(other) is not type(self):
            return NotImplemented
        assert isinstance(other, SensedMap)
        same = self._size == other._size
        return same and np.array_equal(self._positions, other._positions)

    def __hash__(self) -> int:
        return hash((self._TYPE, self._size, self._positions.tobytes()))

    def __repr__(self) -> str:
        size, positions = self._NAMES
        return f'{type(self).__name__}({size}={self._size!r}, {positions}={self._positions.shape})'


class OccupiedCells(SensedMap):
    """Occupied cubes of a grid, along the axes of the geometry's frame.

    ``resolution`` [m] is their edge length, ``centres`` (n, 3) [m] their positions. They need not
    lie on a grid, and may touch, overlap and coincide. Queries treat their union as one body; the
    property ('map', 'margin') [m] enlarges each cube on all sides. A map without cells is in no
    answer: nothing was seen. Raises ArgumentError for too many cells, and positions that are not
    finite.

    >>> cells = OccupiedCells(resolution=0.1, centres=[[0.05, 0.05, 0.05], [0.15, 0.05, 0.05]])
    >>> cells.count(), cells.resolution()
    (2, 0.1)
    """

    __slots__ = ()
    _TYPE = OCCUPIED_CELLS
    _NAMES = ('resolution', 'centres')

    def __init__(self, resolution: float, centres: ArrayLike) -> None:
        super().__init__(resolution, centres)

    def resolution(self) -> float:
        """Return the edge of a cell [m]."""
        return self._size

    def centres(self) -> Floats:
        """Return the centres (n, 3) [m] in their original order, as a read-only array."""
        return self._positions

    def _cell(self, margin: float) -> float:
        return 0.5 * self._size + margin

    def surface(self) -> tuple[Floats, NDArray[np.int64]]:
        """Return vertices (n, 3) [m] and triangles (m, 3) that draw the cubes, without any margin.

        Triangles are counter-clockwise from outside. Faces between two cubes of one grid are left
        out.
        """
        return surface_of_cells(self._positions, self._size)


class PointCloud(SensedMap):
    """Measured points, each enlarged to a ball.

    ``radius`` [m] is that of the balls, ``positions`` (n, 3) [m] are their centres; they may
    overlap and coincide. Queries treat their union as one body; the property ('map', 'margin') [m]
    is added to the radius. A cloud without points is in no answer. Raises ArgumentError for too
    many points, and positions that are not finite.

    >>> cloud = PointCloud(radius=0.01, positions=[[0.0, 0.0, 1.0]])
    >>> cloud.count(), cloud.radius()
    (1, 0.01)
    """

    __slots__ = ()
    _TYPE = POINT_CLOUD
    _NAMES = ('radius', 'positions')

    def __init__(self, radius: float, positions: ArrayLike) -> None:
        super().__init__(radius, positions)

    def radius(self) -> float:
        """Return the radius of a ball [m]."""
        return self._size

    def positions(self) -> Floats:
        """Return the positions (n, 3) [m] in their original order, as a read-only array."""
        return self._positions

    def _cell(self, margin: float) -> float:
        return self._size + margin

    def surface(self) -> tuple[Floats, NDArray[np.int64]]:
        """Return vertices (n, 3) [m] and triangles (m, 3) that draw the balls, without any margin.

        Triangles are counter-clockwise from outside; they form polyhedra inscribed in the balls.
        """
        return surface_of_balls(self._positions, self._size)
