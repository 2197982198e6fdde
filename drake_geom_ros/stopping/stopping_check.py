"""``StoppingCheck``: whether robots that begin to brake now stand before contact, certified."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np
from numpy.typing import ArrayLike

from drake_geom_ros.geometry import (
    AccuracyLike,
    ArgumentError,
    GeometryId,
    QueryObject,
    SceneGraphContext,
)
from drake_geom_ros.geometry.queries.joint_motions import JointMotions
from drake_geom_ros.geometry.queries.joint_trees import JointChain, chain_poses
from drake_geom_ros.math.array_types import Flags, Floats, Indices
from drake_geom_ros.stopping.braking import BrakingError
from drake_geom_ros.stopping.moving_pairs import Moment, PosedPairs
from drake_geom_ros.stopping.prepared_question import PreparedQuestion
from drake_geom_ros.stopping.question_pairs import QuestionPairs
from drake_geom_ros.stopping.robots import BrakedJoints, Columns, Robot, RobotState, braked_joints
from drake_geom_ros.stopping.stop import RESOLUTION, Stop, StoppingQuestion
from drake_geom_ros.stopping.travel import BodyTravel
from drake_geom_ros.stopping.unmapped import FindUnmapped

EVALUATIONS = 400  # pairs that kernels answer at most for one path, by default


class StoppingCheck:
    """Answers, again and again, whether robots can still stop; see ``Stop``.

    Poses of all bodies but the robots' are those of the context at each call. What is neither
    driven by joints nor fixed to the world may approach at ``max_speed`` since its pose was
    measured. Two robots that brake by questions of their own brake independently of each other.
    For one thread at a time.

    Args:
        context: The scene. After a change of its geometries or filters it is prepared anew.
        robots: All robots that move.
        questions: What brakes, against what.
        accuracy: The level of distances, or a length [m]; empty: that of the scene.
        max_evaluations: Of pairs by kernels, for each path; 0: no limit. An answer that would
            need more is not proved.
        resting: Id values of frames that do not move, beside those welded to the world.
        resolution: Of scales, from 0 to 1.
        may_wait: Let a question that names what is not there be answered by a ``trouble``.

    Raises:
        BrakingError: A braking names joints that are not there.
        ArgumentError: Nothing of a question's ``set_a`` is moved by its joints, or the resolution
            is no share.
    """

    def __init__(
        self,
        context: SceneGraphContext,
        robots: Sequence[Robot],
        questions: Sequence[StoppingQuestion],
        accuracy: AccuracyLike = '',
        max_evaluations: int = EVALUATIONS,
        resting: Collection[int] = (),
        *,
        resolution: float = RESOLUTION,
        may_wait: bool = False,
    ) -> None:
        if not 0.0 < resolution <= 1.0:
            raise ArgumentError(f'resolution={resolution!r} must be > 0 and at most 1')
        self._context, self._robots = context, tuple(robots)
        self._questions, self._accuracy = tuple(questions), accuracy
        self._resting, self._most = tuple(resting), max_evaluations
        self._may_wait, self._resolution = may_wait, resolution
        self._prepare()

    @property
    def ids(self) -> Indices:
        """The id values (n,) of the geometries, ascending, as ``ages`` are in order."""
        return self._motions.ids

    def stops(
        self,
        states: Sequence[RobotState],
        ages: ArrayLike = 0.0,
        delay: float = 0.0,
        find_unmapped: FindUnmapped | None = None,
    ) -> list[Stop]:
        """Return the answer to each question, for robots in ``states`` and bodies as posed now.

        ``ages`` [s] are those of the poses of geometries, one number or (n,) in the order of
        ``ids``. ``delay`` [s] is what passes until a scale reaches the robot; it and the age of a
        robot's state count as reaction time. ``find_unmapped`` returns what else is near; it is
        called once, with the distance [m] from which on nothing can matter.
        """
        self._follow_scene()
        moment = self._moment(states, ages, delay)
        stops = [each.stop(moment, self._most) for each in self._prepared]
        if find_unmapped is not None:
            reach = max(each.reach(moment) for each in self._prepared)
            unmapped = find_unmapped(reach)
            stops = [
                each.held_against(near, stop, moment)
                for each, stop, near in zip(self._prepared, stops, unmapped, strict=True)
            ]
        return [
            each.measured(stop, moment) for each, stop in zip(self._prepared, stops, strict=True)
        ]

    @property
    def frame_ids(self) -> Indices:
        """The id values (f,) of the frames that joints and bases pose."""
        return self._columns.frame_ids()

    def ways(
        self, states: Sequence[RobotState], delay: float = 0.0, parts: int = 4
    ) -> list[Floats]:
        """Return where each question's stop from the present speed leads, for pictures.

        X_PF (parts, f, 7), x y z [m] qx qy qz qw, are poses of the frames ``frame_ids`` in what
        carries their robots, where the joints that brake have gone equal parts of their travel;
        the last ones are where they stand. (0, f, 7) where nothing moves, or nobody knows how.
        ``states`` and ``delay`` are as in ``stops``.
        """
        self._follow_scene()
        moment = self._moment(states, 0.0, delay)
        shares = np.arange(1.0, parts + 1.0)[:, np.newaxis] / parts
        travels = [each.travel(moment) for each in self._prepared]
        return [
            chain_poses(
                moment.chain, moment.values + shares[: len(shares) * travel.any()] * travel
            )
            for travel in travels
        ]

    def _moment(self, states: Sequence[RobotState], ages: ArrayLike, delay: float) -> Moment:
        """Return how robots move now, among bodies with poses of some ``ages`` [s]."""
        columns, ages_of_all = self._columns, np.empty(len(self.ids))
        ages_of_all[:] = ages
        values, unplaced = columns.positions(states), self._motions.unplaced()
        return Moment(
            values,
            columns.velocities(states),
            tuple(states),
            self._chain_of(states),
            ages_of_all,
            delay,
            *self._motions.poses(),
            unplaced,
            not (np.isnan(values).any() or unplaced.any()),
        )

    def _follow_scene(self) -> None:
        if not self._motions.is_of_now(self._context) and not self._posed.take_shapes():
            self._prepare()

    def _prepare(self) -> None:
        braked = [self._braked(question) for question in self._questions]
        bases = {robot for each in braked for robot, _ in each.bases}
        self._columns = Columns.of(self._robots, [k in bases for k in range(len(self._robots))])
        chain, count = self._columns.chain(), self._columns.width
        ids = self._columns.frame_ids()
        resting = [frame for frame in self._resting if frame not in ids]
        self._motions = JointMotions(self._context, chain, ids, count, self._accuracy, resting)
        own = np.zeros((len(braked), count), dtype=np.bool_)
        for row, each in zip(own, braked, strict=True):
            row[each.columns(self._columns)] = True
        by_any: Flags = np.asarray(own.any(axis=0))
        about = [
            QuestionPairs.of(question, row, by_any, self._motions)
            for question, row in zip(self._questions, own, strict=True)
        ]
        rows = np.unique(np.concatenate([np.zeros(0, np.int64), *(each.rows for each in about)]))
        posed = self._posed = PosedPairs(self._motions, rows, self._resolution)
        travel = BodyTravel(posed)
        self._prepared = [
            PreparedQuestion(question, joints, self._columns, its_pairs, posed, travel)
            for question, joints, its_pairs in zip(self._questions, braked, about, strict=True)
        ]
        for prepared in self._prepared:
            prepared.stand_beside(self._prepared)
        self._standing: tuple[bytes, JointChain] | None = None
        for prepared in self._prepared:
            if prepared.never and not self._may_wait:
                raise ArgumentError(prepared.never)

    def _braked(self, question: StoppingQuestion) -> BrakedJoints:
        """Return the joints that brake in a question; raises BrakingError unless it may wait."""
        chosen = _robots_in(self._context, self._robots, question.set_a)
        try:
            return braked_joints(self._robots, question.braking, chosen)
        except BrakingError as error:
            if not self._may_wait:
                raise
            return BrakedJoints.of_nothing(str(error))

    def _chain_of(self, states: Sequence[RobotState]) -> JointChain:
        """Return the chain of the robots where they are, the same object while none has moved."""
        if max(self._columns.bases, default=-1) >= 0:
            return self._columns.driven(states)
        places = b''.join(np.asarray(state.X_PB).tobytes() for state in states)
        if self._standing is None or self._standing[0] != places:
            self._standing = places, self._columns.driven(states)
        return self._standing[1]


def _robots_in(
    context: SceneGraphContext, robots: Sequence[Robot], geometries: Collection[int]
) -> list[int]:
    """Return the robots, by their index, one of whose links carries any of some geometries."""
    inspector = QueryObject(context).inspector()
    world, carriers = inspector.world_frame_id(), set()
    for geometry in geometries:
        frame = inspector.GetFrameId(GeometryId(int(geometry)))
        while frame != world:
            carriers.add(frame.get_value())
            frame = inspector.GetParentFrame(frame)
    own = [{robot.root, *robot.frame_ids.tolist()} for robot in robots]
    return [k for k, frames in enumerate(own) if not carriers.isdisjoint(frames)]
