"""Inverse kinematics of an arm that keeps 2 cm from everything, by SciPy.

The left hand of the demo reaches down between the objects on the table; all 16 joints of both arms
may move.

    python examples/inverse_kinematics.py
"""

import numpy as np
from scipy.optimize import minimize

from drake_geom_ros.batch import Checker, Joints
from drake_geom_ros.geometry import SceneGraph
from drake_geom_ros.optimization import MinimumDistanceLowerBoundConstraint
from drake_geom_ros.scene_files import load_scene

BOUND, OFFSET = 0.02, 0.1  # [m]
HAND = ('left', 'panda_hand')
HOME = np.array([0, -0.7854, 0, -2.3562, 0, 1.5707, 0.7854, 0.04] * 2)  # [rad], [m]
GOAL = np.array([0.1, 0.0, -0.5])  # [m] from where the hand is at home
STEP = 1e-6  # [rad] of central differences


def main():
    """Print how near the hand comes to its goal, and the clearance."""
    scene_graph = SceneGraph()
    loaded = load_scene('scenes/two_pandas.yaml', scene_graph)
    joints = Joints.of(loaded)
    checker = Checker(scene_graph, joints)
    clear = MinimumDistanceLowerBoundConstraint(checker, BOUND, OFFSET)
    place = joints.frame_ids.index(loaded.frames[HAND])

    def hand(states):
        """Return the position (N, 3) of the hand in states (N, 16)."""
        return joints.poses(np.atleast_2d(states))[:, place, :3]

    goal = hand(HOME)[0] + GOAL
    steps = STEP * np.eye(joints.count)

    def cost(q):
        """Return the squared distance to the goal, a little of that to home, and its gradient."""
        off = hand(q)[0] - goal
        J = (hand(q + steps) - hand(q - steps)) / (2.0 * STEP)
        value = off @ off + 1e-3 * np.sum((q - HOME) ** 2)
        return value, 2.0 * J @ off + 2e-3 * (q - HOME)

    found = minimize(
        cost,
        HOME,
        jac=True,
        method='SLSQP',
        bounds=list(zip(joints.lower, joints.upper, strict=True)),
        constraints=[clear.as_scipy()],
        options={'maxiter': 200, 'ftol': 1e-9},
    )
    off = np.linalg.norm(hand(found.x)[0] - goal)
    near = checker.nearest(found.x)
    print(f'{found.message}: the hand is {1000 * off:.1f} mm from its goal')
    print(f'clearance {near.lower_bound:.4f} m, between {near.name_a} and {near.name_b}')
    return near.lower_bound


if __name__ == '__main__':
    main()
