"""The demo's client: watches the results of the node, calls its filter services, writes files.

It is what a user's own node would be: topics and services only. Adjacent links, and things that
touch when the motion begins, are excluded for good (where the scene file has done so already,
that changes nothing); while the player announces intended contacts, those are excluded
transiently, on a lease.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

import numpy as np
import rclpy
from drake_geom_msgs import msg
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future
from rclpy.utilities import remove_ros_args
from std_srvs.srv import Trigger

from drake_geom_ros.client import (
    Geometry,
    Penetrations,
    ProximityEvent,
    ProximityMonitor,
    RefusedError,
    SceneListener,
    SceneTable,
    Services,
    SignedDistance,
    SignedDistances,
    UnknownNameError,
    exclude_between,
    sleep,
)
from drake_geom_ros.common.counting import counted
from drake_geom_ros.ros.demo import reading
from drake_geom_ros.ros.demo.filter_keeper import FilterKeeper
from drake_geom_ros.ros.demo.live_table import Screen
from drake_geom_ros.ros.demo.recording import FilterChange, Recording, RuleEvent
from drake_geom_ros.ros.demo.report import write_report
from drake_geom_ros.ros.spinning import StopSignals, spin_until_stopped
from drake_geom_ros.scene_files import SceneDescription, read_scene
from drake_geom_ros.trajectories.motion_file import adjacent_links

_LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
_STREAM = QoSProfile(depth=10)
_PATIENCE = 15.0  # [s] without a result before the demo counts as failed
_START_PATIENCE = 900.0  # [s] for the node to compile its kernels the first time
_PROGRESS_PERIOD = 5  # [s]
_POSES_KEPT = 100
_POLL = 0.05  # [s]
_RULE = 'near each other'
_LIMITS = {'enter': 0.1, 'leave': 0.12}  # [m]
_ANSWER_PATIENCE = 5.0  # [s]


class DemoFailedError(RuntimeError):
    """The demo cannot go on; the text says why."""


class DemoClient(Node):
    """Records results and keeps the filters as the player's intended contacts want them."""

    def __init__(self, scene: SceneDescription, seconds: float) -> None:
        super().__init__('demo_client')
        self._robots = tuple(robot.name for robot in scene.robots)
        self._adjacent = adjacent_links(scene)
        self._seconds = seconds
        self._record_from = np.inf  # stamp [s] of the motion's beginning
        self._poses: dict[float, msg.FramePoses] = {}
        self._closest: tuple[SignedDistances, SignedDistance] | None = None
        self._awaited, self._heard, self._patience = 'service', self._now(), _START_PATIENCE
        self._start_result: SignedDistances | None = None
        self._screen = Screen(sys.stdout)
        self.recording: Recording | None = None
        self.done: Future = Future()
        self._filters = FilterKeeper(self, self._note, self._fail)
        self._restart = self.create_client(Trigger, 'pose_player/restart')
        self._asked = Services(self, 'scene_graph')
        self._monitor = ProximityMonitor(self, 'scene_graph', on_event=self._on_event)
        self._subscribe()
        self._start_timer = self.create_timer(0.0, self._start)
        self.create_timer(_POLL, self._show)
        self.create_timer(1.0, self._watch)

    def _subscribe(self) -> None:
        self._listener = SceneListener(self, 'scene_graph')
        self._listener.on_scene(self._on_scene)
        self._listener.on_signed_distances(self._on_distances)
        self._listener.on_penetrations(self._on_penetrations)
        for kind, topic, callback, qos in (
            (msg.FramePoses, 'scene_graph/frame_poses', self._on_poses, _STREAM),
            (msg.CycleReport, 'scene_graph/cycle_report', self._on_report, _STREAM),
            (
                msg.CollisionFilterDeclaration,
                'pose_player/intended_contacts',
                self._on_intended,
                _LATCHED,
            ),
        ):
            self.create_subscription(kind, topic, callback, qos)

    def _now(self) -> float:
        return float(self.get_clock().now().nanoseconds * 1e-9)

    def _run(self, coroutine: Any) -> None:
        self.executor.create_task(coroutine)

    # The story.

    def _start(self) -> None:
        self.destroy_timer(self._start_timer)
        self._run(self._begin())

    async def _begin(self) -> None:
        """Wait for the node and the player, and let the motion begin."""
        while missing := self._missing():
            self._awaited = f'service {missing[0]}'
            await sleep(self, _POLL)
        self._awaited = 'result'
        await self._add_rule()
        await self._restarted()
        self._record_from = self._heard = self._now()
        self._patience = _PATIENCE

    async def _add_rule(self) -> None:
        """Have the node say when the first two robots, or one and the rest, come near."""
        if self._robots:
            rule = msg.ProximityRule(name=_RULE, level=msg.ProximityRule.SLOW, **_LIMITS)
            rule.set_a, rule.set_b = [self._robots[0]], list(self._robots[1:2])
            try:
                await self._asked.ask('add_proximity_rule', rule=rule)
            except RefusedError as error:  # it is there: of a client before us
                self.get_logger().info(str(error))

    async def _restarted(self) -> None:
        """Have the player begin anew; an answer may be lost where it has not found us yet."""
        while True:
            future = self._restart.call_async(Trigger.Request())
            end = self._now() + _ANSWER_PATIENCE
            while not future.done() and self._now() < end:
                await sleep(self, _POLL)
            if future.done():
                return

    def _missing(self) -> list[str]:
        restart = [] if self._restart.service_is_ready() else [self._restart.srv_name]
        return self._filters.missing() + self._asked.missing('add_proximity_rule') + restart

    def _for_good(self, distances: SignedDistances) -> msg.CollisionFilterDeclaration:
        """Return what to exclude for good: adjacent links, and what touches in this result."""
        sets = [(_frame(a), _frame(b)) for a, b in self._adjacent]
        sets += [(_set_of(a), _set_of(b)) for a, b in reading.touching(distances)]
        return msg.CollisionFilterDeclaration(statements=[exclude_between(*s) for s in sets])

    def _fail(self, reason: str) -> None:
        if not self.done.done():
            self.done.set_exception(DemoFailedError(reason))

    def _note(self, text: str) -> None:
        if self.recording is not None:
            self.recording.changes.append(FilterChange(self._now(), text))

    def _show(self) -> None:
        if self.recording is not None:
            self.recording.filtered_pairs = self._filters.filtered_pairs
            self._screen.show(self.recording)

    def _watch(self) -> None:
        """Once a second: say what is waited for, and give up where it does not come."""
        silence = self._now() - self._heard
        if silence > self._patience:
            self._fail(f'no {self._awaited} for {self._patience:g} s')
        elif self.recording is None and round(silence) % _PROGRESS_PERIOD == 0:
            hint = 'the first time, the node compiles its kernels'
            print(f'{silence:4.0f} s: waiting for {self._awaited} ({hint})', flush=True)

    # Inputs.

    def _on_scene(self, table: SceneTable) -> None:
        if self.recording is not None:
            self.recording.scene = table

    def _on_poses(self, message: msg.FramePoses) -> None:
        self._poses[reading.stamp(message)] = message
        if len(self._poses) > _POSES_KEPT:
            del self._poses[next(iter(self._poses))]
        self._picture_closest()

    def _on_event(self, event: ProximityEvent) -> None:
        if self.recording is not None and event.stamp >= self._record_from:
            fields = event.stamp, event.rule, event.level, event.entered, event.distance
            self.recording.events.append(RuleEvent(*fields))

    def _on_intended(self, message: msg.CollisionFilterDeclaration) -> None:
        self._run(self._filters.follow(message))

    def _on_report(self, message: msg.CycleReport) -> None:
        if self.recording is not None:
            self.recording.cycle_seconds.append(message.seconds)

    def _on_penetrations(self, result: Penetrations) -> None:
        if self.recording is not None and result.stamp >= self._record_from:
            self.recording.add_penetrations(result.stamp, result.id_a, result.id_b, result.depth)
            self._exclude_once()

    def _exclude_once(self) -> None:
        """Exclude for good what touches at the start, once that has been seen and recorded."""
        if self._start_result is None:
            return
        declaration = self._for_good(self._start_result)
        self._start_result = None
        touching = len(declaration.statements) - len(self._adjacent)
        text = (
            f'{counted(len(self._adjacent), "pair")} of adjacent links and {touching} of '
            'things that touch at the start'
        )
        self._run(self._filters.exclude_for_good(declaration, text))

    def _on_distances(self, result: SignedDistances) -> None:
        self._heard = self._now()
        if result.stamp < self._record_from:
            return  # of the motion before
        try:
            self._record(result)
        except UnknownNameError as error:  # a robot of the scene file without a geometry
            self._fail(f'the results say nothing of a robot of the scene file: {error}')

    def _record(self, result: SignedDistances) -> None:
        if self.recording is None:
            self.recording = Recording(result.table, self._robots, result.max_distance)
            self._start_result = result
        self.recording.add_distances(
            result.stamp,
            self._now() - result.stamp,
            result.id_a,
            result.id_b,
            result.distance,
            result.error_bound,
            result.method,
        )
        k = self.recording.closer(result.id_a, result.id_b, result.distance)
        if k is not None:
            self._closest = result, result[k]
            self._picture_closest()
        if result.stamp - self.recording.start >= self._seconds and not self.done.done():
            self.done.set_result(None)

    def _picture_closest(self) -> None:
        """Keep the closest moment once the poses of the same stamp have come as well."""
        if self._closest is None or self.recording is None:
            return
        result, pair = self._closest
        poses = self._poses.get(result.stamp)
        if poses is not None and result.table is self._listener.table:
            X_WFs = reading.world_poses(poses, result.table.parents)
            self.recording.approach = reading.approach(pair, result.stamp, result.table, X_WFs)
            self._closest = None


def _frame(name: str) -> msg.GeometrySet:
    return msg.GeometrySet(frames=[name])


def _set_of(geometry: Geometry) -> msg.GeometrySet:
    """Return all geometries of the frame; an anchored geometry alone: the world has too many."""
    if geometry.anchored:
        return msg.GeometrySet(geometry_ids=[geometry.id])
    return _frame(geometry.frame)


def _arguments(args: list[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog='demo_client', description=__doc__.splitlines()[0])
    parser.add_argument('--seconds', type=float, default=15.0, help='inf: until interrupted')
    parser.add_argument('--scene', type=Path, required=True, help='scene file, for its robots')
    parser.add_argument('--out', type=Path, default=Path('out/demo'), help='folder of the files')
    return parser.parse_args(args)


def main(args: list[str] | None = None) -> int:
    """Run the client; return 0 when the files are written, 1 when the demo failed."""
    args = sys.argv if args is None else args
    options = _arguments(remove_ros_args(args)[1:])
    with StopSignals() as signals:
        rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
        description = read_scene(options.scene)
        client = DemoClient(description, options.seconds)
        failure = ''
        try:
            spin_until_stopped(client, signals, client.done)
            if client.done.done():
                client.done.result()
        except DemoFailedError as error:
            failure = str(error)
        client.destroy_node()
        rclpy.try_shutdown()
        # Still under StopSignals: a second interrupt must not break the writing.
        if client.recording is not None and client.recording.pairs:
            print('\n'.join(write_report(client.recording, options.out, description)))
        elif not failure:
            failure = 'interrupted before the first result'
    if failure:
        print(f'demo_client: {failure}', file=sys.stderr)
    return 1 if failure else 0


if __name__ == '__main__':
    sys.exit(main())
