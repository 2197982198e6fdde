"""The node `scene_graph`: keeps a scene, takes poses, answers services, publishes results.

A managed life-cycle node: configure loads the scene and compiles its kernels, activate publishes,
deactivate stops publishing and keeps the scene, cleanup forgets it. It configures and activates
itself unless the parameter ``autostart`` is false.
"""

from __future__ import annotations

import sys
import time
from functools import partial

from diagnostic_msgs.msg import DiagnosticArray
from drake_geom_msgs import msg as messages
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from drake_geom_ros.ros.cycle import Cycle
from drake_geom_ros.ros.diagnostics import Diagnostics
from drake_geom_ros.ros.handlers import answer
from drake_geom_ros.ros.live_scene import LiveScene
from drake_geom_ros.ros.parameters import NodeParameters, ParameterRefusedError, ParameterStore
from drake_geom_ros.ros.scene_conversions import fill_scene
from drake_geom_ros.ros.services import SERVICES
from drake_geom_ros.ros.spinning import run_node

_POSES_IN = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)
_LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
_RESULTS = QoSProfile(depth=10)
_HOUSEKEEPING_PERIOD = 0.1  # [s] leases, a changed scene
_DIAGNOSTICS_PERIOD = 1.0  # [s]
_LOG_PERIOD = 5.0  # [s] at most one line of a kind in this time


class SceneGraphNode(LifecycleNode):
    """The geometry service; see INTERFACE in the docs for topics, services and parameters."""

    def __init__(self, **kwargs) -> None:
        super().__init__('scene_graph', **kwargs)
        self._settings = ParameterStore(self, self._parameters_changed)
        self._live = LiveScene(self._settings.values.accuracy, self._now)
        self._diagnostics = Diagnostics(self.get_fully_qualified_name())
        self._active = False
        self._handles: list[tuple] = []
        if self._settings.values.autostart:
            # After the constructor, when the executor spins, so that a launch file sees it.
            self._autostart = self.create_timer(0.0, self._start_by_itself)

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
        if values.scene_file:
            try:
                frames, geometries = self._live.load(values.scene_file)
            except (RuntimeError, OSError) as error:
                self.get_logger().error(f'scene_file was refused: {error}')
                return TransitionCallbackReturn.FAILURE
            self.get_logger().info(f'loaded {frames} frames and {geometries} geometries')
        kernels = self._live.context.compile_kernels()
        self._open(values)
        seconds = time.perf_counter() - start
        self.get_logger().info(
            f'configured in {seconds:.1f} s, {len(kernels)} kernels compiled or loaded'
        )
        return TransitionCallbackReturn.SUCCESS

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Publish from now on."""
        self._active = True
        self._publish_scene()
        return super().on_activate(state)

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Stop publishing, keep the scene and go on taking poses."""
        self._active = False
        return super().on_deactivate(state)

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Close topics and services and forget the scene."""
        self._close()
        self._live.clear()
        return TransitionCallbackReturn.SUCCESS

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Close topics and services."""
        self._active = False
        self._close()
        return TransitionCallbackReturn.SUCCESS

    def _open(self, values: NodeParameters) -> None:
        """Create publishers, subscription, services and timers."""
        publishers = {}
        for name, message_class in (
            ('penetrations', messages.PenetrationPairs),
            ('signed_distances', messages.SignedDistancePairs),
            ('cycle_report', messages.CycleReport),
        ):
            publishers[name] = self.create_publisher(message_class, f'~/{name}', _RESULTS)
        self._scene_publisher = self.create_publisher(messages.Scene, '~/scene', _LATCHED)
        self._diagnostics_publisher = self.create_publisher(
            DiagnosticArray, '/diagnostics', _RESULTS
        )
        self._cycle = Cycle(self._live, messages, values.world_frame, publishers)
        poses = self.create_subscription(
            messages.FramePoses, '~/frame_poses', self._on_poses, _POSES_IN
        )
        services = [
            self.create_service(kind, f'~/{name}', partial(self._serve, handler))
            for name, kind, handler in SERVICES
        ]
        self._cycle_timer = None
        self._set_rate(values.rate)
        timers = [
            self.create_timer(_HOUSEKEEPING_PERIOD, self._keep_house),
            self.create_timer(_DIAGNOSTICS_PERIOD, self._publish_diagnostics),
        ]
        self._handles = [
            (self.destroy_publisher, self._scene_publisher),
            (self.destroy_publisher, self._diagnostics_publisher),
            (self.destroy_subscription, poses),
            *((self.destroy_publisher, p) for p in publishers.values()),
            *((self.destroy_service, s) for s in services),
            *((self.destroy_timer, t) for t in timers),
        ]
        self._published_version = -1

    def _close(self) -> None:
        for destroy, handle in self._handles:
            destroy(handle)
        self._handles = []
        if self._cycle_timer is not None:
            self.destroy_timer(self._cycle_timer)
            self._cycle_timer = None

    def _set_rate(self, rate: float) -> None:
        """Run cycles by a timer, or for rate 0 with each pose message."""
        if self._cycle_timer is not None:
            self.destroy_timer(self._cycle_timer)
            self._cycle_timer = None
        if rate > 0.0:
            self._cycle_timer = self.create_timer(1.0 / rate, partial(self._run_cycle, 0, 0.0))

    def _parameters_changed(self, old: NodeParameters, new: NodeParameters) -> None:
        if new.accuracy != old.accuracy:
            self._live.set_accuracy(new.accuracy)
        if new.rate != old.rate and self._handles:
            self._set_rate(new.rate)

    # What comes in.

    def _on_poses(self, message: messages.FramePoses) -> None:
        start = time.perf_counter()
        try:
            taken = self._live.take_poses(message)
        except RuntimeError as error:
            self._diagnostics.refuse(str(error))
            self.get_logger().warning(
                f'a pose message was refused: {error}', throttle_duration_sec=_LOG_PERIOD
            )
            return
        self._diagnostics.take()
        if self._settings.values.rate == 0.0:
            self._run_cycle(taken, time.perf_counter() - start)

    def _serve(self, handler, request, response):
        """Answer a service call; what no handler foresaw is a refusal too, and logged."""
        try:
            answer(handler, self._live, request, response)
        except Exception as error:
            self.get_logger().error(f'{handler.__name__} failed: {error!r}')
            response.success = False
            response.message = f'internal error in {handler.__name__}: {error!r}'
        self._publish_scene()
        if hasattr(response, 'result'):
            self._cycle.stamp(response.result)
        return response

    # What goes out.

    def _run_cycle(self, poses_taken: int, seconds: float) -> None:
        if self._active:
            self._cycle.run(poses_taken, seconds, self._settings.values.max_distance)

    def _publish_scene(self) -> None:
        """Publish ~/scene when it is not the version that was published last."""
        if not self._active or self._published_version == self._live.version:
            return
        message = messages.Scene(scene_version=self._live.version)
        message.header.frame_id = self._settings.values.world_frame
        message.header.stamp = self.get_clock().now().to_msg()
        fill_scene(message, self._live.inspector, messages)
        self._scene_publisher.publish(message)
        self._published_version = self._live.version

    def _keep_house(self) -> None:
        for filter_id in self._live.expire_filters():
            self.get_logger().info(
                f'the lease of transient filter {filter_id.get_value()} ran out: removed'
            )

    def _publish_diagnostics(self) -> None:
        message = self._diagnostics.message(
            self._live, self._settings.values.stale_after, self._cycle.count, time.monotonic()
        )
        message.header.stamp = self.get_clock().now().to_msg()
        self._diagnostics_publisher.publish(message)


def main(args: list[str] | None = None) -> int:
    """Run the node until it is interrupted; return 2 where its parameters cannot be."""
    return run_node(SceneGraphNode, ParameterRefusedError, args)


if __name__ == '__main__':
    sys.exit(main())
