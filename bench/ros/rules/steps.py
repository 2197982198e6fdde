"""Moves two robots of loose bodies step by step, and keeps what was sent, known and heard."""

from __future__ import annotations

import math
import random
import time
from pathlib import Path
from typing import Any

import numpy as np
from drake_geom_msgs import msg

from bench.ros.processes import Processes
from bench.ros.rules.cell import NAMES, PULSE, SHAPES, STALE_AFTER
from bench.ros.rules.records import Facts, Heard, Posed, Step, Twist
from bench.ros.rules.referee import Referee
from bench.ros.rules.talk import PATIENCE, Talk, seconds
from drake_geom_ros.math import RigidTransform, RollPitchYaw

STRIDE, TURN, HALF = 0.02, 0.1, 0.35  # [m] and [rad] of a step, [m] half a side of the room


class Steps(Talk):
    """Steps, one after the other, and what is certain meanwhile."""

    def __init__(self, processes: Processes, folder: Path, seed: int) -> None:
        super().__init__(processes)
        self._folder = folder
        self.random, self._numbers = random.Random(seed), np.random.default_rng(seed)
        self.referee = Referee()
        self.problems = self.referee.problems  # one list of all that is wrong
        self.on_event = self._keep_event
        self._stamp = 0  # [ns] of the last step
        self.facts = Facts({PULSE.name: PULSE}, unposed=frozenset(SHAPES))
        self._places = {name: RigidTransform() for name in NAMES}
        self._placed: set[str] = set()  # robots that ever had a pose
        self._posed: dict[str, Posed] = {}
        self._before: dict[str, tuple[int, dict[str, RigidTransform]]] = {}  # stamp, poses
        self._steps: dict[float, Step] = {}  # by their stamp, as events tell it
        self._order: list[Step] = []
        self.steps, self.lives = 0, 0

    def _keep_event(self, event: Any) -> None:
        if event.stamp in self._steps:
            self._steps[event.stamp].events.append(Heard(event, time.time()))
        else:
            told = f'event {event.sequence} bears the stamp {event.stamp}, which no step has'
            self.problems.append(told)

    def step(self, *sources: str) -> None:
        """Move robots, and wait for the cycle of that."""
        self.send_clock()
        sent = time.time()  # before the stamp, by which ages are told, too
        self._stamp = int(1e9 * self.now())
        for name in NAMES:
            if name.partition('::')[0] in sources:
                self._places[name] = self._moved(self._places[name])
        message = msg.FramePoses(frame_names=[n for n in NAMES if n.partition('::')[0] in sources])
        message.header.stamp.sec, message.header.stamp.nanosec = divmod(self._stamp, 10**9)
        poses = [self._places[name] for name in message.frame_names]
        message.poses = np.ravel([X.ToArray() for X in poses]).tolist()
        facts = self.facts._replace(unposed=self.facts.unposed - set(sources))
        self._order[-1].until = sent
        self._placed |= set(sources)
        now = Step(self._stamp, sent, math.inf, self._stand(), {}, facts)
        key = seconds(message.header.stamp)
        self._begin(now, key)
        # A node whose time stood still may take a stamp for one of the future.
        rested, self.rested = max(self.rested, sent - self._ticked), 0.0
        self._send_until_reported(message, key)
        now.heard = time.time()
        for source in sources:
            self._posed[source] = Posed(sent - rested, now.heard, self._twists(source))
        now.posed = dict(self._posed)
        self.facts = facts
        self.steps += 1
        self.reported.clear()
        self.judge(all_but=5)

    def _stand(self) -> dict[str, RigidTransform]:
        """Return where the bodies are that ever had a pose."""
        there = self._places.items()
        return {name: X for name, X in there if name.partition('::')[0] in self._placed}

    def _send_until_reported(self, message: Any, key: float) -> None:
        """Publish poses until their cycle is known: what comes best effort may be lost."""
        end = time.time() + PATIENCE
        while key not in self.reported:
            if time.time() > end:
                raise TimeoutError('no cycle')
            self.poses.publish(message)
            again = time.time() + 1.0
            while key not in self.reported and time.time() < again:
                self._executor.spin_once(timeout_sec=0.005)

    def _twists(self, source: str) -> dict[str, Twist] | None:
        """Return how the bodies of a robot moved to where they are; None where nobody knows."""
        names = [name for name in NAMES if name.partition('::')[0] == source]
        now = {name: self._places[name] for name in names}
        stamp, before = self._before.get(source, (0, now))
        self._before[source] = self._stamp, now
        seconds = (self._stamp - stamp) * 1e-9
        if not stamp or not 0.0 < seconds <= STALE_AFTER:
            return None
        return {name: Twist.between(before[name], now[name], seconds) for name in names}

    def _begin(self, step: Step, key: float) -> None:
        self._order.append(step)
        self._steps[key] = step

    def _moved(self, X: RigidTransform) -> RigidTransform:
        way = self._numbers.normal(size=3)
        p = X.translation() + STRIDE * way / np.linalg.norm(way)
        p = np.where(np.abs(p) > HALF, 0.98 * np.clip(p, -HALF, HALF), p)
        turn = RollPitchYaw(*self._numbers.uniform(-TURN, TURN, 3)).ToRotationMatrix()
        return RigidTransform(X.rotation() @ turn, p)

    def judge(self, all_but: int = 0) -> None:
        """Let the referee look at the steps of which nothing more is heard."""
        while len(self._order) > all_but:
            step = self._order.pop(0)
            self.referee.look(step, self.pulses)
            self.pulses = [pulse for pulse in self.pulses if pulse >= step.until]
            self._steps = {k: s for k, s in self._steps.items() if s is not step}

    def change(self, **facts: Any) -> None:
        """Know that something holds from now on, or may hold since the last step."""
        self.facts = self.facts._replace(**facts)
        self.may(self.facts)

    def may(self, facts: Facts) -> None:
        """Know that something may hold from now on."""
        step = self._order[-1]
        step.changed = min(step.changed, time.time())
        step.later.append(facts)

    def begin(self, text: str) -> None:
        """Start a node with a scene, and know how its rules stand."""
        self.lives += 1
        path = self._folder / f'scene {self.lives}.yaml'
        path.write_text(text)
        self._posed, self._before, self._steps = {}, {}, {}
        self.facts = self.facts._replace(unposed=frozenset(SHAPES), is_exact=True)
        now = Step(0, math.inf, math.inf, self._stand(), {}, self.facts)
        self._begin(now, 0.0)
        self.start(path)
        now.sent = time.time()
        states = self.states()
        entered = dict(zip(states.rules.name, states.entered, strict=True))
        self.referee.begin_anew(states.next_sequence, entered)
        if set(entered) != set(self.facts.rules):
            self.problems.append(f'began with the rules {sorted(entered)}')
        self.spin(0.5)
