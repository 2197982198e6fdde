"""Topics, services and timers that are open while the node is configured, closed together.

Every topic's history, depth and reliability can be overridden by the parameters
``qos_overrides.<topic>.<publisher or subscription>.<policy>``, read when the node is configured,
for instance ``qos_overrides./scene_graph/frame_poses.subscription.depth``.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rcl_interfaces.msg import ParameterDescriptor
from rclpy.callback_groups import CallbackGroup
from rclpy.client import Client
from rclpy.clock import Clock, ClockType, JumpHandle, JumpThreshold, TimeJump
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.qos_overriding_options import QoSOverridingOptions
from rclpy.subscription import Subscription
from rclpy.timer import Timer

from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.live.conversions.arrivals import MessageInfo
from drake_geom_ros.ros.outputs.service_answers import Answers
from drake_geom_ros.ros.parameters import QOS_OVERRIDES


def sensor_data() -> QoSProfile:
    """Return the profile of what streams in: best effort, so that any publisher fits."""
    return QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)


def results() -> QoSProfile:
    """Return the profile of what streams out: reliable, so that any subscriber fits."""
    return QoSProfile(depth=10)


def images() -> QoSProfile:
    """Return the profile of images: as results, but few are kept, for each is large."""
    return QoSProfile(depth=2)


def latched() -> QoSProfile:
    """Return the profile of what late comers get too: the last message is kept for them."""
    return QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


def transforms(*, static: bool) -> QoSProfile:
    """Return the profile that TF has: many publishers, and static transforms are latched."""
    durability = DurabilityPolicy.TRANSIENT_LOCAL if static else DurabilityPolicy.VOLATILE
    return QoSProfile(depth=100, durability=durability)


def calls(depth: int) -> QoSProfile:
    """Return the profile of services: so many requests wait, and so many answers on their way."""
    return QoSProfile(depth=depth)


class Surface:
    """Opens what a node offers, and remembers it for closing."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self.answers = Answers()
        self._steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._open: list[tuple[Callable[[Any], Any], Any]] = []

    def publisher(
        self, kind: Any, topic: str, profile: QoSProfile, *, comes_and_goes: bool = False
    ) -> Publisher:
        """Open a topic to publish on.

        One that ``comes_and_goes`` has parameters of its QoS only where they were given: a
        parameter cannot be taken back, and each costs kilobytes for as long as the node lives.
        """
        options: QoSOverridingOptions | None = QoSOverridingOptions.with_default_policies()
        if comes_and_goes and not self._is_overridden(topic):
            options = None
        publisher = self._node.create_publisher(
            kind, topic, profile, qos_overriding_options=options
        )
        self._open.append((self._node.destroy_publisher, publisher))
        return publisher

    def subscription(
        self,
        kind: Any,
        topic: str,
        callback: Callable[[Any], None] | Callable[[Any, MessageInfo], None],
        profile: QoSProfile,
        group: CallbackGroup | None = None,
        *,
        raw: bool = False,
        comes_and_goes: bool = False,
    ) -> Subscription[Any]:
        """Open a topic to listen to; ``raw``: to the bytes of its messages.

        See ``publisher`` for one that ``comes_and_goes``.
        """
        options: QoSOverridingOptions | None = QoSOverridingOptions.with_default_policies()
        if comes_and_goes and not self._is_overridden(topic):
            options = None
        subscription = self._node.create_subscription(
            kind,
            topic,
            callback,
            profile,
            callback_group=group,
            qos_overriding_options=options,
            raw=raw,
        )
        self._open.append((self._node.destroy_subscription, subscription))
        return subscription

    def _is_overridden(self, topic: str) -> bool:
        """Return whether the node was started with parameters of the QoS of a topic."""
        begin = f'{QOS_OVERRIDES}{self._node.resolve_topic_name(topic)}.'
        return any(name.startswith(begin) for name in self._node._parameter_overrides)

    def full_topic(self, topic: str) -> str:
        """Return the full name of a topic; raises ArgumentError for what cannot be one."""
        try:
            return str(self._node.resolve_topic_name(topic))
        except (ValueError, RuntimeError) as error:  # InvalidName, RCLError
            raise ArgumentError(f'topic is {topic[:80]!r}, which is none: {error}') from error

    def heard_elsewhere(
        self, topic: str, profile: QoSProfile, *, comes_and_goes: bool = False
    ) -> tuple[str, QoSProfile]:
        """Return the full name and profile of a topic that another process of ours listens to.

        The node has the parameters of its QoS as if it listened itself.
        """
        name = self._node.resolve_topic_name(topic)
        if comes_and_goes and not self._is_overridden(topic):
            return name, profile

        def value_of(policy: str, default: Any) -> Any:
            parameter = f'{QOS_OVERRIDES}{name}.subscription.{policy}'
            if not self._node.has_parameter(parameter):
                descriptor = ParameterDescriptor(read_only=True)
                self._node.declare_parameter(parameter, default, descriptor)
            return self._node.get_parameter(parameter).value

        history, reliability = (
            kind.get_from_short_key(value_of(policy, default.short_key))
            for kind, policy, default in (
                (HistoryPolicy, 'history', profile.history),
                (ReliabilityPolicy, 'reliability', profile.reliability),
            )
        )
        depth = value_of('depth', profile.depth)
        return name, QoSProfile(
            history=history, depth=depth, reliability=reliability, durability=profile.durability
        )

    def full_name(self) -> str:
        """Return the name of the node with its namespace."""
        return str(self._node.get_fully_qualified_name())

    def enclave(self) -> str:
        """Return the enclave of SROS 2 that this process is in; the root where there is none."""
        own = self._node.get_name(), self._node.get_namespace()
        nodes = self._node.get_node_names_and_namespaces_with_enclaves()
        return next((enclave for *name, enclave in nodes if tuple(name) == own), '/')

    def until_closed(self, close: Callable[[], None]) -> None:
        """Have something else closed with the rest."""
        self._open.append((lambda it: it(), close))

    def service(
        self,
        kind: Any,
        name: str,
        callback: Callable[[Any, Any], Any],
        profile: QoSProfile,
        group: CallbackGroup | None = None,
    ) -> None:
        """Open a service."""
        service = self._node.create_service(
            kind, name, callback, qos_profile=profile, callback_group=group
        )
        self.answers.send_for(service)
        self._open.append((self._node.destroy_service, service))

    def client(self, kind: Any, name: str, group: CallbackGroup | None = None) -> Client[Any, Any]:
        """Return what calls a service of another node."""
        client = self._node.create_client(kind, name, callback_group=group)
        self._open.append((self._node.destroy_client, client))
        return client

    def timer(
        self, period: float, callback: Callable[[], None], group: CallbackGroup | None = None
    ) -> Timer:
        """Call something every ``period`` [s] of real time, also while simulated time rests."""
        timer = self._node.create_timer(period, callback, callback_group=group, clock=self._steady)
        self._open.append((self._node.destroy_timer, timer))
        return timer

    def wake(
        self, callback: Callable[[], None], group: CallbackGroup | None = None
    ) -> Callable[[], None]:
        """Return what has a callback called soon by its group's thread, from any thread."""
        guard = self._node.create_guard_condition(callback, callback_group=group)
        self._open.append((self._node.destroy_guard_condition, guard))

        def trigger() -> None:
            guard.trigger()

        return trigger

    def clock_jumps(self, threshold: JumpThreshold, callback: Callable[[TimeJump], None]) -> None:
        """Call back at jumps of simulated time."""
        clock = self._node.get_clock()
        handle = clock.create_jump_callback(threshold, post_callback=callback)
        self._open.append((JumpHandle.unregister, handle))

    def close_subscription(self, subscription: Subscription[Any]) -> None:
        """Listen to one topic no more."""
        self._open.remove((self._node.destroy_subscription, subscription))
        self._node.destroy_subscription(subscription)

    def close_publisher(self, publisher: Publisher) -> None:
        """Close one topic."""
        self._open.remove((self._node.destroy_publisher, publisher))
        self._node.destroy_publisher(publisher)

    def close(self) -> None:
        """Close everything."""
        while self._open:
            destroy, handle = self._open.pop()
            destroy(handle)
