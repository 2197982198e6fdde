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
from drake_geom_ros.command_line.posed_scene import PosedScene
from drake_geom_ros.geometry import ArgumentError, FramePoseVector
from drake_geom_ros.scene_files import SceneFileError


def add_joints_to(parser: argparse.ArgumentParser) -> None:
    """Add ``--joints`` to the arguments of a command."""
    parser.add_argument(
        '--joints',
        nargs='+',
        default=[],
        metavar='NAME=VALUE',
        help='joint values [rad] or [m], as left::panda_joint4=-1.5; a name that one robot alone '
        'has needs no robot. Others stand as the scene file says, or at 0, or at their limit '
        'nearest to it',
    )


def add_states_to(parser: argparse.ArgumentParser | argparse._MutuallyExclusiveGroup) -> None:
    """Add ``--states`` to the arguments of a command."""
    parser.add_argument(
        '--states',
        metavar='FILE',
        help='states one after another, .npy, .npz or .csv as for batch',
    )


def pose_joints(scene: PosedScene, given: Sequence[str]) -> dict[str, float]:
    """Pose a scene's robots by texts ``NAME=VALUE``, and return the values by their full names.

    What is beyond its limits is told on standard error, and shown. Raises SceneFileError for what
    is no joint of the scene, or no number.
    """
    if not given:
        return {}
    joints = Joints.of(scene.loaded)
    values: dict[str, float] = {}
    for text in given:
        name, _, number = text.partition('=')
        full = _full_name(name, joints.names)
        if full in values:
            raise SceneFileError(f'{full} is given twice', '--joints')
        try:
            values[full] = float(number)
        except ValueError:
            raise SceneFileError(f'{text!r} must be NAME=VALUE', '--joints') from None
        if not math.isfinite(values[full]):
            raise SceneFileError(f'{text!r}: a joint value must be finite', '--joints')
    some = Joints.of(scene.loaded, list(values))
    state = np.array([list(values.values())])
    _tell_limits(some, state)
    scene.context.UpdateFramePoses(
        FramePoseVector.FromArrays(some.frame_ids, some.poses(state)[0])
    )
    return values


class StatePoses(NamedTuple):
    """States: the poses of each, and its joint values by ``robot::joint``, none of poses."""

    poses: list[FramePoseVector]
    values: list[dict[str, float]]


def poses_of_states(scene: PosedScene, file: str) -> StatePoses:
    """Return the states of a file; raises SceneFileError for what does not fit the scene."""
    values: list[dict[str, float]] = []
    states = read_states(file)
    if states.are_poses:
        known = {f'{source}::{frame}': id for (source, frame), id in scene.loaded.frames.items()}
        names = states.names or ()
        if unknown := [name for name in names if name not in known]:
            raise SceneFileError(f'the scene has no frame {unknown[0]!r}', file)
        ids, poses = [known[name] for name in names], states.rows[:]
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
        _tell_limits(joints, rows)
        ids, poses = joints.frame_ids, joints.poses(rows)
        values = [dict(zip(joints.names, row, strict=True)) for row in rows.tolist()]
    if not len(poses):
        raise SceneFileError('there is no state in it', file)
    return StatePoses([FramePoseVector.FromArrays(ids, each) for each in poses], values)


def _full_name(name: str, known: Sequence[str]) -> str:
    """Return ``robot::joint`` of a joint's name, with or without its robot."""
    found = [full for full in known if full == name or full.endswith(f'::{name}')]
    if name in known:
        return name
    if len(found) != 1:
        problem = f'{" and ".join(found)} are called so' if found else 'no joint is called so'
        raise SceneFileError(f'{name!r}: {problem}; there are {", ".join(known)}', '--joints')
    return found[0]


def _tell_limits(joints: Joints, states: np.ndarray) -> None:
    """Tell on standard error which joints are beyond their limits, and in how many states."""
    beyond = ((states < joints.lower) | (states > joints.upper)).sum(axis=0)
    for name, low, high, count in zip(
        joints.names, joints.lower, joints.upper, beyond.tolist(), strict=True
    ):
        if count:
            of = f' in {count} of {len(states)} states' if len(states) > 1 else ''
            print(
                f'warning: {name} is outside its limits [{low:g}, {high:g}]{of}', file=sys.stderr
            )
