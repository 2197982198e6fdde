"""Contact material properties, with the names that Drake's contact models use."""

from __future__ import annotations

from typing import Any

from drake_geom_ros.geometry.checks import checked_type
from drake_geom_ros.geometry.errors import ArgumentError, ArgumentTypeError
from drake_geom_ros.geometry.model.properties import ProximityProperties

MATERIAL = 'material'


def AddContactMaterial(
    properties: ProximityProperties,
    dissipation: float | None = None,
    point_stiffness: float | None = None,
    friction: Any = None,
) -> None:
    """Add properties of a contact material to ``properties``, in the group ``material``.

    ``dissipation`` [s/m] >= 0 (Hunt and Crossley), ``point_stiffness`` [N/m] > 0, ``friction`` an
    object with ``static_friction()`` and ``dynamic_friction()``, as pydrake's CoulombFriction.
    No answer of this package depends on them. Raises RuntimeError for other values, and if a
    property exists already.

        >>> properties = ProximityProperties()
        >>> AddContactMaterial(properties, dissipation=0.5)
        >>> properties.GetProperty('material', 'hunt_crossley_dissipation')
        0.5
    """
    checked_type(properties, ProximityProperties, 'AddContactMaterial: properties')
    if dissipation is not None and not dissipation >= 0.0:
        raise ArgumentError(f'AddContactMaterial: dissipation = {dissipation} must be >= 0')
    if point_stiffness is not None and not point_stiffness > 0.0:
        raise ArgumentError(f'AddContactMaterial: point_stiffness = {point_stiffness} must be > 0')
    if friction is not None and not hasattr(friction, 'dynamic_friction'):
        raise ArgumentTypeError(f'AddContactMaterial: friction = {friction!r} has no coefficients')
    values = {
        'hunt_crossley_dissipation': dissipation,
        'point_contact_stiffness': point_stiffness,
        'coulomb_friction': friction,
    }
    for name, value in values.items():
        if value is not None and properties.HasProperty(MATERIAL, name):
            raise ArgumentError(f'AddContactMaterial: there is a {name} already')
    for name, value in values.items():
        if value is not None:
            properties.AddProperty(MATERIAL, name, value)
