"""``SceneGraphConfig``: the default contact properties of a scene's geometries."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields, replace

from drake_geom_ros.geometry.checks import as_number, checked_type
from drake_geom_ros.geometry.errors import ArgumentError
from drake_geom_ros.geometry.hydroelastic.bodies import HydroelasticType
from drake_geom_ros.geometry.model.hydroelastic_properties import (
    HINT,
    MODULUS,
    SLAB,
)

COMPLIANCE_TYPES = {
    'undefined': HydroelasticType.kUndefined,
    'rigid': HydroelasticType.kRigid,
    'compliant': HydroelasticType.kCompliant,
}


@dataclass
class DefaultProximityProperties:
    """Default properties for geometries that lack them, as in pydrake; None for no default.

    ``compliance_type`` is 'undefined' (no hydroelastic contact), 'rigid' or 'compliant';
    ``hydroelastic_modulus`` [Pa], ``resolution_hint`` [m], ``slab_thickness`` [m] of half spaces.
    ``dynamic_friction``, ``static_friction`` [-], ``hunt_crossley_dissipation`` [s/m],
    ``relaxation_time`` [s] and ``point_stiffness`` [N/m] are stored; no answer depends on them.
    """

    compliance_type: str = 'undefined'
    hydroelastic_modulus: float | None = 1e7
    resolution_hint: float | None = 0.02
    slab_thickness: float | None = None
    margin: float | None = None
    dynamic_friction: float | None = 0.5
    static_friction: float | None = 0.5
    hunt_crossley_dissipation: float | None = 50.0
    relaxation_time: float | None = 0.1
    point_stiffness: float | None = 1e6


@dataclass
class SceneGraphConfig:
    """The settings of a SceneGraph.

    >>> defaults = DefaultProximityProperties(compliance_type='compliant')
    >>> SceneGraphConfig(default_proximity_properties=defaults).default_proximity_properties.margin
    """

    default_proximity_properties: DefaultProximityProperties = field(
        default_factory=DefaultProximityProperties
    )


def checked_config(config: SceneGraphConfig) -> SceneGraphConfig:
    """Return a copy of a config; raises ArgumentError for a value that a property cannot have."""
    checked_type(config, SceneGraphConfig, 'SceneGraph: config')
    defaults = checked_type(
        config.default_proximity_properties,
        DefaultProximityProperties,
        'SceneGraphConfig: default_proximity_properties',
    )
    if defaults.compliance_type not in COMPLIANCE_TYPES:
        raise ArgumentError(
            f"SceneGraphConfig: 'compliance_type' is {defaults.compliance_type!r}; it must be one "
            f'of {", ".join(COMPLIANCE_TYPES)}'
        )
    numbers = {
        each.name: _checked_number(each.name, getattr(defaults, each.name))
        for each in fields(defaults)
        if each.name != 'compliance_type'
    }
    defaults = replace(defaults, **numbers)  # type: ignore[arg-type]
    _check_friction(defaults.static_friction, defaults.dynamic_friction)
    return replace(config, default_proximity_properties=defaults)


def _checked_number(name: str, value: object) -> float | None:
    """Return a default property as a float, None without a value.

    Raises ArgumentError for a value that is not allowed.
    """
    if value is None:
        return None
    number = as_number(value)
    if number is None:
        raise ArgumentError(f'SceneGraphConfig: {name!r} is {value!r}; give a number or None')
    may_be_zero = name not in (HINT, MODULUS, SLAB, 'point_stiffness')
    if not (0.0 < number < math.inf or (may_be_zero and number == 0.0)):
        raise ArgumentError(
            f'SceneGraphConfig: {name!r} is {value}; it must be '
            f'{">= 0" if may_be_zero else "> 0"} and finite'
        )
    return number


def _check_friction(static: float | None, dynamic: float | None) -> None:
    """Raise ArgumentError for a single coefficient, and if dynamic exceeds static."""
    if (static is None) != (dynamic is None):
        raise ArgumentError(
            f"SceneGraphConfig: 'static_friction' is {static} and 'dynamic_friction' {dynamic}; "
            'give both or neither'
        )
    if static is not None and dynamic is not None and dynamic > static:
        raise ArgumentError(
            f"SceneGraphConfig: 'dynamic_friction' is {dynamic}; it must be at most "
            f"'static_friction', {static}"
        )
