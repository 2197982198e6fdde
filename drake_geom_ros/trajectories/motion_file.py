"""Motion files: YAML with the joint waypoints of robots, grasps, and timed poses of free frames.

::

    robots:
      left:                                  # a robot of the scene
        joints: [panda_joint1, panda_joint2] # the others stay at 0, or at their limit nearest to 0
        waypoints:
        - {at: 0.0, q: [0.0, -0.3]}          # at [s], q [rad] or [m] in the order of joints
        - {at: 2.0, q: [0.5, 0.1]}
    grasps:
    - {frame: objects::can, link: left::panda_hand, gripper: [left::panda_leftfinger],
       start: 1.0, end: 1.5}                 # meanwhile the frame follows the link
    frames:
      objects::ball:
      - {at: 0.0, pose: [0, 0, 1, 0, 0, 0, 1]}  # x y z [m], qx qy qz qw
      - {at: 1.0, pose: [0, 0, 2, 0, 0, 0, 1]}

A CSV file instead holds timed poses alone, see ``read_timed_poses``.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.scene_files.description import WORLD, SceneDescription
from drake_geom_ros.scene_files.errors import SceneFileError
from drake_geom_ros.scene_files.yaml_text import Document, read_yaml
from drake_geom_ros.trajectories.interpolation import MonotoneCubic
from drake_geom_ros.trajectories.kinematics import Kinematics
from drake_geom_ros.trajectories.motion import Grasp, Motion, RobotMotion
from drake_geom_ros.trajectories.timed_poses import TimedPoses, read_timed_poses

Floats = NDArray[np.float64]


def load_motion(path: str | Path | None, scene: SceneDescription) -> Motion:
    """Return the motion of a file in a scene; without a file everything stands still.

    Robots without waypoints stand at 0, other frames where the scene file says. Frames of which
    neither file tells a pose are left out, for somebody else to move.
    Raises SceneFileError, naming file, line and key, for a file that is not of the form above,
    names what the scene has not, or drives a joint beyond its limits; and for a URDF that is not
    a tree of simple joints.
    """
    robots = {robot.name: robot for robot in scene.robots if robot.urdf is not None}
    kinematics = {path: _kinematics(path) for path in {r.urdf for r in robots.values()}}
    document = _read(path)
    curves, grasps, timed = {}, [], {}
    if isinstance(document, Document):
        reader = _Reader(document)
        curves = reader.curves({name: kinematics[r.urdf] for name, r in robots.items()})
        grasps, timed = reader.grasps(), reader.frames()
    else:
        timed = document
    motions = {}
    for name, robot in robots.items():
        arm = kinematics[robot.urdf]
        curve = curves.get(name) or _rest(arm)
        motions[name] = RobotMotion(arm, robot.X_WB.GetAsMatrix4(), curve)
    try:
        _check_frames(scene, timed, grasps)
        return Motion(motions, {**_still(scene), **timed}, grasps)
    except ValueError as error:
        raise SceneFileError(str(error), str(path)) from error


def adjacent_links(scene: SceneDescription) -> list[tuple[str, str]]:
    """Return the two links of every joint of a scene's robots, as ``source::frame``."""
    return [
        (f'{robot.name}::{parent}', f'{robot.name}::{child}')
        for robot in scene.robots
        if robot.urdf is not None
        for parent, child in _kinematics(robot.urdf).joined_links
    ]


def _kinematics(urdf: Path) -> Kinematics:
    try:
        return Kinematics(str(urdf))
    except ValueError as error:
        raise SceneFileError(str(error), str(urdf)) from error


def _still(scene: SceneDescription) -> dict[str, TimedPoses]:
    """Return the frames of no robot that the scene file gives a pose."""
    robots = {robot.name for robot in scene.robots}
    return {
        f'{frame.source}::{frame.name}': TimedPoses([0.0], [frame.X_PF.ToArray()])
        for frame in scene.frames
        if frame.source not in robots and frame.X_PF is not None
    }


def _check_frames(
    scene: SceneDescription, timed: Mapping[str, TimedPoses], grasps: list[Grasp]
) -> None:
    parents = {f'{frame.source}::{frame.name}': frame.parent for frame in scene.frames}
    for name in timed:
        if name not in parents:
            raise ValueError(f'the scene has no frame {name!r}; it has {", ".join(parents)}')
    for grasp in grasps:
        if parents.get(grasp.frame, WORLD) != WORLD:
            raise ValueError(
                f'grasp of {grasp.frame!r}: its parent is {parents[grasp.frame]!r}; only a '
                'frame whose parent is the world can follow a link'
            )


def _read(path: str | Path | None) -> Document | dict[str, TimedPoses]:
    if path is None:
        return {}
    path = Path(path)
    try:
        if path.suffix == '.csv':
            return read_timed_poses(path)
        return read_yaml(path.read_text(encoding='utf-8'), str(path))
    except (OSError, ValueError) as error:
        raise SceneFileError(str(error), str(path)) from error


def _rest(kinematics: Kinematics) -> MonotoneCubic:
    """Return the curve of a robot that stands still."""
    q = np.clip(0.0, kinematics.lower, kinematics.upper)
    return MonotoneCubic([0.0, 1.0], [q, q])


class _Reader:
    """Takes the parts of a motion file, each error with its place."""

    def __init__(self, document: Document):
        self._document = document
        top = self._mapping(document.value, (), (), ('robots', 'grasps', 'frames'))
        self._robots = self._named(top.get('robots'), 'robots')
        self._grasps = self._list(top.get('grasps') or [], ('grasps',))
        self._frames = self._named(top.get('frames'), 'frames')

    def curves(self, kinematics: Mapping[str, Kinematics]) -> dict[str, MonotoneCubic]:
        """Return the joint curves of every robot that the file moves."""
        curves = {}
        for name, value in self._robots.items():
            if name not in kinematics:
                there = ', '.join(kinematics) or 'none'
                raise self._error(
                    f'the scene has no such robot; there are {there}', 'robots', name
                )
            curves[name] = self._curve(value, kinematics[name], ('robots', name))
        return curves

    def _curve(self, value: Any, robot: Kinematics, path: tuple) -> MonotoneCubic:
        entry = self._mapping(value, path, ('joints', 'waypoints'))
        names = self._list(entry['joints'], (*path, 'joints'))
        for index, name in enumerate(names):
            if name not in robot.joint_names or name in names[:index]:
                raise self._error(
                    f'{name!r} is not one of {", ".join(robot.joint_names)}, or is there twice',
                    *path,
                    'joints',
                    index,
                )
        times, values = self._timed(entry['waypoints'], (*path, 'waypoints'), 'q', len(names))
        columns = [robot.joint_names.index(name) for name in names]
        q = np.repeat(np.clip(0.0, robot.lower, robot.upper)[None], len(times), axis=0)
        q[:, columns] = values
        if bad := np.argwhere((q < robot.lower) | (q > robot.upper)).tolist():
            k, j = bad[0]
            raise self._error(
                f'{robot.joint_names[j]} = {q[k, j]} must lie in '
                f'[{robot.lower[j]}, {robot.upper[j]}]',
                *path,
                'waypoints',
                k,
                'q',
            )
        curve = self._checked(lambda: MonotoneCubic(times, q), (*path, 'waypoints'))
        speeds = curve.max_speed()
        if (too_fast := speeds > robot.max_speed).any():
            j = int(np.argmax(too_fast))
            raise self._error(
                f'{robot.joint_names[j]} reaches {speeds[j]:.3g} per second; at most '
                f'{robot.max_speed[j]} is allowed: leave more time between the waypoints',
                *path,
                'waypoints',
            )
        return curve

    def grasps(self) -> list[Grasp]:
        """Return the grasps."""
        grasps = []
        for index, value in enumerate(self._grasps):
            path = ('grasps', index)
            keys = ('frame', 'link', 'gripper', 'start', 'end')
            entry = self._mapping(value, path, keys)
            grasps.append(
                Grasp(
                    frame=str(entry['frame']),
                    link=str(entry['link']),
                    gripper=tuple(map(str, self._list(entry['gripper'], (*path, 'gripper')))),
                    start=self._number(entry['start'], (*path, 'start')),
                    end=self._number(entry['end'], (*path, 'end')),
                )
            )
        return grasps

    def frames(self) -> dict[str, TimedPoses]:
        """Return the free frames with timed poses."""
        frames = {}
        for name, value in self._frames.items():
            path = ('frames', name)
            times, poses = self._timed(value, path, 'pose', 7)
            frames[name] = self._checked(lambda t=times, p=poses: TimedPoses(t, p), path)
        return frames

    def _timed(self, value: Any, path: tuple, key: str, width: int) -> tuple[list, Floats]:
        """Return times and values (k, width) of a list of ``{at: t, key: [...]}``."""
        times, rows = [], []
        for index, item in enumerate(self._list(value, path)):
            entry = self._mapping(item, (*path, index), ('at', key))
            times.append(self._number(entry['at'], (*path, index, 'at')))
            row = self._list(entry[key], (*path, index, key))
            if len(row) != width:
                raise self._error(f'{len(row)} numbers; {width} are wanted', *path, index, key)
            rows.append([self._number(v, (*path, index, key, i)) for i, v in enumerate(row)])
        return times, np.array(rows, dtype=float).reshape(-1, width)

    def _checked(self, make: Any, path: tuple) -> Any:
        try:
            return make()
        except (ValueError, RuntimeError) as error:
            raise self._error(str(error), *path) from error

    def _error(self, reason: str, *path: str | int) -> SceneFileError:
        return self._document.at(*path).error(reason)

    def _mapping(self, value: Any, path: tuple, needed: tuple, optional: tuple = ()) -> dict:
        if not isinstance(value, dict):
            raise self._error(f'a mapping with {", ".join(needed + optional)} is wanted', *path)
        for key in value:
            if key not in needed + optional:
                allowed = ', '.join(needed + optional)
                raise self._error(f'unknown key; allowed are {allowed}', *path, key)
        for key in needed:
            if key not in value:
                raise self._error(f'key {key!r} is missing', *path)
        return value

    def _named(self, value: Any, key: str) -> dict:
        if value is not None and not isinstance(value, dict):
            raise self._error('a mapping from names is wanted', key)
        return value or {}

    def _list(self, value: Any, path: tuple) -> list:
        if not isinstance(value, list):
            raise self._error('a list is wanted', *path)
        return value

    def _number(self, value: Any, path: tuple) -> float:
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise self._error(f'{value!r} is not a number', *path)
        return float(value)
