"""The node `scene_graph`: keeps a scene, takes poses, answers services, publishes results.

A managed life-cycle node: configure loads the scene and compiles its kernels, activate publishes,
deactivate stops publishing and keeps the scene, cleanup forgets it. It configures and activates
itself unless the parameter ``autostart`` is false.

Four threads share the work (see ``spinning``): one takes poses and runs the cycles, one answers
queries on snapshots of the scene and draws, one reads what may take long (meshes, scene files,
robot descriptions) and compiles for it, and the main one does the rest: other changes of the
scene, parameters, the life cycle, diagnostics.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from functools import partial
from types import SimpleNamespace
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from drake_geom_msgs import msg as messages
from geometry_msgs.msg import Point
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.clock import Clock, ClockType
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from rclpy.qos import QoSProfile
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import String
from visualization_msgs.msg import Marker, MarkerArray

from drake_geom_ros.ros.conversions.file_access import FileAccess
from drake_geom_ros.ros.conversions.scene import fill_scene
from drake_geom_ros.ros.guard import Guard
from drake_geom_ros.ros.inputs.point_queries import PointQueries
from drake_geom_ros.ros.inputs.robot_description import RobotInput
from drake_geom_ros.ros.inputs.tf_input import TfInput
from drake_geom_ros.ros.outputs import level_costs, replays
from drake_geom_ros.ros.outputs.cycle import Cycle
from drake_geom_ros.ros.outputs.diagnostics import Diagnostics
from drake_geom_ros.ros.outputs.level_costs import LevelCosts
from drake_geom_ros.ros.outputs.marker_publisher import MarkerPublisher
from drake_geom_ros.ros.outputs.replays import Replays
from drake_geom_ros.ros.parameters import NodeParameters, ParameterRefusedError, ParameterStore
from drake_geom_ros.ros.scene.live_scene import LiveScene
from drake_geom_ros.ros.services.table import BESIDE, CHANGES, LOADING, answer
from drake_geom_ros.ros.spinning import run_node
from drake_geom_ros.ros.surface import Surface, latched, results, sensor_data, transforms
from drake_geom_ros.scene_files import read_scene

_HOUSEKEEPING_PERIOD = 0.1  # [s] leases, changes of the scene that were not told yet
# [-] times what it took to publish ~/scene pass before the next: a large one costs a tenth.
_SCENE_PAUSE = 10.0
_DIAGNOSTICS_PERIOD = 1.0  # [s]
_LOG_PERIOD = 5.0  # [s] at most one line of a kind in this time


class SceneGraphNode(LifecycleNode):
    """The geometry service; see docs/reference.md for topics, services and parameters."""

    def __init__(self, **kwargs) -> None:
        super().__init__('scene_graph', **kwargs)
        self._stream = MutuallyExclusiveCallbackGroup()
        self._beside = MutuallyExclusiveCallbackGroup()
        self._loading = MutuallyExclusiveCallbackGroup()
        self.threaded_groups = (self._stream, self._beside, self._loading)
        self._settings = ParameterStore(self, self._parameters_changed)
        values = self._settings.values
        self._live = LiveScene(values.accuracy, self._now, values.world_frame)
        self._live.files = FileAccess(values.mesh_roots, values.scene_file)
        self._diagnostics = Diagnostics(self.get_fully_qualified_name())
        self._guard = Guard(self.get_logger(), self._diagnostics)
        self._surface = Surface(self)
        self._cycle: Cycle | None = None
        self._tf: TfInput | None = None
        self._cycle_timer = None
        self._active = False
        if values.autostart:
            # After the constructor, when the executor spins, so that a launch file sees it.
            steady = Clock(clock_type=ClockType.STEADY_TIME)
            self._autostart = self.create_timer(0.0, self._start_by_itself, clock=steady)

    def _now(self) -> float:
        """Return the node's time [s] (simulated when use_sim_time is set)."""
        return self.get_clock().now().nanoseconds * 1e-9

    def _start_by_itself(self) -> None:
        self.destroy_timer(self._autostart)
        if self.trigger_configure() == TransitionCallbackReturn.SUCCESS:
            self.trigger_activate()

    # Life cycle.

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Load the scene, compile its kernels, open topics and services."""
        values = self._settings.values
        start = time.perf_counter()
        try:
            if values.scene_file:
                frames, geometries = self._live.add(read_scene(values.scene_file))
                self.get_logger().info(f'loaded {frames} frames and {geometries} geometries')
            kernels = self._live.compile_kernels()
            self._open(values)
        except Exception as error:
            # A scene that cannot be loaded, a QoS override or the name of a topic that cannot be;
            # rclpy would drop it without a word.
            self.get_logger().error(f'not configured: {str(error) or repr(error)}')
            self._forget()
            return TransitionCallbackReturn.FAILURE
        seconds = time.perf_counter() - start
        self.get_logger().info(
            f'configured in {seconds:.1f} s, {len(kernels)} kernels compiled or loaded'
        )
        return TransitionCallbackReturn.SUCCESS

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Publish from now on."""
        self._active = True
        self._guard.attempt(self._publish_scene)
        return super().on_activate(state)

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Stop publishing, keep the scene and go on taking poses."""
        with self._live.lock:
            self._active = False
        return super().on_deactivate(state)

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Close topics and services and forget the scene."""
        self._forget()
        return TransitionCallbackReturn.SUCCESS

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Close topics and services."""
        self._forget()
        return TransitionCallbackReturn.SUCCESS

    def _forget(self) -> None:
        with self._live.lock:
            self._active = False
            self._set_rate(0.0)
            self._surface.close()
            self._live.clear()
            self._cycle = self._tf = None

    def _open(self, values: NodeParameters) -> None:
        """Open topics, services and timers."""
        surface = self._surface
        self._open_outputs()
        self._listen(
            messages.FramePoses, '~/frame_poses', self._on_poses, sensor_data(), self._stream
        )
        if values.use_tf:
            self._open_tf()
        if values.robot_description_topic:
            self._robot = RobotInput(self._live)
            topic = values.robot_description_topic
            self._listen(String, topic, self._on_robot, latched(), self._loading)
        for name, kind, handler in CHANGES:
            surface.service(kind, f'~/{name}', partial(self._change, handler))
        for services, group in ((BESIDE, self._beside), (LOADING, self._loading)):
            for name, kind, handler in services:
                surface.service(kind, f'~/{name}', partial(self._serve, handler), group)
        self._set_rate(values.rate)
        for period, task, group in (
            (1.0 / values.marker_rate, self._draw, self._beside),
            (level_costs.PERIOD, self._costs.measure, self._beside),
            (replays.PERIOD, self._write_replays, self._beside),
            (_HOUSEKEEPING_PERIOD, self._keep_house, None),
            (_DIAGNOSTICS_PERIOD, self._publish_diagnostics, None),
        ):
            surface.timer(period, partial(self._guard.attempt, task), group)

    def _open_outputs(self) -> None:
        """Open the topics to publish on, and what publishes there."""
        live, surface = self._live, self._surface
        publishers = {
            name: surface.publisher(message_class, f'~/{name}', results())
            for name, message_class in (
                ('penetrations', messages.PenetrationPairs),
                ('signed_distances', messages.SignedDistancePairs),
                ('cycle_report', messages.CycleReport),
            )
        }
        self._costs = LevelCosts(live, publishers['cycle_report'])
        self._replays = Replays(live, self._replay_settings)
        self._cycle = Cycle(live, messages, publishers, self._costs, self._replays)
        self._taken = (0, 0.0)
        self._scene_publisher = surface.publisher(messages.Scene, '~/scene', latched())
        self._published_version, self._next_scene = -1, 0.0
        self._diagnostics_publisher = surface.publisher(DiagnosticArray, '/diagnostics', results())
        self._markers = MarkerPublisher(
            live,
            surface.publisher(MarkerArray, '~/markers', results()),
            SimpleNamespace(Marker=Marker, MarkerArray=MarkerArray, Point=Point),
            lambda: self._settings.values.max_distance,
        )
        distances = surface.publisher(messages.PointDistances, '~/point_distances', results())
        points = PointQueries(
            live,
            distances,
            messages.PointDistances,
            lambda: self._settings.values.point_threshold,
        )
        self._listen(PointCloud2, '~/query_points', points.take, sensor_data(), self._beside)

    def _open_tf(self) -> None:
        """Listen to TF, whose package not every installation has."""
        from tf2_msgs.msg import TFMessage

        self._tf = TfInput(self._live, self._now)
        for static, topic in ((True, '/tf_static'), (False, '/tf')):
            take = partial(self._on_transforms, static)
            profile = transforms(static=static)
            self._listen(TFMessage, topic, take, profile, self._stream)

    def _set_rate(self, rate: float) -> None:
        """Run cycles by a timer, or for rate 0 with each pose message."""
        if self._cycle_timer is not None:
            self.destroy_timer(self._cycle_timer)
            self._cycle_timer = None
        if rate > 0.0:
            self._cycle_timer = self.create_timer(
                1.0 / rate,
                partial(self._guard.attempt, self._cycle_is_due),
                callback_group=self._stream,
            )

    def _parameters_changed(self, old: NodeParameters, new: NodeParameters) -> None:
        with self._live.lock:
            if new.accuracy != old.accuracy:
                self._live.set_accuracy(new.accuracy)
            if new.mesh_roots != old.mesh_roots:
                self._live.files = FileAccess(new.mesh_roots, new.scene_file)
            if new.rate != old.rate and self._cycle is not None:
                self._set_rate(new.rate)

    # What comes in.

    def _listen(
        self, kind: Any, topic: str, take: Callable[[Any], Any], profile: QoSProfile, group: Any
    ) -> None:
        """Listen to a topic whose messages ``take`` may refuse by an exception."""
        guarded = partial(self._guard.take, topic.removeprefix('~/'), take)
        self._surface.subscription(kind, topic, guarded, profile, group)

    def _on_poses(self, message: messages.FramePoses) -> None:
        start = time.perf_counter()
        with self._live.lock:
            self._posed(self._live.take_poses(message), start)
        self._diagnostics.take(time.perf_counter() - start)

    def _on_transforms(self, static: bool, message: Any) -> None:
        start = time.perf_counter()
        with self._live.lock:
            frames = self._tf.take(message, static=static) if self._tf is not None else 0
            if frames:
                self._posed(frames, start)
        if frames:
            self._diagnostics.take(time.perf_counter() - start)

    def _on_robot(self, message: String) -> None:
        if done := self._robot.take(message.data):
            self.get_logger().info(done)

    def _posed(self, frames: int, start: float) -> None:
        """Run a cycle for poses whose taking began at ``start``, or leave it to the timer."""
        frames_before, seconds = self._taken
        self._taken = (frames_before + frames, seconds + time.perf_counter() - start)
        if self._settings.values.rate == 0.0:
            self._run_cycle()

    def _cycle_is_due(self) -> None:
        with self._live.lock:
            self._run_cycle()

    def _change(self, handler: Any, request: Any, response: Any) -> Any:
        """Answer a service call that changes the scene."""
        with self._live.lock:
            self._serve(handler, request, response)
        if time.monotonic() > self._next_scene:
            self._guard.attempt(self._publish_scene)
        return response

    def _serve(self, handler: Any, request: Any, response: Any) -> Any:
        """Answer a service call."""
        return self._guard.answer(partial(answer, handler, self._live), request, response)

    # What goes out.

    def _run_cycle(self) -> None:
        if self._active:
            (frames, seconds), self._taken = self._taken, (0, 0.0)
            values = self._settings.values
            self._cycle.run(frames, seconds, values.max_distance, values.time_budget)

    def _publish_scene(self) -> None:
        """Publish ~/scene when it is not the version that was published last."""
        if not self._active or self._published_version == self._live.version:
            return
        start = time.monotonic()
        view = self._live.view()
        message = messages.Scene(scene_version=view.moment.version)
        message.header.frame_id = view.moment.world_frame
        message.header.stamp = self.get_clock().now().to_msg()
        fill_scene(message, view.query.inspector(), messages)
        self._scene_publisher.publish(message)
        self._published_version = view.moment.version
        now = time.monotonic()
        self._next_scene = now + _SCENE_PAUSE * (now - start)

    def _draw(self) -> None:
        if not self._active:
            return
        if self._settings.values.publish_markers:
            self._markers.publish()
        else:
            self._markers.clear()

    def _replay_settings(self) -> tuple[str, int]:
        values = self._settings.values
        return values.replay_dir, values.replay_limit

    def _write_replays(self) -> None:
        for told in self._replays.write():
            self.get_logger().warning(told)

    def _keep_house(self) -> None:
        with self._live.lock:
            expired = self._live.expire_filters()
            if self._tf is not None:
                self._guard.take('/tf', self._tf.follow_scene)
        for filter_id in expired:
            self.get_logger().info(
                f'the lease of transient filter {filter_id.get_value()} ran out: removed',
                throttle_duration_sec=_LOG_PERIOD,
            )
        self._publish_scene()

    def _publish_diagnostics(self) -> None:
        message = self._diagnostics.message(
            self._live, self._settings.values.stale_after, self._cycle, time.monotonic()
        )
        message.header.stamp = self.get_clock().now().to_msg()
        self._diagnostics_publisher.publish(message)


def main(args: list[str] | None = None) -> int:
    """Run the node until it is interrupted; return 2 where its parameters cannot be."""
    return run_node(SceneGraphNode, (ParameterRefusedError,), args)


if __name__ == '__main__':
    sys.exit(main())
