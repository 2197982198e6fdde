"""Contact surfaces of many states, one after another, as contexts of each would answer."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from drake_geom_ros.geometry._proximity.world.world import Named
from drake_geom_ros.geometry.model.frame_pose_vector import FramePoseVector, arrays_of
from drake_geom_ros.geometry.queries.contact_bodies import ContactBodies
from drake_geom_ros.geometry.queries.contact_queries import (
    CandidateSurfaces,
    Contacts,
    contacts_of,
)
from drake_geom_ros.geometry.queries.contact_surfaces import (
    ContactSurfaceResults,
    HydroelasticContactRepresentation,
)
from drake_geom_ros.geometry.queries.half_space_pairs import endless_overlaps
from drake_geom_ros.geometry.queries.packed_scene import PackedScene
from drake_geom_ros.geometry.queries.padding import Paddings
from drake_geom_ros.geometry.queries.query_results import PenetrationResults
from drake_geom_ros.math.array_types import Floats, Indices


class StateContacts:
    """Contacts of states in a private world, for one thread; ids are places in the scene.

    A state is a pose (7,) in its parent of each frame of ``rows`` (n,); all others stay.
    """

    def __init__(self, scene: PackedScene, paddings: Paddings | None) -> None:
        world, rows, body_of = scene.world(), scene.moved.copy(), scene.body_of
        self._world = world
        self._named = Named(world.frames.ids[rows], rows)
        self._bodies = ContactBodies(
            0, np.arange(len(body_of)), body_of, scene.bodies, scene.likeness, paddings
        )
        self._posed = self._bodies.posed(world.R_WGs, world.p_WGs)
        self._half_spaces = scene.half_spaces

    def of(
        self, pose: Floats, pairs: Indices, overlaps: Callable[[], PenetrationResults]
    ) -> Contacts:
        """Return the contacts of a state (n, 7) among ``pairs`` (k, 2), all that may overlap.

        ``overlaps`` is called only if a pair may lack a surface.
        """
        from drake_geom_ros.geometry._contact_surfaces.asking import surfaces_of

        world, bodies = self._world, self._bodies
        _, X_PFs = arrays_of(FramePoseVector.FromArrays(self._named.ids + 1, pose))
        world.pose(self._named, X_PFs)
        world.update()
        pairs = np.sort(pairs, axis=1)
        answer = surfaces_of(self._posed, pairs)
        surfaces = ContactSurfaceResults(answer, HydroelasticContactRepresentation.kPolygon)
        endless = endless_overlaps(world, self._half_spaces, bodies.paddings)
        return contacts_of(
            bodies, CandidateSurfaces(bodies.ids, pairs, answer, surfaces), endless, overlaps
        )
