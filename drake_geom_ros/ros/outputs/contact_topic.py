"""~/contact_surfaces: where bodies press each other, of a cycle. No ROS import."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from drake_geom_ros.common.counting import counted
from drake_geom_ros.geometry import PenetrationResults
from drake_geom_ros.ros.conversions.contact_surfaces import fill_contact_surfaces, fill_nothing
from drake_geom_ros.ros.outputs.effects import NO_SUBSCRIBER, Effect
from drake_geom_ros.ros.scene.held_scene import HeldScene
from drake_geom_ros.ros.scene.scene_view import SceneStamp

COMPUTED, PUBLISHED = 'contact surfaces', 'publish ~/contact_surfaces'
NOBODY = 'no geometry has hydroelastic properties'


class ContactTopic:
    """Computes and publishes the contact surfaces of cycles, while somebody listens."""

    def __init__(self, publisher: Any, message: Any, polygons: Callable[[], bool]) -> None:
        """``message`` is filled anew each time; ``polygons()`` tells whether they are wanted."""
        self._publisher = publisher
        self.message = message
        self._polygons = polygons
        self.told = 'not asked for'  # what became of the last cycle, in words

    @property
    def is_wanted(self) -> bool:
        """Whether somebody listens."""
        return bool(self._publisher.get_subscription_count() > 0)

    @staticmethod
    def has_participants(scene: HeldScene) -> bool:
        """Tell whether any geometry has hydroelastic properties."""
        return len(scene.query.hydroelastic_geometries()) > 0

    def leave_out(self, moment: SceneStamp | None) -> list[Effect]:
        """Compute nothing; return what is told of that.

        Nobody listens, or, at a ``moment``, no geometry takes part, which the message says.
        """
        if moment is None:
            self.told = 'not asked for'
            return [Effect(name, reason=NO_SUBSCRIBER) for name in (COMPUTED, PUBLISHED)]
        self.told = NOBODY
        fill_nothing(self.message)
        return [Effect(COMPUTED, reason=NOBODY), self._publish(moment)]

    def answer(
        self, scene: HeldScene, moment: SceneStamp, overlaps: PenetrationResults
    ) -> list[Effect]:
        """Publish the surfaces of now, and the pairs among ``overlaps`` that have none."""
        start = time.perf_counter()
        query = scene.query
        contacts = query.contacts(overlaps=overlaps)
        participants, count = len(query.hydroelastic_geometries()), len(contacts.surfaces)
        fill_contact_surfaces(self.message, contacts, participants, self._polygons())
        others = len(contacts.others)
        overlap = 'overlaps' if others == 1 else 'overlap'
        self.told = f'{count}, and {counted(others, "pair")} that {overlap} without'
        computed = Effect(COMPUTED, count, time.perf_counter() - start)
        return [computed, self._publish(moment)]

    def _publish(self, moment: SceneStamp) -> Effect:
        start = time.perf_counter()
        moment.stamp(self.message)
        self._publisher.publish(self.message)
        return Effect(PUBLISHED, len(self.message.id_a), time.perf_counter() - start)
