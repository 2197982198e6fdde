"""The topic of contact surfaces."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from drake_geom_msgs.msg import ContactSurfaces

from drake_geom_ros.live.guard import Guard
from drake_geom_ros.live.outputs.contact_topic import COMPUTED, ContactTopic
from drake_geom_ros.ros.parameters import ParameterStore
from drake_geom_ros.ros.surface import Surface, results


def contact_topic(
    surface: Surface, settings: ParameterStore, guard: Guard, must_stop: Callable[[], bool]
) -> ContactTopic:
    """Open ~/contact_surfaces on ``surface``, and return what publishes on it.

    Surfaces that take long end without a message where ``must_stop()``.
    """
    return ContactTopic(
        surface.publisher(ContactSurfaces, '~/contact_surfaces', results()),
        ContactSurfaces,
        lambda: settings.values.contact_polygons,
        must_stop,
        partial(guard.failed, COMPUTED),
    )
