"""Trees of joints as arrays: forward kinematics of many configurations at once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import IntEnum

import numpy as np
from numpy.typing import ArrayLike, NDArray

from drake_geom_ros.geometry._proximity.world.joint_poses import (
    FIXED,
    PRISMATIC,
    REVOLUTE,
    JointChain,
    pose_links,
)
from drake_geom_ros.math.array_types import Floats, Indices
from drake_geom_ros.math.batched import rotations_from_quaternions

__all__ = ['JointChain', 'JointKind', 'JointTree', 'chain_poses', 'side_by_side']


class JointKind(IntEnum):
    """Kind of motion of a joint along or about its axis."""

    FIXED = FIXED
    REVOLUTE = REVOLUTE
    PRISMATIC = PRISMATIC


@dataclass(frozen=True, eq=False)
class JointTree:
    """Tree of links and joints, parents before children; the first link is the root.

    Joint j has the position ``multipliers[j] v + offsets[j]``. Here v is the value ``leaders[j]``
    of a configuration, or 0 if that is -1: a mimic joint has the leader of another one.
    """

    leaders: Indices  # (m,)
    multipliers: Floats  # (m,)
    offsets: Floats  # (m,) [rad] or [m]
    kinds: Indices  # (m,) JointKind
    axes: Floats  # (m, 3) unit
    X_PJs: Floats  # (m, 7) x y z [m] qx qy qz qw, the joint in its parent link
    parents: Indices  # (m,) rows of links
    children: Indices  # (m,) rows of links

    def still_links(self) -> NDArray[np.bool_]:
        """Return the mask (m + 1,) of links that no joint value moves relative to the root."""
        moved: NDArray[np.bool_] = np.any(self.needs(), axis=1)
        return np.logical_not(moved)

    def needs(self, columns: int = 0) -> NDArray[np.bool_]:
        """Return (m + 1, c), True where a joint value moves a link relative to the root.

        With ``columns`` there are at least so many, for values that move no link, too.
        """
        columns = max(columns, 1 + int(self.leaders.max(initial=-1)))
        needs = np.zeros((len(self.parents) + 1, columns), dtype=np.bool_)
        held = (self.kinds == JointKind.FIXED) | (self.leaders < 0)
        rows = zip(self.parents, self.children, held, self.leaders, strict=True)
        for parent, child, is_held, leader in rows:
            needs[child] = needs[parent]
            if not is_held:
                needs[child, leader] = True
        return needs

    def link_twists(self, speeds: ArrayLike, X_WLs: Floats, V_WB: ArrayLike) -> Floats:
        """Return V_WL (m + 1, 6) of all links, [w, v] of the link's origin in World axes.

        Joint speeds (c,) are in [rad/s] or [m/s], the poses X_WLs (m + 1, 7), and V_WB (6,) is the
        velocity of the root. Each joint adds its own motion to that of its parent link.
        """
        rates = np.asarray(speeds, dtype=np.float64)
        V_WLs = np.empty((len(self.parents) + 1, 6))
        V_WLs[0] = V_WB
        R_WLs = rotations_from_quaternions(X_WLs[self.children, 3:])
        axes_W = (R_WLs @ self.axes[:, :, np.newaxis])[:, :, 0]
        for j, (parent, child) in enumerate(zip(self.parents, self.children, strict=True)):
            w, v = V_WLs[parent, :3], V_WLs[parent, 3:]
            arm = X_WLs[child, :3] - X_WLs[parent, :3]
            V_WLs[child, :3], V_WLs[child, 3:] = w, v + np.cross(w, arm)
            if self.kinds[j] != JointKind.FIXED and self.leaders[j] >= 0:
                part = slice(0, 3) if self.kinds[j] == JointKind.REVOLUTE else slice(3, 6)
                V_WLs[child, part] += self.multipliers[j] * rates[self.leaders[j]] * axes_W[j]
        return V_WLs

    def link_poses(self, values: ArrayLike, X_WB: ArrayLike) -> Floats:
        """Return X_WL (N, m + 1, 7), x y z [m] qx qy qz qw, for joint values (N, c).

        ``X_WB`` (7,) is the pose of the root. Rows are independent, to the bit, of each other and
        of their number.
        """
        rows = np.ascontiguousarray(values, dtype=np.float64)
        X_WLs = np.empty((len(rows), len(self.parents) + 1, 7))
        self.put_poses(rows, X_WB, np.arange(X_WLs.shape[1]), X_WLs, 0)
        return X_WLs

    def put_poses(
        self, values: Floats, X_WB: ArrayLike, links: Indices, X_WLs: Floats, first: int
    ) -> None:
        """Write the poses of some ``links`` (k,) to ``X_WLs`` (N, m, 7), from row ``first`` on."""
        scratch = np.empty((len(self.parents) + 1, 7))
        scratch[0] = X_WB
        joints = self.leaders, self.multipliers, self.offsets, self.kinds, self.axes, self.X_PJs
        chain = *joints, self.parents, self.children, scratch, links
        pose_links(values, chain, first, X_WLs)

    def driven_by(self, columns: Indices, at_rest: Floats) -> JointTree:
        """Return the tree for configurations that have value v in column ``columns[v]``.

        If that is -1 the value stays at ``at_rest[v]``.
        """
        led = self.leaders >= 0
        leaders, still = np.full_like(self.leaders, -1), np.zeros_like(self.offsets)
        leaders[led] = columns[self.leaders[led]]
        still[led] = at_rest[self.leaders[led]]
        fixed = led & (leaders < 0)
        return replace(
            self,
            leaders=leaders,
            offsets=np.where(fixed, self.offsets + self.multipliers * still, self.offsets),
        )


def chain_poses(chain: JointChain, values: ArrayLike) -> Floats:
    """Return X_WL (N, n, 7), x y z [m] qx qy qz qw, of a chain's ``links``, for values (N, c)."""
    rows = np.ascontiguousarray(values, dtype=np.float64)
    X_WLs = np.empty((len(rows), len(chain.links), 7))
    pose_links(rows, tuple(chain), 0, X_WLs)
    return X_WLs


def side_by_side(
    trees: Sequence[JointTree], X_WBs: Floats, links: Sequence[Indices]
) -> JointChain:
    """Return trees of the same columns as one chain, with their roots at X_WBs (k, 7).

    ``links`` has the rows of links of each tree whose poses are wanted, in their order.
    """
    sizes = [len(tree.parents) + 1 for tree in trees]
    firsts = np.concatenate(([0], np.cumsum(sizes)))[: len(trees)]
    X_WLs = np.zeros((sum(sizes), 7))
    X_WLs[firsts] = X_WBs

    def shifted(each: Sequence[Indices]) -> Indices:
        return np.concatenate([rows + first for rows, first in zip(each, firsts, strict=True)])

    return JointChain(
        leaders=np.concatenate([tree.leaders for tree in trees]),
        multipliers=np.concatenate([tree.multipliers for tree in trees]),
        offsets=np.concatenate([tree.offsets for tree in trees]),
        kinds=np.concatenate([tree.kinds for tree in trees]),
        axes=np.concatenate([tree.axes for tree in trees]),
        X_PJs=np.concatenate([tree.X_PJs for tree in trees]),
        parents=shifted([tree.parents for tree in trees]),
        children=shifted([tree.children for tree in trees]),
        X_WLs=X_WLs,
        links=shifted(links),
    )
