"""The picture of the page in docs/mobile_cell.md: maps of three sensors, a shell and a shadow.

./run exec python -m bench.viewer.cell_pictures [--out docs]

The world of the example is sent to a real node, in real time, with all but the arm standing. When
cells are in the shadow of the arm, it stops, and the page is photographed. Walls are out of reach
of the sensors here, and what the robot hides stays until the browser has drawn it.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any
from urllib.parse import quote

import numpy as np
import rclpy
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray
from drake_geom_msgs.msg import FramePoses, Shape, TrackedObjects
from drake_geom_msgs.srv import Attach
from geometry_msgs.msg import Point, Pose, Quaternion
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data as newest
from sensor_msgs.msg import CameraInfo, Image, JointState, LaserScan
from std_msgs.msg import Header

from bench.ros.beside import NODE, VIEWER
from bench.ros.processes import Processes
from bench.viewer.pictures import beside, opened, photograph

EXAMPLE = Path('examples/mobile_cell')
PORT, WINDOW = 18303, (1600, 1000)
PERSON, TROLLEY = (1.5, -1.0), (0.2, -0.36)  # [m] where they stand
EYE, TARGET = (-0.7, -2.8, 1.9), (0.75, -0.9, 0.7)  # [m] of the page's camera
STEP = 0.02  # [s]
RANGE = 3.0  # [m] of the sensors
# Down the panel, to the tables of sensors and maps.
SCROLL = """[...document.querySelectorAll('h2')].find(each => each.textContent === 'Stopping')
.scrollIntoView()"""
AHEAD, LONGEST = 0.05, 4.0  # [rad] of the shoulder, [s] until diagnostics know of a shadow
SHADOW = 20  # cells that the arm hides
X_HAND_BOX = Pose(position=Point(x=0.16), orientation=Quaternion(w=1.0))
PARAMETERS = {
    'publish_markers': True,
    'closing_speeds': True,
    'obstacle_resolution': 0.05,
    'obstacle_padding': 0.12,
    'obstacle_noise': 0.02,
    'obstacle_self_filter': 'robots',
    'max_distance': 0.5,
}


def scene_of_picture(folder: Path) -> Path:
    """Write the example's scene without far walls, and with shadows that stay."""
    text = (EXAMPLE / 'cell.yaml').read_text(encoding='utf-8')
    for name in ('mobile.urdf', 'mobile.srdf'):
        (folder / name).write_text((EXAMPLE / name).read_text(encoding='utf-8'), encoding='utf-8')
    text = text.replace(', keep_hidden: 2.0', '').replace(', timeout: 0.2', ', timeout: 0.5')
    text = text.replace(', timeout:', f', range: {RANGE}, timeout:')
    path = folder / 'cell.yaml'
    path.write_text(text, encoding='utf-8')
    return path


def header_of(plain: Any) -> Header:
    """Return a header of the simulation as a message."""
    stamp = Time(sec=plain.stamp.sec, nanosec=plain.stamp.nanosec)
    return Header(stamp=stamp, frame_id=plain.frame_id)


def as_message(kind: Any, plain: Any, **values: Any) -> Any:
    """Return what the simulation measured as a message, with other values of some fields."""
    message = kind()
    for name, value in {**vars(plain), **values}.items():
        if name == 'header':
            message.header = header_of(value)
        elif name != 'roi':
            setattr(message, name, value)
    return message


class Sender:
    """Sends what the simulation knows and measures, step by step."""

    def __init__(self, node: Node) -> None:
        sys.path.append(str(EXAMPLE))
        from cell import EVERY, tracked_message
        from world import Clock, World

        class Standing(World):
            """The world where all but the arm stands: a person before it, a trolley beside it."""

            base, trolley = (0.0, -1.0, 0.0), np.array([*TROLLEY])

            def move(self, *, share: float, seconds: float) -> None:
                self.person = self._goal = np.array([*PERSON])
                super().move(share=share, seconds=seconds)

        self._tracked_message, self._every = tracked_message, EVERY
        self.clock = Clock(time.time())
        self.world, self.share, self._steps = Standing(self.clock), 1.0, 0
        topics = {
            'poses': (FramePoses, '/scene_graph/frame_poses'),
            'joints': (JointState, '/joint_states'),
            'front': (LaserScan, '/front/scan'),
            'rear': (LaserScan, '/rear/scan'),
            'camera': (Image, '/camera/depth/image_rect_raw'),
            'info': (CameraInfo, '/camera/depth/camera_info'),
            'tracker': (TrackedObjects, '/scene_graph/tracked_objects'),
        }
        self._publishers = {
            name: node.create_publisher(kind, topic, newest)
            for name, (kind, topic) in topics.items()
        }

    def step(self) -> None:
        """Move the world on to now, and send what is due."""
        now = time.time()
        seconds, self.clock.now = now - self.clock.now, now
        world = self.world
        world.move(share=self.share, seconds=min(seconds, 2.0 * STEP) if self.share else 0.0)
        header = header_of(world.scan('front_lidar').header)
        header.frame_id = ''
        send = self._publishers
        poses = FramePoses(header=header, source='mobile', frame_names=['base_link'])
        poses.poses = list(map(float, world.row))
        send['poses'].publish(poses)
        arm, grip = world.arm
        joints = JointState(header=header, name=['shoulder', 'elbow', 'grip'])
        joints.position = [*map(float, arm), float(grip)]
        joints.velocity = [self.share * rate for rate in (*world.arm_rates, 0.0)]
        send['joints'].publish(joints)
        self._steps += 1
        for name, every in self._every.items():
            if self._steps % every == 0:
                self._measure(name)

    def _measure(self, name: str) -> None:
        send, world = self._publishers, self.world
        if name == 'tracker':
            plain = self._tracked_message(self.clock.now, world.seen_by_tracker())
            shapes = [Shape(type=s.type, dimensions=s.dimensions) for s in plain.shapes]
            send['tracker'].publish(as_message(TrackedObjects, plain, shapes=shapes))
        elif name == 'camera':
            picture, info = world.depth()
            send['info'].publish(as_message(CameraInfo, info))
            send['camera'].publish(as_message(Image, picture, data=bytes(picture.data)))
        else:
            scan = world.scan(f'{name}_lidar')
            ranges = np.asarray(scan.ranges, dtype=np.float32).tolist()
            send[name].publish(as_message(LaserScan, scan, ranges=ranges))


def send_until(over: threading.Event, sender: Sender) -> None:
    """Send, step by step, until an event is set."""
    due = time.monotonic()
    while not over.wait(max(0.0, due - time.monotonic())):
        sender.step()
        due = max(due + STEP, time.monotonic())


def wait_for(node: Node, fact: Callable[[], object]) -> None:
    """Spin until a fact is one."""
    while not fact():
        rclpy.spin_once(node, timeout_sec=0.02)


def carry(node: Node) -> None:
    """Attach the box to the hand."""
    client = node.create_client(Attach, '/scene_graph/attach')
    wait_for(node, client.service_is_ready)
    request = Attach.Request(frame='parts::box', parent='mobile::hand', pose_given=True)
    request.touch_links, request.pose = ['mobile::hand', 'mobile::finger'], X_HAND_BOX
    future = client.call_async(request)
    wait_for(node, future.done)
    if not future.result().success:
        raise RuntimeError(future.result().message)


class Shadow:
    """The number of cells that bodies hide from the camera, by the diagnostics."""

    def __init__(self, node: Node) -> None:
        self.cells = 0
        node.create_subscription(DiagnosticArray, '/diagnostics', self._hear, 10)

    def _hear(self, message: DiagnosticArray) -> None:
        for status in message.status:
            for each in status.values:
                if each.key == 'obstacles camera':
                    self.cells = int(each.value.partition(' behind bodies')[0].split()[-1])


def stop_in_shadow(node: Node, sender: Sender, shadow: Shadow) -> None:
    """Stop the arm before the person, once what it hides was seen before."""
    world = sender.world
    while shadow.cells < SHADOW:
        sender.share = 1.0
        wait_for(node, lambda: abs(world.arm[0][0]) > 10.0 * AHEAD)
        wait_for(node, lambda: abs(world.arm[0][0]) < AHEAD)
        sender.share, shadow.cells = 0.0, 0
        end = time.monotonic() + LONGEST
        while shadow.cells < SHADOW and time.monotonic() < end:
            rclpy.spin_once(node, timeout_sec=0.1)


def address() -> str:
    """Return the address of the page with its tab of sensors and a camera near the robot."""
    view = {'tab': 'live', 'camera': {'position': EYE, 'look_at': TARGET}}
    return f'http://127.0.0.1:{PORT}/#{quote(json.dumps(view))}'


def main() -> None:
    """Write the picture."""
    parser = argparse.ArgumentParser(prog='python -m bench.viewer.cell_pictures')
    parser.add_argument('--out', type=Path, default=Path('docs'))
    options = parser.parse_args()
    rclpy.init()
    node = rclpy.create_node('mobile_cell')
    try:
        with tempfile.TemporaryDirectory() as folder, Processes() as processes:
            scene = scene_of_picture(Path(folder))
            processes.start(NODE, scene_file=str(scene), **PARAMETERS)
            processes.start(VIEWER, port=PORT, max_distance=0.05)
            sender, shadow = Sender(node), Shadow(node)
            with beside(partial(send_until, sender=sender)):
                carry(node)
                stop_in_shadow(node, sender, shadow)
                browser = opened(address(), *WINDOW)
                browser.ask(SCROLL)
                photograph(browser, options.out / 'mobile_cell_page.png')
                browser.close()
    finally:
        node.destroy_node()
        rclpy.shutdown()


if __name__ == '__main__':
    main()
