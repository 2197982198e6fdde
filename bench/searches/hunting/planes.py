"""The independent plane: the widest gap between supporting planes that a search finds.

For every unit n, ``f(n) = n . p_AB - h_A(n) - h_B(-n)`` is a lower bound of the signed distance,
h being the support functions: bodies that are apart are at least so far apart, and of bodies that
overlap none is deeper than ``-f(n)``. Directions that minima are known to lie at come first (axes,
their cross products, the centre line, rings about the axes, the answers' normals), then caps
that shrink about the best of them. It is written for many pairs in little time; what it
does not reach is for ``truth.convex`` to tell. Nothing of the engine takes part.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from drake_geom_ros.cross_check.bodies import Body, Pair
from drake_geom_ros.math.array_types import Floats
from truth.bodies.random_bodies import even_directions
from truth.references.supports import posed
from truth.tolerances import ALIKE, NARROWEST, ON_AXIS

SHAPES = 4096  # that are kept as arrays
RING = 16  # directions about each axis
EVENLY = 48  # directions anywhere
STARTS = 3  # of caps that shrink
TURNS = 6  # directions on the rim of a cap
WIDEST = 0.2  # [rad] of a cap
CAPS = 60  # at most: the narrowest is reached in 21 where none leads further
SHRINKING = 0.4
GOLDEN = math.pi * (3.0 - math.sqrt(5.0))


class Packed(NamedTuple):
    """Pairs as arrays: each body is the sum of a polytope, a ball and an ellipsoid or a disc."""

    vertices: Floats  # (n, 2, v, 3) [m] in the geometry's frame; the last is repeated
    counts: NDArray[np.int64]  # (n, 2) of vertices
    radii: Floats  # (n, 2) [m]
    flats: Floats  # (n, 2, 3) [m] half axes of the ellipsoid or the disc
    Rs: Floats  # (n, 2, 3, 3)
    offsets: Floats  # (n, 3) [m] p_AB_W
    half_spaces: NDArray[np.int64]  # (n,) 1 where A is one, 2 where B is one, else 0


def packed(pairs: Sequence[Pair]) -> Packed:
    """Return pairs as arrays."""
    bodies = [[_parts(one.kind, one.size) for one in (pair.a, pair.b)] for pair in pairs]
    most = max(len(part[0]) for pair in bodies for part in pair)
    vertices = np.array(
        [[part[0][np.minimum(np.arange(most), len(part[0]) - 1)] for part in pair]
         for pair in bodies]
    )  # fmt: skip
    return Packed(
        vertices,
        np.array([[len(part[0]) for part in pair] for pair in bodies]),
        np.array([[part[1] for part in pair] for pair in bodies]),
        np.array([[part[2] for part in pair] for pair in bodies]),
        np.array([[pair.a.R, pair.b.R] for pair in pairs]),
        np.array([pair.b.p - pair.a.p for pair in pairs]),
        np.array([(pair.a.kind == 'HalfSpace') + 2 * (pair.b.kind == 'HalfSpace')
                  for pair in pairs]),
    )  # fmt: skip


@functools.lru_cache(maxsize=SHAPES)
def _parts(kind: str, size: tuple) -> tuple[Floats, float, Floats]:
    """Return vertices (v, 3), radius and half axes (3,) of a shape."""
    if kind == 'HalfSpace':
        return np.zeros((1, 3)), 0.0, np.zeros(3)
    if kind == 'Convex':
        return np.array(size), 0.0, np.zeros(3)
    body = posed(Body(kind, size).form, np.eye(3), np.zeros(3))
    flat = np.zeros(3)
    flat[: len(body.flat)] = np.diag(body.flat[:, : len(body.flat)])
    return body.vertices, body.radius, flat


def widest(pairs: Packed, normals: Floats) -> tuple[Floats, Floats]:
    """Return the widest gaps (n,) [m] found, and their directions (n, 3) out of A.

    ``normals`` (n, m, 3), nhat_BA_W of answers, are looked at first.
    """
    return _widest(*pairs, normals, even_directions(EVENLY))


def gaps(pairs: Packed, normals: Floats) -> Floats:
    """Return the gaps (n,) [m] along normals (n, 3), which are nhat_BA_W."""
    return _gaps(*pairs, normals)


@njit(cache=True)
def _height(vertices, count, radius, flat, R, x, y, z):
    """Return the support value of a body about its origin, along a unit vector in World."""
    a = R[0, 0] * x + R[1, 0] * y + R[2, 0] * z
    b = R[0, 1] * x + R[1, 1] * y + R[2, 1] * z
    c = R[0, 2] * x + R[1, 2] * y + R[2, 2] * z
    best = -math.inf
    for k in range(count):
        best = max(best, vertices[k, 0] * a + vertices[k, 1] * b + vertices[k, 2] * c)
    a, b, c = flat[0] * a, flat[1] * b, flat[2] * c
    return best + radius + math.sqrt(a * a + b * b + c * c)


@njit(cache=True)
def _gap(vertices, counts, radii, flats, Rs, offset, x, y, z):
    along = x * offset[0] + y * offset[1] + z * offset[2]
    h_A = _height(vertices[0], counts[0], radii[0], flats[0], Rs[0], x, y, z)
    return along - h_A - _height(vertices[1], counts[1], radii[1], flats[1], Rs[1], -x, -y, -z)


@njit(cache=True)
def _out_of_a(Rs, half_space):
    """Return the unit direction out of A of a pair of which A (1) or B (2) is a half space."""
    n = Rs[0, :, 2].copy() if half_space == 1 else -Rs[1, :, 2]
    return n / math.sqrt(np.sum(n**2))  # a rotation may be off orthogonal


@njit(cache=True)
def _gaps(vertices, counts, radii, flats, Rs, offsets, half_spaces, normals):
    out = np.empty(offsets.shape[0])
    for i in range(offsets.shape[0]):
        # A half space ends along its normal only, and an answer's may be off by its rounding.
        n = -normals[i]
        if half_spaces[i]:
            n = _out_of_a(Rs[i], half_spaces[i])
        out[i] = _gap(
            vertices[i], counts[i], radii[i], flats[i], Rs[i], offsets[i], n[0], n[1], n[2]
        )
    return out


@njit(cache=True)
def _directions(Rs, offset, normals, evenly):
    """Return vectors (m, 3), some of them 0, next to which the maximum may be."""
    out = np.zeros((16 + 2 * RING + normals.shape[0] + evenly.shape[0], 3))
    m = 0
    for k in range(3):
        out[m], out[m + 1] = Rs[0, :, k], Rs[1, :, k]
        m += 2
    for j in range(3):
        for k in range(3):
            out[m] = np.cross(Rs[0, :, j], Rs[1, :, k])
            m += 1
    out[m] = offset
    m += 1
    for side in range(2):
        # Right across the axis from the centre line, and evenly round from there.
        axis = Rs[side, :, 2].copy()
        u = offset - np.dot(offset, axis) * axis
        if np.dot(u, u) <= ON_AXIS * np.dot(offset, offset):
            u = Rs[side, :, 0].copy()
        u /= math.sqrt(np.dot(u, u))
        v = np.cross(axis, u)
        for k in range(RING):
            turn = math.pi * k / RING
            out[m] = math.cos(turn) * u + math.sin(turn) * v
            m += 1
    for k in range(normals.shape[0]):
        out[m] = normals[k]
        m += 1
    out[m : m + evenly.shape[0]] = evenly
    return out


@njit(cache=True)
def _climbed(vertices, counts, radii, flats, Rs, offset, x, y, z, best):
    """Return the best gap that caps about a direction find as they shrink, and its direction."""
    angle, turn = WIDEST, 0.0
    for _ in range(CAPS):
        if angle < NARROWEST:
            break
        # Two directions at right angles, by the axis that is farthest off.
        if abs(z) < 0.6:
            length = math.hypot(x, y)
            a, b, c = y / length, -x / length, 0.0
        else:
            length = math.hypot(x, z)
            a, b, c = -z / length, 0.0, x / length
        d, e, f = y * c - z * b, z * a - x * c, x * b - y * a
        top, s, t, u = best, x, y, z
        for k in range(TURNS):
            phase = turn + 2.0 * math.pi * k / TURNS
            cos, sin = angle * math.cos(phase), angle * math.sin(phase)
            p, q, r = x + cos * a + sin * d, y + cos * b + sin * e, z + cos * c + sin * f
            length = math.sqrt(p * p + q * q + r * r)
            p, q, r = p / length, q / length, r / length
            value = _gap(vertices, counts, radii, flats, Rs, offset, p, q, r)
            if value > top:
                top, s, t, u = value, p, q, r
        if not top > best:
            angle *= SHRINKING
        best, x, y, z = top, s, t, u
        turn += GOLDEN
    return best, x, y, z


@njit(cache=True)
def _widest(vertices, counts, radii, flats, Rs, offsets, half_spaces, normals, evenly):
    best, best_n = np.full(offsets.shape[0], -np.inf), np.zeros((offsets.shape[0], 3))
    for i in range(offsets.shape[0]):
        body = vertices[i], counts[i], radii[i], flats[i], Rs[i], offsets[i]
        if half_spaces[i]:
            n = _out_of_a(Rs[i], half_spaces[i])
            best[i], best_n[i] = _gap(*body, n[0], n[1], n[2]), n
            continue
        directions = _directions(Rs[i], offsets[i], normals[i], evenly)
        values = np.full(2 * directions.shape[0], -np.inf)
        for k in range(directions.shape[0]):
            for _ in range(2):  # the second time for the rounding of the first
                length = math.sqrt(np.sum(directions[k] ** 2))
                if length > 0.0:
                    directions[k] /= length
            n = directions[k]
            if length > 0.0:
                values[2 * k] = _gap(*body, n[0], n[1], n[2])
                values[2 * k + 1] = _gap(*body, -n[0], -n[1], -n[2])
        for _ in range(STARTS):
            k = np.argmax(values)
            if values[k] == -np.inf:
                break
            n = directions[k // 2] * (1.0 - 2.0 * (k % 2))
            value, x, y, z = _climbed(*body, n[0], n[1], n[2], values[k])
            if value > best[i]:
                best[i], best_n[i, 0], best_n[i, 1], best_n[i, 2] = value, x, y, z
            for j in range(values.shape[0]):
                side = 1.0 - 2.0 * (j % 2)
                m = directions[j // 2]
                if side * (m[0] * n[0] + m[1] * n[1] + m[2] * n[2]) > ALIKE:
                    values[j] = -np.inf
    return best, best_n
