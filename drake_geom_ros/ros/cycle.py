"""One cycle of the node: ask what is subscribed to, publish, report what ran and what did not."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

from drake_geom_ros.geometry import METHODS
from drake_geom_ros.ros.conversions import fill_penetrations, fill_signed_distances
from drake_geom_ros.ros.live_scene import LiveScene

NO_SUBSCRIBER = 'no subscriber'


@dataclass
class Effect:
    """One thing that a cycle may do: how much, how long, or why not."""

    name: str
    count: int = 0
    seconds: float = 0.0
    reason: str = ''


class Cycle:
    """Runs cycles of a live scene over three publishers; nothing is computed for nobody."""

    def __init__(
        self, live: LiveScene, messages: Any, world_frame: str, publishers: dict[str, Any]
    ) -> None:
        """Publish on ``publishers``: penetrations, signed_distances and cycle_report."""
        self._live = live
        self._messages = messages
        self._world_frame = world_frame
        self._publishers = publishers
        self.count = 0

    def run(self, poses_taken: int, poses_seconds: float, max_distance: float) -> None:
        """Answer for the poses of now; ``poses_seconds`` is what taking them cost."""
        start = time.perf_counter()
        self.count += 1
        wanted = {
            name: publisher.get_subscription_count() > 0
            for name, publisher in self._publishers.items()
        }
        effects = [Effect('poses', poses_taken, poses_seconds)]
        query = self._live.query
        if wanted['signed_distances'] or wanted['penetrations']:
            # One narrow phase serves both: a pair's depth is minus its signed distance.
            reach = max_distance if wanted['signed_distances'] else 0.0
            distances = query.ComputeSignedDistancePairwiseClosestPoints(reach)
            computed = query.effects()
            effects += _computed(computed)
            if wanted['penetrations']:
                message = self._message(self._messages.PenetrationPairs)
                fill_penetrations(message, distances.penetrations())
                effects.append(self._publish('penetrations', message, len(message.id_a)))
            if wanted['signed_distances']:
                message = self._message(self._messages.SignedDistancePairs)
                fill_signed_distances(message, distances, max_distance)
                effects.append(self._publish('signed_distances', message, len(message.id_a)))
        else:
            computed = None
            effects += [
                Effect(name, reason=NO_SUBSCRIBER)
                for name in ('update', 'broadphase', 'filter', 'compile', 'narrowphase')
            ]
        for name in ('penetrations', 'signed_distances'):
            if not wanted[name]:
                effects.append(Effect(f'publish ~/{name}', reason=NO_SUBSCRIBER))
        if wanted['cycle_report']:
            seconds = poses_seconds + time.perf_counter() - start
            self._publishers['cycle_report'].publish(self._report(effects, computed, seconds))

    def _message(self, message_class: Any) -> Any:
        """Return a message of a kind, stamped."""
        message = message_class()
        self.stamp(message)
        return message

    def stamp(self, message: Any) -> None:
        """Say in a result which poses and which scene it answers for."""
        message.header.frame_id = self._world_frame
        if self._live.newest_stamp is not None:
            message.header.stamp = self._live.newest_stamp
        message.scene_version = self._live.version
        message.oldest_pose_age = self._live.oldest_pose_age()

    def _publish(self, name: str, message: Any, count: int) -> Effect:
        start = time.perf_counter()
        self._publishers[name].publish(message)
        return Effect(f'publish ~/{name}', count, time.perf_counter() - start)

    def _report(self, effects: list[Effect], computed: Any, seconds: float) -> Any:
        """Return the CycleReport message of a cycle."""
        message = self._message(self._messages.CycleReport)
        message.cycle = self.count
        message.seconds = seconds
        if computed is not None:
            message.frames_moved = computed.frames_moved
            message.geometries_updated = computed.geometries_updated
            message.broadphase_pairs = computed.broadphase_pairs
            message.filtered_pairs = computed.filtered_pairs
            methods = sorted(computed.pairs_by_method)
            message.methods = [METHODS[m] for m in methods]
            message.method_pairs = [computed.pairs_by_method[m] for m in methods]
        message.unpublished_messages = sum(
            e.reason == NO_SUBSCRIBER and e.name.startswith('publish') for e in effects
        )
        message.effects = [e.name for e in effects]
        message.effect_ran = [not e.reason for e in effects]
        message.effect_counts = [e.count for e in effects]
        message.effect_seconds = [e.seconds for e in effects]
        message.effect_reasons = [e.reason for e in effects]
        return message


def _computed(computed: Any) -> list[Effect]:
    """Return the effects of a query, in the order in which they ran."""
    seconds = computed.seconds
    compiled = Effect('compile', len(computed.kernels_compiled), seconds['compile'])
    if not computed.kernels_compiled:
        compiled = Effect('compile', reason='every kernel of the scene is compiled')
    return [
        Effect('update', computed.geometries_updated, seconds['update']),
        Effect('broadphase', computed.broadphase_pairs, seconds['broadphase']),
        Effect('filter', computed.filtered_pairs, seconds['filter']),
        compiled,
        Effect('narrowphase', computed.narrowphase_pairs, seconds['narrowphase']),
    ]
