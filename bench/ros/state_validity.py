"""State validity by MoveIt's service type, beside MoveIt's own figures as they were published.

MoveIt's comparison of its collision checkers (moveit/moveit, issue 1427, 2019) counts the checks
of a Panda a second: of itself, and among 100 meshes placed at random of which none, or two, touch
it. Those are calls of its library on another machine. The same cases here, with meshes of 320
triangles: by calls of ours in one process, and by the service of a node, asked from another
process one state at a time with all contacts. So only the order of size can be compared.

    ./run exec python -m bench.ros.state_validity [--calls 2000]
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import rclpy
import trimesh
from moveit_msgs.srv import GetStateValidity
from rclpy.node import Node

from bench.ros.processes import Processes
from drake_geom_ros.batch import Checker, Joints
from drake_geom_ros.geometry import SceneGraph
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.scene_files import load_scene

NODE = 'drake_geom_ros.ros.scene_graph_node'
PANDA = 'package://example-robot-data/robots/panda_description'
MESHES, RADIUS, REACH = 100, 0.05, 1.0  # their number, size [m], and how far off they may be [m]
JITTER = 1e-3  # [rad] so that no answer is of the state before


class Case(NamedTuple):
    """A case of MoveIt's comparison, with the checks a second that it published."""

    title: str
    meshes: int
    touching: int
    fcl: int
    bullet: int


CASES = (
    Case('the robot alone, no contact', 0, 0, 125_000, 90_000),
    Case('100 meshes, none touches', MESHES, 0, 21_000, 600),
    Case('100 meshes, two touch', MESHES, 2, 1_700, 500),
)


def robot_text() -> str:
    """Return the text of a scene of a Panda that stands ready."""
    files = f'urdf: {PANDA}/urdf/panda_collision.urdf, srdf: {PANDA}/srdf/panda.srdf'
    robot = f'{{name: panda, {files}, configuration: default, pose: {{}}}}'
    return f'sources: [clutter]\nrobots:\n- {robot}\n'


def places(case: Case) -> Floats:
    """Return where the meshes of a case stand (n, 3) [m]: around the robot, or in its surface."""
    scene_graph = SceneGraph()
    load_scene(robot_text(), scene_graph, format='yaml')
    query = scene_graph.get_query_output_port().Eval(scene_graph.CreateDefaultContext())
    rng = np.random.default_rng(7)
    points = rng.uniform([-REACH, -REACH, 0.0], [REACH, REACH, REACH], size=(4000, 3))
    found = query.ComputeSignedDistanceToPoint(points)
    nearest = np.full(len(points), np.inf)
    np.minimum.at(nearest, found.point_index, found.distance)
    clear = points[nearest > 1.2 * RADIUS][: case.meshes - case.touching]
    touching = points[np.abs(nearest) < 0.5 * RADIUS][: case.touching]
    return np.vstack((clear, touching))


def write_scene(folder: Path, case: Case) -> Path:
    """Write the scene of a case, and return its file."""
    trimesh.creation.icosphere(subdivisions=2, radius=RADIUS).export(folder / 'ball.obj')
    lines = ['geometries:'] if case.meshes else []
    for k, place in enumerate(places(case).tolist()):
        shape = '{type: mesh, uri: ball.obj}'
        lines.append(
            f'- {{name: mesh_{k}, source: clutter, shape: {shape}, pose: {{position: {place}}}}}'
        )
    file = folder / 'scene.yaml'
    file.write_text(robot_text() + '\n'.join(lines) + '\n')
    return file


def rate_of(ask: Callable[[Floats], Any], states: Floats) -> float:
    """Return the calls a second, one after the other."""
    for state in states[:20]:  # what is prepared or compiled once
        ask(state)
    start = time.perf_counter()
    for state in states:
        ask(state)
    return len(states) / (time.perf_counter() - start)


def asker(node: Node, names: Sequence[str]) -> Callable[[Floats], GetStateValidity.Response]:
    """Return what asks a node about joint values."""
    client = node.create_client(GetStateValidity, '/scene_graph/check_state_validity')
    client.wait_for_service()
    request = GetStateValidity.Request()
    request.robot_state.joint_state.name = list(names)

    def ask(state: Floats) -> GetStateValidity.Response:
        request.robot_state.joint_state.position = state.tolist()
        future = client.call_async(request)
        rclpy.spin_until_future_complete(node, future)
        return future.result()

    return ask


def measure(case: Case, calls: int) -> str:
    """Return the row of a case."""
    with tempfile.TemporaryDirectory() as folder, Processes() as processes:
        file = write_scene(Path(folder), case)
        scene_graph = SceneGraph()
        loaded = load_scene(file, scene_graph)
        joints = Joints.of(loaded)
        standing = [
            loaded.robots['panda'].configuration.get(n, 0.0)
            for n in (name.partition('::')[2] for name in joints.names)
        ]
        jitter = np.random.default_rng(0).uniform(-JITTER, JITTER, (calls, joints.count))
        states = np.clip(standing + jitter, joints.lower, joints.upper)
        checker = Checker(scene_graph, joints)
        library = rate_of(checker.free, states)
        processes.start(NODE, scene_file=file, use_planning_scene=True)
        node = Node('asker')
        ask = asker(node, joints.names)
        service, found = rate_of(ask, states), ask(states[0])
        node.destroy_node()
        assert found.valid == checker.free(states[0]), 'the two disagree'
        assert len({c.contact_body_2 + c.contact_body_1 for c in found.contacts}) >= case.touching
    return (
        f'{case.title:32}{len(found.contacts):12}{service:12.0f}{library:12.0f}'
        f'{case.fcl:12}{case.bullet:12}'
    )


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.split('\n')[0])
    parser.add_argument('--calls', type=int, default=2000)
    options = parser.parse_args()
    rclpy.init()
    columns = 'contacts', 'service', 'library', 'FCL', 'Bullet'
    titles = ''.join(f'{name:>12}' for name in columns)
    print(f'{"checks a second: ours, and MoveIt":32}{titles}')
    for case in CASES:
        print(measure(case, options.calls))
    rclpy.shutdown()


if __name__ == '__main__':
    main()
