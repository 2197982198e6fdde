"""``DistanceConstraint``: the distance of one pair of geometries within a range."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from drake_geom_ros.batch import Checker
from drake_geom_ros.geometry import ArgumentError, GeometryError, GeometryId
from drake_geom_ros.geometry.checks import as_number
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.optimization.constraint import Constraint


class DistanceConstraint(Constraint):
    """Keeps the signed distance of a pair within [``distance_lower``, ``distance_upper``] [m].

    Names and meaning are those of pydrake's class. The output is the certified lower bound of the
    distance where there is no upper limit, the certified upper bound where there is no lower one,
    and the distance where there are both.

    Args:
        checker: a ``batch.Checker`` of the scene and its joints.
        geometry_pair: two ids of geometries, which no filter leaves out.
        distance_lower: [m] smallest allowed distance, or minus infinity.
        distance_upper: [m] largest allowed distance, or infinity.

    Raises:
        ArgumentError: a pair that the checker does not have, or limits that are NaN or reversed.

        >>> scene_graph = SceneGraph()
        >>> joints = Joints.of(load_scene('scenes/two_pandas.yaml', scene_graph))
        >>> checker = Checker(scene_graph, joints)
        >>> q = [0, -0.7854, 0, -2.3562, 0, 1.5707, 0.7854, 0.04] * 2
        >>> pair = checker.pairs[0].tolist()
        >>> DistanceConstraint(checker, pair, 0.0, 10.0).CheckSatisfied(q)
        True
    """

    def __init__(
        self,
        checker: Checker,
        geometry_pair: Sequence[GeometryId | int],
        distance_lower: float,
        distance_upper: float,
    ) -> None:
        """Prepare the constraint; see the class."""
        if not isinstance(checker, Checker):
            raise ArgumentError(f'checker={checker!r} must be a batch.Checker')
        limits = as_number(distance_lower), as_number(distance_upper)
        if None in limits or not limits[0] <= limits[1]:  # type: ignore[operator]
            raise ArgumentError(
                f'distance_lower={distance_lower!r} must be at most '
                f'distance_upper={distance_upper!r}, both in metres'
            )
        self.checker, self._pair = checker, [list(geometry_pair)]
        checker.distances_and_gradients(
            np.clip(0.0, checker.joints.lower, checker.joints.upper), self._pair
        )
        super().__init__(checker.joints.count, limits[0] or 0.0, limits[1] or 0.0)

    def value_and_jacobian(self, q: ArrayLike) -> tuple[Floats, Floats]:
        """Return the output (1,) and its derivatives (1, n); see ``Constraint``."""
        distance, error_bound, gradient = self._answer(q)
        if self._upper[0] == math.inf:
            distance = distance - error_bound
        elif self._lower[0] == -math.inf:
            distance = distance + error_bound
        return distance, gradient

    def CheckSatisfied(self, x: ArrayLike, tol: float = 1.0 / 2**20) -> bool:
        """Return whether the distance is certified to be within the limits, up to ``tol`` [m]."""
        distance, error_bound, _ = self._answer(x)
        above = distance - error_bound >= self._lower - tol
        return bool(above & (distance + error_bound <= self._upper + tol))

    def _answer(self, q: ArrayLike) -> tuple[Floats, Floats, Floats]:
        answer = self.checker.distances_and_gradients(q, self._pair)
        if answer.distance.ndim != 1:
            raise ArgumentError(f'q has the shape {np.shape(q)}; it must be ({self._columns},)')
        if answer.distance[0] == -math.inf:
            raise GeometryError(
                'the pair are half spaces that cross, so their distance has no finite value'
            )
        return answer.distance, answer.error_bound, answer.gradient
