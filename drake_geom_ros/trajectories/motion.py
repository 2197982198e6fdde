"""What every moving frame of a scene does over time: robots, grasped objects, free frames."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike, NDArray

from drake_geom_ros.common.frame_names import Frame, full_name
from drake_geom_ros.scene_files.description import WORLD
from drake_geom_ros.trajectories.interpolation import MonotoneCubic
from drake_geom_ros.trajectories.kinematics import Kinematics
from drake_geom_ros.trajectories.pose_matrices import inverse, poses_of_matrices
from drake_geom_ros.trajectories.timed_poses import TimedPoses

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class RobotMotion:
    """A robot on its base pose X_WB (4, 4), and its joint values over time.

    ``given`` are the joints that somebody gave values; the others are at rest, and a link below a
    planar or floating one of them stands nowhere.
    """

    kinematics: Kinematics
    X_WB: Floats
    joint_values: MonotoneCubic
    given: frozenset[str] = frozenset()

    def moved_links(self) -> list[int]:
        """Return the rows of the links that are frames of the scene, and stand somewhere."""
        # A link called as the world is no frame: see scene_files/urdf.py.
        links = self.kinematics.link_names
        return [k for k in self.kinematics.placed_links(self.given) if links[k] != WORLD]

    def link_transforms(self, t: ArrayLike) -> Floats:
        """Return X_WL of every link (..., links, 4, 4) at times t (...) [s]."""
        return self.kinematics.link_transforms(self.joint_values.value(t), self.X_WB)


@dataclass(frozen=True)
class Grasp:
    """From ``start`` to ``end`` [s] a frame follows a robot's link; frames go by source and name.

    ``gripper`` are the frames that touch it on purpose meanwhile.
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
    """The poses X_WF of all frames that a player moves, at any time of a motion.

    ``robots`` by source name, ``free`` frames by source and name. A frame with grasps stands
    at its first free pose until the first of them, and stays wherever each one leaves it.
    """

    def __init__(
        self,
        robots: Mapping[str, RobotMotion],
        free: Mapping[Frame, TimedPoses],
        grasps: Sequence[Grasp] = (),
        left_out: Mapping[str, str] = MappingProxyType({}),
    ):
        """Raise ValueError for a grasp of or by an unknown frame, or one during another.

        ``left_out`` are the robots of the scene that no joint values can pose, and why.
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
        """The time [s] after which nothing moves any more."""
        ends = [robot.joint_values.times[-1] for robot in self.robots.values()]
        ends += [frame.end for frame in self.free.values()] + [g.end for g in self.grasps]
        return float(max(ends, default=0.0))

    def poses(self, t: ArrayLike) -> dict[str, Floats]:
        """Return of each source X_WF of its ``frame_names`` as (..., frames, 7) at times t (...).

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
                frames = [self._free_pose((source, name), t, links) for name in names]
                poses[source] = np.stack(frames, axis=-2)
        return poses

    def held(self, t: float) -> tuple[Grasp, ...]:
        """Return the grasps that hold at a time t [s]."""
        return tuple(grasp for grasp in self.grasps if grasp.holds(t))

    def _free_pose(self, frame: Frame, t: Floats, links: Mapping[str, Floats]) -> Floats:
        """Return the pose of a free frame (..., 7), given the robots' links at the same times."""
        pose = self.free[frame].poses(t)
        for grasp, (X_LF, pose_end) in zip(self.grasps, self._held_poses, strict=True):
            if grasp.frame != frame:
                continue
            robot, link = self._link_of(grasp)
            X_WF = links[robot][..., link, :, :] @ X_LF
            during = ((t >= grasp.start) & (t < grasp.end))[..., None]
            pose = np.where(during, poses_of_matrices(X_WF), pose)
            pose = np.where((t >= grasp.end)[..., None], pose_end, pose)
        return pose

    def _fix_grasps(self) -> list[tuple[Floats, Floats]]:
        """Return of each grasp X_LF (4, 4), taken at its start, and the pose (7,) it ends with."""
        fixed: list[tuple[Floats, Floats]] = []
        resting = {name: frame.matrices(0.0) for name, frame in self.free.items()}
        for grasp in self.grasps:
            robot, link = self._link_of(grasp)
            X_WL_start, X_WL_end = self.robots[robot].link_transforms([grasp.start, grasp.end])[
                :, link
            ]
            X_LF = inverse(X_WL_start) @ resting[grasp.frame]
            resting[grasp.frame] = X_WL_end @ X_LF
            fixed.append((X_LF, poses_of_matrices(resting[grasp.frame])))
        return fixed

    def _link_of(self, grasp: Grasp) -> tuple[str, int]:
        robot, link = grasp.link
        return robot, self.robots[robot].kinematics.link_names.index(link)

    def _check_grasps(self) -> None:
        links = {(source, n) for source in self.robots for n in self.frame_names[source]}
        free_from: dict[Frame, float] = {}
        for grasp in self.grasps:
            of = f'grasp of {full_name(grasp.frame)!r}'
            unknown = [n for n in (grasp.link, *grasp.gripper) if n not in links]
            if unknown or grasp.frame not in self.free:
                known = sorted(map(full_name, links if unknown else self.free))
                raise ValueError(
                    f'{of} by {full_name(grasp.link)!r}: '
                    f'{full_name(unknown[0] if unknown else grasp.frame)!r} is no '
                    f'{"link of a robot" if unknown else "free frame"}; there are '
                    f'{", ".join(known) or "none"}'
                )
            if self.free[grasp.frame].moves:
                raise ValueError(f'{of}: the frame has timed poses as well')
            if not free_from.get(grasp.frame, 0.0) <= grasp.start < grasp.end:
                raise ValueError(
                    f'{of} from {grasp.start} s to {grasp.end} s must start '
                    f'at {free_from.get(grasp.frame, 0.0)} s or later and end after its start'
                )
            free_from[grasp.frame] = grasp.end
