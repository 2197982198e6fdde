"""Trees of joints as arrays: forward kinematics of many configurations at once."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import ArrayLike, NDArray

from drake_geom_ros.geometry._proximity.joint_poses import FIXED, PRISMATIC, REVOLUTE, pose_links

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


class JointKind(IntEnum):
    """What a joint does along or about its axis."""

    FIXED = FIXED
    REVOLUTE = REVOLUTE
    PRISMATIC = PRISMATIC


@dataclass(frozen=True, eq=False)
class JointTree:
    """Links that joints hold together, parents before children; the first link is the root.

    Joint j stands at ``multipliers[j] v + offsets[j]``, v being the value ``leaders[j]`` of a
    configuration, or 0 where that is -1: a mimic joint has the leader of another one.
    """

    leaders: Indices  # (m,)
    multipliers: Floats  # (m,)
    offsets: Floats  # (m,) [rad] or [m]
    kinds: Indices  # (m,) JointKind
    axes: Floats  # (m, 3) unit
    X_PJs: Floats  # (m, 7) x y z [m] qx qy qz qw, the joint in its parent link
    parents: Indices  # (m,) rows of links
    children: Indices  # (m,) rows of links

    def link_poses(self, values: ArrayLike, X_WB: ArrayLike) -> Floats:
        """Return X_WL (N, m + 1, 7), x y z [m] qx qy qz qw, for joint values (N, c).

        ``X_WB`` (7,) is the pose of the root. Each row is computed alone: how many there are
        changes no bit of one.
        """
        rows = np.ascontiguousarray(values, dtype=np.float64)
        X_WLs = np.empty((len(rows), len(self.parents) + 1, 7))
        X_WLs[:, 0] = np.asarray(X_WB, dtype=np.float64)
        pose_links(
            rows,
            self.leaders,
            self.multipliers,
            self.offsets,
            self.kinds,
            self.axes,
            self.X_PJs,
            self.parents,
            self.children,
            X_WLs,
        )
        return X_WLs
