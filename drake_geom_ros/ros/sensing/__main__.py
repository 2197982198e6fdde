"""Takes clouds and depth images for a node, which starts it: python -m ... FILE_DESCRIPTOR."""

from __future__ import annotations

import os
import sys
import threading
import time
from collections.abc import Callable
from multiprocessing.connection import Connection
from typing import Any

import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import CameraInfo, Image, LaserScan, PointCloud2

from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.live.conversions.arrivals import MessageInfo, publisher_of, waited
from drake_geom_ros.live.conversions.serialized_cloud import (
    Header,
    Stamp,
    cloud_of_bytes,
    is_plain,
)
from drake_geom_ros.live.inputs.obstacle_records import Found, Place
from drake_geom_ros.live.inputs.point_taker import PointTaker
from drake_geom_ros.ros.sensing.protocol import (
    ALIVE,
    CAMERA,
    CLOUD,
    IMAGE,
    SCAN,
    Begin,
    Finish,
    RefusalReason,
    RefusedMessage,
    SensorTopic,
    Task,
)
from drake_geom_ros.sensed_maps.looking_past import compile_looking_past
from drake_geom_ros.sensed_maps.passes import compile_passes

_NICER = 5  # steps of nice, as threads of the node that give way have
_LONGEST_WAIT = 0.2  # [s] between two signs of life
_KINDS: dict[str, Any] = {
    CLOUD: PointCloud2,
    IMAGE: Image,
    CAMERA: CameraInfo,
    SCAN: LaserScan,
}


class _MapOfNode:
    """The map of an input, which the node has at the other end of a pipe."""

    def __init__(self, pipe: Connection, name: str) -> None:
        self._pipe, self._name = pipe, name

    def begin(
        self,
        header: Any,
        waited: float,
        bodies_number: int,
        publisher: str,
        duration: float = 0.0,
    ) -> Place:
        stamp = Stamp(header.stamp.sec, header.stamp.nanosec)
        its_header = Header(stamp, header.frame_id)
        place = self._ask(
            Begin(self._name, its_header, waited, bodies_number, publisher, duration)
        )
        assert isinstance(place, Place)
        return place

    def finish(self, taken: Found) -> None:
        self._ask(Finish(self._name, taken))

    def _ask(self, request: Begin | Finish) -> Any:
        self._pipe.send(request)
        answer = self._pipe.recv()
        if isinstance(answer, RefusalReason):
            raise ArgumentError(answer.reason)
        return answer


def _cloud_of(raw: bytes) -> Any:
    # A middleware may have another layout.
    return cloud_of_bytes(raw) if is_plain(raw) else deserialize_message(raw, PointCloud2)


def _listen(node: Node, topic: SensorTopic, point_taker: PointTaker, pipe: Connection) -> None:
    takes: dict[str, Callable[[Any, float, str], None]] = {
        CLOUD: lambda raw, *how: point_taker.take_cloud(_cloud_of(raw), *how),
        IMAGE: lambda raw, *how: point_taker.take_depth(deserialize_message(raw, Image), *how),
        CAMERA: lambda raw, *how: point_taker.take_camera(
            deserialize_message(raw, CameraInfo), *how
        ),
        SCAN: lambda raw, *how: point_taker.take_scan(deserialize_message(raw, LaserScan), *how),
    }
    take = takes[topic.kind]

    def hear(raw: bytes, info: MessageInfo) -> None:
        try:
            take(raw, waited(info), publisher_of(info))
        except (EOFError, ConnectionError):  # the node is gone
            raise
        except Exception as error:  # RuntimeError refuses; nobody foresaw others
            foreseen = isinstance(error, RuntimeError)
            reason = str(error) if foreseen else f'internal error: {error!r}'
            pipe.send(RefusedMessage(topic.told_as, reason))

    profile = QoSProfile(
        history=HistoryPolicy(topic.history),
        depth=topic.depth,
        reliability=ReliabilityPolicy(topic.reliability),
    )
    node.create_subscription(_KINDS[topic.kind], topic.name, hear, profile, raw=True)


def _end_with_node() -> None:
    """End this process, whatever it does, as soon as the node that started it is gone."""
    sys.stdin.buffer.read()
    os._exit(0)


def _work(pipe: Connection) -> None:
    task: Task = pipe.recv()
    compile_passes()
    compile_looking_past()
    secured = ['--ros-args', '--enclave', task.enclave]
    rclpy.init(args=secured, signal_handler_options=SignalHandlerOptions.NO)
    # What the node's arguments say of names is in the task already.
    node = Node(
        task.node_name,
        namespace=task.namespace,
        use_global_arguments=False,
        enable_rosout=False,
        start_parameter_services=False,
    )
    takers = {each.input: PointTaker(_MapOfNode(pipe, each.input)) for each in task.topics}
    for topic in task.topics:
        _listen(node, topic, takers[topic.input], pipe)
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    if sys.platform.startswith('linux'):  # which has it by thread: not those that receive
        os.nice(_NICER)
    last_sign = 0.0
    while True:
        if time.monotonic() - last_sign >= _LONGEST_WAIT:
            pipe.send(ALIVE)
            last_sign = time.monotonic()
        executor.spin_once(timeout_sec=_LONGEST_WAIT)


def main() -> None:
    """Work for the node until it is gone."""
    threading.Thread(target=_end_with_node, daemon=True).start()
    try:
        _work(Connection(int(sys.argv[1])))
    except (EOFError, ConnectionError):  # it is gone
        return


if __name__ == '__main__':
    main()
