"""Queries about many states of a packed scene."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import partial

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.kernels.calling.points import (
    POINT_DISTANCE,
    POINT_ERROR_BOUND,
)
from drake_geom_ros.geometry._proximity.pairs.answer_rows import OVERLAPS, PairBatch, PointBatch
from drake_geom_ros.geometry._proximity.states.state_loops import StateLoops
from drake_geom_ros.geometry._proximity.world.world import Named
from drake_geom_ros.geometry.errors import GeometryError, PoseError
from drake_geom_ros.geometry.model.frame_pose_vector import FramePoseVector, arrays_of
from drake_geom_ros.geometry.queries.accuracy import Accuracy, AccuracyLike, accuracy_of
from drake_geom_ros.geometry.queries.contact_bodies import ContactBodies
from drake_geom_ros.geometry.queries.contact_queries import (
    CandidateSurfaces,
    Contacts,
    contacts_of,
)
from drake_geom_ros.geometry.queries.contact_surfaces import (
    ContactSurfaceResults,
    HydroelasticContactRepresentation,
)
from drake_geom_ros.geometry.queries.context import SceneGraphContext, state_of
from drake_geom_ros.geometry.queries.half_space_pairs import endless_overlaps
from drake_geom_ros.geometry.queries.half_space_rows import nearest_of
from drake_geom_ros.geometry.queries.half_space_states import HalfSpaceStates
from drake_geom_ros.geometry.queries.packed_scene import PackedScene
from drake_geom_ros.geometry.queries.padding import (
    Paddings,
    lower_ends,
    padded_point_rows,
    padded_rows,
)
from drake_geom_ros.geometry.queries.query_results import (
    PenetrationResults,
    PointDistanceResults,
    SignedDistanceResults,
)
from drake_geom_ros.math.array_types import Floats, Indices

# Answers about a block of states: the number that each state has (N,), and all of them.
BlockAnswers = tuple[Indices, SignedDistanceResults | PointDistanceResults]


def accuracy_in(context: SceneGraphContext, accuracy: AccuracyLike = '') -> Accuracy:
    """Return an accuracy, or the default one of a context's queries where it is empty."""
    return state_of(context).accuracy_for(None if accuracy == '' else accuracy)


class StateQueries:
    """Queries about states of a packed scene, without the GIL; each thread needs its own.

    A state is the pose X_PF, x y z [m] qx qy qz qw, of each moved frame of the scene. Answers
    identify geometries by their place in the scene. Every answer equals, to the bit, that of the
    first query of a new context. When another thread sets ``stop`` (1,) to a number other than 0,
    a call raises InterruptedError.
    """

    def __init__(self, scene: PackedScene) -> None:
        self._world = scene.world()
        self._loops = StateLoops(self._world, scene.pairs.copy(), scene.moved.copy())
        self._paddings = Paddings(scene.paddings, scene.meshes) if scene.paddings.any() else None
        self._half_spaces = HalfSpaceStates.of(scene)
        self._contacts = None
        if (scene.body_of >= 0).any():
            self._contacts = StateContacts(scene, self._paddings)

    def has_collisions(
        self, poses: Floats, accuracy: AccuracyLike, stop: Indices, margin: float | None = None
    ) -> NDArray[np.bool_]:
        """Return HasCollisions of each state (N, n, 7), or whether a pair is within a margin [m].

        With a margin it is True unless every pair is certified to be farther apart.
        """
        collides = self._collide(poses, accuracy, stop, margin)
        if self._half_spaces is not None:
            for k in np.flatnonzero(~collides).tolist():
                _check_done(k if stop[0] else len(poses), poses, stop)
                collides[k] = not self._half_spaces.at(poses[k]).are_beyond(margin or 0.0)
        return collides

    def _collide(
        self, poses: Floats, accuracy: AccuracyLike, stop: Indices, margin: float | None
    ) -> NDArray[np.bool_]:
        """Return ``has_collisions`` without the pairs of half spaces."""
        if self._paddings is not None:
            counts, rows = self._padded(poses, accuracy, margin or 0.0, stop)
            near = rows[:, OVERLAPS] > 0.0
            if margin is not None:
                near = lower_ends(rows) <= margin
            return _any_of_each(counts, near)
        if margin is None:
            done, collides = self._loops.overlaps(poses, accuracy_of(accuracy).length, stop)
        else:
            done, collides = self._loops.near(poses, accuracy_of(accuracy).length, margin, stop)
        _check_done(done, poses, stop)
        return collides

    def nearest(
        self, poses: Floats, accuracy: AccuracyLike, max_distance: float, most: int, stop: Indices
    ) -> BlockAnswers:
        """Return the ``most`` pairs with the smallest lower bounds of each state (N, n, 7).

        They are sorted by the lower bound, distance minus error bound. Pairs with one above
        ``max_distance`` [m] are left out. The distance of two half spaces is their gap if they are
        opposed, else minus infinity.
        """
        if self._paddings is not None:
            counts, batch = self._padded_nearest(poses, accuracy, max_distance, most, stop)
        else:
            done, counts, batch = self._loops.nearest(
                poses, accuracy_of(accuracy).length, max_distance, most, stop
            )
            _check_done(done, poses, stop)
        if self._half_spaces is not None:
            counts, batch = _with_half_spaces(
                self._half_spaces, (counts, batch), poses, max_distance, most, stop
            )
        return counts, SignedDistanceResults(batch)

    def within(
        self, poses: Floats, accuracy: AccuracyLike, max_distance: float, stop: Indices
    ) -> BlockAnswers:
        """Return ComputeSignedDistancePairwiseClosestPoints of each state (N, n, 7)."""
        if self._paddings is not None:
            return self._padded_within(poses, accuracy, max_distance, stop)
        done, counts, batch = self._loops.within(
            poses, accuracy_of(accuracy).length, max_distance, stop
        )
        _check_done(done, poses, stop)
        return counts, SignedDistanceResults(batch)

    def points(
        self,
        poses: Floats,
        p_WQs: Floats,
        threshold: float,
        stop: Indices,
        *,
        shared: bool = False,
    ) -> BlockAnswers:
        """Return ComputeSignedDistanceToPoint of points (m, 3) in each state (N, n, 7).

        The points of a single state may be ``shared`` among all threads.
        """
        paddings = self._paddings
        if paddings is not None and (paddings.meshes & (paddings.radii > 0)).any():
            raise PoseError(
                'States were refused: points near padded meshes are asked of a QueryObject, which '
                'knows where the mesh is'
            )
        reach = threshold + (0.0 if paddings is None else paddings.of_pair)
        done, counts, batch = self._loops.points(poses, p_WQs, reach, stop, shared=shared)
        _check_done(done, poses, stop)
        if self._paddings is None:
            return counts, PointDistanceResults(batch)
        rows, _ = padded_point_rows(batch.rows, batch.ids, self._paddings)
        keep = rows[:, POINT_DISTANCE] - rows[:, POINT_ERROR_BOUND] <= threshold
        batch = PointBatch(batch.ids[keep], batch.points[keep], rows[keep])
        return _count_of_each(counts, keep), PointDistanceResults(batch)

    def contacts(self, poses: Floats, accuracy: AccuracyLike, stop: Indices) -> Iterator[Contacts]:
        """Yield QueryObject.contacts of each state (N, n, 7), with overlaps at a level.

        Raises GeometryError where no geometry has hydroelastic properties.
        """
        if self._contacts is None:
            raise GeometryError(
                'Contacts of states were asked for, and no geometry has hydroelastic properties: '
                'see AddRigidHydroelasticProperties and AddCompliantHydroelasticProperties.'
            )
        reach = 0.0 if self._paddings is None else self._paddings.of_pair
        done, counts, (ids, _) = self._loops.within(poses, math.inf, reach, stop)
        _check_done(done, poses, stop)
        for number, last in enumerate(np.cumsum(counts).tolist()):
            _check_done(number if stop[0] else len(poses), poses, stop)
            state = poses[number : number + 1]
            overlaps = partial(self._penetrations, state, accuracy, stop)
            pairs = ids[last - int(counts[number]) : last]
            yield self._contacts.of(state[0], pairs, overlaps)

    def _penetrations(
        self, state: Floats, accuracy: AccuracyLike, stop: Indices
    ) -> PenetrationResults:
        """Return ComputePointPairPenetration of a state (1, n, 7)."""
        _, pairs = self.within(state, accuracy, 0.0, stop)
        assert isinstance(pairs, SignedDistanceResults)
        return pairs.penetrations()

    def _padded(
        self, poses: Floats, accuracy: AccuracyLike, reach: float, stop: Indices
    ) -> tuple[Indices, Floats]:
        """Return the number of near pairs of each state, and all rows, for the padded bodies."""
        counts, _, rows = self._padded_rows(poses, accuracy, reach, stop)
        return counts, rows

    def _padded_rows(
        self, poses: Floats, accuracy: AccuracyLike, reach: float, stop: Indices
    ) -> tuple[Indices, Indices, Floats]:
        assert self._paddings is not None
        far = reach + self._paddings.of_pair
        done, counts, (ids, rows) = self._loops.within(
            poses, accuracy_of(accuracy).length, far, stop
        )
        _check_done(done, poses, stop)
        return counts, ids, padded_rows(rows, ids, self._paddings, self._world)

    def _padded_within(
        self, poses: Floats, accuracy: AccuracyLike, max_distance: float, stop: Indices
    ) -> BlockAnswers:
        counts, ids, rows = self._padded_rows(poses, accuracy, max_distance, stop)
        keep = lower_ends(rows) <= max_distance
        return _count_of_each(counts, keep), SignedDistanceResults(
            PairBatch(ids[keep], rows[keep])
        )

    def _padded_nearest(
        self, poses: Floats, accuracy: AccuracyLike, max_distance: float, most: int, stop: Indices
    ) -> tuple[Indices, PairBatch]:
        counts, ids, rows = self._padded_rows(poses, accuracy, max_distance, stop)
        lower = lower_ends(rows)
        state = np.repeat(np.arange(len(counts)), counts)
        order = np.lexsort((lower, state))
        ranks = np.arange(len(order)) - np.repeat(np.cumsum(counts) - counts, counts)
        order = order[(ranks < most) & (lower[order] <= max_distance)]
        near_counts = np.bincount(state[order], minlength=len(counts))
        return near_counts, PairBatch(ids[order], rows[order])


def _with_half_spaces(
    half_spaces: HalfSpaceStates,
    others: tuple[Indices, PairBatch],
    poses: Floats,
    max_distance: float,
    most: int,
    stop: Indices,
) -> tuple[Indices, PairBatch]:
    """Return the nearest pairs of states (N, n, 7), half spaces included."""
    counts, (ids, rows) = others
    batches, last = [], np.cumsum(counts)
    for k in range(len(poses)):
        _check_done(k if stop[0] else len(poses), poses, stop)
        own = slice(last[k] - counts[k], last[k])
        answers = half_spaces.answers_at(poses[k])
        batches.append(nearest_of(PairBatch(ids[own], rows[own]), answers, max_distance, most))
    if not batches:
        return others
    batch = PairBatch(*(np.vstack(columns) for columns in zip(*batches, strict=True)))
    return np.array([len(some.ids) for some in batches]), batch


def _count_of_each(counts: Indices, keep: NDArray[np.bool_]) -> Indices:
    """Return the number of rows of each state that ``keep`` selects."""
    state = np.repeat(np.arange(len(counts)), counts)
    return np.bincount(state[keep], minlength=len(counts))


def _any_of_each(counts: Indices, keep: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return the mask of states with a row that ``keep`` selects."""
    any_kept: NDArray[np.bool_] = _count_of_each(counts, keep) > 0
    return any_kept


def _check_done(done: int, poses: Floats, stop: Indices) -> None:
    """Raise InterruptedError where states were left out, StateError where one has no pose."""
    if done == len(poses):
        return
    if stop[0]:
        raise InterruptedError(f'stopped after {done} of {len(poses)} states')
    raise StateError(
        'a pose is x y z [m] and a unit quaternion qx qy qz qw, all finite; '
        f'there are {poses[done].tolist()}',
        done,
    )


class StateError(PoseError):
    """Raised for an invalid state; ``number`` is its index."""

    def __init__(self, reason: str, number: int) -> None:
        super().__init__(reason)
        self.number = number


class StateContacts:
    """Contacts of states in a private world, for one thread; ids are places in the scene.

    A state is a pose (7,) in its parent of each frame of ``rows`` (n,); all others stay.
    """

    def __init__(self, scene: PackedScene, paddings: Paddings | None) -> None:
        world, rows, body_of = scene.world(), scene.moved.copy(), scene.body_of
        self._world = world
        self._named = Named(world.frames.ids[rows], rows)
        self._bodies = ContactBodies(
            0, np.arange(len(body_of)), body_of, scene.bodies, scene.likeness, paddings
        )
        self._posed = self._bodies.posed(world.R_WGs, world.p_WGs)
        self._half_spaces = scene.half_spaces

    def of(
        self, pose: Floats, pairs: Indices, overlaps: Callable[[], PenetrationResults]
    ) -> Contacts:
        """Return the contacts of a state (n, 7) among ``pairs`` (k, 2), all that may overlap.

        ``overlaps`` is called only if a pair may lack a surface.
        """
        from drake_geom_ros.geometry._contact_surfaces.asking import surfaces_of

        world, bodies = self._world, self._bodies
        _, X_PFs = arrays_of(FramePoseVector.FromArrays(self._named.ids + 1, pose))
        world.pose(self._named, X_PFs)
        world.update()
        pairs = np.sort(pairs, axis=1)
        answer = surfaces_of(self._posed, pairs)
        surfaces = ContactSurfaceResults(answer, HydroelasticContactRepresentation.kPolygon)
        endless = endless_overlaps(world, self._half_spaces, bodies.paddings)
        return contacts_of(
            bodies, CandidateSurfaces(bodies.ids, pairs, answer, surfaces), endless, overlaps
        )
