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

ROBOT, JOINTS = 'arm', [f'panda_joint{k}' for k in range(1, 8)]
NAMES = [f'{ROBOT}::{name}' for name in JOINTS]
GOAL = (0.8, -0.3, 0.0, -2.2, 0.0, 2.0, 0.785)  # [rad] on the other side of the wires
CLEARANCE = 0.005  # [m] that every pair is certified to be farther apart


class Proofs(base.MotionValidator):
    """Whether straight ways between configurations are clear, for all times."""

    def __init__(self, information, client):
        super().__init__(information)
        self._client = client

    def checkMotion(self, start, end):
        """Return whether the way from one state of OMPL to another is certified to be clear."""
        asked = {'min_distance': CLEARANCE, 'time_tolerance': 1.0}  # any contact ends a check
        path = values_of(start), values_of(end)
        return self._client.check_motion(joint_names=NAMES, path=path, **asked).outcome == 'clear'


def values_of(state):
    """Return the joint values (7,) [rad] of a state of OMPL."""
    return np.array([state[k] for k in range(len(JOINTS))])


def plan(client, proves, seconds):
    """Return a path (n, 7) from where the arm is; None: none was found."""
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

    def is_free(state):
        return bool(client.evaluate_states(NAMES, [values_of(state)], clearance=CLEARANCE).free[0])

    setup.setStateValidityChecker(is_free)
    if proves:
        validator = Proofs(information, client)
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
        client.check_motion(joint_names=NAMES, path=[GOAL, GOAL])  # compiles what checks run
        began = time.perf_counter()
        path = plan(client, options.edges == 'proofs', seconds=20.0)
        print(f'{time.perf_counter() - began:.2f} s')
        if path is None:
            raise SystemExit('no path was found')
        edges = [client.check_motion(joint_names=NAMES, path=edge) for edge in pairwise(path)]
        touching = sum(edge.outcome == 'contact' for edge in edges)
        print(f'{touching} of {len(edges)} edges are in contact')
        print(np.array2string(path, precision=3, suppress_small=True))


if __name__ == '__main__':
    main()
