"""What sensors saw, taken into the scene: clouds, depth images and OctoMaps.

A message is taken whole or refused whole, and then the map of before stays, and grows old. One
that shows nothing is refused: a covered lens sees no more than an empty room. No ROS import.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Collection
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from drake_geom_ros.geometry import ArgumentError, FrameId, GeometryId, QueryObject
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.ros.conversions.octomap import cells_from_octomap, refuse_too_many_nodes
from drake_geom_ros.ros.inputs.obstacle_records import (
    Found,
    Held,
    MapCounts,
    ObstacleSettings,
    Place,
)
from drake_geom_ros.ros.scene.live_scene import LiveScene
from drake_geom_ros.ros.scene.moments import Hanging, Model, Moment, moment_of
from drake_geom_ros.ros.scene.seen_maps import Sighting, put, shape_of
from drake_geom_ros.ros.scene.seen_shells import NO_SHELL, SeenShell
from drake_geom_ros.ros.scene.self_filter import KnownBodies, bodies_of
from drake_geom_ros.sensed_maps.cells import Cells

MOST_NODES = 3_000_000  # of a tree in a message: reading it costs a microsecond a node


class _Begun(NamedTuple):
    """A message that is being taken, and may be refused yet."""

    moment: Moment
    start: float  # [s] when its taking began
    generation: int  # of the map, then


class ObstacleInput:
    """Has one map of the messages of a topic in the scene."""

    def __init__(
        self,
        name: str,
        live: LiveScene,
        settings: Callable[[], ObstacleSettings],
        hanging: Hanging,
        changed: Callable[[], None],
    ) -> None:
        """``hanging`` tells where a frame is; ``changed()`` is called when the scene has a map."""
        self.name = name
        self.counts = MapCounts()
        self._live = live
        self._settings = settings
        self._hanging = hanging
        self._changed = changed
        self._known = KnownBodies()
        self._known_of: tuple[Model, str] | None = None
        self._generation = 0  # how often it was cleared
        self._begun: _Begun | None = None
        self._held: Held | None = None

    def forget(self) -> None:
        """Hold nothing of before, nor what is being made; the scene is held."""
        self._generation += 1
        self._held = None
        self.counts = MapCounts()

    def begin(self, header: Any, waited: float = 0.0, known: int = 0) -> Place:
        """Return where the frame of a header was, of a message that came ``waited`` [s] ago.

        Bodies of the number ``known`` are not told again. Cells that are made of its points are
        put by ``finish``. Raises RuntimeError to refuse it.
        """
        start, self._begun = time.perf_counter(), None
        generation, settings = self._generation, self._settings()
        which = settings.self_filter

        def frames_of_bodies(query: QueryObject, model: Model) -> Collection[FrameId]:
            if self._known_of != (model, which):  # each body anew took half of the time
                self._known.know(query, self._bodies(query, which))
                self._known_of = model, which
            return self._known.frames

        moment = moment_of(self._live, header, waited, self._hanging, frames_of_bodies)
        self._begun = _Begun(moment, start, generation)
        R_WF = np.array(moment.X_WF.rotation().matrix())
        p_WF = np.array(moment.X_WF.translation())
        there, since = self._known.then(moment.query, known), moment.since
        return Place(R_WF, p_WF, since.held, since.epoch, generation, there, settings, self._held)

    def finish(self, found: Found) -> None:
        """Put cells in the world into the scene, of the message that was begun last.

        Raises RuntimeError where the map or the scene is another one by now.
        """
        begun, self._begun = self._begun, None
        if begun is None:
            raise ArgumentError('no message was begun of which these cells could be')
        shell, margin = found.shell, self._settings().margin
        seen = SeenShell(
            shell.cells.centres(), shell.reach + margin, found.counts.in_shell, found.nearest
        )
        self._put(begun, found.kept.cells, found.counts, RigidTransform(), seen)
        self._held = Held(found.kept, begun.moment.since.epoch, begun.generation, shell)

    def take_octomap(self, octomap: Any, waited: float = 0.0) -> None:
        """Take an Octomap in place of the map of before, as it is; raises RuntimeError."""
        start = time.perf_counter()
        refuse_too_many_nodes(octomap, MOST_NODES)
        generation, cells = self._generation, cells_from_octomap(octomap)
        if not len(cells):
            raise ArgumentError('the tree has no occupied cell: it shows nothing')
        moment = moment_of(self._live, octomap.header, waited, self._hanging, lambda *_: ())
        taken = _cells_in_box(cells, moment.X_WF, self._settings())
        beyond = len(cells) - len(taken)
        counts = MapCounts(points=len(cells), out_of_box=beyond, cells=len(taken))
        self._put(_Begun(moment, start, generation), taken, counts, moment.X_WF)

    def _bodies(self, query: QueryObject, which: str) -> list[GeometryId]:
        """Return the geometries on which points are left out."""
        if which == 'none':
            return []
        with self._live.reading() as scene:
            sources = scene.robot_names() if which == 'robots' else None
            return bodies_of(query, sources, scene.maps_source)

    def _put(
        self,
        begun: _Begun,
        cells: Cells,
        counts: MapCounts,
        X_WM: RigidTransform,
        beside: SeenShell = NO_SHELL,
    ) -> None:
        """Have the scene hold what was seen; what is counted changes with it."""
        margin, moment = self._settings().margin, begun.moment
        shape = shape_of(cells, margin)
        sighting = Sighting(cells, shape, X_WM, moment.since, moment.stamp, beside)
        with self._live.editing() as scene:
            if begun.generation != self._generation:
                raise ArgumentError('the map was cleared while the message was taken')
            if moment.replaced != scene.replaced:
                raise ArgumentError('the scene was replaced while the message was taken')
            known = scene.maps.get(self.name)
            since = None if known is None else scene.posed_since(known.frame)
            if since is not None and since.epoch == moment.since.epoch:
                behind = since.held - moment.since.held
                if behind > 0.0:
                    raise ArgumentError(
                        f'its stamp is {behind:.3f} s before that of the map that is there'
                    )
            put(scene, self.name, sighting, margin)
            taken, seconds = self.counts.taken + 1, time.perf_counter() - begun.start
            self.counts = replace(counts, taken=taken, seconds=seconds)
        self._changed()


def _cells_in_box(cells: Cells, X_WM: RigidTransform, settings: ObstacleSettings) -> Cells:
    """Return the cells that reach into the box of settings, or the nearest to it."""
    low, high = settings.corners()
    p_WCs = X_WM.multiply(cells.centres().T).T
    reach = 0.5 * cells.resolution * np.abs(X_WM.rotation().matrix()).sum(axis=1)
    beyond = np.maximum(low - reach - p_WCs, p_WCs - reach - high).max(axis=1)
    return Cells(cells.resolution, cells.packed[beyond <= max(0.0, float(beyond.min()))])
