"""Collisions of many states of two arms: ``evaluate`` by joints, by poses, and the checker.

    ./run exec python -m bench.costs.collisions [--states 20000] [--rounds 7]

The scene and states are those of ``bench.batches``. Microseconds of processor time a state by one
thread, the least over rounds in turns; by poses includes the poses of the links. All answers of
one margin have to be equal.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from bench.batches.ours import Ours
from drake_geom_ros.batch import Checker, evaluate


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--states', type=int, default=20_000)
    parser.add_argument('--rounds', type=int, default=7)
    options = parser.parse_args()
    ours = Ours()
    states, joints = ours.states(options.states), ours.joints
    checker = Checker(ours.scene_graph, joints, 0.0, ignore_limits=True)

    def by_joints(margin: float) -> Any:
        asked = {'states': states, 'joints': joints, 'max_distance': margin, 'threads': 1}
        return evaluate(ours.scene_graph, want='collision', **asked)

    def by_poses(margin: float) -> Any:
        asked = {'frame_ids': joints.frame_ids, 'poses': joints.poses(states), 'threads': 1}
        return evaluate(ours.scene_graph, want='collision', max_distance=margin, **asked)

    ways: dict[str, Callable[[], Any]] = {
        'Checker.free_each': lambda: ~checker.free_each(states),
        'evaluate by joints, margin 0': lambda: by_joints(0.0),
        'evaluate by poses, margin 0': lambda: by_poses(0.0),
        'evaluate by joints, overlap': lambda: by_joints(np.inf),
        'evaluate by poses, overlap': lambda: by_poses(np.inf),
    }
    answers = {name: way() for name, way in ways.items()}
    for name, answer in answers.items():
        like = 'evaluate by poses, overlap' if 'overlap' in name else 'Checker.free_each'
        assert np.array_equal(answer, answers[like]), name
    least = dict.fromkeys(ways, np.inf)
    for _ in range(options.rounds):
        for name, way in ways.items():
            start = time.process_time()
            way()
            least[name] = min(least[name], time.process_time() - start)
    for name, seconds in least.items():
        of_checker = seconds / least['Checker.free_each']
        print(f'{name:32}{1e6 * seconds / len(states):7.2f} us{of_checker:7.2f} of the checker')


if __name__ == '__main__':
    main()
