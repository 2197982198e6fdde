"""Plan an arm's way with OMPL (PyPI: ompl): with its own test of samples, and with proofs.

    ./run exec python examples/plan_with_proof.py --runs 10

OMPL tests the states of an edge at a hundredth of the space's extent from one another. ``Proofs``
asks whether the whole edge is clear, certified. Both plan the same ways, of an arm that carries a
thin rod past wires, without a node; then the edges of all paths are proved.
"""

import argparse
import time
from pathlib import Path

import numpy as np
from ompl import base, geometric, util

from drake_geom_ros.batch import Checker, Joints, PathChecker
from drake_geom_ros.geometry import SceneGraph
from drake_geom_ros.scene_files import load_scene

SCENE = Path(__file__).parent / 'wires.yaml'
NAMES = [f'arm::panda_joint{k}' for k in range(1, 8)]
GOAL = np.array([0.8, -0.3, 0.0, -2.2, 0.0, 2.0, 0.785])  # [rad] on the other side of the wires
CLEARANCE = 0.005  # [m] that every pair is certified to be farther apart


class Proofs(base.MotionValidator):
    """Whether straight ways between configurations are clear, for all times."""

    def __init__(self, information, checker):
        super().__init__(information)
        self._checker = checker

    def checkMotion(self, start, end):
        """Return whether the way from one state of OMPL to another is certified to be clear."""
        return self._checker.check([values_of(start), values_of(end)]).outcome == 'clear'


def values_of(state):
    """Return the joint values (7,) [rad] of a state of OMPL."""
    return np.array([state[k] for k in range(len(NAMES))])


class Planner:
    """Plans from where the arm stands in the scene file."""

    def __init__(self):
        scene_graph = SceneGraph()
        loaded = load_scene(SCENE, scene_graph)
        self.joints = Joints.of(loaded, NAMES)
        standing = loaded.robots['arm'].configuration
        self.start = np.array([standing.get(name.split('::')[1], 0.0) for name in NAMES])
        self._free = Checker(scene_graph, self.joints, margin=CLEARANCE)
        # Any contact ends a check: a planner asks for no more.
        self.near = PathChecker(scene_graph, self.joints, CLEARANCE, time_tolerance=1.0)
        self.touches = PathChecker(scene_graph, self.joints)

    def plan(self, proves, seconds):
        """Return a path (n, 7), None where none was found, and how long it took [s]."""
        space, bounds = base.RealVectorStateSpace(len(NAMES)), base.RealVectorBounds(len(NAMES))
        start, end = space.allocState(), space.allocState()
        for k in range(len(NAMES)):
            bounds.setLow(k, self.joints.lower[k])
            bounds.setHigh(k, self.joints.upper[k])
            start[k], end[k] = self.start[k], GOAL[k]
        space.setBounds(bounds)
        setup = geometric.SimpleSetup(space)
        information = setup.getSpaceInformation()
        setup.setStateValidityChecker(lambda state: bool(self._free.free(values_of(state))))
        if proves:
            validator = Proofs(information, self.near)
            information.setMotionValidator(validator)
        setup.setStartAndGoalStates(start, end)
        setup.setPlanner(geometric.RRTConnect(information))
        began = time.perf_counter()
        found = setup.solve(seconds) and setup.haveExactSolutionPath()
        took = time.perf_counter() - began
        if not found:
            return None, took
        return np.array([values_of(s) for s in setup.getSolutionPath().getStates()]), took


def main():
    """Plan with both, prove the edges of all paths, and print what was found."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--runs', type=int, default=10)
    parser.add_argument('--seconds', type=float, default=20.0, help='for a search')
    parser.add_argument('--seed', type=int, default=1)
    options = parser.parse_args()
    util.RNG.setSeed(options.seed)
    util.setLogLevel(util.LogLevel.LOG_WARN)
    planner = Planner()
    for name, proves in (('samples', False), ('proofs', True)):
        planner.plan(proves, options.seconds)  # what is compiled and prepared once
        found = [planner.plan(proves, options.seconds) for _ in range(options.runs)]
        paths = [path for path, _ in found if path is not None]
        edges = [path[k : k + 2] for path in paths for k in range(len(path) - 1)]
        touching = sum(planner.touches.check(edge).outcome == 'contact' for edge in edges)
        hit = sum(planner.touches.check(path).outcome == 'contact' for path in paths)
        near = sum(planner.near.check(edge).outcome != 'clear' for edge in edges)
        took = np.array([seconds for _, seconds in found])
        print(
            f'{name}: {len(paths)} of {options.runs} found, mean '
            f'{took.mean():.3f} s, median {np.median(took):.3f} s; {touching} of {len(edges)} '
            f'edges in contact, {near} nearer than {1000 * CLEARANCE:g} mm; {hit} paths in contact'
        )


if __name__ == '__main__':
    main()
