"""Shapes: immutable values with pydrake's names, checks and accessors.

Every shape is centred on the origin of its geometry frame G; lengths lie along its z axis.
"""

from __future__ import annotations

import copy
import math
import threading
from collections.abc import Callable, Iterator
from functools import cached_property
from typing import Any, ClassVar, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from drake_geom_ros.geometry._proximity.kinds import (
    BOX,
    CAPSULE,
    CYLINDER,
    ELLIPSOID,
    HALF_SPACE,
    SPHERE,
)
from drake_geom_ros.geometry.errors import ArgumentError, ArgumentTypeError, GeometryError
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.math.arrays import as_vector
from drake_geom_ros.math.tolerances import DIRECTION_NORM, FARTHEST

_S = TypeVar('_S', bound='Shape')
_moving = threading.Lock()  # of the parameters of any shape
_MOVED_AT_ONCE = 1 << 16  # numbers


class PackedShape:
    """A shape in the layout of ``_proximity.kernels``, for compiled code: kind and parameters.

    All holders of a shape share one, so ``parameters`` can be moved to where queries have them.
    """

    __slots__ = ('_parameters', 'kind')

    def __init__(self, kind: int, parameters: Floats) -> None:
        """Take a number of ``_proximity.kinds``, and the parameters, which never change."""
        self.kind = kind
        self._parameters: Floats | None = parameters

    @property
    def parameters(self) -> Floats:
        """The parameters, read-only."""
        parameters = self._parameters
        if parameters is None:  # another thread moves them
            with _moving:
                parameters = self._parameters
                assert parameters is not None
        return parameters

    @parameters.setter
    def parameters(self, parameters: Floats) -> None:
        """Take equal parameters that are elsewhere."""
        self._parameters = parameters

    def grown(self, before: int, after: int) -> Floats | None:
        """Return an array with room for numbers ``before`` and ``after`` the parameters.

        It is their own memory, made larger, so that they are there only once. None where somebody
        else holds that, too.
        """
        with _moving:
            own, self._parameters = self._parameters, None
            assert own is not None
            size = len(own)
            try:
                own.flags.writeable = True
                own.resize(before + size + after)  # raises where anything else refers to it
            except (ValueError, MemoryError):
                own.flags.writeable = False
                self._parameters = own
                return None
            for end in range(before + size, before, -_MOVED_AT_ONCE):
                first = max(before, end - _MOVED_AT_ONCE)
                own[first:end] = own[first - before : end - before].copy()
            moved = own[before : before + size]
            moved.flags.writeable = False
            self._parameters = moved
        return own

    def __iter__(self) -> Iterator[Any]:
        return iter((self.kind, self.parameters))


class QueriedShape:
    """The packed shapes of a geometry in proximity queries: in pairs, and to points.

    The shape to points may take long to pack, so it is packed on first use.
    """

    def __init__(
        self, in_pairs: PackedShape, to_points: Callable[[], PackedShape] | None = None
    ) -> None:
        """Without ``to_points``, both are the same."""
        self.in_pairs = in_pairs
        self._pack = to_points

    @cached_property
    def to_points(self) -> PackedShape:
        """The shape that points measure to."""
        return self.in_pairs if self._pack is None else self._pack()


class Shape:
    """Base of all shapes: immutable values that compare, hash and print by their measures."""

    __slots__ = ('_measures',)
    _TYPE: ClassVar[int] = 0  # as the constants of the Shape message
    _NAMES: ClassVar[tuple[str, ...]] = ()

    def __init__(self) -> None:
        if not self._TYPE:
            raise ArgumentTypeError('Shape: make one of its kinds, for instance Sphere(0.1)')
        self._measures: tuple[Any, ...] = ()

    def Clone(self: _S) -> _S:
        """Return a copy of the shape."""
        return copy.copy(self)

    def _for_queries(self, is_solid: bool = False, margin: float = 0.0) -> QueriedShape:
        """Return the packed shapes for proximity queries; subclasses define them here only."""
        return QueriedShape(PackedShape(self._TYPE, self._lengths()))

    def _lengths(self) -> Floats:
        """Return the lengths [m] that kernels use: half of the measures of the shape."""
        return np.array(self._measures, dtype=np.float64)

    def __eq__(self, other: object) -> bool:
        if type(other) is not type(self):
            return NotImplemented
        return self._measures == other._measures

    def __hash__(self) -> int:
        return hash((self._TYPE, self._measures))

    def __repr__(self) -> str:
        pairs = zip(self._NAMES, self._measures, strict=True)
        return f'{type(self).__name__}({", ".join(f"{n}={v!r}" for n, v in pairs)})'


def for_queries(shape: Shape, is_solid: bool = False, margin: float = 0.0) -> QueriedShape:
    """Return the packed shapes of a shape for proximity queries.

    ``is_solid`` is the property ('mesh', 'solid') of a Mesh, and ``margin`` [m] is ('map',
    'margin') of a sensed map; other shapes ignore them. Raises GeometryError for a shape that
    cannot have the proximity role.
    """
    return shape._for_queries(is_solid, margin)


class Sphere(Shape):
    """A ball of ``radius`` [m]; a radius of 0 makes a point."""

    __slots__ = ()
    _TYPE = SPHERE
    _NAMES = ('radius',)

    def __init__(self, radius: float) -> None:
        self._measures = (_number('Sphere', 'radius', radius),)
        if self._measures[0] < 0.0:
            raise ArgumentError(f'Sphere: radius = {radius} must be >= 0')

    def radius(self) -> float:
        """Return the radius [m]."""
        return float(self._measures[0])


class Box(Shape):
    """A box of ``width``, ``depth`` and ``height`` [m] along x, y and z, all > 0.

    ``Box([1, 2, 3])`` and ``Box(measures=[1, 2, 3])`` take all three in one argument.
    """

    __slots__ = ()
    _TYPE = BOX
    _NAMES = ('width', 'depth', 'height')

    def __init__(
        self,
        width: Any = None,
        depth: float | None = None,
        height: float | None = None,
        *,
        measures: ArrayLike | None = None,
    ) -> None:
        self._measures = _positive(self, (width, depth, height), measures)

    def width(self) -> float:
        """Return the size [m] along x."""
        return float(self._measures[0])

    def depth(self) -> float:
        """Return the size [m] along y."""
        return float(self._measures[1])

    def height(self) -> float:
        """Return the size [m] along z."""
        return float(self._measures[2])

    def size(self) -> Floats:
        """Return width, depth and height (3,) [m]."""
        return np.array(self._measures)

    def _lengths(self) -> Floats:
        return 0.5 * self.size()


class _Swept(Shape):
    """Base of shapes with a radius and a length along z."""

    __slots__ = ()
    _NAMES = ('radius', 'length')

    def __init__(
        self,
        radius: Any = None,
        length: float | None = None,
        *,
        measures: ArrayLike | None = None,
    ) -> None:
        self._measures = _positive(self, (radius, length), measures)

    def radius(self) -> float:
        """Return the radius [m]."""
        return float(self._measures[0])

    def length(self) -> float:
        """Return the length [m]; of a capsule, the length between its two centres."""
        return float(self._measures[1])

    def _lengths(self) -> Floats:
        return np.array([self.radius(), 0.5 * self.length()])


class Capsule(_Swept):
    """All points within ``radius`` [m] of a segment of ``length`` [m] along z, both > 0."""

    __slots__ = ()
    _TYPE = CAPSULE


class Cylinder(_Swept):
    """A cylinder of ``radius`` [m] and ``length`` [m] along z, both > 0."""

    __slots__ = ()
    _TYPE = CYLINDER


class Ellipsoid(Shape):
    """An ellipsoid of semi-axes ``a``, ``b``, ``c`` [m] along x, y and z, all > 0."""

    __slots__ = ()
    _TYPE = ELLIPSOID
    _NAMES = ('a', 'b', 'c')

    def __init__(
        self,
        a: Any = None,
        b: float | None = None,
        c: float | None = None,
        *,
        measures: ArrayLike | None = None,
    ) -> None:
        self._measures = _positive(self, (a, b, c), measures)

    def a(self) -> float:
        """Return the semi-axis [m] along x."""
        return float(self._measures[0])

    def b(self) -> float:
        """Return the semi-axis [m] along y."""
        return float(self._measures[1])

    def c(self) -> float:
        """Return the semi-axis [m] along z."""
        return float(self._measures[2])


class HalfSpace(Shape):
    """All points with z <= 0 in the geometry's frame: the plane's normal is +z."""

    __slots__ = ()
    _TYPE = HALF_SPACE

    @staticmethod
    def MakePose(Hz_dir_F: ArrayLike, p_FB: ArrayLike) -> RigidTransform:
        """Return X_FH of a half space with normal along ``Hz_dir_F`` and B on its boundary.

        Ho is the point of the boundary nearest to Fo. Raises RuntimeError when the normal, which
        need not be of unit length, is shorter than 1e-10.

            >>> HalfSpace.MakePose([0, 0, 2], [1, 1, 5]).translation().tolist()
            [0.0, 0.0, 5.0]
        """
        normal = as_vector(Hz_dir_F, 'HalfSpace.MakePose: Hz_dir_F')
        length = float(np.linalg.norm(normal))
        if length < DIRECTION_NORM:
            raise ArgumentError(
                f'HalfSpace.MakePose: |Hz_dir_F| = {length:g} must be >= {DIRECTION_NORM:g}'
            )
        Hz_F = normal / length
        Hx_F = np.cross(Hz_F, np.eye(3)[np.argmin(np.abs(Hz_F))])
        Hx_F /= np.linalg.norm(Hx_F)
        R_FH = np.column_stack((Hx_F, np.cross(Hz_F, Hx_F), Hz_F))
        offset = Hz_F @ as_vector(p_FB, 'HalfSpace.MakePose: p_FB')
        return RigidTransform._make(R_FH, offset * Hz_F)


class MeshcatCone(Shape):
    """An elliptical cone for pictures: its apex at Go, its base at z = ``height`` [m].

    ``a`` and ``b`` are the semi-axes [m] of the base along x and y; all > 0. It has no proximity
    role.
    """

    __slots__ = ()
    _TYPE = -1  # no number of kernels or messages
    _NAMES = ('height', 'a', 'b')

    def __init__(
        self,
        height: Any = None,
        a: float = 1.0,
        b: float = 1.0,
        *,
        measures: ArrayLike | None = None,
    ) -> None:
        if measures is None and np.ndim(height) == 1:
            measures = height
        self._measures = _positive(self, (height, a, b), measures)

    def height(self) -> float:
        """Return the size [m] along z."""
        return float(self._measures[0])

    def a(self) -> float:
        """Return the semi-axis [m] of the base along x."""
        return float(self._measures[1])

    def b(self) -> float:
        """Return the semi-axis [m] of the base along y."""
        return float(self._measures[2])

    def _for_queries(self, is_solid: bool = False, margin: float = 0.0) -> QueriedShape:
        raise GeometryError('MeshcatCone: it is for pictures, and cannot have the proximity role')


def _number(kind: str, name: str, value: Any) -> float:
    """Return a float up to FARTHEST, or raise an error that names the argument and its value."""
    if value is None:
        raise ArgumentTypeError(f'{kind}: {name} is missing')
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise ArgumentTypeError(f'{kind}: {name} = {value!r} must be a number [m]') from None
    if not math.isfinite(number):
        raise ArgumentError(f'{kind}: {name} = {number} must be finite')
    if number > FARTHEST:
        raise ArgumentError(f'{kind}: {name} = {number:g} must be <= {FARTHEST:.3g} [m]')
    return number


def _positive(
    shape: Shape, values: tuple[Any, ...], measures: ArrayLike | None
) -> tuple[float, ...]:
    """Return the measures of a shape, one a name, all finite and > 0."""
    kind, names = type(shape).__name__, shape._NAMES
    if measures is None and np.ndim(values[0]) == 1 and values[1:] == (None,) * len(values[1:]):
        measures = values[0]
    if measures is not None:
        if np.shape(measures) != (len(names),):
            raise ArgumentTypeError(f'{kind}: measures = {measures!r} must be {", ".join(names)}')
        values = tuple(np.asarray(measures).tolist())
    numbers = tuple(_number(kind, n, v) for n, v in zip(names, values, strict=True))
    for name, number in zip(names, numbers, strict=True):
        if number <= 0.0:
            raise ArgumentError(f'{kind}: {name} = {number} must be > 0')
    return numbers
