"""``Joints``: the joints of states given by joint values, and the poses of their robots."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.common.tables import html_table
from drake_geom_ros.geometry import ArgumentError, FrameId
from drake_geom_ros.geometry.queries.joint_trees import JointChain, JointTree, side_by_side
from drake_geom_ros.math.array_types import Floats, Indices
from drake_geom_ros.scene_files import LoadedScene
from drake_geom_ros.trajectories.kinematics import Kinematics


@dataclass(frozen=True, eq=False)
class Arm:
    """A robot for workers: its joints, its base X_WB (7,), and the links that are frames.

    W is the frame that carries the robot, if it is mounted on one: poses are those in parents.
    """

    tree: JointTree  # driven by the joint values of a state
    X_WB: Floats
    links: Indices


class Joints:
    """The joints of the columns of states (N, ``count``), by ``robot::joint``.

    ``lower`` and ``upper`` (count,) are their limits [rad] or [m], infinite without a limit.
    Joints without a column keep the value of the scene file's configuration, or else 0, or the
    limit nearest to 0.
    """

    def __init__(
        self,
        names: Sequence[str],
        lower: Floats,
        upper: Floats,
        ids: Indices,
        arms: tuple[Arm, ...],
    ) -> None:
        self.names = tuple(names)
        self.lower, self.upper = lower, upper
        self.id_values = ids  # (n,) of the frames that the robots pose
        self.arms = arms

    def __repr__(self) -> str:
        return f'<Joints: {self.count} of {len(self.arms)} robots, {", ".join(self.names)}>'

    def _repr_html_(self) -> str:
        """Return the joints and their limits as a table, for notebooks."""
        columns = {'joint': self.names, 'lower': self.lower.tolist(), 'upper': self.upper.tolist()}
        return html_table(f'Joints: {self.count} of {len(self.arms)} robots', columns)

    @property
    def count(self) -> int:
        """The number of columns."""
        return len(self.names)

    @property
    def frame_ids(self) -> list[FrameId]:
        """The frames whose poses ``poses`` returns."""
        return [FrameId(value) for value in self.id_values.tolist()]

    def poses(self, states: NDArray[np.float64]) -> Floats:
        """Return the poses (N, n, 7), x y z [m] qx qy qz qw, of ``frame_ids`` in states (N, q).

        Raises ArgumentError for states of another shape.
        """
        rows = np.asarray(states, dtype=np.float64)
        if rows.ndim != 2 or rows.shape[1] != self.count:
            raise ArgumentError(
                f'states has the shape {rows.shape}; it must be (N, {self.count}), one value each '
                f'for {", ".join(self.names)}'
            )
        return poses_of_arms(self.arms, rows)

    @classmethod
    def of(cls, loaded: LoadedScene, names: Sequence[str] | None = None) -> Joints:
        """Return all joints of a scene's robots, or those of ``names`` in this order.

        A planar or floating joint has several values: see ``Kinematics``. Links below one without
        a column for each of them are not posed. Raises ArgumentError for an unknown or duplicate
        name, for a scene without robots, and for a robot that is no tree of joints.
        """
        robots = loaded.robots
        try:
            kinematics_of = {r.name: Kinematics(r.tree) for r in robots.values() if r.tree}
        except ValueError as error:
            raise ArgumentError(f'{error}; give poses of frames instead of joint values') from None
        every = [
            f'{name}::{joint}' for name, k in kinematics_of.items() for joint in k.joint_names
        ]
        if not every:
            raise ArgumentError('joint values were given, but the scene has no robot with joints')
        chosen = every if names is None else list(names)
        for name in chosen:
            if every.count(name) > 1:
                raise ArgumentError(
                    f'joint {name!r} is the name of joints of two robots, whose names hold `::`; '
                    'rename one of the robots'
                )
            if name not in every or chosen.count(name) > 1:
                raise ArgumentError(
                    f'joint {name!r} is not one of the scene, or is named twice; '
                    f'there are {", ".join(every)}'
                )
        arms: list[Arm] = []
        ids: list[int] = []
        limits: dict[str, tuple[float, float]] = {}
        for name, kinematics in kinematics_of.items():
            own = [f'{name}::{joint}' for joint in kinematics.joint_names]
            limits |= dict(
                zip(own, zip(kinematics.lower, kinematics.upper, strict=True), strict=True)
            )
            standing = robots[name].configuration
            with_values = [
                j for j in kinematics.joint_names if f'{name}::{j}' in chosen or j in standing
            ]
            links = [
                k
                for k in kinematics.placed_links(with_values)
                if (name, kinematics.link_names[k]) in loaded.frames
            ]
            ids += [loaded.frames[name, kinematics.link_names[k]].get_value() for k in links]
            columns = [chosen.index(joint) if joint in chosen else -1 for joint in own]
            at_rest = kinematics.at_rest(standing)
            tree = kinematics.tree.driven_by(np.array(columns, dtype=np.int64), at_rest)
            X_WB = robots[name].X_WB.ToArray()
            arms.append(Arm(tree, X_WB, np.array(links, dtype=np.int64)))
        lower, upper = np.array([limits[name] for name in chosen]).T
        return cls(chosen, lower, upper, np.array(ids, dtype=np.int64), tuple(arms))


def chain_of_arms(arms: tuple[Arm, ...]) -> JointChain:
    """Return all arms as one chain, with links in the order of ``poses_of_arms``."""
    return side_by_side(
        [arm.tree for arm in arms],
        np.array([arm.X_WB for arm in arms]),
        [arm.links for arm in arms],
    )


def still_poses(arms: tuple[Arm, ...], ids: Indices) -> dict[int, Floats]:
    """Return the poses (7,) of the arms' frames, with ``ids`` (n,), that no state moves."""
    if not arms:
        return {}
    columns = 1 + max((int(arm.tree.leaders.max(initial=-1)) for arm in arms), default=-1)
    (poses,) = poses_of_arms(arms, np.zeros((1, columns)))
    still = np.concatenate([arm.tree.still_links()[arm.links] for arm in arms])
    return {int(id): pose for id, pose in zip(ids[still], poses[still], strict=True)}


def poses_of_arms(arms: tuple[Arm, ...], states: Floats) -> Floats:
    """Return the poses (N, n, 7) of all links that are frames, for joint values (N, q)."""
    values = np.ascontiguousarray(states, dtype=np.float64)
    poses = np.empty((len(values), sum(len(arm.links) for arm in arms), 7))
    first = 0
    for arm in arms:
        arm.tree.put_poses(values, arm.X_WB, arm.links, poses, first)
        first += len(arm.links)
    return poses
