"""What contexts add to geometries whose properties say nothing of contact."""

from __future__ import annotations

from drake_geom_ros.geometry.errors import GeometryError
from drake_geom_ros.geometry.model._model import Model
from drake_geom_ros.geometry.model.contact_material import MATERIAL
from drake_geom_ros.geometry.model.hydroelastic_properties import (
    COMPLIANCE,
    GROUP,
    HINT,
    MARGIN,
    MODULUS,
    SLAB,
)
from drake_geom_ros.geometry.model.properties import ProximityProperties, Role, frozen
from drake_geom_ros.geometry.model.scene_graph_config import COMPLIANCE_TYPES


def with_defaults(model: Model) -> None:
    """Give all geometries of a model what its config has and their proximity properties lack.

    Nothing where the compliance type is 'undefined'. Raises GeometryError where a geometry cannot
    be what the defaults say.
    """
    defaults = model.config.default_proximity_properties
    if defaults.compliance_type == 'undefined':
        return
    values = {
        (GROUP, COMPLIANCE): COMPLIANCE_TYPES[defaults.compliance_type],
        (GROUP, MODULUS): defaults.hydroelastic_modulus,
        (GROUP, HINT): defaults.resolution_hint,
        (GROUP, SLAB): defaults.slab_thickness,
        (GROUP, MARGIN): defaults.margin,
        (MATERIAL, 'hunt_crossley_dissipation'): defaults.hunt_crossley_dissipation,
        (MATERIAL, 'relaxation_time'): defaults.relaxation_time,
        (MATERIAL, 'point_contact_stiffness'): defaults.point_stiffness,
    }
    for id, record in list(model.geometries.items()):
        if record.proximity is None:
            continue
        properties = ProximityProperties(record.proximity)
        for (group, name), value in values.items():
            if value is not None and not properties.HasProperty(group, name):
                properties.AddProperty(group, name, value)
        changed = record.changed(proximity=frozen(properties))
        _ = changed.hydroelastic_body
        model.geometries[id] = changed
    model.changed(roles=[Role.kProximity], names=False)


def refuse_defaults(model: Model) -> None:
    """Raise GeometryError where a config would change geometries that others share."""
    if model.config.default_proximity_properties.compliance_type != 'undefined':
        raise GeometryError(
            'CreateSharedContext: the config has a default compliance type, which would change '
            'the shared geometries; give them hydroelastic properties of their own'
        )
