"""Joint values on the command line: one configuration, or a file of states."""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from drake_geom_ros.batch import Joints
from drake_geom_ros.batch.state_files import read_states
from drake_geom_ros.command_line.opened_scene import OpenedScene
from drake_geom_ros.common.nearest import nearest
from drake_geom_ros.geometry import ArgumentError, FramePoseVector
from drake_geom_ros.scene_files import SceneFileError


def add_joints_to(parser: argparse.ArgumentParser) -> None:
    """Add ``--joints`` to the arguments of a command."""
    parser.add_argument(
        '--joints',
        action='append',
        default=[],
        metavar='NAME=VALUE',
        help='joint values [rad] or [m], as left::panda_joint4=-1.5; several may follow; a name '
        'that one robot alone has needs no robot. Others stand as the scene file says, or at 0, '
        'or at their limit nearest to it',
    )


def add_states_to(parser: argparse.ArgumentParser | argparse._MutuallyExclusiveGroup) -> None:
    """Add ``--states`` to the arguments of a command."""
    parser.add_argument(
        '--states',
        metavar='FILE',
        help='states one after another, .npy, .npz or .csv as for batch',
    )


def pose_joints(scene: OpenedScene, assignments: Sequence[str]) -> dict[str, float]:
    """Pose a scene's robots by texts ``NAME=VALUE``, and return the values by full names.

    Values beyond limits are applied, with a warning on standard error. Raises SceneFileError for
    an unknown joint, or a value that is no number.
    """
    if not assignments:
        return {}
    joints = Joints.of(scene.loaded)
    values: dict[str, float] = {}
    for text in assignments:
        name, _, number = text.partition('=')
        full = _full_name(name, joints.names)
        if full in values:
            raise SceneFileError(f'{full} is given twice', '--joints')
        try:
            values[full] = float(number)
        except ValueError:
            reason = f'{number!r} is no number' if number else 'it must be NAME=VALUE'
            raise SceneFileError(f'{text!r}: {reason}', '--joints') from None
        if not math.isfinite(values[full]):
            raise SceneFileError(f'{text!r}: a joint value must be finite', '--joints')
    some = Joints.of(scene.loaded, list(values))
    state = np.array([list(values.values())])
    _warn_of_limits(some, state)
    scene.context.UpdateFramePoses(
        FramePoseVector.FromArrays(some.frame_ids, some.poses(state)[0])
    )
    return values


class StatePoses(NamedTuple):
    """Frame poses of states, and their joint values by ``robot::joint``.

    States that are given as poses have no values.
    """

    poses: list[FramePoseVector]
    values: list[dict[str, float]]


def poses_of_states(scene: OpenedScene, file: str) -> StatePoses:
    """Return the states of a file; raises SceneFileError for states that do not fit the scene."""
    values: list[dict[str, float]] = []
    states = read_states(file)
    if states.are_poses:
        frame_ids = {
            f'{source}::{frame}': id for (source, frame), id in scene.loaded.frames.items()
        }
        names = states.names or ()
        if unknown := [name for name in names if name not in frame_ids]:
            raise SceneFileError(f'the scene has no frame {unknown[0]!r}', file)
        ids, poses = [frame_ids[name] for name in names], states.rows[:]
    else:
        try:
            joints = Joints.of(scene.loaded, states.names)
        except ArgumentError as error:
            raise SceneFileError(str(error), file) from None
        if states.rows.shape[1] != joints.count:
            raise SceneFileError(
                f'{states.rows.shape[1]} columns for {joints.count} joints: '
                f'{", ".join(joints.names)}',
                file,
            )
        rows = np.asarray(states.rows[:])
        if bad := np.flatnonzero(~np.isfinite(rows).all(axis=1)).tolist():
            raise SceneFileError(f'state {bad[0]} has a value that is not finite', file)
        _warn_of_limits(joints, rows)
        ids, poses = joints.frame_ids, joints.poses(rows)
        values = [dict(zip(joints.names, row, strict=True)) for row in rows.tolist()]
    if not len(poses):
        raise SceneFileError('there is no state in it', file)
    return StatePoses([FramePoseVector.FromArrays(ids, each) for each in poses], values)


def _full_name(name: str, joint_names: Sequence[str]) -> str:
    """Return ``robot::joint`` of a joint's name, with or without its robot."""
    matches = [full for full in joint_names if full == name or full.endswith(f'::{name}')]
    if name in joint_names:
        return name
    if len(matches) != 1:
        problem = f'{" and ".join(matches)} are called so' if matches else 'no joint is called so'
        short = [full.rpartition('::')[2] for full in joint_names]
        meant = nearest(name, [*joint_names, *short]) if not matches else ''
        names = ', '.join(joint_names)
        raise SceneFileError(f'{name!r}: {problem}{meant}; there are {names}', '--joints')
    return matches[0]


def _warn_of_limits(joints: Joints, states: np.ndarray) -> None:
    """Print warnings about joints beyond their limits, with the number of states."""
    beyond = ((states < joints.lower) | (states > joints.upper)).sum(axis=0)
    for name, low, high, count in zip(
        joints.names, joints.lower, joints.upper, beyond.tolist(), strict=True
    ):
        if count:
            of = f' in {count} of {len(states)} states' if len(states) > 1 else ''
            print(
                f'warning: {name} is outside its limits [{low:g}, {high:g}]{of}', file=sys.stderr
            )
