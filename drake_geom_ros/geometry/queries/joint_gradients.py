"""Distances of states and their derivatives by joint values, one state after another."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from drake_geom_ros.geometry._joint_gradients.joint_axes import JointAxes
from drake_geom_ros.geometry._joint_gradients.state_gradients import (
    GradientArrays,
    distances_of_state,
    gradients_of_states,
    least_of_state_with_gradient,
)
from drake_geom_ros.geometry._proximity.derivatives.gradients import gradients_of_rows
from drake_geom_ros.geometry._proximity.kernels.calling.pairs import (
    DISTANCE,
    ERROR_BOUND,
    SLOT_WIDTH,
)
from drake_geom_ros.geometry._proximity.pairs.answer_rows import BATCH_WIDTH
from drake_geom_ros.geometry._proximity.runtime.handles import handle_of
from drake_geom_ros.geometry._proximity.states.joint_checks import FREE, NEAR
from drake_geom_ros.geometry._proximity.states.joint_loops import JointLoops
from drake_geom_ros.geometry.queries.accuracy import AccuracyLike, accuracy_of
from drake_geom_ros.geometry.queries.half_space_states import HalfSpaceStates
from drake_geom_ros.geometry.queries.joint_trees import JointChain, JointKind
from drake_geom_ros.geometry.queries.packed_scene import PackedScene
from drake_geom_ros.geometry.queries.padding import Paddings, lower_ends, padded_rows
from drake_geom_ros.math.array_types import Flags, Floats, Indices


class NearDistances(NamedTuple):
    """The h pairs of a state that may be within a distance, in the fixed order of all pairs.

    Pairs that are left out are certified to be farther apart.
    """

    verdict: int  # NEAR, or NO_STATE or NO_POSE for an invalid state
    numbers: Indices  # (h,) of the pairs
    distance: Floats  # (h,) [m]
    error_bound: Floats  # (h,) [m]
    gradient: Floats  # (h, c) by joint values
    is_unique: Flags  # (h,) whether the gradient is unique


class LeastDistance(NamedTuple):
    """The pair with the smallest lower bound in a state, by the places of its geometries."""

    verdict: int  # NEAR; FREE without a pair, NO_STATE or NO_POSE for an invalid state
    distance: float  # [m]
    error_bound: float  # [m]
    a: int
    b: int
    gradient: Floats  # (c,) by joint values
    is_unique: bool


class JointGradients:
    """Distances on a packed scene with derivatives by c joint values; each thread needs its own.

    ``chain`` computes the poses of the scene's moved frames, in their order. Distances equal, to
    the bit, those of ``StateQueries``; limits of joints are ignored. The pairs in their fixed
    order are ``scene.pairs``, and then ``scene.half_spaces``.
    """

    def __init__(
        self, scene: PackedScene, chain: JointChain, columns: int, accuracy: AccuracyLike
    ) -> None:
        chain = chain._replace(X_WLs=chain.X_WLs.copy())  # scratch of this thread alone
        limits = np.array([[-math.inf], [math.inf]]).repeat(columns, axis=1)
        self._scene, self._world = scene, scene.world()
        self._loops = JointLoops(
            self._world,
            scene.pairs.copy(),
            scene.moved.copy(),
            chain,
            limits,
            accuracy_of(accuracy).length,
            0.0,
            np.zeros(len(scene.types)),  # answers are about the bodies; paddings are added here
            0.0,
        )
        count = len(scene.pairs)
        self._joints = _joint_axes(scene, chain, self._loops.arrays.X_WLs)
        self._arrays = GradientArrays(
            checks=self._loops.handle,
            joints=handle_of(self._joints),
            slots=np.arange(count),
            is_collected=np.zeros(count, dtype=np.bool_),
            near=np.zeros((count, 2), dtype=np.int64),
            hits=np.zeros(count, dtype=np.int64),
            memory=np.zeros((count, SLOT_WIDTH)),
            numbers=np.zeros(count, dtype=np.int64),
            ids=np.zeros((count, 2), dtype=np.int64),
            places=np.zeros((count, 2), dtype=np.int64),
            rows=np.zeros((count, BATCH_WIDTH)),
            by_frames=np.zeros((count, 12)),
            unique=np.zeros(count, dtype=np.bool_),
            by_joints=np.zeros((count, columns)),
        )
        self._handle = handle_of(self._arrays)
        self._paddings = Paddings(scene.paddings, scene.meshes) if scene.paddings.any() else None
        self._half_spaces = HalfSpaceStates.of(scene, chain)

    def within(self, state: Floats, distance: float) -> NearDistances:
        """Return the pairs that may be within a distance [m] in a contiguous state (1, c).

        Arrays are valid until the next call.
        """
        reach = distance if self._paddings is None else distance + self._paddings.of_pair
        verdict, count, surfaces = distances_of_state(self._handle, state, reach)
        arrays = self._arrays
        if surfaces:
            self._decide_surfaces(count)
        rows = arrays.rows[:count]
        near = NearDistances(
            verdict,
            arrays.numbers[:count],
            rows[:, DISTANCE],
            rows[:, ERROR_BOUND],
            arrays.by_joints[:count],
            arrays.unique[:count],
        )
        if verdict != NEAR:
            return near
        if self._paddings is not None:
            # A padding moves points along the normal, which changes no gradient.
            rows = padded_rows(rows, arrays.places[:count], self._paddings, self._world)
            keep = lower_ends(rows) <= distance
            near = NearDistances(
                verdict,
                near.numbers[keep],
                rows[keep, DISTANCE],
                rows[keep, ERROR_BOUND],
                near.gradient[keep],
                near.is_unique[keep],
            )
        return near if self._half_spaces is None else self._with_half_spaces(near, state, distance)

    def least(self, state: Floats) -> LeastDistance:
        """Return the pair with the smallest lower bound in a contiguous state (1, c)."""
        if self._paddings is not None or self._half_spaces is not None:
            return self._least_of_all(state)
        if not len(self._scene.pairs):
            return LeastDistance(FREE, math.inf, 0.0, 0, 0, np.zeros(state.shape[1]), False)
        verdict, distance, error_bound, a, b, surfaces = least_of_state_with_gradient(
            self._handle, state
        )
        if surfaces:
            self._decide_surfaces(1)
        if verdict != NEAR:
            none = np.zeros(state.shape[1])
            return LeastDistance(verdict, distance, error_bound, a, b, none, False)
        gradient, is_unique = self._arrays.by_joints[0].copy(), bool(self._arrays.unique[0])
        return LeastDistance(verdict, distance, error_bound, a, b, gradient, is_unique)

    def of_rows(
        self, states: Floats, of_state: Indices, places: Indices, by_frames: Floats
    ) -> Floats:
        """Return the derivatives (k, c) of k distances by the joint values of their states (N, c).

        ``of_state`` (k,) are their states, ascending, ``places`` (k, 2) the geometries A and B,
        -1 without a pair, ``by_frames`` (k, 12) the derivatives by the velocities of their frames.
        """
        totals = np.zeros((len(places), states.shape[1]))
        offsets = np.searchsorted(of_state, np.arange(len(states) + 1))
        gradients_of_states(
            self._handle,
            np.ascontiguousarray(states),
            offsets,
            np.ascontiguousarray(places),
            np.ascontiguousarray(by_frames),
            totals,
        )
        return totals

    def _decide_surfaces(self, count: int) -> None:
        """Decide which gradients of the first ``count`` rows from surfaces are unique."""
        # Imported late: scenes without solids need not load the code for solids.
        from drake_geom_ros.geometry._proximity.derivatives.of_solids import find_unique_of_solids

        rows = self._arrays.rows[:count]
        rows.setflags(write=False)  # Numba compiles another version for writable arrays
        geometries, R_WGs = self._world.geometries, self._world.R_WGs
        shapes = geometries.types, geometries.starts, geometries.pool, R_WGs
        find_unique_of_solids(rows, self._arrays.places[:count], shapes, self._arrays.unique)

    def _with_half_spaces(
        self, near: NearDistances, state: Floats, distance: float
    ) -> NearDistances:
        assert self._half_spaces is not None
        places, rows = self._half_spaces.answers_at(self._loops.arrays.poses[0])
        rows = rows[:, :BATCH_WIDTH]
        of_state = np.zeros(len(places), dtype=np.int64)
        gradients = self.of_rows(state, of_state, places, gradients_of_rows(rows))
        numbers = len(self._scene.pairs) + np.arange(len(places))
        own = numbers, rows[:, DISTANCE], rows[:, ERROR_BOUND], gradients, of_state > 0
        keep = lower_ends(rows) <= distance
        columns = [
            np.concatenate((some, others[keep]))
            for some, others in zip(near[1:], own, strict=True)
        ]
        return NearDistances(near.verdict, *columns)

    def _least_of_all(self, state: Floats) -> LeastDistance:
        """Return ``least`` from the answers about all pairs."""
        near = self.within(state, math.inf)
        if near.verdict != NEAR or not len(near.numbers):
            verdict = FREE if near.verdict == NEAR else near.verdict
            return LeastDistance(verdict, math.inf, 0.0, 0, 0, np.zeros(state.shape[1]), False)
        k = int(np.argmin(near.distance - near.error_bound))
        a, b = np.concatenate((self._scene.pairs, self._scene.half_spaces))[near.numbers[k]]
        return LeastDistance(
            NEAR,
            float(near.distance[k]),
            float(near.error_bound[k]),
            int(a),
            int(b),
            near.gradient[k].copy(),
            bool(near.is_unique[k]),
        )


def with_pairs(scene: PackedScene, numbers: Indices) -> PackedScene:
    """Return a scene with some of its pairs alone, by their ascending numbers (k,)."""
    count = len(scene.pairs)
    return replace(
        scene,
        pairs=scene.pairs[numbers[numbers < count]],
        half_spaces=scene.half_spaces[numbers[numbers >= count] - count],
    )


def _joint_axes(scene: PackedScene, chain: JointChain, X_PLs: Floats) -> JointAxes:
    """Return the joints of a chain that a state moves, and the frames that each of them moves.

    Each joint moves the descendants of its link, and the robots that are mounted on one of them.
    """
    below = _links_below(chain, len(X_PLs))
    moves = np.zeros((len(chain.parents), len(scene.parents)), dtype=np.bool_)
    moves[:, scene.moved] = below[:, chain.links]
    for frame, parent in enumerate(scene.parents.tolist()):
        if frame:
            moves[:, frame] |= moves[:, parent]
    used = np.flatnonzero((chain.leaders >= 0) & (chain.kinds != JointKind.FIXED))
    bases = np.zeros(len(chain.parents), dtype=np.int64)
    for link, row in zip(chain.links.tolist(), scene.moved.tolist(), strict=True):
        bases[below[:, link]] = scene.parents[row]
    return JointAxes(
        columns=chain.leaders[used],
        multipliers=chain.multipliers[used],
        kinds=chain.kinds[used],
        axes=np.ascontiguousarray(chain.axes[used]),
        links=chain.children[used],
        X_PLs=X_PLs,
        bases=bases[used],
        moves=np.ascontiguousarray(moves[used]),
        axes_W=np.zeros((len(used), 3)),
        p_WJs=np.zeros((len(used), 3)),
    )


def _links_below(chain: JointChain, links: int) -> Flags:
    """Return the mask (m, links) of the descendants of each joint's link, that link included."""
    below = np.zeros((len(chain.parents), links), dtype=np.bool_)
    for joint, (parent, child) in enumerate(zip(chain.parents, chain.children, strict=True)):
        below[:, child] = below[:, parent]  # parents come first
        below[joint, child] = True
    return below
