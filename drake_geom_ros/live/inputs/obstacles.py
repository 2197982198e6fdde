"""Input of sensed maps into the scene: clouds, scans, depth images, OctoMaps and grids.

A message is taken whole or refused whole, and then the map of before stays, and grows old. One
that says that nothing is there, as a scan by rays without an echo, makes a map without cells. One
that only shows nothing is refused: a covered lens sees no more than an empty room.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Sequence
from dataclasses import replace
from types import SimpleNamespace
from typing import NamedTuple

import numpy as np

from drake_geom_ros.common.geometry_names import matches
from drake_geom_ros.geometry import ArgumentError, FrameId, GeometryId, QueryObject
from drake_geom_ros.live.conversions.fields import stamp_after
from drake_geom_ros.live.conversions.message_types import (
    GridMessage,
    HeaderMessage,
    OctomapMessage,
)
from drake_geom_ros.live.conversions.occupancy_grid import cells_from_grid, extruded
from drake_geom_ros.live.conversions.octomap import cells_from_octomap, refuse_too_many_nodes
from drake_geom_ros.live.inputs.map_feeds import MapFeeds, Shown
from drake_geom_ros.live.inputs.obstacle_records import (
    Found,
    Held,
    MapCounts,
    ObstacleSettings,
    Place,
    Turn,
)
from drake_geom_ros.live.scene.changes.map_update import Sighting, has_many, shape_of, showing
from drake_geom_ros.live.scene.feeds import Feed
from drake_geom_ros.live.scene.held_scene import HeldScene
from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.live.scene.map_placing import stand
from drake_geom_ros.live.scene.moments import (
    PATIENCE,
    Hanging,
    Model,
    Moment,
    lasting_moment,
    moment_of,
)
from drake_geom_ros.live.scene.out_of_sight import Sight
from drake_geom_ros.live.scene.seen_shells import NO_SHELL, SeenShell
from drake_geom_ros.live.scene.self_filter import KnownBodies, bodies_of
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.proximity_rules import geometry_names
from drake_geom_ros.scene_files import FREE, ObstacleSource
from drake_geom_ros.sensed_maps.cells import Cells

Paddings = tuple[tuple[str, float], ...]


class _Begun(NamedTuple):
    """A message that is being taken, and may be refused yet."""

    moment: Moment
    start: float  # [s] when its taking began
    generation: int  # of the map, then
    feed: Feed


class _OfMap(NamedTuple):
    """The cells of a message that is a map, and the box in the world that it shows."""

    cells: Cells  # in a frame M
    X_WM: RigidTransform
    low: Floats  # (3,) [m]
    high: Floats


class ObstacleInput:
    """Keeps one map in the scene, made from the messages of a topic."""

    def __init__(
        self,
        source: ObstacleSource,
        live: LiveScene,
        settings: Callable[[], ObstacleSettings],
        hanging: Hanging,
        changed: Callable[[], None],
    ) -> None:
        """Take ``settings()`` of the source; ``hanging`` finds a sensor's frame.

        ``changed()`` is called when the scene has a map.
        """
        self.source, self.name = source, source.name
        self.counts = MapCounts()
        self._live = live
        self._settings = settings
        self._hanging = hanging
        self._changed = changed
        self._known = KnownBodies()
        self._known_of: tuple[Model, str, Paddings] | None = None
        self._unmatched: list[str] = []  # patterns of paddings that fit no body
        self._generation = 0  # how often it was cleared
        self._is_removed = False
        self._begun: _Begun | None = None
        self._feeds = MapFeeds(live.clocks)
        self._held: dict[Feed, Held] = {}  # by sensor

    def miss(self, messages: int) -> None:
        """Count messages that were lost, or replaced by newer ones."""
        with self._live.reading():
            self.counts = replace(self.counts, missed=self.counts.missed + messages)

    def forget(self) -> None:
        """Discard earlier messages and the one being processed; the scene is held."""
        self._generation += 1
        self._feeds, self._held = MapFeeds(self._live.clocks), {}
        self.counts = MapCounts()

    def remove(self) -> None:
        """Refuse all messages from now on; the scene is held."""
        self.forget()
        self._is_removed = True

    def troubles(self) -> list[str]:
        """Return which sensors feed the map, where several do, and which paddings fit no body."""
        troubles = [
            f'a padding of the obstacle source {self.name!r} is for {pattern!r}, and no body on '
            'which points are left out is called so: see obstacle_self_filter'
            for pattern in self._unmatched
        ]
        ages = list(self._feeds.ages())
        if len(ages) < 2:
            return troubles
        each = '; '.join(f'{feed.in_words()}: {age:.3g} s old' for feed, age in ages)
        return [
            *troubles,
            f'{len(ages)} sensors feed {self.source.topic}: {each}. The map shows what all of '
            'them see, and is as old as the oldest: give each a topic and a source of its own '
            '(obstacle_sources); clear_obstacles forgets one that is gone',
        ]

    def begin(
        self,
        header: HeaderMessage,
        waited: float = 0.0,
        bodies_number: int = 0,
        publisher: str = '',
        duration: float = 0.0,
        patience: float = PATIENCE,
    ) -> Place:
        """Return where the frame of a header was, of a message that came ``waited`` [s] ago.

        Bodies of the number ``bodies_number`` are not sent again. With a ``duration`` [s] the
        place has the turn of the frame meanwhile. ``finish`` puts the cells of its points into the
        scene. Raises RuntimeError to refuse it, UnknownYetError where it may be taken after
        ``patience`` [s].
        """
        self._refuse_if_removed()
        header = self.framed(header)
        start, self._begun = time.perf_counter(), None
        generation, settings = self._generation, self._settings()
        which = settings.self_filter

        def frames_of_bodies(query: QueryObject, model: Model) -> Collection[FrameId]:
            key = model, which, settings.paddings
            if self._known_of != key:  # each body anew took half of the time
                bodies = self._bodies(query, which)
                self._known.know(query, bodies, self._paddings_of(query, bodies))
                self._known_of = key
            return self._known.frames

        moment = moment_of(self._live, header, waited, self._hanging, frames_of_bodies, patience)
        feed = Feed(header.frame_id, publisher)
        in_sensor = None
        if self.source.sensor:
            moment, in_sensor = self._from_sensor(moment, header, waited, patience)
        self._begun = _Begun(moment, start, generation, feed)
        R_WF = np.array(moment.X_WF.rotation().matrix())
        p_WF = np.array(moment.X_WF.translation())
        there, since = self._known.then(moment.query, bodies_number), moment.since
        when = since.held, since.epoch, generation
        turn = self._turn(moment, header, waited, duration, patience) if duration else None
        held = self._held.get(feed)
        return Place(R_WF, p_WF, *when, there, settings, held, feed, turn, in_sensor)

    def _from_sensor(
        self, moment: Moment, header: HeaderMessage, waited: float, patience: float
    ) -> tuple[Moment, tuple[Floats, Floats]]:
        """Return a moment for the frame S of the source's sensor, and R_SF, p_SF [m]."""
        of_sensor = SimpleNamespace(stamp=header.stamp, frame_id=self.source.sensor)
        X_WS = moment_of(self._live, of_sensor, waited, self._hanging, _no_bodies, patience).X_WF
        X_SF = X_WS.inverse() @ moment.X_WF
        R_SF, p_SF = np.array(X_SF.rotation().matrix()), np.array(X_SF.translation())
        return moment._replace(X_WF=X_WS), (R_SF, p_SF)

    def framed(self, header: HeaderMessage) -> HeaderMessage:
        """Return a header with the frame that the source says, if it does."""
        if not self.source.frame:
            return header
        return SimpleNamespace(stamp=header.stamp, frame_id=self.source.frame)

    def _refuse_if_removed(self) -> None:
        if self._is_removed:
            raise ArgumentError(f'the obstacle source {self.name!r} was removed')

    def _turn(
        self,
        moment: Moment,
        header: HeaderMessage,
        waited: float,
        duration: float,
        patience: float,
    ) -> Turn | None:
        """Return how the frame of a header moved in the time [s] after its stamp."""
        stamp = stamp_after(header.stamp, duration)
        later = SimpleNamespace(stamp=stamp, frame_id=header.frame_id)
        end = moment_of(self._live, later, waited, self._hanging, _no_bodies, patience)
        X_FE = moment.X_WF.inverse() @ end.X_WF
        if X_FE.IsExactlyIdentity():
            return None
        return Turn(np.array(X_FE.rotation().matrix()), np.array(X_FE.translation()))

    def finish(self, taken: Found) -> None:
        """Put cells in the world into the scene, of the message that was begun last.

        Raises RuntimeError where the map or the scene is another one by now.
        """
        begun, self._begun = self._begun, None
        if begun is None:
            raise ArgumentError('no message was begun of which these cells could be')
        shell, margin = taken.shell, self._settings().margin
        seen = SeenShell(
            shell.cells.centres(), shell.reach + margin, taken.counts.in_shell, taken.nearest
        )
        moment, settings = begun.moment, self._settings()
        reach = min(settings.reach, taken.range)
        sight = Sight(moment.X_WF.translation(), reach, *settings.corners())
        cells, counts = taken.kept.cells, taken.counts
        if settings.extrude is not None:
            cells = cells.extruded(*settings.extrude)
            counts = replace(counts, cells=len(cells))
        hidden = Cells(taken.kept.cells.resolution, taken.shadow).centres()
        shown = Shown(cells, RigidTransform(), seen, moment.since, sight, hidden)
        self._put(begun, shown, counts)
        self._held = {feed: held for feed, held in self._held.items() if self._feeds.since(feed)}
        epoch = begun.moment.since.epoch
        self._held[begun.feed] = Held(taken.kept, epoch, begun.generation, shell)

    def take_octomap(
        self,
        octomap: OctomapMessage,
        waited: float = 0.0,
        publisher: str = '',
        patience: float = PATIENCE,
    ) -> None:
        """Take an Octomap in place of the one of before, as it is; raises as ``begin``."""
        refuse_too_many_nodes(octomap)

        def taken(X_WF: RigidTransform, settings: ObstacleSettings) -> _OfMap:
            return _OfMap(cells_from_octomap(octomap), X_WF, *settings.corners())

        self._take_map(octomap.header, taken, waited, publisher, patience)

    def take_grid(
        self,
        grid: GridMessage,
        waited: float = 0.0,
        publisher: str = '',
        patience: float = PATIENCE,
    ) -> None:
        """Take an OccupancyGrid in place of the one of before; raises as ``begin``."""

        def taken(X_WF: RigidTransform, settings: ObstacleSettings) -> _OfMap:
            unknown_is_free = settings.unknown == FREE
            from_grid = cells_from_grid(grid, settings.threshold, unknown_is_free=unknown_is_free)
            X_WM, cells = X_WF @ from_grid.X_FM, from_grid.cells
            if settings.extrude is not None:
                cells = extruded(cells, X_WM, *settings.extrude)
            # The grid shows what is above and below it, too, as far as columns reach.
            p_WCs = X_WM.multiply(np.array([(*c, 0.0) for c in from_grid.corners]).T).T
            low, high = settings.corners()
            low[:2] = np.maximum(low[:2], p_WCs[:, :2].min(axis=0))
            high[:2] = np.minimum(high[:2], p_WCs[:, :2].max(axis=0))
            return _OfMap(cells, X_WM, low, high)

        self._take_map(grid.header, taken, waited, publisher, patience)

    def _take_map(
        self,
        header: HeaderMessage,
        taken: Callable[[RigidTransform, ObstacleSettings], _OfMap],
        waited: float,
        publisher: str,
        patience: float,
    ) -> None:
        """Take a message that is a map, ``taken`` where its frame was."""
        self._refuse_if_removed()
        start, generation, header = time.perf_counter(), self._generation, self.framed(header)
        # Before the map is read, which may take seconds: its stamp is that much older then.
        if self.source.static:
            moment = lasting_moment(self._live, header, self._hanging)
        else:
            moment = moment_of(self._live, header, waited, self._hanging, _no_bodies, patience)
        settings = self._settings()
        cells, X_WM, low, high = taken(moment.X_WF, settings)
        in_box = _cells_in_box(cells, X_WM, settings)
        beyond = len(cells) - len(in_box)
        counts = MapCounts(points=len(cells), out_of_box=beyond, cells=len(in_box))
        feed = Feed(header.frame_id, publisher)
        sight = Sight(np.zeros(3), np.inf, low, high)
        shown = Shown(in_box, X_WM, NO_SHELL, moment.since, sight)
        self._put(_Begun(moment, start, generation, feed), shown, counts)

    def _bodies(self, query: QueryObject, which: str) -> list[GeometryId]:
        """Return the geometries on which points are left out."""
        if which == 'none':
            return []
        with self._live.reading() as scene:
            sources = scene.model.robot_names() if which == 'robots' else None
            return bodies_of(query, sources, scene.model.maps_source)

    def _paddings_of(self, query: QueryObject, bodies: Sequence[GeometryId]) -> list[float | None]:
        """Return the padding [m] of each body that has one of its own."""
        paddings: list[float | None] = [None] * len(bodies)
        patterns, matched = self._settings().paddings, set[str]()
        if patterns:
            for k, body in enumerate(bodies):
                names = geometry_names(query.inspector(), body)
                for pattern, padding in patterns:
                    if matches(names.found_by, pattern):
                        paddings[k] = padding
                        matched.add(pattern)
        self._unmatched = [pattern for pattern, _ in patterns if pattern not in matched]
        return paddings

    def _put(self, begun: _Begun, shown: Shown, counts: MapCounts) -> None:
        """Put a sighting into the scene and update the counters."""
        margin, moment, feed = self._settings().margin, begun.moment, begun.feed
        feeds = self._feeds.with_one(feed, shown)
        all_shown = feeds.union()
        cells = all_shown.cells
        sighting = Sighting(
            cells,
            shape_of(cells, margin),
            all_shown.X_WM,
            all_shown.since,
            moment.stamp,
            all_shown.shell,
            tuple((each.in_words(), since) for each, since in feeds.sinces()),
            feeds.sights(),
            all_shown.hidden,
        )

        def first(scene: HeldScene) -> None:
            self._refuse_late(scene, begun)

        def done() -> None:
            self._feeds = feeds
            taken, seconds = self.counts.taken + 1, time.perf_counter() - begun.start
            missed = self.counts.missed
            self.counts = replace(counts, taken=taken, missed=missed, seconds=seconds)

        with self._live.editing() as scene:
            first(scene)
            stand(scene, self.name, margin)
            change = showing(scene, self.name, sighting, first, done)
        self._live.change(change, calls_for_more=has_many(cells))
        self._changed()

    def _refuse_late(self, scene: HeldScene, begun: _Begun) -> None:
        """Raise ArgumentError for a message that something has overtaken."""
        self._refuse_if_removed()
        moment = begun.moment
        if begun.generation != self._generation:
            raise ArgumentError('the map was cleared while the message was taken')
        if moment.replaced != scene.replaced:
            raise ArgumentError('the scene was replaced while the message was taken')
        since = self._feeds.since(begun.feed)
        if since is not None and since.epoch == moment.since.epoch:
            behind = since.held - moment.since.held
            if behind > 0.0:
                raise ArgumentError(
                    f'its stamp is {behind:.3f} s before that of the map that is there'
                )


def _no_bodies(query: QueryObject, model: Model) -> Collection[FrameId]:
    """Return no bodies: none of them matters."""
    return ()


def _cells_in_box(cells: Cells, X_WM: RigidTransform, settings: ObstacleSettings) -> Cells:
    """Return the cells that reach into the box of settings, or the nearest to it."""
    if not settings.box or not len(cells):
        return cells  # millions of cells take long to look at
    low, high = settings.corners()
    p_WCs = X_WM.multiply(cells.centres().T).T
    reach = 0.5 * cells.resolution * np.abs(X_WM.rotation().matrix()).sum(axis=1)
    beyond = np.maximum(low - reach - p_WCs, p_WCs - reach - high).max(axis=1)
    return Cells(cells.resolution, cells.packed[beyond <= max(0.0, float(beyond.min()))])
