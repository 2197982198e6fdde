"""How frames move: by messages that say so, or by the last two stamped poses. No ROS import.

A twist holds for the pose that it belongs to: one that is told, until a pose with a later stamp
comes; one from two poses, for the later of them. So none is older than the pose it is used with.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry import FrameId, FramePoseVector, QueryObject
from drake_geom_ros.math import RigidTransform

Floats = NDArray[np.float64]
_NANOSECONDS = 1e-9  # [s]


class _Stamped(NamedTuple):
    """A pose X_PF and, where the one before tells it, the twist V_PF (6,) that led there."""

    stamp: int  # [ns]
    X_PF: RigidTransform
    V_PF: Floats | None


class FrameTwists:
    """The twists of the frames of one scene, by the values of their ids."""

    def __init__(self, longest_gap: float) -> None:
        """Poses farther apart than ``longest_gap`` [s] tell nothing of the motion in between."""
        self._longest_gap = longest_gap
        self._poses: dict[int, _Stamped] = {}
        self._told: dict[int, tuple[int, Floats]] = {}

    def note_poses(self, poses: FramePoseVector, stamps: Mapping[int, int]) -> None:
        """Note the poses of frames, and their stamps [ns] by id value; 0: it bears none."""
        for value, stamp in stamps.items():
            X_PF, before = poses.value(FrameId(value)), self._poses.get(value)
            V_PF = None
            if stamp and before is not None and before.stamp:
                seconds = (stamp - before.stamp) * _NANOSECONDS
                if seconds == 0.0:  # said twice
                    V_PF = before.V_PF
                elif 0.0 < seconds <= self._longest_gap:
                    V_PF = _twist(before.X_PF, X_PF, seconds)
            self._poses[value] = _Stamped(stamp, X_PF, V_PF)

    def note_twists(self, frames: NDArray[np.int64], twists: Floats, stamp: int) -> None:
        """Note the twists V_WF (n, 6) of frames (n,) with their stamp [ns]."""
        for value, twist in zip(frames.tolist(), twists, strict=True):
            self._told[value] = stamp, twist

    def in_world(self, query: QueryObject, static: Mapping[int, bool]) -> dict[FrameId, Floats]:
        """Return V_WF (6,) of the frames whose motion is known, at the poses of now.

        A frame that never had a stamped pose rests in its parent where ``static`` says so, or says
        nothing; where it says False, it is expected to move, and nobody knows how.
        """
        inspector = query.inspector()
        world = inspector.world_frame_id()
        found: dict[FrameId, Floats | None] = {world: np.zeros(6)}
        # A parent is registered before its children.
        for frame in inspector.GetAllFrameIds():
            if frame != world and query.is_placed(frame):
                parent = inspector.GetParentFrame(frame)
                found[frame] = self._of(frame, parent, found.get(parent), query, static)
        return {frame: V for frame, V in found.items() if V is not None}

    def _of(
        self,
        frame: FrameId,
        parent: FrameId,
        V_WP: Floats | None,
        query: QueryObject,
        static: Mapping[int, bool],
    ) -> Floats | None:
        """Return the twist of one frame, or None."""
        value = frame.get_value()
        pose, told = self._poses.get(value), self._told.get(value)
        if told is not None and (pose is None or told[0] >= pose.stamp > 0):
            return told[1]
        V_PF = np.zeros(6) if pose is None and static.get(value, True) else None
        if pose is not None:
            V_PF = pose.V_PF
        if V_WP is None or V_PF is None:
            return None
        if parent == query.inspector().world_frame_id():
            return V_PF
        X_WP = query.X_WF(parent)
        R_WP, p_PF_W = (
            X_WP.rotation().matrix(),
            query.X_WF(frame).translation() - X_WP.translation(),
        )
        carried = np.concatenate((V_WP[:3], V_WP[3:] + np.cross(V_WP[:3], p_PF_W)))
        return carried + np.concatenate((R_WP @ V_PF[:3], R_WP @ V_PF[3:]))


def stamp_of(stamp: Any) -> int:
    """Return a builtin_interfaces/Time in nanoseconds."""
    return int(stamp.sec) * 10**9 + int(stamp.nanosec)


def _twist(before: RigidTransform, after: RigidTransform, seconds: float) -> Floats:
    """Return the mean spatial velocity [w, v] (6,) from one pose to the other, in the parent."""
    turn = (after.rotation() @ before.rotation().inverse()).ToAngleAxis()
    w = turn.angle() * turn.axis()
    return np.concatenate((w, after.translation() - before.translation())) / seconds
