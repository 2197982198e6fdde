"""Contact material properties, with the names that Drake's contact models use."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from drake_geom_ros.geometry.checks import as_number, checked_type
from drake_geom_ros.geometry.errors import ArgumentError, ArgumentTypeError
from drake_geom_ros.geometry.model.properties import ProximityProperties

MATERIAL = 'material'


@dataclass(frozen=True, init=False, repr=False)
class CoulombFriction:
    """Coefficients of friction [-] of a surface, as those of pydrake's ``multibody.plant``.

    No answer of this package depends on them. Raises RuntimeError unless
    0 <= ``dynamic_friction`` <= ``static_friction``, both finite.

    >>> CoulombFriction(0.9, 0.7).dynamic_friction()
    0.7
    """

    _static: float
    _dynamic: float

    def __init__(self, static_friction: float = 0.0, dynamic_friction: float = 0.0) -> None:
        static, dynamic = as_number(static_friction), as_number(dynamic_friction)
        if static is None or dynamic is None or not 0.0 <= dynamic <= static < math.inf:
            raise ArgumentError(
                f'CoulombFriction: static_friction = {static_friction!r}, dynamic_friction = '
                f'{dynamic_friction!r}; they must be finite numbers, 0 <= dynamic <= static'
            )
        object.__setattr__(self, '_static', static)
        object.__setattr__(self, '_dynamic', dynamic)

    def static_friction(self) -> float:
        """Return the coefficient [-] of surfaces that stick."""
        return self._static

    def dynamic_friction(self) -> float:
        """Return the coefficient [-] of surfaces that slide."""
        return self._dynamic

    def __repr__(self) -> str:
        return f'CoulombFriction({self._static}, {self._dynamic})'


def AddContactMaterial(
    properties: ProximityProperties,
    dissipation: float | None = None,
    point_stiffness: float | None = None,
    friction: Any = None,
) -> None:
    """Add properties of a contact material to ``properties``, in the group ``material``.

    ``dissipation`` [s/m] >= 0 (Hunt and Crossley), ``point_stiffness`` [N/m] > 0, ``friction`` a
    CoulombFriction, or an object with ``static_friction()`` and ``dynamic_friction()``.
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
