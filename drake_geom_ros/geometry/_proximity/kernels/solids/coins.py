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
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.kernels.solids.pieces import slices_of
from drake_geom_ros.geometry._proximity.kernels.solids.solid import Tree, TreeBody
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add,
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


def put_coins(coins: Floats, corners: Floats, starts: NDArray[np.int64]) -> None:
    """Write the coins (2 L - 1, COIN_WIDTH) of a tree's nodes.

    ``corners`` (n, 3, 3) [m] are those of the triangles in the order of the leaves, ``starts``
    (L + 1,) where the triangles of each leaf begin, the end last.
    """
    leaves = len(starts) - 1
    vectors = np.empty((len(corners), 3))
    for some in slices_of(len(corners)):
        a, b, c = corners[some].transpose(1, 0, 2)
        vectors[some] = 0.5 * np.cross(b - a, c - a)
    areas = np.linalg.norm(vectors, axis=1)
    rounding = ROUNDING * EPS * float(max(corners.max(), -corners.min()))
    first, step = leaves - 1, 1
    while True:
        ends = starts[::step]
        for some in slices_of(first + 1):
            of_some = slice(first + some.start, first + some.stop)
            _put_nodes(coins[of_some], corners, vectors, areas, ends[some.start : some.stop + 1])
        if first == 0:
            break
        first, step = first // 2, 2 * step
    coins[:, 6:] += rounding


def _put_nodes(
    coins: Floats, corners: Floats, vectors: Floats, areas: Floats, ends: NDArray[np.int64]
) -> None:
    """Write the coins (k, COIN_WIDTH) of nodes that end at ``ends`` (k + 1,), the begin first."""
    vectors, areas = vectors[ends[0] : ends[-1]], areas[ends[0] : ends[-1]]
    firsts = ends[:-1] - ends[0]
    normals = np.add.reduceat(vectors, firsts)
    lengths = np.linalg.norm(normals, axis=1)
    faces = lengths > NO_NORMAL * np.add.reduceat(areas, firsts)
    normals = np.divide(
        normals, lengths[:, None], out=np.zeros_like(normals), where=faces[:, None]
    )
    normals[~faces, 2] = 1.0
    low, high = np.full_like(normals, np.inf), np.full_like(normals, -np.inf)
    for some, nodes, at in _spans(ends):
        of_some = corners[some]
        low[nodes] = np.minimum(low[nodes], np.minimum.reduceat(of_some.min(axis=1), at))
        high[nodes] = np.maximum(high[nodes], np.maximum.reduceat(of_some.max(axis=1), at))
    middles = 0.5 * (low + high)
    bottom, top = np.full(len(firsts), np.inf), np.full(len(firsts), -np.inf)
    radii = np.zeros(len(firsts))
    for some, nodes, at in _spans(ends):
        counts = np.diff(np.append(at, some.stop - some.start))
        node = np.repeat(np.arange(nodes.start, nodes.stop), 3 * counts)
        points = corners[some].reshape(-1, 3) - middles[node]
        heights = np.einsum('ij,ij->i', points, normals[node])
        bottom[nodes] = np.minimum(bottom[nodes], np.minimum.reduceat(heights, 3 * at))
        top[nodes] = np.maximum(top[nodes], np.maximum.reduceat(heights, 3 * at))
        across = np.linalg.norm(points - heights[:, None] * normals[node], axis=1)
        radii[nodes] = np.maximum(radii[nodes], np.maximum.reduceat(across, 3 * at))
    middles += (0.5 * (bottom + top))[:, None] * normals
    coins[:, :3], coins[:, 3:6] = middles, normals
    coins[:, 6], coins[:, 7] = 0.5 * (top - bottom), radii


def _spans(ends: NDArray[np.int64]) -> Iterator[tuple[slice, slice, NDArray[np.int64]]]:
    """Yield some triangles, the nodes that they are of, and where these begin among them.

    Node k has the triangles from ``ends[k]`` to ``ends[k + 1]``; the largest and the smallest of a
    node are the same however its triangles are parted.
    """
    for piece in slices_of(int(ends[-1] - ends[0])):
        some = slice(int(ends[0]) + piece.start, int(ends[0]) + piece.stop)
        first = int(np.searchsorted(ends, some.start, side='right')) - 1
        last = int(np.searchsorted(ends, some.stop, side='left'))
        yield some, slice(first, last), np.maximum(ends[first:last] - some.start, 0)
