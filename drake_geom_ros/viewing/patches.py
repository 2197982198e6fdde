"""Contact surfaces for display, as triangles coloured by pressure."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from drake_geom_ros.geometry import ContactSurfaceResults
from drake_geom_ros.math.array_types import Floats, Indices

# From no pressure to the greatest: dark blue, teal, yellow, which also differ in lightness.
_COLOURS = ((0.10, 0.10, 0.45), (0.10, 0.55, 0.60), (1.00, 0.90, 0.15))


@dataclass(frozen=True, eq=False)
class Patches:
    """Surfaces: corners (v, 3) [m] in the world, pressures (v,) [Pa], triangles (t, 3)."""

    vertices: Floats
    pressures: Floats
    triangles: Indices

    @classmethod
    def of(cls, surfaces: ContactSurfaceResults) -> Patches:
        """Return patches of surfaces, with polygons as fans of triangles."""
        return cls.of_polygons(*surfaces.polygon_arrays())

    @classmethod
    def of_polygons(cls, vertices: Floats, pressures: Floats, ends: Indices) -> Patches:
        """Return patches of polygons; polygon i ends before vertex ``ends[i]`` (f,)."""
        sizes = np.diff(ends, prepend=0)
        counts = sizes - 2
        first = np.repeat(ends - sizes, counts)
        within = np.arange(len(first)) - np.repeat(np.cumsum(counts) - counts, counts)
        second = first + within + 1
        return cls(vertices, pressures, np.column_stack((first, second, second + 1)))

    @classmethod
    def none(cls) -> Patches:
        """Return no surfaces."""
        return cls(np.zeros((0, 3)), np.zeros(0), np.zeros((0, 3), dtype=np.int64))

    def __len__(self) -> int:
        return len(self.triangles)

    @property
    def max_pressure(self) -> float:
        """The greatest pressure [Pa]; 0 without vertices."""
        return float(self.pressures.max(initial=0.0))

    def colours(self) -> Floats:
        """Return the colour (v, 3), 0 to 1, of each corner; the greatest pressure is yellow."""
        return colours_of(self.shares(), 1.0)

    def shares(self) -> Floats:
        """Return the pressure (v,) at each corner, relative to the greatest one."""
        return self.pressures / (self.max_pressure or 1.0)


def colours_of(pressures: Floats, most: float) -> Floats:
    """Return the colours (..., 3), from 0 to 1, of pressures (...,) [Pa] from 0 to ``most``."""
    at = np.linspace(0.0, 1.0, len(_COLOURS))
    shares = pressures / (most or 1.0)
    channels = zip(*_COLOURS, strict=True)
    return np.stack([np.interp(shares, at, channel) for channel in channels], axis=-1)


def in_pascals(pressure: float) -> str:
    """Return a pressure [Pa] as a text such as ``88.3 kPa``."""
    for unit, words in ((1e9, 'GPa'), (1e6, 'MPa'), (1e3, 'kPa')):
        if pressure >= unit:
            return f'{pressure / unit:.3g} {words}'
    return f'{pressure:.3g} Pa'
