"""Hydroelastic properties in words and numbers, as scene files, URDF and messages say them."""

from __future__ import annotations

import math
from typing import Any

from drake_geom_ros.geometry import ArgumentError, HydroelasticType
from drake_geom_ros.geometry.checks import as_number

GROUP = 'hydroelastic'
COMPLIANCE, HINT, MODULUS = 'compliance_type', 'resolution_hint', 'hydroelastic_modulus'
_LENGTHS = ('slab_thickness', 'margin')
TYPES = {
    'rigid': HydroelasticType.kRigid,
    'compliant': HydroelasticType.kCompliant,
    'undefined': HydroelasticType.kUndefined,
}
_WORDS = {kind: word for word, kind in TYPES.items()}


def proximity_property(group: str, name: str, value: Any) -> Any:
    """Return the value of a property of the proximity role that was said in words and numbers.

    Of the group ``hydroelastic`` it is what contact surfaces are made by: the compliance type one
    of ``TYPES``, all others floats. Of other groups it is the value. Raises ArgumentError for
    unknown names of this group, and for values that these properties cannot have.
    """
    if group != GROUP:
        return value
    if name == COMPLIANCE:
        if not isinstance(value, str) or value not in TYPES:
            raise ArgumentError(
                f"the property '{GROUP}/{name}' is {value!r}; it must be one of {', '.join(TYPES)}"
            )
        return TYPES[value]
    if name not in (HINT, MODULUS, *_LENGTHS):
        known = ', '.join((COMPLIANCE, HINT, MODULUS, *_LENGTHS))
        raise ArgumentError(f"there is no property '{GROUP}/{name}'; known are {known}")
    number = as_number(value)
    if number is None or not (0.0 < number < math.inf or (name == 'margin' and number == 0.0)):
        raise ArgumentError(
            f"the property '{GROUP}/{name}' is {value!r}; it must be a number > 0 and finite"
        )
    return number


def in_words(kind: HydroelasticType) -> str:
    """Return the word for a compliance type."""
    return _WORDS[kind]
