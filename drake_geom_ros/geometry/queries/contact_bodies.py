"""The hydroelastic bodies of a scene, packed for the kernels."""

from __future__ import annotations

from enum import IntEnum
from typing import TYPE_CHECKING, NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from drake_geom_ros.geometry._contact_surfaces.arrays import (
    LATE,
    NOTHING,
    SWALLOWED,
    TURNED,
    Bodies,
    Geometries,
)
from drake_geom_ros.geometry._contact_surfaces.packing import (
    PackedBody,
    packed,
    packed_half_space,
    packed_surface,
    packed_volume,
)
from drake_geom_ros.geometry.hydroelastic.bodies import (
    CompliantBody,
    HalfSpaceBody,
    HydroelasticBody,
)
from drake_geom_ros.geometry.ids import GeometryId
from drake_geom_ros.geometry.meshes.volume_surface import neighbours_of
from drake_geom_ros.geometry.model._model import Model
from drake_geom_ros.geometry.model._records import GeometryRecord, is_solid
from drake_geom_ros.geometry.queries.padding import Paddings
from drake_geom_ros.geometry.shapes.from_meshes import Mesh
from drake_geom_ros.geometry.shapes.primitives import Capsule, Cylinder, Ellipsoid, Sphere
from drake_geom_ros.math.array_types import Floats, Indices

if TYPE_CHECKING:  # with its kernels
    from drake_geom_ros.geometry._contact_surfaces.asking import Posed


# Packed bodies, as long as the bodies live: the contexts of a scene share them.
_PACKED: WeakKeyDictionary[HydroelasticBody, PackedBody] = WeakKeyDictionary()


class NoSurface(IntEnum):
    """Reason why two geometries that overlap have no contact surface."""

    NO_PROPERTIES = 1
    BOTH_RIGID = 2
    HALF_SPACES = 3
    TOO_DEEP = 4
    FACES_LEFT_OUT = 5
    TOO_COARSE = 6
    OUT_OF_TIME = 7

    def in_words(self) -> str:
        """Return the reason and the remedy."""
        return _REASONS[self]


# Relation of a body to the shape that all other queries use: the same, or a mesh with all vertices
# on the surface of a round shape, or a mesh whose convex hull is the shape.
SAME, ROUND, OTHER = range(3)
# A state of pairs beside those of ``Surfaces.states``: NOTHING, but the meshes may be so coarse
# that they miss each other.
COARSE = 5

_REASONS = {
    NoSurface.NO_PROPERTIES: 'one of them has no hydroelastic properties; give it some',
    NoSurface.BOTH_RIGID: 'both are rigid; make one of them compliant',
    NoSurface.HALF_SPACES: 'both are half spaces, and such overlap without end',
    NoSurface.TOO_DEEP: 'one is so deep within the other that their pressures are equal nowhere',
    NoSurface.FACES_LEFT_OUT: (
        'all its faces are left out, for one pressure does not grow along their normals'
    ),
    NoSurface.TOO_COARSE: (
        'the meshes that stand for them do not overlap; give them a smaller resolution_hint'
    ),
    NoSurface.OUT_OF_TIME: (
        'there was no time to compute one; give them a larger resolution_hint, or allow more time'
    ),
}


class ContactBodies(NamedTuple):
    """The bodies of the geometries with hydroelastic properties."""

    version: int
    ids: Indices  # (n,) of all geometries with the proximity role
    body_of: Indices  # (n,) the row of each one's body; -1: it has none
    bodies: Bodies
    likeness: Indices  # (n,) SAME, ROUND or OTHER
    paddings: Paddings | None

    def load_kernels(self) -> None:
        """Compile the kernels for surfaces, or load them from the cache; no-op without bodies."""
        if (self.body_of < 0).all():
            return
        # Imported here: other scenes need not load these kernels, nor those of solids.
        from drake_geom_ros.geometry._contact_surfaces.asking import surfaces_of

        n = len(self.ids)
        posed = self.posed(np.zeros((n, 3, 3)), np.zeros((n, 3)))
        surfaces_of(posed, np.zeros((0, 2), dtype=np.int64))

    def posed(self, R_WGs: Floats, p_WGs: Floats) -> Posed:
        """Return the bodies as geometries that refer to pose arrays (n, 3, 3), (n, 3)."""
        from drake_geom_ros.geometry._contact_surfaces.asking import Posed

        return Posed(self.bodies, Geometries(self.ids, self.body_of, R_WGs, p_WGs))

    def judged(self, ids: Indices, states: Indices) -> Indices:
        """Return states (k,) of pairs of ids (k, 2), with COARSE in place of some NOTHING.

        Meshes may miss each other in pairs with a ROUND body and no OTHER one. Without such
        pairs the same array is returned.
        """
        nothing = np.flatnonzero(states == NOTHING)
        places = np.searchsorted(self.ids, ids[nothing])
        coarse = nothing[self.likeness[places].max(axis=1, initial=SAME) == ROUND]
        if len(coarse):
            states = states.copy()
            states[coarse] = COARSE
        return states

    def padding_between(self, ids: Indices) -> Floats:
        """Return the sums of paddings (k,) [m] of pairs of ids (k, 2)."""
        if self.paddings is None:
            return np.zeros(len(ids))
        radii: Floats = self.paddings.radii[np.searchsorted(self.ids, ids)].sum(axis=1)
        return radii

    def why_not(self, M: Indices, N: Indices, states: Indices) -> Indices:
        """Return the NoSurface (k,) of overlapping pairs that are not both half spaces.

        ``M`` and ``N`` (k,) are the places of geometries in ``ids``, ``states`` those of
        ``Surfaces.states`` or COARSE.
        """
        rows = np.column_stack((self.body_of[M], self.body_of[N]))
        reasons = np.full(len(rows), NoSurface.BOTH_RIGID.value)
        reasons[(rows < 0).any(axis=1)] = NoSurface.NO_PROPERTIES
        reasons[states == SWALLOWED] = NoSurface.TOO_DEEP
        reasons[states == TURNED] = NoSurface.FACES_LEFT_OUT
        reasons[states == COARSE] = NoSurface.TOO_COARSE
        reasons[states == LATE] = NoSurface.OUT_OF_TIME
        return reasons


def contact_bodies(
    model: Model, ids: Indices, paddings: Paddings | None, before: ContactBodies | None
) -> ContactBodies:
    """Return the bodies of a model, or ``before`` if the model has not changed since.

    ``ids`` (n,) are the id values of all its geometries with the proximity role, ascending.
    """
    version = model.versions.proximity
    if before is not None and before.version == version and before.ids is ids:
        return before
    parts, body_of = [packed_half_space(0.0)], []  # a first part, so that there is one to join
    likeness = []
    for value in ids.tolist():
        record = model.geometry(GeometryId(value))
        body = record.hydroelastic_body
        likeness.append(_likeness(record))
        body_of.append(-1 if body is None else len(parts))
        if body is not None:
            if body not in _PACKED:
                _PACKED[body] = _packed(body)
            parts.append(_PACKED[body])
    rows, alike = np.array(body_of, dtype=np.int64), np.array(likeness, dtype=np.int64)
    return ContactBodies(version, ids, rows, packed(parts), alike, paddings)


def _likeness(record: GeometryRecord) -> int:
    """Return SAME, ROUND or OTHER: how a geometry's body relates to its shape in other queries."""
    if isinstance(record.shape, Mesh) and not is_solid(record):
        return OTHER
    is_round = isinstance(record.shape, (Sphere, Ellipsoid, Cylinder, Capsule))
    return ROUND if is_round else SAME


def _packed(body: HydroelasticBody) -> PackedBody:
    """Return a body in the layout of the kernels."""
    if isinstance(body, CompliantBody):
        elements = body.mesh.element_array()
        beyond = neighbours_of(elements)
        return packed_volume(body.mesh.vertex_array(), elements, body.pressures, beyond)
    if isinstance(body, HalfSpaceBody):
        return packed_half_space(body.pressure_slope)
    return packed_surface(body.mesh.vertex_array(), body.mesh.triangle_array())
