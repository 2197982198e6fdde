"""Runs a node until a signal or a future says stop; the callbacks that run then finish first.

rclpy's own signal handler shuts the context down from another thread, under a callback that is
about to publish: that callback then fails. So a process of ours begins with
``rclpy.init(signal_handler_options=SignalHandlerOptions.NO)`` and spins here.

A node may name callback groups that get a thread each, so that none of them waits for another.
rclpy's executor looks at each entity of a node before every wait, which with the services of a
scene graph costs as much as a cycle; an executor of one group waits for that group's entities
only, by a wait set that it keeps, and a pose message is answered sooner (``bench.ros.executors``).
"""

from __future__ import annotations

import inspect
import math
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Coroutine, Sequence
from types import FrameType
from typing import Any

import rclpy
from rclpy.callback_groups import CallbackGroup
from rclpy.exceptions import InvalidHandle
from rclpy.executors import (
    ExternalShutdownException,
    ShutdownException,
    SingleThreadedExecutor,
    TimeoutException,
)
from rclpy.node import Node
from rclpy.service import Service
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future
from rclpy.utilities import remove_ros_args

from drake_geom_ros.live.memory import settle
from drake_geom_ros.live.watchdog import Watchdog
from drake_geom_ros.ros.group_waiting import GroupWaitSet, can_keep_wait_sets
from drake_geom_ros.ros.outputs.service_answers import Calls

_SIGNALS = (signal.SIGINT, signal.SIGTERM)
# Python runs its signal handlers between two waits of the executor, so this [s] is how long a
# signal may go unnoticed.
_LONGEST_WAIT = 0.1
# A thread that computes hands Python's interpreter over after this [s] when another one asks for
# it; Python's own 5 ms are ten cycles of a small scene.
_SWITCH_INTERVAL = 0.0005
# How much nicer [steps of nice] threads in the background are. On two cores, while states were
# evaluated on both, results of poses were 2.2 times as late as otherwise without it, and 1.1 times
# with it. It is no more, for such a thread must get on while it holds what others wait for.
_NICER = 5
# A callback that runs when the node is told to stop may finish in this time [s].
_FAREWELL = 15.0


class StopSignals:
    """While entered, SIGINT and SIGTERM only make ``received`` true.

    With ``once`` the second of them ends the process: what runs may take long, such as the
    compilation of a scene's kernels.
    """

    def __init__(self, *, once: bool = False) -> None:
        self.received = False
        self._once = once

    def __enter__(self) -> StopSignals:
        self._before = {number: signal.signal(number, self._receive) for number in _SIGNALS}
        return self

    def __exit__(self, *exception: object) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)

    def _receive(self, number: int, frame: FrameType | None) -> None:
        if self.received and self._once:
            signal.signal(number, signal.SIG_DFL)
            signal.raise_signal(number)
        self.received = True


Failed = Callable[[Exception, Any], None]  # with the entity whose callback it was


class _Executor(SingleThreadedExecutor):
    """Hands what a callback raises to ``failed``; None: raises it, as rclpy does.

    rclpy's own callbacks raise for some requests, such as a parameter of a type that is none.
    """

    def __init__(self, node: Node, failed: Failed | None) -> None:
        super().__init__(context=node.context)
        self._failed = failed
        self._busy_since = math.inf  # [s] of the steady clock

    def spin_once(self, timeout_sec: float | None = None) -> None:
        """Wait for a callback and execute it.

        Where another thread closes what this one was about to wait for, rclpy raises InvalidHandle
        and looks at everything anew in its next wait.
        """
        try:
            handler, entity, _ = self.wait_for_ready_callbacks(timeout_sec)
        except (ShutdownException, TimeoutException, InvalidHandle):
            return
        self._busy_since = time.monotonic()
        handler()
        self._busy_since = math.inf
        if (error := handler.exception()) is None:
            return
        # What was closed while its callback ran: nobody waits for the answer.
        untold = isinstance(error, InvalidHandle)
        if self._failed is None and not untold:
            raise error
        # Where taking the message failed, rclpy leaves the whole group busy for ever.
        if entity is not None and entity._executor_event and entity.callback_group is not None:
            entity._executor_event = False
            entity.callback_group.ending_execution(entity)
        if self._failed is not None and not untold:
            self._failed(error, entity)

    def _take_service(self, srv: Service[Any, Any]) -> Any:
        """Return what answers the next request of a service: see ``outputs.answers``."""
        calls = srv.send_response
        if not (isinstance(calls, Calls) and calls.is_there):
            return super()._take_service(srv)
        try:
            taken = calls.take()
        except InvalidHandle:  # it was closed
            return None

        async def answer() -> None:
            if taken is not None:
                request, request_id = taken
                response = srv.callback(request, srv.srv_type.Response())
                calls(await response if inspect.isawaitable(response) else response, request_id)

        return answer

    def busy(self) -> float:
        """Return for how long [s] the callback that runs has run; 0 where none does."""
        return max(0.0, time.monotonic() - self._busy_since)


class GroupExecutor(_Executor):
    """Serves the callbacks of one group of a node; other executors serve the node's others."""

    def __init__(self, node: Node, group: CallbackGroup, failed: Failed | None = None) -> None:
        super().__init__(node, failed)
        self._node = node
        self._group = group
        self._waits: GroupWaitSet | None = None
        if can_keep_wait_sets() and self._guard is not None:
            self._waits = GroupWaitSet(group, self._guard, node.context)

    def spin_once(self, timeout_sec: float | None = None) -> None:
        """Wait for callbacks, and execute all that are ready together, one after another."""
        if self._waits is None:
            super().spin_once(timeout_sec)
            return
        if not self._context.ok():
            raise ExternalShutdownException
        self._run_tasks()
        for entity, kind in self._waits.ready(-1.0 if timeout_sec is None else timeout_sec):
            self._execute(entity, kind)

    def _run_tasks(self) -> None:
        """Run what others handed over, such as what is to be done with a service's answer."""
        if not self._tasks:
            return
        with self._tasks_lock:
            tasks = list(self._tasks)
            self._tasks.clear()
        for entry in tasks:
            task = entry[0]
            task()
            if not task.done():  # it waits
                with self._tasks_lock:
                    self._tasks.append(entry)
            elif (error := task.exception()) is not None:
                if self._failed is None:
                    raise error
                self._failed(error, None)

    def _execute(self, entity: Any, kind: str) -> None:
        """Execute the callback of an entity that is ready."""
        if not self._group.beginning_execution(entity):
            return
        self._busy_since = time.monotonic()
        try:
            if kind == 'timer':
                with entity.handle:  # another callback may have closed it
                    is_ready = entity.handle.is_timer_ready()
                if not is_ready:  # it was cancelled
                    return
            callback = getattr(self, f'_take_{kind}')(entity)
            if callback is not None:
                _finish(callback())
        except Exception as error:
            if isinstance(error, InvalidHandle):
                return  # closed by another callback: nobody waits for an answer
            if self._failed is None:
                raise
            self._failed(error, entity)
        finally:
            self._busy_since = math.inf
            self._group.ending_execution(entity)

    def get_nodes(self) -> list[Node]:
        """Return the node, which is not added: a node is added to one executor only."""
        return [self._node]

    def can_execute(self, entity: Any) -> bool:
        """Return whether an entity is of the group, and free."""
        return entity.callback_group is self._group and super().can_execute(entity)


def _finish(callback: Coroutine[Any, Any, None]) -> None:
    """Run a callback; raises RuntimeError for one that waits, which nobody would go on with."""
    try:
        callback.send(None)
    except StopIteration:
        return
    callback.close()
    raise RuntimeError('a callback of a group with a thread of its own must not await anything')


class _RemainderExecutor(_Executor):
    """Serves the callbacks of a node but those of some groups."""

    def __init__(self, node: Node, others: Sequence[CallbackGroup], failed: Failed | None) -> None:
        super().__init__(node, failed)
        self._others = others
        self.add_node(node)

    def can_execute(self, entity: Any) -> bool:
        """Return whether an entity is of no other executor's group, and free."""
        return entity.callback_group not in self._others and super().can_execute(entity)


class _GroupThread(threading.Thread):
    """A thread that serves one callback group until it is stopped; it keeps what went wrong."""

    def __init__(
        self, node: Node, group: CallbackGroup, failed: Failed | None, gives_way: bool = False
    ) -> None:
        super().__init__(daemon=True)
        self.group = group
        self._gives_way = gives_way
        self._executor = GroupExecutor(node, group, failed)
        self._stopping = threading.Event()
        self.error: Exception | None = None

    def run(self) -> None:
        try:
            if self._gives_way and sys.platform.startswith('linux'):  # which has it by thread
                os.nice(_NICER)
            while not self._stopping.is_set():
                self._executor.spin_once(timeout_sec=_LONGEST_WAIT)
        except Exception as error:
            self.error = error

    def busy(self) -> float:
        """Return for how long [s] the callback that runs has run; 0 where none does."""
        return self._executor.busy()

    def stop(self) -> None:
        """Let the callback that runs finish, then end; raises StuckError where it does not."""
        self._stopping.set()
        self._executor.wake()
        self.join(_FAREWELL)
        if self.is_alive():
            raise StuckError(f'a callback did not finish within {_FAREWELL:g} s')
        self._executor.shutdown()


class StuckError(RuntimeError):
    """A callback waits for something that does not come."""


def spin_until_stopped(
    node: Node,
    signals: StopSignals,
    until: Future | None = None,
    groups: Sequence[CallbackGroup] = (),
    failed: Failed | None = None,
    watchdog: Watchdog | None = None,
    patient: Sequence[CallbackGroup] = (),
    background: Sequence[CallbackGroup] = (),
    interrupt: Callable[[], None] | None = None,
) -> None:
    """Serve a node's callbacks until a signal is received or a future is done.

    Each of ``groups`` has a thread of its own, all other callbacks are served by this one.
    ``failed`` is called with what callbacks raise, and whose, from any thread, and all go on;
    without it, what one raises ends all of them and is raised here. ``watchdog`` is fed while
    this thread gets around and no callback of the others runs for longer than its limit, but
    those of the groups in ``patient``, which may take their time. On Linux, threads of the groups
    in ``background``, and those that they start, give way to others where cores are scarce.
    ``interrupt`` is called before the threads are waited for, so that what takes long ends.
    """
    threads = [_GroupThread(node, group, failed, group in background) for group in groups]
    watched = [thread for thread in threads if thread.group not in patient]
    executor = _RemainderExecutor(node, groups, failed)
    if threads:
        sys.setswitchinterval(_SWITCH_INTERVAL)
    for thread in threads:
        thread.start()
    try:
        while not signals.received and not (until is not None and until.done()):
            executor.spin_once(timeout_sec=_LONGEST_WAIT)
            if watchdog is not None and all(t.busy() <= watchdog.limit for t in watched):
                watchdog.feed()
            for thread in threads:
                if thread.error is not None:
                    raise thread.error
    finally:
        if watchdog is not None:
            watchdog.stop()
        if interrupt is not None:
            interrupt()
        for thread in threads:
            thread.stop()
        executor.shutdown()


def run_node(
    make_node: Callable[[], Node],
    refusals: tuple[type[Exception], ...],
    args: list[str] | None = None,
) -> int:
    """Run a node as a process until it is stopped, and return the exit code.

    That is 2 where arguments are none of ROS, or where making the node raises one of
    ``refusals``, for what it was given cannot be. A node names the callback groups that get
    threads of their own in its ``threaded_groups``, those among them that may take their time in
    its ``patient_groups``, those that give way to others in its ``background_groups``, a watchdog
    over the others in its ``watchdog``. Its method ``interrupt`` ends what takes long before the
    node stops, and what a callback raises does not end one that has a method ``callback_failed``.
    """
    expected: tuple[type[Exception], ...] = (_BadArgumentsError, *refusals)
    with StopSignals(once=True) as signals:
        try:
            _initialise(sys.argv[1:] if args is None else args)
            node = make_node()
            spin_until_stopped(
                node,
                signals,
                groups=getattr(node, 'threaded_groups', ()),
                failed=getattr(node, 'callback_failed', None),
                watchdog=getattr(node, 'watchdog', None),
                patient=getattr(node, 'patient_groups', ()),
                background=getattr(node, 'background_groups', ()),
                interrupt=getattr(node, 'interrupt', None),
            )
            node.destroy_node()
            del node
        except StuckError as error:
            print(f'drake_geom_ros: {error}; ended without it', file=sys.stderr)
            sys.stderr.flush()
            os._exit(1)  # what is stuck would keep an orderly end waiting
        except expected as error:
            print(f'drake_geom_ros: {error}', file=sys.stderr)
            return 2
        finally:
            # What rclpy keeps of a life-cycle node ends with the garbage, as does a node that was
            # refused. Until then the threads of Fast DDS run, into what is gone at the end of the
            # process. The interpreter then searches only what came after this.
            settle()
            rclpy.try_shutdown()
    return 0


class _BadArgumentsError(ValueError):
    """Arguments of a process that are none, or that ROS cannot read."""


def _initialise(args: list[str]) -> None:
    """Initialise rclpy without its signal handler; raise _BadArgumentsError for bad arguments."""
    try:
        rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
        others = remove_ros_args(args)
    except RuntimeError as error:  # rcl's, which are not exported
        what = str(error)
        if what.startswith('['):  # a list of those that it does not know
            what = f'ROS has no arguments {what}; a parameter is given as -p NAME:=VALUE'
        raise _BadArgumentsError(what) from None
    if others:
        raise _BadArgumentsError(
            f'unknown arguments {" ".join(others)!r}; only ROS arguments are accepted, such as '
            '--ros-args -p NAME:=VALUE (--help lists the parameters)'
        )
