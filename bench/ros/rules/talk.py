"""Talks with a node that has proximity rules: its life, its clock, its services, what it says.

Times [s] are of the machine's clock, which also stamps what the middleware sends.
"""

from __future__ import annotations

import subprocess
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import rclpy
from drake_geom_msgs import msg, srv
from rclpy.clock import Clock as SteadyClock
from rclpy.clock import ClockType
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import QoSProfile
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Float64

from bench.ros.processes import Processes
from bench.ros.rules.cell import PULSE, STALE_AFTER, Rule
from drake_geom_ros.client import ProximityMonitor

NODE = 'drake_geom_ros.ros.scene_graph_node'
SERVER = '/scene_graph'
PATIENCE = 60.0  # [s] for an answer
COMPILING = 600.0  # [s] for a first answer: without a cache the node compiles its kernels
ONE_CALL = 2.0  # [s] after which a call is made again that may be made twice
CLOCK = 0.01  # [s] between two messages of /clock


class Talk:
    """One side of it; ``problems`` are what did not come."""

    def __init__(self, processes: Processes) -> None:
        self._processes = processes
        self.problems: list[str] = []
        self.node, self._executor = rclpy.create_node('storm'), SingleThreadedExecutor()
        self._executor.add_node(self.node)
        self._clients: dict[str, Any] = {}
        self.offset = 1e6  # [s] of the node's time
        self.pulses: list[float] = []  # [s] when it sent something at the end of a decision
        self.reported: set[float] = set()  # [s] stamps of cycles
        self.on_event: Callable[[Any], object] = lambda _: None
        self._ended: set[str] = set()  # rules, as events told it
        self._ticked, self.rested = time.time(), 0.0  # [s] last tick, longest rest of the clock
        self.node.create_subscription(
            msg.CycleReport, f'{SERVER}/cycle_report', self._hear_report, QoSProfile(depth=100)
        )
        self.node.create_subscription(
            Float64, f'{SERVER}/speed_scale', self._hear_pulse, QoSProfile(depth=1000)
        )
        self.monitor = ProximityMonitor(self.node, SERVER, on_event=self._hear_event)
        self._missed_unmet = 0  # events of nodes that were not met yet
        self.poses = self.node.create_publisher(msg.FramePoses, f'{SERVER}/frame_poses', 5)
        self._clock = self.node.create_publisher(Clock, '/clock', 5)
        steady = SteadyClock(clock_type=ClockType.STEADY_TIME)
        self.node.create_timer(CLOCK, self.send_clock, clock=steady)

    # What is heard.

    def missed(self) -> int:
        """Return how many events were missed of nodes that had been met."""
        return self.monitor.missed - self._missed_unmet

    def _hear_pulse(self, message: Float64, info: Any) -> None:
        self.pulses.append(info['source_timestamp'] * 1e-9)

    def _hear_report(self, message: Any) -> None:
        self.reported.add(seconds(message.header.stamp))

    def _hear_event(self, event: Any) -> None:
        if event.why == 'gone':
            self._ended.add(event.rule)
        self.on_event(event)

    def wait_for(self, fact: Callable[[], Any], what: str, patience: float = PATIENCE) -> bool:
        """Spin until something holds; tell the referee where it does not come."""
        end = time.time() + patience
        while not fact():
            if time.time() > end:
                self.problems.append(f'waited {patience:g} s for {what}')
                return False
            self._executor.spin_once(timeout_sec=0.01)
        return True

    def spin(self, seconds: float) -> None:
        """Hear what comes for a while."""
        end = time.time() + seconds
        while time.time() < end:
            self._executor.spin_once(timeout_sec=0.01)

    def ask(self, kind: Any, name: str, /, **fields: Any) -> Any:
        """Return the answer of a service."""
        if name not in self._clients:
            self._clients[name] = self.node.create_client(kind, f'{SERVER}/{name}')
        client = self._clients[name]
        if not self.wait_for(client.service_is_ready, name):
            raise TimeoutError(name)
        future = client.call_async(kind.Request(**fields))
        if not self.wait_for(future.done, f'an answer of {name}'):
            raise TimeoutError(name)
        return future.result()

    # Its clock.

    def now(self) -> float:
        """Return the node's time [s]."""
        return self.offset + time.monotonic() % 1e5

    def send_clock(self) -> None:
        """Tell the node its time."""
        message = Clock()
        message.clock.sec, message.clock.nanosec = divmod(int(1e9 * self.now()), 10**9)
        self._clock.publish(message)
        now = time.time()
        self.rested, self._ticked = max(self.rested, now - self._ticked), now

    # Its life.

    def kill(self) -> None:
        """End the node without a word, and hear what it said before."""
        self._process.kill()
        self._process.wait()
        self._processes.forget(self._process)
        self.spin(0.5)

    def start(self, scene_file: Path) -> None:
        """Start a node, and come back when it has heard the clock, and its events are heard."""
        self._process: subprocess.Popen[str] = self._processes.start(
            *(NODE, '--ros-args', '-p', f'scene_file:={scene_file.as_posix()}', '-p'),
            *('use_sim_time:=true', '-p', f'stale_after:={STALE_AFTER}', '-p'),
            *('closing_speeds:=true', '--log-level', 'error'),
        )
        missed = self.monitor.missed
        self._meet()
        self.wait_for(self.poses.get_subscription_count, 'a listener to poses')
        self._hear_an_event()
        self._missed_unmet += self.monitor.missed - missed
        self.wait_for(lambda: self.states().header.stamp.sec, 'time in the node')

    def states(self) -> Any:
        """Return how its rules stand."""
        return self.ask(srv.ListProximityRules, 'list_proximity_rules').states

    def _hear_an_event(self) -> None:
        """Add and remove a rule until that is heard: who is not met yet hears no event."""
        for number in range(int(PATIENCE)):
            name = f'hello {number}'
            hello = Rule(name, PULSE.sets, 1, 0.0, 1e-3).fields()
            self.ask(srv.AddProximityRule, 'add_proximity_rule', rule=msg.ProximityRule(**hello))
            self.ask(srv.RemoveProximityRule, 'remove_proximity_rule', name=name)
            end = time.time() + ONE_CALL
            while name not in self._ended and time.time() < end:
                self._executor.spin_once(timeout_sec=0.01)
            if name in self._ended:
                return
        raise TimeoutError('no event was heard')

    def _meet(self) -> None:
        """Ask until the node answers: a request to one that was killed, or is not met, is lost."""
        name = 'get_filters'
        client = self.node.create_client(srv.GetFilters, f'{SERVER}/{name}')
        self._clients[name] = client
        end = time.time() + COMPILING
        while time.time() < end:
            future = client.call_async(srv.GetFilters.Request())
            again = time.time() + ONE_CALL
            while not future.done() and time.time() < again:
                self._executor.spin_once(timeout_sec=0.01)
            if future.done():
                return
            if self._process.poll() is not None:
                raise RuntimeError(f'the node ended: {self._process.stdout.read()}')
        raise TimeoutError(name)


def seconds(stamp: Any) -> float:
    """Return a builtin_interfaces/Time in seconds, as ProximityMonitor tells it."""
    return float(stamp.sec + stamp.nanosec / 1_000_000_000)
