"""Queries about states given by joint values, one after another."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.states.joint_checks import (
    FREE,
    NEAR,
    NO_POSE,
    NO_STATE,
    OUTSIDE,
)
from drake_geom_ros.geometry._proximity.states.joint_loops import JointLoops
from drake_geom_ros.geometry.errors import ArgumentError
from drake_geom_ros.geometry.queries.accuracy import AccuracyLike, accuracy_of
from drake_geom_ros.geometry.queries.half_space_states import HalfSpaceStates
from drake_geom_ros.geometry.queries.joint_trees import JointChain
from drake_geom_ros.geometry.queries.packed_scene import PackedScene
from drake_geom_ros.geometry.queries.padding import PADDED_ROUNDING
from drake_geom_ros.math.array_types import Floats

# Verdicts on a state; see ``JointQueries.verdict``.
__all__ = ['FREE', 'NEAR', 'NO_POSE', 'NO_STATE', 'OUTSIDE', 'JointQueries', 'NearestPair']


class NearestPair(NamedTuple):
    """Pair with the smallest lower bound in a state, by the places of its geometries."""

    verdict: int  # NEAR; FREE where there is no pair, NO_STATE or NO_POSE where there is no state
    distance: float  # [m]
    error_bound: float  # [m]
    a: int
    b: int


class JointQueries:
    """Queries by joint values on a packed scene, without the GIL; each thread needs its own.

    ``chain`` computes the poses of the scene's moved frames, in their order, from the c values of
    a state; ``limits`` (2, c) are the limits of the values. A state is near if a pair may be
    within the ``margin`` [m] or, with None, overlaps. Every answer equals, to the bit, that of
    ``StateQueries`` for these poses. Raises ArgumentError for padded geometries without a margin.
    """

    def __init__(
        self,
        scene: PackedScene,
        chain: JointChain,
        limits: Floats,
        accuracy: AccuracyLike,
        margin: float | None,
    ) -> None:
        if margin is None and scene.paddings.any():
            raise ArgumentError('an overlap of padded geometries has no check by joint values')
        chain = chain._replace(X_WLs=chain.X_WLs.copy())  # scratch of this thread alone
        self._loops = JointLoops(
            scene.world(),
            scene.pairs.copy(),
            scene.moved.copy(),
            chain,
            limits,
            accuracy_of(accuracy).length,
            margin,
            scene.paddings,
            PADDED_ROUNDING,
        )
        self._half_spaces, self._margin = HalfSpaceStates.of(scene, chain), margin or 0.0
        # Bound here, since a method around it would cost a tenth of a microsecond.
        self.verdict = self._loops.verdict  # of one state (1, c), as ``verdicts``
        if self._half_spaces is not None:
            self.verdict = self._verdict_with_half_spaces

    def verdicts(self, states: Floats) -> NDArray[np.int64]:
        """Return the verdicts (N,) on states (N, c), a contiguous array.

        FREE where every pair is certified to be farther apart than the margin, else NEAR; OUTSIDE
        where a value is beyond its limits, NO_STATE where it is not finite, NO_POSE where a link
        would be beyond the largest allowed coordinates.
        """
        verdicts = self._loops.verdicts(states)
        if self._half_spaces is not None:
            for k in np.flatnonzero(verdicts == FREE).tolist():
                verdicts[k] = self._of_half_spaces(states[k])
        return verdicts

    def least(self, state: Floats) -> NearestPair:
        """Return the pair with the smallest lower bound in a state (1, c); limits are ignored.

        Paddings are ignored, too.
        """
        nearest = NearestPair(*self._loops.least(state))
        if self._half_spaces is None or nearest.verdict not in (FREE, NEAR):
            return nearest
        gaps = self._half_spaces.at_joints(state[0])
        k = int(np.argmin(gaps.lower))
        if nearest.verdict == NEAR and nearest.distance - nearest.error_bound <= gaps.lower[k]:
            return nearest
        a, b = gaps.ids[k].tolist()
        return NearestPair(NEAR, float(gaps.distance[k]), float(gaps.error_bound[k]), a, b)

    def _verdict_with_half_spaces(self, state: Floats) -> int:
        """Return the verdict on a state (1, c) of a scene with pairs of half spaces."""
        verdict = self._loops.verdict(state)
        return self._of_half_spaces(state[0]) if verdict == FREE else verdict

    def _of_half_spaces(self, values: Floats) -> int:
        """Return the verdict on values (c,) at which all other pairs are FREE."""
        assert self._half_spaces is not None
        return FREE if self._half_spaces.at_joints(values).are_beyond(self._margin) else NEAR
