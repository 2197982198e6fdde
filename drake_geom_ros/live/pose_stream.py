"""Poses in, cycles out: the part of the node that must not wait, in a thread of its own."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Protocol

from drake_geom_ros.geometry import QueryObject
from drake_geom_ros.live.conversions.message_types import (
    FramePosesMessage,
    FrameTwistsMessage,
    JointStateMessage,
)
from drake_geom_ros.live.conversions.transforms import Transforms
from drake_geom_ros.live.inputs.pose_inputs import PoseInputs
from drake_geom_ros.live.inputs.tf_edges import Refusal
from drake_geom_ros.live.inputs.tf_input import TfInput
from drake_geom_ros.live.outputs.cycle import Cycle
from drake_geom_ros.live.scene.held_scene import HeldScene
from drake_geom_ros.live.scene.live_scene import LiveScene

_SOON = 0.02  # [s] poses that come as fast as this have a cycle soon


class StreamValues(Protocol):
    """The parameters of the stream."""

    @property
    def stale_after(self) -> float:
        """Age [s] beyond which a pose is stale."""

    @property
    def rate(self) -> float:
        """Cycles [1/s] by a timer; 0: one cycle for each message."""

    @property
    def max_distance(self) -> float:
        """Largest distance [m] of published pairs."""

    @property
    def time_budget(self) -> float:
        """Longest time [s] of a query; 0: no limit."""


class StreamSettings(Protocol):
    """Keeps the present parameters."""

    @property
    def values(self) -> StreamValues:
        """The parameters of now."""


class InputCounts(Protocol):
    """Counts what comes in, for the diagnostics."""

    def take(self, delay: float, messages: int = 1, passed_over: int = 0) -> None:
        """Count messages that were answered within ``delay`` [s]."""

    def answer(self, lag: float) -> None:
        """Count an answer that is ``lag`` [s] behind its poses."""


class PoseStream:
    """Takes poses into the live scene; runs cycles for them while ``active``."""

    def __init__(
        self,
        live: LiveScene,
        settings: StreamSettings,
        diagnostics: InputCounts,
        cycle: Cycle,
    ) -> None:
        self.active = False
        self.inputs = PoseInputs()
        self._live = live
        self._settings = settings
        self._diagnostics = diagnostics
        self._cycle = cycle
        live.rehearse = self._rehearse
        # Called with the scene when poses were taken, before their cycle.
        self.with_poses: Callable[[HeldScene], object] = lambda scene: None
        self._frames, self._seconds = 0, 0.0  # taken since the last cycle, and what that cost
        # [s] when poses came last, and how long after those before.
        self._posed_at, self._gap = -math.inf, math.inf

    def stop(self) -> None:
        """Run no more cycles; the one that runs ends first."""
        with self._live.editing():
            self.active = False

    def take_poses(self, message: FramePosesMessage, waited: float, sender: str = '') -> None:
        """Take a FramePoses that came ``waited`` [s] ago; raises RuntimeError to refuse it."""
        start = time.perf_counter()
        with self._live.editing() as scene:
            self._posed(scene, self.inputs.take_poses(scene, message, waited, sender), start)
        self._diagnostics.take(time.perf_counter() - start)

    def take_joint_states(
        self, topic: str, message: JointStateMessage, waited: float, sender: str = ''
    ) -> None:
        """Take a JointState that came ``waited`` [s] ago; raises RuntimeError to refuse it.

        ``topic`` is that of the robots that name it, empty for all others.
        """
        start = time.perf_counter()
        with self._live.editing() as scene:
            if frames := self.inputs.take_joint_states(scene, message, waited, topic, sender):
                self._posed(scene, frames, start)
        self._diagnostics.take(time.perf_counter() - start)

    def follow(self, scene: HeldScene) -> int:
        """Pose what hangs on frames that moved, or is new; return how many frames."""
        return self.inputs.follow(scene)

    def take_twists(self, message: FrameTwistsMessage, waited: float) -> None:
        """Take a FrameTwists that came ``waited`` [s] ago; raises RuntimeError to refuse it."""
        with self._live.editing() as scene:
            scene.poses.take_twists(message, waited)

    def hear_transforms(
        self, tf: TfInput, static: bool, transforms: Transforms, waited: float, sender: str = ''
    ) -> Refusal:
        """Take a TFMessage that came ``waited`` [s] ago; return what was not taken of it."""
        with self._live.editing() as scene:
            if sender and not static:
                scene.poses.senders.note_transforms(sender, transforms.names.children)
            return tf.take(transforms, static=static, waited=waited)

    def pose_by_transforms(self, messages: int, passed_over: int) -> None:
        """Pose by what some messages brought, at once: a cycle for each would fall behind."""
        start = time.perf_counter()
        with self._live.editing() as scene:
            if frames := self.inputs.pose_by_transforms(scene):
                self._posed(scene, frames, start)
        if frames:
            self._diagnostics.take(time.perf_counter() - start, messages, passed_over)

    def troubles(self, scene: HeldScene) -> list[str]:
        """Return what is wrong with transforms and joint values, in words."""
        return self.inputs.troubles(scene, self._settings.values.stale_after)

    def cycle_is_due(self) -> None:
        """Run a cycle because it is time to."""
        with self._live.editing() as scene:
            self._run_cycle(scene)

    def map_has_changed(self) -> None:
        """Run a cycle for a map or objects that changed, if none is due by the timer."""
        if self._settings.values.rate == 0.0:
            self.cycle_is_due()

    def has_cycle_soon(self) -> bool:
        """Return whether poses come so fast that the cycle of the next ones is due within 20 ms.

        Tracked bodies that moved wait for it: a cycle of their own would cost as much again, and
        be 10 ms earlier beside a robot at 100 Hz. Any thread may ask.
        """
        return self._gap <= _SOON and time.perf_counter() - self._posed_at <= _SOON

    def rules_are_due(self) -> None:
        """Decide about proximity rules where no cycle did."""
        with self._live.reading() as scene:
            if self.active:
                self._cycle.rules.look_again(scene)

    def _rehearse(self, query: QueryObject) -> None:
        """Ask a query object what a cycle asks."""
        values = self._settings.values
        self._cycle.rehearse(query, values.max_distance, values.time_budget)

    def _posed(self, scene: HeldScene, frames: int, start: float) -> None:
        """Run a cycle for poses whose taking began at ``start``, or leave it to the timer."""
        self.with_poses(scene)
        self._frames += frames
        now = time.perf_counter()
        self._seconds += now - start
        self._gap, self._posed_at = now - self._posed_at, now
        if self._settings.values.rate == 0.0:
            self._run_cycle(scene)

    def _run_cycle(self, scene: HeldScene) -> None:
        if self.active:
            frames, seconds = self._frames, self._seconds
            self._frames, self._seconds = 0, 0.0
            values = self._settings.values
            self._cycle.run(scene, frames, seconds, values.max_distance, values.time_budget)
            if frames:
                self._diagnostics.answer(scene.poses.ages.lag())
