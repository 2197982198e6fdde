"""Proximity properties of collision elements of URDF and SDFormat, in Drake's elements.

``<drake:proximity_properties>`` holds ``<drake:rigid_hydroelastic/>`` or
``<drake:compliant_hydroelastic/>``, coefficients of friction (``<drake:mu_static>``,
``<drake:mu_dynamic>``) and numbers as ``<drake:hydroelastic_modulus value="1e6"/>``, in SDFormat
as text in the element.
"""

from typing import Any

from drake_geom_ros.geometry import CoulombFriction, HydroelasticType, ProximityProperties
from drake_geom_ros.scene_files.drake_names import is_drake_name
from drake_geom_ros.scene_files.hydroelastic import (
    COMPLIANCE,
    FRICTION,
    GROUP,
    HINT,
    MODULUS,
    TYPES,
    proximity_property,
)
from drake_geom_ros.scene_files.xml_tree import local_name, numbers

_COMPLIANCE = {
    'rigid_hydroelastic': TYPES['rigid'],
    'compliant_hydroelastic': TYPES['compliant'],
}
# Names of Drake's properties; no answer depends on those of the group `material`.
_NUMBERS = {
    'mesh_resolution_hint': (GROUP, HINT),
    'hydroelastic_modulus': (GROUP, MODULUS),
    'hunt_crossley_dissipation': ('material', 'hunt_crossley_dissipation'),
    'relaxation_time': ('material', 'relaxation_time'),
    'point_contact_stiffness': ('material', 'point_contact_stiffness'),
}
_COEFFICIENTS = ('mu_static', 'mu_dynamic')
KNOWN_PROPERTIES = (*_COMPLIANCE, *_NUMBERS, *_COEFFICIENTS)


def proximity_properties_of(collision: Any) -> ProximityProperties:
    """Return the properties of a collision element, empty if it has none.

    As in Drake, the modulus of a rigid element is ignored, and one coefficient of friction stands
    for both. Raises ValueError or RuntimeError,
    which name no line, for an element that is both rigid and compliant, and for a value that is
    no number or that the property cannot have.
    """
    properties = ProximityProperties()
    for part in collision:
        if local_name(part) == 'proximity_properties':
            elements = {local_name(element): element for element in part}
            if all(name in elements for name in _COMPLIANCE):
                raise ValueError(f'<{"> and <".join(_COMPLIANCE)}> exclude each other; give one')
            _add(elements, properties)
    return properties


def _add(elements: dict[str, Any], properties: ProximityProperties) -> None:
    """Add the properties of the elements, by local name."""
    for name, kind in _COMPLIANCE.items():
        if name in elements:
            properties.AddProperty(GROUP, COMPLIANCE, kind)
    for name, (group, key) in _NUMBERS.items():
        if name not in elements or (key == MODULUS and 'rigid_hydroelastic' in elements):
            continue
        value = _number(elements[name])
        properties.AddProperty(group, key, proximity_property(group, key, value))
    if coefficients := [_number(elements[name]) for name in _COEFFICIENTS if name in elements]:
        both = (coefficients[0], coefficients[-1])
        properties.AddProperty(*FRICTION, proximity_property(*FRICTION, both))


def _number(element: Any) -> float:
    """Return the number of an element, in its attribute ``value`` or as its text."""
    return numbers(element, 'value', 1, element.text)[0]


def write_properties(collision: Any, properties: ProximityProperties, namespace: str) -> None:
    """Add the element of properties to a collision element, none for no properties.

    Names that look-ups use for a geometry are not written, for reading makes them again. Raises
    ValueError for a property that no element of Drake holds.
    """
    written = collision.makeelement(f'{{{namespace}}}proximity_properties')
    for group in sorted(properties.GetGroupNames()):
        for key, held in sorted(properties.GetPropertiesInGroup(group).items()):
            value = held.get_value()
            if is_drake_name(group, key) or value is HydroelasticType.kUndefined:
                continue
            for name, number in _elements_of(group, key, value).items():
                element = written.makeelement(f'{{{namespace}}}{name}')
                if number is not None:
                    element.set('value', repr(number))
                written.append(element)
    if len(written):
        collision.append(written)


def _elements_of(group: str, key: str, value: Any) -> dict[str, float | None]:
    """Return the elements that hold a property, each with its number; ValueError if none does."""
    elements = {where: name for name, where in _NUMBERS.items()}
    if (group, key) == FRICTION and isinstance(value, CoulombFriction):
        numbers = value.static_friction(), value.dynamic_friction()
        return dict(zip(_COEFFICIENTS, numbers, strict=True))
    if (group, key) == (GROUP, COMPLIANCE):
        return {name: None for name, kind in _COMPLIANCE.items() if kind == value}
    if (group, key) in elements and isinstance(value, float):
        return {elements[group, key]: value}
    raise ValueError(f'a URDF cannot hold the property {group}/{key} = {value!r}')
