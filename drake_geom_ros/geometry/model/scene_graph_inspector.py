"""``SceneGraphInspector``: the content of a scene, without poses of frames."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.filters.state import FilterState
from drake_geom_ros.geometry.checks import canonical_name, checked_type
from drake_geom_ros.geometry.errors import GeometryError, RoleError
from drake_geom_ros.geometry.hydroelastic.bodies import CompliantBody, RigidBody
from drake_geom_ros.geometry.ids import FrameId, GeometryId, SourceId, only_id
from drake_geom_ros.geometry.meshes.polygon_mesh import PolygonSurfaceMesh
from drake_geom_ros.geometry.meshes.surface_mesh import TriangleSurfaceMesh
from drake_geom_ros.geometry.meshes.volume_mesh import VolumeMesh
from drake_geom_ros.geometry.model._model import Model
from drake_geom_ros.geometry.model._records import FrameRecord, GeometryRecord, named
from drake_geom_ros.geometry.model.candidate_pairs import CandidatePairs
from drake_geom_ros.geometry.model.geometry_set import GeometrySet
from drake_geom_ros.geometry.model.geometry_version import GeometryVersion, version_of
from drake_geom_ros.geometry.model.instances import GeometryInstance
from drake_geom_ros.geometry.model.properties import (
    GeometryProperties,
    IllustrationProperties,
    PerceptionProperties,
    ProximityProperties,
    Role,
)
from drake_geom_ros.geometry.shapes.bounding_boxes import Obb
from drake_geom_ros.geometry.shapes.from_meshes import Convex, Mesh
from drake_geom_ros.geometry.shapes.measures import CalcObb
from drake_geom_ros.geometry.shapes.primitives import Shape
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.math.missing import refuse_missing_member


class SceneGraphInspector:
    """A live view of a scene's model, or of a context's copy of it.

    ``SceneGraph.model_inspector()`` and ``QueryObject.inspector()`` return it. Lists of ids are
    ascending. Every method raises RuntimeError for an unknown id. Where an id may be of several
    kinds there is a keyword for each kind, and ``id`` for any of them.
    """

    def __init__(self, model: Model, filters: FilterState) -> None:
        self._model = model
        self._filters = filters

    if not TYPE_CHECKING:  # mypy would take any method for one that is there
        __getattr__ = refuse_missing_member

    # Sources.

    def num_sources(self) -> int:
        """Return the number of sources, the scene's own included."""
        return len(self._model.sources)

    def GetAllSourceIds(self) -> list[SourceId]:
        """Return the ids of all sources, the scene's own included."""
        return sorted(self._model.sources)

    def SourceIsRegistered(
        self, source_id: SourceId | None = None, *, id: SourceId | None = None
    ) -> bool:
        """Return whether a source of that id exists."""
        return only_id('SourceIsRegistered', source_id, id) in self._model.sources

    def GetSourceName(
        self, source_id: SourceId | None = None, *, id: SourceId | None = None
    ) -> str:
        """Return the name of a source, by the older name of ``GetName``."""
        return self._model.source_name(only_id('GetSourceName', source_id, id))

    def NumFramesForSource(self, source_id: SourceId) -> int:
        """Return the number of frames of a source."""
        return len(self._model.frames_of_source(source_id))

    def FramesForSource(self, source_id: SourceId) -> set[FrameId]:
        """Return a source's frames."""
        return set(self._model.frames_of_source(source_id))

    def BelongsToSource(
        self,
        id: FrameId | GeometryId | None = None,
        source_id: SourceId | None = None,
        *,
        frame_id: FrameId | None = None,
        geometry_id: GeometryId | None = None,
    ) -> bool:
        """Return whether a frame or a geometry belongs to a source."""
        source: SourceId = only_id('BelongsToSource: source_id', source_id)
        self._model.source_name(source)
        only = only_id('BelongsToSource', id, frame_id, geometry_id)
        return self._record(only).source_id == source

    def GetOwningSourceId(
        self,
        id: FrameId | GeometryId | None = None,
        *,
        frame_id: FrameId | None = None,
        geometry_id: GeometryId | None = None,
    ) -> SourceId:
        """Return the source that a frame or a geometry belongs to."""
        return self._record(only_id('GetOwningSourceId', id, frame_id, geometry_id)).source_id

    def GetOwningSourceName(
        self,
        id: FrameId | GeometryId | None = None,
        *,
        frame_id: FrameId | None = None,
        geometry_id: GeometryId | None = None,
    ) -> str:
        """Return the name of the source that a frame or a geometry belongs to."""
        only = only_id('GetOwningSourceName', id, frame_id, geometry_id)
        return self._model.source_name(self._record(only).source_id)

    # Frames.

    def world_frame_id(self) -> FrameId:
        """Return the id of the world frame."""
        return self._model.world_frame_id

    def num_frames(self) -> int:
        """Return the number of frames, the world included."""
        return len(self._model.frames)

    def GetAllFrameIds(self) -> list[FrameId]:
        """Return the ids of all frames, the world included."""
        return sorted(self._model.frames)

    def FramesParentsFirst(self) -> list[FrameId]:
        """Return the ids of all frames, parents before children, the world first."""
        return list(self._model.frames)

    def all_frame_ids(self) -> list[FrameId]:
        """Return ``GetAllFrameIds()``, by the older name."""
        return self.GetAllFrameIds()

    def GetParentFrame(self, frame_id: FrameId) -> FrameId:
        """Return the parent of a frame; the world is its own.

        The frame was registered on its parent, or is attached to it: see ``GetHomeFrame``.
        """
        return self._model.frame(frame_id).parent_id

    def GetHomeFrame(self, frame_id: FrameId) -> FrameId:
        """Return the parent that a frame was registered on, also while it is attached."""
        frame = self._model.frame(frame_id)
        return frame.parent_id if frame.home_id is None else frame.home_id

    def IsAttached(self, frame_id: FrameId) -> bool:
        """Return whether a frame is attached to another one, see ``SceneGraph.AttachFrame``."""
        return self._model.frame(frame_id).home_id is not None

    def IsPartOfParent(self, frame_id: FrameId) -> bool:
        """Return whether a frame is attached and counts as part of its parent."""
        return self._model.frame(frame_id).is_part

    def GetFrameGroup(self, frame_id: FrameId) -> int:
        """Return the group number of a frame, -1 for the world."""
        return self._model.frame(frame_id).frame_group

    def NumGeometriesForFrame(self, frame_id: FrameId) -> int:
        """Return the number of geometries on a frame."""
        return len(self._model.frame(frame_id).geometry_ids)

    def NumGeometriesForFrameWithRole(self, frame_id: FrameId, role: Role) -> int:
        """Return the number of geometries with a role on a frame."""
        return len(self.GetGeometries(frame_id, role))

    def GetGeometries(self, frame_id: FrameId, role: Role | None = None) -> list[GeometryId]:
        """Return the geometries on a frame, or those with a ``role``."""
        return _with_role(self._model.geometries_on(frame_id), role)

    def GetGeometryIdByName(self, frame_id: FrameId, role: Role, name: str) -> GeometryId:
        """Return the geometry of that name and role on a frame; the name is trimmed first.

        Raises RuntimeError if there is none, or several, as there can be without any role.
        """
        frame = self._model.frame(frame_id)
        wanted = canonical_name(name, 'GetGeometryIdByName')
        records = [r for r in self._model.geometries_on(frame_id) if _has_role(r, role)]
        matches = [record.id for record in records if record.name == wanted]
        if len(matches) != 1:
            raise GeometryError(
                f"GetGeometryIdByName: the frame '{frame.name}' ({frame_id!r}) has {len(matches)} "
                f'geometries of the name {wanted!r} and the role {role.name}; the names with '
                f'this role are {sorted(record.name for record in records)}'
            )
        return matches[0]

    # Geometries.

    def num_geometries(self) -> int:
        """Return the number of geometries."""
        return len(self._model.geometries)

    def NumAnchoredGeometries(self) -> int:
        """Return the number of geometries on the world frame."""
        return self.NumGeometriesForFrame(self._model.world_frame_id)

    def NumDynamicGeometries(self) -> int:
        """Return the number of geometries on other frames than the world."""
        return self.num_geometries() - self.NumAnchoredGeometries()

    def NumGeometriesWithRole(self, role: Role) -> int:
        """Return the number of geometries with a role, for kUnassigned of those without any."""
        return len(self.GetAllGeometryIds(role))

    def GetAllGeometryIds(self, role: Role | None = None) -> list[GeometryId]:
        """Return the ids of all geometries, or of those with a ``role``."""
        return _with_role(self._model.geometries.values(), role)

    def GetGeometryIds(
        self, geometry_set: GeometrySet, role: Role | None = None
    ) -> set[GeometryId]:
        """Return the geometries that a GeometrySet resolves to, or those with a ``role``."""
        return set(self._model.resolve(geometry_set, role))

    def GetFrameId(self, geometry_id: GeometryId) -> FrameId:
        """Return the frame that a geometry is on."""
        return self._model.geometry(geometry_id).frame_id

    def GetShape(self, geometry_id: GeometryId) -> Shape:
        """Return the shape of a geometry."""
        return self._model.geometry(geometry_id).shape

    def GetConvexHull(self, geometry_id: GeometryId) -> PolygonSurfaceMesh | None:
        """Return the convex hull of a Mesh or Convex, in G; None for another shape."""
        shape = self._model.geometry(geometry_id).shape
        return shape.GetConvexHull() if isinstance(shape, (Mesh, Convex)) else None

    def maybe_get_hydroelastic_mesh(
        self, geometry_id: GeometryId
    ) -> VolumeMesh | TriangleSurfaceMesh | None:
        """Return the mesh of a geometry for contact surfaces, in G.

        It has tetrahedra if the geometry is compliant, and is a surface if rigid. None for a half
        space, and without hydroelastic properties.
        """
        body = self._model.geometry(geometry_id).hydroelastic_body
        return body.mesh if isinstance(body, (CompliantBody, RigidBody)) else None

    def maybe_get_hydroelastic_pressures(
        self, geometry_id: GeometryId
    ) -> NDArray[np.float64] | None:
        """Return the pressure (n,) [Pa] at the vertices of a compliant mesh, or None."""
        body = self._model.geometry(geometry_id).hydroelastic_body
        return body.pressures.copy() if isinstance(body, CompliantBody) else None

    def GetObbInGeometryFrame(self, geometry_id: GeometryId) -> Obb | None:
        """Return the oriented box around a geometry, in G; None for a half space."""
        return CalcObb(self._model.geometry(geometry_id).shape)

    def geometry_version(self) -> GeometryVersion:
        """Return the current version of the geometries."""
        return version_of(self._model.role_versions(self._filters.version))

    def GetPoseInFrame(self, geometry_id: GeometryId) -> RigidTransform:
        """Return X_FG, the pose of a geometry in its frame."""
        return RigidTransform(self._model.geometry(geometry_id).X_FG)

    def GetPoseInParent(self, geometry_id: GeometryId) -> RigidTransform:
        """Return X_PG, the pose of a geometry in the frame or geometry it was registered on."""
        return RigidTransform(self._model.geometry(geometry_id).X_PG)

    def GetProperties(self, geometry_id: GeometryId, role: Role) -> GeometryProperties | None:
        """Return the properties of a geometry in a role, read only, or None without the role."""
        checked_type(role, Role, 'GetProperties: role')
        return self._model.geometry(geometry_id).properties(role)

    def GetProximityProperties(self, geometry_id: GeometryId) -> ProximityProperties | None:
        """Return the properties of the proximity role, read only, or None."""
        return self._model.geometry(geometry_id).proximity

    def GetIllustrationProperties(self, geometry_id: GeometryId) -> IllustrationProperties | None:
        """Return the properties of the illustration role, read only, or None."""
        return self._model.geometry(geometry_id).illustration

    def GetPerceptionProperties(self, geometry_id: GeometryId) -> PerceptionProperties | None:
        """Return the properties of the perception role, read only, or None."""
        return self._model.geometry(geometry_id).perception

    def CloneGeometryInstance(self, geometry_id: GeometryId) -> GeometryInstance:
        """Return an instance with a new id and a geometry's X_FG, shape, name and roles."""
        record = self._model.geometry(geometry_id)
        instance = GeometryInstance(record.X_FG, record.shape, record.name)
        if record.proximity is not None:
            instance.set_proximity_properties(record.proximity)
        if record.illustration is not None:
            instance.set_illustration_properties(record.illustration)
        if record.perception is not None:
            instance.set_perception_properties(record.perception)
        return instance

    # Frames, geometries and sources alike.

    def GetName(
        self,
        id: SourceId | FrameId | GeometryId | None = None,
        *,
        source_id: SourceId | None = None,
        frame_id: FrameId | None = None,
        geometry_id: GeometryId | None = None,
    ) -> str:
        """Return the name of a source, a frame or a geometry."""
        only = only_id('GetName', id, source_id, frame_id, geometry_id)
        if isinstance(only, SourceId):
            return self._model.source_name(only)
        return self._record(only).name

    def GetNameByFrameId(self, frame_id: FrameId) -> str:
        """Return the name of a frame, by the older name of ``GetName``."""
        return self._model.frame(frame_id).name

    def GetNameByGeometryId(self, geometry_id: GeometryId) -> str:
        """Return the name of a geometry, by the older name of ``GetName``."""
        return self._model.geometry(geometry_id).name

    def full_name(self, id: SourceId | FrameId | GeometryId) -> str:
        """Return ``source``, ``source::frame`` or ``source::frame/geometry``; ``world`` alone.

        A geometry on the world is ``source::world/geometry``.
        """
        if isinstance(id, SourceId):
            return self._model.source_name(id)
        record = self._record(id)
        if record.id == self._model.world_frame_id:
            return record.name
        source = self._model.source_name(record.source_id)
        if isinstance(record, FrameRecord):
            return f'{source}::{record.name}'
        return f'{source}::{self._model.frame(record.frame_id).name}/{record.name}'

    def full_names(self, geometry_ids: Iterable[GeometryId | int] | NDArray[Any]) -> list[str]:
        """Return ``full_name`` of geometries by ids, or by id values as in arrays of results.

        The name for 0, which is no geometry, is empty.
        """
        ids = [id if isinstance(id, GeometryId) else GeometryId(id) for id in geometry_ids]
        names = {id: self.full_name(id) for id in set(ids) if id.is_valid()}
        return [names.get(id, '') for id in ids]

    # Collision filters.

    def CollisionFiltered(self, geometry_id1: GeometryId, geometry_id2: GeometryId) -> bool:
        """Return whether a pair is left out of pairwise queries for any reason.

        Raises RuntimeError unless both have the proximity role.
        """
        keys = []
        for geometry_id in (geometry_id1, geometry_id2):
            record = self._model.geometry(geometry_id)
            if record.proximity is None:
                raise RoleError(f'CollisionFiltered: {named(record)} has no proximity role')
            keys.append(geometry_id.get_value())
        return self._filters.filtered(*keys)

    def GetCollisionCandidates(self) -> set[tuple[GeometryId, GeometryId]]:
        """Return the pairs (A, B), A < B, that pairwise queries consider."""
        values, considered = self.candidate_matrix()
        ids = [GeometryId(value) for value in values.tolist()]
        rows, columns = np.nonzero(np.triu(considered))
        return {(ids[a], ids[b]) for a, b in zip(rows.tolist(), columns.tolist(), strict=True)}

    def candidate_matrix(self) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
        """Return the id values (n,), and GetCollisionCandidates as a symmetric matrix (n, n).

        The ids are those of all geometries with the proximity role, ascending.
        """
        candidates = self.candidate_pairs()
        return candidates.ids, candidates.matrix()

    def candidate_pairs(self) -> CandidatePairs:
        """Return GetCollisionCandidates of now as an object without a matrix, for large scenes."""
        return CandidatePairs.of_filters(self._filters)

    def _record(self, id: FrameId | GeometryId) -> FrameRecord | GeometryRecord:
        """Return the record of a frame or a geometry."""
        if isinstance(id, FrameId):
            return self._model.frame(id)
        # Plain numbers are refused where both kinds are allowed, since one may be of either.
        return self._model.geometry(checked_type(id, GeometryId, 'id'))


def _has_role(record: GeometryRecord, role: Role) -> bool:
    return record.has_role(checked_type(role, Role, 'role'))


def model_version(inspector: SceneGraphInspector) -> int:
    """Return the version number of an inspected model; filters do not change it."""
    return inspector._model.versions.any


def _with_role(records: Any, role: Role | None) -> list[GeometryId]:
    """Return the ids of the records with a role, or of all for None, ascending."""
    return sorted(record.id for record in records if role is None or _has_role(record, role))
