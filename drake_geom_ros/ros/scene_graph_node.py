"""The node `scene_graph`: keeps a scene, takes poses, answers services, publishes results.

A managed life-cycle node: configure loads the scene and compiles its kernels, activate publishes,
deactivate stops publishing and keeps the scene, cleanup forgets it. It configures and activates
itself unless the parameter ``autostart`` is false.

Some threads share the work (see ``spinning``): one takes poses and runs the cycles, one answers
queries on snapshots of the scene and draws, one reads what may take long (meshes, scene files,
robot descriptions) and compiles for it, one takes images, one answers for many states at once, one
proves motions, one makes maps of what sensors see, and the main one does the rest: other changes
of the scene, parameters, the life cycle, diagnostics.
"""

from __future__ import annotations

import secrets
import sys
import time
from typing import Any

from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.clock import Clock as SteadyClock
from rclpy.clock import ClockType
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from rosgraph_msgs.msg import Clock

from drake_geom_ros.common.counting import counted
from drake_geom_ros.geometry.ids import begin_ids_at
from drake_geom_ros.live.conversions.paddings import paddings_of
from drake_geom_ros.live.gates import all_gates
from drake_geom_ros.live.guard import Guard
from drake_geom_ros.live.inputs.obstacle_sources import all_sources, obstacle_sources_of
from drake_geom_ros.live.memory import give_back_blocks, leave_out_of_searches, settle
from drake_geom_ros.live.scene.clocks import Clocks
from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.live.scene.map_placing import begin_with_maps
from drake_geom_ros.live.scene.pose_history import PoseHistory
from drake_geom_ros.live.watchdog import Watchdog
from drake_geom_ros.ros.callback_groups import CallbackGroups
from drake_geom_ros.ros.configured_node import ConfiguredNode
from drake_geom_ros.ros.outputs.diagnostics import Diagnostics
from drake_geom_ros.ros.parameters import (
    QOS_OVERRIDES,
    TEXTS,
    NodeParameters,
    ParameterRefusedError,
    ParameterStore,
    file_access,
    unknown_parameters,
)
from drake_geom_ros.ros.services.parameter_services import answer_always
from drake_geom_ros.ros.spinning import run_node
from drake_geom_ros.ros.surface import Surface
from drake_geom_ros.ros.usage import is_help, usage
from drake_geom_ros.scene_files import RobotOptions, hulls_in_words, read_scene
from drake_geom_ros.sensed_maps.passes import compile_passes
from drake_geom_ros.sensed_maps.tree_walk import compile_tree_walk

_ID_BITS = 52  # of the number that the ids of a process begin at, drawn by chance


class SceneGraphNode(LifecycleNode):
    """The geometry service; see docs/reference.md for topics, services and parameters."""

    def __init__(self, **kwargs: Any) -> None:
        super().__init__('scene_graph', **kwargs)
        self.threaded_groups = CallbackGroups(
            *(MutuallyExclusiveCallbackGroup() for _ in CallbackGroups._fields)
        )
        groups = self.threaded_groups
        self.background_groups = (groups.planning, groups.motions, groups.obstacles)
        preparing = groups.changes, groups.loading, groups.images, groups.tracked
        self.patient_groups = (*preparing, groups.watching, *self.background_groups)
        self._configured: ConfiguredNode | None = None
        self._settings = ParameterStore(self, self._parameters_changed)
        values = self._settings.values
        self.watchdog = Watchdog(values.watchdog, exits=values.watchdog_exits)
        self._diagnostics = Diagnostics(self.get_fully_qualified_name())
        self._guard = Guard(self.get_logger(), self._diagnostics.refuse)
        answer_always(self)
        self._surface = Surface(self)
        self._tell_unknown_parameters()
        # Who outlives the node holds numbers of its: in a node that comes after it an id names
        # nothing (below 2 ** 53, which JSON and floats carry), and versions go on growing.
        begin_ids_at(secrets.randbits(_ID_BITS))
        self._first_version = time.time_ns() // 1000
        if self._settings.values.autostart:
            # After the constructor, when the executor spins, so that a launch file sees it.
            steady = SteadyClock(clock_type=ClockType.STEADY_TIME)
            self._autostart = self.create_timer(0.0, self._start_by_itself, clock=steady)

    def callback_failed(self, error: Exception, entity: Any) -> None:
        """Go on where a callback raised, of rclpy's own ones too."""
        # rclpy listens to the clock, and takes no time before 0.
        if getattr(entity, 'msg_type', None) is Clock and isinstance(error, ValueError):
            self._guard.refused('/clock', f'{error}; the node keeps the time that it had')
        else:
            self._guard.failed('a callback', error)

    def _start_by_itself(self) -> None:
        self.destroy_timer(self._autostart)
        if self.trigger_configure() == TransitionCallbackReturn.SUCCESS:
            self.trigger_activate()

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Load the scene, compile its kernels, open topics and services."""

        def configured() -> None:
            self._configured = self._open(self._settings.values)

        # A scene that cannot be loaded, a QoS override or the name of a topic that cannot be;
        # rclpy would drop it without a word.
        with self.watchdog.paused():
            is_configured = self._guard.succeeds(configured)
            settle()
        if is_configured:
            self._tell_unknown_parameters(QOS_OVERRIDES)
            return TransitionCallbackReturn.SUCCESS
        self._surface.close()
        self.get_logger().error(
            'the node is not configured and answers no requests. Correct the error above, then '
            f'go on with `ros2 lifecycle set {self.get_fully_qualified_name()} configure`, then '
            '`activate`; files are read again. To change a read-only parameter, restart the node'
        )
        return TransitionCallbackReturn.FAILURE

    def _tell_unknown_parameters(self, prefix: str = '') -> None:
        for text in unknown_parameters(self, prefix):
            self.get_logger().warning(text)

    def _tell_compiling(self, name: str, number: int, last: int) -> None:
        text = f'compiling {name} ({number} of {last}), once for this version of the package'
        self.get_logger().info(text)

    def _open(self, values: NodeParameters) -> ConfiguredNode:
        """Return what a configured node has."""
        start = time.perf_counter()
        clocks = Clocks(lambda: _seconds_now(self))
        live = LiveScene(values.accuracy, clocks, values.world_frame, self._first_version)
        live.files = file_access(values)
        live.most_megabytes, live.stale_after = values.max_answer_size, values.stale_after
        live.time_budget = values.time_budget
        live.name_cameras_for(self.get_fully_qualified_name())
        live.robot_options = RobotOptions(
            filter_self_collisions=values.filter_self_collisions,
            solid_meshes=values.solid_meshes,
            paddings=paddings_of(values.paddings),
            frame_prefix=values.frame_prefix,
        )
        described = None
        if values.scene_file:
            roots, options = live.files.package_roots, live.robot_options
            described = read_scene(values.scene_file, package_roots=roots, options=options)
        of_scene = () if described is None else described.obstacle_sources
        of_parameter = obstacle_sources_of(values.obstacle_sources)
        sources = all_sources(values.obstacles, of_parameter, of_scene)
        if sources:
            compile_passes()
            compile_tree_walk()
        with live.editing() as scene:
            if sources:
                scene.poses.history = PoseHistory()
            counts = begin_with_maps(scene, described, list(sources), values.obstacle_margin)
            scene.rules.begin_entered()
            scene.gates = all_gates(values.gate, described)
        if described is not None:
            hulls = hulls_in_words(described.geometries)
            loaded = f'{counted(counts[0], "frame")} and {counted(counts[1], "geometry")}'
            self.get_logger().info(f'loaded {loaded}{hulls}')
        live.tell_compiling, live.have_settled = self._tell_compiling, leave_out_of_searches
        kernels = live.compile_kernels()
        opened = ConfiguredNode(
            self,
            self._surface,
            self.threaded_groups,
            self._settings,
            self._guard,
            self._diagnostics,
            live,
            sources,
        )
        seconds = time.perf_counter() - start
        self.get_logger().info(
            f'configured in {seconds:.1f} s, {counted(len(kernels), "kernel")} compiled or loaded'
        )
        return opened

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Publish from now on."""
        if self._configured is not None:
            self._configured.activate()
        return super().on_activate(state)

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Stop publishing, keep the scene and go on taking poses."""
        if self._configured is not None:
            self._configured.deactivate()
        return super().on_deactivate(state)

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Close topics and services and forget the scene."""
        self._forget()
        return TransitionCallbackReturn.SUCCESS

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Close topics and services."""
        self._forget()
        return TransitionCallbackReturn.SUCCESS

    def destroy_node(self) -> None:
        """Log the counts of the second opinion, too, and end its process."""
        if self._configured is not None:
            self._configured.end_beside()
        super().destroy_node()

    def interrupt(self) -> None:
        """Let what takes long end soon: the process is about to stop."""
        if self._configured is not None:
            self._configured.live.interrupt()

    def _forget(self) -> None:
        if self._configured is not None:
            self._configured.close()
            with self._configured.live.reading() as scene:
                self._first_version = scene.model.version + 1
            self._configured = None

    def _parameters_changed(self, old: NodeParameters, new: NodeParameters) -> None:
        def follow_parameters() -> None:
            if self._configured is not None:
                self._configured.follow(old, new)

        self._guard.attempt(follow_parameters)


def _seconds_now(node: LifecycleNode) -> float:
    """Return the node's time [s] (simulated when use_sim_time is set)."""
    return float(node.get_clock().now().nanoseconds * 1e-9)


def main(args: list[str] | None = None) -> int:
    """Run the node until it is interrupted; return 2 where its parameters cannot be."""
    if is_help(args):
        print(
            usage(
                'scene_graph_node',
                example='[-p scene_file:=FILE]',
                description='Keeps a scene, takes poses from topics, and publishes which of its '
                'shapes touch, how deep and how far apart.',
                texts=TEXTS,
                see='docs/reference.md lists topics, services and parameters.',
            )
        )
        return 0
    give_back_blocks()
    return run_node(SceneGraphNode, (ParameterRefusedError,), args)


if __name__ == '__main__':
    sys.exit(main())
