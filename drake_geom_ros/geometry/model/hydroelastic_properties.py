"""Properties of hydroelastic contact, with pydrake's names."""

from __future__ import annotations

import math
from collections.abc import Mapping

from drake_geom_ros.geometry.checks import as_number, checked_type
from drake_geom_ros.geometry.errors import ArgumentError, GeometryError
from drake_geom_ros.geometry.hydroelastic.bodies import HydroelasticMaterial, HydroelasticType
from drake_geom_ros.geometry.model.properties import ProximityProperties

GROUP = 'hydroelastic'
COMPLIANCE, HINT, MODULUS = 'compliance_type', 'resolution_hint', 'hydroelastic_modulus'
SLAB, MARGIN = 'slab_thickness', 'margin'


def AddRigidHydroelasticProperties(
    resolution_hint: float | ProximityProperties | None = None,
    properties: ProximityProperties | None = None,
) -> None:
    """Add the properties of a rigid geometry: call it with or without the ``resolution_hint``.

    ``resolution_hint`` [m] > 0 is the approximate edge length of facets; a half space, a Convex
    and a Mesh need none. The calls are ``(resolution_hint, properties)`` and ``(properties)``.
    Raises RuntimeError for another value, and if one of the properties exists already.

        >>> properties = ProximityProperties()
        >>> AddRigidHydroelasticProperties(0.01, properties)
        >>> properties.GetProperty('hydroelastic', 'resolution_hint')
        0.01
    """
    if isinstance(resolution_hint, ProximityProperties) and properties is None:
        resolution_hint, properties = None, resolution_hint
    values: dict[str, object] = {COMPLIANCE: HydroelasticType.kRigid}
    if resolution_hint is not None:
        values[HINT] = resolution_hint
    _add('AddRigidHydroelasticProperties', properties, values)


def AddCompliantHydroelasticProperties(
    resolution_hint: float, hydroelastic_modulus: float, properties: ProximityProperties
) -> None:
    """Add the properties of a compliant geometry, with the pressure p = modulus times extent.

    The extent grows from 0 on the surface to 1 at the innermost points. ``resolution_hint`` [m]
    > 0 is the approximate edge length, ``hydroelastic_modulus`` [Pa] > 0. Raises RuntimeError for
    other values, and if one of the properties exists already.

        >>> properties = ProximityProperties()
        >>> AddCompliantHydroelasticProperties(0.01, 1e6, properties)
        >>> properties.GetProperty('hydroelastic', 'hydroelastic_modulus')
        1000000.0
    """
    values = {HINT: resolution_hint, MODULUS: hydroelastic_modulus}
    _add_compliant('AddCompliantHydroelasticProperties', properties, values)


def AddCompliantHydroelasticPropertiesForHalfSpace(
    slab_thickness: float, hydroelastic_modulus: float, properties: ProximityProperties
) -> None:
    """Add the properties of a compliant half space: a slab over a rigid core.

    ``slab_thickness`` [m] > 0 is the depth at which the pressure is ``hydroelastic_modulus`` [Pa]
    > 0. Raises RuntimeError for other values, and if one of the properties exists already.

        >>> properties = ProximityProperties()
        >>> AddCompliantHydroelasticPropertiesForHalfSpace(0.02, 1e6, properties)
        >>> properties.GetProperty('hydroelastic', 'slab_thickness')
        0.02
    """
    values = {SLAB: slab_thickness, MODULUS: hydroelastic_modulus}
    _add_compliant('AddCompliantHydroelasticPropertiesForHalfSpace', properties, values)


def _add_compliant(
    call: str, properties: ProximityProperties, values: Mapping[str, object]
) -> None:
    """Add the properties of a compliant geometry, all or none."""
    _add(call, properties, {COMPLIANCE: HydroelasticType.kCompliant, **values})


def _add(call: str, properties: ProximityProperties | None, values: dict[str, object]) -> None:
    """Add properties, all or none."""
    into = checked_type(properties, ProximityProperties, f'{call}: properties')
    for name, value in values.items():
        if name == COMPLIANCE:
            continue
        values[name] = number = as_number(value)
        if number is None:
            raise ArgumentError(f'{call}: {name} = {value!r} must be a number')
        if not 0.0 < number < math.inf:
            raise ArgumentError(f'{call}: {name} = {value} must be > 0 and finite')
    for name in values:
        if into.HasProperty(GROUP, name):
            raise ArgumentError(f'{call}: there is a property {GROUP}/{name} already')
    for name, value in values.items():
        into.AddProperty(GROUP, name, value)


def material_of(properties: ProximityProperties, what: str) -> HydroelasticMaterial | None:
    """Return the hydroelastic material of a geometry, None without one.

    Raises GeometryError, which begins with ``what``, for an unknown compliance type, and for a
    margin, which is not supported.
    """
    compliance = properties.GetPropertyOrDefault(GROUP, COMPLIANCE, None)
    if compliance is None or compliance is HydroelasticType.kUndefined:
        return None
    if not isinstance(compliance, HydroelasticType):
        raise GeometryError(
            f"{what}: the property '{GROUP}/{COMPLIANCE}' is {compliance!r}; it must be a "
            'HydroelasticType: use AddCompliantHydroelasticProperties and its kin'
        )
    if properties.GetPropertyOrDefault(GROUP, MARGIN, None):
        raise GeometryError(
            f"{what}: the property '{GROUP}/{MARGIN}' is not supported; contact surfaces are "
            'those of bodies without one'
        )
    numbers = (
        properties.GetPropertyOrDefault(GROUP, name, None) for name in (HINT, MODULUS, SLAB)
    )
    return HydroelasticMaterial(compliance, *numbers)
