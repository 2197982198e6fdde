"""Opens what tells of contact surfaces."""

from __future__ import annotations

from drake_geom_msgs.msg import ContactSurfaces

from drake_geom_ros.ros.outputs.contact_topic import ContactTopic
from drake_geom_ros.ros.parameters import ParameterStore
from drake_geom_ros.ros.surface import Surface, results


def contact_topic(surface: Surface, settings: ParameterStore) -> ContactTopic:
    """Open ~/contact_surfaces on ``surface``, and return what publishes on it."""
    publisher = surface.publisher(ContactSurfaces, '~/contact_surfaces', results())
    return ContactTopic(publisher, ContactSurfaces(), lambda: settings.values.contact_polygons)
