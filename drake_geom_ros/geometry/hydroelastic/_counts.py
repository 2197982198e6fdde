"""Numbers of tetrahedra by shape and hint, known before any is made; too many are refused."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from drake_geom_ros.geometry.errors import GeometryError
from drake_geom_ros.geometry.shapes.primitives import Capsule, Cylinder, Ellipsoid, Shape, Sphere
from drake_geom_ros.geometry.tolerances import SAME_HALF, SAME_HINT
from drake_geom_ros.math.array_types import Floats

# Of one body, tetrahedra or triangles: a ball cut seven times. It takes 0.1 GB of memory, and
# seconds to pack; one cut once more takes four times as much of both.
MOST_ELEMENTS = 131_072
_MOST_AROUND = 10**18  # that a count shows: more is no number that anybody reads
_MOST_HALVINGS = 60


def halvings(radius: float, resolution_hint: float) -> int:
    """Return how often a quarter of a circle is halved until its chords are within the hint."""
    levels = 0
    while levels < _MOST_HALVINGS and _chord(radius, levels) > resolution_hint:
        levels += 1
    return levels


def vertices_around_cylinder(radius: float, resolution_hint: float) -> int:
    """Return how many vertices a cylinder has around."""
    return max(3, math.ceil(_sides(radius, resolution_hint)))


def vertices_around_capsule(radius: float, resolution_hint: float) -> int:
    """Return how many vertices a capsule has around; half as many rings are on each end."""
    return max(3, math.floor(_sides(radius, resolution_hint)))


def insets(half: Floats) -> Floats:
    """Return by how much half sizes exceed the least; nothing where that is a rounding or so."""
    excess = half - half.min()
    return np.where(excess > SAME_HALF * half.min(), excess, 0.0)


def elements_of(shape: Sphere | Ellipsoid | Cylinder | Capsule, resolution_hint: float) -> int:
    """Return how many tetrahedra a round shape is cut into."""
    if isinstance(shape, Sphere):
        return 8 << 2 * halvings(shape.radius(), resolution_hint)
    if isinstance(shape, Ellipsoid):
        return 8 << 2 * halvings(max(shape.a(), shape.b(), shape.c()), resolution_hint)
    if isinstance(shape, Capsule):
        around = vertices_around_capsule(shape.radius(), resolution_hint)
        return around * (4 * (around // 2) + 1)
    # A sector has two ends and a side over a point, over a segment along the axis, or over a disc.
    at_side, at_end = insets(np.array([shape.radius(), 0.5 * shape.length()])).tolist()
    sector = 9 if at_side else 5 if at_end else 4
    return sector * vertices_around_cylinder(shape.radius(), resolution_hint)


def check_hint(shape: Sphere | Ellipsoid | Cylinder | Capsule, resolution_hint: float) -> None:
    """Raise GeometryError where a hint cuts a round shape into more than MOST_ELEMENTS."""
    count = elements_of(shape, resolution_hint)
    if count > MOST_ELEMENTS:
        least = _least_hint(lambda hint: elements_of(shape, hint), resolution_hint)
        raise GeometryError(
            f'the resolution hint {resolution_hint:g} m is too fine for the shape {shape!r}: it '
            f'would be cut into {_in_digits(count)} tetrahedra, and at most {MOST_ELEMENTS} are '
            f'allowed; give at least {least:.3g} m'
        )


def check_elements_of_mesh(shape: Shape, count: int, elements: str) -> None:
    """Raise GeometryError where a mesh, which no hint cuts, has more than MOST_ELEMENTS."""
    if count > MOST_ELEMENTS:
        raise GeometryError(
            f'the shape {shape!r} has {count} {elements}, whatever the resolution hint is, and at '
            f'most {MOST_ELEMENTS} are allowed; give a coarser mesh'
        )


def _chord(radius: float, levels: int) -> float:
    """Return the chord [m] of a quarter of a circle halved so many times."""
    return 2.0 * radius * math.sin(0.25 * math.pi / 2.0**levels)


def _sides(radius: float, resolution_hint: float) -> float:
    """Return how many times the hint fits around a circle."""
    return min(2.0 * math.pi * radius / resolution_hint, float(_MOST_AROUND))


def _least_hint(count: Callable[[float], int], refused: float) -> float:
    """Return the smallest hint [m] that cuts into few enough, rounded up to three digits."""
    low, high = refused, 2.0 * refused
    while count(high) > MOST_ELEMENTS:
        low, high = high, 2.0 * high
    while high - low > SAME_HINT * high:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if count(middle) > MOST_ELEMENTS else (low, middle)
    digit = 10.0 ** (math.floor(math.log10(high)) - 2)
    return math.ceil(high / digit) * digit


def _in_digits(count: int) -> str:
    """Return a count in digits, or about, where there are many."""
    return str(count) if count < 10**9 else f'{float(count):.1e}'
