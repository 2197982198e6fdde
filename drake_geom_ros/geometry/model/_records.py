"""Records of a model: one per frame, one per geometry."""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Protocol

from drake_geom_ros.geometry.checks import as_number
from drake_geom_ros.geometry.errors import GeometryError
from drake_geom_ros.geometry.hydroelastic.bodies import HydroelasticBody, body_of
from drake_geom_ros.geometry.ids import FrameId, GeometryId, SourceId
from drake_geom_ros.geometry.model.contact_defaults import HeldConfig
from drake_geom_ros.geometry.model.geometry_version import fresh_marks
from drake_geom_ros.geometry.model.hydroelastic_properties import material_of
from drake_geom_ros.geometry.model.properties import (
    GeometryProperties,
    IllustrationProperties,
    PerceptionProperties,
    ProximityProperties,
    Role,
    frozen,
)
from drake_geom_ros.geometry.shapes.from_meshes import Mesh, warn_if_open
from drake_geom_ros.geometry.shapes.height_field import HeightField
from drake_geom_ros.geometry.shapes.primitives import QueriedShape, Shape, for_queries
from drake_geom_ros.geometry.shapes.sensed import FARTHEST_CELL, SensedMap
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.math.tolerances import FARTHEST

# One world for all scenes of the process, as in Drake.
WORLD_FRAME_ID = FrameId.get_new_id()
WORLD_NAME = 'world'
INTERNAL_SOURCE_NAME = 'SceneGraphInternal'  # the source that owns the world frame
SOLID = ('mesh', 'solid')
PADDING = ('proximity', 'padding')  # enlarges a body on all sides [m]
MARGIN = ('map', 'margin')  # enlarges each cell of a sensed map on all sides [m]
WORLD_FRAME_GROUP = -1  # no GeometryFrame can have it

# The field of a GeometryRecord that holds the properties of a role.
ROLE_FIELDS = {
    Role.kProximity: 'proximity',
    Role.kIllustration: 'illustration',
    Role.kPerception: 'perception',
}
ROLE_OF_PROPERTIES = {
    ProximityProperties: Role.kProximity,
    IllustrationProperties: Role.kIllustration,
    PerceptionProperties: Role.kPerception,
}


class Renderer(Protocol):
    """Interface of a ``RenderEngine`` to the model, which only stores it by name."""

    def Clone(self) -> Renderer:
        """Return a copy of the renderer."""


@dataclass
class FrameRecord:
    """A registered frame; the world is its own parent.

    ``geometry_ids`` are its geometries in the order of their registration: the keys of a
    dictionary, for quick removal.
    """

    id: FrameId
    name: str
    source_id: SourceId
    parent_id: FrameId
    frame_group: int
    home_id: FrameId | None = None  # of an attached frame: the parent that it was registered on
    is_part: bool = False  # an attached frame that counts as part of its parent
    geometry_ids: dict[GeometryId, None] = field(default_factory=dict)


@dataclass(frozen=True)
class GeometryRecord:
    """A registered geometry; a change makes a new record, so that models may share them.

    ``parent_id`` is the geometry it was registered on, or None; ``X_PG`` its pose in that, or in
    the frame.
    """

    id: GeometryId
    name: str
    source_id: SourceId
    frame_id: FrameId
    parent_id: GeometryId | None
    X_PG: RigidTransform
    X_FG: RigidTransform
    shape: Shape
    proximity: ProximityProperties | None = None
    illustration: IllustrationProperties | None = None
    perception: PerceptionProperties | None = None

    @cached_property
    def queried_shape(self) -> QueriedShape:
        """The shape as proximity queries use it, with the geometry's properties.

        Raises GeometryError if queries cannot support it. Cached in the record, so that a new mesh
        in a scene does not cause others to be read again.
        """
        return for_queries(self.shape, is_solid(self), margin_of(self))

    @cached_property
    def hydroelastic_body(self) -> HydroelasticBody | None:
        """The body for contact surfaces, None without hydroelastic properties.

        Raises GeometryError for properties that the shape cannot have.
        """
        if self.proximity is None:
            return None
        material = material_of(self.proximity, named(self))
        if material is None:
            return None
        hull = isinstance(self.shape, Mesh) and self.shape.volume_mesh() is None
        if hull and is_solid(self) and material.is_compliant:
            raise GeometryError(
                f'{named(self)} has hydroelastic properties, and a compliant Mesh would be its '
                "convex hull, but it has the property ('mesh', 'solid'): make it rigid"
            )
        return body_of(self.shape, material, named(self))

    def changed(self, **fields: Any) -> GeometryRecord:
        """Return the record with other values in some fields, and its packed shape if possible."""
        other = replace(self, **fields)
        if other.shape is self.shape and other.proximity is self.proximity:
            vars(other).update({k: v for k, v in vars(self).items() if k == 'hydroelastic_body'})
        packed = vars(self).get('queried_shape')
        same = other.shape is self.shape and is_solid(other) == is_solid(self)
        same = same and margin_of(other) == margin_of(self)
        if packed and same and other.proximity is not None:
            vars(other)['queried_shape'] = packed
        return other

    def filled(self, config: HeldConfig) -> GeometryRecord:
        """Return the record with a context's default properties; contexts share it."""
        if self.proximity is None:
            return self
        cached: tuple[HeldConfig, GeometryRecord] | None = vars(self).get('_filled')
        if cached is None or cached[0] != config:
            cached = config, self.changed(proximity=frozen(config.filled(self.proximity)))
            vars(self)['_filled'] = cached
        return cached[1]

    def properties(self, role: Role) -> GeometryProperties | None:
        """Return the properties of a role, or None."""
        if role not in ROLE_FIELDS:
            return None
        properties: GeometryProperties | None = getattr(self, ROLE_FIELDS[role])
        return properties

    def roles(self) -> list[Role]:
        """Return the roles of the geometry; an empty list means kUnassigned."""
        return [role for role in ROLE_FIELDS if self.properties(role) is not None]

    def has_role(self, role: Role) -> bool:
        """Return whether the geometry has a role, kUnassigned if it has no other."""
        return role in (self.roles() or [Role.kUnassigned])


@dataclass
class Versions:
    """Version numbers, each of which grows with every change of a kind."""

    frames: int = 0  # a frame was registered, renamed, removed or got another parent
    frame_order: int = 0  # a frame was removed or got another parent
    proximity: int = 0  # the geometries with the proximity role, a shape or X_FG of one changed
    any: int = 0
    names: int = 0  # ``any`` at the last change of the set of objects, of names or of roles
    roles: dict[Role, int] = field(default_factory=fresh_marks)  # see GeometryVersion
    filters: int = 0  # the version of the filters that ``roles`` include

    def copy(self) -> Versions:
        """Return an independent copy."""
        return replace(self, roles=dict(self.roles))


def named(record: FrameRecord | GeometryRecord) -> str:
    """Return kind, name and id, for messages."""
    kind = 'frame' if isinstance(record, FrameRecord) else 'geometry'
    return f"the {kind} '{record.name}' ({record.id!r})"


def is_solid(record: GeometryRecord) -> bool:
    """Return the property ('mesh', 'solid') of a Mesh; raises RuntimeError if it is no bool."""
    if record.proximity is None or not isinstance(record.shape, Mesh):
        return False
    return bool(record.proximity.GetPropertyOrDefault(*SOLID, False))


def padding_of(record: GeometryRecord) -> float:
    """Return the property ('proximity', 'padding') [m], 0 without it.

    Raises GeometryError for a value that is no length.
    """
    return _length_of(record, PADDING, FARTHEST)


def margin_of(record: GeometryRecord) -> float:
    """Return the property ('map', 'margin') [m] of a sensed map, 0 without it.

    Raises GeometryError for a value that is no length.
    """
    return _length_of(record, MARGIN, FARTHEST_CELL) if is_map(record) else 0.0


def is_map(record: GeometryRecord) -> bool:
    """Return whether the shape is a sensed map."""
    return isinstance(record.shape, SensedMap)


def _length_of(record: GeometryRecord, name: tuple[str, str], most: float) -> float:
    """Return a proximity property that is a length from 0 to ``most`` [m], 0 without one."""
    value = record.proximity and record.proximity.GetPropertyOrDefault(*name, None)
    if value is None:
        return 0.0
    number = as_number(value)
    if number is None:
        raise GeometryError(f'{named(record)}: the property {name} is {value!r}; give metres')
    if not 0.0 <= number <= most:
        raise GeometryError(
            f'{named(record)}: the property {name} is {value}; it must be >= 0 and finite [m]'
        )
    return number


def prepared(record: GeometryRecord) -> GeometryRecord:
    """Return the record of a geometry for queries: a height field is a solid.

    Raises GeometryError if queries cannot support it with the proximity role.
    """
    if record.proximity is None:
        return record
    if isinstance(record.shape, HeightField) and not is_solid(record):
        if record.proximity.HasProperty(*SOLID):
            raise GeometryError(
                f'{named(record)} is a height field, and has the property {SOLID} = False; it is '
                'always a solid'
            )
        properties = copy(record.proximity)
        properties.AddProperty(*SOLID, True)
        record = record.changed(proximity=frozen(properties))
    padding_of(record)
    _ = record.queried_shape
    _ = record.hydroelastic_body
    if isinstance(record.shape, Mesh) and not is_solid(record):
        warn_if_open(record.shape)
    return record
