"""Tree of nodes of links and frames, and the common node of two bodies."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.kinds import HALF_SPACE
from drake_geom_ros.geometry._proximity.motion.arrays import (
    NODE_WIDTH,
    OFFSET,
    TURN_ROUNDING,
)
from drake_geom_ros.geometry._proximity.states.groups import Groups
from drake_geom_ros.geometry._proximity.tolerances import INTERPOLATED_ROTATION, ROUNDED_UP
from drake_geom_ros.geometry._proximity.world.joint_poses import JointChain
from drake_geom_ros.geometry._proximity.world.world import World

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


class NodeTree(NamedTuple):
    """Nodes (v,): the world, then the links of joints, then the other frames.

    A node's parent is the world, a link or a frame; that of a root link is the carrier of the
    robot. The bounds of moving nodes are filled in later.
    """

    parents: Indices  # (v,)
    nodes: Floats  # (v, NODE_WIDTH)
    on: Indices  # (n,) of geometries
    reaches: Floats  # (n,) [m]


def tree_of(world: World, rows: Indices, chain: JointChain | None) -> NodeTree:
    """Return the nodes of a world whose frames in ``rows`` (f,) are the links of a chain.

    Without a chain they are moved by poses.
    """
    links = 0 if chain is None else len(chain.X_WLs)
    frames = np.arange(len(world.frames.ids))
    of_frames = np.where(frames == 0, 0, frames + links)
    parents = np.zeros(len(frames) + links, dtype=np.int64)
    nodes = np.zeros((len(parents), NODE_WIDTH))
    parents[of_frames] = of_frames[world.frames.parents]
    nodes[of_frames, OFFSET] = offsets_of(world.p_PFs)
    if chain is not None:
        parents[1 + chain.children] = 1 + chain.parents
        parents[of_frames[rows]] = 1 + chain.links
        nodes[of_frames[rows], OFFSET] = 0.0
        roots = 1 + np.setdiff1d(np.arange(links), chain.children)
        # Poses of links are relative to the carrier of the robot, the parent of all its frames.
        root_of = np.arange(links)
        for parent, child in zip(chain.parents.tolist(), chain.children.tolist(), strict=True):
            root_of[child] = root_of[parent]
        carriers = of_frames[world.frames.parents[rows]]
        parents[1 + root_of[chain.links]] = carriers
        if (parents[1 + root_of[chain.links]] != carriers).any():
            raise ValueError('links of one robot hang on different frames')
        nodes[roots, OFFSET] = offsets_of(chain.X_WLs[roots - 1, :3])
        nodes[roots, TURN_ROUNDING] = INTERPOLATED_ROTATION
    return NodeTree(parents, nodes, of_frames[world.geometries.frames], reaches_of(world))


def reaches_of(world: World) -> Floats:
    """Return the farthest point (n,) [m] of geometries from the origins of their nodes."""
    table = world.geometries
    outer = np.where(table.types == HALF_SPACE, 0.0, world.outer_radii)
    return np.asarray((np.linalg.norm(table.p_FGs, axis=1) + outer) * ROUNDED_UP)


def reaches_of_groups(reaches: Floats, firsts: Indices, members: Indices) -> Floats:
    """Return the largest of the reaches (n,) [m] of the members of each group (g,)."""
    largest = np.zeros(len(firsts) - 1)
    np.maximum.at(largest, np.repeat(np.arange(len(largest)), np.diff(firsts)), reaches[members])
    return largest


def offsets_of(p_PFs: Floats) -> Floats:
    """Return upper bounds (f,) of the lengths [m] of p_PF (f, 3)."""
    return np.asarray(np.linalg.norm(p_PFs, axis=1) * ROUNDED_UP)


def common_nodes(tree: NodeTree, groups: Groups) -> tuple[Indices, Indices]:
    """Return the nodes (m, 2) of pairs of groups, and their lowest common ancestors (m,)."""
    of_groups = tree.on[groups.members[groups.firsts[:-1]]]
    sides, count = np.ascontiguousarray(of_groups[groups.pairs]).reshape(-1, 2), len(tree.parents)
    # As one number each, because sorting rows is ten times slower.
    codes, which = np.unique(sides @ np.array([count, 1]), return_inverse=True)
    ways: dict[int, list[int]] = {}
    for node in np.unique(sides).tolist():
        way = ways[node] = [node]
        while way[-1] != 0:
            way.append(int(tree.parents[way[-1]]))
    ancestors = np.empty(len(codes), dtype=np.int64)
    for k, code in enumerate(codes.tolist()):
        above = set(ways[code % count])
        ancestors[k] = next(node for node in ways[code // count] if node in above)
    return sides, ancestors[which.reshape(-1)]
