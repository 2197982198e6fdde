"""Zones: geometries that only the proximity rules see that name them.

A zone has no proximity role, so no query answers for it. It is drawn, and bears the property
SENSOR in the role for that. Rules measure it in a copy of the scene, where it has the proximity
role: see ``QueryObject.with_proximity``.
"""

from __future__ import annotations

from collections.abc import Mapping

from drake_geom_ros.geometry import (
    GeometryId,
    GeometryInstance,
    GeometryProperties,
    IllustrationProperties,
    ProximityProperties,
    Role,
    SceneGraph,
    SceneGraphInspector,
    Shape,
)
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.proximity_rules.named_geometries import geometry_names

SENSOR = ('proximity_rules', 'sensor')  # group and name of the property of a zone, true
SOLID = ('mesh', 'solid')

Zones = Mapping[GeometryId, ProximityProperties]


def is_zone(roles: Mapping[Role, GeometryProperties]) -> bool:
    """Return whether a geometry with these roles is a zone.

    >>> illustration = IllustrationProperties()
    >>> illustration.AddProperty(*SENSOR, True)
    >>> is_zone({Role.kIllustration: illustration})
    True
    """
    illustration = roles.get(Role.kIllustration)
    return illustration is not None and _is_marked(illustration)


def zones_in(inspector: SceneGraphInspector) -> dict[GeometryId, ProximityProperties]:
    """Return the zones of a scene, with the properties by which rules measure them."""
    return {
        geometry: properties_of_zone(illustration)
        for geometry in inspector.GetAllGeometryIds(Role.kIllustration)
        if (illustration := inspector.GetIllustrationProperties(geometry)) is not None
        and _is_marked(illustration)
        and inspector.GetProximityProperties(geometry) is None
    }


def named_zones(inspector: SceneGraphInspector) -> dict[str, GeometryId]:
    """Return the zones of a scene by their full names, ``source::frame/geometry``."""
    return {geometry_names(inspector, zone).full_name: zone for zone in zones_in(inspector)}


def check_zone(shape: Shape, illustration: GeometryProperties | None) -> None:
    """Raise GeometryError for a zone that rules could not measure; ignore other geometry.

    ``illustration`` are the properties that a geometry is drawn with.
    """
    if not isinstance(illustration, IllustrationProperties) or not _is_marked(illustration):
        return
    instance = GeometryInstance(RigidTransform(), shape, 'zone')
    instance.set_proximity_properties(properties_of_zone(illustration))
    scene_graph = SceneGraph()
    scene_graph.RegisterAnchoredGeometry(scene_graph.RegisterSource('zone'), instance)


def properties_of_zone(illustration: IllustrationProperties) -> ProximityProperties:
    """Return the properties by which rules measure a zone that is drawn with others.

    A mesh is its convex hull unless it is said to be solid, as bodies are.
    """
    properties = ProximityProperties()
    if illustration.GetPropertyOrDefault(*SOLID, False) is True:
        properties.AddProperty(*SOLID, True)
    return properties


def _is_marked(illustration: GeometryProperties) -> bool:
    return illustration.GetPropertyOrDefault(*SENSOR, False) is True
