"""A question about stops, prepared for one version of a scene."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import reduce
from itertools import chain
from typing import NamedTuple

import numpy as np

from drake_geom_ros.geometry.queries.stop_queries import (
    AGE,
    ALONG,
    AT_END,
    EACH,
    IN_TIME,
    PROFILE_ROWS,
    REACTION,
    VELOCITY,
    StopDemand,
    StopLook,
    seconds_within,
)
from drake_geom_ros.math.array_types import Flags, Floats
from drake_geom_ros.stopping.braking import StopCategory
from drake_geom_ros.stopping.moving_pairs import ChosenPairs, Moment, MovingPairs, PosedPairs
from drake_geom_ros.stopping.question_pairs import QuestionPairs, between
from drake_geom_ros.stopping.robots import BrakedJoints, Columns, arc_deviation
from drake_geom_ros.stopping.stop import (
    FREE,
    Stop,
    StoppingQuestion,
    unproved,
    worse,
)
from drake_geom_ros.stopping.stop_profile import StopProfile, joined
from drake_geom_ros.stopping.travel import BodyTravel
from drake_geom_ros.stopping.unmapped import Unmapped, stop_before

_FROM_STILL = np.array([0.0, 1.0])  # shares


class _Part(NamedTuple):
    """Pairs of a question that are looked at together, and how the columns move that move them."""

    pairs: MovingPairs
    chosen: ChosenPairs
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
        # Every call of NumPy counts: after other work each one is a cache miss. What the scene
        # alone decides is computed here.
        self._used = np.concatenate((self._alone.used, self._slow.used))
        self._loose: Flags = about.loose_a
        if not question.max_speed:
            self._loose = about.loose_a | about.loose_b
        self._has_loose = bool(self._loose.any())
        self._joints = np.array(
            [columns.firsts[robot] + joint for robot, joint in braked.joints], dtype=np.int64
        )
        self._decelerations = np.zeros(0)
        if question.braking.decelerations and not braked.trouble:
            count = len(braked.joints) + len(braked.bases)
            self._decelerations = question.braking.decelerations_of(count)
        self._neighbours: tuple[PreparedQuestion, ...] = ()
        self._of_both: tuple[tuple[bytes, bytes], bool] | None = None
        self._profiled: tuple[Moment, StopProfile | None] | None = None

    def stand_beside(self, every: Sequence[PreparedQuestion]) -> None:
        """Take those of all questions whose columns move pairs of this one."""
        others = self._about.others
        self._neighbours = tuple(each for each in every if (each._own & others).any())

    def stop(self, moment: Moment, most: int) -> Stop:
        """Return the answer at a moment."""
        profile = self.profile(moment)
        if trouble := self._trouble(moment, profile):
            return unproved(trouble)
        assert profile is not None
        moving = profile.velocities != 0.0
        parts = self._parts(moment, profile, moving)
        if isinstance(parts, str):
            return unproved(parts)
        stop = boxed = FREE
        done, looks = list[_Part](), list[StopLook]()
        demand = StopDemand(self.question.margin, self._posed.resolution, most)
        for part in parts:
            # Only the shares that all pairs before allow matter any more.
            kind = ALONG if part.along else EACH
            look = part.pairs.look(moment, kind, stop.scale, part.profile, demand, part.chosen)
            answer = part.pairs.stop(look, part.chosen)
            if not part.along:
                boxed = worse(boxed, answer)
            stop = worse(stop, answer)
            done.append(part)
            looks.append(look)
            if stop.scale == 0.0:
                break
        stop = self._counted(stop, parts, moving, looks)
        if stop.scale >= 1.0 or profile.fastest < 1.0:
            return stop
        if boxed.clear:
            stop = self._of_now(stop, moment, [part for part in parts if part.along], demand)
        if stop.clear:
            least = min(stop.least_clearance, boxed.least_clearance)
            return stop._replace(least_clearance=least)
        profiles = {id(part.profile): part.profile for part in done}
        seconds = [seconds_within(*each, stop.scale) for each in profiles.values()]
        return stop._replace(contact_time=min(seconds))

    def _counted(
        self,
        stop: Stop,
        parts: Sequence[_Part],
        moving: Flags,
        looks: Sequence[StopLook],
    ) -> Stop:
        """Return an answer with the bodies and joints that did not matter to any of its looks."""
        if not looks:
            return stop._replace(idle_joints=int(np.count_nonzero(moving)))
        bodies = reduce(np.logical_or, (part.chosen.bodies for part in parts))
        near = reduce(np.logical_or, (look.near for look in looks))
        busy = reduce(np.logical_or, (look.busy for look in looks))
        # One flag is greater than another where it is set and the other is not.
        return stop._replace(
            far_bodies=int(np.count_nonzero(bodies > near)),
            idle_joints=int(np.count_nonzero(moving > busy)),
        )

    def _parts(self, moment: Moment, profile: StopProfile, moving: Flags) -> list[_Part] | str:
        """Return the pairs that move, those whose distances take longest last.

        It is a text where nobody knows how they move.
        """
        along = self.question.braking.category == StopCategory.ALONG_PATH
        parts = list[_Part]()
        chosen = self._shared.chosen_by(moving)
        if len(chosen.places):
            others = self._of_others(moment)
            if isinstance(others, str):
                return others
            independent = along and self._moved_by_both(moving, others.velocities != 0.0)
            together = joined(profile, others)
            parts.append(_Part(self._shared, chosen, together, along and not independent))
        for pairs in (self._alone, self._slow):
            chosen = pairs.chosen_by(moving)
            if len(chosen.places):
                parts.append(_Part(pairs, chosen, profile, along))
        return parts

    def _moved_by_both(self, moving: Flags, others: Flags) -> bool:
        """Return whether columns of this question and of others (c,) move any pair together."""
        key = moving.tobytes(), others.tobytes()  # mostly the same columns as in the last cycle
        if self._of_both is None or self._of_both[0] != key:
            both = self._shared.moved_by(moving) & self._shared.moved_by(others)
            self._of_both = key, bool(both.any())
        return self._of_both[1]

    def reach(self, moment: Moment) -> float:
        """Return the distance [m] beyond which other bodies cannot affect a stop."""
        profile = self.profile(moment)
        if profile is None or not profile.velocities.any():
            return 0.0
        goes = self._travel.of(moment, profile, profile.fastest)
        comes = self._comes(moment, profile.duration_at(profile.fastest))
        moved = self._about.moved_by[:, self._own].any(axis=1)
        return float(goes[moved].max() + comes.max() + self.question.margin)

    def held_against(self, unmapped: Sequence[Unmapped], stop: Stop, moment: Moment) -> Stop:
        """Return an answer that also covers bodies beside the braking ones."""
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
            goes = self._travel.of(moment, profile, share)[body]
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
        speeds = np.abs(
            self._braked.velocities(moment.states)
            if self._braked.bases
            else moment.velocities[self._joints]
        )
        fastest = float(speeds.max(initial=0.0))
        if self.never or math.isnan(fastest):
            return None
        columns = np.zeros((PROFILE_ROWS, self._columns.width))
        v, ages = columns[VELOCITY], columns[AGE]
        np.copyto(v, moment.velocities, where=self._own)
        columns[REACTION] = self.question.braking.reaction_time + moment.delay
        still = v == 0.0
        for k, state in enumerate(moment.states):
            if state.age and not math.isinf(state.age):  # of unknown age nothing is proved
                first, base = self._columns.firsts[k], self._columns.bases[k]
                ages[first : first + len(state.positions)] = state.age
                ages[base if base >= 0 else first] = state.age
                ages[still] = 0.0
        shares, times = self._times(speeds, fastest)
        times[:, still] = 0.0
        profile = StopProfile(columns, shares, times)
        for base, state in zip(self._columns.bases, moment.states, strict=True):
            if base >= 0:
                profile.radii[base] = arc_deviation(
                    state, float(profile.travel(profile.fastest)[base])
                )
        return profile

    def _times(self, joint_speeds: Floats, fastest: float) -> tuple[Floats, Floats]:
        """Return shares (k,) and the times (k, c) of columns to brake from them.

        ``joint_speeds`` (n,) are those of what brakes, in the order of decelerations.
        """
        braking, count = self.question.braking, self._columns.width
        if braking.stopping_times:
            speeds, times = np.array(braking.stopping_times).T
            shares = speeds / fastest if fastest else np.array([1.0])
            inside = shares < 1.0
            table_shares = np.concatenate(([0.0], shares[inside]))
            if not inside.all():
                table_shares = np.append(table_shares, 1.0)
            each = np.interp(table_shares * fastest, speeds, times)
            return table_shares, np.repeat(each[:, None], count, axis=1)
        times, each = np.zeros((2, count)), joint_speeds / self._decelerations
        if braking.category == StopCategory.ALONG_PATH:
            times[1] = each.max(initial=0.0)
        else:
            times[1] = self._braked.by_column(self._columns, each)
        return _FROM_STILL, times

    def _trouble(self, moment: Moment, profile: StopProfile | None) -> str:
        """Return why nothing can be proved now; empty: something can."""
        v, matter = moment.velocities, self._moves_pairs
        if self.never:
            return self.never
        if profile is None:
            unknown = self._own & np.isnan(v)
            moving = self._moving(unknown) if unknown.any() else 'its base moves'
            return (
                f'nobody knows how fast {moving}: publish velocities of joints, or stamped '
                'values; of a base, twists, with the parameter closing_speeds'
            )
        if any(math.isinf(s.age) and self._is_of(k) for k, s in enumerate(moment.states)):
            return 'the values of its joints are stale, or of unknown age'
        if not moment.is_known and (lost := np.isnan(moment.values) & matter).any():
            return f'nothing was heard of {self._some(lost)}'
        if self._has_loose and (astray := self._loose & ~(v == 0.0)).any():
            return (
                f'{self._moving(astray)}, or nobody knows whether that is so, and no stoppable '
                'rule says how to brake there; name it in joint_names, or give max_speed where '
                'set_b has it'
            )
        for k, state in enumerate(moment.states):
            stands = self._columns.bases[k] >= 0 or state.V_PB is None or not state.V_PB.any()
            if not stands and self._is_of(k):
                return (
                    f'the base of {self._columns.robots[k].name!r} moves, or nobody knows whether '
                    'it does, and it does not brake; name x, y and theta in joint_names'
                )
        if self._about.has_half_spaces:
            return 'set_a moves a half space against another one, of which nothing can be proved'
        if not moment.is_known and any(
            moment.unplaced[pairs.used].any() for pairs in (self._shared, self._alone, self._slow)
        ):
            return 'a body of the rule never had a pose'
        return ''

    def _some(self, columns: Flags) -> str:
        """Return the names of some columns (c,)."""
        names = self._columns.names()
        some = [names[k] for k in np.flatnonzero(columns).tolist()]
        more = f' and {len(some) - 3} more' if len(some) > 3 else ''
        return ', '.join(some[:3]) + more

    def _moving(self, columns: Flags) -> str:
        """Return that columns (c,) move, with their names."""
        return f'{self._some(columns)} {"moves" if np.count_nonzero(columns) == 1 else "move"}'

    def _is_of(self, robot: int) -> bool:
        """Return whether a joint or the base of a robot moves any pair."""
        first, base = self._columns.firsts[robot], self._columns.bases[robot]
        own = self._moves_pairs[first : first + len(self._columns.robots[robot].joint_names)]
        return bool(own.any() or (base >= 0 and self._moves_pairs[base]))

    def _of_others(self, moment: Moment) -> StopProfile | str:
        """Return how other questions' columns brake that matter here, or why nobody knows."""
        profiles = [each.profile(moment) for each in self._neighbours]
        profiles_of_now = [profile for profile in profiles if profile is not None]
        if len(profiles_of_now) < len(profiles):
            return 'nobody knows how fast the other robots move that brake by rules of their own'
        together = profiles_of_now[0]
        for profile in profiles_of_now[1:]:
            together = joined(together, profile)
        return together._replace(columns=together.columns * self._about.others)

    def _of_now(
        self, stop: Stop, moment: Moment, parts: Sequence[_Part], demand: StopDemand
    ) -> Stop:
        """Return an answer with the stop from the present speed along its path.

        It passes each point sooner than slower stops do, so what approaches may not be there yet.
        """
        least, evaluations = math.inf, stop.evaluations
        # It ends where those of all shares do. Mostly the pair that is too near on the way is so
        # there, too.
        ends = ((part, AT_END, part.pairs.of(part.chosen, stop)) for part in parts)
        ways = ((part, IN_TIME, part.chosen) for part in parts)
        for part, kind, chosen in chain(ends, ways):
            if not len(chosen.places):
                continue
            look = part.pairs.look(moment, kind, 1.0, part.profile, demand, chosen)
            evaluations += look.evaluations
            if not look.is_proved:
                return stop._replace(evaluations=evaluations)
            least = min(least, look.clearance)
        return stop._replace(
            clear=True, evaluations=evaluations, least_clearance=least, contact_time=math.inf
        )

    def travel(self, moment: Moment) -> Floats:
        """Return how far (c,) columns go until they stand; 0 where nobody knows."""
        profile = self.profile(moment)
        is_complete = profile is not None and profile.fastest >= 1.0
        if not is_complete or profile is None or np.isnan(moment.values).any():
            return np.zeros(self._columns.width)
        return np.nan_to_num(profile.travel(), posinf=0.0, neginf=0.0)

    def measured(self, stop: Stop, moment: Moment) -> Stop:
        """Return an answer with the times, ways and speeds of its stop."""
        profile = self.profile(moment)
        if profile is None or math.isinf(stop.stopping_time):
            return stop
        age = float(profile.ages.max(initial=0.0))
        oldest = max(float(moment.ages[self._used].max(initial=0.0)), age)
        reaction = self.question.braking.reaction_time + moment.delay + age
        stop = stop._replace(reaction_time=reaction, oldest_pose_age=oldest)
        if not profile.velocities.any():
            return stop
        seconds, way, linear, angular = self._travel.measures(
            moment, profile, stop.scale, self._about.moving_a
        )
        stop = stop._replace(
            stopping_time=seconds, stopping_distance=way, linear=linear, angular=angular
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
