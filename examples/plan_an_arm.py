"""Plan an arm's way with OMPL (PyPI: ompl), which asks a node whether each edge is free.

    ./run node --ros-args -p scene_file:=scenes/two_pandas.yaml
    ./run exec python examples/plan_an_arm.py

An edge is asked about in one call, at states so close that no joint turns by more than STEP from
one to the next; the path that is found is checked again at ten times as many.
"""

import argparse
import math
from itertools import pairwise

import numpy as np
from ompl import base, geometric, util

from drake_geom_ros.client import SceneGraphClient

ROBOT, JOINTS = 'left', [f'panda_joint{k}' for k in range(1, 8)]
GOAL = (1.1, 0.5, 0.0, -1.6, 0.0, 2.3, 0.785)  # [rad] over the far side of the table
STEP = 0.05  # [rad] between two states of an edge
CLEARANCE = 0.005  # [m] that every pair is certified to be farther apart


class Edges(base.MotionValidator):
    """Whether the straight ways between configurations are free, as a node says."""

    def __init__(self, information, client):
        super().__init__(information)
        self._client = client
        self._names = [f'{ROBOT}::{name}' for name in JOINTS]
        self.calls = self.states = 0

    def are_free(self, start, end, step=STEP):
        """Return whether all states on the way (7,) to (7,) are free, the ends too."""
        count = 1 + math.ceil(np.abs(end - start).max() / step)
        rows = np.linspace(start, end, max(2, count))
        found = self._client.evaluate_states(
            self._names, rows, clearance=CLEARANCE, stop_at_first=True
        )
        self.calls, self.states = self.calls + 1, self.states + len(found.free)
        return found.first_not_free < 0

    def checkMotion(self, start, end):
        """Return whether the way from one state of OMPL to another is free."""
        return self.are_free(values_of(start), values_of(end))


def values_of(state):
    """Return the joint values (7,) [rad] of a state of OMPL."""
    return np.array([state[k] for k in range(len(JOINTS))])


def plan(client, goal, seconds):
    """Return a free path (n, 7) from where the arm is, and what its edges cost; None: no path."""
    joints = {each.name: each for each in client.scene().joints if each.robot == ROBOT}
    space, bounds = base.RealVectorStateSpace(len(JOINTS)), base.RealVectorBounds(len(JOINTS))
    start, end = space.allocState(), space.allocState()
    for k, name in enumerate(JOINTS):
        lower, upper = joints[name].limits
        bounds.setLow(k, lower)
        bounds.setHigh(k, upper)
        start[k], end[k] = joints[name].state.position, goal[k]
    space.setBounds(bounds)
    setup = geometric.SimpleSetup(space)
    information = setup.getSpaceInformation()
    edges = Edges(information, client)
    information.setMotionValidator(edges)
    setup.setStateValidityChecker(lambda state: edges.are_free(*[values_of(state)] * 2))
    setup.setStartAndGoalStates(start, end)
    setup.setPlanner(geometric.RRTConnect(information))
    if not setup.solve(seconds) or not setup.haveExactSolutionPath():
        return None, edges
    setup.simplifySolution(1.0)
    path = setup.getSolutionPath()
    return np.array([values_of(state) for state in path.getStates()]), edges


def main():
    """Plan, check again, and print the way."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--seconds', type=float, default=20.0, help='for the search')
    parser.add_argument('--seed', type=int, default=1)
    options = parser.parse_args()
    util.RNG.setSeed(options.seed)
    util.setLogLevel(util.LogLevel.LOG_WARN)
    with SceneGraphClient() as client:
        path, edges = plan(client, GOAL, options.seconds)
        print(f'{edges.calls} calls about {edges.states} states')
        if path is None:
            raise SystemExit('no path was found')
        free = all(edges.are_free(*way, step=STEP / 10.0) for way in pairwise(path))
        print(f'{len(path)} waypoints, {"free" if free else "NOT free"} at a tenth of the step')
        print(np.array2string(path, precision=3, suppress_small=True))


if __name__ == '__main__':
    main()
