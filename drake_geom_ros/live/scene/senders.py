"""The senders of joint values, frame poses and transforms, and what two of them pose in turn.

A publisher is known by its identity, where the middleware gives one: ``Feeders`` notice that two
alternate. A recording does not: there
two senders of joint values differ in the names that they list, or else a joint jumps to another
place and back, again and again, faster than it can move.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Hashable, Iterable, Sequence
from typing import NamedTuple

import numpy as np

from drake_geom_ros.live.scene.driven_robot import DrivenRobot, JointValue
from drake_geom_ros.live.scene.feeders import Feeders
from drake_geom_ros.math.array_types import Floats

_REMEMBERED = 5.0  # [s] for which a jump is remembered, and two senders after the last one
_NANOSECONDS = 1e-9  # [s]
_FASTEST = 2.0 * math.pi  # [1/s] of a joint without a speed limit
_FASTER = 2.0  # than its speed limit: no joint that is measured is
_LEAST_JUMP = 0.002  # [rad] or [m]
_BACK = 0.05  # of a jump: nearer to where it began is back
_MANY_JUMPS = 3

Joint = tuple[str, int]  # robot and column


class _Course(NamedTuple):
    """The last two values of a joint, and when they were."""

    before: tuple[float, float]  # [s], [rad] or [m]
    last: tuple[float, float]


class Senders:
    """The senders of a scene's joints, frames and transforms."""

    def __init__(self, now: Callable[[], float]) -> None:
        """``now()`` [s] is of steady time."""
        self._now = now
        self._of_joints, self._of_frames = Feeders(now), Feeders(now)
        self._of_transforms = Feeders(now)
        self._on_transforms: tuple[frozenset[str], frozenset[int]] = frozenset(), frozenset()
        self._courses: dict[Joint, _Course] = {}
        self._jumped: dict[Joint, tuple[float, ...]] = {}  # when [s] it jumped and came back
        self._contested: dict[Joint, float] = {}  # when [s] that was the case of many

    def note_joints(self, sender: Hashable, joints: frozenset[Joint]) -> None:
        """Note who sent values of joints now."""
        self._of_joints.note(sender, joints)

    def note_frames(self, sender: Hashable, frames: frozenset[int]) -> None:
        """Note who sent poses of frames, by the values of their ids."""
        self._of_frames.note(sender, frames)

    def note_transforms(self, sender: Hashable, children: frozenset[str]) -> None:
        """Note who sent transforms of TF frames that move."""
        self._of_transforms.note(sender, children)

    def note_values(self, robot: DrivenRobot, columns: Collection[int]) -> None:
        """Note the values of joints that a sender without identity sent in one message.

        Another sender's message is between two of the same: all joints that are elsewhere in it
        are back in the next one.
        """
        gone, back = set[Joint](), set[Joint]()
        for column in columns:
            value = robot.values[column]
            if value is None:
                continue
            joint, fastest = (robot.name, column), _fastest(robot, column)
            here = _time_of(value), value.position
            course = self._courses.get(joint)
            if course is not None and _is_jump(*course, fastest):
                gone.add(joint)
                if _is_jump(course.last, here, fastest) and _is_back(*course, here):
                    back.add(joint)
            self._courses[joint] = _Course(here if course is None else course.last, here)
        if gone == back:
            self._note_jumps(back)

    def _note_jumps(self, joints: Collection[Joint]) -> None:
        """Note that joints jumped away and came back: once may be a glitch."""
        now = self._now()
        for joint in joints:
            times = self._jumped[joint] = (*self._jumped.get(joint, ()), now)[-_MANY_JUMPS:]
            if len(times) == _MANY_JUMPS and now - times[0] < _REMEMBERED:
                self._contested[joint] = now

    def contested_joints(self) -> list[Joint]:
        """Return the joints that two send in turn."""
        now = self._now()
        jumping = [joint for joint, at in self._contested.items() if now - at < _REMEMBERED]
        return list(dict.fromkeys([*self._of_joints.contested(), *jumping]))

    def note_frames_on(self, children: Collection[str], frames: Collection[int]) -> None:
        """Note which frames hang on contested TF frames."""
        self._on_transforms = frozenset(children), frozenset(frames)

    def contested_poses(self) -> list[int]:
        """Return the frames that two pose in turn by messages of poses."""
        return self._of_frames.contested()

    def contested_frames(self) -> set[int]:
        """Return the frames that two pose in turn by messages of poses or by transforms."""
        children, frames = self._on_transforms
        is_so = bool(children) and not children.isdisjoint(self.contested_transforms())
        return set(self.contested_poses()) | (set(frames) if is_so else set())

    def contested_transforms(self) -> list[str]:
        """Return the TF frames whose transforms two send in turn."""
        return self._of_transforms.contested()


def links_of(robots: Iterable[DrivenRobot], joints: Collection[Joint]) -> set[int]:
    """Return the frames of the links that joints move."""
    links = set[int]()
    for robot in robots:
        columns = {column for name, column in joints if name == robot.name}
        for needed, rows in robot.patterns.items():
            if not columns.isdisjoint(needed):
                links |= {robot.links[row] for row in rows}
    return links


def may_jump_and_return(
    robot: DrivenRobot, columns: Sequence[int], times: Floats, values: Floats
) -> bool:
    """Return whether joints jump away and back in messages (n,), by values (n, c) of columns.

    Once is enough, where ``note_values`` has it happen several times.
    """
    ways, seconds = np.diff(values, axis=0), np.abs(np.diff(times))[:, np.newaxis]
    fastest = np.array([_fastest(robot, column) for column in columns])
    jumps = (np.abs(ways) >= _LEAST_JUMP) & (np.abs(ways) > fastest * seconds)
    is_back = np.abs(values[2:] - values[:-2]) <= _BACK * np.abs(ways[:-1])
    gone, back = jumps[:-1], jumps[:-1] & jumps[1:] & is_back
    return bool(np.any(back.any(axis=1) & (gone == back).all(axis=1)))


def _fastest(robot: DrivenRobot, column: int) -> float:
    """Return the speed [1/s] beyond which a joint does not move."""
    limit = float(robot.speed_limits[column])
    return _FASTER * limit if math.isfinite(limit) else _FASTEST


def _time_of(value: JointValue) -> float:
    return value.stamp * _NANOSECONDS if value.stamp else value.since.heard


def _is_jump(before: tuple[float, float], after: tuple[float, float], fastest: float) -> bool:
    """Return whether a joint is farther [s, rad or m] from where it was than it can move."""
    way = abs(after[1] - before[1])
    return way >= _LEAST_JUMP and way > fastest * abs(after[0] - before[0])


def _is_back(
    first: tuple[float, float], there: tuple[float, float], here: tuple[float, float]
) -> bool:
    return abs(here[1] - first[1]) <= _BACK * abs(there[1] - first[1])
