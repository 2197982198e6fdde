"""Plan an arm's way with OMPL (PyPI: ompl), which asks a node whether each edge is clear.

    ./run node --ros-args -p scene_file:=examples/wires.yaml
    ./run exec python examples/plan_an_arm.py

An edge is asked about in one call: as a motion, certified for all times, or with ``--edges
samples`` at states so close that no joint turns by more than STEP from one to the next. With
``--edges discrete`` OMPL's own validator asks, a call for each of its states. In the end the path
is looked at with a tenth of STEP, and each of its edges is proved: between thin things, those of
states may touch.
"""

import argparse
import math
import time
from itertools import pairwise

import numpy as np
from ompl import base, geometric, util

from drake_geom_ros.client import SceneGraphClient

ROBOT, JOINTS = 'arm', [f'panda_joint{k}' for k in range(1, 8)]
NAMES = [f'{ROBOT}::{name}' for name in JOINTS]
GOAL = (0.8, -0.3, 0.0, -2.2, 0.0, 2.0, 0.785)  # [rad] on the other side of the wires
WAYS = 'proofs', 'samples', 'discrete'
STEP = 0.05  # [rad] between two states of an edge
CLEARANCE = 0.005  # [m] that every pair is certified to be farther apart


class Node:
    """What a planner asks a node about joint values (7,) [rad], and how often."""

    def __init__(self, client):
        self._client, self.calls = client, 0

    def are_free(self, rows):
        """Return whether all states (n, 7) are certified to be free."""
        self.calls += 1
        asked = {'clearance': CLEARANCE, 'stop_at_first': True}
        return self._client.evaluate_states(NAMES, rows, **asked).first_not_free < 0

    def is_sampled(self, start, end, step=STEP):
        """Return whether states on the straight way between two are free, the ends too."""
        count = 1 + math.ceil(np.abs(end - start).max() / step)
        return self.are_free(np.linspace(start, end, max(2, count)))

    def is_proved(self, start, end):
        """Return whether the straight way between two states is clear, for all times."""
        asked = {'min_distance': CLEARANCE, 'time_tolerance': 1.0}  # any contact ends a check
        return self.outcome([start, end], **asked) == 'clear'

    def outcome(self, path, **asked):
        """Return what is true of a path (k, 7) for all times."""
        self.calls += 1
        return self._client.check_motion(joint_names=NAMES, path=path, **asked).outcome


class Edges(base.MotionValidator):
    """Whether straight ways between states of OMPL are clear, as something tells of values."""

    def __init__(self, information, is_clear):
        super().__init__(information)
        self._is_clear = is_clear

    def checkMotion(self, start, end):
        """Return whether the way from one state to another is clear."""
        return self._is_clear(values_of(start), values_of(end))


def values_of(state):
    """Return the joint values (7,) [rad] of a state of OMPL."""
    return np.array([state[k] for k in range(len(JOINTS))])


def plan(client, node, is_clear, seconds):
    """Return a path (n, 7) from where the arm is; None: none was found.

    ``is_clear`` tells of the way between two states; None: OMPL's own validator does.
    """
    joints = {each.name: each for each in client.scene().joints if each.robot == ROBOT}
    space, bounds = base.RealVectorStateSpace(len(JOINTS)), base.RealVectorBounds(len(JOINTS))
    start, end = space.allocState(), space.allocState()
    for k, name in enumerate(JOINTS):
        lower, upper = joints[name].limits
        bounds.setLow(k, lower)
        bounds.setHigh(k, upper)
        start[k], end[k] = joints[name].state.position, GOAL[k]
    space.setBounds(bounds)
    setup = geometric.SimpleSetup(space)
    information = setup.getSpaceInformation()
    setup.setStateValidityChecker(lambda state: node.are_free([values_of(state)]))
    if is_clear is not None:
        edges = Edges(information, is_clear)  # of which OMPL keeps no reference
        information.setMotionValidator(edges)
    setup.setStartAndGoalStates(start, end)
    setup.setPlanner(geometric.RRTConnect(information))
    if not setup.solve(seconds) or not setup.haveExactSolutionPath():
        return None
    return np.array([values_of(state) for state in setup.getSolutionPath().getStates()])


def main():
    """Plan, look at the path again, prove each of its edges, and print it."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--edges', choices=WAYS, default='proofs')
    parser.add_argument('--seed', type=int, default=1)
    options = parser.parse_args()
    util.RNG.setSeed(options.seed)
    util.setLogLevel(util.LogLevel.LOG_WARN)
    with SceneGraphClient() as client:
        node = Node(client)
        node.is_proved(GOAL, GOAL)  # so the node compiles what it is asked now, and not then
        node.are_free([GOAL])
        began = time.perf_counter()
        ways = dict(zip(WAYS, (node.is_proved, node.is_sampled, None), strict=True))
        path = plan(client, node, ways[options.edges], seconds=20.0)
        print(f'{time.perf_counter() - began:.2f} s, {node.calls} calls')
        if path is None:
            raise SystemExit('no path was found')
        free = all(node.is_sampled(*edge, step=STEP / 10.0) for edge in pairwise(path))
        print(f'{len(path)} waypoints, {"free" if free else "NOT free"} at a tenth of the step')
        outcomes = [node.outcome(edge) for edge in pairwise(path)]
        print(f'{outcomes.count("contact")} of {len(outcomes)} edges are in contact')
        print(np.array2string(path, precision=3, suppress_small=True))


if __name__ == '__main__':
    main()
