"""Plan an arm's way with OMPL (PyPI: ompl), which asks a node whether each edge is clear.

    ./run node --ros-args -p scene_file:=examples/wires.yaml
    ./run exec python examples/plan_an_arm.py

An edge is asked about as one motion, certified for all times. With ``--edges samples`` OMPL's own
validator tests states instead, a hundredth of the space's extent from one to the next. In the end
each edge of the path that is found is proved: between thin things, those of samples may touch.
"""

import argparse
import time
from itertools import pairwise

import numpy as np
from ompl import base, geometric, util

from drake_geom_ros.client import SceneGraphClient

ARM, FINGERS = [f'panda_joint{k}' for k in range(1, 8)], 'panda_finger_joint1'
NAMES = [f'arm::{name}' for name in (*ARM, FINGERS)]
START = (-0.8, -0.3, 0.0, -2.2, 0.0, 2.0, 0.785)  # [rad]
GOAL = (0.8, -0.3, 0.0, -2.2, 0.0, 2.0, 0.785)  # on the other side of the wires
OPEN = 0.02  # [m] of a finger
CLEARANCE = 0.005  # [m] that every pair is certified to be farther apart


class Node:
    """What a planner asks a node, and how often."""

    def __init__(self, client):
        self._client, self.calls = client, 0

    def is_free(self, state):
        """Return whether a state of OMPL is free."""
        self.calls += 1
        return self._client.evaluate_states(NAMES, [values_of(state)], clearance=CLEARANCE).free[0]

    def motion(self, path, clearance=0.0, tolerance=1e-6):
        """Return what is true of a whole path (k, 8)."""
        self.calls += 1
        asked = {'min_distance': clearance, 'time_tolerance': tolerance}
        return self._client.check_motion(joint_names=NAMES, path=path, **asked)


class Proofs(base.MotionValidator):
    """Whether straight ways between configurations are clear, for all times."""

    def __init__(self, information, node):
        super().__init__(information)
        self._node = node

    def checkMotion(self, start, end):
        """Return whether the way from one state of OMPL to another is certified to be clear."""
        path = values_of(start), values_of(end)
        return self._node.motion(path, CLEARANCE, tolerance=1.0).outcome == 'clear'


def values_of(state):
    """Return the joint values (8,) of a state of OMPL."""
    return np.array([*(state[k] for k in range(len(ARM))), OPEN])


def plan(client, node, proves, seconds):
    """Return a path (n, 8); None: none was found."""
    limits = {joint.name: joint.limits for joint in client.scene().joints}
    space, bounds = base.RealVectorStateSpace(len(ARM)), base.RealVectorBounds(len(ARM))
    start, end = space.allocState(), space.allocState()
    for k, name in enumerate(ARM):
        bounds.setLow(k, limits[name][0])
        bounds.setHigh(k, limits[name][1])
        start[k], end[k] = START[k], GOAL[k]
    space.setBounds(bounds)
    setup = geometric.SimpleSetup(space)
    information = setup.getSpaceInformation()
    setup.setStateValidityChecker(lambda state: bool(node.is_free(state)))
    if proves:
        validator = Proofs(information, node)
        information.setMotionValidator(validator)
    setup.setStartAndGoalStates(start, end)
    setup.setPlanner(geometric.RRTConnect(information))
    if not setup.solve(seconds) or not setup.haveExactSolutionPath():
        return None
    return np.array([values_of(state) for state in setup.getSolutionPath().getStates()])


def main():
    """Plan, prove each edge of the way, and print it."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--edges', choices=('proofs', 'samples'), default='proofs')
    parser.add_argument('--seed', type=int, default=1)
    options = parser.parse_args()
    util.RNG.setSeed(options.seed)
    util.setLogLevel(util.LogLevel.LOG_WARN)
    with SceneGraphClient() as client:
        node = Node(client)
        if node.motion([[*START, OPEN]], CLEARANCE).outcome != 'clear':  # loads what is compiled
            raise SystemExit('the start is not clear')
        began = time.perf_counter()
        path = plan(client, node, options.edges == 'proofs', seconds=20.0)
        print(f'{time.perf_counter() - began:.2f} s, {node.calls} calls')
        if path is None:
            raise SystemExit('no path was found')
        outcomes = [node.motion(edge).outcome for edge in pairwise(path)]
        print(f'{outcomes.count("contact")} of {len(outcomes)} edges are in contact')
        print(np.array2string(path, precision=3, suppress_small=True))


if __name__ == '__main__':
    main()
