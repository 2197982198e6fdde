"""Poses X_FG of all geometries in their frames, and their poses in the world."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry.model.scene_graph_inspector import SceneGraphInspector
from drake_geom_ros.geometry.queries.context import SceneGraphContext
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.math.batched import compose


class FixedGeometries:
    """X_FG of the geometries of one version of a scene, of any role, by ascending id.

    ``ids`` (n,) and ``frames`` (n,) are the values of their ids and of their frames'.
    """

    def __init__(self, inspector: SceneGraphInspector) -> None:
        ids = inspector.GetAllGeometryIds()
        X_FGs = [inspector.GetPoseInFrame(id) for id in ids]
        frames = [inspector.GetFrameId(id).get_value() for id in ids]
        self.ids = np.array([id.get_value() for id in ids], dtype=np.int64)
        self.frames = np.array(frames, dtype=np.int64)
        self._R_FGs = np.array([X.rotation().matrix() for X in X_FGs]).reshape(-1, 3, 3)
        self._p_FGs = np.array([X.translation() for X in X_FGs]).reshape(-1, 3)

    def X_WGs(self, context: SceneGraphContext) -> tuple[Floats, Floats, NDArray[np.bool_]]:
        """Return R_WG (k, 3, 3) and p_WG (k, 3) [m] of the k geometries that have a pose now.

        The third array (n,) is the mask of these.
        """
        R_WFs, p_WFs, placed = context.X_WFs(self.frames)
        of_frames = R_WFs[placed], p_WFs[placed]
        return *compose(*of_frames, self._R_FGs[placed], self._p_FGs[placed]), placed
