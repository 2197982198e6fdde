"""State of a context: a posed scene, an engine, and caches of what queries derive from them."""

from __future__ import annotations

import threading
from collections.abc import Hashable, Mapping
from copy import copy
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.engine.engine import Engine
from drake_geom_ros.geometry._proximity.engine.prepared import Prepared
from drake_geom_ros.geometry._proximity.engine.waiting import count_waiting_pairs
from drake_geom_ros.geometry._proximity.filters.state import FilterState
from drake_geom_ros.geometry._proximity.runtime.handles import Handle
from drake_geom_ros.geometry._proximity.world.row_change import RowChange
from drake_geom_ros.geometry._proximity.world.world import World
from drake_geom_ros.geometry.errors import GeometryError
from drake_geom_ros.geometry.ids import GeometryId
from drake_geom_ros.geometry.model._model import Model
from drake_geom_ros.geometry.model.properties import ProximityProperties
from drake_geom_ros.geometry.model.scene_content import add_to_filters
from drake_geom_ros.geometry.queries.accuracy import Accuracy, AccuracyLike, accuracy_of
from drake_geom_ros.geometry.queries.contact_bodies import ContactBodies, contact_bodies
from drake_geom_ros.geometry.queries.half_space_pairs import (
    NO_GAPS,
    NO_PAIRS,
    NONE_ENDLESS,
    EndlessOverlaps,
    HalfSpaceGaps,
    endless_overlaps,
    gaps_of,
    pairs_of_half_spaces,
)
from drake_geom_ros.geometry.queries.padding import Paddings, changed_paddings, paddings_of
from drake_geom_ros.geometry.queries.posed_scene import PosedScene
from drake_geom_ros.geometry.queries.world_tables import know_point_shapes
from drake_geom_ros.math.array_types import Indices

if TYPE_CHECKING:
    from drake_geom_ros.geometry._contact_surfaces.asking import Posed


_State = TypeVar('_State', bound='ContextState')
_MAX_PREPARED = 16  # a limit, since callers may vary the distance without end
_MAX_KINDS = 8  # a limit, since callers may move different frames each time


class _WaitingPairs(NamedTuple):
    """Number of pairs that wait for a pose, and the versions it was counted at."""

    moment: object
    pairs: int


class _VersionedPaddings(NamedTuple):
    """Paddings, and the version of the proximity geometry that they belong to."""

    version: int | None
    paddings: Paddings | None


class _GeometryIds(NamedTuple):
    """Ids of geometries as objects, and the array of the values that they were made of."""

    values: Indices | None
    ids: NDArray[np.object_]


class _HalfSpaces(NamedTuple):
    """The unfiltered pairs of half spaces (k, 2) by places, and the versions they belong to."""

    moment: object
    pairs: NDArray[np.int64]


class _PosedBodies(NamedTuple):
    """Bodies of contact surfaces posed in a world, and the handle of that world."""

    bodies: ContactBodies | None
    world: Handle
    posed: Any


_NO_POSED_BODIES = _PosedBodies(None, None, None)


class ContextState(PosedScene):
    """State of a context, which its query objects, images and states share; see ``state_of``.

    ``accuracy`` is the default accuracy of queries. ``is_snapshot``: it is for queries only.
    """

    is_snapshot = False

    def __init__(
        self, model: Model, filters: FilterState, accuracy: AccuracyLike, partial: bool = False
    ) -> None:
        self.accuracy = accuracy_of(accuracy)
        self.engine = Engine()
        # By renderer: the packed scene and its version; see RenderEngineExact.
        self.packed_scenes: dict[str, Any] = {}
        self._prepared: dict[Hashable, Prepared] = {}  # by key, at the default accuracy
        # Shared with snapshots; see ``prepared_motions``.
        self.prepared_motions = PreparedMotions()
        self._snapshot: Model | None = None
        self._padded = _VersionedPaddings(None, None)
        self._ids = _GeometryIds(None, np.empty(0, dtype=np.object_))
        self._waiting_pairs = _WaitingPairs(None, 0)
        self._half_spaces = _HalfSpaces(None, NO_PAIRS)
        self._contact_bodies: ContactBodies | None = None
        self._posed_bodies = _NO_POSED_BODIES
        super().__init__(model, filters, partial)

    def copy(self: _State) -> _State:
        """Return an independent copy."""
        other = self._about(self.model.copy())
        other.copied_from = self.copied_from if self.is_snapshot else self.mark()
        other.is_snapshot = False
        other._snapshot, other.packed_scenes = None, dict(self.packed_scenes)
        other.prepared_motions = PreparedMotions()
        return other

    def go_on_as(self, copy: ContextState) -> None:
        """Answer, at the poses of now, with what queries of a copy have prepared.

        The content of the copy was taken over, and nobody uses it from now on.
        """
        copy.world.pose_as(self.world)
        copy.engine.detailed = self.engine.detailed
        former = {**self.__dict__}
        own = self.model, self.filters, self.accuracy, self.partial
        self.__dict__.update(copy.__dict__)
        self.model, self.filters, self.accuracy, self.partial = own
        self.copied_from = self.former = None
        copy.former = copy.former, former

    def snapshot(self: _State) -> _State:
        """Return a copy for queries and poses only.

        Snapshots of one version of the model share a copy of it, and the packed scenes of
        renderers, which are never changed. A copy of a snapshot is one of this state.
        """
        if self._snapshot is None or self._snapshot.versions != self.model.versions:
            self._snapshot = self.model.copy()
        other = self._about(self._snapshot)
        other.copied_from = self.copied_from if self.is_snapshot else self.mark()
        other.is_snapshot = True
        return other

    def narrowed(self: _State, considered: NDArray[np.bool_], kinds: Indices) -> _State:
        """Return a state of the same model and poses, for pairs of some kinds (k, k) only.

        ``kinds`` (n,) are those of the geometries.
        """
        other = copy(self)
        other.filters = self.filters.narrowed(kinds, considered)
        other.engine, other._prepared = Engine(), {}
        other.prepared_motions = PreparedMotions()
        return other

    def with_proximity(
        self: _State, properties: Mapping[GeometryId, ProximityProperties]
    ) -> _State:
        """Return a copy in which more geometries have the proximity role."""
        other = self.copy()
        for id, each in properties.items():
            add_to_filters(other, other.model.give_proximity(id, each))
        return other

    def _about(self: _State, model: Model) -> _State:
        """Return this state with a copy of the model, and an engine of its own."""
        other = super()._about(model)
        other.engine, other._prepared = Engine(), {}
        return other

    def __getstate__(self) -> dict[str, object]:
        return {
            **self.__dict__,
            '_prepared': {},
            '_posed_bodies': _NO_POSED_BODIES,
        }  # they refer to arrays by address, and a copy has others

    def set_accuracy(self, accuracy: AccuracyLike) -> None:
        """Set the default accuracy; raises ArgumentError for one that is none."""
        self.accuracy = accuracy_of(accuracy)
        self._prepared.clear()

    def accuracy_for(self, accuracy: AccuracyLike | None) -> Accuracy:
        """Return the accuracy to use; raises ArgumentError for one that is none."""
        return self.accuracy if accuracy is None else accuracy_of(accuracy)

    def query(
        self,
        key: Hashable,
        accuracy: AccuracyLike | None,
        cutoff: float,
        penetrating: bool,
        mode: int,
    ) -> Prepared:
        """Return a prepared query for the engine: see ``Engine.prepared``.

        Queries at the default accuracy are cached by ``key``. Raises PoseError if a pose that the
        query needs is missing.
        """
        if accuracy is None:
            cached = self._prepared.get(key)
            # The sum identifies a state, since either number only grows.
            scene = self.model.versions.any + self.filters.version
            if (
                cached is not None
                and cached.scene == scene
                and cached.handles is cached.near.handles
            ):
                return cached
        level_gap, world = self.accuracy_for(accuracy).length, self.posed_world()
        query = self.engine.prepared(world, self.filters, level_gap, cutoff, penetrating, mode)
        if accuracy is None:
            if len(self._prepared) == _MAX_PREPARED:
                self._prepared.clear()
            self._prepared[key] = query
            query.scene = self.model.versions.any + self.filters.version
        return query

    def pointed_world(self) -> World:
        """Return the world for a query about points, with the shapes that points measure to."""
        world = self.posed_world()
        know_point_shapes(world, self.model)
        return world

    def geometry_ids(self) -> NDArray[np.object_]:
        """Return the ids (n,) of the geometries of the world, which are never changed."""
        values = self.up_to_date_world().geometries.ids
        if self._ids.values is not values:
            ids = np.empty(len(values), dtype=np.object_)
            ids[:] = [GeometryId(value) for value in values.tolist()]
            self._ids = _GeometryIds(values, ids)
        return self._ids.ids

    def paddings(self) -> Paddings | None:
        """Return the cached paddings of the geometries, None if there are none."""
        version = self.model.versions.proximity
        if self._padded.version != version:
            ids = self.up_to_date_world().geometries.ids  # follows most changes
            if self._padded.version != version:
                self._padded = _VersionedPaddings(version, paddings_of(self.model, ids))
        return self._padded.paddings

    def _follow(self, former: World, change: RowChange | None) -> None:
        """Keep the neighbour lists and paddings of the geometries that did not change."""
        if change is None:
            return
        self.engine.follow(former, self.world, change)
        if self._padded.version == self.built.proximity:
            paddings = changed_paddings(
                self._padded.paddings, self.model, self.world.geometries.ids, change
            )
            version = self.model.versions.proximity
            self._padded = _VersionedPaddings(version, paddings)

    def contact_bodies(self) -> ContactBodies:
        """Return the bodies of geometries with hydroelastic properties, up to date."""
        ids = self.up_to_date_world().geometries.ids
        before = self._contact_bodies
        self._contact_bodies = contact_bodies(self.model, ids, self.paddings(), before)
        return self._contact_bodies

    def endless_overlaps(self) -> EndlessOverlaps:
        """Return the unfiltered pairs of half spaces that overlap in the last query's world."""
        pairs = self._pairs_of_half_spaces()
        return endless_overlaps(self.world, pairs, self.paddings()) if len(pairs) else NONE_ENDLESS

    def half_space_gaps(self) -> HalfSpaceGaps:
        """Return the gaps of the unfiltered pairs of half spaces at the current poses."""
        world, pairs = self.posed_world(), self.pairs_of_half_spaces()
        if not len(pairs):
            return NO_GAPS
        world.update()
        return gaps_of(world, pairs, self.paddings())

    def pairs_of_half_spaces(self) -> NDArray[np.int64]:
        """Return the unfiltered pairs of half spaces (k, 2), by their places in the world."""
        self.up_to_date_world()
        return self._pairs_of_half_spaces()

    def _pairs_of_half_spaces(self) -> NDArray[np.int64]:
        """Return them for the world of the last query, from a cache."""
        if not self.world.has_plane_pairs:
            return NO_PAIRS
        moment = self.built, self.filters.version
        if self._half_spaces.moment != moment:
            pairs = pairs_of_half_spaces(self.world, self.filters)
            self._half_spaces = _HalfSpaces(moment, pairs)
        return self._half_spaces.pairs

    def posed_bodies(self, world: World) -> Posed:
        """Return the contact bodies, posed as the geometries of a world."""
        cached, bodies = self._posed_bodies, self.contact_bodies()
        # Another world, or a copy, has arrays, and a handle, of its own.
        if cached.bodies is not bodies or cached.world is not world.handle:
            posed = bodies.posed(world.R_WGs, world.p_WGs)
            cached = self._posed_bodies = _PosedBodies(bodies, world.handle, posed)
        posed_bodies: Posed = cached.posed
        return posed_bodies

    def count_waiting_pairs(self) -> int:
        """Return the number of unfiltered pairs with a geometry that has no pose."""
        world = self.up_to_date_world()
        moment = self.built, world.placings, self.filters.version
        # Asked each cycle, and 20 ms of work where 1000 bodies wait.
        if self._waiting_pairs.moment != moment:
            self._waiting_pairs = _WaitingPairs(moment, count_waiting_pairs(world, self.filters))
        return self._waiting_pairs.pairs


class PreparedMotions:
    """Thread-safe cache with one entry a kind; a caller owns an entry from ``take`` to ``keep``.

    It holds the entries that were used last.
    """

    def __init__(self) -> None:
        self._entries: dict[Hashable, Any] = {}
        self._lock = threading.Lock()

    def __reduce__(self) -> tuple[type[PreparedMotions], tuple[()]]:
        return PreparedMotions, ()  # a copy begins with nothing

    def take(self, kind: Hashable) -> Any:
        """Remove and return the entry of a kind, None if there is none."""
        with self._lock:
            return self._entries.pop(kind, None)

    def keep(self, kind: Hashable, prepared: Any) -> None:
        """Store an entry, and drop the oldest one beyond the limit."""
        with self._lock:
            self._entries[kind] = prepared
            if len(self._entries) > _MAX_KINDS:
                del self._entries[next(iter(self._entries))]


class _NoScene:
    """State without a scene: every attribute raises GeometryError."""

    def __getattr__(self, name: str) -> Any:
        if name.startswith('__'):
            raise AttributeError(name)
        raise GeometryError(
            'A default QueryObject was asked a query, and it belongs to no scene: take one '
            'from scene_graph.get_query_output_port().Eval(context).'
        )


NO_SCENE = cast(ContextState, _NoScene())
