"""Compiled count of rays that pass places of interest and end farther away.

There are many rays and few places: each place is in the buckets of directions that rays past it
may have, and a ray searches only its own bucket.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from drake_geom_ros.geometry.compiling import compiled
from drake_geom_ros.math.array_types import Floats, Indices
from drake_geom_ros.sensed_maps.passes import Columns, as_columns

_STEP = 0.05  # edge of a bucket of unit vectors
_WIDEST = 0.2  # greatest width of a place as a difference of unit vectors, to limit its buckets
_BASE = 1 << 10  # buckets along an axis, in a key


class _Places(NamedTuple):
    """Directions and ranges of places from a sensor, with their buckets."""

    directions: Floats  # (n, 3) unit vectors
    ranges: Floats  # (n,) [m] rays past a place are longer
    widths: Floats  # (n,) squared greatest difference to the direction of such rays
    low: Floats  # (3,) corners of a box around the directions
    high: Floats
    keys: Indices  # (k,) of buckets, ascending, one entry for each place in a bucket
    owners: Indices  # (k,) places of the entries


def rays_past(columns: Columns, p_FPs: Floats, width: float, noise: float) -> Indices:
    """Return the number of rays (n,) that passed each place (n, 3) [m].

    ``columns`` are x, y and z (a, b) [m] of the ends of rays from the origin; those that are not
    finite are ignored. A ray passes a place within ``width`` [m] and ends more than ``noise`` [m]
    behind it.
    """
    counts = np.zeros(len(p_FPs), dtype=np.int64)
    lengths = np.linalg.norm(p_FPs, axis=1)
    seen = np.flatnonzero(lengths > 0.0)  # a place at the sensor has no direction
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
    counts_of_seen = np.zeros(len(seen), dtype=np.int64)
    low, high = (directions - reach).min(axis=0), (directions + reach).max(axis=0)
    places = _Places(
        directions, lengths + noise, widths * widths, low, high, keys[order], owners[order]
    )
    _count(as_columns(columns), places, counts_of_seen)
    counts[seen] = counts_of_seen
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
    """Compile ``rays_past``, or load it from the cache, for both types of numbers."""
    for number in (np.float32, np.float64):
        grid = np.ones((2, 2), dtype=number)
        rays_past((grid, grid, grid), np.ones((1, 3)), 0.1, 0.0)
