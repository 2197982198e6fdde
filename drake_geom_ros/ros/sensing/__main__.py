"""Takes clouds and depth images for a node, which starts it: python -m ... FILE_DESCRIPTOR."""

from __future__ import annotations

import os
import sys
import threading
import time
from collections.abc import Callable, Iterable
from multiprocessing.connection import Connection
from typing import Any

import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message
from rclpy.signals import SignalHandlerOptions
from rclpy.subscription import Subscription
from sensor_msgs.msg import CameraInfo, Image, LaserScan, PointCloud2, Range

from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.live.conversions.arrivals import Gaps, MessageInfo, publisher_of, waited
from drake_geom_ros.live.conversions.serialized_cloud import (
    Header,
    Stamp,
    cloud_of_bytes,
    is_plain,
)
from drake_geom_ros.live.inputs.late_messages import LateMessages
from drake_geom_ros.live.inputs.obstacle_records import Found, Place
from drake_geom_ros.live.inputs.point_taker import PointTaker
from drake_geom_ros.live.scene.moments import UnknownYetError
from drake_geom_ros.ros.sensing.node_pipe import NodePipe
from drake_geom_ros.ros.sensing.protocol import (
    ALIVE,
    CAMERA,
    CLOUD,
    CONE,
    IMAGE,
    SCAN,
    Begin,
    Finish,
    MissedMessages,
    RefusalReason,
    RefusedMessage,
    SensorTopic,
    Task,
)
from drake_geom_ros.sensed_maps.looking_past import compile_looking_past
from drake_geom_ros.sensed_maps.passes import compile_passes

_NICER = 5  # steps of nice, as threads of the node that give way have
_LONGEST_WAIT = 0.2  # [s] between two signs of life
_LOOKS = 0.005  # [s] between two looks whether the poses of messages that wait have come
_KINDS: dict[str, Any] = {
    CLOUD: PointCloud2,
    IMAGE: Image,
    CAMERA: CameraInfo,
    SCAN: LaserScan,
    CONE: Range,
}


class _MapOfNode:
    """The map of an input, which the node has at the other end of a pipe."""

    def __init__(self, pipe: NodePipe, name: str) -> None:
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
        if place.bodies.bodies is not None:
            self._pipe.may_compile()  # what knows new bodies
        return place

    def finish(self, taken: Found) -> None:
        self._ask(Finish(self._name, taken))

    def _ask(self, request: Begin | Finish) -> Any:
        self._pipe.send(request)
        answer = self._pipe.recv()
        if isinstance(answer, RefusalReason):
            refusal = UnknownYetError if answer.may_pass else ArgumentError
            raise refusal(answer.reason)
        return answer


def _cloud_of(raw: bytes) -> Any:
    # A middleware may have another layout.
    return cloud_of_bytes(raw) if is_plain(raw) else deserialize_message(raw, PointCloud2)


class _Listening:
    """The subscriptions of a process, each with what takes its messages."""

    def __init__(self, node: Node, pipe: NodePipe) -> None:
        self._node, self._pipe = node, pipe
        self._takers: dict[str, PointTaker] = {}  # by map
        self._open: dict[SensorTopic, Subscription[Any]] = {}
        self.late = LateMessages()

    def follow(self, topics: Iterable[SensorTopic]) -> None:
        """Listen to these topics, and to no others."""
        wanted = set(topics)
        for topic in [topic for topic in self._open if topic not in wanted]:
            self._node.destroy_subscription(self._open.pop(topic))
            self.late.forget(_key(topic))
        maps = {topic.input for topic in wanted}
        self._takers = {name: each for name, each in self._takers.items() if name in maps}
        for topic in wanted - self._open.keys():
            self._open[topic] = self._subscription(topic)

    def _subscription(self, topic: SensorTopic) -> Subscription[Any]:
        point_taker = self._takers.get(topic.input)
        if point_taker is None:
            point_taker = PointTaker(_MapOfNode(self._pipe, topic.input))
            self._takers[topic.input] = point_taker
        take, gaps = _take(topic.kind, point_taker), Gaps()

        def refuse(error: Exception) -> None:
            foreseen = isinstance(error, RuntimeError)
            reason = str(error) if foreseen else f'internal error: {error!r}'
            self._pipe.send(RefusedMessage(topic.told_as, reason))

        def hear(raw: bytes, info: MessageInfo) -> None:
            def attempt() -> None:
                take(raw, waited(info), publisher_of(info))

            missed = gaps.before(info)
            missed += self.late.take(_key(topic), attempt, refuse, topic.depth)
            if missed and topic.kind != CAMERA:  # whose messages make no map
                self._pipe.send(MissedMessages(topic.input, missed))

        profile = QoSProfile(
            history=HistoryPolicy(topic.history),
            depth=topic.depth,
            reliability=ReliabilityPolicy(topic.reliability),
            durability=DurabilityPolicy(topic.durability),
        )
        return self._node.create_subscription(
            _KINDS[topic.kind], topic.name, hear, profile, raw=True
        )


def _key(topic: SensorTopic) -> str:
    """Return what no other topic has."""
    return f'{topic.input} {topic.name}'


def _take(kind: str, point_taker: PointTaker) -> Callable[[bytes, float, str], None]:
    """Return what takes the bytes of messages of a kind."""
    if kind == CLOUD:
        return lambda raw, *how: point_taker.take_cloud(_cloud_of(raw), *how)
    if kind == IMAGE:
        return lambda raw, *how: point_taker.take_depth(deserialize_message(raw, Image), *how)
    if kind == CAMERA:
        return lambda raw, *how: point_taker.take_camera(
            deserialize_message(raw, CameraInfo), *how
        )
    if kind == CONE:
        return lambda raw, *how: point_taker.take_range(deserialize_message(raw, Range), *how)
    assert kind == SCAN, kind
    return lambda raw, *how: point_taker.take_scan(deserialize_message(raw, LaserScan), *how)


def _end_with_node() -> None:
    """End this process, whatever it does, as soon as the node that started it is gone."""
    # Not by sys.stdin: its lock is held meanwhile, and an interpreter that ends would abort.
    while os.read(0, 1024):
        pass
    os._exit(0)


def _work(pipe: NodePipe) -> None:
    task: Task = pipe.recv()
    pipe.may_compile()
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
    listening = _Listening(node, pipe)
    listening.follow(task.topics)
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    if sys.platform.startswith('linux'):  # which has it by thread: not those that receive
        os.nice(_NICER)
    last_sign = 0.0
    while True:
        if time.monotonic() - last_sign >= _LONGEST_WAIT:
            pipe.send(ALIVE)
            topics = pipe.recv()
            if topics is not None:
                listening.follow(topics)
            last_sign = time.monotonic()
        executor.spin_once(timeout_sec=_LOOKS if listening.late else _LONGEST_WAIT)
        listening.late.retry()


def main() -> None:
    """Work for the node until it is gone."""
    threading.Thread(target=_end_with_node, daemon=True).start()
    try:
        _work(NodePipe(Connection(int(sys.argv[1]))))
    except (EOFError, ConnectionError):  # it is gone
        return


if __name__ == '__main__':
    main()
