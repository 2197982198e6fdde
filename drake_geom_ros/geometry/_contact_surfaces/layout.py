"""Layout of the parts of an answer in one array."""

from __future__ import annotations

from typing import NamedTuple

from drake_geom_ros.geometry._contact_surfaces.arrays import FACE, RECORD, SUMS
from drake_geom_ros.geometry._contact_surfaces.compiled import compiled


class Layout(NamedTuple):
    """Starts of the parts of ``Surfaces``, in numbers of 64 bits; ``sums`` begin the array."""

    found: int
    states: int
    faces: int
    ends: int
    points: int
    pressures: int
    size: int  # of the array


@compiled
def layout_of(pairs: int, polygons: int, corners: int) -> Layout:
    """Return that of an array with room for a surface of each pair, polygons and corners."""
    found = SUMS * pairs
    states = found + RECORD * pairs
    faces = states + pairs
    ends = faces + FACE * polygons
    points = ends + polygons
    pressures = points + 3 * corners
    return Layout(found, states, faces, ends, points, pressures, pressures + corners)
