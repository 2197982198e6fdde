"""Constraints on the minimum distance of all pairs of geometries, with Drake's smoothing."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from drake_geom_ros.batch import Checker
from drake_geom_ros.geometry import ArgumentError, GeometryError
from drake_geom_ros.geometry.checks import as_number
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.optimization.constraint import Constraint
from drake_geom_ros.optimization.penalties import (
    PenaltyFunction,
    QuadraticallySmoothedHingeLoss,
    smooth_over_maximum,
    smooth_under_maximum,
)


class _MinimumDistanceConstraint(Constraint):
    """Penalties of near pairs, p(d) = phi((d - influence) / (influence - bound)) / phi(-1)."""

    def __init__(
        self,
        checker: Checker,
        bound: float,
        influence_distance_offset: float,
        penalty_function: PenaltyFunction | None,
        limits: tuple[float, float],
    ) -> None:
        if not isinstance(checker, Checker):
            raise ArgumentError(f'checker={checker!r} must be a batch.Checker')
        self._bound, self._offset = as_number(bound), as_number(influence_distance_offset)
        if self._bound is None or not math.isfinite(self._bound):
            raise ArgumentError(f'bound={bound!r} must be a finite number, in metres')
        if self._offset is None or not 0.0 < self._offset < math.inf:
            raise ArgumentError(
                f'influence_distance_offset={influence_distance_offset!r} must be finite and '
                'above 0, in metres: distances are scaled by it'
            )
        self._penalty = penalty_function or QuadraticallySmoothedHingeLoss
        scale, slope = self._penalty(-1.0, True)
        if not scale > 0.0 or slope is None or not slope < 0.0:
            raise ArgumentError(
                f'penalty_function(-1, True) is ({scale}, {slope}); the penalty must be above 0 '
                'there, and its derivative below 0'
            )
        self.checker, self._scale, self._pairs = checker, scale, len(checker.pairs)
        super().__init__(checker.joints.count, limits[0], limits[1])

    def influence_distance(self) -> float:
        """Return the distance [m] below which a pair counts: bound plus offset."""
        assert self._bound is not None
        assert self._offset is not None
        return self._bound + self._offset

    def distance_bound(self) -> float:
        """Return the bound [m] of the minimum distance."""
        assert self._bound is not None
        return self._bound

    def _penalties(self, q: ArrayLike, ends: float) -> tuple[Floats, Floats]:
        """Return the penalties (k,) of near pairs and their derivatives (k, n).

        They are of distance plus ``ends`` times the error bound.
        """
        influence = self.influence_distance()
        near = self.checker.near_pairs(q, influence)
        if near.distance.min(initial=0.0) == -math.inf:
            crossing = near.numbers[near.distance == -math.inf]
            a, b = self.checker.pair_names[crossing[0]]
            raise GeometryError(
                f'{a} and {b} are half spaces that cross, so their distance has no finite value; '
                'filter the pair or replace one of them by a box'
            )
        assert self._offset is not None
        # Beyond the influence distance penalties are 0, as of pairs that are left out.
        scaled = (near.distance + ends * near.error_bound - influence) / self._offset
        terms: list[tuple[float, Any]] = [self._penalty(x, True) for x in scaled.tolist()]
        table = np.array(terms).reshape(len(terms), 2) / self._scale
        return table[:, 0], table[:, 1:] / self._offset * near.gradient


class MinimumDistanceLowerBoundConstraint(_MinimumDistanceConstraint):
    """Keeps every pair of a checker's geometries at least ``bound`` [m] apart.

    The constraint is SmoothOverMax(phi((d_i - influence) / (influence - bound)) / phi(-1)) <= 1,
    as of pydrake's class of this name; d_i are certified lower bounds of the distances. So where
    the output is at most 1, every pair is certified to be at least ``bound`` apart. Pairs beyond
    ``influence_distance`` count as 0.

    Args:
        checker: a ``batch.Checker`` of the scene and its joints; its margin does not enter.
        bound: [m] smallest allowed distance.
        influence_distance_offset: [m] influence distance minus ``bound``. A smaller one makes
            evaluation faster, a larger one lets solvers see obstacles earlier.
        penalty_function: phi; ``QuadraticallySmoothedHingeLoss`` by default.

    Raises:
        ArgumentError: an offset that is not finite and above 0, a bound that is not finite, a
            penalty function that does not fall at -1.

        >>> scene_graph = SceneGraph()
        >>> joints = Joints.of(load_scene('scenes/two_pandas.yaml', scene_graph))
        >>> checker = Checker(scene_graph, joints)
        >>> q = [0, -0.7854, 0, -2.3562, 0, 1.5707, 0.7854, 0.04] * 2
        >>> constraint = MinimumDistanceLowerBoundConstraint(checker, 0.001, 0.1)
        >>> constraint.Jacobian(q).shape
        (1, 16)
    """

    def __init__(
        self,
        checker: Checker,
        bound: float,
        influence_distance_offset: float = 0.01,
        penalty_function: PenaltyFunction | None = None,
    ) -> None:
        """Prepare the constraint; see the class."""
        limits = -math.inf, 1.0
        super().__init__(checker, bound, influence_distance_offset, penalty_function, limits)

    def value_and_jacobian(self, q: ArrayLike) -> tuple[Floats, Floats]:
        """Return the output (1,) and its derivatives (1, n); see ``Constraint``."""
        penalties, gradients = self._penalties(q, -1.0)
        value, weights = smooth_over_maximum(penalties, self._pairs - len(penalties))
        return np.array([value]), (weights @ gradients)[np.newaxis]


class MinimumDistanceUpperBoundConstraint(_MinimumDistanceConstraint):
    """Brings at least one pair of a checker's geometries within ``bound`` [m].

    The constraint is SmoothUnderMax(phi((d_i - influence) / (influence - bound)) / phi(-1)) >= 1,
    as of pydrake's class of this name; d_i are certified upper bounds of the distances. So where
    the output is at least 1, a pair is certified to be within ``bound``. Pairs beyond
    ``influence_distance`` count as 0 and attract nothing, so choose a large offset.

    Args, errors and use are those of ``MinimumDistanceLowerBoundConstraint``.
    """

    def __init__(
        self,
        checker: Checker,
        bound: float,
        influence_distance_offset: float,
        penalty_function: PenaltyFunction | None = None,
    ) -> None:
        """Prepare the constraint; see the class."""
        limits = 1.0, math.inf
        super().__init__(checker, bound, influence_distance_offset, penalty_function, limits)

    def value_and_jacobian(self, q: ArrayLike) -> tuple[Floats, Floats]:
        """Return the output (1,) and its derivatives (1, n); see ``Constraint``."""
        penalties, gradients = self._penalties(q, 1.0)
        value, weights = smooth_under_maximum(penalties, self._pairs - len(penalties))
        return np.array([value]), (weights @ gradients)[np.newaxis]
