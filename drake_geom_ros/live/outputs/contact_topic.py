"""~/contact_surfaces: where bodies press each other, of a cycle."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from drake_geom_ros.common.counting import counted
from drake_geom_ros.geometry import PenetrationResults, QueryObject
from drake_geom_ros.geometry.queries.contact_queries import Contacts
from drake_geom_ros.live.conversions.contact_surfaces import fill_contact_surfaces, fill_nothing
from drake_geom_ros.live.outputs.effects import NO_SUBSCRIBER, Beside, Effect
from drake_geom_ros.live.outputs.long_contacts import ContactRequest, LongContacts
from drake_geom_ros.live.scene.held_scene import HeldScene
from drake_geom_ros.live.scene.scene_view import SceneStamp

COMPUTED, PUBLISHED = 'contact surfaces', 'publish ~/contact_surfaces'
NOBODY = 'no geometry has hydroelastic properties'
GOES_ON = 'it takes long, and goes on beside the cycles'
_UNASKED = tuple(Effect(name, reason=NO_SUBSCRIBER) for name in (COMPUTED, PUBLISHED))
_SHORT = 0.005  # [s]: what takes less is computed in the cycle again


class ContactTopic:
    """Computes and publishes the contact surfaces of cycles, while somebody listens.

    In the cycle, as long as they take few steps; those that take more are computed beside the
    cycles, without the lock of the scene, of the newest moment each time.
    """

    def __init__(
        self,
        publisher: Any,
        make_message: Callable[[], Any],
        polygons: Callable[[], bool],
        must_stop: Callable[[], bool],
        failed: Callable[[Exception], None],
    ) -> None:
        """``polygons()`` returns whether they are wanted.

        Nothing is computed beside the cycles while ``must_stop()``; ``failed`` takes what nobody
        foresaw there.
        """
        self._publisher = publisher
        self.message, self._message_beside = make_message(), make_message()
        self._polygons = polygons
        self._long = LongContacts(self._prepare_beside, must_stop, failed)
        self._takes_long = False
        self._beside = [Beside(name, lambda: GOES_ON) for name in (COMPUTED, PUBLISHED)]
        self.told = 'not asked for'  # what became of the last cycle, in words

    @property
    def is_wanted(self) -> bool:
        """True if the topic has a subscriber."""
        return bool(self._publisher.get_subscription_count() > 0)

    @staticmethod
    def has_participants(scene: HeldScene) -> bool:
        """Return whether any geometry has hydroelastic properties."""
        return len(scene.query.hydroelastic_geometries()) > 0

    def close(self) -> None:
        """Publish nothing any more."""
        self._long.close()

    def leave_out(self, moment: SceneStamp | None) -> list[Effect]:
        """Compute nothing; return the row of the report that says so.

        Nobody listens, or, at a ``moment``, no geometry takes part, which the message says.
        """
        self._long.forget()
        if moment is None:
            self.told = 'not asked for'
            return list(_UNASKED)
        self.told = NOBODY
        fill_nothing(self.message)
        return [Effect(COMPUTED, reason=NOBODY), self._publish(self.message, moment)]

    def answer(
        self,
        scene: HeldScene,
        moment: SceneStamp,
        overlaps: PenetrationResults,
        time_budget: float,
    ) -> list[Effect]:
        """Publish the surfaces of now, and the pairs among ``overlaps`` that have none.

        ``time_budget`` [s] limits them; 0: it does not.
        """
        start = time.perf_counter()
        self._takes_long = self._takes_long or self._long.is_busy
        if not self._takes_long:
            contacts = scene.query.contacts(overlaps=overlaps, at_once=True)
            seconds = time.perf_counter() - start
            if not contacts.late() or 0.0 < time_budget < seconds:
                self._fill(self.message, scene.query, contacts)
                computed = Effect(COMPUTED, len(contacts.surfaces), time.perf_counter() - start)
                return [computed, self._publish(self.message, moment)]
            self._takes_long = True
        request = scene.view(), moment, scene.waiting(), overlaps, time_budget
        self._long.ask(ContactRequest(*request, began=time.monotonic()))
        return [beside.take() for beside in self._beside]

    def _prepare_beside(
        self, request: ContactRequest, contacts: Contacts, seconds: float
    ) -> Callable[[], None]:
        """Return what publishes surfaces that were computed beside the cycles."""
        message = self._message_beside
        request.waiting.tell_pairs(message)
        self._fill(message, request.view.query, contacts)

        def publish() -> None:
            # The poses have grown older since the cycle.
            moment = request.moment.after(time.monotonic() - request.began)
            published = self._publish(message, moment)
            self._beside[0].did(len(contacts.surfaces), seconds)
            self._beside[1].did(published.count, published.seconds)
            self._takes_long = seconds > _SHORT

        return publish

    def _fill(self, message: Any, query: QueryObject, contacts: Contacts) -> None:
        """Fill a message, and say in words what became of the cycle."""
        participants, count = len(query.hydroelastic_geometries()), len(contacts.surfaces)
        fill_contact_surfaces(message, contacts, participants, self._polygons())
        others, late = len(contacts.others), contacts.late()
        overlap = 'overlaps' if others == 1 else 'overlap'
        self.told = f'{count}, and {counted(others, "pair")} that {overlap} without'
        self.told += f', of which {late} for want of time' if late else ''

    def _publish(self, message: Any, moment: SceneStamp) -> Effect:
        start = time.perf_counter()
        moment.stamp(message)
        self._publisher.publish(message)
        return Effect(PUBLISHED, len(message.id_a), time.perf_counter() - start)
