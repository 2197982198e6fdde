"""``SceneGraphContext_[AutoDiffXd]``: a context whose poses have derivatives."""

from __future__ import annotations

from typing import Any

import numpy as np

from drake_geom_ros.autodiffutils import AutoDiffXd
from drake_geom_ros.geometry._proximity.world.world import World
from drake_geom_ros.geometry.autodiff.poses import FramePoseVectorAutoDiffXd
from drake_geom_ros.geometry.errors import PoseError
from drake_geom_ros.geometry.ids import FrameId, SourceId
from drake_geom_ros.geometry.model.frame_pose_vector import FramePoseVector
from drake_geom_ros.geometry.model.scene_graph_inspector import SceneGraphInspector
from drake_geom_ros.geometry.queries.context import SceneGraphContext
from drake_geom_ros.geometry.queries.context_state import ContextState
from drake_geom_ros.math.array_types import Floats

Poses = FramePoseVector | FramePoseVectorAutoDiffXd


class ContextStateAutoDiffXd(ContextState):
    """State of a context with derivatives: also the velocity of each pose for each variable."""

    _velocities: dict[int, Floats] | None = None  # V_PF (6, n) by the frame's id value
    number: Any = AutoDiffXd  # the type of the poses' numbers

    def pose_source(self, source_id: SourceId, poses: Poses) -> None:
        """Set the poses of all frames of a source, as a context of floats does."""
        values, velocities = _taken_apart(poses)
        super().pose_source(source_id, values)
        self._take(poses, values, velocities)

    def pose_frames(self, poses: Poses) -> None:
        """Set the poses of the frames in ``poses``; those of floats are constants."""
        values, velocities = _taken_apart(poses)
        super().pose_frames(values)
        self._take(poses, values, velocities)

    def _take(self, poses: Poses, values: FramePoseVector, velocities: dict[int, Floats]) -> None:
        frames = values.id_values().tolist()
        others = {id: V for id, V in (self._velocities or {}).items() if id not in frames}
        self._velocities = {**others, **velocities}
        if isinstance(poses, FramePoseVectorAutoDiffXd):
            self.number = poses.scalar()

    def velocity_in_parent(self, id: FrameId) -> Floats:
        """Return V_PF (6, n) of a frame for the n variables; (6, 0) of a constant pose."""
        return (self._velocities or {}).get(id.get_value(), np.zeros((6, 0)))

    def spatial_velocities(self, world: World) -> Floats:
        """Return V_WF (nf, 6, n) of all frames, each by its row, for the n variables.

        Raises PoseError if poses depend on different variables.
        """
        by_id = self._velocities or {}
        sizes = {V.shape[1] for V in by_id.values()} - {0}
        if len(sizes) > 1:
            raise PoseError(
                f'Poses of frames have derivatives by {sorted(sizes)} variables; all must be by '
                'the same ones, see InitializeAutoDiffTuple.'
            )
        count = len(world.frames.ids)
        V_WFs = np.zeros((count, 6, sizes.pop() if sizes else 0))
        for row in range(1, count):
            parent = int(world.frames.parents[row])
            w_WP, p_PF_W = V_WFs[parent, :3], world.p_WFs[row] - world.p_WFs[parent]
            V_WFs[row] = V_WFs[parent]
            V_WFs[row, 3:] += np.cross(w_WP, p_PF_W[:, None], axis=0)
            V_PF = by_id.get(int(world.frames.ids[row]))
            if V_PF is not None and V_PF.shape[1]:
                R_WP = world.R_WFs[parent]
                V_WFs[row] += np.concatenate((R_WP @ V_PF[:3], R_WP @ V_PF[3:]))
        return V_WFs


class SceneGraphContextAutoDiffXd(SceneGraphContext):
    """A context of ``SceneGraph_[AutoDiffXd]``: poses with derivatives by each variable."""

    scalar = 'AutoDiffXd'
    _state: ContextStateAutoDiffXd
    _state_type = ContextStateAutoDiffXd

    def SetFramePoses(self, source_id: SourceId, poses: Poses) -> None:
        """Set the poses of all frames of a source, as SceneGraphContext does."""
        self._state.pose_source(source_id, poses)

    def UpdateFramePoses(self, poses: Poses) -> None:
        """Set the poses of the frames in ``poses``; those of floats are constants."""
        self._state.pose_frames(poses)


def state_of(context: SceneGraphContextAutoDiffXd) -> ContextStateAutoDiffXd:
    """Return the state of a context, for its query objects."""
    return context._state


def _taken_apart(poses: Poses) -> tuple[FramePoseVector, dict[int, Floats]]:
    if isinstance(poses, FramePoseVectorAutoDiffXd):
        return poses.taken_apart()
    return poses, {}


class SceneGraphInspectorAutoDiffXd(SceneGraphInspector):
    """The inspector of a ``SceneGraph_[AutoDiffXd]``; its values have no derivatives."""
