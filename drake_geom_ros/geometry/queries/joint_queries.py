"""Queries about one state after another, by joint values."""

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
from drake_geom_ros.geometry._proximity.tolerances import GAPS_OF_LEVELS
from drake_geom_ros.geometry.queries.half_space_states import HalfSpaceStates
from drake_geom_ros.geometry.queries.joint_trees import JointChain
from drake_geom_ros.geometry.queries.packed_scene import PackedScene

# What is said of a state; see ``JointQueries.verdict``.
__all__ = ['FREE', 'NEAR', 'NO_POSE', 'NO_STATE', 'OUTSIDE', 'JointQueries', 'Least']

Floats = NDArray[np.float64]


class Least(NamedTuple):
    """The pair of the least lower bound in a state, by the places of its geometries."""

    verdict: int  # NEAR; FREE where there is no pair, NO_STATE or NO_POSE where there is no state
    distance: float  # [m]
    error_bound: float  # [m]
    a: int
    b: int


class JointQueries:
    """Answers about joint values of a packed scene, without the GIL; each thread takes its own.

    ``chain`` poses the frames that the scene has as moved, in their order, from the c values of a
    state; ``limits`` (2, c) are theirs. Every answer is, to the bit, that of ``StateQueries``
    about the poses that the values mean.
    """

    def __init__(
        self, scene: PackedScene, chain: JointChain, limits: Floats, accuracy: str, margin: float
    ) -> None:
        chain = chain._replace(X_WLs=chain.X_WLs.copy())  # room, of this thread alone
        self._loops = JointLoops(
            scene.world(),
            scene.pairs.copy(),
            scene.moved.copy(),
            chain,
            limits,
            GAPS_OF_LEVELS[accuracy],
            margin,
        )
        self._half_spaces, self._margin = HalfSpaceStates.of(scene, chain), margin
        # Bound here: a method that passes it on takes a tenth of a microsecond.
        self.verdict = self._loops.verdict  # of one state (1, c), as ``verdicts``
        if self._half_spaces is not None:
            self.verdict = self._verdict_with_half_spaces

    def verdicts(self, states: Floats) -> NDArray[np.int64]:
        """Return what is true of each state (N, c), in one piece: (N,).

        FREE where every pair is certified to be farther apart than the margin, else NEAR; OUTSIDE
        where a value is beyond its limits, NO_STATE where it is not finite, NO_POSE where a link
        would be too far away to be anywhere.
        """
        found = self._loops.verdicts(states)
        if self._half_spaces is not None:
            for k in np.flatnonzero(found == FREE).tolist():
                found[k] = self._of_half_spaces(states[k])
        return found

    def least(self, state: Floats) -> Least:
        """Return the pair of the least lower bound in a state (1, c), whatever its limits."""
        found = Least(*self._loops.least(state))
        if self._half_spaces is None or found.verdict not in (FREE, NEAR):
            return found
        gaps = self._half_spaces.at_joints(state[0])
        k = int(np.argmin(gaps.lower))
        if found.verdict == NEAR and found.distance - found.error_bound <= gaps.lower[k]:
            return found
        a, b = gaps.ids[k].tolist()
        return Least(NEAR, float(gaps.distance[k]), float(gaps.error_bound[k]), a, b)

    def _verdict_with_half_spaces(self, state: Floats) -> int:
        """Return the verdict about a state (1, c) of a scene with pairs of half spaces."""
        verdict = self._loops.verdict(state)
        return self._of_half_spaces(state[0]) if verdict == FREE else verdict

    def _of_half_spaces(self, values: Floats) -> int:
        """Return the verdict about values (c,) at which all other pairs are free."""
        assert self._half_spaces is not None
        return FREE if self._half_spaces.at_joints(values).are_beyond(self._margin) else NEAR
