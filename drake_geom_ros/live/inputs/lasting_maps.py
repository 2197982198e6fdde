"""Static maps of topics: each stays where its frame is, though its message comes once.

A frame that rests may be posed again, as by a calibration. Its map is then taken again from the
message that it is of. Where the frame rests no more, the map waits for another message.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from drake_geom_ros.live.conversions.message_types import HeaderMessage
from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.live.scene.map_placing import clear_maps
from drake_geom_ros.live.scene.moments import Hanging, resting_pose
from drake_geom_ros.math import RigidTransform


class _Taken(NamedTuple):
    """A message that a map is of."""

    header: HeaderMessage
    take: Callable[[], object]
    X_WF: RigidTransform  # of its frame, when it was taken


class LastingMaps:
    """Has static maps follow their frames."""

    def __init__(self, live: LiveScene, hanging: Hanging) -> None:
        """``hanging`` finds the frame of a header."""
        self._live, self._hanging = live, hanging
        self._taken: dict[str, _Taken] = {}  # by the name of the map

    def take(self, name: str, header: HeaderMessage, take: Callable[[], object]) -> None:
        """Take a message by ``take()``; raises what it raises, or ArgumentError as ``look``."""
        X_WF = self._pose(header)
        take()
        self._taken[name] = _Taken(header, take, X_WF)

    def look(self) -> None:
        """Take maps again whose frames were posed elsewhere.

        Raises RuntimeError where that cannot be, as for a frame that rests no more; its map waits
        from then on.
        """
        for name, taken in list(self._taken.items()):
            if not self._is_held(name):  # it was cleared, or its source removed
                del self._taken[name]
                continue
            try:
                X_WF = self._pose(taken.header)
                if (X_WF.GetAsMatrix34() != taken.X_WF.GetAsMatrix34()).any():
                    self.take(name, taken.header, taken.take)
            except RuntimeError:
                del self._taken[name]
                clear_maps(self._live, [name])
                raise

    def _pose(self, header: HeaderMessage) -> RigidTransform:
        with self._live.reading() as scene:
            return resting_pose(scene, header, self._hanging)

    def _is_held(self, name: str) -> bool:
        with self._live.reading() as scene:
            seen_map = scene.maps.by_name.get(name)
            return seen_map is not None and seen_map.cells is not None
