"""A planner that asks about many states until it is ended; then it prints how many a second.

It asks a node's ``evaluate_states``, or its own batch, which takes as much of the cores and
nothing of the node.

    python -m bench.ros.planner (service | batch) SCENE COUNT
"""

from __future__ import annotations

import sys
import time

import numpy as np

from drake_geom_ros.batch import Joints, evaluate
from drake_geom_ros.client import SceneGraphClient
from drake_geom_ros.geometry import SceneGraph
from drake_geom_ros.ros.spinning import StopSignals
from drake_geom_ros.scene_files import load_scene


def main() -> None:
    """Ask, and print the rate."""
    way, scene_file, count = sys.argv[1:]
    scene_graph = SceneGraph()
    joints = Joints.of(load_scene(scene_file, scene_graph))
    context = scene_graph.CreateDefaultContext()
    generator = np.random.default_rng(1)
    states = generator.uniform(joints.lower, joints.upper, (int(count), joints.count))
    asked, start = 0, time.perf_counter()
    with StopSignals() as signals, SceneGraphClient(patience=600.0) as client:
        while not signals.received:
            if way == 'service':
                client.evaluate_states(joints.names, states)
            else:
                evaluate(context, states=states, joints=joints, want='collision')
            asked += len(states)
    print(asked / (time.perf_counter() - start))


if __name__ == '__main__':
    main()
