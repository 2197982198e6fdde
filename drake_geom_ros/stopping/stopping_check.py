"""``StoppingCheck``: whether robots that begin to brake now stand before contact, certified."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import NamedTuple

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
from drake_geom_ros.geometry.queries.joint_trees import JointChain, JointKind
from drake_geom_ros.geometry.queries.motion_queries import (
    MotionAnswer,
    MotionQuestion,
)
from drake_geom_ros.math.array_types import Flags, Floats, Indices
from drake_geom_ros.stopping.braking import Braking, BrakingError, StopCategory
from drake_geom_ros.stopping.robots import (
    BrakedJoints,
    Columns,
    Robot,
    RobotState,
    arc_deviation,
    braked_joints,
)
from drake_geom_ros.stopping.stop_paths import (
    StopPath,
    StopProfile,
    boxes_over_shares,
    joined,
    path_over_shares,
    path_over_time,
    standing,
)

RESOLUTION = 0.02  # [-] of the scale
EVALUATIONS = 400  # pairs that kernels answer at most for one question, by default
_NOWHERE = np.full(3, np.nan)


@dataclass(frozen=True, eq=False)
class StoppingQuestion:
    """Bodies that brake, and those that they must not meet.

    Args:
        braking: Which joints brake, and how. Its ``joint_names`` are of robots with a link in
            ``set_a``.
        set_a: Id values (n,) of the geometries that brake.
        set_b: Id values of those that they are held against; None: all others.
        margin: All pairs must stay farther apart than this [m].
        max_speed: Of everything in the pairs that neither brakes nor stands [m/s].
    """

    braking: Braking
    set_a: Collection[int]
    set_b: Collection[int] | None = None
    margin: float = 0.0
    max_speed: float = 0.0

    def __post_init__(self) -> None:
        for field in ('margin', 'max_speed'):
            value = getattr(self, field)
            if not (math.isfinite(value) and value >= 0.0):
                raise ArgumentError(f'{field}={value!r} must be finite and >= 0')


class Stop(NamedTuple):
    """Answer to one ``StoppingQuestion``.

    ``scale`` is the largest share of the present speed such that braking from it, and from every
    smaller one, is proved to keep all pairs farther apart than ``margin``. The scale 0 promises
    that the robot stands, and nothing about others. ``clear`` is about braking from the present
    speed alone. Where the answer is not clear, the pair is the one that could not be proved.
    """

    clear: bool
    scale: float
    stopping_time: float  # [s] from now until all stand, from the present speed
    stopping_distance: float  # [m] certified: no point of set_a goes farther
    linear: float  # [m/s] certified: no point of set_a is faster at the scale
    angular: float  # [rad/s] no joint that brakes, and no base, turns faster at the scale
    id_A: int = 0  # 0: no pair
    id_B: int = 0
    distance: float = math.inf  # [m] of the pair, where it comes too near, or nearest
    error_bound: float = 0.0  # [m]
    p_WCa: Floats = _NOWHERE  # (3,) [m]
    p_WCb: Floats = _NOWHERE
    least_clearance: float = math.inf  # [m] certified on the way; -inf where it is not clear
    contact_time: float = math.inf  # [s] from now on: until then all is proved
    reaction_time: float = 0.0  # [s] that was assumed: of the braking, delay and age together
    oldest_pose_age: float = 0.0  # [s] of the bodies that it is about
    pairs: int = 0  # that were looked at
    far_pairs: int = 0  # that cannot meet within the stopping time, by their boxes
    evaluations: int = 0
    trouble: str = ''  # why nothing is proved; empty: it was looked at


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
        max_evaluations: Of pairs by kernels, for each question; 0: no limit. An answer that
            would need more is not proved.
        resting: Id values of frames that do not move, beside those welded to the world.
        may_wait: Let a question that names what is not there be answered by a ``trouble``.

    Raises:
        BrakingError: A braking names joints that are not there.
        ArgumentError: Nothing of a question's ``set_a`` is moved by its joints.
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
        may_wait: bool = False,
    ) -> None:
        self._may_wait = may_wait
        self._context, self._robots = context, tuple(robots)
        self._questions, self._accuracy = tuple(questions), accuracy
        self._resting, self._most = tuple(resting), max_evaluations
        self._prepare()

    @property
    def ids(self) -> Indices:
        """The id values (n,) of the geometries, ascending, as ``ages`` are in order."""
        return self._motions.ids

    def _prepare(self) -> None:
        braked = []
        for question in self._questions:
            chosen = _robots_in(self._context, self._robots, question.set_a)
            try:
                braked.append(braked_joints(self._robots, question.braking, chosen))
            except BrakingError as error:
                if not self._may_wait:
                    raise
                braked.append(BrakedJoints.of_nothing(str(error)))
        bases = {robot for each in braked for robot, _ in each.bases}
        self._columns = Columns.of(self._robots, [k in bases for k in range(len(self._robots))])
        chain, count = self._columns.chain(), self._columns.width
        ids = self._columns.frame_ids()
        resting = [frame for frame in self._resting if frame not in ids]
        self._motions = JointMotions(self._context, chain, ids, count, self._accuracy, resting)
        others = np.zeros(count, dtype=np.bool_)
        for each in braked:
            others[each.columns(self._columns)] = True
        self._parts = [
            _Part(question, each, self._columns, self._motions, others)
            for question, each in zip(self._questions, braked, strict=True)
        ]
        for part in self._parts:
            if part.never and not self._may_wait:
                raise ArgumentError(part.never)

    def stops(
        self, states: Sequence[RobotState], ages: ArrayLike = 0.0, delay: float = 0.0
    ) -> list[Stop]:
        """Return the answer to each question, for robots in ``states`` and bodies as posed now.

        ``ages`` [s] are those of the poses of geometries, one number or (n,) in the order of
        ``ids``. ``delay`` [s] is what passes until a scale reaches the robot; it and the age of a
        robot's state count as reaction time.
        """
        if not self._motions.is_of_now(self._context):
            self._prepare()
        columns = self._columns
        now = _Now(
            columns.positions(states),
            columns.velocities(states),
            tuple(states),
            columns.driven(states),
            np.broadcast_to(np.asarray(ages, dtype=np.float64), self.ids.shape),
            delay,
            *self._motions.poses(),
            self._motions.unplaced(),
        )
        return [part.stop(now, self._parts, self._most) for part in self._parts]


class _Now(NamedTuple):
    """What is known of a moment."""

    values: Floats  # (c,)
    velocities: Floats
    states: tuple[RobotState, ...]
    chain: JointChain
    ages: Floats  # (n,) [s] of geometries
    delay: float  # [s]
    R_PFs: Floats
    p_PFs: Floats
    unplaced: Flags  # (n,)


class _Part:
    """One question in one version of the scene."""

    def __init__(
        self,
        question: StoppingQuestion,
        braked: BrakedJoints,
        columns: Columns,
        motions: JointMotions,
        braked_by_any: Flags,
    ) -> None:
        self.question, self._braked, self._columns = question, braked, columns
        self._own: Flags = np.zeros(columns.width, dtype=np.bool_)
        self._own[braked.columns(columns)] = True
        self._others: Flags = braked_by_any & ~self._own
        ids, moved_by = motions.ids, motions.moved_by
        in_a = np.isin(ids, np.fromiter(question.set_a, np.int64))
        in_b = ~in_a
        if question.set_b is not None:
            in_b = np.isin(ids, np.fromiter(question.set_b, np.int64))
        moved = in_a & moved_by[:, self._own].any(axis=1)
        self.never = braked.trouble  # why it can never be answered in this scene; empty: it can
        if not moved.any() and not self.never:
            self.never = (
                'no geometry of set_a is moved by the joints that brake; it must hold links of '
                'a robot whose joints are in joint_names'
            )
        self._moving_a = np.flatnonzero(moved)
        pairs = _considered(motions.pairs, in_a, in_b)
        relative = moved_by[pairs[:, 0]] ^ moved_by[pairs[:, 1]]
        matters = relative[:, self._own].any(axis=1)
        self._pairs, self._relative = pairs[matters], relative[matters]
        halves = _considered(motions.half_spaces, in_a, in_b)
        apart = moved_by[halves[:, 0]] ^ moved_by[halves[:, 1]]
        self._has_half_spaces = bool(apart[:, self._own].any())
        self._loose: Flags = ~(braked_by_any)  # columns that nobody brakes
        self._loose_a: Flags = moved_by[in_a].any(axis=0) & self._loose
        used = np.unique(self._pairs)
        self._loose_b: Flags = moved_by[used].any(axis=0) & self._loose
        self._can_move = motions.can_move | moved_by[:, self._loose & ~self._loose_a].any(axis=1)
        self._ids = ids
        self._queries = motions.queries(self._pairs) if len(self._pairs) else None

    def stop(self, now: _Now, parts: Sequence[_Part], most: int) -> Stop:
        """Return the answer of now; ``parts`` are those of all questions."""
        profile = self.profile(now)
        if trouble := self._trouble(now, profile):
            return _unproved(trouble)
        assert profile is not None
        moving = self._own & (profile.velocities != 0.0)
        concerned: Flags = np.any(self._relative[:, moving], axis=1)
        if self._queries is None or not concerned.any():
            return self._measured(Stop(True, 1.0, 0.0, 0.0, 0.0, 0.0), profile, now)
        self._queries.drive_by(now.chain)
        self._queries.stand(now.R_PFs, now.p_PFs)
        self._approach(now)
        others = self._of_others(now, parts)
        if isinstance(others, str):
            return _unproved(others)
        moves = others.velocities != 0.0
        independent: Flags = concerned & self._relative[:, moves].any(axis=1)
        stop = self._alone(now, profile, concerned & ~independent, most)
        if independent.any():
            together = joined(profile, others)
            other = self._boxes(now, together, independent, most)
            stop = _worse(stop, other)
        return self._measured(stop, profile, now)

    def profile(self, now: _Now) -> StopProfile | None:
        """Return how the columns of this question brake; None where no one knows how they move."""
        velocities = self._braked.velocities(now.states)
        if self.never or np.isnan(velocities).any():
            return None
        braking, count = self.question.braking, self._columns.width
        v = np.where(self._own, now.velocities, 0.0)
        ages = np.zeros(count)
        for k, state in enumerate(now.states):
            first, base = self._columns.firsts[k], self._columns.bases[k]
            ages[first : first + len(state.positions)] = state.age
            if base >= 0:
                ages[base] = state.age
        ages[(v == 0.0) | np.isinf(ages)] = 0.0  # of unknown age nothing is proved
        radii = np.zeros(count)
        reactions = np.full(count, braking.reaction_time + now.delay)
        shares, times = self._times(velocities)
        times = np.where(v == 0.0, 0.0, times)
        profile = StopProfile(v, ages, reactions, shares, times, radii)
        seconds = profile.travel(profile.fastest)
        for base, state in zip(self._columns.bases, now.states, strict=True):
            if base >= 0:
                radii[base] = arc_deviation(state, float(seconds[base]))
        return profile

    def _times(self, velocities: Floats) -> tuple[Floats, Floats]:
        """Return shares (k,) and the times (k, c) of columns to brake from them."""
        braking, count = self.question.braking, self._columns.width
        fastest = float(np.abs(velocities).max(initial=0.0))
        if braking.stopping_times:
            speeds, times = np.array(braking.stopping_times).T
            shares = speeds / fastest if fastest else np.array([1.0])
            inside = shares < 1.0
            known = np.concatenate(([0.0], shares[inside]))
            if not inside.all():
                known = np.append(known, 1.0)
            each = np.interp(known * fastest, speeds, times)
            return known, np.repeat(each[:, None], count, axis=1)
        each = np.abs(velocities) / braking.decelerations_of(len(velocities))
        whole = np.full(count, each.max(initial=0.0))
        if braking.category == StopCategory.EACH_JOINT:
            whole = self._braked.by_column(self._columns, each)
        return np.array([0.0, 1.0]), np.stack((np.zeros(count), whole))

    def _trouble(self, now: _Now, profile: StopProfile | None) -> str:
        """Return why nothing can be proved now; empty: something can."""
        v, names = now.velocities, self._columns.names()
        if self.never:
            return self.never
        if profile is None:
            unknown = self._own & np.isnan(v)
            some = _some([names[k] for k in np.flatnonzero(unknown)]) or 'its base'
            return (
                f'nobody knows how fast {some} move: publish velocities of joints, or stamped '
                'values; of a base, twists, with the parameter closing_speeds'
            )
        if any(math.isinf(s.age) and self._is_of(k) for k, s in enumerate(now.states)):
            return 'the values of its joints are stale, or of unknown age'
        lost = np.isnan(now.values)
        if lost.any() and (lost & self._moves_pairs()).any():
            which = np.flatnonzero(lost & self._moves_pairs())
            return f'nothing was heard of {_some([names[k] for k in which])}'
        standing = self._loose_a if self.question.max_speed else self._loose_b
        astray = standing & ~(v == 0.0)
        if astray.any():
            some = _some([names[k] for k in np.flatnonzero(astray)])
            return (
                f'{some} move, or nobody knows whether they do, and no stoppable rule says how '
                'they brake; name them in joint_names, or give max_speed where they are of set_b'
            )
        for k, state in enumerate(now.states):
            stands = self._columns.bases[k] >= 0 or state.V_PB is None or not state.V_PB.any()
            if not stands and self._is_of(k):
                return (
                    f'the base of {self._columns.robots[k].name!r} moves, and does not brake; '
                    'name x, y and theta in joint_names'
                )
        if self._has_half_spaces:
            return 'set_a moves a half space against another one, of which nothing can be proved'
        if now.unplaced.any() and now.unplaced[self._pairs].any():
            return 'a body of the rule never had a pose'
        return ''

    def _is_of(self, robot: int) -> bool:
        """Return whether a joint of a robot moves any pair."""
        first = self._columns.firsts[robot]
        own = slice(first, first + len(self._columns.robots[robot].joint_names))
        return bool(self._moves_pairs()[own].any())

    def _moves_pairs(self) -> Flags:
        return np.asarray(self._relative.any(axis=0))

    def _approach(self, now: _Now) -> None:
        """Let bodies that neither brake nor stand come nearer, since their poses were measured."""
        speed = self.question.max_speed
        speeds = np.where(self._can_move, speed, 0.0)
        since = np.where(self._can_move & (speed > 0.0), now.ages, 0.0) * speed
        pairs = self._pairs
        assert self._queries is not None
        self._queries.approach(speeds[pairs].sum(axis=1), since[pairs].sum(axis=1))

    def _of_others(self, now: _Now, parts: Sequence[_Part]) -> StopProfile | str:
        """Return how other questions' columns brake, or why that is not known."""
        needed = self._others & self._moves_pairs()
        profiles = [part.profile(now) for part in parts if (part._own & needed).any()]
        if not profiles:
            return standing(self._columns.width)
        every = [profile for profile in profiles if profile is not None]
        if len(every) < len(profiles):
            return 'nobody knows how fast the other robots move that brake by rules of their own'
        together = every[0]
        for profile in every[1:]:
            together = joined(together, profile)
        return together._replace(velocities=np.where(needed, together.velocities, 0.0))

    def _alone(self, now: _Now, profile: StopProfile, asked: Flags, most: int) -> Stop:
        """Return the answer about pairs (k,) of which nobody else's brakes move a body."""
        if not asked.any():
            return Stop(True, 1.0, 0.0, 0.0, 0.0, 0.0)
        if self.question.braking.category == StopCategory.EACH_JOINT:
            return self._boxes(now, profile, asked, most)
        way = path_over_shares(now.values, profile)
        answer = self._follow(way, asked, most)
        stop = self._stop_of(way, answer, profile, asked, most)
        if stop.clear or profile.fastest < 1.0 or answer.outcome == 'clear':
            return stop
        way = path_over_time(now.values, profile)
        answer = self._follow(way, asked, most)
        if answer.outcome != 'clear':
            return stop._replace(contact_time=way.at(answer.times[0]))
        return stop._replace(clear=True, least_clearance=answer.lower_bound, contact_time=math.inf)

    def _boxes(self, now: _Now, profile: StopProfile, asked: Flags, most: int) -> Stop:
        """Return the answer about pairs (k,) whose columns stop each by itself."""
        way = boxes_over_shares(now.values, profile)
        answer = self._follow(way, asked, most)
        return self._stop_of(way, answer, profile, asked, most)

    def _follow(self, way: StopPath, asked: Flags, most: int) -> MotionAnswer:
        assert self._queries is not None
        widest = float(np.diff(way.reached).max(initial=0.0)) or 1.0
        question = MotionQuestion(
            min_distance=self.question.margin,
            time_tolerance=RESOLUTION / widest,
            max_evaluations=most,
        )
        return self._queries.follow(question, way.path, skipped=~asked)

    def _stop_of(
        self, way: StopPath, answer: MotionAnswer, profile: StopProfile, asked: Flags, most: int
    ) -> Stop:
        """Return the answer about a path over shares."""
        assert self._queries is not None
        is_proved = answer.outcome == 'clear'
        looked = int(np.count_nonzero(self._queries.examined() & asked))
        places = (answer.a, answer.b) if answer.a >= 0 else ()
        ids = [int(self._ids[place]) for place in places] or [0, 0]
        spent = answer.outcome == 'unknown' and 0 < most <= answer.evaluations
        return Stop(
            clear=is_proved and profile.fastest >= 1.0,
            scale=profile.fastest if is_proved else way.at(answer.times[0]),
            stopping_time=0.0,
            stopping_distance=0.0,
            linear=0.0,
            angular=0.0,
            id_A=ids[0],
            id_B=ids[1],
            distance=answer.distance,
            error_bound=answer.error_bound,
            p_WCa=answer.p_WCa,
            p_WCb=answer.p_WCb,
            least_clearance=answer.lower_bound if is_proved else -math.inf,
            contact_time=math.inf if is_proved else 0.0,
            pairs=looked,
            far_pairs=int(np.count_nonzero(asked)) - looked,
            evaluations=answer.evaluations,
            trouble='max_evaluations were used up before it was proved' if spent else '',
        )

    def _measured(self, stop: Stop, profile: StopProfile, now: _Now) -> Stop:
        """Return an answer with the times, ways and speeds of a profile."""
        trouble = stop.trouble
        if profile.fastest < 1.0:
            trouble = trouble or (
                'it is faster than stopping_times say, and nothing is known beyond; measure it '
                'at higher speeds'
            )
            stop = stop._replace(clear=False, least_clearance=-math.inf, contact_time=0.0)
        speeds = np.abs(profile.velocities)
        distance, linear = self._reach(profile, stop.scale * speeds, now)
        moves = bool(speeds.any())
        age = float(profile.ages.max(initial=0.0))
        oldest = float(now.ages[np.unique(self._pairs)].max(initial=age))
        reaction = self.question.braking.reaction_time + now.delay + age
        duration = profile.duration_at(profile.fastest) if moves else 0.0
        return stop._replace(
            stopping_time=duration if profile.fastest >= 1.0 else math.inf,
            stopping_distance=distance,
            linear=linear,
            angular=float((stop.scale * speeds * _turns(now.chain, speeds.size)).max(initial=0.0)),
            reaction_time=reaction,
            oldest_pose_age=oldest,
            trouble=trouble,
        )

    def _reach(self, profile: StopProfile, speeds: Floats, now: _Now) -> tuple[float, float]:
        """Return how far [m] a point of set_a goes at most, and how fast [m/s] at ``speeds``."""
        if self._queries is None or not profile.velocities.any():
            return 0.0, 0.0
        self._queries.drive_by(now.chain)
        travel = np.abs(profile.travel(profile.fastest))
        way = float(self._queries.ways(self._moving_a, travel).max(initial=0.0))
        linear = float(self._queries.ways(self._moving_a, speeds).max(initial=0.0))
        return (way if profile.fastest >= 1.0 else math.inf), linear


def _unproved(trouble: str) -> Stop:
    """Return the answer where nothing is proved."""
    return Stop(
        *(False, 0.0, math.inf, math.inf, 0.0, 0.0),
        least_clearance=-math.inf,
        contact_time=0.0,
        trouble=trouble,
    )


def _worse(stop: Stop, other: Stop) -> Stop:
    """Return the answer about the pairs of two answers together: that with the smaller scale."""
    first, second = sorted((stop, other), key=_key)
    return first._replace(
        clear=stop.clear and other.clear,
        least_clearance=min(stop.least_clearance, other.least_clearance),
        contact_time=min(stop.contact_time, other.contact_time),
        pairs=stop.pairs + other.pairs,
        far_pairs=stop.far_pairs + other.far_pairs,
        evaluations=stop.evaluations + other.evaluations,
        trouble=first.trouble or second.trouble,
    )


def _key(stop: Stop) -> tuple[float, float, float]:
    return stop.scale, stop.least_clearance, stop.distance


def _considered(pairs: Indices, in_a: Flags, in_b: Flags) -> Indices:
    """Return those of pairs (k, 2) that have one body in each of two sets."""
    a, b = pairs[:, 0], pairs[:, 1]
    return pairs[(in_a[a] & in_b[b]) | (in_b[a] & in_a[b])]


def _turns(chain: JointChain, count: int) -> Floats:
    """Return how fast (c,) [rad] a joint turns for each column's unit of speed; 0: it slides."""
    turns = np.zeros(count)
    led = (chain.leaders >= 0) & (chain.kinds == JointKind.REVOLUTE)
    np.maximum.at(turns, chain.leaders[led], np.abs(chain.multipliers[led]))
    return turns


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


def _some(names: Sequence[str]) -> str:
    more = f' and {len(names) - 3} more' if len(names) > 3 else ''
    return ', '.join(names[:3]) + more
