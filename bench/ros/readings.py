"""How long messages that stream in take to be read, by their bytes and by rclpy, in turns.

    ./run exec python -m bench.ros.readings [--messages 200]

Each row is a message of so many transforms, joints or frames. Reading by bytes is what the node
does; reading by rclpy is what it falls back on. ``taken`` is what comes behind, the same for both:
a scene hears the transforms and poses its frames by them. A row ``other`` is of frames that the
scene does not have. Milliseconds: median, mean and 99th percentile; the ratio is that of medians.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from drake_geom_msgs.msg import FramePoses
from geometry_msgs.msg import TransformStamped
from rclpy.serialization import serialize_message
from sensor_msgs.msg import JointState
from tf2_msgs.msg import TFMessage

from bench.ros.arrivals.kinds import scene_of
from drake_geom_ros.live.conversions.serialized_transforms import TransformReader
from drake_geom_ros.live.conversions.transforms import Transforms, transforms_of
from drake_geom_ros.live.inputs.tf_input import TfInput
from drake_geom_ros.live.scene.changes.addition import addition
from drake_geom_ros.live.scene.clocks import Clocks
from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.ros.message_reading import MessageReader, pose_reader, time_of
from drake_geom_ros.scene_files import read_scene

SIZES = 50, 3000
JOINTS = 36
WARM_UP = 5  # messages


class Case(NamedTuple):
    """A kind of message: its type, what it says at a time [ns], and what takes it, if measured."""

    name: str
    kind: Any
    message: Callable[[int], Any]
    take: Callable[[Any], object] | None = None


class Never:
    """Reads nothing by bytes."""

    def read(self, raw: bytes, sender: str = '') -> Any:
        """Return None: rclpy reads all."""


def scene_taking(count: int, folder: Path) -> Callable[[Transforms], object]:
    """Return what has a scene of so many frames hear transforms, and pose by them."""
    live = LiveScene('exact', Clocks(time.time))
    scene_file = folder / f'{count}.yaml'
    scene_file.write_text(scene_of(frames=count))
    with live.editing() as scene:
        scene.make(addition(read_scene(scene_file)))
    tf = TfInput(live.clocks)

    def take(transforms: Transforms) -> None:
        with live.editing() as scene:
            tf.take(transforms, static=False)
            tf.pose(scene)

    return take


def transforms(count: int, prefix: str) -> Callable[[int], TFMessage]:
    """Return what makes a message of so many transforms for a time."""
    each = [TransformStamped(child_frame_id=f'{prefix}{k}') for k in range(count)]

    def message(now: int) -> TFMessage:
        for k, transform in enumerate(each):
            transform.header.frame_id = 'world'
            transform.header.stamp = time_of(*divmod(now, 10**9))
            transform.transform.translation.x = 5.0 + k + 1e-9 * (now % 10**9)
        return TFMessage(transforms=each)

    return message


def joint_state(now: int) -> JointState:
    """Return the state of a humanoid."""
    names, values = [f'left_arm_joint_{k}' for k in range(JOINTS)], [1e-9 * (now % 10**9)] * JOINTS
    message = JointState(name=names, position=values, velocity=values, effort=values)
    message.header.stamp = time_of(*divmod(now, 10**9))
    return message


def frame_poses(count: int) -> Callable[[int], FramePoses]:
    """Return what makes a message of so many poses for a time."""
    names = [f'source::frame_{k}' for k in range(count)]

    def message(now: int) -> FramePoses:
        row = [1e-9 * (now % 10**9), 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]
        message = FramePoses(frame_names=names, poses=row * count)
        message.header.stamp = time_of(*divmod(now, 10**9))
        return message

    return message


def cases(folder: Path) -> list[Case]:
    """Return what is measured."""
    rows = []
    for count in SIZES:
        for name, prefix in (('of the scene', 'f'), ('other', 'g')):
            take = scene_taking(count, folder)
            message = transforms(count, prefix)
            rows.append(Case(f'/tf of {count}, {name}', TFMessage, message, take))
    rows.append(Case(f'JointState of {JOINTS}', JointState, joint_state))
    return rows + [Case(f'FramePoses of {n}', FramePoses, frame_poses(n)) for n in (50, 1000)]


def measure(case: Case, messages: int) -> str:
    """Return a row of the table."""
    if case.kind is TFMessage:
        by_bytes = MessageReader(case.kind, TransformReader(time_of), transforms_of)
        by_rclpy = MessageReader(case.kind, Never(), transforms_of)
    else:
        by_bytes, by_rclpy = pose_reader(case.kind), MessageReader(case.kind, Never())
    seconds: tuple[list[float], ...] = ([], [], [])
    for _ in range(messages + WARM_UP):
        raw = serialize_message(case.message(time.time_ns()))
        start = time.perf_counter()
        by_rclpy.read(raw, 'sender')
        middle = time.perf_counter()
        message = by_bytes.read(raw, 'sender')
        end = time.perf_counter()
        if case.take is not None:
            case.take(message)
        taken = time.perf_counter()
        for values, value in zip(
            seconds, (middle - start, end - middle, taken - end), strict=True
        ):
            values.append(value * 1e3)
    cells = [f'{"":>27}' if case.take is None else f'{_cells(seconds[2])}']
    ratio = np.median(seconds[0][WARM_UP:]) / np.median(seconds[1][WARM_UP:])
    return f'{case.name:26}{_cells(seconds[0])}{_cells(seconds[1])}{ratio:8.0f}{cells[0]}'


def _cells(values: list[float]) -> str:
    counted = values[WARM_UP:]
    three = np.median(counted), np.mean(counted), np.percentile(counted, 99)
    return ''.join(f'{value:9.3f}' for value in three)


def main() -> None:
    """Measure and print the table."""
    parser = argparse.ArgumentParser(
        prog='python -m bench.ros.readings', description=__doc__.split('\n')[0]
    )
    parser.add_argument('--messages', type=int, default=200)
    options = parser.parse_args()
    three = f'{"median":>9}{"mean":>9}{"p99":>9}'
    print(f'{"":26}{"by rclpy":>27}{"by bytes":>27}{"ratio":>8}{"taken":>27}   [ms]')
    print(f'{"":26}{three}{three}{"":8}{three}')
    with tempfile.TemporaryDirectory() as folder:
        for case in cases(Path(folder)):
            print(measure(case, options.messages), flush=True)


if __name__ == '__main__':
    main()
