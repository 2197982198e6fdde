"""Default contact properties, which contexts add to geometries that lack them."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from drake_geom_ros.geometry.model.contact_material import MATERIAL
from drake_geom_ros.geometry.model.hydroelastic_properties import (
    COMPLIANCE,
    GROUP,
    HINT,
    MARGIN,
    MODULUS,
    SLAB,
)
from drake_geom_ros.geometry.model.properties import GeometryProperties, ProximityProperties
from drake_geom_ros.geometry.model.scene_graph_config import COMPLIANCE_TYPES, SceneGraphConfig


@dataclass(frozen=True)
class HeldConfig:
    """The settings of a model; the geometries of contexts get the defaults.

    ``is_shared``: a context sees the changes of this very model, so it gets no defaults.
    """

    config: SceneGraphConfig = field(default_factory=SceneGraphConfig)
    gives: bool = False
    is_shared: bool = False

    @property
    def is_empty(self) -> bool:
        """True if there are no defaults: the default compliance type is 'undefined'."""
        return self.config.default_proximity_properties.compliance_type == 'undefined'

    def filled(self, properties: GeometryProperties) -> Any:
        """Return the properties, with missing defaults added to proximity properties."""
        if not self.gives or self.is_empty or not isinstance(properties, ProximityProperties):
            return properties
        defaults = self.config.default_proximity_properties
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
        filled = ProximityProperties(properties)
        for (group, name), value in values.items():
            if value is not None and not filled.HasProperty(group, name):
                filled.AddProperty(group, name, value)
        return filled
