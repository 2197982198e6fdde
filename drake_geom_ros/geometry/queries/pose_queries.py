"""Queries for poses of frames and geometries, and for frames that have never received a pose."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from drake_geom_ros.geometry.errors import RoleError
from drake_geom_ros.geometry.ids import FrameId, GeometryId, only_id
from drake_geom_ros.geometry.model.scene_graph_inspector import SceneGraphInspector
from drake_geom_ros.geometry.queries.context_state import ContextState
from drake_geom_ros.geometry.shapes.bounding_boxes import Obb
from drake_geom_ros.math import RigidTransform, RotationMatrix


class PoseQueries:
    """Base of ``QueryObject`` with the queries for poses."""

    _state: ContextState

    def inspector(self) -> SceneGraphInspector:
        """Return the inspector of this context's model."""
        return SceneGraphInspector(self._state.model, self._state.filters)

    def GetPoseInWorld(
        self,
        id: FrameId | GeometryId | None = None,
        *,
        frame_id: FrameId | None = None,
        geometry_id: GeometryId | None = None,
    ) -> RigidTransform:
        """Return X_WF of a frame or X_WG of a geometry; raises for an unknown id."""
        only = only_id('GetPoseInWorld', id, frame_id, geometry_id)
        return self.X_WG(only) if isinstance(only, GeometryId) else self.X_WF(only)

    def GetPoseInParent(self, frame_id: FrameId) -> RigidTransform:
        """Return X_PF, the pose of a frame in its parent; raises for an unknown id."""
        return self.X_PF(frame_id)

    def X_WF(self, id: FrameId) -> RigidTransform:
        """Return the pose of a frame in the world; raises for an unknown id."""
        world, row = self._state.placed_frame(id)
        world.update()
        return _transform(world.R_WFs[row], world.p_WFs[row])

    def X_WFs(
        self, ids: ArrayLike
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.bool_]]:
        """Return the poses of many frames as arrays, see ``SceneGraphContext.X_WFs``."""
        return self._state.X_WFs(ids)

    def X_PF(self, id: FrameId) -> RigidTransform:
        """Return the pose of a frame in its parent; raises for an unknown id."""
        world, row = self._state.placed_frame(id, in_world=False)
        return _transform(world.R_PFs[row], world.p_PFs[row])

    def X_WG(self, id: GeometryId) -> RigidTransform:
        """Return the pose of a geometry in the world; raises for an unknown id."""
        record = self._state.model.geometry(id)
        return self.X_WF(record.frame_id) @ record.X_FG

    def ComputeObbInWorld(self, geometry_id: GeometryId) -> Obb | None:
        """Return the oriented box around a geometry, in World; None for a half space."""
        obb = self.inspector().GetObbInGeometryFrame(geometry_id)
        return obb and Obb(self.X_WG(geometry_id) @ obb.pose(), obb.half_width())

    # Frames without a first pose. As long as there are any, partial contexts leave out the
    # geometry on them, and other contexts refuse all queries.

    def waiting_frames(self) -> list[FrameId]:
        """Return the frames that have never received a pose, parents first."""
        return list(self._state.waiting_frames())

    def is_placed(self, id: FrameId | GeometryId) -> bool:
        """Return whether a frame, or that of a geometry, and all its parents have a pose."""
        model, world = self._state.model, self._state.up_to_date_world()
        frame = model.geometry(id).frame_id if isinstance(id, GeometryId) else model.frame(id).id
        return bool(world.placed[world.frame_rows(np.array([frame.get_value()]))[0]])

    def num_waiting_pairs(self) -> int:
        """Return the number of unfiltered pairs, at any distance, with a geometry not placed."""
        return self._state.count_waiting_pairs()

    def num_waiting_geometries(self) -> int:
        """Return the number of geometries with the proximity role that are not placed."""
        return int(np.count_nonzero(self._state.up_to_date_world().waiting))

    def X_WGs(self, ids: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return R_WG (k, 3, 3) and p_WG (k, 3) [m] of geometries by the values (k,) of their ids.

        A call of ``X_WG`` costs a hundred times as much per geometry. Raises RoleError for ids of
        geometries without the proximity role.
        """
        world = self._state.up_to_date_world()
        world.update()
        values, all_ids = np.asarray(ids, dtype=np.int64), world.geometries.ids
        rows = world.geometry_rows(values)
        is_known = rows < len(all_ids)
        is_known[is_known] = all_ids[rows[is_known]] == values[is_known]
        if not is_known.all():
            unknown = sorted(set(values[~is_known].tolist()))[:5]
            raise RoleError(f'these ids belong to no geometry with the proximity role: {unknown}')
        return world.R_WGs[rows], world.p_WGs[rows]


def _transform(R: NDArray[np.float64], p: NDArray[np.float64]) -> RigidTransform:
    return RigidTransform(RotationMatrix(R.copy()), p.copy())
