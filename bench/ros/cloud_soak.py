"""What memory a node and its process of sensors take while maps of changing sizes come.

    ./run exec python -m bench.ros.cloud_soak [--points 300000] [--minutes 10]

Clouds at 10 Hz, each of another number of points and elsewhere, beside poses of the demo's arms.
"""

from __future__ import annotations

import argparse
import time
from statistics import linear_regression

import numpy as np
import rclpy
from drake_geom_msgs.msg import CycleReport, FramePoses
from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import Header

from bench.ros.clouds import NODE, RATE, cloud_of, parameters, room
from bench.ros.processes import Processes, children, memory
from bench.ros.scenes import two_arms

WARM_UP = 20.0  # [s] before memory counts


def soak(minutes: float, count: int) -> None:
    """Send clouds and poses, and print what memory each process takes."""
    played = two_arms()
    with Processes() as processes:
        node = processes.start(NODE, scene_file=played.scene_file, **parameters())
        rclpy.init()
        camera = rclpy.create_node('camera')
        newest = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
        publisher = camera.create_publisher(PointCloud2, '/scene_graph/obstacles/points', newest)
        poses = camera.create_publisher(FramePoses, '/scene_graph/frame_poses', newest)
        names = played.frame_names
        reports: list[CycleReport] = []
        camera.create_subscription(CycleReport, '/scene_graph/cycle_report', reports.append, 10)
        random = np.random.default_rng(1)
        points = room(count)
        start = time.monotonic()
        seen: list[tuple[float, float, float]] = []
        maps: set[int] = set()
        while (now := time.monotonic() - start) < 60.0 * minutes:
            some = points[: random.integers(1, count)] + random.uniform(-1.0, 1.0, 3)
            cloud = cloud_of(some)
            cloud.header.stamp = camera.get_clock().now().to_msg()
            publisher.publish(cloud)
            end = time.monotonic() + 1.0 / RATE
            while (left := end - time.monotonic()) > 0.0:
                header = Header(stamp=camera.get_clock().now().to_msg(), frame_id='world')
                flat = played.poses(time.monotonic()).ravel().tolist()
                poses.publish(FramePoses(header=header, frame_names=names, poses=flat))
                rclpy.spin_once(camera, timeout_sec=min(left, 0.01))
            maps.update(n for report in reports for n in report.map_cells)
            reports.clear()
            if now > WARM_UP:
                sensing = sum(memory(pid) for pid in children(node.pid))
                seen.append((now, memory(node.pid), sensing))
        rclpy.shutdown()
    print(f'{len(maps)} sizes of maps in {minutes:g} minutes')
    times, *both = zip(*seen, strict=True)
    for name, megabytes in zip(('node', 'process of sensors'), both, strict=True):
        slope = linear_regression(times, megabytes).slope
        print(
            f'{name}: {min(megabytes):.0f} to {max(megabytes):.0f} MB, {megabytes[-1]:.0f} at '
            f'the end, {60.0 * slope:+.2f} MB a minute'
        )


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.split('\n')[0])
    parser.add_argument('--points', type=int, default=300_000)
    parser.add_argument('--minutes', type=float, default=10.0)
    options = parser.parse_args()
    soak(options.minutes, options.points)


if __name__ == '__main__':
    main()
