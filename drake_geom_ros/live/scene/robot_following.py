"""Links follow the base of their robot in "what if" questions as they do live.

The links of a robot are posed in the frame that carries it, beside the base and not on it. A
request that poses the base alone would leave them where they are live: the base would stand there
without its robot.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from typing import NamedTuple

import numpy as np

from drake_geom_ros.geometry import (
    ArgumentError,
    FrameId,
    FramePoseVector,
    QueryObject,
    SceneGraphInspector,
)
from drake_geom_ros.live.conversions.names import some_of
from drake_geom_ros.live.scene.clocks import ALWAYS
from drake_geom_ros.live.scene.driven_robot import Base, DrivenRobot
from drake_geom_ros.live.scene.feeders import MESSAGES
from drake_geom_ros.live.scene.held_scene import HeldScene
from drake_geom_ros.live.scene.scene_view import SceneView
from drake_geom_ros.math import RigidTransform


class _Moved(NamedTuple):
    """A robot whose base stands elsewhere than live; ``live`` is None where it waits there."""

    robot: DrivenRobot
    live: Base | None
    base: Base


def pose_followers(scene: HeldScene, view: SceneView, posed: Collection[int]) -> None:
    """Pose the links of the robots whose base stands elsewhere in ``view`` than live.

    ``posed`` are the frames, by the values of their ids, that the question poses itself. A robot
    on a link that follows, follows too.
    """
    done: dict[str, bytes] = {}
    for _ in range(len(scene.model.joints.robots)):
        moved = [
            m for m in _moved_robots(scene, view.query) if done.get(m.robot.name) != _bytes(m)
        ]
        if not moved:
            return
        for each in moved:
            done[each.robot.name] = _bytes(each)
            if poses := _following(scene, each, posed):
                view.context.UpdateFramePoses(FramePoseVector(poses))


def ends_with_followers(
    scene: HeldScene, query: QueryObject, ends: FramePoseVector, interpolation: str
) -> FramePoseVector:
    """Return where a motion of frames ends, with the links that follow a base.

    ``query`` is of its start. Each link moves as the base does if that goes straight without a
    turn, or by a screw. Raises ArgumentError for a turn by other interpolations, and for a base
    that is attached to a frame which moves.
    """
    posed = {frame.get_value() for frame in ends.ids()}
    X_PFs = {frame: ends.value(frame) for frame in ends.ids()}
    for robot in scene.model.joints.robots.values():
        rows = _rows_that_follow(scene, robot, posed)
        if robot.root is None or not rows or not query.is_placed(robot.root):
            continue
        if robot.root in X_PFs and robot.root.get_value() not in scene.model.attached:
            D = _displacement(robot, query.X_PF(robot.root), X_PFs[robot.root], interpolation)
            placed = [frame for frame in map(FrameId, rows) if query.is_placed(frame)]
            X_PFs.update((frame, D @ query.X_PF(frame)) for frame in placed)
    refuse_carried_robots(scene, [frame.get_value() for frame in X_PFs])
    return FramePoseVector(X_PFs) if len(X_PFs) > len(posed) else ends


def _displacement(
    robot: DrivenRobot, start: RigidTransform, end: RigidTransform, interpolation: str
) -> RigidTransform:
    """Return how a base and its links are displaced; raises ArgumentError for a turn by slerp."""
    turns = not np.array_equal(start.rotation().matrix(), end.rotation().matrix())
    if turns and interpolation != 'screw':
        raise ArgumentError(
            f'end turns the base of {robot.name!r}, whose links follow it. They do so rigidly by '
            "interpolation 'screw' alone: ask for that, or cut the motion into parts and pose the "
            'links in each'
        )
    return end @ start.inverse()


def refuse_carried_robots(scene: HeldScene, moving: Collection[int]) -> None:
    """Raise ArgumentError for a robot whose base is attached to one of the frames that move.

    Its links would stay where they are.
    """
    for robot in scene.model.joints.robots.values():
        if robot.root is None or robot.root_value not in scene.model.attached:
            continue
        if not set(robot.links.values()).difference(moving):
            continue
        if carriers := _carriers_of_base(scene.model.inspector, robot.root).intersection(moving):
            raise ArgumentError(_attached(scene, robot, carriers))


def refuse_twice_posed(scene: HeldScene, frames: set[int]) -> None:
    """Raise ArgumentError for frames, by the values of their ids, that are posed in two ways."""
    if frames:
        frame_names = scene.model.names.frame_names.items()
        names = [name for frame, name in frame_names if frame.get_value() in frames]
        raise ArgumentError(
            f'joints move {some_of(names)}, and poses pose them, too; leave them out of one'
        )


def _attached(scene: HeldScene, robot: DrivenRobot, carriers: set[int]) -> str:
    frame_names = scene.model.names.frame_names.items()
    name = next(name for frame, name in frame_names if frame.get_value() in carriers)
    return (
        f'the base of {robot.name!r} is attached to {name}, which moves, and the links of the '
        'robot follow it: what they meet on the way is not known. Detach it, or ask for the '
        'places one by one'
    )


def _moved_robots(scene: HeldScene, query: QueryObject) -> Iterator[_Moved]:
    """Yield the robots whose base stands elsewhere in ``query`` than live."""
    joints = scene.model.joints
    for robot in joints.robots.values():
        base = None if robot.root is None else joints.base(robot, query, ALWAYS)
        if base is None:
            continue
        live = joints.base(robot, scene.query, ALWAYS)
        if live is None or not np.array_equal(live.X_PB, base.X_PB):
            yield _Moved(robot, live, base)


def _following(
    scene: HeldScene, moved: _Moved, posed: Collection[int]
) -> dict[FrameId, RigidTransform]:
    """Return the poses X_PL of the links of a robot that follow its base."""
    robot, live, base = moved
    X_PFs: dict[FrameId, RigidTransform] = {}
    rows = _rows_that_follow(scene, robot, posed)
    if robot.base is not None or live is None:  # joint values pose them, as soon as it stands
        values = robot.positions()
        placed_rows = [
            r for f, r in rows.items() if not np.isnan(values[robot.joints_of([r])]).any()
        ]
        links = robot.link_poses(base, values, placed_rows)
        for value, row in zip(links.ids.tolist(), links.rows, strict=True):
            X_PFs[FrameId(value)] = RigidTransform.FromArray(row)
    if live is not None:
        D = RigidTransform.FromArray(base.X_PB) @ RigidTransform.FromArray(live.X_PB).inverse()
        for frame in map(FrameId, rows):
            if frame not in X_PFs and scene.query.is_placed(frame):
                X_PFs[frame] = D @ scene.query.X_PF(frame)
    return X_PFs


def _rows_that_follow(
    scene: HeldScene, robot: DrivenRobot, posed: Collection[int]
) -> dict[int, int]:
    """Return by frame the rows of the links that follow the base.

    Others are posed by the question or hang on another frame; or messages pose them one by one,
    and nothing moves them with the base.
    """
    is_driven = robot.base is not None
    fed = scene.poses.feeders.is_fed_by
    return {
        frame: row
        for row, frame in robot.links.items()
        if frame not in posed
        and frame not in scene.model.attached
        and (is_driven or not fed(MESSAGES, frame))
    }


def _carriers_of_base(inspector: SceneGraphInspector, root: FrameId) -> set[int]:
    """Return the frames that move an attached root link, and not the links of its robot alike."""
    shared = _line(inspector, inspector.GetHomeFrame(root))
    return _line(inspector, inspector.GetParentFrame(root)) - shared


def _line(inspector: SceneGraphInspector, frame: FrameId) -> set[int]:
    line, world = set[int](), inspector.world_frame_id()
    while frame != world and frame.get_value() not in line:
        line.add(frame.get_value())
        frame = inspector.GetParentFrame(frame)
    return line


def _bytes(moved: _Moved) -> bytes:
    return moved.base.X_PB.tobytes()
