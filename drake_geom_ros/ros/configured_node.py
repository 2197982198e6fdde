"""The configured part of the node: made by configure, dropped by cleanup."""

from __future__ import annotations

import time
from collections.abc import Mapping
from functools import partial
from typing import Any

from drake_geom_msgs import msg as messages
from rclpy.lifecycle import LifecycleNode
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile
from rclpy.timer import Timer
from std_msgs.msg import Float64

from drake_geom_ros.common.counting import counted
from drake_geom_ros.live.guard import Guard
from drake_geom_ros.live.inputs.planning_scene import PlanningSceneInput
from drake_geom_ros.live.inputs.point_queries import PointQueries
from drake_geom_ros.live.inputs.robot_description import RobotInput
from drake_geom_ros.live.namesakes import Namesakes
from drake_geom_ros.live.outputs import level_costs, replays, rule_events
from drake_geom_ros.live.outputs.contact_topic import COMPUTED, ContactTopic
from drake_geom_ros.live.outputs.cycle import TOPICS as CYCLE_TOPICS
from drake_geom_ros.live.outputs.cycle import Cycle
from drake_geom_ros.live.outputs.effects import Beside, unheard
from drake_geom_ros.live.outputs.level_costs import LevelCosts
from drake_geom_ros.live.outputs.replays import Replays
from drake_geom_ros.live.outputs.rule_events import RuleEvents, RuleMessages, RuleTopics
from drake_geom_ros.live.outputs.scene_topic import SceneTopic
from drake_geom_ros.live.pose_stream import PoseStream
from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.live.scene.map_sources import NamedSource
from drake_geom_ros.live.services.state_validity import ValidityMessages, check_state_validity
from drake_geom_ros.live.watching import trajectory_watch
from drake_geom_ros.live.watching.trajectory_watch import Logs, TrajectoryWatch
from drake_geom_ros.ros import topics
from drake_geom_ros.ros.callback_groups import LONGEST_FAREWELL, CallbackGroups
from drake_geom_ros.ros.clock_jumps import THRESHOLD, ClockJumps
from drake_geom_ros.ros.gates import Gates
from drake_geom_ros.ros.joint_listening import JointListening
from drake_geom_ros.ros.message_classes import message_class
from drake_geom_ros.ros.obstacle_listening import ObstacleListening
from drake_geom_ros.ros.outputs import cameras, rule_points
from drake_geom_ros.ros.outputs.cameras import CameraPublisher
from drake_geom_ros.ros.outputs.diagnostics import (
    Diagnostics,
    SceneStatus,
    add_counts,
    add_trouble,
)
from drake_geom_ros.ros.outputs.result_publisher import ResultPublisher
from drake_geom_ros.ros.outputs.rule_points import RulePoints
from drake_geom_ros.ros.outputs.unlocked import LargePublisher
from drake_geom_ros.ros.parameters import NodeParameters, ParameterStore, file_access
from drake_geom_ros.ros.planning_scenes import PlanningScenes, SceneOutput
from drake_geom_ros.ros.robot_listening import listen_to_robots
from drake_geom_ros.ros.services.table import (
    BESIDE,
    CHANGES,
    IMAGES,
    LOADING,
    MOTIONS,
    PLANNING,
    STATE_VALIDITY,
    WATCHING,
)
from drake_geom_ros.ros.shown import ShownOutputs
from drake_geom_ros.ros.surface import (
    Surface,
    calls,
    images,
    latched,
    results,
    transforms,
)
from drake_geom_ros.ros.tf_listening import listen_to_tf
from drake_geom_ros.ros.tracked_listening import TrackedListening

_HOUSEKEEPING_PERIOD = 0.1  # [s] leases, changes of the scene that were not told yet
_DIAGNOSTICS_PERIOD = 1.0  # [s]
_NO_CLOCK = (
    'use_sim_time is set, but no message of /clock has arrived: ages are unknown, and with a '
    'rate no cycle runs'
)
_RULE_MESSAGES = RuleMessages(
    messages.ProximityEvents,
    messages.ProximityRules,
    messages.ProximityStates,
    messages.SpeedLimits,
    messages.Stopping,
    Float64,
)
_NOT_DUE = 'no {} since the last report'


class ConfiguredNode:
    """A live scene and all that is open for it: topics, services, timers."""

    def __init__(
        self,
        node: LifecycleNode,
        surface: Surface,
        groups: CallbackGroups,
        settings: ParameterStore,
        guard: Guard,
        diagnostics: Diagnostics,
        live: LiveScene,
        obstacle_sources: Mapping[str, NamedSource],
    ) -> None:
        """Open everything on ``surface``, which the caller closes where this raises."""
        self.live, self._node, self._surface, self._groups = live, node, surface, groups
        self._settings, self._guard, self._diagnostics = settings, guard, diagnostics
        publishers = topics.publishers(surface, settings.values)
        self._costs = LevelCosts(live, publishers['~/cycle_report'])
        self._replays = Replays(self._replay_settings)
        self._shown = ShownOutputs(
            live, publishers, settings, lambda: self._stream.active, node.get_logger().warning
        )
        self._beside = {**_beside(publishers), **self._shown.beside}
        decided, proofs = rule_events.effect(), rule_events.StopEffects.fresh()
        self._rules = RuleEvents(
            RuleTopics.of(publishers), _RULE_MESSAGES, self._rule_settings, decided.did, proofs
        )
        tf = transforms(static=False)
        self._cameras = CameraPublisher(live, surface, images(), latched(), tf)
        judged = trajectory_watch.effect()
        self._watch = _trajectory_watch(live, publishers, node.get_logger(), judged)
        self._rule_points = RulePoints(live, surface, results())
        points = self._rule_points.beside
        beside = (*self._beside.values(), self._cameras.beside, points, decided, *proofs, judged)
        self._cycle = Cycle(
            {name: ResultPublisher(publishers[f'~/{name}']) for name in CYCLE_TOPICS},
            self._costs,
            self._replays,
            self._rules,
            ContactTopic(
                publishers['~/contact_surfaces'],
                messages.ContactSurfaces,
                lambda: settings.values.contact_polygons,
                self._must_stop,
                partial(guard.failed, COMPUTED),
            ),
            beside,
        )
        self._stream = PoseStream(live, settings, diagnostics, self._cycle)
        self._scene_topic = SceneTopic(
            live,
            LargePublisher(publishers['~/scene']),
            messages,
            lambda: node.get_clock().now().to_msg(),
            self._beside['scene'].did,
        )
        self._diagnostics_publisher = publishers['/diagnostics']
        with live.editing() as scene:
            scene.filters.most_per_owner = settings.values.filters_per_owner
        self._namesakes = Namesakes(node)
        self._jumps = ClockJumps(live.clocks, node, guard)
        surface.clock_jumps(THRESHOLD, self._jumps.simulated)
        planning = self._open_inputs(settings.values, publishers['~/point_distances'])
        self._listen(settings.values, obstacle_sources)
        self._open_services(calls(settings.values.service_depth))
        if settings.values.use_planning_scene:
            self._open_state_validity(calls(settings.values.service_depth))
            self._open_planning_scenes(planning, publishers[topics.PLANNING_SCENE])
        self._start_timers()
        self._cycle_timer: Timer | None = None
        self._set_rate(settings.values.rate)
        self.set_cross_check(settings.values.cross_check)

    # The life cycle.

    def activate(self) -> None:
        """Publish from now on."""
        with self.live.editing() as scene:
            scene.rules.measure_again()
            self._rules.forget()
        self._watch.forget()
        self._gates.open()
        self._stream.active = True
        self._guard.attempt(self._publish_scene)

    def deactivate(self) -> None:
        """Stop publishing, keep the scene and go on taking poses."""
        self._stream.stop()
        self._gates.close()

    def close(self) -> None:
        """Stop, and close everything; answers that come soon are still sent."""
        self._stream.stop()
        self._gates.close()
        self.live.close()
        self._cycle.contacts.close()
        if not self._groups.let_answers_go():
            self._node.get_logger().warning(
                f'closed after waiting {LONGEST_FAREWELL:g} s for service calls at work: their '
                'callers get no answer, and nothing was changed'
            )
        self._obstacles.close()
        with self.live.reading():
            self._set_rate(0.0)
            self._surface.close()
        self.set_cross_check(0.0)

    def follow(self, old: NodeParameters, new: NodeParameters) -> None:
        """Apply changed parameters."""
        with self.live.editing() as scene:
            if new.accuracy != old.accuracy:
                scene.set_accuracy(new.accuracy)
            scene.filters.most_per_owner = new.filters_per_owner
            self.live.files = file_access(new)
            self.live.most_megabytes, self.live.stale_after = new.max_answer_size, new.stale_after
            self.live.time_budget = new.time_budget
            if new.rate != old.rate:
                self._set_rate(new.rate)
        if new.cross_check != old.cross_check:
            self.set_cross_check(new.cross_check)

    def set_cross_check(self, rate: float) -> None:
        """Ask for a second opinion ``rate`` [Hz] times a second; 0: not at all."""
        cross_check, self._cycle.cross_check = self._cycle.cross_check, None
        if cross_check is not None:
            cross_check.close()
            counts = ', '.join(f'{n} {key}' for key, n in cross_check.counts()._asdict().items())
            self._node.get_logger().info(f'cross_check: {counts}')
        if rate > 0.0:
            # Only now: most nodes ask for none.
            from drake_geom_ros.live.outputs.cross_check import CrossCheck

            self._cycle.cross_check = CrossCheck(rate, self._replay_settings)

    def end_beside(self) -> None:
        """End the threads and processes that no callback group has."""
        self._cycle.contacts.close()
        self.set_cross_check(0.0)

    def _must_stop(self) -> bool:
        """Return whether a long publication must end."""
        return self.live.must_stop() or not self._stream.active

    # Topics and services.

    def _open_inputs(
        self, values: NodeParameters, point_distances: Publisher
    ) -> PlanningSceneInput:
        """Listen to poses, points and robot descriptions; return the input of planning scenes."""
        if values.closing_speeds:
            with self.live.editing() as scene:
                scene.poses.watch_motion(values.stale_after)
        points = PointQueries(
            self.live,
            point_distances,
            messages.PointDistances,
            lambda: self._settings.values.point_threshold,
            lambda: self._stream.active,
            self._beside['point_distances'].did,
        )
        log = self._node.get_logger().info
        changed = partial(self._guard.attempt, self._stream.map_has_changed)
        planning = PlanningSceneInput(
            self.live,
            self._surface.wake(changed, self._groups.stream),
            lambda: self._stream.inputs.joints,
            self._surface.full_name(),
        )
        robot = RobotInput(self.live)
        receivers = topics.Receivers(self._stream, points, robot, planning, log)
        topics.subscribe(self._surface, self._guard, self._groups, values, receivers)
        parts = self._surface, self.live, self._guard, self._groups.loading
        listen_to_robots(*parts, values.robot_descriptions, log)
        return planning

    def _listen(self, values: NodeParameters, obstacle_sources: Mapping[str, NamedSource]) -> None:
        """Listen to TF, joint states and sensors, whose topics depend on parameters and robots."""
        surface, stream, guard = self._surface, self._stream, self._guard
        group, clocks = self._groups.stream, self.live.clocks
        if values.use_tf:
            stream.inputs.tf = listen_to_tf(surface, stream, guard, group, clocks)
        self._joints = JointListening(surface, stream, guard, group, clocks, values)
        self._obstacles = ObstacleListening(
            surface, self.live, stream, guard, self._groups, self._settings, obstacle_sources
        )
        self._tracked = TrackedListening(surface, self.live, stream, guard, self._groups, values)
        with self.live.reading() as scene:
            gates = scene.gates
        self._gates = Gates(self._node, surface, guard, group, clocks, gates)
        self._rules.tell_gates = self._gates.decide

    def _open_services(self, profile: QoSProfile) -> None:
        """Open all services."""
        groups = self._groups
        for services, group in (
            *((BESIDE, groups.beside), (CHANGES, groups.changes), (LOADING, groups.loading)),
            *((IMAGES, groups.images), (PLANNING, groups.planning), (MOTIONS, groups.motions)),
        ):
            for name, kind, handler in services:
                serve = partial(self._guard.answer, handler, self.live)
                self._surface.service(kind, f'~/{name}', serve, profile, group)
        for name, kind, handle in WATCHING:
            serve = partial(self._guard.answer, handle, self._watch)
            self._surface.service(kind, f'~/{name}', serve, profile, groups.watching)

    def _open_planning_scenes(self, planning: PlanningSceneInput, publisher: Publisher) -> None:
        """Ask MoveIt for its scene, and publish this one for it."""
        did = self._beside['planning_scene'].did
        output = SceneOutput(publisher, did, lambda: self._stream.active)
        parts = self._surface, self.live, self._guard, self._groups, planning, output
        self._planning_scenes = PlanningScenes(*parts, self._node.get_logger())

    def _open_state_validity(self, profile: QoSProfile) -> None:
        """Open the service of MoveIt's type, whose answer has no reason: that is logged."""
        kind = message_class('moveit_msgs/srv/GetStateValidity')
        new = ValidityMessages(
            message_class('moveit_msgs/msg/ContactInformation'),
            message_class('moveit_msgs/msg/CostSource'),
        )
        handler = partial(check_state_validity, self.live, new)

        def serve(request: Any, response: Any) -> Any:
            self._guard.take(STATE_VALIDITY, handler, request, response)
            return response

        name, group = f'~/{STATE_VALIDITY}', self._groups.planning
        self._surface.service(kind, name, serve, profile, group)

    def _set_rate(self, rate: float) -> None:
        """Run cycles by a timer, or for rate 0 with each pose message."""
        if self._cycle_timer is not None:
            self._node.destroy_timer(self._cycle_timer)
            self._cycle_timer = None
        if rate > 0.0:
            self._cycle_timer = self._node.create_timer(
                1.0 / rate,
                partial(self._guard.attempt, self._stream.cycle_is_due),
                callback_group=self._groups.stream,
            )

    def _start_timers(self) -> None:
        """Start the periodic tasks other than cycles."""
        beside = self._groups.beside
        for period, task, group in (
            *((period, task, beside) for period, task in self._shown.tasks()),
            (level_costs.PERIOD, self._costs.measure, beside),
            (rule_events.PERIOD, self._stream.rules_are_due, self._groups.stream),
            (rule_points.PERIOD, self._publish_rule_points, beside),
            (replays.PERIOD, self._write_replays, beside),
            (trajectory_watch.PERIOD, self._look_at_trajectories, self._groups.watching),
            (_HOUSEKEEPING_PERIOD, self._keep_house, None),
            (_DIAGNOSTICS_PERIOD, self._publish_diagnostics, None),
        ):
            self._surface.timer(period, partial(self._guard.attempt, task), group)
        take = partial(self._guard.attempt, self._take_images)
        self._camera_timer = self._surface.timer(cameras.PERIOD, take, self._groups.images)

    # Periodic tasks.

    def _publish_scene(self) -> None:
        if self._stream.active:
            self._scene_topic.publish()

    def _look_at_trajectories(self) -> None:
        if self._stream.active:
            self._watch.look()

    def _publish_rule_points(self) -> None:
        if self._stream.active:
            self._rule_points.publish()

    def _take_images(self) -> None:
        if self._stream.active:
            self._camera_timer.timer_period_ns = int(1e9 * self._cameras.publish())
            self._camera_timer.reset()

    def _rule_settings(self) -> rule_events.RuleSettings:
        values = self._settings.values
        return rule_events.RuleSettings(values.stale_after, values.time_budget)

    def _replay_settings(self) -> tuple[str, int]:
        values = self._settings.values
        return values.replay_dir, values.replay_limit

    def _write_replays(self) -> None:
        cross_check = self._cycle.cross_check
        for text in self._replays.write() + (cross_check.tell() if cross_check else []):
            self._node.get_logger().warning(text)

    def _keep_house(self) -> None:
        self._jumps.look()
        with self.live.editing() as scene:
            scene.filters.expire()
            has_changed = scene.poses.take_out_silent(self._settings.values.stale_after)
            self._guard.take('poses that hang on others', self._stream.follow, scene)
            self._guard.take('joint_states', self._joints.follow, scene)
        if has_changed:
            self._stream.map_has_changed()
        self._guard.attempt(self._tracked.sweep)
        self._log_what_is_told()
        self._publish_scene()

    def _log_what_is_told(self) -> None:
        """Log the ends of transient filters in one line, and each warning in its own."""
        with self.live.editing() as scene:
            notes, warnings = scene.log.take()
        for warning in warnings:
            self._guard.tell(warning, warning, once=True)
        if notes:
            self._node.get_logger().info('; '.join(notes))

    def _publish_diagnostics(self) -> None:
        with self.live.reading() as scene:
            troubles = [*scene.troubles(), *self._stream.troubles(scene)]
            state = SceneStatus(
                scene.model.version,
                scene.poses.ages_by_name(),
                scene.waiting(),
                scene.filters.owners(),
                scene.poses.unknown_ages(),
                self._jumps.count,
                scene.filters.leases(),
                scene.rules.in_words(),
            )
        stale_after = self._settings.values.stale_after
        message = self._diagnostics.message(state, stale_after, self._cycle, time.monotonic())
        if self._cycle.cross_check is not None:
            add_counts(message.status[0], self._cycle.cross_check.counts())
        self._obstacles.tell(message.status[0])
        self._tracked.tell(message.status[0])
        self._gates.tell(message.status[0])
        self._diagnostics.add_calls(message.status[0], self._surface.answers.counts())
        if namesakes := self._namesakes.trouble():
            add_trouble(message.status[0], namesakes)
        if unpublished := self._scene_topic.unpublished:
            troubles.append(
                f'{counted(unpublished, "set")} of names that results refer to could not be '
                'published on ~/scene: the scene is too large to change that often'
            )
        for trouble in troubles:
            add_trouble(message.status[0], trouble)
        for text in filter(None, (state.waiting.in_words(), *troubles)):
            self._guard.tell(text, text, once=True)
        now = self._node.get_clock().now()
        # Simulated time stands at 0 until it is told; no other clock ever shows that.
        if not now.nanoseconds:
            add_trouble(message.status[0], _NO_CLOCK)
            self._node.get_logger().warning(_NO_CLOCK, once=True)
        message.header.stamp = now.to_msg()
        self._diagnostics_publisher.publish(message)


def _trajectory_watch(
    live: LiveScene, publishers: Mapping[str, Publisher], logger: Any, judged: Beside
) -> TrajectoryWatch:
    """Return the judge of running trajectories."""
    return TrajectoryWatch(
        live,
        publishers['~/trajectory_states'],
        messages.TrajectoryStates,
        Logs(logger.info, logger.warning),
        judged.did,
    )


def _beside(publishers: Mapping[str, Publisher]) -> dict[str, Beside]:
    """Return the rows of the report about what is published beside the cycles."""
    points = publishers['~/point_distances']
    reasons = {
        'point_distances': lambda: unheard(points, _NOT_DUE.format('cloud of points')),
        'scene': lambda: _NOT_DUE.format('change of the scene'),
    }
    if (planning_scene := publishers.get(topics.PLANNING_SCENE)) is not None:
        reason = _NOT_DUE.format('change of a body')
        reasons['planning_scene'] = lambda: unheard(planning_scene, reason)
    return {name: Beside.publishing(name, why_not) for name, why_not in reasons.items()}
