"""Motions of the frames of a scene over time: robots, grasped objects, free frames."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike

from drake_geom_ros.common.frame_names import Frame, full_name
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.scene_files.description import WORLD
from drake_geom_ros.trajectories.interpolation import MonotoneCubic
from drake_geom_ros.trajectories.kinematics import Kinematics
from drake_geom_ros.trajectories.pose_matrices import inverse, matrices_of_poses, poses_of_matrices
from drake_geom_ros.trajectories.timed_poses import TimedPoses


@dataclass(frozen=True)
class RobotMotion:
    """A robot on its base pose X_WB (4, 4), and its joint values over time.

    W is the frame ``carrier``, by source and name, if the robot is mounted on one. ``given`` are
    the joints with values; the others are at rest, and links below a planar or floating one of the
    others have no pose.
    """

    kinematics: Kinematics
    X_WB: Floats
    joint_values: MonotoneCubic
    given: frozenset[str] = frozenset()
    carrier: Frame | None = None

    def moved_links(self) -> list[int]:
        """Return the rows of the links that are frames of the scene and have a pose."""
        # A link with the name of the world is no frame: see scene_files/urdf.py.
        links = self.kinematics.link_names
        return [k for k in self.kinematics.placed_links(self.given) if links[k] != WORLD]

    def link_transforms(self, t: ArrayLike) -> Floats:
        """Return X_WL of every link (..., links, 4, 4) at times t (...) [s]."""
        return self.kinematics.link_transforms(self.joint_values.value(t), self.X_WB)


@dataclass(frozen=True)
class Grasp:
    """A period from ``start`` to ``end`` [s] in which a frame follows a robot's link.

    Frames are given by source and name. ``gripper`` are the frames that may touch it meanwhile.
    """

    frame: Frame
    link: Frame
    gripper: tuple[Frame, ...]
    start: float
    end: float

    def holds(self, t: float) -> bool:
        """Return whether the frame is held at a time t [s]."""
        return self.start <= t < self.end


class Motion:
    """Poses X_PF of all moving frames at any time of a motion.

    P is the world, or the frame that a robot is mounted on. ``robots`` are given by source name,
    ``free`` frames by source and name. A frame with grasps has its first free pose until the first
    grasp, and keeps the pose at the end of each.
    """

    def __init__(
        self,
        robots: Mapping[str, RobotMotion],
        free: Mapping[Frame, TimedPoses],
        grasps: Sequence[Grasp] = (),
        left_out: Mapping[str, str] = MappingProxyType({}),
    ):
        """Make a motion; raises ValueError for a grasp with an unknown frame or during another.

        ``left_out`` are the robots of the scene without kinematics, with the reasons.
        """
        self.left_out = dict(left_out)
        self.robots = dict(robots)
        self.free = dict(free)
        self.grasps = tuple(sorted(grasps, key=lambda g: g.start))
        self._moving_links = {source: r.moved_links() for source, r in self.robots.items()}
        self.frame_names: dict[str, list[str]] = {
            source: [robot.kinematics.link_names[k] for k in self._moving_links[source]]
            for source, robot in self.robots.items()
        }
        for source, name in self.free:
            if source in self.robots:
                raise ValueError(
                    f'free frame {full_name((source, name))!r}: its source is a robot, whose '
                    'frames its joints move'
                )
            self.frame_names.setdefault(source, []).append(name)
        self._check_grasps()
        self._held_poses = self._fix_grasps()

    @property
    def duration(self) -> float:
        """The time [s] of the end of all movements."""
        ends = [robot.joint_values.times[-1] for robot in self.robots.values()]
        ends += [frame.end for frame in self.free.values()] + [g.end for g in self.grasps]
        return float(max(ends, default=0.0))

    def poses(self, t: ArrayLike) -> dict[str, Floats]:
        """Return X_PF (..., frames, 7) of the ``frame_names`` of each source, at times t (...).

        A pose is x y z [m] and a unit quaternion qx qy qz qw.
        """
        t = np.asarray(t, dtype=float)
        links = {source: robot.link_transforms(t) for source, robot in self.robots.items()}
        poses = {
            source: poses_of_matrices(X_WLs[..., self._moving_links[source], :, :])
            for source, X_WLs in links.items()
        }
        for source, names in self.frame_names.items():
            if source not in self.robots:
                frames = [self._free_pose((source, name), t) for name in names]
                poses[source] = np.stack(frames, axis=-2)
        return poses

    def held(self, t: float) -> tuple[Grasp, ...]:
        """Return the active grasps at a time t [s]."""
        return tuple(grasp for grasp in self.grasps if grasp.holds(t))

    def _free_pose(self, frame: Frame, t: Floats) -> Floats:
        """Return the pose of a free frame (..., 7)."""
        pose = self.free[frame].poses(t)
        for grasp, (X_LF, pose_end) in zip(self.grasps, self._held_poses, strict=True):
            if grasp.frame != frame:
                continue
            X_WF = self._X_WL(grasp.link, t) @ X_LF
            during = ((t >= grasp.start) & (t < grasp.end))[..., None]
            pose = np.where(during, poses_of_matrices(X_WF), pose)
            pose = np.where((t >= grasp.end)[..., None], pose_end, pose)
        return pose

    def _X_WL(self, link: Frame, t: ArrayLike) -> Floats:
        """Return X_WL of a link (..., 4, 4) in the world, also for a mounted robot."""
        source, name = link
        robot = self.robots[source]
        X_PL: Floats = robot.link_transforms(t)[..., robot.kinematics.link_names.index(name), :, :]
        if robot.carrier is None:
            return X_PL
        if robot.carrier[0] in self.robots:
            return np.asarray(self._X_WL(robot.carrier, t) @ X_PL)
        carrier = self.free[robot.carrier].poses(np.asarray(t, dtype=float))
        return np.asarray(matrices_of_poses(carrier) @ X_PL)

    def _fix_grasps(self) -> list[tuple[Floats, Floats]]:
        """Return X_LF (4, 4) at the start of each grasp, and the pose (7,) at its end."""
        fixed: list[tuple[Floats, Floats]] = []
        resting = {name: frame.matrices(0.0) for name, frame in self.free.items()}
        for grasp in self.grasps:
            X_WL_start, X_WL_end = self._X_WL(grasp.link, [grasp.start, grasp.end])
            X_LF = inverse(X_WL_start) @ resting[grasp.frame]
            resting[grasp.frame] = X_WL_end @ X_LF
            fixed.append((X_LF, poses_of_matrices(resting[grasp.frame])))
        return fixed

    def _refuse_unknown_carrier(self, grasp: Grasp) -> None:
        """Raise ValueError if the pose of a grasp's robot is unknown."""
        carrier = self.robots[grasp.link[0]].carrier
        while carrier is not None and carrier[0] in self.robots:
            carrier = self.robots[carrier[0]].carrier
        if carrier is None:
            return
        if carrier not in self.free or any(other.frame == carrier for other in self.grasps):
            raise ValueError(
                f'grasp by {full_name(grasp.link)!r}: its robot is mounted on '
                f'{full_name(carrier)!r}, which must be a frame with poses that nothing grasps'
            )

    def _check_grasps(self) -> None:
        links = {(source, n) for source in self.robots for n in self.frame_names[source]}
        free_from: dict[Frame, float] = {}
        for grasp in self.grasps:
            of = f'grasp of {full_name(grasp.frame)!r}'
            unknown = [n for n in (grasp.link, *grasp.gripper) if n not in links]
            if unknown or grasp.frame not in self.free:
                existing = sorted(map(full_name, links if unknown else self.free))
                raise ValueError(
                    f'{of} by {full_name(grasp.link)!r}: '
                    f'{full_name(unknown[0] if unknown else grasp.frame)!r} is no '
                    f'{"link of a robot" if unknown else "free frame"}; there are '
                    f'{", ".join(existing) or "none"}'
                )
            self._refuse_unknown_carrier(grasp)
            if self.free[grasp.frame].moves:
                raise ValueError(f'{of}: the frame has timed poses as well')
            if not free_from.get(grasp.frame, 0.0) <= grasp.start < grasp.end:
                raise ValueError(
                    f'{of} from {grasp.start} s to {grasp.end} s must start '
                    f'at {free_from.get(grasp.frame, 0.0)} s or later and end after its start'
                )
            free_from[grasp.frame] = grasp.end
