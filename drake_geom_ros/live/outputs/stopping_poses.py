"""Publishes ~/stopping_poses, where robots would be while they stop, while somebody looks."""

from __future__ import annotations

import numpy as np

from drake_geom_ros.geometry import FramePoseVector
from drake_geom_ros.geometry.queries.fixed_geometries import FixedGeometries
from drake_geom_ros.live.outputs.geometry_poses import PosesTopic
from drake_geom_ros.live.scene.scene_view import SceneView
from drake_geom_ros.math.array_types import Floats, Indices
from drake_geom_ros.math.batched import poses_from_matrices


class StoppingPoses(PosesTopic):
    """Publishes the poses of what moves, at several places of each stop from the present speed."""

    _had_any = False

    def _poses(self) -> tuple[SceneView, Indices, Floats] | None:
        """Return the poses; when all stand, once that there is nothing."""
        with self._live.reading() as scene:
            frames, ways = scene.stopping.ways()
            if not (any(map(len, ways)) or self._had_any):
                return None
            view = scene.view()
        ids, poses = _moved(view, frames, ways)
        self._had_any = bool(len(ids))
        return view, ids, poses


def _moved(view: SceneView, frames: Indices, ways: list[Floats]) -> tuple[Indices, Floats]:
    """Return ids (k,) and X_WG (k, 7) of the geometries that are elsewhere at places of ways."""
    fixed = FixedGeometries(view.query.inspector())
    *now, placed = fixed.X_WGs(view.context)
    ids, poses = fixed.ids[placed], poses_from_matrices(*now)
    each_ids, each_poses = [ids[:0]], [poses[:0]]
    for way in ways:
        for X_PFs in way:
            view.context.UpdateFramePoses(FramePoseVector.FromArrays(frames, X_PFs))
            *there, still_placed = fixed.X_WGs(view.context)
            X_WGs = poses_from_matrices(*there)
            moved = (X_WGs != poses).any(axis=1) if np.array_equal(placed, still_placed) else []
            each_ids.append(ids[moved])
            each_poses.append(X_WGs[moved])
    return np.concatenate(each_ids), np.concatenate(each_poses)
