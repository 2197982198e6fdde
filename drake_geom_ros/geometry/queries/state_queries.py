"""Queries about many states of a scene, and who answers them."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.kernels.calling.points import (
    POINT_DISTANCE,
    POINT_ERROR_BOUND,
)
from drake_geom_ros.geometry._proximity.pairs.answer_rows import OVERLAPS, PairBatch, PointBatch
from drake_geom_ros.geometry._proximity.states.state_loops import StateLoops
from drake_geom_ros.geometry._proximity.tolerances import GAPS_OF_LEVELS
from drake_geom_ros.geometry.errors import GeometryError, PoseError
from drake_geom_ros.geometry.queries.contact_queries import Contacts
from drake_geom_ros.geometry.queries.context import SceneGraphContext, state_of
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
from drake_geom_ros.geometry.queries.state_contacts import StateContacts

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
# Found pairs or points of a block of states: how many each state has (N,), and all of them.
Found = tuple[Indices, SignedDistanceResults | PointDistanceResults]


def default_accuracy(context: SceneGraphContext) -> str:
    """Return the accuracy of queries of a context that name none."""
    return state_of(context).accuracy


class StateQueries:
    """Answers about states of a packed scene, without the GIL; each thread takes one of its own.

    A state is the pose X_PF, x y z [m] qx qy qz qw, of each frame that the scene has as moved.
    What is found names geometries by their place in the scene. Every answer is, to the bit, that
    of a QueryObject of a context that was never asked before. ``stop`` (1,) set to another number
    than 0, by another thread, ends a call early: it raises InterruptedError then.
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
        self, poses: Floats, accuracy: str, stop: Indices, margin: float | None = None
    ) -> NDArray[np.bool_]:
        """Return HasCollisions of each state (N, n, 7); with a margin [m] whether a pair is in it.

        That is so unless every pair is certified to be farther apart than the margin.
        """
        found = self._collide(poses, accuracy, stop, margin)
        if self._half_spaces is not None:
            for k in np.flatnonzero(~found).tolist():
                _check_done(k if stop[0] else len(poses), poses, stop)
                found[k] = not self._half_spaces.at(poses[k]).are_beyond(margin or 0.0)
        return found

    def _collide(
        self, poses: Floats, accuracy: str, stop: Indices, margin: float | None
    ) -> NDArray[np.bool_]:
        """Return ``has_collisions`` as if there were no pairs of half spaces."""
        if self._paddings is not None:
            counts, rows = self._padded(poses, accuracy, margin or 0.0, stop)
            near = rows[:, OVERLAPS] > 0.0
            if margin is not None:
                near = lower_ends(rows) <= margin
            return _any_of_each(counts, near)
        if margin is None:
            done, found = self._loops.overlaps(poses, GAPS_OF_LEVELS[accuracy], stop)
        else:
            done, found = self._loops.near(poses, GAPS_OF_LEVELS[accuracy], margin, stop)
        _check_done(done, poses, stop)
        return found

    def nearest(
        self, poses: Floats, accuracy: str, max_distance: float, most: int, stop: Indices
    ) -> Found:
        """Return the pairs of the least lower bounds of each state (N, n, 7), at most so many.

        In their order, a lower bound being distance minus error bound. Left out is what has a
        higher one than the last of so many, or one above ``max_distance`` [m]. Two half spaces
        are as far apart as their gap where they are opposed, else minus infinity.
        """
        if self._paddings is not None:
            counts, batch = self._padded_nearest(poses, accuracy, max_distance, most, stop)
        else:
            done, counts, batch = self._loops.nearest(
                poses, GAPS_OF_LEVELS[accuracy], max_distance, most, stop
            )
            _check_done(done, poses, stop)
        if self._half_spaces is not None:
            counts, batch = _with_half_spaces(
                self._half_spaces, (counts, batch), poses, max_distance, most, stop
            )
        return counts, SignedDistanceResults(batch)

    def within(self, poses: Floats, accuracy: str, max_distance: float, stop: Indices) -> Found:
        """Return ComputeSignedDistancePairwiseClosestPoints of each state (N, n, 7)."""
        if self._paddings is not None:
            return self._padded_within(poses, accuracy, max_distance, stop)
        done, counts, batch = self._loops.within(
            poses, GAPS_OF_LEVELS[accuracy], max_distance, stop
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
    ) -> Found:
        """Return ComputeSignedDistanceToPoint of points (m, 3) in each state (N, n, 7).

        The points of a single state may be ``shared`` out to all threads.
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

    def contacts(self, poses: Floats, accuracy: str, stop: Indices) -> Iterator[Contacts]:
        """Yield what QueryObject.contacts tells of each state (N, n, 7), overlaps at a level.

        Raises GeometryError where no geometry has hydroelastic properties.
        """
        if self._contacts is None:
            raise GeometryError(
                'Contacts of states were asked for, and no geometry has hydroelastic properties: '
                'see AddRigidHydroelasticProperties and AddCompliantHydroelasticProperties.'
            )
        reach = 0.0 if self._paddings is None else self._paddings.of_pair
        done, counts, (ids, _) = self._loops.within(poses, GAPS_OF_LEVELS['bound'], reach, stop)
        _check_done(done, poses, stop)
        for number, last in enumerate(np.cumsum(counts).tolist()):
            _check_done(number if stop[0] else len(poses), poses, stop)
            state = poses[number : number + 1]
            overlaps = partial(self._penetrations, state, accuracy, stop)
            pairs = ids[last - int(counts[number]) : last]
            yield self._contacts.of(state[0], pairs, overlaps)

    def _penetrations(self, state: Floats, accuracy: str, stop: Indices) -> PenetrationResults:
        """Return ComputePointPairPenetration of a state (1, n, 7)."""
        _, found = self.within(state, accuracy, 0.0, stop)
        assert isinstance(found, SignedDistanceResults)
        return found.penetrations()

    def _padded(
        self, poses: Floats, accuracy: str, reach: float, stop: Indices
    ) -> tuple[Indices, Floats]:
        """Return how many pairs each state has near, and all rows, of the padded bodies."""
        counts, _, rows = self._padded_rows(poses, accuracy, reach, stop)
        return counts, rows

    def _padded_rows(
        self, poses: Floats, accuracy: str, reach: float, stop: Indices
    ) -> tuple[Indices, Indices, Floats]:
        assert self._paddings is not None
        far = reach + self._paddings.of_pair
        done, counts, (ids, rows) = self._loops.within(poses, GAPS_OF_LEVELS[accuracy], far, stop)
        _check_done(done, poses, stop)
        return counts, ids, padded_rows(rows, ids, self._paddings, self._world)

    def _padded_within(
        self, poses: Floats, accuracy: str, max_distance: float, stop: Indices
    ) -> Found:
        counts, ids, rows = self._padded_rows(poses, accuracy, max_distance, stop)
        keep = lower_ends(rows) <= max_distance
        return _count_of_each(counts, keep), SignedDistanceResults(
            PairBatch(ids[keep], rows[keep])
        )

    def _padded_nearest(
        self, poses: Floats, accuracy: str, max_distance: float, most: int, stop: Indices
    ) -> tuple[Indices, PairBatch]:
        counts, ids, rows = self._padded_rows(poses, accuracy, max_distance, stop)
        lower = lower_ends(rows)
        state = np.repeat(np.arange(len(counts)), counts)
        order = np.lexsort((lower, state))
        ranks = np.arange(len(order)) - np.repeat(np.cumsum(counts) - counts, counts)
        order = order[(ranks < most) & (lower[order] <= max_distance)]
        kept = np.bincount(state[order], minlength=len(counts))
        return kept, PairBatch(ids[order], rows[order])


def _with_half_spaces(
    half_spaces: HalfSpaceStates,
    others: tuple[Indices, PairBatch],
    poses: Floats,
    max_distance: float,
    most: int,
    stop: Indices,
) -> tuple[Indices, PairBatch]:
    """Return the nearest pairs of states (N, n, 7), those of half spaces among the others."""
    counts, (ids, rows) = others
    found, last = [], np.cumsum(counts)
    for k in range(len(poses)):
        _check_done(k if stop[0] else len(poses), poses, stop)
        own = slice(last[k] - counts[k], last[k])
        answers = half_spaces.answers_at(poses[k])
        found.append(nearest_of(PairBatch(ids[own], rows[own]), answers, max_distance, most))
    if not found:
        return others
    batch = PairBatch(*(np.vstack(columns) for columns in zip(*found, strict=True)))
    return np.array([len(some.ids) for some in found]), batch


def _count_of_each(counts: Indices, keep: NDArray[np.bool_]) -> Indices:
    """Return how many of the rows of each state are kept."""
    state = np.repeat(np.arange(len(counts)), counts)
    return np.bincount(state[keep], minlength=len(counts))


def _any_of_each(counts: Indices, keep: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return which states have a row that is kept."""
    found: NDArray[np.bool_] = _count_of_each(counts, keep) > 0
    return found


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
    """A state that is none; ``number`` is which one."""

    def __init__(self, reason: str, number: int) -> None:
        super().__init__(reason)
        self.number = number
