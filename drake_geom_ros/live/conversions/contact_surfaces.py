"""Contact surfaces to messages."""

from __future__ import annotations

from typing import Any

import numpy as np

from drake_geom_ros.geometry import ContactSurfaceResults
from drake_geom_ros.geometry.queries.contact_queries import Contacts
from drake_geom_ros.live.conversions.fields import floats, uint8s, uint32s, unsigned

# What each takes in a message [bytes].
SURFACE_SIZE, POINT_PAIR_SIZE = 132, 105
POLYGON_SIZE, CORNER_SIZE = 4, 32


def size_of(contacts: Contacts, polygons: bool) -> int:
    """Return what contacts take in a message [bytes]."""
    size = SURFACE_SIZE * len(contacts.surfaces) + POINT_PAIR_SIZE * len(contacts.others)
    if polygons:
        points, _, ends = contacts.surfaces.polygon_arrays()
        size += CORNER_SIZE * len(points) + POLYGON_SIZE * len(ends)
    return size


def fill_contact_surfaces(
    message: Any, contacts: Contacts, participants: int, polygons: bool
) -> None:
    """Fill the arrays of a ContactSurfaces message, those of the polygons if wanted."""
    message.participants = participants
    _fill_surfaces(message, contacts.surfaces)
    _fill_polygons(message, contacts.surfaces, polygons)
    others = contacts.others
    message.point_pair_id_a = unsigned(others.id_A)
    message.point_pair_id_b = unsigned(others.id_B)
    message.point_pair_reason = uint8s(contacts.reasons)
    message.point_pair_p_wca = floats(others.p_WCa)
    message.point_pair_p_wcb = floats(others.p_WCb)
    message.point_pair_nhat_ba_w = floats(others.nhat_BA_W)
    message.point_pair_depth = floats(others.depth)
    message.point_pair_error_bound = floats(others.error_bound)


def _fill_surfaces(message: Any, surfaces: ContactSurfaceResults) -> None:
    """Fill a row for each surface."""
    message.id_a, message.id_b = unsigned(surfaces.id_M), unsigned(surfaces.id_N)
    message.area = floats(surfaces.areas)
    message.p_wc = floats(surfaces.centroids)
    message.centre_of_pressure = floats(surfaces.centres_of_pressure)
    message.force_on_a_w = floats(surfaces.forces_on_M_W)
    message.torque_on_a_wo_w = floats(surfaces.torques_on_M_Wo_W)
    message.max_pressure = floats(surfaces.max_pressures)
    message.faces = uint32s(np.diff(surfaces.face_offsets))


def _fill_polygons(message: Any, surfaces: ContactSurfaceResults, wanted: bool) -> None:
    """Fill the polygons; where they are not wanted, take out what a message had before."""
    points, pressures, ends = surfaces.polygon_arrays()
    message.has_polygons = wanted
    message.polygon_ends = uint32s(ends if wanted else ends[:0])
    message.p_wv = floats(points if wanted else points[:0])
    message.pressure = floats(pressures if wanted else pressures[:0])


def fill_nothing(message: Any) -> None:
    """Fill a message of a scene where no geometry has hydroelastic properties."""
    message.participants, message.has_polygons = 0, False
    for name in (
        *('id_a', 'id_b', 'area', 'p_wc', 'centre_of_pressure', 'force_on_a_w'),
        *('torque_on_a_wo_w', 'max_pressure', 'faces', 'polygon_ends', 'p_wv', 'pressure'),
        *('point_pair_id_a', 'point_pair_id_b', 'point_pair_reason', 'point_pair_p_wca'),
        *('point_pair_p_wcb', 'point_pair_nhat_ba_w', 'point_pair_depth'),
        'point_pair_error_bound',
    ):
        setattr(message, name, [])
