"""How late results are by the way in which a robot's motion reaches the node, in one run.

Two arms, in turns: poses of all links on ``~/frame_poses``; joint states alone; joint states to a
state publisher, whose TF the node hears. Each way has a node of its own, and only one is used at
a time. ``robot_state_publisher`` is no package of PyPI: where it is not installed, one in Python
that does the same stands in for it (``state_publisher``). With ``--without-tf`` the last way is
left out: at 500 Hz three nodes and a publisher are more than two cores do.

    ./run exec python -m bench.ros.joint_routes [--rates 100 500] [--seconds 5] [--without-tf]
"""

from __future__ import annotations

import argparse
import time

import numpy as np
import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from sensor_msgs.msg import JointState

from bench.ros.processes import Processes
from bench.ros.routes import LAST_ANSWERS, POSES, WARM_UP, Route, stream
from bench.ros.scenes import Played, two_arms
from drake_geom_ros.scene_files import read_scene
from drake_geom_ros.trajectories.motion import Motion
from drake_geom_ros.trajectories.motion_file import load_motion

NODE = 'drake_geom_ros.ros.scene_graph_node'
TURNS = 3


class JointRoute(Route):
    """A node that hears of joints: a publisher of their values, and when each answer came."""

    def __init__(self, node: Node, server: str, topic: str, motion: Motion) -> None:
        super().__init__(node, server)
        node.destroy_publisher(self.publisher)
        self.publisher = node.create_publisher(JointState, topic, POSES)
        self._motion = motion
        robots = motion.robots.items()
        self.names = [f'{name}::{j}' for name, r in robots for j in r.kinematics.joint_names]

    def message(self, seconds: float) -> JointState:
        """Return the joint values at a time of the motion."""
        time_of = seconds % self._motion.duration
        values = [robot.joint_values.value(time_of) for robot in self._motion.robots.values()]
        return JointState(name=self.names, position=np.concatenate(values).tolist())


def stream_joints(
    executor: SingleThreadedExecutor, route: JointRoute, rate: float, seconds: float
) -> None:
    """Send joint states at a rate, without waiting for answers, and then wait for the last."""
    first = max(route.delays, default=0) + 1
    start = time.perf_counter()
    for k in range(WARM_UP + round(rate * seconds)):
        message = route.message(k / rate)
        while (left := start + k / rate - time.perf_counter()) > 0.0:
            executor.spin_once(timeout_sec=left)
        route.send(message, first + k)
    end = time.perf_counter() + LAST_ANSWERS
    while (left := end - time.perf_counter()) > 0.0:
        executor.spin_once(timeout_sec=left)


def start_nodes(processes: Processes, played: Played, *, with_tf: bool) -> None:
    """Start a node for each way, and the state publisher of the last."""
    nodes = [('by_poses', 'use_tf', False), ('by_joints', 'use_joint_states', True)]
    if with_tf:
        nodes.append(('by_tf', 'use_tf', True))
        processes.start('bench.ros.state_publisher', str(played.scene_file))
    for name, parameter, value in nodes:
        values = {parameter: str(value).lower()}
        remapped = ('--ros-args', '-r', f'__node:={name}', '--')
        processes.start(NODE, *remapped, scene_file=played.scene_file, max_distance=0.1, **values)


def measure(
    node: Node, played: Played, rate: float, seconds: float, *, with_tf: bool
) -> dict[str, tuple[list[float], int]]:
    """Stream all ways in turns; return the delays [s] of each, and how many were lost."""
    motion = load_motion(
        played.scene_file.with_name(f'{played.scene_file.stem}_motion.yaml'),
        read_scene(played.scene_file),
    )
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    by_poses = Route(node, 'by_poses')
    by_values = {'joint states': JointRoute(node, 'by_joints', '/joint_states', motion)}
    if with_tf:
        topic = '/to_state_publisher'
        by_values['state publisher and TF'] = JointRoute(node, 'by_tf', topic, motion)
    routes = {'link poses': by_poses, **by_values}
    while not all(route.publisher.get_subscription_count() for route in routes.values()):
        executor.spin_once(timeout_sec=0.1)
    for _ in range(TURNS):
        stream(executor, by_poses, played, rate, seconds / TURNS)
        for route in by_values.values():
            stream_joints(executor, route, rate, seconds / TURNS)
    executor.remove_node(node)
    return {way: route.result() for way, route in routes.items()}


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.split('\n')[0])
    parser.add_argument('--rates', nargs='+', type=float, default=[100.0, 500.0])
    parser.add_argument('--seconds', type=float, default=6.0, help='of streaming each way')
    parser.add_argument('--without-tf', action='store_true', help='link poses and joint states')
    options = parser.parse_args()
    played, with_tf = two_arms(), not options.without_tf
    print(f'{"rate [Hz]":>10}{"way":>26}{"p50":>9}{"p99":>9}{"mean":>9}{"lost":>6}   [ms]')
    with Processes() as processes:
        start_nodes(processes, played, with_tf=with_tf)
        for rate in options.rates:
            rclpy.init()
            driver = rclpy.create_node('driver')
            found = measure(driver, played, rate, options.seconds, with_tf=with_tf)
            for way, (delays, lost) in found.items():
                p50, p99 = np.percentile(delays, (50, 99)) * 1e3 if delays else (np.nan, np.nan)
                mean = np.mean(delays) * 1e3 if delays else np.nan
                print(f'{rate:10g}{way:>26}{p50:9.2f}{p99:9.2f}{mean:9.2f}{lost:6}', flush=True)
            driver.destroy_node()
            rclpy.shutdown()


if __name__ == '__main__':
    main()
