"""What the first answer costs in a process that has nothing to compile.

    ./run exec python -m bench.costs.warm_start [--tree FOLDER] [--runs 5] [--node]

Processor seconds (user and system) of whole processes, the least of some runs of all in turn. The
ratio is to the import of NumPy in the same runs, which says how busy the machine was.
``--tree`` measures the package in another checkout, ``--node`` also a node up to its configuration
and the memory of the process that takes what sensors see.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAIR = """
from drake_geom_ros.geometry import *
from drake_geom_ros.math import RigidTransform
scene_graph, X_WFs = SceneGraph(), FramePoseVector()
source = scene_graph.RegisterSource('boxes')
for k in range(2):
    frame = scene_graph.RegisterFrame(source, GeometryFrame(str(k)))
    box = GeometryInstance(RigidTransform(), Box(1, 1, 1), str(k))
    box.set_proximity_properties(ProximityProperties())
    scene_graph.RegisterGeometry(source, frame, box)
    X_WFs.set_value(frame, RigidTransform([3.0 * k, 0, 0]))
context = scene_graph.CreateDefaultContext()
context.UpdateFramePoses(X_WFs)
query = scene_graph.get_query_output_port().Eval(context)
assert len(query.ComputeSignedDistancePairwiseClosestPoints(10.0))
"""
ARMS = """
from drake_geom_ros.geometry import SceneGraph
from drake_geom_ros.scene_files import load_scene
scene_graph = SceneGraph()
load_scene('scenes/two_pandas.yaml', scene_graph)
query = scene_graph.get_query_output_port().Eval(scene_graph.CreateDefaultContext())
query.ComputeSignedDistancePairwiseClosestPoints(0.3)
"""
QUERY = """
import os
import sys
from drake_geom_ros.programs import drake_geom_ros
sys.argv[1:] = ['query', 'scenes/two_pandas.yaml', '--max-distance', '0.3', '--out', os.devnull]
sys.exit(drake_geom_ros())
"""
NODE = """
import rclpy
from drake_geom_ros.ros.scene_graph_node import SceneGraphNode
rclpy.init(args=['--ros-args', '-p', 'scene_file:=scenes/two_pandas.yaml'])
node = SceneGraphNode()
assert node.trigger_configure().name == 'SUCCESS'
import os
os._exit(0)
"""
SENSORS = """
import os
import rclpy
from rclpy.node import Node
from drake_geom_ros.ros.sensing import __main__ as sensing
sensing.compile_passes()
sensing.compile_looking_past()
rclpy.init()
node = Node('sensors')
sizes = [line.split() for line in open('/proc/self/smaps_rollup')]
sizes = {row[0]: int(row[1]) / 1e3 for row in sizes if row[-1] == 'kB'}
own = sizes['Private_Clean:'] + sizes['Private_Dirty:']
print(f'{sizes["Rss:"]:.0f} MB resident, of these {own:.0f} MB its own')
os._exit(0)
"""
STEPS = {
    'python': '',
    'import numpy': 'import numpy',
    'import numba': 'import numba',
    'import drake_geom_ros.geometry': 'import drake_geom_ros.geometry',
    'first answer of two boxes': PAIR,
    'first answer of two arms': ARMS,
    'drake_geom_ros query of two arms': QUERY,
}
WITH_NODE = {'node of two arms configured': NODE, 'process of sensors ready': SENSORS}


def processor_time(code: str, environment: Mapping[str, str], folder: Path) -> tuple[float, str]:
    """Return the processor seconds of a process that runs some code, and what it prints."""
    process = subprocess.Popen(
        [sys.executable, '-c', code],
        env=environment,
        cwd=folder,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    printed = process.stdout.read()
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise SystemExit(f'this ended with {process.returncode}:\n{code}')
    return usage.ru_utime + usage.ru_stime, printed.strip()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--tree', type=Path, default=ROOT, help='the checkout to measure')
    parser.add_argument('--runs', type=int, default=5)
    parser.add_argument('--node', action='store_true', help='also the node and its helper')
    options = parser.parse_args()
    paths = [str(options.tree.resolve()), os.environ.get('PYTHONPATH', '')]
    environment = {**os.environ, 'PYTHONPATH': os.pathsep.join(filter(None, paths))}
    steps = STEPS | (WITH_NODE if options.node else {})
    for code in steps.values():  # compiles what is missing
        processor_time(code, environment, options.tree)
    least = dict.fromkeys(steps, float('inf'))
    notes = dict.fromkeys(steps, '')
    for _ in range(options.runs):
        for name, code in steps.items():
            seconds, notes[name] = processor_time(code, environment, options.tree)
            least[name] = min(least[name], seconds)
    print('| step | processor time [s] | times `import numpy` (below is better) | |')
    print('|---|---|---|---|')
    for name, seconds in least.items():
        print(
            f'| {name} | {seconds:.2f} | {seconds / least["import numpy"]:.1f} | {notes[name]} |'
        )


if __name__ == '__main__':
    main()
