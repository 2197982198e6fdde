"""Scene of this process for a page, whose threads pose, query and filter it."""

from __future__ import annotations

import threading
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.common.frame_names import Frame
from drake_geom_ros.geometry import (
    CollisionFilterDeclaration,
    FilterId,
    FilterOperation,
    FrameId,
    FramePoseVector,
    GeometryId,
    GeometrySet,
    QueryObject,
    SceneGraph,
    SceneGraphContext,
)
from drake_geom_ros.geometry.queries.fixed_geometries import FixedGeometries
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files import poses_in_parents
from drake_geom_ros.viewing.bodies import ShownBody
from drake_geom_ros.viewing.looks import LAYERS, geometry_name, looks_of
from drake_geom_ros.viewing.shown_contacts import ShownContacts, contacts_of
from drake_geom_ros.viewing.shown_pairs import ReportedPairs
from drake_geom_ros.viewing.shown_scene import ShownGeometries, ShownMoment


@dataclass(frozen=True)
class Declared:
    """A transient declaration of the page; its ``filter_id`` is None while it is switched off."""

    text: str
    declaration: CollisionFilterDeclaration
    filter_id: FilterId | None


class LocalScene:
    """Scene for a page, of a scene graph and a context that shares its model."""

    def __init__(self, scene_graph: SceneGraph, context: SceneGraphContext) -> None:
        """Show ``context``, which must share its model, so that filters change its results."""
        self._lock = threading.RLock()
        self._scene_graph, self._context = scene_graph, context
        self._filters = scene_graph.collision_filter_manager()
        self._query = QueryObject(context)
        self._changes = 0
        self._history: list[Declared] = []
        inspector = scene_graph.model_inspector()
        self._inspector = inspector
        geometries = inspector.GetAllGeometryIds()
        frames = np.array([f.get_value() for f in inspector.GetAllFrameIds()], dtype=np.int64)
        self._frame_ids = frames
        self._fixed = FixedGeometries(inspector)
        self._looks = looks_of(inspector)
        self._names = {g.get_value(): geometry_name(inspector, g) for g in geometries}
        self.frames: Mapping[Frame, FrameId] = {
            (inspector.GetOwningSourceName(f), inspector.GetName(f)): f
            for f in inspector.GetAllFrameIds()
            if f != inspector.world_frame_id()
        }
        self._geometries: ShownGeometries | None = None

    # Implementation of ShownScene.

    def version(self) -> object:
        """Return a number that grows with every change."""
        return self._changes

    def moment(self, max_distance: float, accuracy: str, *, contacts: bool = False) -> ShownMoment:
        """Return current poses, the pairs up to a distance [m], and contact surfaces."""
        shown = ShownContacts.none()
        with self._lock:
            R_WFs, p_WFs, is_posed = self._context.X_WFs(self._frame_ids)
            results = self._query.ComputeSignedDistancePairwiseClosestPoints(
                max_distance, accuracy=accuracy
            )
            R_WGs, p_WGs, placed = self._fixed.X_WGs(self._context)
            geometries = self._shown_geometries(placed)
            if contacts:
                shown = contacts_of(self._query, self._names.__getitem__)
        return ShownMoment(
            *(geometries, R_WGs, p_WGs, ReportedPairs.of(results)),
            *(R_WFs[is_posed], p_WFs[is_posed]),
            remarks=[*shown.remarks, *shown.missing],
            patches=shown.patches,
        )

    def explain(self, pair: tuple[int, int]) -> list[str]:
        """Return why a pair is not reported; RuntimeError without the proximity role."""
        with self._lock:
            return self._filters.explain(*map(GeometryId, pair))

    def body(self, value: int) -> ShownBody | None:
        """Return a geometry by its id value; None if there is none."""
        if value not in self._names:
            return None
        id, inspector = GeometryId(value), self._inspector
        properties = {role: inspector.GetProperties(id, role) for role in LAYERS}
        return ShownBody(
            value,
            self._names[value],
            inspector.GetOwningSourceName(id),
            inspector.GetName(inspector.GetFrameId(id)),
            inspector.GetShape(id),
            {role: each for role, each in properties.items() if each is not None},
        )

    def _shown_geometries(self, placed: NDArray[np.bool_]) -> ShownGeometries:
        ids = self._fixed.ids[placed]
        if self._geometries is None or not np.array_equal(self._geometries.ids, ids):
            shown = set(ids.tolist())
            looks = [look for look in self._looks if look.geometry.get_value() in shown]
            waiting = [self._inspector.GetName(f) for f in self._query.waiting_frames()]
            self._geometries = ShownGeometries(ids, looks, self._names, waiting)
        return self._geometries

    # Poses.

    def pose(self, X_PFs: FramePoseVector) -> None:
        """Pose frames; raises PoseError for one that does not exist."""
        with self._lock:
            self._context.UpdateFramePoses(X_PFs)
            self._changes += 1

    def pose_only(self, X_PFs: FramePoseVector) -> None:
        """Pose frames, and leave all others without a pose; raises PoseError like ``pose``."""
        with self._lock:
            named = set(X_PFs.ids())
            if not named.issuperset(poses_in_parents(self._query)):
                self._context = self._scene_graph.CreateSharedContext(partial=True)
                self._query = QueryObject(self._context)
            self.pose(X_PFs)

    def X_WF(self, frame: Frame) -> RigidTransform:
        """Return the pose of a frame by source and name; PoseError if it has none."""
        with self._lock:
            return self._query.X_WF(self.frames[frame])

    def place(self, frame: Frame, X_WF: RigidTransform) -> None:
        """Pose a frame by source and name in the world; PoseError if its parent has no pose."""
        with self._lock:
            id = self.frames[frame]
            X_WP = self._query.X_WF(self._inspector.GetParentFrame(id))
            self.pose(FramePoseVector({id: X_WP.inverse() @ X_WF}))

    def poses(self) -> dict[Frame, RigidTransform]:
        """Return X_PF of the frames that have a pose, by source and name."""
        with self._lock:
            X_PFs = poses_in_parents(self._query)
        return {frame: X_PFs[id] for frame, id in self.frames.items() if id in X_PFs}

    def snapshot(self) -> SceneGraphContext:
        """Return a copy that another thread may pose and query."""
        with self._lock:
            return self._context.what_if()

    # Transient filters. Later ones override earlier ones, so a filter that is switched on again
    # must return to its place: later ones are removed first, and made again in their order.

    def history(self) -> list[Declared]:
        """Return the page's declarations, in the order in which they apply."""
        with self._lock:
            return list(self._history)

    def exclude(self, pair: tuple[int, int]) -> None:
        """Add a declaration that excludes a pair of geometries, by id values."""
        self._declare('exclude', pair, FilterOperation.EXCLUDE_BETWEEN)

    def allow(self, pair: tuple[int, int]) -> None:
        """Add a declaration that allows a pair of geometries, by id values."""
        self._declare('allow', pair, FilterOperation.ALLOW_BETWEEN)

    def _declare(self, word: str, pair: tuple[int, int], operation: FilterOperation) -> None:
        sets = [GeometrySet(GeometryId(value)) for value in pair]
        declaration = CollisionFilterDeclaration().Declare(operation, *sets)
        text = f'{word} {" | ".join(self._names[value] for value in pair)}'
        with self._lock:
            filter_id = self._filters.ApplyTransient(declaration)
            self._history.append(Declared(text, declaration, filter_id))
            self._changes += 1

    def switch(self, index: int, *, on: bool) -> None:
        """Switch one of the declarations of ``history()`` on or off."""
        with self._lock:
            wanted = [each.filter_id is not None for each in self._history]
            wanted[index] = on
            for k in range(index, len(self._history)):
                each = self._history[k]
                if each.filter_id is not None:
                    self._filters.RemoveDeclaration(each.filter_id)
                again = self._filters.ApplyTransient(each.declaration) if wanted[k] else None
                self._history[k] = replace(each, filter_id=again)
            self._changes += 1
