"""Rules while everything happens: `./run soak --rules --minutes 10` lets a referee look at it.

Two robots of loose bodies wander through each other, one pose message after the other, each
answered by a cycle. In between rules are added and removed, filters come and go or run out, the
level changes, one robot's poses or all stop, the clock jumps, the node is deactivated, and killed
and started again from the scene that it saved. What was sent and heard is kept, and ``referee``
decides once more. The exit code is 1 where a decision was missing, late beyond a cycle, unfounded,
or told twice.
"""

from __future__ import annotations

import argparse
import random
import signal
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import rclpy
from drake_geom_msgs import msg, srv
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter
from rclpy.qos import QoSProfile
from rosgraph_msgs.msg import Clock

from bench.ros.processes import Processes
from bench.ros.rules.cell import NAMES, STALE_AFTER, drawn_rule, scene_text
from bench.ros.rules.referee import Facts, Heard, Referee, Step
from drake_geom_ros.client import ProximityMonitor, exclude_between
from drake_geom_ros.math import RigidTransform, RollPitchYaw

NODE = 'drake_geom_ros.ros.scene_graph_node'
SERVER = '/scene_graph'
MOST_RULES = 20
PATIENCE = 60.0  # [s] for an answer
ONE_CALL = 2.0  # [s] after which a call is made again that may be made twice
STRIDE, TURN, HALF = 0.02, 0.1, 0.35  # [m] and [rad] of a step, [m] half a side of the room
EVERY = 12  # steps between two things that happen
SHOWN = 20


class Storm:
    """Sends, hears, and keeps both."""

    def __init__(self, processes: Processes, folder: Path, seed: int) -> None:
        self._processes, self._folder = processes, folder
        self.random, self._numbers = random.Random(seed), np.random.default_rng(seed)
        self.node = rclpy.create_node('storm')
        self._clients: dict[str, Any] = {}
        self.referee, self.counts = Referee(), Counter[str]()
        self._offset, self._stamp = 1e6, 0  # [s] of the node's time; [ns] of the last step
        self.facts = Facts({}, unposed=frozenset(('left', 'right')))
        self._leases: dict[int, tuple[frozenset[str], float]] = {}
        self._filters: dict[int, frozenset[str]] = {}
        self._places = {name: RigidTransform() for name in NAMES}
        self._posed: dict[str, tuple[float, float]] = {}
        self._steps: dict[float, Step] = {}  # by their stamp, as events tell it
        self._order: list[Step] = []
        self._reported: set[float] = set()
        self.steps, self.rules = 0, 0
        self.node.create_subscription(
            msg.CycleReport, f'{SERVER}/cycle_report', self._hear_report, QoSProfile(depth=100)
        )
        self.monitor = ProximityMonitor(self.node, SERVER, on_event=self._hear_event)
        self._poses = self.node.create_publisher(msg.FramePoses, f'{SERVER}/frame_poses', 5)
        self._clock = self.node.create_publisher(Clock, '/clock', 5)
        self._start(scene_text())

    # What is heard.

    def _hear_report(self, message: Any) -> None:
        self._reported.add(_seconds(message.header.stamp))

    def _hear_event(self, event: Any) -> None:
        # Poses from before the clock jumped have no newest stamp.
        step = self._steps.get(event.stamp, self._order[-1])
        step.events.append(Heard(event, time.monotonic()))

    def wait_for(self, fact: Callable[[], Any], what: str, patience: float = PATIENCE) -> bool:
        """Spin until something holds; tell the referee where it does not come."""
        end = time.monotonic() + patience
        while not fact():
            if time.monotonic() > end:
                self.referee.problems.append(f'waited {patience:g} s for {what}')
                return False
            rclpy.spin_once(self.node, timeout_sec=0.01)
        return True

    def spin(self, seconds: float) -> None:
        """Hear what comes for a while."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            rclpy.spin_once(self.node, timeout_sec=0.01)

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

    # Steps.

    def step(self, *sources: str) -> None:
        """Move robots, and wait for the cycle of that."""
        self._send_clock()
        self._stamp = int(1e9 * self._now())
        for name in NAMES:
            if name.partition('::')[0] in sources:
                self._places[name] = self._moved(self._places[name])
        message = msg.FramePoses(frame_names=[n for n in NAMES if n.partition('::')[0] in sources])
        message.header.stamp.sec, message.header.stamp.nanosec = divmod(self._stamp, 10**9)
        poses = [self._places[name] for name in message.frame_names]
        message.poses = np.ravel([X.ToArray() for X in poses]).tolist()
        key = _seconds(message.header.stamp)
        facts = self.facts._replace(unposed=self.facts.unposed - set(sources))
        sent = time.monotonic()
        before = self._order[-1]
        self._begin(Step(self._stamp, sent, sent, dict(self._places), {}, facts), key)
        before.until = sent
        end = sent + PATIENCE
        while key not in self._reported and time.monotonic() < end:
            self._poses.publish(message)  # again: what comes best effort may be lost
            again = time.monotonic() + 1.0
            while key not in self._reported and time.monotonic() < again:
                rclpy.spin_once(self.node, timeout_sec=0.005)
        now = self._order[-1]
        now.heard = time.monotonic()
        self._posed |= dict.fromkeys(sources, (sent, now.heard))
        now.posed = dict(self._posed)
        self.facts = facts
        self.steps += 1
        self._reported.clear()
        self._judge(all_but=5)

    def _begin(self, step: Step, key: float) -> None:
        self._order.append(step)
        self._steps[key] = step

    def _moved(self, X: RigidTransform) -> RigidTransform:
        way = self._numbers.normal(size=3)
        p = X.translation() + STRIDE * way / np.linalg.norm(way)
        p = np.where(np.abs(p) > HALF, 0.98 * np.clip(p, -HALF, HALF), p)
        turn = RollPitchYaw(*self._numbers.uniform(-TURN, TURN, 3)).ToRotationMatrix()
        return RigidTransform(X.rotation() @ turn, p)

    def _now(self) -> float:
        return self._offset + time.monotonic() % 1e5

    def _send_clock(self) -> None:
        message = Clock()
        message.clock.sec, message.clock.nanosec = divmod(int(1e9 * self._now()), 10**9)
        self._clock.publish(message)

    def _judge(self, all_but: int = 0) -> None:
        """Let the referee look at the steps of which nothing more is heard."""
        while len(self._order) > all_but:
            step = self._order.pop(0)
            self.referee.look(step)
            self._steps = {k: s for k, s in self._steps.items() if s is not step}

    def change(self, **facts: Any) -> None:
        """Know that something holds from now on, or may hold since the last step."""
        self.facts = self.facts._replace(**facts)
        self._order[-1].later.append(self.facts)

    # What happens.

    def add_rule(self) -> None:
        """Add a rule; past the most that there are, remove one."""
        if len(self.facts.rules) >= MOST_RULES:
            return self.remove_rule()
        self.rules += 1
        rule = drawn_rule(self.rules, self.random)
        self._order[-1].later.append(self._with(rule))
        answer = self.ask(
            *(srv.AddProximityRule, 'add_proximity_rule'), rule=msg.ProximityRule(**rule.fields())
        )
        if answer.success:
            self.change(rules={**self.facts.rules, rule.name: rule})
        elif 'could never be entered' not in answer.message:
            self.referee.problems.append(answer.message)
        return None

    def _with(self, rule: Any) -> Facts:
        return self.facts._replace(rules={**self.facts.rules, rule.name: rule})

    def remove_rule(self) -> None:
        """Remove a rule."""
        if self.facts.rules:
            name = self.random.choice(list(self.facts.rules))
            kept = {n: r for n, r in self.facts.rules.items() if n != name}
            self.change(rules=kept)
            self.ask(srv.RemoveProximityRule, 'remove_proximity_rule', name=name)

    def filter_pair(self) -> None:
        """Take a pair out, for good or for a while."""
        a, b = self.random.sample(NAMES, 2)
        lease = self.random.choice([0.0, 0.3])
        sets = (msg.GeometrySet(frames=[name]) for name in (a, b))
        declaration = msg.CollisionFilterDeclaration(statements=[exclude_between(*sets)])
        pair, sent = frozenset((a, b)), time.monotonic()
        self._order[-1].later.append(self.facts._replace(in_doubt=self.facts.in_doubt | {pair}))
        answer = self.ask(
            *(srv.ApplyTransientFilter, 'apply_transient_filter'),
            declaration=declaration,
            lease=lease,
        )
        if lease:
            self._leases[answer.filter_id] = pair, sent + lease
        self._filters[answer.filter_id] = pair
        self.know_filters()

    def free_pair(self) -> None:
        """Let a pair in again."""
        numbers = [n for n in self._filters if n not in self._leases]
        if numbers:
            number = self.random.choice(numbers)
            pair = self._filters.pop(number)
            self._order[-1].later.append(
                self.facts._replace(
                    filtered=self.facts.filtered - {pair}, in_doubt=self.facts.in_doubt | {pair}
                )
            )
            self.ask(srv.RemoveFilter, 'remove_filter', filter_id=number)
            self.know_filters()

    def know_filters(self) -> None:
        """Know which pairs are filtered, and of which that may have ended by itself."""
        now = time.monotonic()
        if any(now > end for _, end in self._leases.values()):
            active = set(self.ask(srv.GetFilters, 'get_filters').active_filter_ids)
            gone = set(self._leases) - active
            self._leases = {n: each for n, each in self._leases.items() if n not in gone}
            self._filters = {n: pair for n, pair in self._filters.items() if n not in gone}
        held = [pair for n, pair in self._filters.items() if n not in self._leases]
        leased = frozenset(pair for pair, _ in self._leases.values())
        self.change(filtered=frozenset(held), in_doubt=leased - frozenset(held))

    def set_level(self) -> None:
        """Change the accuracy level."""
        level = self.random.choice(['exact', 'exact', 'balanced', 'fast', 'bound'])
        self.change(is_exact=False)
        parameter = Parameter('accuracy', value=level).to_parameter_msg()
        self.ask(SetParameters, 'set_parameters', parameters=[parameter])
        if level == 'exact':
            self.facts = self.facts._replace(is_exact=True)

    def stop_a_robot(self) -> None:
        """Let the poses of one robot stop, while the other goes on."""
        source = self.random.choice(['left', 'right'])
        end = time.monotonic() + self.random.choice([0.3, 2.0]) * STALE_AFTER
        while time.monotonic() < end:
            self.step(source)

    def pause(self) -> None:
        """Let all poses stop."""
        self.spin(self.random.choice([0.5, 4.0]) * STALE_AFTER)

    def jump(self) -> None:
        """Let the clock jump."""
        self._offset += self.random.choice([-500.0, 100.0, -3.0])
        self.change(unposed=frozenset(('left', 'right')))

        def is_known() -> bool:
            self._send_clock()
            ages = self.ask(srv.GetPoseAges, 'get_pose_ages')
            return all(age == float('inf') for age in ages.ages if age != 0.0)

        self.wait_for(is_known, 'the jump to be known')

    def deactivate(self) -> None:
        """Deactivate the node, and activate it."""
        for number in (Transition.TRANSITION_DEACTIVATE, Transition.TRANSITION_ACTIVATE):
            self.ask(ChangeState, 'change_state', transition=Transition(id=number))

    def restart(self) -> None:
        """Kill the node, and start it from what it saved."""
        for number in list(self._filters):
            self.ask(srv.RemoveFilter, 'remove_filter', filter_id=number)
        self._filters, self._leases = {}, {}
        self.change(filtered=frozenset(), in_doubt=frozenset())
        text = self.ask(srv.SaveScene, 'save_scene').text
        self.spin(0.5)
        self._process.send_signal(signal.SIGKILL)
        self._process.wait()
        self._processes.forget(self._process)
        self.spin(0.5)
        self._judge()
        self.referee.begin_anew()
        self._start(text)

    def _start(self, text: str) -> None:
        path = self._folder / f'scene {self.counts["restart"]}.yaml'
        path.write_text(text)
        self._posed = {}
        both = frozenset(('left', 'right'))
        self.facts = self.facts._replace(unposed=both, is_exact=True)
        places = dict(self._places) if self._order or self.steps else {}
        now = time.monotonic()
        self._begin(Step(0, now, now, places, {}, self.facts), 0.0)
        self._process = self._processes.start(
            *(NODE, '--ros-args', '-p', f'scene_file:={path.as_posix()}', '-p'),
            *('use_sim_time:=true', '-p', f'stale_after:={STALE_AFTER}', '--log-level', 'error'),
        )
        self._meet()
        self.wait_for(self._poses.get_subscription_count, 'a listener to poses')
        wanted = {n for n, rule in self.facts.rules.items() if rule.enters_when_stale}

        def stand() -> bool:
            self._send_clock()
            known = self.monitor.rules
            return all(n in known and known[n].entered for n in wanted)

        self.wait_for(stand, 'the rules of the scene that was saved')
        self.spin(0.5)

    def _meet(self) -> None:
        """Ask until the node answers: a request to one that was killed, or is not met, is lost."""
        name = 'get_filters'
        client = self.node.create_client(srv.GetFilters, f'{SERVER}/{name}')
        self._clients[name] = client
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            future = client.call_async(srv.GetFilters.Request())
            again = time.monotonic() + ONE_CALL
            while not future.done() and time.monotonic() < again:
                rclpy.spin_once(self.node, timeout_sec=0.01)
            if future.done():
                return
            if self._process.poll() is not None:
                raise RuntimeError(f'the node ended: {self._process.stdout.read()}')
        raise TimeoutError(name)

    def run(self, seconds: float) -> None:
        """Let everything happen for so long, then look at the rest."""
        happenings = (
            *[self.add_rule] * 4, self.remove_rule, *[self.filter_pair] * 3, self.free_pair,
            self.set_level, self.stop_a_robot, self.pause, self.jump, self.deactivate,
        )  # fmt: skip
        start = restarted = time.monotonic()
        while time.monotonic() < start + seconds:
            for _ in range(EVERY):
                self.step(*self.random.choice([('left',), ('right',), ('left', 'right')]))
            if self._leases:
                self.know_filters()
            happening = self.random.choice(happenings)
            if time.monotonic() - restarted > max(8.0, seconds / 20.0):
                happening = self.restart
            self.counts[happening.__name__] += 1
            happening()
            if happening == self.restart:
                restarted = time.monotonic()
        self.step('left', 'right')
        self.spin(1.0)
        self._judge()
        if self.monitor.missed:
            self.referee.problems.append(f'{self.monitor.missed} events were missed')


def _seconds(stamp: Any) -> float:
    return float(stamp.sec + stamp.nanosec / 1_000_000_000)


def storm(seconds: float, seed: int = 0) -> Storm:
    """Let a storm rage for so long; return what came of it."""
    rclpy.init()
    try:
        with tempfile.TemporaryDirectory() as folder, Processes() as processes:
            raging = Storm(processes, Path(folder), seed)
            raging.run(seconds)
            return raging
    finally:
        rclpy.shutdown()


def run(options: argparse.Namespace) -> int:
    """Let it rage, print what came of it, and return the exit code."""
    raging = storm(60.0 * options.minutes, options.seed)
    referee, counts = raging.referee, raging.counts
    print(f'{options.minutes:g} minutes, {raging.steps} cycles, {referee.decisions} decisions '
          f'about {raging.rules} rules')  # fmt: skip
    print(', '.join(f'{count} {name}' for name, count in counts.most_common()))
    print(f'{len(referee.problems)} decisions missing, late, unfounded or told twice')
    for problem in referee.problems[:SHOWN]:
        print(f'  {problem}')
    return 1 if referee.problems or not referee.decisions else 0
