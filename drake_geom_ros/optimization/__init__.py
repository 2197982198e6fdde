"""Constraints and gradients for those who optimise joint values: SciPy, IPOPT, CasADi.

Names are those of ``pydrake.multibody.inverse_kinematics`` where it has them::

    checker = Checker(scene_graph, joints)
    clear = MinimumDistanceLowerBoundConstraint(checker, 0.02, influence_distance_offset=0.1)
    scipy.optimize.minimize(cost, q0, method='SLSQP', constraints=[clear.as_scipy()])
"""

from drake_geom_ros.optimization.constraint import Constraint
from drake_geom_ros.optimization.ipopt_problem import ipopt_problem
from drake_geom_ros.optimization.minimum_distance import (
    MinimumDistanceLowerBoundConstraint,
    MinimumDistanceUpperBoundConstraint,
)
from drake_geom_ros.optimization.pair_distance import DistanceConstraint
from drake_geom_ros.optimization.path_clearance import (
    PathClearance,
    PathClearanceConstraint,
    path_clearance,
)
from drake_geom_ros.optimization.penalties import (
    ExponentiallySmoothedHingeLoss,
    QuadraticallySmoothedHingeLoss,
)
from drake_geom_ros.optimization.polyhedron import HPolyhedron
from drake_geom_ros.optimization.regions import (
    FreeRegion,
    certified_free_ball,
    certified_free_box,
    free_region,
)
from drake_geom_ros.optimization.spline_clearance import ClampedCubicSpline

__all__ = [
    'Constraint',
    'ipopt_problem',
    'MinimumDistanceLowerBoundConstraint',
    'MinimumDistanceUpperBoundConstraint',
    'DistanceConstraint',
    'ExponentiallySmoothedHingeLoss',
    'QuadraticallySmoothedHingeLoss',
    'PathClearance',
    'PathClearanceConstraint',
    'path_clearance',
    'ClampedCubicSpline',
    'HPolyhedron',
    'FreeRegion',
    'certified_free_ball',
    'certified_free_box',
    'free_region',
]
