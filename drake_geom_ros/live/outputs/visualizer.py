"""Sends the live scene to Drake's visualiser; loaded by a node whose ``lcm_url`` is set."""

from __future__ import annotations

import time

from drake_geom_ros.geometry import DrakeVisualizerPublisher, Role
from drake_geom_ros.geometry.visualizer.drake_visualizer import open_lcm
from drake_geom_ros.live.scene.live_scene import LiveScene

# [s] after which the scene is loaded again: LCM keeps nothing for those who come later. A
# visualiser that has it already ignores that.
_AGAIN = 5.0


class Visualizer:
    """Draws the present scene when called, from a view: the cycle does not wait."""

    def __init__(self, live: LiveScene, url: str) -> None:
        """Send to an LCM URL; raises GeometryError where that cannot be."""
        self._live = live
        self._lcm = open_lcm(url)
        self._publisher: DrakeVisualizerPublisher | None = None
        self._role = Role.kIllustration
        self._loaded = 0.0  # [s] of the steady clock

    def draw(self) -> None:
        """Send where everything is, and first, where it is time to, what there is."""
        view, now = self._live.view(), time.monotonic()
        role = Role.kIllustration
        if not view.query.inspector().NumGeometriesWithRole(role):
            role = Role.kProximity  # a scene that nobody made for eyes
        if self._publisher is None or role is not self._role or now - self._loaded > _AGAIN:
            self._publisher = DrakeVisualizerPublisher(self._lcm, role)
            self._publisher.set_publish_period(0.0)
            self._role, self._loaded = role, now
        self._publisher.Publish(view.context, now)
