"""State of a trajectory that a node watches, and a subscription to all of them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from drake_geom_msgs import msg
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.time import Time

_LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
_OUTCOMES = ('', 'clear', 'contact', 'unknown')


class TrajectoryState(NamedTuple):
    """Verdict about the rest of a trajectory that runs; times [s] since its start.

    ``outcome`` is that of a ``Motion``, or empty where nothing is known; ``trouble`` says why, or
    what the outcome rests on. Only ``'clear'`` of a trajectory that has not ended is clear:
    ``bool()`` of a state raises TypeError.
    """

    name: str
    start: float  # [s] of the node's time
    ended: bool
    outcome: str
    now: float  # from which on it was judged
    times: tuple[float, float]  # that hold the first contact
    last_free: float  # proved to be clear until then
    names: tuple[str, str]  # of the reported pair, as source::frame/geometry; empty: none
    ids: tuple[int, int]  # 0: none
    distance: float  # [m] of that pair; inf: none
    error_bound: float  # [m]
    lower_bound: float  # [m] certified for the rest when it is clear
    deviation: float  # [rad] or [m] of a joint from the trajectory; nan: no value
    deviating_joint: str
    deviates: bool  # by more than the tolerance
    oldest_pose_age: float  # [s] of what was judged
    trouble: str

    def __bool__(self) -> bool:
        """Raise TypeError: an unknown outcome is neither true nor false."""
        raise TypeError(
            "a TrajectoryState is neither true nor false: ask whether outcome == 'clear'"
        )


def states_of(message: msg.TrajectoryStates) -> dict[str, TrajectoryState]:
    """Return the entries of a message by name."""
    return {name: _state(message, k) for k, name in enumerate(message.names)}


def _state(message: Any, k: int) -> TrajectoryState:
    start, times = message.starts[k], message.times[2 * k : 2 * k + 2]
    return TrajectoryState(
        name=message.names[k],
        start=Time.from_msg(start).nanoseconds / 1_000_000_000,
        ended=message.ended[k],
        outcome=_OUTCOMES[message.outcome[k]],
        now=message.now[k],
        times=(times[0], times[1]),
        last_free=message.last_free[k],
        names=(message.geometry_a[k], message.geometry_b[k]),
        ids=(message.id_a[k], message.id_b[k]),
        distance=message.distance[k],
        error_bound=message.error_bound[k],
        lower_bound=message.lower_bound[k],
        deviation=message.deviation[k],
        deviating_joint=message.deviating_joint[k],
        deviates=message.deviates[k],
        oldest_pose_age=message.oldest_pose_age[k],
        trouble=message.trouble[k],
    )


class TrajectoryStates:
    """Subscription to ``~/trajectory_states``, with the states of the last message by name."""

    def __init__(self, node: Node, server: str = '/scene_graph') -> None:
        """Listen with ``node``, which the caller spins, to the node named ``server``."""
        self.last: dict[str, TrajectoryState] | None = None  # None: no message came yet
        self._callbacks: list[Callable[[dict[str, TrajectoryState]], None]] = []
        topic = f'{server}/trajectory_states'
        node.create_subscription(msg.TrajectoryStates, topic, self._take, _LATCHED)

    def on_states(self, take: Callable[[dict[str, TrajectoryState]], None]) -> None:
        """Call ``take`` with the states of each message."""
        self._callbacks.append(take)

    def _take(self, message: msg.TrajectoryStates) -> None:
        self.last = states_of(message)
        for callback in self._callbacks:
            callback(self.last)
