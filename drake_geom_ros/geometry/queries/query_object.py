"""``QueryObject``: queries for penetration, signed distance and collision candidates."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from drake_geom_ros.geometry._proximity.effects import Effects
from drake_geom_ros.geometry._proximity.engine.pair_query import ANSWERS, CANDIDATES, CONTACT
from drake_geom_ros.geometry._proximity.kernels.pair_table import unsupported
from drake_geom_ros.geometry._proximity.pairs.answer_rows import batch_of
from drake_geom_ros.geometry._proximity.pairs.level_costs import seconds_a_pair
from drake_geom_ros.geometry._proximity.points.point_query import are_allowed
from drake_geom_ros.geometry._proximity.world.world import World
from drake_geom_ros.geometry.checks import checked_budget
from drake_geom_ros.geometry.errors import ArgumentError, FilterError, GeometryError, RoleError
from drake_geom_ros.geometry.ids import FrameId, GeometryId, only_id
from drake_geom_ros.geometry.model.collision_filter_manager import how_to_allow
from drake_geom_ros.geometry.model.properties import ProximityProperties
from drake_geom_ros.geometry.model.scene_graph_inspector import SceneGraphInspector
from drake_geom_ros.geometry.queries.accuracy import AccuracyLike
from drake_geom_ros.geometry.queries.contact_queries import ContactQueries
from drake_geom_ros.geometry.queries.context import SceneGraphContext, state_of
from drake_geom_ros.geometry.queries.context_state import NO_SCENE
from drake_geom_ros.geometry.queries.half_space_pairs import HalfSpaceGaps
from drake_geom_ros.geometry.queries.image_queries import ImageQueries
from drake_geom_ros.geometry.queries.motion_checks import MotionChecks
from drake_geom_ros.geometry.queries.padding import Paddings, padded_pairs, padded_points
from drake_geom_ros.geometry.queries.prepared_query import PreparedQuery
from drake_geom_ros.geometry.queries.query_records import SignedDistancePair
from drake_geom_ros.geometry.queries.query_results import (
    PenetrationResults,
    PointDistanceResults,
    SignedDistanceResults,
)
from drake_geom_ros.geometry.shapes.bounding_boxes import Obb
from drake_geom_ros.geometry.shapes.sensed import SensedMap
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.math.array_types import Indices
from drake_geom_ros.math.missing import refuse_missing_member
from drake_geom_ros.math.tolerances import FARTHEST

_Results = TypeVar('_Results', PenetrationResults, SignedDistanceResults, PointDistanceResults)


class QueryObject(ImageQueries, MotionChecks, ContactQueries):
    """Geometry queries on a context.

    The query object of a SceneGraph's query port is live: it sees later poses and changes of its
    context. A copy of it (``copy.copy``) is baked: it keeps the poses and the model of the moment
    of the copy. Queries raise PoseError, with the names of frames that have never received a pose.

    Each query takes ``accuracy``: ``bound``, ``fast``, ``balanced``, ``exact``, or a length [m].
    The SceneGraph's default applies without it.
    """

    def __init__(self, context: SceneGraphContext | None = None) -> None:
        self._context = context
        self._state = NO_SCENE if context is None else state_of(context)

    def __copy__(self) -> QueryObject:
        return QueryObject(self._context and self._context.copy())

    def __deepcopy__(self, memo: dict[int, object]) -> QueryObject:
        return self.__copy__()

    if not TYPE_CHECKING:  # mypy would take any method for one that is there
        __getattr__ = refuse_missing_member

    def effects(self) -> Effects:
        """Return the steps that the last query ran and skipped, with counts and seconds."""
        return self._state.engine.effects

    def cost_of_levels(
        self, max_distance: float = math.inf, *, samples: int = 64, seed: int = 0
    ) -> tuple[dict[str, float], int]:
        """Return the time [s] per pair by accuracy, and the number of sampled pairs.

        Accuracies are the levels, and 0.01 m, by the name ``0.01``; ``fast`` is 0.001 m.

        Measured on at most ``samples`` of the pairs for which a signed distance within
        ``max_distance`` [m] would be computed, chosen by ``seed``. Each is computed without a warm
        start, so a cycle is faster. Empty and 0 where no pair is near. Later queries are not
        affected. Raises ArgumentError for a max_distance that is NaN.
        """
        reach = _checked_distance('max_distance', max_distance)
        state = self._state
        world = state.posed_world()
        return seconds_a_pair(world, state.filters, reach, samples, seed)

    def narrowed(self, considered: ArrayLike, kinds: ArrayLike | None = None) -> QueryObject:
        """Return a query object that considers only the pairs of a matrix (n, n).

        Its rows are those of ``inspector().candidate_matrix()``; filters apply, too. With
        ``kinds`` (n,), whole numbers, the matrix (k, k) is that of kinds of geometries, which
        takes little memory in large scenes. The object sees later poses, as this one does. After
        a change of shapes or filters, make another one.
        """
        flags = np.asarray(considered, dtype=np.bool_)
        count = len(self._state.up_to_date_world().geometries.ids)
        kind_of = np.arange(count) if kinds is None else np.asarray(kinds, dtype=np.int64)
        size = count if kinds is None else int(kind_of.max(initial=-1)) + 1
        if flags.shape != (size, size) or kind_of.shape != (count,) or (kind_of < 0).any():
            raise ArgumentError(
                f'narrowed was given a matrix {flags.shape}; it must be {(size, size)}, '
                'as inspector().candidate_matrix() is, or as many rows as there are kinds, and '
                f'kinds {kind_of.shape}, from 0 on, must be {(count,)}.'
            )
        return QueryObject(self._context and self._context.narrowed(flags | flags.T, kind_of))

    def with_proximity(self, properties: Mapping[GeometryId, ProximityProperties]) -> QueryObject:
        """Return a query object of a copy in which these geometries have the proximity role, too.

        For bodies that some queries see and others do not, such as zones. The copy stays at the
        poses of now until ``pose_as``. Raises RuntimeError for an unknown id, and for a shape that
        queries cannot support with these properties.
        """
        return QueryObject(self._context and self._context.with_proximity(properties))

    def pose_as(self, other: QueryObject) -> None:
        """Pose all frames as in another query object of the same scene."""
        self._state.up_to_date_world().pose_as(other._state.up_to_date_world())

    # Poses.

    def inspector(self) -> SceneGraphInspector:
        """Return the inspector of this context's model."""
        return SceneGraphInspector(self._state.model, self._state.filters)

    def GetPoseInWorld(
        self,
        id: FrameId | GeometryId | None = None,
        *,
        frame_id: FrameId | None = None,
        geometry_id: GeometryId | None = None,
    ) -> RigidTransform:
        """Return X_WF of a frame or X_WG of a geometry; raises for an unknown id."""
        only = only_id('GetPoseInWorld', id, frame_id, geometry_id)
        return self.X_WG(only) if isinstance(only, GeometryId) else self.X_WF(only)

    def GetPoseInParent(self, frame_id: FrameId) -> RigidTransform:
        """Return X_PF, the pose of a frame in its parent; raises for an unknown id."""
        return self.X_PF(frame_id)

    def X_WF(self, id: FrameId) -> RigidTransform:
        """Return the pose of a frame in the world; raises for an unknown id."""
        return self._state.X_WF(id)

    def X_WFs(
        self, ids: ArrayLike
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.bool_]]:
        """Return the poses of many frames as arrays, see ``SceneGraphContext.X_WFs``."""
        return self._state.X_WFs(ids)

    def X_PF(self, id: FrameId) -> RigidTransform:
        """Return the pose of a frame in its parent; raises for an unknown id."""
        return self._state.X_PF(id)

    def X_WG(self, id: GeometryId) -> RigidTransform:
        """Return the pose of a geometry in the world; raises for an unknown id."""
        record = self._state.model.geometry(id)
        return self.X_WF(record.frame_id) @ record.X_FG

    def ComputeObbInWorld(self, geometry_id: GeometryId) -> Obb | None:
        """Return the oriented box around a geometry, in World; None for a half space."""
        obb = self.inspector().GetObbInGeometryFrame(geometry_id)
        return obb and Obb(self.X_WG(geometry_id) @ obb.pose(), obb.half_width())

    # Frames without a first pose. As long as there are any, partial contexts leave out the
    # geometry on them, and other contexts refuse all queries.

    def waiting_frames(self) -> list[FrameId]:
        """Return the frames that have never received a pose, parents first."""
        return list(self._state.waiting_frames())

    def is_placed(self, id: FrameId | GeometryId) -> bool:
        """Return whether a frame, or that of a geometry, and all its parents have a pose."""
        model, world = self._state.model, self._state.up_to_date_world()
        frame = model.geometry(id).frame_id if isinstance(id, GeometryId) else model.frame(id).id
        return bool(world.placed[world.frame_rows(np.array([frame.get_value()]))[0]])

    def num_waiting_pairs(self) -> int:
        """Return the number of unfiltered pairs, at any distance, with a geometry not placed."""
        return self._state.count_waiting_pairs()

    def num_waiting_geometries(self) -> int:
        """Return the number of geometries with the proximity role that are not placed."""
        return int(np.count_nonzero(self._state.up_to_date_world().unplaced()))

    def X_WGs(self, ids: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return R_WG (k, 3, 3) and p_WG (k, 3) [m] of geometries by the values (k,) of their ids.

        A call of ``X_WG`` costs a hundred times as much per geometry. Raises RoleError for ids of
        geometries without the proximity role.
        """
        world = self._state.up_to_date_world()
        world.update()
        values, all_ids = np.asarray(ids, dtype=np.int64), world.geometries.ids
        rows = world.geometry_rows(values)
        is_known = rows < len(all_ids)
        is_known[is_known] = all_ids[rows[is_known]] == values[is_known]
        if not is_known.all():
            unknown = sorted(set(values[~is_known].tolist()))[:5]
            raise RoleError(f'these ids belong to no geometry with the proximity role: {unknown}')
        return world.R_WGs[rows], world.p_WGs[rows]

    # Pairs.

    def ComputePointPairPenetration(
        self, *, accuracy: AccuracyLike | None = None, time_budget: float | None = None
    ) -> PenetrationResults:
        """Return the unfiltered pairs that overlap, with depth and witness points.

        Touching is not penetrating: the depth must exceed ``TOUCHING_DEPTH`` times the pair's
        size, see ``_proximity/tolerances.py``. Sorted by (id_A, id_B), and ``id_A < id_B``. Two
        half spaces have no depth and are left out; HasCollisions includes them.

        Pairs answered from bounds alone (method BOUND_ONLY, because of the level or of the
        ``time_budget``) are reported if they may overlap, so no overlap is missing. If they may
        also be apart, the depth is half of the largest possible one, and the interval of the error
        bound contains minus the signed distance.

        ``time_budget`` is that of ComputeSignedDistancePairwiseClosestPoints.
        """
        state = self._state
        if paddings := state.paddings():
            return self._named(self._padded(paddings, 0.0, accuracy, time_budget).penetrations())
        query = state.query('penetrations', accuracy, 0.0, True, ANSWERS)
        budget = checked_budget(time_budget)
        answers = state.engine.answer_of(query, budget)
        # Kernels decide every pair, and to look for undecided ones costs as much as 50 balls.
        if query.is_bound or budget > 0.0:
            batch = batch_of(answers).penetrating()
            return self._named(PenetrationResults(batch, query.world.kept_poses()))
        return self._named(PenetrationResults(answers, query.world.kept_poses()))

    def HasCollisions(self, *, accuracy: AccuracyLike | None = None) -> bool:
        """Return whether any unfiltered pair overlaps; stops at the first.

        Counts the pairs that ComputePointPairPenetration reports, and overlapping half spaces,
        which it does not report: all but opposed ones with a gap above rounding.

        From about 1e11 m on, rounding may hide contacts deeper than a millimetre. There a pair
        counts as colliding if the certified interval of its distance reaches below 0.
        """
        state = self._state
        if paddings := state.paddings():
            overlaps = len(self._padded(paddings, 0.0, accuracy).penetrations()) > 0
        else:
            query = state.query('contact', accuracy, 0.0, True, CONTACT)
            overlaps = state.engine.finds_overlap(query)
        if overlaps or not state.world.has_plane_pairs:
            return overlaps
        return len(state.endless_overlaps().ids) > 0

    def half_space_gaps(self) -> HalfSpaceGaps:
        """Return the gaps of unfiltered pairs of half spaces, which other queries leave out."""
        return self._state.half_space_gaps()

    def ComputeSignedDistancePairwiseClosestPoints(
        self,
        max_distance: float = math.inf,
        *,
        accuracy: AccuracyLike | None = None,
        time_budget: float | None = None,
    ) -> SignedDistanceResults:
        """Return the unfiltered pairs no farther apart than ``max_distance`` [m].

        Overlapping pairs have the negative of the penetration depth as distance. Sorted by
        (id_A, id_B), and ``id_A < id_B``. Two half spaces have no distance and are left out.

        ``time_budget`` [s] limits the narrow phase (None or 0: no limit). Every candidate pair is
        bounded first. Then kernels answer the nearest pairs, by these bounds, while time lasts,
        and at least a few. The others keep their certified bounds, with method BOUND_ONLY and half
        of the interval's width as ``error_bound``; a later query refines them. Pairs answered from
        bounds, because of the budget or the level, are reported if they may be near enough.

        Raises ArgumentError for a max_distance that is NaN and a time_budget that is negative or
        NaN.
        """
        reach = _checked_distance('max_distance', max_distance)
        state = self._state
        if paddings := state.paddings():
            return self._named(self._padded(paddings, reach, accuracy, time_budget))
        query = state.query(reach, accuracy, reach, False, ANSWERS)
        answers = state.engine.answer_of(query, checked_budget(time_budget))
        return self._named(SignedDistanceResults(answers, query.world.kept_poses()))

    def _named(self, results: _Results) -> _Results:
        """Return results that know the scene to look up names in."""
        results.know_names(self._names_of_ids)
        return results

    def _names_of_ids(self, ids: Indices) -> list[str]:
        return self.inspector().full_names(ids)

    def _padded(
        self,
        paddings: Paddings,
        reach: float,
        accuracy: AccuracyLike | None,
        budget: float | None = None,
    ) -> SignedDistanceResults:
        """Return the pairs within ``reach`` [m] where geometries have paddings."""
        state, far = self._state, reach + paddings.of_pair
        query = state.query(('padded', far), accuracy, far, False, ANSWERS)
        batch = batch_of(state.engine.answer_of(query, checked_budget(budget)))
        padded = padded_pairs(batch, paddings, query.world, reach)
        return SignedDistanceResults(padded, query.world.kept_poses())

    def ComputeSignedDistancePairClosestPoints(
        self,
        geometry_id_A: GeometryId | None = None,
        geometry_id_B: GeometryId | None = None,
        *,
        accuracy: AccuracyLike | None = None,
        id_A: GeometryId | None = None,
        id_B: GeometryId | None = None,
    ) -> SignedDistancePair:
        """Return the signed distance of two geometries, with ``id_A < id_B`` in the answer.

        ``id_A`` and ``id_B`` are older names of the arguments.

        Raises GeometryError for an unknown id, a geometry without the proximity role, a filtered
        pair, and two half spaces.
        """
        first = only_id('geometry_id_A', geometry_id_A, id_A)
        second = only_id('geometry_id_B', geometry_id_B, id_B)
        return self.signed_distance_of_pair(first, second, accuracy=accuracy)[0]

    def signed_distance_of_pair(
        self,
        geometry_id_A: GeometryId,
        geometry_id_B: GeometryId,
        *,
        accuracy: AccuracyLike | None = None,
        hint: ArrayLike | None = None,
    ) -> SignedDistanceResults:
        """Return ComputeSignedDistancePairClosestPoints as a result sequence of one pair.

        ``hint`` (3,) is the normal from which an iteration starts: nhat_BA_W of an earlier answer
        with the ids in ascending order. A good one saves time; the certificate holds for any.
        """
        state = self._state
        records = [state.model.geometry(g) for g in (geometry_id_A, geometry_id_B)]
        records.sort(key=lambda record: record.id)
        what = 'The signed distance of ' + ' and '.join(f"'{r.name}' ({r.id!r})" for r in records)
        for record in records:
            if record.proximity is None:
                raise RoleError(
                    f"{what} was asked for, but '{record.name}' has no proximity role: "
                    'assign it with SceneGraph.AssignRole.'
                )
        keys = [record.id.get_value() for record in records]
        if reasons := state.filters.explain(keys[0], keys[1]):
            raise FilterError(
                f'{what} was asked for, but the pair is filtered: {", ".join(reasons)}. '
                + how_to_allow(reasons)
            )
        for record in records:
            state.placed_frame(record.frame_id)
            if isinstance(record.shape, SensedMap) and not record.shape.count():
                raise GeometryError(
                    f"{what} was asked for, but '{record.name}' is a map without cells, which is "
                    'at no distance from anything.'
                )
        world = state.posed_world()
        pair = world.geometry_rows(np.array([keys], dtype=np.int64))
        start = None if hint is None else _checked_hint(hint)
        batch = state.engine.distance_of_pair(
            world, pair, state.accuracy_for(accuracy).length, start
        )
        if not len(batch.ids):
            why = unsupported(*world.geometries.types[pair[0]].tolist())
            raise GeometryError(f'{what} was asked for: {why}.')
        if (paddings := state.paddings()) is not None:
            batch = padded_pairs(batch, paddings, world, math.inf)
        return SignedDistanceResults(batch, world.kept_poses())

    def FindCollisionCandidates(
        self, *, accuracy: AccuracyLike | None = None
    ) -> list[tuple[GeometryId, GeometryId]]:
        """Return the unfiltered pairs that bounding volumes do not separate, sorted by ids.

        Two half spaces are separated if they are opposed with a gap above rounding. The pairs are
        the same at each ``accuracy``; an unknown name raises ArgumentError.
        """
        state = self._state
        state.accuracy_for(accuracy)
        world, places = self._candidates()
        if len(state.endless_overlaps().ids):
            places = world.geometry_rows(self.collision_candidates())
        ids = state.geometry_ids()
        return list(zip(ids[places[:, 0]].tolist(), ids[places[:, 1]].tolist(), strict=True))

    def collision_candidates(self) -> NDArray[np.int64]:
        """Return FindCollisionCandidates as an array of id values (k, 2)."""
        world, places = self._candidates()
        ids, endless = world.geometries.ids[places], self._state.endless_overlaps().ids
        if not len(endless):
            return ids
        ids = np.concatenate((ids, endless))
        return ids[np.lexsort((ids[:, 1], ids[:, 0]))]

    def _candidates(self) -> tuple[World, NDArray[np.int64]]:
        """Return the up-to-date world, and FindCollisionCandidates by places in it.

        Pairs of two half spaces are left out.
        """
        state = self._state
        reach = paddings.of_pair if (paddings := state.paddings()) else 0.0
        # The level does not matter; the query at the default one is cached.
        query = state.query(('candidates', reach), None, reach, False, CANDIDATES)
        return query.world, state.engine.candidates_of(query)

    def ComputeSignedDistanceToPoint(
        self, p_WQ: ArrayLike, threshold: float = math.inf, *, accuracy: AccuracyLike | None = None
    ) -> PointDistanceResults:
        """Return the signed distances from all geometries to a point, or to points (m, 3).

        A point is (3,), or a column (3, 1).
        Geometries farther than ``threshold`` [m] are left out. Filters do not apply. Sorted by
        (point_index, id_G). Answers are exact at each accuracy level, for every shape.
        On an edge or a corner of a box and on a rim of a cylinder, within rounding, the gradient
        is the normalised mean of the adjoining outward normals.
        Raises ArgumentError for points that are not finite, not of these shapes or beyond 1e302 m,
        and for a threshold that is NaN.
        """
        reach = _checked_distance('threshold', threshold)
        self._state.accuracy_for(accuracy)
        p_WQs = np.array(p_WQ, dtype=np.float64, order='C', ndmin=2)  # the results refer to it
        if p_WQs.shape == (3, 1):
            p_WQs = p_WQs.reshape(1, 3)
        if p_WQs.ndim != 2 or p_WQs.shape[1] != 3:
            raise ArgumentError(
                f'ComputeSignedDistanceToPoint was given p_WQ of shape {np.shape(p_WQ)}; '
                'it must be one point (3,) or points (m, 3), in metres.'
            )
        if not are_allowed(p_WQs):
            raise ArgumentError(_why_refused(p_WQs))
        state = self._state
        world, paddings = state.pointed_world(), state.paddings()
        farthest = reach + (paddings.of_pair if paddings else 0.0)
        batch = state.engine.point_distances(world, p_WQs, farthest)
        if paddings:
            batch = padded_points(batch, paddings, world, p_WQs, reach)
        return self._named(
            PointDistanceResults(batch, world.kept_poses(), p_WQs, paddings is not None)
        )


PreparedQuery.query_type = QueryObject


def _checked_distance(name: str, value: float) -> float:
    """Return a distance as a float, since kernels take no integers."""
    if math.isnan(value):
        raise ArgumentError(f'{name} must be a distance in metres or infinity, but is NaN.')
    return float(value)


def _checked_hint(hint: ArrayLike) -> NDArray[np.float64]:
    nhat_BA_W = np.asarray(hint, dtype=np.float64)
    if nhat_BA_W.shape != (3,):
        raise ArgumentError(f'hint has the shape {nhat_BA_W.shape}; it must be a normal (3,).')
    return nhat_BA_W


def _why_refused(p_WQs: NDArray[np.float64]) -> str:
    """Return the error text for points of which one is not finite or beyond FARTHEST."""
    finite = np.isfinite(p_WQs).all(axis=-1)
    if not finite.all():
        return (
            'ComputeSignedDistanceToPoint was given a point that is not finite: '
            f'{p_WQs[~finite][:1].tolist()}.'
        )
    return (
        'ComputeSignedDistanceToPoint was given a point with the coordinate '
        f'{p_WQs[np.abs(p_WQs) > FARTHEST][0]:.3g} m; none may be beyond {FARTHEST:.3g} m.'
    )
