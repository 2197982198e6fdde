"""Panel of motion: joint sliders, a gizmo for frames, and a motion with its timeline."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from drake_geom_ros.common.frame_names import FrameNames
from drake_geom_ros.geometry import GeometryError
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.math.batched import matrices_from_poses, quaternions_from_rotations
from drake_geom_ros.viewing.joint_sliders import JointSlider, JointSliders
from drake_geom_ros.viewing.local_scene import LocalScene
from drake_geom_ros.viewing.page.slider_plot import plot
from drake_geom_ros.viewing.timeline import Timeline, checks_between, least_distances

NO_FRAME = '-'
_MOST_FRAMES = 500  # in the list of movable frames
_STEPS = 400  # of a slider
_GIZMO_SIZE = 0.2  # [m]
_PLOT_PERIOD = 0.5  # [s] between two updates of a growing plot


class MotionPanel:
    """Panel that moves joints, frames and motions of a scene."""

    def __init__(
        self,
        server: Any,
        scene: LocalScene,
        touch: Callable[[], None],
        joints: JointSliders | None,
        timeline: Timeline | None,
    ) -> None:
        """Add the controls; ``touch()`` is called when the picture is outdated."""
        self._server, self._scene, self._touch = server, scene, touch
        self._joints, self._timeline = joints, timeline
        self._lock = threading.RLock()  # of the joint values and the time
        self._following: int | None = None  # id of the thread that sets sliders by program
        self._last = 0.0  # [s] of the steady clock, at the last step of the motion
        self.sliders: dict[JointSlider, Any] = {}
        if timeline is not None:
            self._add_timeline(server.gui, timeline)
        if joints is not None and joints.all():
            self._add_joints(server.gui, joints)
        self._add_gizmo(server.gui, {j.robot for j in self.sliders})

    # A motion.

    def _add_timeline(self, gui: Any, timeline: Timeline) -> None:
        with gui.add_folder('Motion'):
            self.play = gui.add_checkbox('play', False)
            step = max((timeline.end - timeline.start) / _STEPS, np.finfo(float).tiny)
            end = max(timeline.end, timeline.start + step)
            self._least = np.full(len(timeline.times), np.nan)
            self._proved: list[str] = []
            self._unproved = ''  # why nothing is proved
            self._plot = gui.add_html(self._plotted())
            # Right after the plot, which is drawn on its track.
            self.time = gui.add_slider('time [s]', timeline.start, end, step, timeline.start)
            self.nearest = gui.add_button('go to the least distance')
        self.time.on_update(self._time_moved)
        self.play.on_update(self._play_switched)
        self.nearest.on_click(lambda _: self.go_to_least())
        threading.Thread(target=self._measure, name='least-distances', daemon=True).start()

    def _plotted(self) -> str:
        """Return the plot of the minimum distances computed so far."""
        assert self._timeline is not None
        line = self._timeline
        return plot(line.times, self._least, line.start, line.end, self._proved, self._unproved)

    def _measure(self) -> None:
        """Compute the minimum distances of the motion, then certify it, in a separate thread."""
        assert self._timeline is not None
        self._drawn = time.monotonic()
        for row, least in enumerate(least_distances(self._timeline, self._scene.snapshot())):
            self._least[row] = least if np.isfinite(least) else np.nan
            self._plot_now_and_then()
        if self._timeline.is_continuous:
            try:
                for check in checks_between(self._timeline, self._scene.snapshot()):
                    self._proved.append(check.outcome)
                    self._plot_now_and_then()
            except GeometryError as error:  # frames without a pose, or pairs that never meet
                self._proved.clear()
                self._unproved = str(error)
        self._plot.content = self._plotted()

    def _plot_now_and_then(self) -> None:
        if time.monotonic() - self._drawn > _PLOT_PERIOD:
            self._plot.content, self._drawn = self._plotted(), time.monotonic()

    def go_to_least(self) -> None:
        """Go to the moment of the minimum distance computed so far."""
        assert self._timeline is not None
        if np.isfinite(self._least).any():
            self.time.value = float(self._timeline.times[np.nanargmin(self._least)])

    def _play_switched(self, event: Any) -> None:
        self._last = time.monotonic()
        self._touch()

    def _time_moved(self, event: Any) -> None:
        assert self._timeline is not None
        with self._lock:
            X_PFs = self._timeline.poses(self.time.value)
            if self._timeline.names_all:
                self._scene.pose_only(X_PFs)
            else:
                self._scene.pose(X_PFs)
            if self._joints is not None:
                self._joints.follow(self.time.value)
        self._touch()

    def move_on(self) -> bool:
        """Advance a playing motion to the current time; return whether one is playing."""
        if self._timeline is None or not self.play.value:
            return False
        now = time.monotonic()
        later = self.time.value + now - self._last
        self._last = now
        self.time.value = later if later <= self._timeline.end else self._timeline.start
        return True

    def show(self) -> None:
        """Update the sliders to joint values that were set elsewhere."""
        if self._timeline is None or self._joints is None:
            return
        self._following = threading.get_ident()
        try:
            for joint, slider in self.sliders.items():
                slider.value = min(max(self._joints.value(joint), joint.lower), joint.upper)
        finally:
            self._following = None

    # Joints.

    def _add_joints(self, gui: Any, joints: JointSliders) -> None:
        folders: dict[str, Any] = {}
        for joint in joints.all():
            if joint.robot not in folders:
                folders[joint.robot] = gui.add_folder(
                    f'Joints of {joint.robot}', expand_by_default=False
                )
            with folders[joint.robot]:
                step = (joint.upper - joint.lower) / _STEPS
                value = min(max(joints.value(joint), joint.lower), joint.upper)
                slider = gui.add_slider(joint.name, joint.lower, joint.upper, step, value)
            slider.on_update(partial(self._joint_moved, joint))
            self.sliders[joint] = slider

    def _joint_moved(self, joint: JointSlider, event: Any) -> None:
        if self._following == threading.get_ident():
            return
        assert self._joints is not None
        with self._lock:
            self._scene.pose(self._joints.move(joint, event.target.value))
        self._touch()

    # One frame.

    def _add_gizmo(self, gui: Any, robots: set[str]) -> None:
        names = FrameNames(self._scene.frames)
        free = [frame for frame in self._scene.frames if frame[0] not in robots]
        self._free = {names.label(frame): frame for frame in free[:_MOST_FRAMES]}
        if not free:
            return
        with gui.add_folder('Move a frame'):
            self.frame = gui.add_dropdown('frame', (NO_FRAME, *self._free))
        self.frame.on_update(lambda _: self._take_frame())
        self.gizmo: Any = None

    def _take_frame(self) -> None:
        """Move the gizmo to the chosen frame, or to the world's origin if it has no pose."""
        if self.gizmo is not None:
            self.gizmo.remove()
            self.gizmo = None
        name = self.frame.value
        if name == NO_FRAME:
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
