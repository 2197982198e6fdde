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

from drake_geom_ros.ros.demo import reading
from drake_geom_ros.ros.demo.filter_keeper import FilterKeeper, exclude_between, sleep
from drake_geom_ros.ros.demo.live_table import Screen
from drake_geom_ros.ros.demo.recording import FilterChange, Recording
from drake_geom_ros.ros.demo.report import write_report
from drake_geom_ros.ros.demo.scene_table import Geometry
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
        self._closest: tuple[msg.SignedDistancePairs, int] | None = None
        self._awaited, self._heard, self._patience = 'service', self._now(), _START_PATIENCE
        self._start_result: msg.SignedDistancePairs | None = None
        self._screen = Screen(sys.stdout)
        self.recording: Recording | None = None
        self.done: Future = Future()
        self._filters = FilterKeeper(self, self._note, self._fail)
        self._restart = self.create_client(Trigger, 'pose_player/restart')
        self._subscribe()
        self._start_timer = self.create_timer(0.0, self._start)
        self.create_timer(_POLL, self._show)
        self.create_timer(1.0, self._watch)

    def _subscribe(self) -> None:
        for kind, topic, callback, qos in (
            (msg.Scene, 'scene_graph/scene', self._on_scene, _LATCHED),
            (msg.FramePoses, 'scene_graph/frame_poses', self._on_poses, _STREAM),
            (
                msg.SignedDistancePairs,
                'scene_graph/signed_distances',
                self._on_distances,
                _STREAM,
            ),
            (msg.PenetrationPairs, 'scene_graph/penetrations', self._on_penetrations, _STREAM),
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
        while missing := [c.srv_name for c in self.clients if not c.service_is_ready()]:
            self._awaited = f'service {missing[0]}'
            await sleep(self, _POLL)
        self._awaited = 'result'
        await self._restart.call_async(Trigger.Request())
        self._record_from = self._heard = self._now()
        self._patience = _PATIENCE

    def _for_good(self, message: msg.SignedDistancePairs) -> msg.CollisionFilterDeclaration:
        """Return what to exclude for good: adjacent links, and what touches in this result."""
        sets = [(_frame(a), _frame(b)) for a, b in self._adjacent]
        touching = reading.touching(message, self._table)
        sets += [(_set_of(a), _set_of(b)) for a, b in touching]
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

    # What comes in.

    def _on_scene(self, message: msg.Scene) -> None:
        self._table = reading.scene_table(message)
        self._parents = reading.frame_parents(message)
        if self.recording is not None:
            self.recording.scene = self._table

    def _on_poses(self, message: msg.FramePoses) -> None:
        self._poses[reading.stamp(message)] = message
        if len(self._poses) > _POSES_KEPT:
            del self._poses[next(iter(self._poses))]
        self._picture_closest()

    def _on_intended(self, message: msg.CollisionFilterDeclaration) -> None:
        self._run(self._filters.follow(message))

    def _on_report(self, message: msg.CycleReport) -> None:
        if self.recording is not None:
            self.recording.cycle_seconds.append(message.seconds)

    def _on_penetrations(self, message: msg.PenetrationPairs) -> None:
        if self.recording is not None and self._is_ours(message):
            self.recording.add_penetrations(
                reading.stamp(message),
                _integers(message.id_a),
                _integers(message.id_b),
                np.asarray(message.depth),
            )
            self._exclude_once()

    def _exclude_once(self) -> None:
        """Exclude for good what touches at the start, once that has been seen and recorded."""
        if self._start_result is None:
            return
        declaration = self._for_good(self._start_result)
        self._start_result = None
        touching = len(declaration.statements) - len(self._adjacent)
        text = (
            f'{len(self._adjacent)} pairs of adjacent links and {touching} of things that '
            'touch at the start'
        )
        self._run(self._filters.exclude_for_good(declaration, text))

    def _on_distances(self, message: msg.SignedDistancePairs) -> None:
        self._heard = self._now()
        if not self._is_ours(message):
            return
        if self.recording is None:
            self.recording = Recording(self._table, self._robots, message.max_distance)
            self._start_result = message
        time = reading.stamp(message)
        id_a, id_b = _integers(message.id_a), _integers(message.id_b)
        distance = np.asarray(message.distance)
        self.recording.add_distances(
            time,
            self._now() - time,
            id_a,
            id_b,
            distance,
            np.asarray(message.error_bound),
            _integers(message.method),
        )
        k = self.recording.closer(id_a, id_b, distance)
        if k is not None:
            self._closest = message, k
            self._picture_closest()
        if time - self.recording.start >= self._seconds and not self.done.done():
            self.done.set_result(None)

    def _is_ours(self, message: Any) -> bool:
        """Return whether a result is of this motion and of the scene that we know."""
        known = hasattr(self, '_table') and self._table.version == message.scene_version
        return known and reading.stamp(message) >= self._record_from

    def _picture_closest(self) -> None:
        """Keep the closest moment once the poses of the same stamp have come as well."""
        if self._closest is None or self.recording is None:
            return
        message, k = self._closest
        poses = self._poses.get(reading.stamp(message))
        if poses is not None and message.scene_version == self._table.version:
            X_WFs = reading.world_poses(poses, self._parents)
            self.recording.approach = reading.approach(message, k, self._table, X_WFs)
            self._closest = None


def _integers(values: Any) -> np.ndarray:
    return np.asarray(values).astype(np.int64)


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
        client = DemoClient(read_scene(options.scene), options.seconds)
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
        if client.recording is not None:
            print('\n'.join(write_report(client.recording, options.out)))
        elif not failure:
            failure = 'interrupted before the first result'
    if failure:
        print(f'demo_client: {failure}', file=sys.stderr)
    return 1 if failure else 0


if __name__ == '__main__':
    sys.exit(main())
