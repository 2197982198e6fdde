"""The hydroelastic bodies of a scene, packed for the kernels."""

from __future__ import annotations

from enum import IntEnum
from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._contact_surfaces.arrays import HALF_SPACE, KIND, VOLUME, Bodies
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
from drake_geom_ros.geometry.meshes.volume_surface import neighbours_of
from drake_geom_ros.geometry.model._model import Model

Indices = NDArray[np.int64]


# How bodies are packed, while they live: the contexts of a scene share them.
_PACKED: WeakKeyDictionary[HydroelasticBody, PackedBody] = WeakKeyDictionary()


class NoSurface(IntEnum):
    """Why two geometries that overlap have no contact surface."""

    NO_PROPERTIES = 1
    BOTH_RIGID = 2
    HALF_SPACES = 3
    TOO_DEEP = 4

    def in_words(self) -> str:
        """Return the reason, and what can be done."""
        return _REASONS[self]


_REASONS = {
    NoSurface.NO_PROPERTIES: 'one of them has no hydroelastic properties; give it some',
    NoSurface.BOTH_RIGID: 'both are rigid; make one of them compliant',
    NoSurface.HALF_SPACES: 'both are half spaces',
    NoSurface.TOO_DEEP: ('one is so deep within the other that their pressures are equal nowhere'),
}


class ContactBodies(NamedTuple):
    """The bodies of the geometries with hydroelastic properties, by ascending ids (b,)."""

    version: int
    ids: Indices
    is_compliant: NDArray[np.bool_]
    bodies: Bodies

    def rows(self, ids: Indices) -> Indices:
        """Return which body geometries (...) are, by the values of their ids; -1 where none."""
        if not len(self.ids):
            return np.full(ids.shape, -1)
        at = self.ids.searchsorted(ids)
        at[at == len(self.ids)] = 0
        at[self.ids[at] != ids] = -1
        return at

    def load_kernels(self) -> None:
        """Compile what makes surfaces, or load it from the cache."""
        # Only who may ask for surfaces loads their kernels, and those of solids behind them.
        from drake_geom_ros.geometry._contact_surfaces.pairs import surfaces_of

        no_pairs, no_poses = np.zeros((0, 2), dtype=np.int64), np.zeros((0, 3, 3))
        surfaces_of(self.bodies, no_pairs, no_poses, np.zeros((0, 3)))

    def have_a_surface(self, a: Indices, b: Indices) -> NDArray[np.bool_]:
        """Tell for pairs of rows (k,) whether they can have a surface: see ``why_not``."""
        if not len(self.ids):
            return np.zeros(len(a), dtype=np.bool_)
        able: NDArray[np.bool_] = self.is_compliant[a] | self.is_compliant[b]
        able &= (a >= 0) & (b >= 0)
        infinite = self.bodies.table[:, KIND] == HALF_SPACE
        if infinite.any():
            able &= ~(infinite[a] & infinite[b])
        return able

    def why_not(self, a: Indices, b: Indices) -> Indices:
        """Return why pairs of rows (k,) that overlap have no surface: values of NoSurface."""
        reasons = np.full(len(a), NoSurface.TOO_DEEP.value)
        if len(self.ids):
            infinite = self.bodies.table[:, KIND] == HALF_SPACE
            reasons[infinite[a] & infinite[b]] = NoSurface.HALF_SPACES
            reasons[~(self.is_compliant[a] | self.is_compliant[b])] = NoSurface.BOTH_RIGID
        reasons[(a < 0) | (b < 0)] = NoSurface.NO_PROPERTIES
        return reasons


def contact_bodies(model: Model, before: ContactBodies | None) -> ContactBodies:
    """Return the bodies of a model, those from before where nothing has changed since."""
    version = model.versions.proximity
    if before is not None and before.version == version:
        return before
    parts: dict[int, PackedBody] = {}
    for id in sorted(model.geometries):
        body = model.geometries[id].hydroelastic_body
        if body is not None:
            if body not in _PACKED:
                _PACKED[body] = _packed(body)
            parts[id.get_value()] = _PACKED[body]
    compliant = [
        part.kind == VOLUME or (part.kind == HALF_SPACE and part.numbers[1] > 0.0)
        for part in parts.values()
    ]
    none = [packed_half_space(0.0)]  # arrays need something to be joined of
    return ContactBodies(
        version,
        np.array(list(parts), dtype=np.int64),
        np.array(compliant, dtype=np.bool_),
        packed(list(parts.values()) or none),
    )


def _packed(body: HydroelasticBody) -> PackedBody:
    """Return a body as the kernels take it."""
    if isinstance(body, CompliantBody):
        elements = body.mesh.element_array()
        beyond = neighbours_of(elements)
        return packed_volume(body.mesh.vertex_array(), elements, body.pressures, beyond)
    if isinstance(body, HalfSpaceBody):
        return packed_half_space(body.pressure_slope)
    return packed_surface(body.mesh.vertex_array(), body.mesh.triangle_array())
