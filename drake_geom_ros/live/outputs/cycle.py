"""One cycle of the node: ask what is subscribed to, publish, report what ran and what did not."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from drake_geom_ros.geometry import METHODS, Effects, QueryObject, closing_speeds
from drake_geom_ros.live.conversions.fields import floats, unsigned
from drake_geom_ros.live.conversions.results import (
    fill_closing_speeds,
    fill_penetrations,
    fill_signed_distances,
)
from drake_geom_ros.live.outputs.contact_topic import PUBLISHED, ContactTopic
from drake_geom_ros.live.outputs.effects import NO_SUBSCRIBER, Beside, Effect
from drake_geom_ros.live.outputs.level_costs import LevelCosts
from drake_geom_ros.live.outputs.replays import Replays
from drake_geom_ros.live.outputs.rule_events import RuleEvents
from drake_geom_ros.live.scene.held_scene import HeldScene
from drake_geom_ros.live.scene.map_placing import map_ages, sensor_ages
from drake_geom_ros.live.scene.scene_view import SceneStamp

if TYPE_CHECKING:  # a node that asks for no second opinion loads nothing of it
    from drake_geom_ros.live.outputs.cross_check import CrossCheck


_NO_POSES = 'no pose message since the last cycle'
_STILL_NEAR = 'nothing moved far enough to bring other pairs near'
_ALL_COMPILED = 'every kernel of the scene is compiled'
_NONE_KEPT = 'no pair of two resting bodies'
_NOTHING_LEFT = 'no pair left to compute'
_OF_A_CYCLE = ('publish ~/penetrations', 'publish ~/signed_distances', PUBLISHED)
# Published below the node's name by each cycle; ~/contact_surfaces has a publisher of its own.
TOPICS = ('penetrations', 'signed_distances', 'cycle_report')
_OF_PAIRS = ('penetrations', 'signed_distances', 'contact_surfaces')


class ResultTopic(Protocol):
    """Publishes one type of messages, and makes what is filled for it."""

    def make_message(self) -> Any:
        """Return an empty message, which is filled and published again and again."""

    def publish(self, message: Any) -> None:
        """Publish such a message."""

    def get_subscription_count(self) -> int:
        """Return how many listen."""


class Cycle:
    """Runs cycles over four publishers; nothing is computed for nobody."""

    def __init__(
        self,
        publishers: Mapping[str, ResultTopic],
        costs: LevelCosts,
        replays: Replays,
        rules: RuleEvents,
        contacts: ContactTopic,
        beside: Sequence[Beside] = (),
    ) -> None:
        """Publish on ``publishers``: penetrations, signed_distances and cycle_report.

        ``contacts`` publishes contact surfaces; ``costs`` receive what was computed, ``replays``
        and ``rules`` what was answered.
        Work ``beside`` the cycles since the last report is in the next one.
        """
        self._beside = beside
        self._costs = costs
        self._replays = replays
        self.rules = rules
        self.contacts = contacts
        self._publishers = publishers
        # Filled anew each cycle: making one costs as much as filling it (30 us).
        self._messages = {name: each.make_message() for name, each in publishers.items()}
        self.cross_check: CrossCheck | None = None
        self.count = 0
        self.worst_error_bound = 0.0  # [m] of the last cycle that computed anything

    def run(
        self,
        scene: HeldScene,
        poses_taken: int,
        poses_seconds: float,
        max_distance: float,
        time_budget: float,
    ) -> None:
        """Answer for the poses of now; ``poses_seconds`` is what taking them cost.

        ``time_budget`` [s] limits the narrow phase; 0: it has none.
        """
        start = time.perf_counter()
        self.count += 1
        wanted = {
            name: publisher.get_subscription_count() > 0
            for name, publisher in self._publishers.items()
        }
        pressing = self.contacts.is_wanted
        if not any(wanted.values()) and not pressing:
            self.contacts.leave_out(None)
            self.rules.look_at(scene, None, 0.0)
            return
        moment, waiting = scene.moment(), scene.waiting()
        messages = [message for name, message in self._messages.items() if wanted[name]]
        waiting.tell_pairs(*messages, *([self.contacts.message] if pressing else ()))
        scene.model.context.set_detailed_effects(wanted['cycle_report'])
        effects = [Effect('poses', poses_taken, poses_seconds, '' if poses_taken else _NO_POSES)]
        computed = None
        wanted['contact_surfaces'] = pressing and self.contacts.has_participants(scene)
        if any(wanted[name] for name in _OF_PAIRS):
            computed, published = self._answer(scene, moment, wanted, max_distance, time_budget)
        else:
            self.rules.look_at(scene, None, 0.0)
            published = [_unpublished('penetrations'), _unpublished('signed_distances')]
        if not wanted['contact_surfaces']:
            published += self.contacts.leave_out(moment if pressing else None)
        if wanted['cycle_report']:
            effects += _computed(computed) + published
            effects += [beside.take() for beside in self._beside]
            seconds = poses_seconds + time.perf_counter() - start
            self._report(scene, moment, effects, computed, seconds, time_budget)

    def rehearse(self, query: QueryObject, max_distance: float, time_budget: float) -> None:
        """Ask a query object of a scene that is to come what cycles ask at present."""
        wanted = self._publishers['signed_distances'].get_subscription_count() > 0
        query.ComputeSignedDistancePairwiseClosestPoints(
            max_distance if wanted else 0.0, time_budget=time_budget
        )

    def _answer(
        self,
        scene: HeldScene,
        moment: SceneStamp,
        wanted: dict[str, bool],
        max_distance: float,
        time_budget: float,
    ) -> tuple[Effects, list[Effect]]:
        """Compute, publish what is wanted, and return what that took.

        One narrow phase serves all: a pair's depth is minus its signed distance.
        """
        published = [_unpublished('penetrations'), _unpublished('signed_distances')]
        query, twists = scene.query, scene.poses.twists()
        reach = max_distance if wanted['signed_distances'] else 0.0
        distances = query.ComputeSignedDistancePairwiseClosestPoints(
            reach, time_budget=time_budget
        )
        computed = query.effects()
        self._costs.count(computed.narrowphase_pairs, reach)
        self._replays.look_at(scene, distances, reach)
        self.worst_error_bound = float(distances.error_bound.max(initial=0.0))
        if wanted['penetrations'] or wanted['contact_surfaces']:
            overlaps = distances.penetrations()
        if wanted['penetrations']:
            message = self._messages['penetrations']
            fill_penetrations(message, overlaps)
            if twists is not None:
                fill_closing_speeds(message, closing_speeds(overlaps, twists))
            published[0] = self._publish('penetrations', moment)
        if wanted['signed_distances']:
            message = self._messages['signed_distances']
            fill_signed_distances(message, distances, max_distance)
            if twists is not None:
                fill_closing_speeds(message, closing_speeds(distances, twists))
            published[1] = self._publish('signed_distances', moment)
        if wanted['contact_surfaces']:
            published += self.contacts.answer(scene, moment, overlaps, time_budget)
        self.rules.look_at(scene, distances, reach)
        if self.cross_check is not None:
            self.cross_check.look_at(scene, distances, reach)
        return computed, published

    def _publish(self, name: str, moment: SceneStamp) -> Effect:
        start = time.perf_counter()
        message = self._messages[name]
        moment.stamp(message)
        self._publishers[name].publish(message)
        return Effect(f'publish ~/{name}', len(message.id_a), time.perf_counter() - start)

    def _report(
        self,
        scene: HeldScene,
        moment: SceneStamp,
        effects: list[Effect],
        computed: Effects | None,
        seconds: float,
        time_budget: float,
    ) -> None:
        """Publish the CycleReport of a cycle."""
        computed = computed or Effects()
        maps = map_ages(scene)
        cells = np.array([len(scene.maps.by_name[name].cells or ()) for name in maps])
        message = self._messages['cycle_report']
        moment.stamp_report(message)
        message.cycle = self.count
        message.seconds = seconds
        message.frames_moved = computed.frames_moved
        message.geometries_updated = computed.geometries_updated
        message.broadphase_pairs = computed.broadphase_pairs
        message.filtered_pairs = computed.filtered_pairs
        message.cached_pairs = computed.cached_pairs
        methods = sorted(computed.pairs_by_method)
        message.methods = [METHODS[m] for m in methods]
        message.method_pairs = [computed.pairs_by_method[m] for m in methods]
        message.unpublished_messages = sum(
            e.reason == NO_SUBSCRIBER and e.name in _OF_A_CYCLE for e in effects
        )
        message.effects = [e.name for e in effects]
        message.effect_ran = [not e.reason for e in effects]
        message.effect_counts = [e.count for e in effects]
        message.effect_seconds = [e.seconds for e in effects]
        message.effect_reasons = [e.reason for e in effects]
        costs = self._costs.last
        message.levels, message.level_seconds = costs.levels, floats(costs.seconds)
        message.level_samples = costs.samples
        message.maps = list(maps)
        message.map_ages = floats(np.array(list(maps.values())))
        message.map_cells = unsigned(cells)
        sensors = sensor_ages(scene)
        message.map_sensors = list(sensors)
        message.map_sensor_ages = floats(np.array(list(sensors.values())))
        message.map_shell_points = [scene.maps.by_name[name].shell.points for name in maps]
        message.time_budget = time_budget
        message.unrefined_pairs = computed.unrefined_pairs
        self._publishers['cycle_report'].publish(message)


def _unpublished(name: str) -> Effect:
    return Effect(f'publish ~/{name}', reason=NO_SUBSCRIBER)


def _computed(computed: Effects | None) -> list[Effect]:
    """Return the effects of a query, in the order in which they ran; None: it did not."""
    if computed is None:
        names = ('update', 'broadphase', 'filter', 'compile', 'cache', 'narrowphase')
        return [Effect(name, reason=NO_SUBSCRIBER) for name in names]
    near, kernels = computed.near_list_made, len(computed.kernels_compiled)
    cached, narrow = computed.cached_pairs, computed.narrowphase_pairs
    # What was done, how often, whether it ran, and why not.
    effects = (
        ('update', computed.geometries_updated, True, ''),
        ('broadphase', computed.broadphase_pairs, near, _STILL_NEAR),
        ('filter', computed.filtered_pairs, near, _STILL_NEAR),
        ('compile', kernels, kernels, _ALL_COMPILED),
        ('cache', cached, cached, _NONE_KEPT),
        ('narrowphase', narrow, narrow, _NOTHING_LEFT),
    )
    return [
        Effect(name, count, computed.seconds[name], '' if ran else reason)
        for name, count, ran, reason in effects
    ]
