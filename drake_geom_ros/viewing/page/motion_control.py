"""Controls of a scene of this process: joints, a gizmo for frames, a motion with its time."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from drake_geom_ros.common.frame_names import FrameNames
from drake_geom_ros.geometry import FramePoseVector, GeometryError, SceneGraphContext
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.math.batched import matrices_from_poses, quaternions_from_rotations
from drake_geom_ros.viewing.joint_sliders import JointSlider, JointSliders
from drake_geom_ros.viewing.local_scene import LocalScene
from drake_geom_ros.viewing.page.options import CommandError
from drake_geom_ros.viewing.timeline import Timeline, checks_between, least_distances

_MOST_FRAMES = 500  # in the list of movable frames
_GIZMO_SIZE = 0.2  # [m]
_PLOT_PERIOD = 0.5  # [s] between two updates of a growing plot
SPEEDS = (0.01, 100.0)  # of a motion that is played, times that of the clock


class PlottedPairs(NamedTuple):
    """Pairs that a plot is about: their name, and a context in which all others are filtered."""

    name: str
    context: SceneGraphContext


class MotionControl:
    """Moves joints, frames and motions of a scene; any thread may call it."""

    def __init__(
        self,
        server: Any,
        scene: LocalScene,
        touch: Callable[[], None],
        joints: JointSliders | None,
        timeline: Timeline | None,
        plotted: PlottedPairs | None = None,
    ) -> None:
        """Control ``scene``; ``touch()`` is called when the picture is outdated.

        The plot of the timeline is about the pairs ``plotted``, without these about all.
        """
        self.plotted = plotted
        self._server, self._scene, self._touch = server, scene, touch
        self._joints, self.timeline = joints, timeline
        self._lock = threading.RLock()  # of the joint values and the time
        self._last = 0.0  # [s] of the steady clock, at the last step of the motion
        self._begin = scene.poses()
        if joints is not None:
            joints.keep()
        self.time = 0.0 if timeline is None else timeline.start
        self.playing, self.speed = False, 1.0
        self.least = np.zeros(0)
        self.proved: list[str] = []
        self.unproved = ''  # why nothing is proved
        self.revision = 0  # of the minimum distances
        sliders = [] if joints is None else joints.all()
        self.joints = {f'{joint.robot}::{joint.name}': joint for joint in sliders}
        robots = {joint.robot for joint in sliders}
        names = FrameNames(scene.frames)
        free = [frame for frame in scene.frames if frame[0] not in robots]
        self._free = {names.label(frame): frame for frame in free[:_MOST_FRAMES]}
        self.frame = ''
        self.gizmo: Any = None
        if timeline is not None:
            self.least = np.full(len(timeline.times), np.nan)
            threading.Thread(target=self._measure, name='least-distances', daemon=True).start()

    # A motion.

    def _measure(self) -> None:
        """Compute the minimum distances of the motion, then certify it, in a separate thread."""
        assert self.timeline is not None
        self._drawn = time.monotonic()
        snapshot = self._scene.snapshot if self.plotted is None else self.plotted.context.what_if
        for row, least in enumerate(least_distances(self.timeline, snapshot())):
            self.least[row] = least if np.isfinite(least) else np.nan
            self._show_progress()
        if self.timeline.is_continuous:
            try:
                for check in checks_between(self.timeline, snapshot()):
                    self.proved.append(check.outcome)
                    self._show_progress()
            except GeometryError as error:  # frames without a pose, or pairs that never meet
                self.proved.clear()
                self.unproved = str(error)
        self.revision += 1
        self._touch()

    def _show_progress(self) -> None:
        if time.monotonic() - self._drawn > _PLOT_PERIOD:
            self._drawn = time.monotonic()
            self.revision += 1
            self._touch()

    def go_to(self, moment: float) -> None:
        """Pose the scene as it is at a time [s] of the motion."""
        if self.timeline is None:
            raise CommandError('this scene has no motion')
        with self._lock:
            self.time = float(np.clip(moment, self.timeline.start, self.timeline.end))
            X_PFs = self.timeline.poses(self.time)
            if self.timeline.names_all:
                self._scene.pose_only(X_PFs)
            else:
                self._scene.pose(X_PFs)
            if self._joints is not None:
                self._joints.follow(self.time)
        self._touch()

    def go_to_least(self) -> None:
        """Go to the moment of the minimum distance computed so far."""
        if self.timeline is not None and np.isfinite(self.least).any():
            self.go_to(float(self.timeline.times[np.nanargmin(self.least)]))

    def step(self, count: int) -> None:
        """Go on by so many of the times at which the distance is known, back if negative."""
        if self.timeline is None:
            raise CommandError('this scene has no motion')
        times = self.timeline.times
        if count > 0:
            row = int(np.searchsorted(times, self.time, side='right')) + count - 1
        else:
            row = int(np.searchsorted(times, self.time, side='left')) + count
        self.go_to(float(times[min(max(row, 0), len(times) - 1)]))

    def play(self, *, on: bool) -> None:
        """Begin to play the motion, or pause."""
        self._last = time.monotonic()
        self.playing = on and self.timeline is not None
        self._touch()

    def move_on(self) -> bool:
        """Advance a playing motion to the current time; return whether one is playing."""
        if self.timeline is None or not self.playing:
            return False
        now = time.monotonic()
        later = self.time + self.speed * (now - self._last)
        self._last = now
        self.go_to(later if later <= self.timeline.end else self.timeline.start)
        return True

    # Joints.

    def joint_values(self) -> dict[str, float]:
        """Return the values [rad] or [m] of the joints by ``robot::joint``."""
        with self._lock:
            assert self._joints is not None or not self.joints
            return {
                name: self._joints.value(joint)  # type: ignore[union-attr]
                for name, joint in self.joints.items()
            }

    def move_joint(self, name: str, value: float) -> None:
        """Set a joint [rad] or [m], within its limits, and pause the motion."""
        if name not in self.joints or self._joints is None:
            raise CommandError(f'{name!r} is no joint that can be moved')
        self.playing = False
        with self._lock:
            self._scene.pose(self._joints.move(self.joints[name], value))
        self._touch()

    def reset(self) -> None:
        """Put joints and frames back to where they were when the page was opened."""
        self.playing = False
        with self._lock:
            if self.timeline is not None:
                self.time = self.timeline.start
                if self._joints is not None:
                    self._joints.follow(self.time)
            if self._joints is not None:
                self._joints.restore()
            frames = self._scene.frames
            X_PFs = FramePoseVector({frames[frame]: X for frame, X in self._begin.items()})
            self._scene.pose_only(X_PFs)
        self.take_frame(self.frame)
        self._touch()

    # One frame.

    @property
    def frames(self) -> list[str]:
        """Names of the frames that a gizmo can move."""
        return list(self._free)

    def take_frame(self, name: str) -> None:
        """Put the gizmo on a frame; on the world's origin if it has no pose; '': nowhere."""
        if name and name not in self._free:
            raise CommandError(f'{name!r} is no frame that can be moved')
        if self.gizmo is not None:
            self.gizmo.remove()
        self.frame, self.gizmo = name, None
        if not name:
            return
        try:
            X_WF = self._scene.X_WF(self._free[name])
        except GeometryError:
            X_WF = RigidTransform()
        wxyz = np.roll(quaternions_from_rotations(X_WF.rotation().matrix()[None])[0], 1)
        self.gizmo = self._server.scene.add_transform_controls(
            '/gizmo', scale=_GIZMO_SIZE, wxyz=wxyz, position=X_WF.translation(), depth_test=False
        )
        self.gizmo.on_update(partial(self._frame_moved, name))

    def _frame_moved(self, name: str, event: Any) -> None:
        handle = event.target
        self.place(name, np.concatenate([handle.position, np.roll(handle.wxyz, -1)]))

    def place(self, name: str, pose: Any) -> None:
        """Pose a frame of the list by x y z [m] qx qy qz qw; invalid poses are ignored."""
        try:
            matrices_from_poses([pose])
            self._scene.place(self._free[name], RigidTransform.FromArray(pose))
        except RuntimeError:  # a browser may send anything, and a parent may have no pose
            return
        self._touch()


def plain_joint(name: str, joint: JointSlider) -> dict[str, Any]:
    """Return a joint as JSON has it."""
    return {
        'id': name,
        'robot': joint.robot,
        'name': joint.name,
        'angle': joint.is_angle,
        'lower': joint.lower,
        'upper': joint.upper,
    }
