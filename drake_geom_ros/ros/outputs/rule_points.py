"""Publishes the nearest points of each proximity rule, for tools that know no types of ours.

``~/proximity_rules/NAME/point_a`` and ``point_b`` are ``geometry_msgs/PointStamped`` in the world,
beside the cycle: nothing for nobody, and only what was measured since the last look.
"""

from __future__ import annotations

import re
import time
from typing import Any

from geometry_msgs.msg import PointStamped

from drake_geom_ros.live.outputs.effects import NO_SUBSCRIBER, Beside
from drake_geom_ros.live.scene.live_scene import LiveScene

PERIOD = 0.05  # [s] between two looks
_NO_TOKEN = re.compile(r'[^A-Za-z0-9]+')
_ENDS = ('point_a', 'point_b')


class RulePoints:
    """Opens two topics for each rule, and publishes while somebody listens."""

    def __init__(self, live: LiveScene, surface: Any, profile: Any) -> None:
        self._live, self._surface, self._profile = live, surface, profile
        self._open: dict[str, tuple[Any, Any]] = {}  # publishers by the name of the rule
        self._published: object = None  # the measurement that was published last
        self.beside = Beside.publishing('proximity_rules', self._why_not)

    def _why_not(self) -> str:
        return NO_SUBSCRIBER if self._open else 'no proximity rule'

    def publish(self) -> None:
        """Publish the nearest points of rules that somebody listens to, if they are new."""
        with self._live.reading() as scene:
            names = [rule.name for rule in scene.rules.rules]
            self._follow(names)
            heard = [name for name in names if self._is_heard(name)]
            if not heard or scene.rules.measurement is self._published:
                return
            start = time.perf_counter()
            self._published = scene.rules.measurement
            points = dict(zip(names, scene.rules.nearest_points(), strict=True))
            moment = scene.moment()
        count = 0
        for name in heard:
            pair = points[name]
            if pair is not None:
                count += 1
                for publisher, p_WC in zip(self._open[name], pair, strict=True):
                    message = PointStamped()
                    moment.stamp_poses(message)
                    message.point.x, message.point.y, message.point.z = p_WC.tolist()
                    publisher.publish(message)
        self.beside.did(count, time.perf_counter() - start)

    def _is_heard(self, name: str) -> bool:
        publishers = self._open.get(name, ())
        return any(publisher.get_subscription_count() for publisher in publishers)

    def _follow(self, names: list[str]) -> None:
        """Open and close topics as rules come and go."""
        for name in [name for name in self._open if name not in names]:
            for publisher in self._open.pop(name):
                self._surface.close_publisher(publisher)
        used = {token(name) for name in self._open}
        for name in names:
            # Of two rules whose names are one as parts of a topic, the first has the topics.
            if name not in self._open and token(name) not in used:
                used.add(token(name))
                base = f'~/proximity_rules/{token(name)}'
                self._open[name] = tuple(
                    self._surface.publisher(
                        PointStamped, f'{base}/{end}', self._profile, comes_and_goes=True
                    )
                    for end in _ENDS
                )


def token(name: str) -> str:
    """Return the name of a rule as a part of a topic: letters, digits and single underscores."""
    part = _NO_TOKEN.sub('_', name).strip('_')
    return part if part[:1].isalpha() else f'rule_{part}'
