"""Which places a sensor looked past: rays that go by, and end farther away. Compiled.

Rays are many and places few: each place is in the buckets of directions that rays to it may have,
and a ray looks into its own bucket only.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry.compiling import compiled
from drake_geom_ros.sensed_maps.passes import Columns, as_columns

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
_STEP = 0.05  # edge of a bucket: directions are unit vectors
_WIDEST = 0.2  # of a place as seen from the sensor; nearer ones take more buckets
_BASE = 1 << 10  # buckets along an axis, in a key


class _Places(NamedTuple):
    """Where places are as seen from a sensor, and in which buckets."""

    directions: Floats  # (n, 3) unit vectors
    ranges: Floats  # (n,) [m] a ray that goes past is longer
    widths: Floats  # (n,) squares of the largest difference to the direction of such a ray
    low: Floats  # (3,) corners of a box around the directions
    high: Floats
    keys: Indices  # (k,) of buckets, ascending, with one of the places in each
    owners: Indices  # (k,)


def rays_past(columns: Columns, p_FPs: Floats, width: float, noise: float) -> Indices:
    """Return of each place (n, 3) [m] how many rays went past it.

    ``columns`` are x, y and z (a, b) [m] of the ends of rays, from the origin; one that is not
    finite is none. A ray goes past within ``width`` [m], and ends more than ``noise`` [m] behind.
    """
    counts = np.zeros(len(p_FPs), dtype=np.int64)
    lengths = np.linalg.norm(p_FPs, axis=1)
    seen = np.flatnonzero(lengths > 0.0)  # past the sensor itself nobody looks
    if not len(seen):
        return counts
    lengths = lengths[seen]
    directions = p_FPs[seen] / lengths[:, np.newaxis]
    widths = np.minimum(width / lengths, _WIDEST)
    reach = widths[:, np.newaxis]
    firsts = np.floor((directions - reach) / _STEP).astype(np.int64)
    sizes = np.floor((directions + reach) / _STEP).astype(np.int64) - firsts + 1
    many = sizes.prod(axis=1)
    owners = np.repeat(np.arange(len(seen)), many)
    number = np.arange(len(owners)) - np.repeat(np.cumsum(many) - many, many)
    _, b, c = sizes[owners].T
    steps = firsts[owners] + np.stack([number // (b * c), number // c % b, number % c], axis=1)
    keys = ((steps[:, 0] + _BASE // 2) * _BASE + steps[:, 1] + _BASE // 2) * _BASE
    keys += steps[:, 2] + _BASE // 2
    order = np.argsort(keys, kind='stable')
    found = np.zeros(len(seen), dtype=np.int64)
    low, high = (directions - reach).min(axis=0), (directions + reach).max(axis=0)
    places = _Places(
        directions, lengths + noise, widths * widths, low, high, keys[order], owners[order]
    )
    _count(as_columns(columns), places, found)
    counts[seen] = found
    return counts


@compiled
def _count(columns: Columns, places: _Places, counts: Indices) -> None:
    xs, ys, zs = columns
    low, high, keys = places.low, places.high, places.keys
    for i in range(xs.shape[0]):
        for j in range(xs.shape[1]):
            x, y, z = np.float64(xs[i, j]), np.float64(ys[i, j]), np.float64(zs[i, j])
            length = np.sqrt(x * x + y * y + z * z)
            if not 0.0 < length < np.inf:
                continue
            x, y, z = x / length, y / length, z / length
            if x < low[0] or x > high[0] or y < low[1] or y > high[1]:
                continue
            if z < low[2] or z > high[2]:
                continue
            a, b, c = int(np.floor(x / _STEP)), int(np.floor(y / _STEP)), int(np.floor(z / _STEP))
            key = ((a + _BASE // 2) * _BASE + b + _BASE // 2) * _BASE + c + _BASE // 2
            at = np.searchsorted(keys, key)
            while at < len(keys) and keys[at] == key:
                k = places.owners[at]
                at += 1
                if length <= places.ranges[k]:
                    continue
                dx, dy = x - places.directions[k, 0], y - places.directions[k, 1]
                dz = z - places.directions[k, 2]
                if dx * dx + dy * dy + dz * dz <= places.widths[k]:
                    counts[k] += 1


def compile_looking_past() -> None:
    """Compile it, or load it from the cache, for both kinds of numbers."""
    for number in (np.float32, np.float64):
        grid = np.ones((2, 2), dtype=number)
        rays_past((grid, grid, grid), np.ones((1, 3)), 0.1, 0.0)
