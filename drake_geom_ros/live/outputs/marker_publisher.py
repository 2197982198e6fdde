"""Publishes ~/markers: everything to a new subscriber, then what changed."""

from __future__ import annotations

import time
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

from drake_geom_ros.common.counting import counted
from drake_geom_ros.geometry import GeometryError, GeometryId
from drake_geom_ros.live.outputs.markers import DELETE_ALL, MarkerPart, MarkerWriter, parts_of
from drake_geom_ros.live.outputs.obstacle_markers import ObstacleMarkers
from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.live.scene.scene_view import SceneView
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.viewing.looks import LAYERS, Colour, looks_of
from drake_geom_ros.viewing.patches import Patches

Key = tuple[str, GeometryId]
_MOST_SECONDS = 0.2  # [s] for contact surfaces: other answers wait for what is drawn


class MarkerPublisher:
    """Draws the present scene when called, from a view: the cycle does not wait.

    What stands still is sent once, and again to all when somebody new listens.
    """

    def __init__(
        self,
        live: LiveScene,
        publisher: Any,
        types: SimpleNamespace,
        max_distance: Callable[[], float],
        did: Callable[[int, float], None],
        tell: Callable[[str], None] = lambda text: None,
    ) -> None:
        """``types`` holds Marker, MarkerArray, Point and ColorRGBA.

        Pairs within ``max_distance()`` [m] are drawn.
        ``did(count, seconds)`` is called for each message: how many markers, how long it took;
        ``tell(text)`` for what cannot be drawn, once a version of the scene.
        """
        self._did = did
        self._tell = tell
        self._live = live
        self._publisher = publisher
        self._types = types
        self._max_distance = max_distance
        self._obstacles = ObstacleMarkers(live)
        self._listeners = 0
        self._shows_surfaces = False
        self._version = self._late_version = -1
        self._looks: dict[Key, tuple[list[MarkerPart], Colour]] = {}
        self._shown: dict[Key, tuple[int, bytes]] = {}

    def publish(self) -> None:
        """Publish what changed, if somebody listens."""
        listeners = self._publisher.get_subscription_count()
        if listeners > self._listeners:
            self._shown.clear()
            self._obstacles.forget()
        self._listeners = listeners
        if not listeners:
            return
        start = time.perf_counter()
        view = self._live.view()
        stamp = view.moment.newest_stamp or self._types.Marker().header.stamp
        writer = MarkerWriter(self._types, view.moment.world_frame, stamp)
        results = view.query.ComputeSignedDistancePairwiseClosestPoints(self._max_distance())
        markers = self._geometry(view, writer) + writer.pairs(results)
        markers += self._obstacles.changed(writer)
        if len(view.query.hydroelastic_geometries()):
            contacts = view.query.contacts(
                overlaps=results.penetrations(), time_budget=_MOST_SECONDS
            )
            if (late := contacts.late()) and self._late_version != self._version:
                self._late_version = self._version
                self._tell(
                    f'the contact surfaces of {counted(late, "pair")} are not in ~/markers: they '
                    f'take longer than {_MOST_SECONDS:g} s; a larger resolution_hint would help'
                )
            markers.append(writer.surfaces(Patches.of(contacts.surfaces)))
            self._shows_surfaces = True
        elif self._shows_surfaces:
            markers.append(writer.surfaces(Patches.none()))
            self._shows_surfaces = False
        self._publisher.publish(self._types.MarkerArray(markers=markers))
        self._did(len(markers), time.perf_counter() - start)

    def clear(self) -> None:
        """Let everything vanish that is shown."""
        if self._shown:
            marker = self._types.Marker(action=DELETE_ALL)
            marker.header.frame_id = self._live.world_frame
            self._publisher.publish(self._types.MarkerArray(markers=[marker]))
            self._shown.clear()
            self._obstacles.forget()

    def _geometry(self, view: SceneView, writer: MarkerWriter) -> list[Any]:
        """Return the markers of geometry that is new, moved, changed or gone."""
        self._bring_up_to_date(view)
        markers = []
        for key in [key for key in self._shown if key not in self._looks]:
            count, _ = self._shown.pop(key)
            markers += writer.removed(*key, range(count))
        for key, (parts, colour) in self._looks.items():
            if not view.query.is_placed(key[1]):
                count, _ = self._shown.pop(key, (0, b''))  # a body that left
                markers += writer.removed(*key, range(count))
                continue
            X_WG: RigidTransform = view.query.X_WG(key[1])
            state = len(parts), X_WG.ToArray().tobytes()
            before = self._shown.get(key, (0, b''))
            if before != state:
                markers += writer.removed(*key, range(len(parts), before[0]))
                markers += writer.geometry(*key, parts, colour, X_WG)
                self._shown[key] = state
        return markers

    def _bring_up_to_date(self, view: SceneView) -> None:
        """Look shapes and colours up, once a version of the scene; all are sent again then."""
        if self._version == view.moment.version:
            return
        inspector = view.query.inspector()
        self._looks, maps = {}, self._obstacles.geometries()
        for look in looks_of(inspector):
            if look.geometry in maps:
                continue
            try:
                parts = parts_of(look.shape, look.solid)
            except (GeometryError, OSError) as error:
                self._tell(f'{look.name} is left out of ~/markers: {error}')
                continue
            self._looks[LAYERS[look.role], look.geometry] = parts, look.colour
        self._shown = {key: (count, b'') for key, (count, _) in self._shown.items()}
        self._version = view.moment.version
