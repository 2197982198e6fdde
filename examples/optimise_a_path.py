"""Optimise a path of an arm from a collision to a proof that it is clear.

The left arm of the demo goes straight in joint space, through the table: 15 way points with a
clearance of -0.090 m. SciPy shortens the path while bounds of the clearance, certified between way
points, too, stay above 5 mm. ``check_path`` then proves the result again.

    python examples/optimise_a_path.py [ITERATIONS]
"""

import sys

import numpy as np
from scipy.optimize import minimize

from drake_geom_ros.batch import Checker, Joints, check_path
from drake_geom_ros.geometry import SceneGraph
from drake_geom_ros.optimization import PathClearanceConstraint, path_clearance
from drake_geom_ros.scene_files import load_scene

WAYPOINTS, PIECES, CLEARANCE = 15, 8, 0.005  # [-], [-], [m]
START = np.array([-2.664, -0.395, -2.4353, -2.2542, -1.2961, 1.9941, 0.7756])  # [rad]
END = np.array([-0.4967, 0.161, 0.0773, -2.2452, -1.485, 1.8856, -0.3575])


def length(x):
    """Return the sum of the squares of all steps, and its gradient."""
    steps = np.diff(x.reshape(WAYPOINTS, -1), axis=0)
    gradient = np.zeros((WAYPOINTS, steps.shape[1]))
    gradient[1:] += 2.0 * steps
    gradient[:-1] -= 2.0 * steps
    return np.sum(steps**2), gradient.ravel()


def main():
    """Print the clearance before and after, and the proof."""
    iterations = int(sys.argv[1]) if len(sys.argv) > 1 else 100
    scene_graph = SceneGraph()
    loaded = load_scene('scenes/two_pandas.yaml', scene_graph)
    joints = Joints.of(loaded, [f'left::panda_joint{k}' for k in range(1, 8)])
    checker = Checker(scene_graph, joints)
    straight = np.linspace(START, END, WAYPOINTS)
    print(f'straight: clearance {path_clearance(checker, straight).clearance.min():.3f} m')

    limits = list(zip(joints.lower, joints.upper, strict=True))
    ends = [[(value, value) for value in q] for q in (START, END)]
    constraint = PathClearanceConstraint(checker, WAYPOINTS, CLEARANCE, PIECES)
    found = minimize(
        length,
        straight.ravel(),
        jac=True,
        method='SLSQP',
        bounds=[*ends[0], *limits * (WAYPOINTS - 2), *ends[1]],
        constraints=[constraint.as_scipy()],
        options={'maxiter': iterations, 'ftol': 1e-4},
    )
    path = np.clip(found.x.reshape(WAYPOINTS, -1), joints.lower, joints.upper)
    bounds = path_clearance(checker, path, PIECES)
    print(f'optimised in {found.nit} iterations: certified {bounds.least:.4f} m on the whole way')
    check = check_path(scene_graph, joints, path, bound_tolerance=1e-3)
    print(f'check_path: {check.outcome}, no pair nearer than {check.lower_bound:.4f} m')
    return bounds.least, check


if __name__ == '__main__':
    main()
