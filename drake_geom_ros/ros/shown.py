"""Outputs for people: markers, poses for viewers, and Drake's visualiser."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import SimpleNamespace
from typing import TYPE_CHECKING

from drake_geom_msgs.msg import GeometryPoses as GeometryPosesMessage
from geometry_msgs.msg import Point
from rclpy.publisher import Publisher
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker, MarkerArray

from drake_geom_ros.live.outputs.effects import Beside, unheard
from drake_geom_ros.live.outputs.geometry_poses import GeometryPoses
from drake_geom_ros.live.outputs.marker_publisher import MarkerPublisher
from drake_geom_ros.live.outputs.stopping_poses import StoppingPoses
from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.ros.outputs.unlocked import LargePublisher
from drake_geom_ros.ros.parameters import ParameterStore

if TYPE_CHECKING:  # a node that is asked for no visualiser loads nothing of it
    from drake_geom_ros.live.outputs.visualizer import Visualizer

_POSES_PERIOD = 0.04  # [s] of ~/geometry_poses: for eyes
_WAYS_PERIOD = 0.1  # [s] of ~/stopping_poses
_NOT_DUE = 'no time for one since the last report'


class ShownOutputs:
    """Publishes markers and poses while ``active()``; ``beside`` has their rows of the report."""

    def __init__(
        self,
        live: LiveScene,
        publishers: Mapping[str, Publisher],
        settings: ParameterStore,
        active: Callable[[], bool],
        tell: Callable[[str], None],
    ) -> None:
        """Draw on ``publishers``, by topic; ``tell(text)`` logs what cannot be drawn.

        Raises GeometryError where ``lcm_url`` cannot be used.
        """
        self._settings = settings
        self._active = active
        markers = publishers['~/markers']
        poses, ways = publishers['~/geometry_poses'], publishers['~/stopping_poses']

        def why_no_markers() -> str:
            if not settings.values.publish_markers:
                return 'publish_markers is false'
            return unheard(markers, _NOT_DUE)

        self.beside = {
            'markers': Beside.publishing('markers', why_no_markers),
            'geometry_poses': Beside.publishing(
                'geometry_poses', lambda: unheard(poses, _NOT_DUE)
            ),
            'stopping_poses': Beside.publishing(
                'stopping_poses', lambda: unheard(ways, 'nothing brakes, or no time for one')
            ),
        }
        self._markers = MarkerPublisher(
            live,
            LargePublisher(markers),
            SimpleNamespace(
                Marker=Marker, MarkerArray=MarkerArray, Point=Point, ColorRGBA=ColorRGBA
            ),
            lambda: settings.values.max_distance,
            self.beside['markers'].did,
            tell,
        )
        self._poses = GeometryPoses(
            live, poses, GeometryPosesMessage, self.beside['geometry_poses'].did
        )
        self._ways = StoppingPoses(
            live, ways, GeometryPosesMessage, self.beside['stopping_poses'].did
        )
        self._visualizer: Visualizer | None = None
        if settings.values.lcm_url:
            # Only now: most nodes are asked for none.
            from drake_geom_ros.live.outputs.visualizer import Visualizer

            self._visualizer = Visualizer(live, settings.values.lcm_url)

    def tasks(self) -> list[tuple[float, Callable[[], None]]]:
        """Return what is due again and again, each with its period [s]."""
        return [
            (1.0 / self._settings.values.marker_rate, self._draw),
            (_POSES_PERIOD, self._pose),
            (_WAYS_PERIOD, self._pose_ways),
        ]

    def _draw(self) -> None:
        if not self._active():
            return
        if self._settings.values.publish_markers:
            self._markers.publish()
        else:
            self._markers.clear()
        if self._visualizer is not None:
            self._visualizer.draw()

    def _pose(self) -> None:
        if self._active():
            self._poses.publish()

    def _pose_ways(self) -> None:
        if self._active():
            self._ways.publish()
