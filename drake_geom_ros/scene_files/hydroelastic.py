"""Proximity properties as plain words and numbers of scene files, URDF and messages."""

from __future__ import annotations

import math
from typing import Any

from drake_geom_ros.geometry import ArgumentError, CoulombFriction, HydroelasticType
from drake_geom_ros.geometry.checks import as_number

GROUP = 'hydroelastic'
COMPLIANCE, HINT, MODULUS = 'compliance_type', 'resolution_hint', 'hydroelastic_modulus'
_LENGTHS = ('slab_thickness', 'margin')
FRICTION = ('material', 'coulomb_friction')
TYPES = {
    'rigid': HydroelasticType.kRigid,
    'compliant': HydroelasticType.kCompliant,
    'undefined': HydroelasticType.kUndefined,
}
_WORDS = {kind: word for word, kind in TYPES.items()}


def proximity_property(group: str, name: str, value: Any) -> Any:
    """Return the value of a proximity property from its plain form.

    In the group ``hydroelastic`` the compliance type becomes one of ``TYPES``, and all others
    floats. The friction of ``material`` becomes a CoulombFriction from ``[static, dynamic]``;
    other values are returned unchanged. Raises ArgumentError for unknown names in the group
    ``hydroelastic``, and for values that these properties cannot have.
    """
    if (group, name) == FRICTION:
        if isinstance(value, str) or not hasattr(value, '__len__') or len(value) != 2:
            raise ArgumentError(
                f"the property '{group}/{name}' is {value!r}; it must be [static, dynamic]"
            )
        return CoulombFriction(*value)
    if group != GROUP:
        return value
    if name == COMPLIANCE:
        if not isinstance(value, str) or value not in TYPES:
            raise ArgumentError(
                f"the property '{GROUP}/{name}' is {value!r}; it must be one of {', '.join(TYPES)}"
            )
        return TYPES[value]
    if name not in (HINT, MODULUS, *_LENGTHS):
        names = ', '.join((COMPLIANCE, HINT, MODULUS, *_LENGTHS))
        raise ArgumentError(f"there is no property '{GROUP}/{name}'; known are {names}")
    number = as_number(value)
    if number is None or not (0.0 < number < math.inf or (name == 'margin' and number == 0.0)):
        raise ArgumentError(
            f"the property '{GROUP}/{name}' is {value!r}; it must be a number > 0 and finite"
        )
    return number


def in_words(kind: HydroelasticType) -> str:
    """Return the word for a compliance type."""
    return _WORDS[kind]
