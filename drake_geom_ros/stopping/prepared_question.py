"""A question about stops, prepared for one version of a scene."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from drake_geom_ros.geometry.queries.joint_motions import JointMotions
from drake_geom_ros.geometry.queries.joint_trees import JointChain, JointKind
from drake_geom_ros.math.array_types import Flags, Floats, Indices
from drake_geom_ros.stopping.braking import StopCategory
from drake_geom_ros.stopping.moving_pairs import Moment, MovingPairs
from drake_geom_ros.stopping.robots import BrakedJoints, Columns, arc_deviation
from drake_geom_ros.stopping.stop import (
    FREE,
    Stop,
    StoppingQuestion,
    unproved,
    worse,
)
from drake_geom_ros.stopping.stop_paths import (
    StopProfile,
    boxes_over_shares,
    joined,
    path_over_shares,
    path_over_time,
)
from drake_geom_ros.stopping.travel import BodyTravel
from drake_geom_ros.stopping.unmapped import Unmapped, stop_before

_FINER = 4  # parts of an edge of boxes that is not proved, in the second look at it


class PreparedQuestion:
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
        ids, moved_by = motions.ids, motions.moved_by
        in_a: Flags = np.isin(ids, np.fromiter(question.set_a, np.int64))
        in_b: Flags = ~in_a
        if question.set_b is not None:
            in_b = np.isin(ids, np.fromiter(question.set_b, np.int64))
        moved = np.asarray(in_a & moved_by[:, self._own].any(axis=1), dtype=np.bool_)
        self.never = braked.trouble  # why it can never be answered in this scene; empty: it can
        if not moved.any() and not self.never:
            self.never = (
                'no geometry of set_a is moved by the joints that brake; it must hold links of '
                'a robot whose joints are in joint_names'
            )
        self._moving_a: Flags = moved
        loose = ~braked_by_any  # columns that nobody brakes
        self._loose_a: Flags = moved_by[in_a].any(axis=0) & loose
        can_move = motions.can_move | moved_by[:, loose & ~self._loose_a].any(axis=1)
        pairs = _considered(motions.pairs, in_a, in_b)
        relative = motions.relative(pairs)
        matters: Flags = np.asarray(relative[:, self._own].any(axis=1))
        self._moves_pairs: Flags = np.asarray(relative[matters].any(axis=0))
        self._loose_b: Flags = moved_by[np.unique(pairs[matters])].any(axis=0) & loose
        self._others: Flags = braked_by_any & ~self._own & self._moves_pairs
        shared: Flags = np.asarray(relative[:, self._others].any(axis=1))
        self._alone, self._shared = (
            MovingPairs(motions, pairs[some], relative[some], can_move, question.max_speed)
            for some in (matters & ~shared, matters & shared)
        )
        halves = motions.relative(_considered(motions.half_spaces, in_a, in_b))
        self._has_half_spaces = bool(halves[:, self._own].any())
        self._ids, self._in_a, self._in_b = ids, in_a, in_b
        self._moved_by = moved_by
        self._speeds: Floats = np.where(can_move, question.max_speed, 0.0)
        self._travel = BodyTravel(self._alone.queries, columns)
        self._profiled: tuple[Moment, StopProfile | None] | None = None

    def stop(self, moment: Moment, every: Sequence[PreparedQuestion], most: int) -> Stop:
        """Return the answer at a moment; ``every`` are all questions."""
        profile = self.profile(moment)
        if trouble := self._trouble(moment, profile):
            return unproved(trouble)
        assert profile is not None
        moving = self._own & (profile.velocities != 0.0)
        along = self.question.braking.category == StopCategory.ALONG_PATH
        stop = FREE
        if (asked := self._alone.moved_by(moving)).any():
            self._alone.be_at(moment)
            answer = self._along_path if along else self._in_boxes
            stop = answer(self._alone, moment, profile, asked, most)
        if (asked := self._shared.moved_by(moving)).any():
            others = self._of_others(moment, every)
            if isinstance(others, str):
                return unproved(others)
            self._shared.be_at(moment)
            independent = asked & self._shared.moved_by(others.velocities != 0.0)
            answer = self._along_path if along and not independent.any() else self._in_boxes
            together = joined(profile, others)
            stop = worse(stop, answer(self._shared, moment, together, asked, most))
        return stop

    def reach(self, moment: Moment) -> float:
        """Return the distance [m] from which on nothing beside a body can matter to a stop."""
        profile = self.profile(moment)
        if profile is None or not profile.velocities.any():
            return 0.0
        goes = self._travel.of(moment.chain, moment.values, profile, profile.fastest)
        comes = self._comes(moment, profile.duration_at(profile.fastest))
        moved = self._moved_by[:, self._own].any(axis=1)
        return float(goes[moved].max() + comes.max() + self.question.margin)

    def held_against(self, unmapped: Sequence[Unmapped], stop: Stop, moment: Moment) -> Stop:
        """Return an answer that holds against what is beside the bodies that brake, too."""
        profile = None if math.isinf(stop.stopping_time) else self.profile(moment)
        if profile is None:
            return stop
        moving = self._own & (profile.velocities != 0.0)
        for each in unmapped:
            body, other = np.searchsorted(self._ids, (each.body, each.other)).tolist()
            asked = _considered(np.array([(body, other)]), self._in_a, self._in_b)
            if len(asked) and self._moved_by[body, moving].any():
                needed, margin = self._needed(moment, profile, body, other), self.question.margin
                stop = worse(stop, stop_before(each, needed, margin, profile.fastest))
        return stop

    def _needed(
        self, moment: Moment, profile: StopProfile, body: int, other: int
    ) -> Callable[[float], float]:
        """Return the distance [m] of now that two geometries need, by the share of the speed."""

        def needed(share: float) -> float:
            goes = self._travel.of(moment.chain, moment.values, profile, share)[body]
            comes = self._comes(moment, profile.duration_at(share))[other]
            return float(goes + comes + self.question.margin)

        return needed

    def _comes(self, moment: Moment, seconds: float) -> Floats:
        """Return how far (n,) [m] geometries may come nearer by themselves, in so many seconds."""
        since = np.where(self._speeds > 0.0, moment.ages, 0.0)
        return np.asarray(self._speeds * (since + seconds))

    def profile(self, moment: Moment) -> StopProfile | None:
        """Return how the columns of this question brake; None where no one knows how they move."""
        if self._profiled is None or self._profiled[0] is not moment:
            self._profiled = moment, self._profile(moment)
        return self._profiled[1]

    def _profile(self, moment: Moment) -> StopProfile | None:
        velocities = self._braked.velocities(moment.states)
        if self.never or np.isnan(velocities).any():
            return None
        braking, count = self.question.braking, self._columns.width
        v = np.where(self._own, moment.velocities, 0.0)
        ages = np.zeros(count)
        for k, state in enumerate(moment.states):
            if state.age:
                first, base = self._columns.firsts[k], self._columns.bases[k]
                ages[first : first + len(state.positions)] = state.age
                ages[base if base >= 0 else first] = state.age
        ages[(v == 0.0) | np.isinf(ages)] = 0.0  # of unknown age nothing is proved
        radii = np.zeros(count)
        reactions = np.full(count, braking.reaction_time + moment.delay)
        shares, times = self._times(velocities)
        times = np.where(v == 0.0, 0.0, times)
        profile = StopProfile(v, ages, reactions, shares, times, radii)
        for base, state in zip(self._columns.bases, moment.states, strict=True):
            if base >= 0:
                radii[base] = arc_deviation(state, float(profile.travel(profile.fastest)[base]))
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

    def _trouble(self, moment: Moment, profile: StopProfile | None) -> str:
        """Return why nothing can be proved now; empty: something can."""
        v, matter = moment.velocities, self._moves_pairs
        if self.never:
            return self.never
        if profile is None:
            some = self._some(self._own & np.isnan(v)) or 'its base'
            return (
                f'nobody knows how fast {some} move: publish velocities of joints, or stamped '
                'values; of a base, twists, with the parameter closing_speeds'
            )
        if any(math.isinf(s.age) and self._is_of(k) for k, s in enumerate(moment.states)):
            return 'the values of its joints are stale, or of unknown age'
        if (lost := np.isnan(moment.values) & matter).any():
            return f'nothing was heard of {self._some(lost)}'
        loose = self._loose_a if self.question.max_speed else self._loose_a | self._loose_b
        if (astray := loose & ~(v == 0.0)).any():
            return (
                f'{self._some(astray)} move, or nobody knows whether they do, and no stoppable '
                'rule says how they brake; name them in joint_names, or give max_speed where '
                'they are of set_b'
            )
        for k, state in enumerate(moment.states):
            stands = self._columns.bases[k] >= 0 or state.V_PB is None or not state.V_PB.any()
            if not stands and self._is_of(k):
                return (
                    f'the base of {self._columns.robots[k].name!r} moves, or nobody knows whether '
                    'it does, and it does not brake; name x, y and theta in joint_names'
                )
        if self._has_half_spaces:
            return 'set_a moves a half space against another one, of which nothing can be proved'
        if moment.unplaced.any() and any(
            moment.unplaced[pairs.used].any() for pairs in (self._alone, self._shared)
        ):
            return 'a body of the rule never had a pose'
        return ''

    def _some(self, columns: Flags) -> str:
        """Return what some columns (c,) are called."""
        names = self._columns.names()
        some = [names[k] for k in np.flatnonzero(columns).tolist()]
        more = f' and {len(some) - 3} more' if len(some) > 3 else ''
        return ', '.join(some[:3]) + more

    def _is_of(self, robot: int) -> bool:
        """Return whether a joint or the base of a robot moves any pair."""
        first, base = self._columns.firsts[robot], self._columns.bases[robot]
        own = self._moves_pairs[first : first + len(self._columns.robots[robot].joint_names)]
        return bool(own.any() or (base >= 0 and self._moves_pairs[base]))

    def _of_others(self, moment: Moment, every: Sequence[PreparedQuestion]) -> StopProfile | str:
        """Return how other questions' columns brake that matter here, or why nobody knows."""
        profiles = [each.profile(moment) for each in every if (each._own & self._others).any()]
        known = [profile for profile in profiles if profile is not None]
        if len(known) < len(profiles):
            return 'nobody knows how fast the other robots move that brake by rules of their own'
        together = known[0]
        for profile in known[1:]:
            together = joined(together, profile)
        return together._replace(velocities=np.where(self._others, together.velocities, 0.0))

    def _along_path(
        self, pairs: MovingPairs, moment: Moment, profile: StopProfile, asked: Flags, most: int
    ) -> Stop:
        """Return the answer about pairs (k,) whose columns brake along their path."""
        margin, way = self.question.margin, path_over_shares(moment.values, profile)
        answer = pairs.follow(way, asked, margin, most)
        stop = pairs.stop(way, answer, asked, most)
        if stop.clear or profile.fastest < 1.0:
            return stop
        # Pairs that boxes prove for all stops are proved for this one.
        way, asked = path_over_time(moment.values, profile), asked & pairs.queries.examined()
        answer = pairs.follow(way, asked, margin, most)
        if answer.outcome != 'clear':
            return stop._replace(contact_time=way.at(answer.times[0]))
        return stop._replace(clear=True, least_clearance=answer.lower_bound, contact_time=math.inf)

    def _in_boxes(
        self, pairs: MovingPairs, moment: Moment, profile: StopProfile, asked: Flags, most: int
    ) -> Stop:
        """Return the answer about pairs (k,) whose columns stop each by itself.

        An edge that is not proved is looked at again in parts, whose boxes are smaller.
        """
        margin, way = self.question.margin, boxes_over_shares(moment.values, profile)
        answer = pairs.follow(way, asked, margin, most)
        stop = pairs.stop(way, answer, asked, most)
        if answer.outcome == 'clear':
            return stop
        finer = boxes_over_shares(moment.values, profile, way.edge(answer.times[0]), _FINER)
        again = pairs.follow(finer, asked, margin, most)
        second = pairs.stop(finer, again, asked, most)
        if second.scale <= stop.scale:
            return stop
        return second._replace(clear=False, least_clearance=-math.inf, contact_time=0.0)

    def measured(self, stop: Stop, moment: Moment) -> Stop:
        """Return an answer with the times, ways and speeds of its stop."""
        profile = self.profile(moment)
        if profile is None or math.isinf(stop.stopping_time):
            return stop
        speeds = np.abs(profile.velocities)
        age = float(profile.ages.max(initial=0.0))
        oldest = max(float(moment.ages[self._alone.used].max(initial=0.0)), age)
        reaction = self.question.braking.reaction_time + moment.delay + age
        stop = stop._replace(reaction_time=reaction, oldest_pose_age=oldest)
        if not speeds.any():
            return stop
        chain, values, moving = moment.chain, moment.values, self._moving_a
        goes = self._travel.of(chain, values, profile, profile.fastest)
        runs = self._travel.speeds(chain, values, profile, stop.scale)
        turns = (stop.scale * speeds * _turns(chain, speeds.size)).max(initial=0.0)
        stop = stop._replace(
            stopping_time=profile.duration_at(profile.fastest),
            stopping_distance=float(goes[moving].max(initial=0.0)),
            linear=float(runs[moving].max(initial=0.0)),
            angular=float(turns),
        )
        if profile.fastest >= 1.0:
            return stop
        return stop._replace(
            clear=False,
            least_clearance=-math.inf,
            contact_time=0.0,
            stopping_time=math.inf,
            stopping_distance=math.inf,
            trouble=stop.trouble
            or 'it is faster than stopping_times say, and nothing is known beyond; measure it at '
            'higher speeds',
        )


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
