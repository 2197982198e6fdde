"""Plan an arm's way with OMPL (PyPI: ompl), which asks a node whether each edge is clear.

    ./run node --ros-args -p scene_file:=examples/wires.yaml
    ./run exec python examples/plan_an_arm.py

An edge is asked about in one call: as a motion, certified for all times, or with ``--edges
samples`` at states so close that no joint turns by more than STEP from one to the next. In the end
the path is looked at with a tenth of that step, and each of its edges is proved: between thin
things, those of samples may touch.
"""

import argparse
import math
import time
from itertools import pairwise

import numpy as np
from ompl import base, geometric, util

from drake_geom_ros.client import SceneGraphClient

ARM, FINGERS = [f'panda_joint{k}' for k in range(1, 8)], 'panda_finger_joint1'
NAMES = [f'arm::{name}' for name in (*ARM, FINGERS)]
START = (-0.8, -0.3, 0.0, -2.2, 0.0, 2.0, 0.785)  # [rad]
GOAL = (0.8, -0.3, 0.0, -2.2, 0.0, 2.0, 0.785)  # on the other side of the wires
STEP = 0.05  # [rad] between two states of an edge
OPEN = 0.02  # [m] of a finger
CLEARANCE = 0.005  # [m] that every pair is certified to be farther apart


class Node:
    """What a planner asks a node, and how often."""

    def __init__(self, client):
        self._client, self.calls = client, 0

    def are_free(self, rows):
        """Return whether all states (n, 8) are certified to be free."""
        self.calls += 1
        asked = {'clearance': CLEARANCE, 'stop_at_first': True}
        return self._client.evaluate_states(NAMES, rows, **asked).first_not_free < 0

    def is_sampled(self, start, end, step=STEP):
        """Return whether states on the straight way from (8,) to (8,) are free, the ends too."""
        count = 1 + math.ceil(np.abs(end - start).max() / step)
        return self.are_free(np.linspace(start, end, max(2, count)))

    def is_proved(self, start, end):
        """Return whether the straight way from (8,) to (8,) is clear, for all times."""
        return self.motion([start, end], CLEARANCE, tolerance=1.0).outcome == 'clear'

    def motion(self, path, clearance=0.0, tolerance=1e-6):
        """Return what is true of a whole path (k, 8)."""
        self.calls += 1
        asked = {'min_distance': clearance, 'time_tolerance': tolerance}
        return self._client.check_motion(joint_names=NAMES, path=path, **asked)


class Edges(base.MotionValidator):
    """Whether straight ways between states of OMPL are clear, as something tells of values."""

    def __init__(self, information, is_clear):
        super().__init__(information)
        self._is_clear = is_clear

    def checkMotion(self, start, end):
        """Return whether the way from one state to another is clear."""
        return self._is_clear(values_of(start), values_of(end))


def values_of(state):
    """Return the joint values (8,) of a state of OMPL."""
    return np.array([*(state[k] for k in range(len(ARM))), OPEN])


def plan(client, node, is_clear, seconds):
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
    setup.setStateValidityChecker(lambda state: node.are_free([values_of(state)]))
    validator = Edges(information, is_clear)  # OMPL keeps no reference
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
        if (
            node.motion([[*START, OPEN]] * 2, CLEARANCE).outcome != 'clear'
        ):  # loads what is compiled
            raise SystemExit('the start is not clear')
        began = time.perf_counter()
        is_clear = node.is_proved if options.edges == 'proofs' else node.is_sampled
        path = plan(client, node, is_clear, seconds=20.0)
        print(f'{time.perf_counter() - began:.2f} s, {node.calls} calls')
        if path is None:
            raise SystemExit('no path was found')
        free = all(node.is_sampled(*edge, step=STEP / 10.0) for edge in pairwise(path))
        print(f'{len(path)} waypoints, {"free" if free else "NOT free"} at a tenth of the step')
        outcomes = [node.motion(edge).outcome for edge in pairwise(path)]
        print(f'{outcomes.count("contact")} of {len(outcomes)} edges are in contact')
        print(np.array2string(path, precision=3, suppress_small=True))


if __name__ == '__main__':
    main()
