"""Runs a node until a signal or a future says stop; the callback that runs then finishes first.

rclpy's own signal handler shuts the context down from another thread, under a callback that is
about to publish: that callback then fails. So a process of ours begins with
``rclpy.init(signal_handler_options=SignalHandlerOptions.NO)`` and spins here.
"""

from __future__ import annotations

import signal
import sys
from collections.abc import Callable
from pathlib import Path
from types import FrameType

import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future

_SIGNALS = (signal.SIGINT, signal.SIGTERM)
# Python runs its signal handlers between two waits of the executor, so this [s] is how long a
# signal may go unnoticed.
_LONGEST_WAIT = 0.1


class StopSignals:
    """While entered, SIGINT and SIGTERM only make ``received`` true."""

    def __init__(self) -> None:
        self.received = False

    def __enter__(self) -> StopSignals:
        self._before = {number: signal.signal(number, self._receive) for number in _SIGNALS}
        return self

    def __exit__(self, *exception: object) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)

    def _receive(self, number: int, frame: FrameType | None) -> None:
        self.received = True


def spin_until_stopped(node: Node, signals: StopSignals, until: Future | None = None) -> None:
    """Serve a node's callbacks until a signal is received or a future is done."""
    executor = SingleThreadedExecutor(context=node.context)
    executor.add_node(node)
    try:
        while not signals.received and not (until is not None and until.done()):
            executor.spin_once(timeout_sec=_LONGEST_WAIT)
    finally:
        executor.shutdown()


def run_node(
    make_node: Callable[[], Node], refusal: type[Exception], args: list[str] | None = None
) -> int:
    """Run a node as a process until it is told to stop, and return the exit code.

    That is 2 where making the node raises ``refusal``, for what it was given cannot be.
    """
    with StopSignals() as signals:
        rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
        try:
            node = make_node()
            spin_until_stopped(node, signals)
            node.destroy_node()
        except refusal as error:
            print(f'{Path(sys.argv[0]).stem}: {error}', file=sys.stderr)
            return 2
        finally:
            rclpy.try_shutdown()
    return 0
