"""A question about stops, prepared for one version of a scene."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import chain
from typing import NamedTuple

import numpy as np

from drake_geom_ros.geometry.queries.joint_trees import JointChain, JointKind
from drake_geom_ros.math.array_types import Flags, Floats
from drake_geom_ros.stopping.braking import StopCategory
from drake_geom_ros.stopping.moving_pairs import Moment, MovingPairs, PosedPairs
from drake_geom_ros.stopping.question_pairs import QuestionPairs, between
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
    end_of_stops,
    joined,
    path_over_shares,
    path_over_time,
)
from drake_geom_ros.stopping.travel import BodyTravel
from drake_geom_ros.stopping.unmapped import Unmapped, stop_before

_FINER = 4  # parts of an edge of boxes that is not proved, in the second look at it


class _Part(NamedTuple):
    """Pairs of a question that are looked at together, and how the columns move that move them."""

    pairs: MovingPairs
    chosen: Flags  # (k,)
    profile: StopProfile
    along: bool  # all columns brake along one path; otherwise each may stop by itself


class PreparedQuestion:
    """One question in one version of the scene."""

    def __init__(
        self,
        question: StoppingQuestion,
        braked: BrakedJoints,
        columns: Columns,
        about: QuestionPairs,
        posed: PosedPairs,
        travel: BodyTravel,
    ) -> None:
        self.question, self._braked, self._columns = question, braked, columns
        self._about, self._own = about, about.own
        self.never = braked.trouble  # why it can never be answered in this scene; empty: it can
        if not about.moving_a.any() and not self.never:
            self.never = (
                'no geometry of set_a is moved by the joints that brake; it must hold links of '
                'a robot whose joints are in joint_names'
            )
        self._moves_pairs = about.moves_pairs
        self._ids, alone = posed.ids, ~about.shared
        self._shared, self._alone, self._slow = (
            MovingPairs(posed, about, which)
            for which in (about.shared, alone & ~about.slow, alone & about.slow)
        )
        self._travel, self._posed = travel, posed
        self._profiled: tuple[Moment, StopProfile | None] | None = None

    def stop(self, moment: Moment, every: Sequence[PreparedQuestion], most: int) -> Stop:
        """Return the answer at a moment; ``every`` are all questions."""
        profile = self.profile(moment)
        if trouble := self._trouble(moment, profile):
            return unproved(trouble)
        assert profile is not None
        parts = self._parts(moment, profile, every)
        if isinstance(parts, str):
            return unproved(parts)
        stop = boxed = FREE
        done = list[_Part]()
        looked: Flags = np.zeros(len(self._posed.rows), dtype=np.bool_)
        for part in parts:
            # Only the shares that all pairs before allow matter any more.
            limited = part._replace(profile=part.profile.until(stop.scale))
            if part.along:
                answer = self._along_path(moment, limited, most, looked)
            else:
                answer = self._in_boxes(moment, limited, most, looked)
                boxed = worse(boxed, answer)
            stop = worse(stop, answer)
            done.append(part)
            if stop.scale == 0.0:
                break
        stop = self._counted(stop, parts, profile, looked)
        if stop.scale >= 1.0 or profile.fastest < 1.0:
            return stop
        if boxed.clear:
            stop = self._of_now(stop, moment, [part for part in parts if part.along], most)
        if stop.clear:
            least = min(stop.least_clearance, boxed.least_clearance)
            return stop._replace(least_clearance=least)
        seconds = min(part.profile.seconds_within(stop.scale) for part in done)
        return stop._replace(contact_time=seconds)

    def _counted(
        self, stop: Stop, parts: Sequence[_Part], profile: StopProfile, looked: Flags
    ) -> Stop:
        """Return an answer with the bodies and joints that did not matter to it.

        ``looked`` (m,) flags the pairs in one world that were looked at.
        """
        bodies, near = np.zeros((2, len(self._ids)), dtype=np.bool_)
        for part in parts:
            bodies[part.pairs.bodies_of(part.chosen)] = True
        near[self._posed.pairs[looked].ravel()] = True
        mine = looked[np.searchsorted(self._posed.rows, self._about.rows)]
        busy = self._about.relative[mine].any(axis=0)
        idle = self._own & (profile.velocities != 0.0) & ~busy
        far = int(np.count_nonzero(bodies & ~near))
        return stop._replace(far_bodies=far, idle_joints=int(np.count_nonzero(idle)))

    def _parts(
        self, moment: Moment, profile: StopProfile, every: Sequence[PreparedQuestion]
    ) -> list[_Part] | str:
        """Return the pairs that move, those whose distances take longest last.

        It is a text where nobody knows how they move.
        """
        along = self.question.braking.category == StopCategory.ALONG_PATH
        moving, parts = self._own & (profile.velocities != 0.0), list[_Part]()
        if (chosen := self._shared.moved_by(moving)).any():
            others = self._of_others(moment, every)
            if isinstance(others, str):
                return others
            independent = (chosen & self._shared.moved_by(others.velocities != 0.0)).any()
            together = joined(profile, others)
            parts.append(_Part(self._shared, chosen, together, along and not independent))
        for pairs in (self._alone, self._slow):
            if (chosen := pairs.moved_by(moving)).any():
                parts.append(_Part(pairs, chosen, profile, along))
        return parts

    def reach(self, moment: Moment) -> float:
        """Return the distance [m] from which on nothing beside a body can matter to a stop."""
        profile = self.profile(moment)
        if profile is None or not profile.velocities.any():
            return 0.0
        goes = self._travel.of(moment.chain, moment.values, profile, profile.fastest)
        comes = self._comes(moment, profile.duration_at(profile.fastest))
        moved = self._about.moved_by[:, self._own].any(axis=1)
        return float(goes[moved].max() + comes.max() + self.question.margin)

    def held_against(self, unmapped: Sequence[Unmapped], stop: Stop, moment: Moment) -> Stop:
        """Return an answer that holds against what is beside the bodies that brake, too."""
        profile = None if math.isinf(stop.stopping_time) else self.profile(moment)
        if profile is None:
            return stop
        moving = self._own & (profile.velocities != 0.0)
        for each in unmapped:
            body, other = np.searchsorted(self._ids, (each.body, each.other)).tolist()
            chosen = between(np.array([(body, other)]), self._about.in_a, self._about.in_b)
            if chosen.any() and self._about.moved_by[body, moving].any():
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
        speeds = self._about.speeds
        since = np.where(speeds > 0.0, moment.ages, 0.0)
        return np.asarray(speeds * (since + seconds))

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
        about = self._about
        loose = about.loose_a if self.question.max_speed else about.loose_a | about.loose_b
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
        if about.has_half_spaces:
            return 'set_a moves a half space against another one, of which nothing can be proved'
        if moment.unplaced.any() and any(
            moment.unplaced[pairs.used].any() for pairs in (self._shared, self._alone, self._slow)
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
        profiles = [
            each.profile(moment) for each in every if (each._own & self._about.others).any()
        ]
        known = [profile for profile in profiles if profile is not None]
        if len(known) < len(profiles):
            return 'nobody knows how fast the other robots move that brake by rules of their own'
        together = known[0]
        for profile in known[1:]:
            together = joined(together, profile)
        return together._replace(velocities=np.where(self._about.others, together.velocities, 0.0))

    def _along_path(self, moment: Moment, part: _Part, most: int, looked: Flags) -> Stop:
        """Return the answer about pairs whose columns brake along their path.

        ``looked`` gets the pairs that were looked at.
        """
        margin, way = self.question.margin, path_over_shares(moment.values, part.profile)
        judged = part.pairs.follow(moment, way, part.chosen, margin, most)
        looked |= judged.examined
        return part.pairs.stop(way, judged, part.chosen, most)

    def _in_boxes(self, moment: Moment, part: _Part, most: int, looked: Flags) -> Stop:
        """Return the answer about pairs whose columns stop each by itself.

        An edge that is not proved is looked at again in parts, whose boxes are smaller.
        ``looked`` gets the pairs that were looked at.
        """
        chosen, profile, margin = part.chosen, part.profile, self.question.margin
        way = boxes_over_shares(moment.values, profile)
        judged = part.pairs.follow(moment, way, chosen, margin, most)
        looked |= judged.examined
        stop = part.pairs.stop(way, judged, chosen, most)
        if judged.answer.outcome == 'clear':
            return stop
        first = way.edge(judged.answer.times[0])
        finer = boxes_over_shares(moment.values, profile, first, _FINER)
        again = part.pairs.follow(moment, finer, chosen, margin, most)
        second = part.pairs.stop(finer, again, chosen, most)
        if second.scale <= stop.scale:
            return stop
        return second._replace(clear=False, least_clearance=-math.inf, contact_time=0.0)

    def _of_now(self, stop: Stop, moment: Moment, parts: Sequence[_Part], most: int) -> Stop:
        """Return an answer with what the stop from the present speed is, along its path.

        It passes each point sooner than slower stops do, so what approaches may not be there yet.
        """
        margin, least, evaluations = self.question.margin, math.inf, stop.evaluations
        # It ends where those of all shares do. Mostly the pair that is too near on the way is so
        # there, too.
        q = moment.values
        ends = ((part, end_of_stops(q, part.profile), part.pairs.of(stop)) for part in parts)
        ways = ((part, path_over_time(q, part.profile), part.chosen) for part in parts)
        for part, way, chosen in chain(ends, ways):
            if not chosen.any():
                continue
            answer = part.pairs.follow(moment, way, chosen, margin, most).answer
            evaluations += answer.evaluations
            if answer.outcome != 'clear':
                return stop._replace(evaluations=evaluations)
            least = min(least, answer.lower_bound)
        return stop._replace(
            clear=True, evaluations=evaluations, least_clearance=least, contact_time=math.inf
        )

    def travel(self, moment: Moment) -> Floats:
        """Return how far (c,) columns go until they stand; 0 where nobody knows."""
        profile = self.profile(moment)
        known = profile is not None and profile.fastest >= 1.0
        if not known or profile is None or np.isnan(moment.values).any():
            return np.zeros(self._columns.width)
        return np.nan_to_num(profile.travel(), posinf=0.0, neginf=0.0)

    def measured(self, stop: Stop, moment: Moment) -> Stop:
        """Return an answer with the times, ways and speeds of its stop."""
        profile = self.profile(moment)
        if profile is None or math.isinf(stop.stopping_time):
            return stop
        speeds = np.abs(profile.velocities)
        age = float(profile.ages.max(initial=0.0))
        used = np.concatenate((self._alone.used, self._slow.used))
        oldest = max(float(moment.ages[used].max(initial=0.0)), age)
        reaction = self.question.braking.reaction_time + moment.delay + age
        stop = stop._replace(reaction_time=reaction, oldest_pose_age=oldest)
        if not speeds.any():
            return stop
        chain, values, moving = moment.chain, moment.values, self._about.moving_a
        goes, runs = self._travel.and_speeds(chain, values, profile, stop.scale)
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


def _turns(chain: JointChain, count: int) -> Floats:
    """Return how fast (c,) [rad] a joint turns for each column's unit of speed; 0: it slides."""
    turns = np.zeros(count)
    led = (chain.leaders >= 0) & (chain.kinds == JointKind.REVOLUTE)
    np.maximum.at(turns, chain.leaders[led], np.abs(chain.multipliers[led]))
    return turns
