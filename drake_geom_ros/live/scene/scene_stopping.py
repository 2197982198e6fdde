"""Stopping of the robots of the live scene, for its rules of level STOPPABLE."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from fnmatch import fnmatchcase
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry import ArgumentError, FrameId
from drake_geom_ros.live.scene.clocks import ALWAYS, UNKNOWN
from drake_geom_ros.live.scene.driven_robot import Base, DrivenRobot
from drake_geom_ros.live.scene.scene_model import SceneModel
from drake_geom_ros.live.scene.scene_poses import ScenePoses
from drake_geom_ros.live.scene.scene_rules import SceneRules, Twists
from drake_geom_ros.live.scene.stops_beside_sensors import Sensed, finding_unmapped
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.math.batched import matrices_from_poses
from drake_geom_ros.proximity_rules import Level, ProximityRule, RuleError
from drake_geom_ros.stopping import (
    BrakingError,
    FindUnmapped,
    Robot,
    RobotState,
    Stop,
    StoppingCheck,
    StoppingQuestion,
)


class _Prepared(NamedTuple):
    """A check with the arguments that it was made for."""

    check: StoppingCheck
    rules: tuple[ProximityRule, ...]
    watched: object  # the watched pairs of the scene's version
    robots: tuple[DrivenRobot, ...]
    resting: frozenset[int]

    def is_for(self, other: _Prepared) -> bool:
        same = self.watched is other.watched and self.resting == other.resting
        return same and self.rules == other.rules and self.robots == other.robots


class _PosedFrames(NamedTuple):
    """The frames (f,) with geometries that no joints pose, and what hangs on each.

    Geometry ``rows[k]`` of a check hangs on frame ``of[k]`` of these. They were found for
    ``prepared``, among ``geometries`` by frame.
    """

    prepared: _Prepared
    geometries: Mapping[int, NDArray[np.int64]]
    frames: tuple[int, ...]
    rows: NDArray[np.int64]
    of: NDArray[np.int64]

    @classmethod
    def among(
        cls, prepared: _Prepared, geometries: Mapping[int, NDArray[np.int64]]
    ) -> _PosedFrames:
        driven, ids = _links_of(prepared.robots), prepared.check.ids
        rows = {
            frame: np.searchsorted(ids, some)
            for frame, some in geometries.items()
            if frame not in driven
        }
        of = np.repeat(np.arange(len(rows)), [len(some) for some in rows.values()])
        all_rows = np.concatenate([np.zeros(0, dtype=np.int64), *rows.values()])
        return cls(prepared, geometries, tuple(rows), all_rows, of)


class _Asked(NamedTuple):
    """The arguments of a check."""

    prepared: _Prepared
    states: list[RobotState]
    ages: Floats
    delay: float
    find_unmapped: FindUnmapped | None

    def answers(self, states: Sequence[RobotState]) -> dict[str, Stop]:
        """Return the answer about each rule, by its name, for robots in other ``states``."""
        check, rules = self.prepared.check, self.prepared.rules
        stops = check.stops(states, self.ages, self.delay, self.find_unmapped)
        return {rule.name: stop for rule, stop in zip(rules, stops, strict=True)}


class SceneStopping:
    """Answers of ``StoppingCheck`` about the live scene, prepared anew where the scene changes."""

    def __init__(self, model: SceneModel, poses: ScenePoses, rules: SceneRules) -> None:
        self._model, self._poses, self._rules = model, poses, rules
        self._prepared: _Prepared | None = None
        self._asked: _Asked | None = None  # by the last decision
        self._posed: _PosedFrames | None = None

    def stops(
        self, twists: Twists | None, stale_after: float, delay: float, sensed: Sensed
    ) -> dict[str, Stop] | None:
        """Return the answer for each rule of level STOPPABLE by its name; None: there is none.

        ``twists`` V_WF (6,) of now are by frame; ``delay`` [s] passes until the next decision.
        Joint values older than ``stale_after`` [s] prove nothing. ``sensed`` is what maps lack.
        The rules are bound already.
        """
        rules = tuple(rule for rule in self._rules.rules if rule.level == Level.STOPPABLE)
        if not rules:
            self._prepared = self._asked = self._posed = None
            return None
        robots = tuple(self._model.joints.robots.values())
        prepared = self._prepared_for(rules, robots)
        states = self._states(robots, twists or {}, stale_after)
        ages = self._ages(prepared)
        unmapped = finding_unmapped(self._rules, self._model.query, rules, sensed)
        self._asked = _Asked(prepared, states, ages, delay, unmapped)
        return self._asked.answers(states)

    def commanded(self, robot: str, command: Floats) -> dict[str, Stop] | None:
        """Return the answers of the last decision for a base that goes as it is commanded.

        ``robot`` is the name or pattern of robots, ``command`` (6,) the linear [m/s] and angular
        [rad/s] velocity that their root links are to have, in their own axes. None: no rule
        of level STOPPABLE was decided about, or no robot is called so.
        """
        if self._asked is None:
            return None
        names = [driven.name for driven in self._asked.prepared.robots]
        called = [fnmatchcase(name, robot) for name in names]
        if not any(called):
            return None
        states = [
            state._replace(V_PB=_in_parent(state, command)) if is_it else state
            for state, is_it in zip(self._asked.states, called, strict=True)
        ]
        return self._asked.answers(states)

    def ways(self) -> tuple[NDArray[np.int64], list[Floats]]:
        """Return frames (f,) by ids, and ``StoppingCheck.ways`` of the last decision.

        There are none where robots came or went since then.
        """
        robots = self._model.joints.robots.values()
        if self._asked is None or _links(self._asked.prepared.robots) != _links(robots):
            return np.zeros(0, dtype=np.int64), []
        check = self._asked.prepared.check
        return check.frame_ids, check.ways(self._asked.states, self._asked.delay)

    def refuse(self, rule: ProximityRule) -> None:
        """Raise RuleError for a rule whose braking names what is not in the scene."""
        if rule.level != Level.STOPPABLE:
            return
        robots = [_robot(robot) for robot in self._model.joints.robots.values()]
        question = _question(rule, *self._rules.sets_of(rule))
        try:
            StoppingCheck(self._model.context, robots, [question])
        except (BrakingError, ArgumentError) as error:
            raise RuleError(f'proximity rule {rule.name[:80]!r}: {error}') from None

    def _prepared_for(
        self, rules: tuple[ProximityRule, ...], robots: tuple[DrivenRobot, ...]
    ) -> _Prepared:
        """Return a check of the scene as it is now."""
        now = self._prepared
        watched, resting = self._rules.watched, self._resting(robots)
        if now is not None:
            other = now._replace(rules=rules, watched=watched, robots=robots, resting=resting)
            if now.is_for(other):
                return now
        questions = [_question(rule, *self._rules.sets_of(rule)) for rule in rules]
        check = StoppingCheck(
            self._model.context,
            [_robot(robot) for robot in robots],
            questions,
            resting=resting,
            may_wait=True,
        )
        self._prepared = _Prepared(check, rules, watched, robots, resting)
        return self._prepared

    def _resting(self, robots: Sequence[DrivenRobot]) -> frozenset[int]:
        """Return the frames with geometries that nothing moves, without links of robots."""
        since, driven = self._poses.ages.since, _links_of(robots)
        return frozenset(
            frame
            for frame in self._rules.frames_with_geometries()
            if frame not in driven and since(frame) == ALWAYS
        )

    def _ages(self, prepared: _Prepared) -> Floats:
        """Return the age [s] (n,) of the pose of each geometry that does not follow joints."""
        geometries, posed = self._rules.frames_with_geometries(), self._posed
        if posed is None or posed.prepared is not prepared or posed.geometries is not geometries:
            self._posed = posed = _PosedFrames.among(prepared, geometries)
        ages, age = np.zeros(len(prepared.check.ids)), self._poses.ages_now()
        sinces = map(self._poses.ages.since, posed.frames)
        of_frames = np.array([math.inf if since is None else age(since) for since in sinces])
        np.maximum.at(ages, posed.rows, of_frames[posed.of])
        return ages

    def _states(
        self, robots: Sequence[DrivenRobot], twists: Twists, stale_after: float
    ) -> list[RobotState]:
        """Return how each robot moves now."""
        since = self._poses.ages.since
        sinces = [None if r.root_value is None else since(r.root_value) for r in robots]
        bases = self._model.joints.bases(robots, self._model.query, sinces)
        age = self._poses.ages_now()
        states = []
        for robot, base in zip(robots, bases, strict=True):
            heard = [v.since for v in robot.values if v and v.since not in (ALWAYS, UNKNOWN)]
            moved = [*heard, *([base.since] if base and base.since != ALWAYS else [])]
            oldest = max((age(moment) for moment in moved), default=0.0)
            states.append(
                RobotState(
                    robot.described_X_PB if base is None else base.X_PB,
                    robot.positions(),
                    robot.speeds(),
                    self._twist_of(robot, base, twists),
                    oldest if oldest <= stale_after else math.inf,
                )
            )
        return states

    def _twist_of(
        self, robot: DrivenRobot, base: Base | None, twists: Mapping[FrameId, Floats]
    ) -> Floats | None:
        """Return V_PB (6,) of a base; None: it rests, in what carries it; NaN: unknown."""
        if robot.root is None or (base is not None and base.since == ALWAYS):
            return None
        if self._model.is_mounted(robot.root):
            return None
        return np.asarray(twists.get(robot.root, np.full(6, math.nan)))


def _in_parent(state: RobotState, command: Floats) -> Floats:
    """Return V_PB (6,) of a root link that moves by a command in its own axes."""
    R_PB = matrices_from_poses(np.asarray(state.X_PB)[np.newaxis])[0][0]
    return np.concatenate((R_PB @ command[3:], R_PB @ command[:3]))


def _question(
    rule: ProximityRule, set_a: NDArray[np.int64], set_b: NDArray[np.int64]
) -> StoppingQuestion:
    """Return the question of a rule about the geometries of its sets."""
    sets = set_a.tolist(), set_b.tolist()
    return StoppingQuestion(rule.braking, *sets, rule.margin, rule.max_speed)


def _robot(robot: DrivenRobot) -> Robot:
    """Return a robot of the scene as checks take it."""
    return Robot(
        robot.name,
        tuple(robot.joint_names),
        robot.tree,
        np.array(list(robot.links), dtype=np.int64),
        np.array(list(robot.links.values()), dtype=np.int64),
        robot.root_value or 0,
    )


def _links(robots: Iterable[DrivenRobot]) -> list[tuple[str, Mapping[int, int]]]:
    """Return the name of each robot, and its links."""
    return [(robot.name, robot.links) for robot in robots]


def _links_of(robots: Sequence[DrivenRobot]) -> frozenset[int]:
    """Return the frames that joints pose."""
    return frozenset(frame for robot in robots for frame in robot.links.values())
