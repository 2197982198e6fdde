"""The proximity rules of the live scene, bound to what it holds now."""

from __future__ import annotations

import copy
import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry import (
    CandidatePairs,
    FrameId,
    GeometryId,
    GeometryVersion,
    QueryObject,
    SceneGraphInspector,
    SignedDistanceResults,
    closing_speeds,
)
from drake_geom_ros.live.conversions.names import HEARTBEAT, TRACKED, some_of
from drake_geom_ros.live.scene.bound_rules import (
    BoundRules,
    FlagsOnFrames,
    hanging,
    is_same_for_rules,
    narrowed_to,
)
from drake_geom_ros.live.scene.counted_points import CountedPoints
from drake_geom_ros.live.scene.measured_pairs import (
    extents,
    measured_pairs,
    with_half_spaces,
)
from drake_geom_ros.live.scene.out_of_sight import Balls, MapSights, unseen_bodies
from drake_geom_ros.live.scene.seen_shells import SeenShell, with_shells
from drake_geom_ros.proximity_rules import (
    Event,
    Measured,
    NamedGeometries,
    Poses,
    ProximityRule,
    RuleMonitor,
    RuleState,
    RuleStates,
    ScaleOfRobot,
    ScenePairs,
    UnseenBodies,
    WatchedPairs,
    Zones,
    geometry_names,
    unseen_of_groups,
    zones_in,
)
from drake_geom_ros.stopping import Stop

Twists = Mapping[FrameId, NDArray[np.float64]]
_NO_PAIRS = ScenePairs(NamedGeometries([]), CandidatePairs.of_all(np.zeros(0, dtype=np.int64)))


class Blind(NamedTuple):
    """Frames (values of ids) whose poses are stale or unknown."""

    stale: Collection[int]  # too old, or of unknown age
    absent: Collection[int]  # never posed
    contested: Collection[int] = ()  # posed by two senders in turn
    foreign: Collection[int] = ()  # posed with stamps of another clock


class SceneRules:
    """The proximity rules, the pairs that they watch, and their states."""

    def __init__(self) -> None:
        self._monitor = RuleMonitor(_NO_PAIRS)
        self._version, self._frames_version = GeometryVersion(), -1
        self._hanging: dict[int, list[int]] = {}  # by frame: the rows of the geometries on it
        self._carried: dict[int, NDArray[np.int64]] | None = None  # the same by ids
        self._flags_of_blind = [FlagsOnFrames() for _ in Blind._fields]
        self._frames = np.zeros(0, dtype=np.int64)  # of each geometry
        # [m] how far geometries reach from the origin of each frame; None: to be found
        self._extents: dict[FrameId, float] | None = None
        self._balls: Balls | None = None  # around geometries that sensed maps are reported with
        self._pairs = _NO_PAIRS
        self._bodies = _NO_PAIRS.reported  # pairs without zones
        self._zones: Zones = {}
        self._with_zones: QueryObject | None = None  # made when a rule about a zone is measured
        self._narrowed: QueryObject | None = None
        self._counts = CountedPoints()
        self._prepared: BoundRules | None = None  # of a version of the scene that comes
        self._happened: list[Event] = []  # that nobody was told of yet
        self.revision = 0  # changes with each rule, state and number of pairs

    def copy(self) -> SceneRules:
        """Return the rules as they are now, for a thread that does not hold the scene."""
        other = copy.copy(self)
        other._monitor = copy.copy(self._monitor)
        return other

    @property
    def rules(self) -> tuple[ProximityRule, ...]:
        """The rules in the order in which they came."""
        return self._monitor.rules

    @property
    def next_sequence(self) -> int:
        """The number of the next event."""
        return self._monitor.next_sequence

    @property
    def measurement(self) -> object:
        """The last measurement of the present pairs, to tell it from another; None: none."""
        return self._monitor.measurement

    def nearest_points(self) -> list[tuple[NDArray[np.float64], NDArray[np.float64]] | None]:
        """Return p_WCa and p_WCb [m] of the nearest pair of each rule; see ``RuleMonitor``."""
        return self._monitor.nearest_points()

    @property
    def is_measured(self) -> bool:
        """True if the rules were decided by the distances of the present pairs."""
        return self._monitor.is_measured

    def add(self, rules: Iterable[ProximityRule]) -> RuleState:
        """Add rules that can be entered in the scene that it is bound to, all or none.

        Returns the last one; raises RuleError for others.
        """
        new = list(rules)
        prepared = self._prepared_for((*self.rules, *new))
        self._monitor.add(new, prepared and prepared.watched)
        self._changed()
        self._narrowed = prepared and prepared.own_narrowed
        return self._monitor.states()[-1]

    def take(self, rules: Sequence[ProximityRule]) -> list[str]:
        """Have the rules of a scene file, in place of those of the same names.

        Returns what is wrong with those that can never be entered as the scene is.
        """
        others = self._replaced_by(rules)
        stay = {rule.name for rule in self.rules}.difference(others)
        new = [rule for rule in rules if rule.name not in stay]
        if not new:
            return []
        prepared = self._prepared_for(self.after(rules))
        events, released = self._monitor.exchange(others, new, prepared and prepared.watched)
        self._happened += events
        self._changed()
        self._narrowed = prepared and prepared.own_narrowed
        troubles = self._monitor.watched.trouble[len(self.rules) - len(new) :]
        return [*filter(None, troubles), *released]

    def acknowledge(self, name: str, sequence: int) -> None:
        """Let a latched rule be left that the event of this number entered.

        Raises the RuleError of ``RuleMonitor.acknowledge``.
        """
        before = self.rules
        self._happened += self._monitor.acknowledge(name, sequence)
        self.revision += 1
        if self.rules != before:
            self._changed()

    def unacknowledged(self) -> dict[str, int]:
        """Return by latched rule the event that entered it, and that has to be acknowledged."""
        return self._monitor.unacknowledged()

    def begin_entered(self) -> None:
        """Have the next decision enter latched rules: their state before the start is unknown."""
        self._monitor.begin_entered()

    def after(
        self, taken: Sequence[ProximityRule], removed: Collection[str] = ()
    ) -> tuple[ProximityRule, ...]:
        """Return the rules after additions and removals."""
        gone = {*removed, *self._replaced_by(taken)}
        stay = [rule for rule in self.rules if rule.name not in gone]
        there = {rule.name for rule in stay}
        return (*stay, *(rule for rule in taken if rule.name not in there))

    def _replaced_by(self, rules: Sequence[ProximityRule]) -> list[str]:
        """Return the names of the rules that others replace."""
        present = {rule.name: rule for rule in self.rules}
        return [rule.name for rule in rules if present.get(rule.name, rule) != rule]

    def _prepared_for(self, rules: tuple[ProximityRule, ...]) -> BoundRules | None:
        """Return the binding prepared for these rules and the present scene, or None."""
        prepared, self._prepared = self._prepared, None
        if prepared is None or not prepared.is_of(self._version, rules):
            return None
        return prepared if prepared.pairs is self._pairs else None

    def remove(self, name: str) -> None:
        """Remove a rule; raises RuleError where there is none of that name."""
        prepared = self._prepared_for(self.after([], [name]))
        self._happened += self._monitor.remove(name, watched=prepared and prepared.watched)
        self._changed()
        self._narrowed = prepared and prepared.own_narrowed

    def _changed(self) -> None:
        self._narrowed, self.revision = None, self.revision + 1

    def bind(self, query: QueryObject, frames_version: int) -> None:
        """Bind the rules to the present scene, if its content or its filters changed."""
        inspector = query.inspector()
        version = inspector.geometry_version()
        is_same = is_same_for_rules(version, self._version)
        if is_same and frames_version == self._frames_version:
            return
        prepared = self._prepared
        if prepared is not None and prepared.is_about(version):
            self._be_prepared(prepared, frames_version)
            return
        self._prepared = None
        have_same_names = frames_version == self._frames_version
        self._version, self._frames_version = version, frames_version
        self._extents = self._balls = self._with_zones = None
        candidates, zones = inspector.candidate_pairs(), zones_in(inspector)
        if have_same_names and self._has_pairs(candidates, zones):
            # Shapes changed, as those of sensed maps do many times a second: rules are about the
            # same pairs.
            self._narrowed, self._zones = None, zones
            self.measure_again()
            return
        bound = self._bound(query, self.rules, candidates, zones, have_same_names)
        self._be(bound._replace(frames_version=frames_version))

    def _has_pairs(self, candidates: CandidatePairs, zones: Zones) -> bool:
        """Return whether rules are about these pairs without zones, and these zones."""
        return self._zones.keys() == zones.keys() and self._bodies.matches(candidates)

    def _be_prepared(self, prepared: BoundRules, frames_version: int) -> None:
        """Bind the rules to the version of the scene that they were prepared for.

        It stays there for rules that come with that version.
        """
        if prepared.rules != self.rules:
            watched = self._monitor.watching(self.rules, prepared.pairs)
            self._be(prepared._replace(frames_version=frames_version, watched=watched))
            return
        self._prepared = None
        if prepared.pairs is self._pairs:
            self._version, self._frames_version = prepared.version, frames_version
            self._zones, self._extents = prepared.zones, None
            self._balls = self._with_zones = None
            self.measure_again()
        else:
            self._be(prepared._replace(frames_version=frames_version))
        self._narrowed = prepared.own_narrowed

    def prepared(
        self, query: QueryObject, rules: tuple[ProximityRule, ...], *, same_names: bool
    ) -> BoundRules:
        """Return the binding to a copy of the scene that will replace it.

        With these ``rules``; with the ``same_names`` as the scene of now where only shapes and
        filters are others.
        """
        inspector = query.inspector()
        candidates, zones = inspector.candidate_pairs(), zones_in(inspector)
        if same_names and rules == self.rules and self._has_pairs(candidates, zones):
            version = inspector.geometry_version()
            present = self._pairs, self._monitor.watched, self._hanging, self._frames
            bound = BoundRules(version, -1, rules, *present, candidates, zones, query)
        else:
            bound = self._bound(query, rules, candidates, zones, same_names)
        if bound.watched.needed_zones.any():
            query = query.with_proximity(zones)
        return bound._replace(narrowed=narrowed_to(query, bound.watched, zones))

    def offer(self, prepared: BoundRules | None) -> None:
        """Keep the ``prepared`` binding to the present scene until the next ``bind``."""
        self._prepared = prepared

    def _bound(
        self,
        query: QueryObject,
        rules: tuple[ProximityRule, ...],
        bodies: CandidatePairs,
        zones: Zones,
        same_names: bool,
    ) -> BoundRules:
        """Return the binding of rules; unchanged names and frames are reused."""
        inspector = query.inspector()
        version, candidates = inspector.geometry_version(), bodies
        if zones:
            candidates = query.with_proximity(zones).inspector().candidate_pairs()
        if same_names and np.array_equal(candidates.ids, self._pairs.ids):
            pairs, on, frames = self._pairs, self._hanging, self._frames
            if not pairs.reported.matches(candidates):
                pairs = ScenePairs(pairs.geometries, candidates)
        else:
            geometries = [GeometryId(value) for value in candidates.ids.tolist()]
            names = [
                geometry_names(inspector, geometry)._replace(is_zone=geometry in zones)
                for geometry in geometries
            ]
            heartbeat = [(each.source, each.frame_name) == (TRACKED, HEARTBEAT) for each in names]
            vital = np.array(heartbeat, dtype=np.bool_)
            pairs = ScenePairs(NamedGeometries(names, vital), candidates)
            on = hanging(inspector, geometries)
            of_each = (inspector.GetFrameId(geometry).get_value() for geometry in geometries)
            frames = np.fromiter(of_each, np.int64, len(geometries))
        watched = self._monitor.watching(rules, pairs)
        binding = pairs, watched, on, frames, bodies, zones
        return BoundRules(version, -1, rules, *binding, query)

    def _be(self, bound: BoundRules) -> None:
        """Adopt a binding."""
        self._changed()
        self._version, self._frames_version = bound.version, bound.frames_version
        self._bodies, self._zones = bound.bodies, bound.zones
        self._extents = self._balls = self._with_zones = None
        self._pairs, self._hanging, self._frames = bound.pairs, bound.hanging, bound.frames
        self._carried = None
        self._happened += self._monitor.bind(bound.pairs, bound.watched)

    def decide(
        self,
        now: float,
        query: QueryObject,
        unreliable: Blind,
        seen: tuple[SignedDistanceResults, float] | None = None,
        twists: Twists | None = None,
        time_budget: float = 0.0,
        shells: Sequence[tuple[GeometryId, SeenShell]] = (),
        sights: Sequence[MapSights] = (),
        stops: Mapping[str, Stop] | None = None,
    ) -> int:
        """Decide by the poses of now [s]; return how many pairs were computed for it.

        ``seen`` are the distances of all pairs within so many metres, where a cycle
        has them: what rules need beyond is computed, of their pairs alone, within a
        ``time_budget`` [s] (0: without one). ``shells`` are what sensors saw beside bodies, which
        counts as near for the rules about their maps; of bodies out of their ``sights`` nothing is
        known. ``stops`` are the answers of now for stoppable rules.
        """
        farthest = self._monitor.farthest(self._fastest(query.inspector(), twists))
        computed, without_zones = 0, query
        query = self.with_zones(query)
        if seen is not None and seen[1] >= farthest and query is without_zones:
            results = seen[0]
        else:
            results = self._narrow(query).ComputeSignedDistancePairwiseClosestPoints(
                farthest, time_budget=time_budget
            )
            computed = len(results)
        speeds = None if twists is None else closing_speeds(results, twists).speed
        measured = with_half_spaces(measured_pairs(results, speeds), query)
        measured = self._counts.counted(measured, query, self._monitor.watched, farthest)
        if shells:
            measured = with_shells(measured, query, shells, self._pairs, farthest)
        if sights:
            measured = measured._replace(unseen=self.unseen_bodies(query, sights))
        if twists is not None and any(rule.min_time_to_contact for rule in self.rules):
            moving_frames = np.array([frame.get_value() for frame in twists], dtype=np.int64)
            lost = ~np.isin(self._frames, moving_frames)
            measured = measured._replace(unpredicted=lost)
        self._decide(now, unreliable, measured, farthest, stops)
        return computed

    def with_zones(self, query: QueryObject) -> QueryObject:
        """Return a query object of the bodies and zones that rules are about, posed as this one.

        It is this one where no rule is about a zone. Otherwise it holds until the next call.
        """
        if not self._zones or not self._monitor.watched.needed_zones.any():
            return query
        if self._with_zones is None:
            self._with_zones, self._narrowed = query.with_proximity(self._zones), None
        else:
            self._with_zones.pose_as(query)
        return self._with_zones

    def unseen(self, query: QueryObject, sights: Sequence[MapSights]) -> str:
        """Return which bodies no sensor of the maps of a rule can see, in words."""
        watched = self._monitor.watched
        unseen = unseen_of_groups(watched, self.unseen_bodies(query, sights))
        if not unseen:
            return ''
        rows = np.flatnonzero(np.logical_or.reduce(list(unseen.values()))).tolist()
        names = [self._pairs.geometries.names[row].full_name for row in rows]
        groups = watched.groups.tolist()
        rules = [r.name for r, group in zip(self.rules, groups, strict=True) if group in unseen]
        return (
            f'no sensor sees {some_of(names)}: beyond obstacle_reach of all those that proximity '
            f'rules {some_of(rules)} are about, or beyond obstacle_box; what is near is not seen, '
            'and these rules are entered'
        )

    def unseen_bodies(self, query: QueryObject, sights: Sequence[MapSights]) -> UnseenBodies:
        """Return which bodies the sensors of each map can see, by the rows of ``pairs``."""
        if self._balls is None:
            maps = [its_map for its_map, _ in sights]
            self._balls = Balls.around(query.inspector(), self._pairs, self._frames, maps)
        return unseen_bodies(query, self._balls, sights, self._pairs)

    def wait(self, now: float, unreliable: Blind, stops: Mapping[str, Stop] | None = None) -> None:
        """Decide [s] where nothing moved since, and only time went on."""
        self._decide(now, unreliable, None, stops=stops)

    def _decide(
        self,
        now: float,
        unreliable: Blind,
        measured: Measured | None,
        farthest: float = math.inf,
        stops: Mapping[str, Stop] | None = None,
    ) -> None:
        count = len(self._monitor.watched.ids)
        flags = zip(self._flags_of_blind, unreliable, strict=True)
        poses = Poses(*(each.of(frames, self._hanging, count) for each, frames in flags))
        changes = self._monitor.changes_of_state
        events = self._monitor.decide(now, poses, measured, farthest, stops)
        self._happened += events
        self.revision += len(events) + self._monitor.changes_of_state - changes

    @property
    def pairs(self) -> ScenePairs:
        """The geometries and pairs that rules are about."""
        return self._pairs

    @property
    def watched(self) -> WatchedPairs:
        """The pairs that the rules watch, another object where these change."""
        return self._monitor.watched

    @property
    def stops(self) -> Mapping[str, Stop]:
        """The last answers for stoppable rules, by their names."""
        return self._monitor.stops

    def sets_of(self, rule: ProximityRule) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Return the geometries (n,), by the values of their ids, in the sets of a rule.

        Both are empty where a name stands for nothing. The rule need not be one of the scene's.
        """
        if rule in self.rules:
            return self._monitor.watched.sets_of(self.rules.index(rule))
        sets = self._pairs.geometries.sets_of(rule, may_lack=False)
        ids = np.array(self._pairs.ids, dtype=np.int64)
        return ids[sets.in_a], ids[sets.in_b]

    def frames_with_geometries(self) -> Mapping[int, NDArray[np.int64]]:
        """Return by frame the geometries on it, and on what hangs on it, by values of ids."""
        if self._carried is None:
            ids = np.array(self._pairs.ids, dtype=np.int64)
            self._carried = {frame: ids[rows] for frame, rows in self._hanging.items()}
        return self._carried

    def take_events(self) -> list[Event]:
        """Return the events since the last call."""
        events, self._happened = self._happened, []
        return events

    def states(self) -> list[RuleState]:
        """Return the state of each rule."""
        return self._monitor.states()

    def table(self) -> RuleStates:
        """Return the states of all rules in arrays, to be read before anything else happens."""
        return self._monitor.table()

    def measure_again(self) -> None:
        """Discard earlier distances: bodies moved, or were not measured for a while."""
        self._monitor.is_measured = False

    def change_accuracy(self) -> None:
        """Set the level at which distances are measured for rules alone."""
        self._narrowed = self._with_zones = None
        self.measure_again()

    def troubles(self, *, watches_motion: bool) -> list[str]:
        """Return which rules can never be entered, or not for all that they say, in words."""
        states = self.states()
        troubles = [state.trouble for state in states if state.trouble]
        troubles += [
            f'proximity rule {state.rule.name!r} goes on without {some_of(state.lacking)}: '
            'of what it names, this stands for no geometry any more'
            for state in states
            if state.lacking
        ]
        lost = [state.rule.name for state in states if state.unpredicted]
        if lost:
            troubles.append(
                'nobody knows how all bodies move whose times to contact count for proximity '
                f'rules {some_of(lost)}: until that is known they are entered by distance alone, '
                'and not left; poses need stamps, or twists'
            )
        troubles += [
            f'proximity rule {name!r} proves no stop: {stop.trouble}'
            for name, stop in self.stops.items()
            if stop.trouble
        ]
        need_twists = [rule.name for rule in self.rules if rule.min_time_to_contact]
        if need_twists and not watches_motion:
            troubles.append(
                'min_time_to_contact does not count, for nobody watches how bodies move: '
                f'proximity rules {some_of(need_twists)}; set the parameter closing_speeds'
            )
        return troubles

    def finer_than(self, limits: Mapping[GeometryId, float], rule: str = '') -> list[str]:
        """Return in words which rules, or whether this one, are finer than maps can resolve.

        ``limits`` [m] are by map.
        """
        ids, needed = self._monitor.watched.ids, self._monitor.watched.needed
        rows = {row: limits[g] for g in limits for row in np.flatnonzero(ids == g.get_value())}
        finer: dict[float, list[str]] = {}
        is_about_zones = self._monitor.watched.is_about_zones
        for number, each in enumerate(self.rules):
            if is_about_zones(number):  # what is near the robot may be far inside a zone
                continue
            limit = max((rows[row] for row in rows if needed(number)[row]), default=0.0)
            if each.enter < limit and rule in ('', each.name):
                finer.setdefault(limit, []).append(each.name)
        return [
            f'proximity rules {some_of(names)} are entered by less than the {limit:g} m that '
            'sensed maps can tell (the larger of obstacle_padding and the edge of a cell): nearer '
            'things are in no map, and count by cells beside bodies, early; '
            f'enter must be at least {limit:g}'
            for limit, names in finer.items()
        ]

    def in_words(self) -> str:
        """Return how many rules there are, and which are entered."""
        states = self.states()
        entered = [
            f'{s.rule.name} ({s.why.name.lower()}'
            f'{", to be acknowledged" if s.awaits_acknowledgement else ""})'
            for s in states
            if s.why is not None
        ]
        return f'{len(states)}, entered: {some_of(entered) or "none"}' if states else 'none'

    def speed_scale(self) -> float | None:
        """Return the speed scale, 0 to 1; None: no rule sets one."""
        return self._monitor.speed_scale()

    def scale_about(self, robot: str) -> ScaleOfRobot:
        """Return how fast a robot may go, by a name or pattern, and why not faster."""
        return self._monitor.scale_about(robot)

    def _narrow(self, query: QueryObject) -> QueryObject:
        """Return the query object of the pairs of rules, made anew after changes."""
        if self._narrowed is None:
            self._narrowed = narrowed_to(query, self._monitor.watched, self._zones)
        return self._narrowed

    def _fastest(self, inspector: SceneGraphInspector, twists: Twists | None) -> float:
        """Return a bound [m/s] of how fast any two geometries close.

        No point of a body is faster than its frame's origin and the turn about it.
        """
        if not twists or not any(rule.min_time_to_contact for rule in self.rules):
            return 0.0
        if self._extents is None:
            world = inspector.world_frame_id().get_value()
            ids = self._pairs.ids[self._frames != world].tolist()
            self._extents = extents(inspector, list(map(GeometryId, ids)))
        speeds = []
        for frame, extent in self._extents.items():
            if frame in twists:
                turn, straight = np.linalg.norm(twists[frame].reshape(2, 3), axis=1)
                speeds.append(float(straight + (turn * extent if turn else 0.0)))
        return sum(sorted(speeds)[-2:])
