"""Random trajectories of two arms by the service ``check_motion``, beside states 1 ms apart.

The demo's two arms, the node in a process of its own. Each trajectory is asked about once as a
whole, and once as states a millisecond apart by ``evaluate_states``; then it is proved in this
process, and the states are judged here. A verdict of the service is wrong if it is another one
than the proof's, or if a state that certainly touches refutes it.

    ./run exec python -m bench.ros.trajectories [--count 2000] [--apart 0.001]
"""

from __future__ import annotations

import argparse
import time
from collections import Counter
from collections.abc import Callable
from typing import Any

import numpy as np

from bench.motion.trajectories import SAMPLING, random_trajectory, states_of
from bench.ros.many_states import NODE
from bench.ros.processes import Processes
from bench.ros.scenes import two_arms
from bench.ros.whole_motions import loaded_scene
from drake_geom_ros.batch import Checker, Joints, PathChecker, evaluate
from drake_geom_ros.client import SceneGraphClient
from drake_geom_ros.geometry import MotionCheck
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.trajectories import JointSpline, JointTrajectory

ANYWHERE = 1e6  # [rad] of a start: the arms do not move here
STEP = 0.5  # [rad] between points


def timed(ask: Callable[[], Any]) -> tuple[Any, float]:
    """Return an answer, and how long [s] it took."""
    start = time.perf_counter()
    answer = ask()
    return answer, time.perf_counter() - start


def is_other(answer: Any, proof: MotionCheck, edges: Floats) -> bool:
    """Return whether the service answers otherwise than a proof, which has times by points."""
    times = np.interp(proof.times, np.arange(len(edges)), edges)
    same_times = np.allclose(answer.times, times, rtol=0, atol=2e-6)
    return answer.outcome != proof.outcome or not (same_times or proof.outcome == 'clear')


def run(client: SceneGraphClient, count: int, apart: float, seed: int) -> str:
    """Return what was seen, in words."""
    scene_graph, loaded = loaded_scene(two_arms())
    joints = Joints.of(loaded)
    checker = Checker(scene_graph, joints)
    paths = PathChecker(scene_graph, joints, ignore_limits=True)
    rng, tally = np.random.default_rng(seed), Counter[str]()
    names, whole, sampled = list(joints.names), [], []

    def ask(way: JointTrajectory) -> Any:
        return client.check_motion(
            joint_names=names,
            path=way.positions,
            times=way.times,
            velocities=way.velocities,
            accelerations=way.accelerations,
            start_tolerance=ANYWHERE,
            ignore_limits=True,
            allow_stale=True,
        )

    at_rest = np.tile(0.5 * (joints.lower + joints.upper), (2, 1))
    ask(JointTrajectory([0.0, 1.0], at_rest, 0.0 * at_rest))  # what is compiled once
    client.evaluate_states(names, at_rest)
    while len(whole) < count:
        start = rng.uniform(joints.lower, joints.upper)
        if not checker.free(start):
            continue
        way = random_trajectory(rng, start, STEP)
        spline = JointSpline(way)
        _, coarse = states_of(spline, SAMPLING)
        answer, seconds = timed(lambda w=way: ask(w))
        free, others = timed(
            lambda q=coarse: client.evaluate_states(names, q, ignore_limits=True).free
        )
        whole.append(seconds)
        sampled.append(others)
        times, states = states_of(spline, apart)
        least = evaluate(scene_graph, states=states, joints=joints, want='least')
        near = times[least.distance + least.error_bound <= 0.0]
        proof = paths.check_spline(spline)
        tally[answer.outcome] += 1
        tally['other'] += is_other(answer, proof, spline.times)
        tally['refuted'] += answer.outcome == 'clear' and bool(len(near))
        tally['late'] += bool((near < answer.last_free - 1e-9).any())
        tally['missed'] += answer.outcome == 'contact' and bool(np.all(free))
    ratio = np.sum(sampled) / np.sum(whole)
    return (
        f'{count} trajectories of two arms by check_motion: {tally["clear"]} clear, '
        f'{tally["contact"]} in contact, {tally["unknown"]} unknown; otherwise than the proof in '
        f'this process: {tally["other"]}; by states {apart:g} s apart, clear that is not: '
        f'{tally["refuted"]}, late: {tally["late"]}; contacts that states {SAMPLING:g} s apart '
        f'miss: {tally["missed"]}, which by evaluate_states take {ratio:.2f} times as long as '
        'check_motion'
    )


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.split('\n')[0])
    parser.add_argument('--count', type=int, default=2000)
    parser.add_argument('--apart', type=float, default=SAMPLING, help='states that judge [s]')
    parser.add_argument('--seed', type=int, default=0)
    options = parser.parse_args()
    with Processes() as processes:
        processes.start(NODE, scene_file=two_arms().scene_file, max_distance=0.1)
        with SceneGraphClient(patience=600.0) as client:
            print(run(client, options.count, options.apart, options.seed))


if __name__ == '__main__':
    main()
