"""``Model``: sources, frames and geometries of a scene, and the rules of their registration.

Poses of frames are in ``SceneGraphContext``, filters in ``FilterState``. Every change checks all
its conditions first and then commits.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Collection, Iterable

from drake_geom_ros.geometry.checks import canonical_name, checked_pose, checked_type
from drake_geom_ros.geometry.errors import (
    ArgumentTypeError,
    DuplicateError,
    GeometryError,
    OwnershipError,
    RoleError,
    UnknownIdError,
)
from drake_geom_ros.geometry.ids import FrameId, GeometryId, SourceId, geometry_id_of
from drake_geom_ros.geometry.model._changed_geometries import ChangedGeometries
from drake_geom_ros.geometry.model._records import (
    INTERNAL_SOURCE_NAME,
    ROLE_FIELDS,
    ROLE_OF_PROPERTIES,
    WORLD_FRAME_GROUP,
    WORLD_FRAME_ID,
    WORLD_NAME,
    FrameRecord,
    GeometryRecord,
    Renderer,
    Versions,
    named,
    prepared,
)
from drake_geom_ros.geometry.model.contact_defaults import HeldConfig
from drake_geom_ros.geometry.model.geometry_set import GeometrySet, members_of
from drake_geom_ros.geometry.model.geometry_version import fresh_number
from drake_geom_ros.geometry.model.instances import GeometryFrame, GeometryInstance
from drake_geom_ros.geometry.model.properties import (
    GeometryProperties,
    ProximityProperties,
    Role,
    RoleAssign,
    frozen,
)
from drake_geom_ros.geometry.shapes.primitives import Shape
from drake_geom_ros.math import RigidTransform

_MAX_NAMES = 1024  # of the geometries that were removed last


class Model:
    """Sources, frames and geometries by id, with the names in use."""

    def __init__(self) -> None:
        internal = SourceId.get_new_id()
        id, group = WORLD_FRAME_ID, WORLD_FRAME_GROUP
        world = FrameRecord(id, WORLD_NAME, internal, id, group)
        self.world_frame_id = WORLD_FRAME_ID
        self.sources, self.frames = {internal: INTERNAL_SOURCE_NAME}, {WORLD_FRAME_ID: world}
        self.geometries: dict[GeometryId, GeometryRecord] = {}
        self.first_X_PFs: dict[FrameId, RigidTransform] = {}  # poses that contexts begin with
        self.renderers: dict[str, Renderer] = {}
        self.config = HeldConfig()  # immutable: a change replaces it
        self.versions = Versions()
        self._changed_geometries = ChangedGeometries()
        self.source_names = {INTERNAL_SOURCE_NAME}
        self.frame_names = {(internal, WORLD_NAME)}
        self.geometry_names: dict[tuple[FrameId, Role, str], GeometryId] = {}
        self._removed = RemovedNames()
        self.children: dict[GeometryId, list[GeometryId]] = {}  # registered on a geometry

    def copy(self) -> Model:
        """Return an independent copy."""
        other = Model.__new__(Model)
        other.world_frame_id = self.world_frame_id
        other.sources = dict(self.sources)
        other.frames = {
            id: dataclasses.replace(frame, geometry_ids=dict(frame.geometry_ids))
            for id, frame in self.frames.items()
        }
        other.geometries = dict(self.geometries)
        other.first_X_PFs, other.config = dict(self.first_X_PFs), self.config
        other.renderers = dict(self.renderers)
        other.versions = self.versions.copy()
        other._changed_geometries = self._changed_geometries.copy()
        other.source_names = set(self.source_names)
        other.frame_names = set(self.frame_names)
        other.geometry_names = dict(self.geometry_names)
        other._removed = self._removed.copy()
        other.children = {parent: list(children) for parent, children in self.children.items()}
        return other

    # Look-ups: each raises RuntimeError for an id of the wrong kind or an unknown one.

    def source_name(self, source_id: SourceId) -> str:
        """Return the name of a source."""
        if checked_type(source_id, SourceId, 'source_id') not in self.sources:
            raise UnknownIdError(f'{source_id!r} is not a source of this scene; {self._sources()}')
        return self.sources[source_id]

    def frame(self, frame_id: FrameId) -> FrameRecord:
        """Return a frame."""
        if checked_type(frame_id, FrameId, 'frame_id') not in self.frames:
            raise UnknownIdError(
                f'{frame_id!r} is not a frame of this scene, which has {len(self.frames)}; '
                'see SceneGraphInspector.GetAllFrameIds'
            )
        return self.frames[frame_id]

    def geometry(self, geometry_id: GeometryId) -> GeometryRecord:
        """Return a geometry by its id, or by the value of that, as in arrays of results."""
        geometry_id = geometry_id_of(geometry_id)
        if geometry_id not in self.geometries:
            raise UnknownIdError(
                f'Referenced geometry {geometry_id!r} is not a geometry of this scene, which has '
                f'{len(self.geometries)}; see SceneGraphInspector.GetAllGeometryIds. '
                f'{self._removed.sentence_on(geometry_id)}'
            )
        return self.geometries[geometry_id]

    def owned_frame(self, source_id: SourceId, frame_id: FrameId) -> FrameRecord:
        """Return a frame of a source."""
        self.source_name(source_id)
        frame = self.frame(frame_id)
        self._check_owner(source_id, frame)
        return frame

    def owned_geometry(self, source_id: SourceId, geometry_id: GeometryId) -> GeometryRecord:
        """Return a geometry of a source."""
        self.source_name(source_id)
        geometry = self.geometry(geometry_id)
        self._check_owner(source_id, geometry)
        return geometry

    def frames_of_source(self, source_id: SourceId) -> list[FrameId]:
        """Return the frames of a source in the order of their registration."""
        self.source_name(source_id)
        return [frame.id for frame in self.frames.values() if frame.source_id == source_id]

    def geometries_on(self, frame_id: FrameId) -> list[GeometryRecord]:
        """Return the geometries on a frame in the order of their registration."""
        return [self.geometries[id] for id in self.frame(frame_id).geometry_ids]

    def resolve(self, geometry_set: GeometrySet, role: Role | None = None) -> list[GeometryId]:
        """Return the geometries of a set, those on its frames included, ascending.

        ``role`` selects those with that role. Raises UnknownIdError for an unknown id.
        """
        checked_type(geometry_set, GeometrySet, 'geometry_set')
        return self.resolve_members(*members_of(geometry_set), role)

    def resolve_members(
        self,
        geometry_ids: Iterable[GeometryId],
        frame_ids: Iterable[FrameId],
        role: Role | None = None,
    ) -> list[GeometryId]:
        """Return geometries, and those on frames, as ``resolve`` does."""
        records = [self.geometry(id) for id in geometry_ids]
        for frame_id in frame_ids:
            records += self.geometries_on(frame_id)
        return sorted({r.id for r in records if role is None or r.has_role(role)})

    # Registration.

    def register_source(self, name: str) -> SourceId:
        """Add a source; without a name it becomes ``Source_<id>``."""
        source_id = SourceId.get_new_id()
        default = f'Source_{source_id.get_value()}'
        new_name = canonical_name(name or default, 'RegisterSource')
        if new_name in self.source_names:
            raise DuplicateError(
                f'RegisterSource: the name {new_name!r} is taken; {self._sources()}'
            )
        self.sources[source_id] = new_name
        self.source_names.add(new_name)
        self.changed()
        return source_id

    def register_frame(
        self, source_id: SourceId, frame: GeometryFrame, parent_id: FrameId
    ) -> FrameId:
        """Add a frame to the world or to a frame of the same source."""
        source = self.source_name(source_id)
        checked_type(frame, GeometryFrame, 'RegisterFrame: frame')
        if checked_type(parent_id, FrameId, 'RegisterFrame: parent_id') != WORLD_FRAME_ID:
            self.owned_frame(source_id, parent_id)
        if frame.id() in self.frames:
            raise DuplicateError(
                f"RegisterFrame: {frame.id()!r} '{frame.name()}' is registered already"
            )
        self._check_frame_name(source_id, frame.name(), f'RegisterFrame for source {source!r}')
        self.frames[frame.id()] = FrameRecord(
            frame.id(), frame.name(), source_id, parent_id, frame.frame_group()
        )
        self.frame_names.add((source_id, frame.name()))
        self.changed(frames=True)
        return frame.id()

    def register_geometry(
        self, source_id: SourceId, parent_id: FrameId | GeometryId, instance: GeometryInstance
    ) -> GeometryRecord:
        """Add a geometry to the world, or to a frame or a geometry of the same source."""
        self.source_name(source_id)
        checked_type(instance, GeometryInstance, 'RegisterGeometry: geometry')
        if isinstance(parent_id, GeometryId):
            parent = self.owned_geometry(source_id, parent_id)
            frame_id, X_FG = parent.frame_id, parent.X_FG @ instance.pose()
        else:
            frame_id, X_FG = parent_id, instance.pose()
            if checked_type(frame_id, FrameId, 'RegisterGeometry: frame_id') != WORLD_FRAME_ID:
                self.owned_frame(source_id, frame_id)
        if instance.id() in self.geometries:
            raise DuplicateError(
                f"RegisterGeometry: {instance.id()!r} '{instance.name()}' is registered already"
            )
        proximity = instance.proximity_properties()
        illustration = instance.illustration_properties()
        perception = instance.perception_properties()
        record = GeometryRecord(
            id=instance.id(),
            name=instance.name(),
            source_id=source_id,
            frame_id=frame_id,
            parent_id=parent_id if isinstance(parent_id, GeometryId) else None,
            X_PG=instance.pose(),
            X_FG=X_FG,
            shape=instance.shape(),
            proximity=proximity and frozen(self.config.filled(proximity)),
            illustration=illustration and frozen(illustration),
            perception=perception and frozen(perception),
        )
        self._check_geometry_name(record, record.name, record.roles(), 'RegisterGeometry')
        record = prepared(record)
        self.frames[frame_id].geometry_ids[record.id] = None
        if record.parent_id is not None:
            self.children.setdefault(record.parent_id, []).append(record.id)
        self._store(record)
        return record

    def remove_geometry(
        self, source_id: SourceId, geometry_id: GeometryId
    ) -> list[GeometryRecord]:
        """Remove a geometry and all that was registered on it; return the removed ones."""
        removed = [self.owned_geometry(source_id, geometry_id)]
        for parent in removed:
            removed += [self.geometries[id] for id in self.children.get(parent.id, [])]
        if removed[0].parent_id is not None:
            self.children[removed[0].parent_id].remove(geometry_id)
        for record in removed:
            self.children.pop(record.id, None)
            for role in record.roles():
                del self.geometry_names[record.frame_id, role, record.name]
            del self.frames[record.frame_id].geometry_ids[record.id]
            del self.geometries[record.id]
        self._removed.add(removed)
        self.changed_geometries(removed, {role for r in removed for role in r.roles()})
        return removed

    # Changes.

    def assign_role(
        self,
        source_id: SourceId,
        geometry_id: GeometryId,
        properties: GeometryProperties,
        assign: RoleAssign,
    ) -> GeometryRecord:
        """Assign a role to a geometry, or replace the properties of one that it has."""
        record = self.owned_geometry(source_id, geometry_id)
        role = ROLE_OF_PROPERTIES.get(type(properties))
        if role is None:
            raise ArgumentTypeError(f'AssignRole: {properties!r} are not the properties of a role')
        checked_type(assign, RoleAssign, 'AssignRole: assign')
        if record.has_role(role) != (assign is RoleAssign.kReplace):
            raise RoleError(
                f'AssignRole: {named(record)} has the roles '
                f'{[r.name for r in record.roles()]}; {role.name} can be given anew with '
                'RoleAssign.kNew only if it is not there, with kReplace only if it is'
            )
        if assign is RoleAssign.kNew:
            self._check_geometry_name(record, record.name, [role], 'AssignRole')
        record = record.changed(**{ROLE_FIELDS[role]: frozen(self.config.filled(properties))})
        if role is Role.kProximity:
            record = prepared(record)
        self._store(record, roles=[role], names=assign is RoleAssign.kNew)
        return record

    def give_proximity(
        self, geometry_id: GeometryId, properties: ProximityProperties
    ) -> GeometryRecord:
        """Give a geometry the proximity role in a copy for queries, whatever its name is.

        Raises GeometryError if queries cannot support it.
        """
        record = prepared(self.geometry(geometry_id).changed(proximity=frozen(properties)))
        self._store(record, roles=[Role.kProximity])
        return record

    def remove_role(
        self, source_id: SourceId, of: FrameId | GeometryId, role: Role
    ) -> list[GeometryRecord]:
        """Remove a role of a geometry, or of a source's geometries on a frame; return these."""
        if isinstance(of, GeometryId):
            records = [self.owned_geometry(source_id, of)]
        else:
            self.source_name(source_id)
            if of != WORLD_FRAME_ID:
                self.owned_frame(source_id, of)
            records = [r for r in self.geometries_on(of) if r.source_id == source_id]
        losing = [record for record in records if record.properties(role) is not None]
        for record in losing:  # none for kUnassigned
            changed: dict[str, None] = {ROLE_FIELDS[role]: None}
            del self.geometry_names[record.frame_id, role, record.name]
            self.geometries[record.id] = record.changed(**changed)
        if losing:
            self.changed_geometries(losing, [role])
        return losing

    def change_shape(
        self,
        source_id: SourceId,
        geometry_id: GeometryId,
        shape: Shape,
        X_FG: RigidTransform | None,
    ) -> None:
        """Replace the shape of a geometry, and optionally its pose in the frame."""
        record = self.owned_geometry(source_id, geometry_id)
        checked_type(shape, Shape, 'ChangeShape: shape')
        pose = record.X_FG if X_FG is None else checked_pose(X_FG, 'ChangeShape: X_FG')
        record = record.changed(shape=shape)
        record = prepared(record)
        self._store(record, names=False)
        if X_FG is not None:
            self._repose(self.geometries[geometry_id], pose)

    def rename_frame(self, frame_id: FrameId, name: str) -> None:
        """Rename a frame."""
        frame = self.frame(frame_id)
        new_name = canonical_name(name, 'RenameFrame')
        if frame_id == WORLD_FRAME_ID:
            raise GeometryError(f'RenameFrame to {name!r}: the world frame keeps its name')
        if new_name != frame.name:
            self._check_frame_name(frame.source_id, new_name, f"RenameFrame of '{frame.name}'")
            self.frame_names.remove((frame.source_id, frame.name))
            self.frame_names.add((frame.source_id, new_name))
            frame.name = new_name
            self.changed(frames=True)

    def rename_geometry(self, geometry_id: GeometryId, name: str) -> None:
        """Rename a geometry."""
        record = self.geometry(geometry_id)
        new_name = canonical_name(name, 'RenameGeometry')
        if new_name != record.name:
            self._check_geometry_name(record, new_name, record.roles(), 'RenameGeometry')
            for role in record.roles():
                del self.geometry_names[record.frame_id, role, record.name]
            self._store(record.changed(name=new_name), roles=())

    # Helpers.

    def _store(
        self, record: GeometryRecord, roles: Collection[Role] | None = None, names: bool = True
    ) -> None:
        """Store a record and its names; ``roles`` are those that change, None for all."""
        self.geometries[record.id] = record
        for role in record.roles():
            self.geometry_names[record.frame_id, role, record.name] = record.id
        self.changed_geometries([record], record.roles() if roles is None else roles, names=names)

    def _repose(self, record: GeometryRecord, X_FG: RigidTransform) -> None:
        """Move a geometry in its frame, with the geometries that were registered on it."""
        X_PG = X_FG
        if record.parent_id is not None:
            X_PG = self.geometries[record.parent_id].X_FG.InvertAndCompose(X_FG)
        self._store(record.changed(X_FG=X_FG, X_PG=X_PG), names=False)
        for child_id in self.children.get(record.id, []):
            self._repose(self.geometries[child_id], X_FG @ self.geometries[child_id].X_PG)

    def changed(self, frames: bool = False, reordered: bool = False, names: bool = True) -> None:
        """Count a change of frames; ``reordered`` unless all others keep place and parent.

        Not ``names``: a change of neither names nor the set of objects.
        """
        self.versions.any += 1
        if names:
            self.versions.names = self.versions.any
        self.versions.frames += frames
        self.versions.frame_order += reordered

    def changed_geometries(
        self,
        records: Iterable[GeometryRecord] | None,
        roles: Collection[Role],
        *,
        frames: bool = False,
        names: bool = True,
    ) -> None:
        """Count a change of geometries (None: any) in some roles; not ``names``: of shapes.

        ``frames``: frames were removed with them.
        """
        self.changed(frames=frames, reordered=frames, names=names)
        if Role.kProximity in roles:
            self.versions.proximity += 1
            ids = None if records is None else [record.id for record in records]
            self._changed_geometries.add(self.versions.proximity, ids)
        self.versions.roles.update((role, fresh_number()) for role in roles)

    def geometries_changed_since(self, version: int) -> set[GeometryId] | None:
        """Return the ids of the geometries that changed after a ``versions.proximity``.

        None: any of them may have.
        """
        return self._changed_geometries.between(version, self.versions.proximity)

    def role_versions(self, filters: int) -> dict[Role, int]:
        """Return the version number of each role, given the version of the filters."""
        if self.versions.filters != filters:
            self.versions.filters = filters
            self.versions.roles[Role.kProximity] = fresh_number()
        return self.versions.roles

    def _check_owner(self, source_id: SourceId, record: FrameRecord | GeometryRecord) -> None:
        """Raise OwnershipError if a frame or a geometry belongs to another source."""
        if record.source_id != source_id:
            raise OwnershipError(
                f"{named(record)} belongs to source '{self.sources[record.source_id]}' "
                f"({record.source_id!r}), not to '{self.sources[source_id]}' ({source_id!r})"
            )

    def _check_frame_name(self, source_id: SourceId, name: str, what: str) -> None:
        """Raise DuplicateError if a source has a frame of that name."""
        if (source_id, name) in self.frame_names:
            raise DuplicateError(f'{what}: the source has a frame of the name {name!r} already')

    def _check_geometry_name(
        self, record: GeometryRecord, name: str, roles: list[Role], what: str
    ) -> None:
        """Raise DuplicateError if the frame has a geometry of that name in any of the roles."""
        for role in roles:
            owner = self.geometry_names.get((record.frame_id, role, name))
            if owner is not None:
                raise DuplicateError(
                    f"{what}: the frame '{self.frames[record.frame_id].name}' has a geometry of "
                    f'the name {name!r} with the role {role.name} already: {owner!r}'
                )

    def _sources(self) -> str:
        """Return the names of the sources, for messages."""
        return f'there are {sorted(self.source_names)}'


class RemovedNames:
    """Names of the last removed geometries, by their ids."""

    def __init__(self, names: dict[GeometryId, str] | None = None) -> None:
        self._names = {} if names is None else names

    def copy(self) -> RemovedNames:
        """Return an independent copy."""
        return RemovedNames(dict(self._names))

    def add(self, records: Iterable[GeometryRecord]) -> None:
        """Record the names of geometries that are being removed."""
        self._names |= {record.id: record.name for record in records}
        while len(self._names) > _MAX_NAMES:
            del self._names[next(iter(self._names))]

    def sentence_on(self, id: GeometryId) -> str:
        """Return a sentence that says if a missing geometry was removed or never registered."""
        if id in self._names:
            return f"It was called '{self._names[id]}', and has been removed."
        return 'It has not been registered.'
