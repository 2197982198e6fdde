"""Coins around the triangles of a tree's nodes: thin where the surface is nearly flat.

A coin is a disc grown to a thickness: a point of it is off its middle by no more than ``half``
along its unit normal and by no more than ``radius`` across. That of a node lies along the mean
surface there, so it is as thin as the surface is bent: where a box around a patch of 20 mm is
20 mm thick, if the patch is turned, its coin is thinner than 1 mm. Two coins that face each other
are therefore separated by their distance to a millimetre long before their triangles are looked
at. ``coarse`` stops there.

The coins of a solid are the last of its parameters but one, a row of COIN_WIDTH for each node of
its tree.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.kernels.solids.solid import Tree, TreeBody
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add,
    add_scaled,
    dot,
    rotate,
    sub,
    vector_at,
)
from drake_geom_ros.geometry._proximity.runtime.arrays import Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import inlined
from drake_geom_ros.geometry._proximity.tolerances import EPS, NO_NORMAL, ROUNDING

Floats = NDArray[np.float64]

COIN_WIDTH = 8  # numbers of a coin: middle, normal, half, radius
SQUARED_SINE = 32.0 * EPS  # rounding of one less a squared cosine [-]
THICK = 0.2  # half the thickness over the radius [-]: a patch bent by more than 40 degrees


class Coin(NamedTuple):
    """A coin: its middle and unit normal, half its thickness and its radius [m]."""

    middle: Vector
    normal: Vector
    half: float
    radius: float


@inlined
def coins_at(shape: Floats, tree: Tree) -> int:
    """Return where the coins of a solid begin in its parameters."""
    return shape.size - 1 - COIN_WIDTH * (2 * tree.leaves - 1)


@inlined
def coin_of_node(shape: Floats, first: int, k: int) -> Coin:
    """Return the coin of node k, in the solid's frame; ``first`` is from ``coins_at``."""
    at = first + COIN_WIDTH * k
    return Coin(vector_at(shape, at), vector_at(shape, at + 3), shape[at + 6], shape[at + 7])


@inlined
def posed_coin(A: TreeBody, first: int, p: Vector, k: int) -> Coin:
    """Return the coin of node k of A in B, where A's origin is at p."""
    coin = coin_of_node(A.shape, first, k)
    return Coin(add(rotate(A.R, coin.middle), p), rotate(A.R, coin.normal), coin.half, coin.radius)


@inlined
def _sine(cosine: float) -> float:
    """Return a sine, rounded up by more than the rounding of its cosine makes it too small."""
    return math.sqrt(max(0.0, 1.0 - cosine * cosine) + SQUARED_SINE)


@inlined
def is_thick(coin: Coin) -> bool:
    """Return whether a coin is about an edge or a corner, where a box may be thinner."""
    return coin.half > THICK * coin.radius


@inlined
def separation_of_coins(A: Coin, B: Coin) -> float:
    """Return a lower bound [m] of the distance of two coins, negative where none is found.

    It is the widest slab along the line of the middles and both normals. All that is added is no
    longer than the size of the pair, so rounding makes it too large by less than
    ROUNDING EPS size.
    """
    between = sub(B.middle, A.middle)
    d = math.sqrt(dot(between, between))
    if d == 0.0:
        return -A.half - B.half
    along_A, along_B = dot(between, A.normal), dot(between, B.normal)
    a, b, turn = along_A / d, along_B / d, dot(A.normal, B.normal)
    across = _sine(turn)
    of_A = A.half * abs(a) + A.radius * _sine(a)
    of_B = B.half * abs(b) + B.radius * _sine(b)
    in_A = B.half * abs(turn) + B.radius * across
    in_B = A.half * abs(turn) + A.radius * across
    return max(d - of_A - of_B, abs(along_A) - A.half - in_A, abs(along_B) - B.half - in_B)


@inlined
def _separation_over(A: Coin, B: Coin, between: Vector) -> float:
    """Return a lower bound [m] of the distance of A and B by slabs along and across A's normal.

    Both directions are at a right angle, so both gaps are legs of what is between two points.
    """
    along, turn = dot(between, A.normal), dot(A.normal, B.normal)
    height = abs(along) - A.half - B.half * abs(turn) - B.radius * _sine(turn)
    beside = add_scaled(between, -along, A.normal)
    w, aside = math.sqrt(dot(beside, beside)), 0.0
    if w > A.radius:
        tilt = dot(beside, B.normal) / w
        aside = max(w - A.radius - B.half * abs(tilt) - B.radius * _sine(tilt), 0.0)
    height = max(height, 0.0)
    return math.sqrt(height * height + aside * aside)


@inlined
def separation_beside(A: Coin, B: Coin) -> float:
    """Return a lower bound [m] as ``separation_of_coins``, larger for coins beside each other.

    It takes twice as long.
    """
    between = sub(B.middle, A.middle)
    return max(_separation_over(A, B, between), _separation_over(B, A, between))


def coin_parameters(corners: Floats, starts: NDArray[np.int64]) -> Floats:
    """Return the coins (2 L - 1, COIN_WIDTH) of a tree's nodes.

    ``corners`` (n, 3, 3) [m] are those of the triangles in the order of the leaves, ``starts``
    (L + 1,) where the triangles of each leaf begin, the end last.
    """
    leaves = len(starts) - 1
    coins = np.empty((2 * leaves - 1, COIN_WIDTH))
    vectors = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = np.linalg.norm(vectors, axis=1)
    rounding = ROUNDING * EPS * float(np.abs(corners).max())
    first, step = leaves - 1, 1
    while True:
        ends = starts[::step]
        of_level = slice(first, 2 * first + 1)
        coins[of_level] = _coins(corners, vectors, areas, ends)
        if first == 0:
            break
        first, step = first // 2, 2 * step
    coins[:, 6:] += rounding
    return coins


def _coins(corners: Floats, vectors: Floats, areas: Floats, ends: NDArray[np.int64]) -> Floats:
    """Return the coins (k, COIN_WIDTH) of one level, whose nodes end at ``ends`` (k + 1,)."""
    firsts, counts = ends[:-1], np.diff(ends)
    normals = np.add.reduceat(vectors, firsts)
    lengths = np.linalg.norm(normals, axis=1)
    faces = lengths > NO_NORMAL * np.add.reduceat(areas, firsts)
    normals = np.divide(
        normals, lengths[:, None], out=np.zeros_like(normals), where=faces[:, None]
    )
    normals[~faces, 2] = 1.0
    low = np.minimum.reduceat(corners.min(axis=1), firsts)
    high = np.maximum.reduceat(corners.max(axis=1), firsts)
    middles = 0.5 * (low + high)
    node = np.repeat(np.arange(len(firsts)), 3 * counts)
    points = corners.reshape(-1, 3) - middles[node]
    heights = np.einsum('ij,ij->i', points, normals[node])
    bottom, top = (
        np.minimum.reduceat(heights, 3 * firsts),
        np.maximum.reduceat(heights, 3 * firsts),
    )
    across = points - heights[:, None] * normals[node]
    radii = np.maximum.reduceat(np.linalg.norm(across, axis=1), 3 * firsts)
    middles += (0.5 * (bottom + top))[:, None] * normals
    return np.column_stack((middles, normals, 0.5 * (top - bottom), radii))
