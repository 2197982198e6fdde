"""Motion files: YAML with the joint waypoints of robots, grasps, and timed poses of free frames.

::

    robots:
      left:                                  # a robot of the scene
        joints: [panda_joint1, panda_joint2] # the others stay as the scene file has them
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

Frames are named ``source::frame``; names may contain ``::``, and an ambiguous text is an error.
``motion.schema.json`` is the complete schema. A CSV file has timed poses only: see
``read_timed_poses``.
"""

from collections.abc import Callable, Mapping
from functools import partial
from itertools import combinations
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.common.frame_names import Frame, FrameNames, full_name
from drake_geom_ros.scene_files import urdf_filters
from drake_geom_ros.scene_files.description import WORLD, SceneDescription
from drake_geom_ros.scene_files.errors import SceneFileError, unreadable
from drake_geom_ros.scene_files.schema import check_schema, read_schema
from drake_geom_ros.scene_files.yaml_text import Document, KeyPath, read_yaml, text_of
from drake_geom_ros.trajectories.interpolation import MonotoneCubic
from drake_geom_ros.trajectories.kinematics import Kinematics
from drake_geom_ros.trajectories.motion import Grasp, Motion, RobotMotion
from drake_geom_ros.trajectories.timed_poses import TimedPoses, read_timed_poses

_Made = TypeVar('_Made')


def load_motion(path: str | Path | None, scene: SceneDescription) -> Motion:
    """Return the motion of a file in a scene; without a file nothing moves.

    Robots without waypoints have the configuration of the scene file, joints without a value are
    at 0, and other frames have the pose of that file. Frames without a pose in either file are
    left out: links below a planar or floating joint without values, and robots whose URDF is not a
    tree of supported joints, which are listed in ``Motion.left_out``. Other programs may move
    them.

    Raises SceneFileError, with file, line and key, for a file of another form, for names that the
    scene lacks, for a joint beyond its limits, and for a robot that is left out.
    """
    X_WBs = {r.name: r.X_WB.GetAsMatrix4() for r in scene.robots if r.tree is not None}
    standing = {robot.name: robot.configuration for robot in scene.robots}
    carriers = {
        r.name: (r.mounted_on.source, r.mounted_on.frame) for r in scene.robots if r.mounted_on
    }
    arms, left_out = _arms(scene)
    document = _read(path)
    curves: dict[str, MonotoneCubic] = {}
    with_values: dict[str, frozenset[str]] = {}
    grasps: list[Mapping[str, Any]] = []
    if isinstance(document, Document):
        reader = _MotionReader(document)
        curves, with_values = reader.curves(arms, left_out, standing), reader.joints()
        grasps, timed = reader.grasps(), reader.frames()
    else:
        timed = document
    motions = {
        name: RobotMotion(
            *(arm, X_WBs[name], curves.get(name) or _rest(arm, standing[name])),
            given=with_values.get(name, frozenset()) | standing[name].keys(),
            carrier=carriers.get(name),
        )
        for name, arm in arms.items()
    }
    try:
        names = _names(scene, motions)
        free = {_found(names, text): poses for text, poses in timed.items()}
        held = [_grasp(scene, names, grasp) for grasp in grasps]
        return Motion(motions, {**_still(scene), **free}, held, left_out)
    except ValueError as error:
        raise SceneFileError(str(error), str(path)) from error


def adjacent_links(scene: SceneDescription) -> list[tuple[str, str]]:
    """Return the pairs of adjacent links of a scene's robots, as ``source::frame``."""
    return [
        (full_name((robot.name, a)), full_name((robot.name, b)))
        for robot in scene.robots
        if robot.tree is not None
        for each in urdf_filters.adjacent_links(
            robot.tree.joints, {g.frame for g in scene.geometries if g.source == robot.name}
        )
        for a, b in combinations(each.links, 2)
    ]


def _arms(scene: SceneDescription) -> tuple[dict[str, Kinematics], dict[str, str]]:
    """Return the kinematics of robots, and the reasons of those without."""
    arms: dict[str, Kinematics] = {}
    left_out: dict[str, str] = {}
    for robot in scene.robots:
        if robot.tree is None:
            continue
        try:
            arms[robot.name] = Kinematics(robot.tree)
        except ValueError as error:
            left_out[robot.name] = str(error)
    return arms, left_out


def _still(scene: SceneDescription) -> dict[Frame, TimedPoses]:
    """Return the frames of no robot with a pose in the scene file."""
    robots = {robot.name for robot in scene.robots}
    return {
        (frame.source, frame.name): TimedPoses([0.0], [frame.X_PF.ToArray()])
        for frame in scene.frames
        if frame.source not in robots and frame.X_PF is not None and frame.attached_to is None
    }


def _grasp(scene: SceneDescription, names: FrameNames, entry: Mapping[str, Any]) -> Grasp:
    """Return the grasp of an entry of a motion file."""
    try:
        frame, link = _found(names, entry['frame']), _found(names, entry['link'])
        gripper = tuple(_found(names, text) for text in entry['gripper'])
    except ValueError as error:
        raise ValueError(f'grasp of {entry["frame"]!r}: {error}') from None
    parents = {(each.source, each.name): each.parent for each in scene.frames}
    if parents.get(frame, WORLD) != WORLD:
        raise ValueError(
            f'grasp of {full_name(frame)!r}: its parent is {parents[frame]!r}; only a '
            'frame whose parent is the world can follow a link'
        )
    return Grasp(frame, link, gripper, entry['start'], entry['end'])


def _names(scene: SceneDescription, robots: Mapping[str, RobotMotion]) -> FrameNames:
    """Return the frames of a scene and the links of its robots."""
    links = ((name, link) for name, r in robots.items() for link in r.kinematics.link_names)
    return FrameNames([*((frame.source, frame.name) for frame in scene.frames), *links])


def _found(names: FrameNames, text: str) -> Frame:
    frame = names.find(text)
    if frame is None:
        raise ValueError(f'the scene has no frame {text!r}; it has {", ".join(names)}')
    return frame


def _read(path: str | Path | None) -> Document | dict[str, TimedPoses]:
    if path is None:
        return {}
    path = Path(path)
    try:
        if path.suffix == '.csv':
            return read_timed_poses(path)
        return read_yaml(text_of(path.read_bytes(), str(path)), str(path))
    except OSError as error:
        raise unreadable(str(path), error) from error


def _rest(kinematics: Kinematics, configuration: Mapping[str, float]) -> MonotoneCubic:
    """Return the constant curve of a robot at rest."""
    q = kinematics.at_rest(configuration)
    return MonotoneCubic([0.0, 1.0], [q, q])


class _MotionReader:
    """Reader of the parts of a valid motion file; each error has its location."""

    def __init__(self, document: Document):
        check_schema(document, read_schema('drake_geom_ros.trajectories', 'motion.schema.json'))
        self._document = document

    def _part(self, key: str) -> Any:
        """Return a part of the file, empty if it is missing or empty."""
        return self._document.value.get(key) or {}

    def joints(self) -> dict[str, frozenset[str]]:
        """Return the joints of each robot that the file moves."""
        return {name: frozenset(e['joints']) for name, e in self._part('robots').items()}

    def curves(
        self,
        kinematics: Mapping[str, Kinematics],
        left_out: Mapping[str, str],
        standing: Mapping[str, Mapping[str, float]],
    ) -> dict[str, MonotoneCubic]:
        """Return the joint curves of every robot that the file moves."""
        curves = {}
        for name, entry in self._part('robots').items():
            if name in left_out:
                raise self._error(left_out[name], 'robots', name)
            if name not in kinematics:
                there = ', '.join(kinematics) or 'none'
                raise self._error(
                    f'the scene has no such robot; there are {there}', 'robots', name
                )
            robot = kinematics[name]
            at_rest = robot.at_rest(standing[name])
            curves[name] = self._curve(entry, robot, at_rest, ('robots', name))
        return curves

    def _curve(
        self, entry: Any, robot: Kinematics, at_rest: NDArray[np.float64], path: KeyPath
    ) -> MonotoneCubic:
        names, waypoints = entry['joints'], entry['waypoints']
        for index, name in enumerate(names):
            if name not in robot.joint_names or name in names[:index]:
                raise self._error(
                    f'{name!r} is not one of {", ".join(robot.joint_names)}, or is listed twice',
                    *(*path, 'joints', index),
                )
        path = (*path, 'waypoints')
        for k, waypoint in enumerate(waypoints):
            if len(waypoint['q']) != len(names):
                reason = f'{len(waypoint["q"])} numbers; {len(names)} are needed'
                raise self._error(reason, *path, k, 'q')
        columns = [robot.joint_names.index(name) for name in names]
        q = np.repeat(at_rest[None], len(waypoints), axis=0)
        q[:, columns] = np.array([w['q'] for w in waypoints]).reshape(-1, len(names))
        beyond = (q < robot.lower) | (q > robot.upper)
        if bad := [(k, j) for k, j in np.argwhere(beyond).tolist() if j in columns]:
            k, j = bad[0]
            raise self._error(
                f'{robot.joint_names[j]} = {q[k, j]} must lie in '
                f'[{robot.lower[j]}, {robot.upper[j]}]',
                *(*path, k, 'q'),
            )
        curve = self._checked(lambda: MonotoneCubic([w['at'] for w in waypoints], q), path)
        speeds = curve.max_speed()
        if (too_fast := speeds > robot.max_speed).any():
            j = int(np.argmax(too_fast))
            raise self._error(
                f'{robot.joint_names[j]} reaches {speeds[j]:.3g} per second; at most '
                f'{robot.max_speed[j]} is allowed: leave more time between the waypoints',
                *path,
            )
        return curve

    def grasps(self) -> list[Mapping[str, Any]]:
        """Return the entries of grasps."""
        return list(self._part('grasps'))

    def frames(self) -> dict[str, TimedPoses]:
        """Return the free frames with timed poses."""
        return {
            name: self._checked(partial(_timed_poses, rows), ('frames', name))
            for name, rows in self._part('frames').items()
        }

    def _checked(self, make: Callable[[], _Made], path: KeyPath) -> _Made:
        try:
            return make()
        except (ValueError, RuntimeError) as error:
            raise self._error(str(error), *path) from error

    def _error(self, reason: str, *path: str | int) -> SceneFileError:
        return self._document.at(*path).error(reason)


def _timed_poses(rows: list[dict[str, Any]]) -> TimedPoses:
    poses = np.array([row['pose'] for row in rows], dtype=float).reshape(-1, 7)
    return TimedPoses([row['at'] for row in rows], poses)
