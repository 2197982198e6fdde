"""OctoMap's trees as bytes: decoding of occupied leaves to cells, encoding as a binary tree.

A tree has 16 levels of cubes, each with up to eight children; child c is the upper one along x, y
and z if bits 0, 1 and 2 of c are set. Cells of the finest level have keys from -32768 to 32767.
Nodes are stored depth first. In a binary tree an inner node is two bytes, two bits for each child:
nothing (0), free (1), occupied (2), inner (3). In a full tree a node is its log-odds (float32),
three more bytes if coloured, and a byte with a bit for each existing child.

Source: Hornung et al., OctoMap: An efficient probabilistic 3D mapping framework based on octrees,
Autonomous Robots 34 (2013), and the formats as octomap 1.10 reads and writes them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.sensed_maps.cells import MOST_CELLS, Cells, Keys, MapError, unique_numbers
from drake_geom_ros.sensed_maps.tree_walk import put_paths

LEVELS = 16
HALF = 1 << (LEVELS - 1)  # cells from the origin along an axis
_OCCUPIED, _INNER = 2, 3
# Bytes of a node in a full tree before the byte of its children, by kind of tree.
_PAYLOADS = {'OcTree': 4, 'ColorOcTree': 7}
KINDS = tuple(_PAYLOADS)
# The 16 bits of a coordinate within a path, which is a Morton code: every third bit, then groups
# of 2, 4, 8 and 16 bits, each at the start of three times its width.
_GROUPS = (0x249249249249, 0xC30C30C30C3, 0xF00F00F00F, 0xFF0000FF, 0xFFFF)


def bytes_a_node(kind: str, *, binary: bool) -> int:
    """Return the number of bytes of a node, by kind of tree; MapError for another kind."""
    check_kind(kind)
    return 2 if binary else _PAYLOADS[kind] + 1


def check_kind(kind: str) -> None:
    """Raise MapError for a kind of tree that is not read."""
    if kind not in _PAYLOADS:
        raise MapError(f'the tree is a {kind[:80]!r}; {" and ".join(KINDS)} are read')


def cells_of_binary(data: bytes | memoryview, resolution: float) -> Cells:
    """Return the occupied cells of a binary tree; raises MapError for invalid bytes.

    >>> len(cells_of_binary(binary_of_cells(Cells.of_points([[1, 2, 3]], 0.1)).data, 0.1))
    1
    """
    if len(data) % 2:
        raise MapError(f'the tree has {len(data)} bytes; of a binary one they are two a node')
    words = np.frombuffer(data, dtype='<u2')
    paths = _paths(_children(words, _INNER), LEVELS - 1)
    # A node without children would be a leaf of unknown occupancy.
    if not words.all():
        raise MapError('an inner node of the tree has no children')
    occupied = _children(words, _OCCUPIED)
    leaves = [paths[(occupied >> c & 1) != 0] << 3 | c for c in range(8)]
    return _cells_of_leaves(np.concatenate(leaves), resolution)


def cells_of_full(data: bytes | memoryview, resolution: float, kind: str = 'OcTree') -> Cells:
    """Return the occupied cells of a full tree: leaves with a probability of at least 0.5.

    Raises MapError for invalid bytes, and for log-odds that are not finite.
    """
    check_kind(kind)
    payload, step = _PAYLOADS[kind], bytes_a_node(kind, binary=False)
    if len(data) % step:
        raise MapError(f'the tree has {len(data)} bytes; of a {kind} they are {step} a node')
    rows = np.frombuffer(data, dtype=np.uint8).reshape(-1, step)
    log_odds = np.ascontiguousarray(rows[:, :4]).view('<f4')[:, 0]
    if not np.isfinite(log_odds).all():
        raise MapError('a node of the tree has log-odds that are not finite')
    children = rows[:, payload].copy()  # as ``put_paths`` is compiled for
    paths = _paths(children, LEVELS)
    is_leaf = children == 0
    return _cells_of_leaves(paths[is_leaf & (log_odds >= 0.0)], resolution)


def count_nodes(data: bytes | memoryview, kind: str, *, binary: bool) -> int:
    """Return the number of nodes of a tree, including leaves of a binary one, which have no bytes.

    >>> tree = binary_of_cells(Cells.of_points([[1, 2, 3]], 0.1))
    >>> (count_nodes(tree.data, 'OcTree', binary=True), tree.nodes)
    (17, 17)
    """
    if not binary:
        return len(data) // bytes_a_node(kind, binary=False)
    words = np.frombuffer(data, dtype='<u2')
    some = words | words >> 1 & 0x5555  # the lower bit of each child that is there
    return int(len(data) > 0) + sum(int(np.count_nonzero(some >> 2 * c & 1)) for c in range(8))


class BinaryTree(NamedTuple):
    """A binary tree as bytes, and its number of nodes, leaves included."""

    data: bytes
    nodes: int


def binary_of_cells(cells: Cells) -> BinaryTree:
    """Return the binary tree of cells; raises MapError for a cell beyond 16 levels."""
    keys = cells.keys() + HALF
    if keys.size and not 0 <= keys.min() <= keys.max() < 2 * HALF:
        raise MapError(
            f'a cell of {cells.resolution:g} m is more than {HALF} cells from the origin, the '
            'most that an OctoMap holds; make the cells larger'
        )
    if not len(cells):
        return BinaryTree(b'', 0)
    below = unique_numbers(_interleaved(keys))
    kind, count = _OCCUPIED, len(below)
    words, orders = list[NDArray[np.int64]](), list[NDArray[np.int64]]()
    for depth in range(LEVELS - 1, -1, -1):
        parents, first = np.unique(below >> 3, return_index=True)
        words.append(np.add.reduceat(kind << 2 * (below & 7), first))
        # Depth first is the order by the first corner of a cube, with larger cubes first.
        orders.append((parents << 3 * (LEVELS - depth)) * (LEVELS + 1) + depth)
        below, kind, count = parents, _INNER, count + len(parents)
    order = np.argsort(np.concatenate(orders), kind='stable')
    data = np.concatenate(words)[order].astype('<u2').tobytes()
    return BinaryTree(data, count)


def _children(words: NDArray[np.uint16], kind: int) -> NDArray[np.uint8]:
    """Return a bit for each child of one kind of a binary tree's nodes (n,)."""
    bits = np.zeros(len(words), dtype=np.uint8)
    for child in range(8):
        bits |= ((words >> 2 * child & 3) == kind).astype(np.uint8) << child
    return bits


def _paths(children: NDArray[np.uint8], most_levels: int) -> NDArray[np.int64]:
    """Return the path (n,) of each node, see ``put_paths``; MapError for no whole tree."""
    count, paths = len(children), np.empty(len(children), dtype=np.int64)
    if not count:
        return paths
    nodes, open_branches, too_deep = put_paths(children, most_levels, paths)
    if too_deep:
        raise MapError(f'the tree has more than {LEVELS} levels')
    if nodes < count:
        raise MapError(f'the tree ends after {nodes} nodes, and {count - nodes} more follow')
    if open_branches:
        raise MapError(f'the tree is truncated: {open_branches} of its branches are missing')
    return paths


def _cells_of_leaves(paths: NDArray[np.int64], resolution: float) -> Cells:
    """Return the cells that leaves cover, including leaves above the finest level."""
    depths = np.zeros(len(paths), dtype=np.int64)
    for level in range(1, LEVELS + 1):
        depths += paths >= 1 << 3 * level
    if (paths >= 1 << 3 * (LEVELS + 1)).any():
        raise MapError(f'the tree has more than {LEVELS} levels')
    # Checked first, since a few bytes of coarse leaves could become billions of cells.
    count = float((8.0 ** (LEVELS - depths)).sum())
    if count > MOST_CELLS:
        raise MapError(
            f'the tree holds {count:.3g} cells of {resolution:g} m; at most {MOST_CELLS} are read'
        )
    parts = [np.zeros((0, 3), dtype=np.int64)]
    for depth in np.flatnonzero(np.bincount(depths)).tolist():
        own = paths[depths == depth] - (1 << 3 * depth)
        edge = 1 << (LEVELS - depth)
        within = np.indices((edge, edge, edge)).reshape(3, -1).T
        corners = _deinterleaved(own) * edge
        parts.append((corners[:, np.newaxis] + within).reshape(-1, 3))
    return Cells.of_keys(np.concatenate(parts) - HALF, resolution)


def _interleaved(keys: Keys) -> NDArray[np.int64]:
    """Return the path (n,) of cells (n, 3) of the finest level, without the leading 1."""
    path = np.zeros(len(keys), dtype=np.int64)
    for axis in range(3):
        bits = keys[:, axis]
        for k in reversed(range(len(_GROUPS) - 1)):
            bits = (bits | bits << (2 << k)) & _GROUPS[k]
        path |= bits << axis
    return path


def _deinterleaved(path: NDArray[np.int64]) -> Keys:
    """Return the cells (n, 3) of paths (n,) without the leading 1."""
    keys = np.empty((len(path), 3), dtype=np.int64)
    for axis in range(3):
        bits = path >> axis & _GROUPS[0]
        for k, mask in enumerate(_GROUPS[1:], 1):
            bits = (bits | bits >> (1 << k)) & mask
        keys[:, axis] = bits
    return keys
