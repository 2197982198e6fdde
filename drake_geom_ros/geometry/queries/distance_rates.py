"""Certified bounds of how fast distances change with joint values, whatever the state.

The bounds are those of ``_proximity.motion.rates``, for each joint by itself: a point at a
distance of at most r from the origin of a link moves by at most r per radian of its joint. A joint
counts for a pair only if it is between the two bodies.
"""

from __future__ import annotations

import math

import numpy as np

from drake_geom_ros.geometry._proximity.kinds import HALF_SPACE
from drake_geom_ros.geometry._proximity.motion.arrays import OFFSET
from drake_geom_ros.geometry._proximity.motion.tree import NodeTree, tree_of
from drake_geom_ros.geometry._proximity.tolerances import ROUNDED_UP
from drake_geom_ros.geometry.queries.joint_trees import JointChain, JointKind
from drake_geom_ros.geometry.queries.packed_scene import PackedScene
from drake_geom_ros.math.array_types import Floats, Indices


def distance_rates(scene: PackedScene, chain: JointChain, limits: Floats) -> Floats:
    """Return bounds (k, c) of the change of each distance per unit of each joint value.

    Rows are ``scene.pairs``, and then ``scene.half_spaces``; units are [m/rad] or [-]. For states
    q and p within the limits (2, c), ``|d(q) - d(p)| <= rates @ |q - p|``. Rates are infinite
    where a half space turns, and where a joint without limits slides what another one turns.
    """
    world = scene.world()
    world.update()
    tree = tree_of(world, scene.moved, chain)
    joint_of = np.full(len(tree.parents), -1, dtype=np.int64)
    joint_of[1 + chain.children] = np.arange(len(chain.children))
    tree.nodes[1 + chain.children, OFFSET] = _offsets(chain, limits)
    pairs = np.concatenate((scene.pairs, scene.half_spaces))
    rates = np.zeros((len(pairs), limits.shape[1]))
    reaches = np.where(scene.types == HALF_SPACE, math.inf, tree.reaches + scene.paddings)
    sides, which = np.unique(tree.on[pairs].reshape(-1, 2), axis=0, return_inverse=True)
    for number, (node_a, node_b) in enumerate(sides.tolist()):
        rows = np.flatnonzero(which.reshape(-1) == number)
        common = _common_node(tree, node_a, node_b)
        for side, node in enumerate((node_a, node_b)):
            _add(tree, chain, joint_of, (node, common), reaches[pairs[rows, side]], rates, rows)
    bounds: Floats = rates * ROUNDED_UP
    return bounds


def _offsets(chain: JointChain, limits: Floats) -> Floats:
    """Return bounds (m,) of the distances [m] of links' origins from those of their parents."""
    lengths: Floats = np.linalg.norm(chain.X_PJs[:, :3], axis=1)
    led = chain.leaders >= 0
    largest = np.zeros(len(led))
    largest[led] = np.abs(limits).max(axis=0)[chain.leaders[led]]
    slides = np.abs(chain.offsets)
    slides[led] += np.abs(chain.multipliers[led]) * largest[led]
    lengths = lengths + np.where(chain.kinds == JointKind.PRISMATIC, slides, 0.0)
    return lengths * ROUNDED_UP


def _common_node(tree: NodeTree, a: int, b: int) -> int:
    """Return the lowest common ancestor of two nodes."""
    above = {0}
    while a != 0:
        above.add(a)
        a = int(tree.parents[a])
    while b not in above:
        b = int(tree.parents[b])
    return b


def _add(
    tree: NodeTree,
    chain: JointChain,
    joint_of: Indices,
    way: tuple[int, int],
    reaches: Floats,
    rates: Floats,
    rows: Indices,
) -> None:
    """Add to ``rows`` of rates the joints from a node up to an ancestor.

    ``reaches`` (k,) [m] are the distances of the bodies' farthest points from the node's origin.
    """
    (node, common), reach = way, reaches.copy()
    while node != common:
        joint = int(joint_of[node])
        if joint >= 0 and chain.leaders[joint] >= 0:
            factor = abs(float(chain.multipliers[joint]))
            column = int(chain.leaders[joint])
            if chain.kinds[joint] == JointKind.REVOLUTE:
                rates[rows, column] += factor * reach
            elif chain.kinds[joint] == JointKind.PRISMATIC:
                rates[rows, column] += factor
        reach += tree.nodes[node, OFFSET]
        node = int(tree.parents[node])
