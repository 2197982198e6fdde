"""The hydroelastic bodies of a scene, packed for the kernels."""

from __future__ import annotations

from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._contact_surfaces.arrays import (
    HALF_SPACE,
    KIND,
    SWALLOWED,
    TURNED,
    Bodies,
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

Indices = NDArray[np.int64]


# How bodies are packed, while they live: the contexts of a scene share them.
_PACKED: WeakKeyDictionary[HydroelasticBody, PackedBody] = WeakKeyDictionary()


class ContactBodies(NamedTuple):
    """The bodies of the geometries with hydroelastic properties."""

    version: int
    ids: Indices  # (n,) of all geometries that proximity queries know
    body_of: Indices  # (n,) the row of each one's body; -1: it has none
    bodies: Bodies

    def why_not(self, M: int, N: int, state: int) -> str:
        """Return why two geometries that overlap have no surface, and what can be done.

        By their places among ``ids``, and what ``Surfaces.states`` says of the pair.
        """
        if state == TURNED:
            return 'all its faces are left out, for one pressure does not grow along their normals'
        if state == SWALLOWED:
            return 'one is so deep within the other that their pressures are equal nowhere'
        rows = self.body_of[M], self.body_of[N]
        if min(rows) < 0:
            return 'one of them has no hydroelastic properties; give it some'
        kinds = self.bodies.table[rows, KIND]
        if (kinds == HALF_SPACE).all():
            return 'both are half spaces'
        return 'both are rigid; make one of them compliant'


def contact_bodies(model: Model, ids: Indices, before: ContactBodies | None) -> ContactBodies:
    """Return the bodies of a model, those from before where nothing has changed since.

    ``ids`` (n,) are the values of those of all its geometries in proximity queries, ascending.
    """
    version = model.versions.proximity
    if before is not None and before.version == version and before.ids is ids:
        return before
    parts, body_of = [packed_half_space(0.0)], []  # arrays need something to be joined of
    for value in ids.tolist():
        body = model.geometry(GeometryId(value)).hydroelastic_body
        body_of.append(-1 if body is None else len(parts))
        if body is not None:
            if body not in _PACKED:
                _PACKED[body] = _packed(body)
            parts.append(_PACKED[body])
    return ContactBodies(version, ids, np.array(body_of, dtype=np.int64), packed(parts))


def _packed(body: HydroelasticBody) -> PackedBody:
    """Return a body as the kernels take it."""
    if isinstance(body, CompliantBody):
        elements = body.mesh.element_array()
        beyond = neighbours_of(elements)
        return packed_volume(body.mesh.vertex_array(), elements, body.pressures, beyond)
    if isinstance(body, HalfSpaceBody):
        return packed_half_space(body.pressure_slope)
    return packed_surface(body.mesh.vertex_array(), body.mesh.triangle_array())
