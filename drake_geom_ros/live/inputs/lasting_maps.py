"""Static maps of topics: each stays where its frame is, though its message comes once.

A frame that rests may be posed again, as by a calibration. Its map is then taken again from the
message that it is of. A message that came before the pose of its frame waits for that. Where the
frame rests no more, the map waits for another message.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from drake_geom_ros.live.conversions.message_types import HeaderMessage
from drake_geom_ros.live.scene.feeds import Feed
from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.live.scene.map_placing import clear_maps
from drake_geom_ros.live.scene.moments import Hanging, resting_pose
from drake_geom_ros.math import RigidTransform


class _Last(NamedTuple):
    """The last message of a sensor."""

    header: HeaderMessage
    take: Callable[[], object]
    X_WF: RigidTransform | None  # of its frame, when it was taken; None: it waits for that


class LastingMaps:
    """Has static maps follow their frames."""

    def __init__(self, live: LiveScene, hanging: Hanging) -> None:
        """``hanging`` finds the frame of a header."""
        self._live, self._hanging = live, hanging
        self._last: dict[tuple[str, Feed], _Last] = {}  # by the name of the map and the sensor

    def take(
        self, name: str, publisher: str, header: HeaderMessage, take: Callable[[], object]
    ) -> None:
        """Take a message by ``take()``; raises what it raises, and ArgumentError as ``look``.

        A message whose frame does not rest is refused, and waits unless one of its sensor is held.
        """
        sensor = name, Feed(header.frame_id, publisher)
        last = self._last.get(sensor)
        try:
            X_WF = self._pose(header)
        except RuntimeError:
            if last is None or last.X_WF is None:
                self._last[sensor] = _Last(header, take, None)
            raise
        take()
        self._last[sensor] = _Last(header, take, X_WF)

    def look(self) -> None:
        """Take maps again whose frames were posed elsewhere, and those that waited for a pose.

        Raises RuntimeError where that cannot be, as for a frame that rests no more; its map, with
        the messages of all its sensors, waits from then on.
        """
        for sensor, last in list(self._last.items()):
            name, feed = sensor
            if last.X_WF is not None and not self._is_held(name):  # it was cleared
                self._last.pop(sensor, None)
                continue
            try:
                X_WF = self._pose(last.header)
            except RuntimeError:
                if last.X_WF is None:
                    continue  # it was refused for this when it came
                self.forget(name)
                clear_maps(self._live, [name])
                raise
            if last.X_WF is None or (X_WF.GetAsMatrix34() != last.X_WF.GetAsMatrix34()).any():
                self._last.pop(sensor, None)  # one that is refused is not tried again
                self.take(name, feed.publisher, last.header, last.take)

    def forget(self, name: str) -> None:
        """Follow no frame for a map any more."""
        self._last = {key: last for key, last in self._last.items() if key[0] != name}

    def _pose(self, header: HeaderMessage) -> RigidTransform:
        with self._live.reading() as scene:
            return resting_pose(scene, header, self._hanging)

    def _is_held(self, name: str) -> bool:
        with self._live.reading() as scene:
            seen_map = scene.maps.by_name.get(name)
            return seen_map is not None and seen_map.cells is not None
