"""Whole motions by the service ``check_motion``: an edge a call, and poses beside long paths.

The demo's two arms, the node in a process of its own. Edges of 0.5 rad are asked about one a call;
then poses are streamed to the node while nobody asks and while long paths are checked, in turns.

    ./run exec python -m bench.ros.whole_motions [--rows 2000]
"""

from __future__ import annotations

import argparse
import time
from collections import Counter
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.motion.arms import edges_of
from bench.ros.many_states import NODE, timed
from bench.ros.meanwhile import beside, delays
from bench.ros.processes import Processes
from bench.ros.scenes import Played, two_arms
from drake_geom_ros.batch import Checker, Joints, PathChecker
from drake_geom_ros.client import SceneGraphClient
from drake_geom_ros.geometry import SceneGraph
from drake_geom_ros.scene_files import LoadedScene, load_scene

Floats = NDArray[np.float64]
EDGES = 200


def loaded_scene(played: Played) -> tuple[SceneGraph, LoadedScene]:
    """Return the scene as the library has it."""
    scene_graph = SceneGraph()
    return scene_graph, load_scene(played.scene_file, scene_graph)


def edges(client: SceneGraphClient, played: Played) -> None:
    """Print what an edge a call takes, beside the same checks in one process."""
    scene_graph, loaded = loaded_scene(played)
    joints = Joints.of(loaded)
    paths = edges_of(Checker(scene_graph, joints), joints, EDGES, 0.5)
    checker = PathChecker(scene_graph, joints, time_tolerance=1.0)
    ask = partial(client.check_motion, joint_names=joints.names, time_tolerance=1.0)
    ways = {
        'PathChecker': checker.check,
        'check_motion of the node': lambda path: ask(path=path),
    }
    client.ask('get_pose_ages')
    ages = [timed(partial(client.ask, 'get_pose_ages')) for _ in paths]
    print(f'  {"get_pose_ages, to compare":28}mean {np.mean(ages) * 1e3:.2f} ms')
    found = {}
    for name, check in ways.items():
        check(paths[0])  # what is prepared or compiled once
        taken, outcomes = [], []
        for path in paths:
            start = time.perf_counter()
            outcomes.append(check(path).outcome)
            taken.append(time.perf_counter() - start)
        p50, p99 = np.percentile(taken, (50, 99)) * 1e3
        print(f'  {name:28}mean {np.mean(taken) * 1e3:.2f} ms, p50 {p50:.2f}, p99 {p99:.2f}')
        found[name] = outcomes
    one, other = found.values()
    print(f'  {EDGES} edges of 0.5 rad, {dict(Counter(one))}; the two agree: {one == other}')


def long_path(played: Played, rows: int) -> tuple[list[str], Floats]:
    """Return joints, and a path (rows, q) to and fro about where the arms stand."""
    _, loaded = loaded_scene(played)
    joints = Joints.of(loaded)
    standing = {
        f'{robot.name}::{name}': value
        for robot in loaded.robots.values()
        for name, value in robot.configuration.items()
    }
    at = np.array([standing.get(name, 0.02) for name in joints.names])
    swing = 0.02 * np.sin(np.arange(rows))[:, None] * np.ones(joints.count)
    return list(joints.names), np.clip(at + swing, joints.lower, joints.upper)


def ask_on(rows: int, ready: Any, ending: Any) -> None:
    """Ask about long paths, by a process of its own, until it shall end; print how many."""
    names, path = long_path(two_arms(), rows)
    with SceneGraphClient(patience=600.0) as client:
        ask = partial(client.check_motion, joint_names=names, path=path)
        outcome, taken = ask(ignore_start_contacts=True).outcome, []
        ready.set()
        while not ending.is_set():
            start = time.perf_counter()
            ask(ignore_start_contacts=True)
            taken.append(time.perf_counter() - start)
    print(f'  {len(taken)} paths of {rows} rows, {outcome}, {np.mean(taken):.3f} s each')


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.split('\n')[0])
    parser.add_argument('--rows', type=int, default=2000)
    parser.add_argument('--seconds', type=float, default=10.0)
    options = parser.parse_args()
    played = two_arms()
    with Processes() as processes:
        processes.start(NODE, scene_file=played.scene_file, max_distance=0.1)
        with SceneGraphClient(patience=600.0) as client:
            edges(client, played)
        ways = {'check_motion': partial(beside, ask_on, options.rows)}
        delays(played, ways, options.seconds)


if __name__ == '__main__':
    main()
