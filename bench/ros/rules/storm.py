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
import tempfile
import time
from collections import Counter
from pathlib import Path

import rclpy
from drake_geom_msgs import msg, srv
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter

from bench.ros.processes import Processes
from bench.ros.rules.cell import NAMES, PULSE, SHAPES, STALE_AFTER, Rule, drawn_rule, scene_text
from bench.ros.rules.records import Facts
from bench.ros.rules.steps import Steps
from drake_geom_ros.client import exclude_between

MOST_RULES = 20
EVERY = 8  # steps between two things that happen


class Storm(Steps):
    """Lets things happen between the steps."""

    def __init__(self, processes: Processes, folder: Path, seed: int) -> None:
        super().__init__(processes, folder, seed)
        self.counts = Counter[str]()
        self.rules = 0
        self._leases: dict[int, tuple[frozenset[str], float]] = {}
        self._filters: dict[int, frozenset[str]] = {}
        self.begin(scene_text())

    # What happens.

    def add_rule(self) -> None:
        """Add a rule; past the most that there are, remove one."""
        if len(self.facts.rules) >= MOST_RULES:
            return self.remove_rule()
        self.rules += 1
        rule = drawn_rule(self.rules, self.random)
        self.may(self._with(rule))
        answer = self.ask(
            *(srv.AddProximityRule, 'add_proximity_rule'), rule=msg.ProximityRule(**rule.fields())
        )
        if answer.success:
            self.change(rules={**self.facts.rules, rule.name: rule})
        elif 'could never be entered' not in answer.message:
            self.problems.append(answer.message)
        return None

    def _with(self, rule: Rule) -> Facts:
        return self.facts._replace(rules={**self.facts.rules, rule.name: rule})

    def remove_rule(self) -> None:
        """Remove a rule."""
        names = [name for name in self.facts.rules if name != PULSE.name]
        if names:
            name = self.random.choice(names)
            self._order[-1].removed.add(name)
            kept = {n: r for n, r in self.facts.rules.items() if n != name}
            self.change(rules=kept)
            self.ask(srv.RemoveProximityRule, 'remove_proximity_rule', name=name)

    def filter_pair(self) -> None:
        """Take a pair out, for good or for a while."""
        a, b = self.random.sample(NAMES, 2)
        lease = self.random.choice([0.0, 0.3])
        sets = (msg.GeometrySet(frames=[name]) for name in (a, b))
        declaration = msg.CollisionFilterDeclaration(statements=[exclude_between(*sets)])
        pair, sent = frozenset((a, b)), time.time()
        self.may(self.facts._replace(in_doubt=self.facts.in_doubt | {pair}))
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
            filtered = self.facts.filtered - {pair}
            in_doubt = self.facts.in_doubt | {pair}
            self.may(self.facts._replace(filtered=filtered, in_doubt=in_doubt))
            self.ask(srv.RemoveFilter, 'remove_filter', filter_id=number)
            self.know_filters()

    def know_filters(self) -> None:
        """Know which pairs are filtered, and of which that may have ended by itself."""
        now = time.time()
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
        end = time.time() + self.random.choice([0.3, 2.0]) * STALE_AFTER
        while time.time() < end:
            self.step(source)

    def pause(self) -> None:
        """Let all poses stop."""
        self.spin(self.random.choice([0.5, 4.0]) * STALE_AFTER)

    def jump(self) -> None:
        """Let the clock jump."""
        self.offset += self.random.choice([-500.0, 100.0, -3.0])
        self.change(unposed=frozenset(SHAPES))
        self._before.clear()

        def is_known() -> bool:
            self.send_clock()
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
        self.kill()
        self.judge()
        self.begin(text)

    def run(self, seconds: float) -> None:
        """Let everything happen for so long, then look at the rest."""
        happenings = (
            *[self.add_rule] * 8, self.remove_rule, *[self.filter_pair] * 3, self.free_pair,
            self.set_level, self.stop_a_robot, self.pause, self.jump, self.deactivate,
        )  # fmt: skip
        start = restarted = time.time()
        while time.time() < start + seconds:
            for _ in range(EVERY):
                self.step(*self.random.choice([('left',), ('right',), ('left', 'right')]))
            if self._leases:
                self.know_filters()
            happening = self.random.choice(happenings)
            if time.time() - restarted > max(10.0, seconds / 10.0):
                happening = self.restart
            self.counts[happening.__name__] += 1
            happening()
            if happening == self.restart:
                restarted = time.time()
        self.step('left', 'right')
        self.spin(1.0)
        self.judge()
        if missed := self.missed():
            self.problems.append(f'{missed} events were missed')


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
    print(f'{referee.silences} times a rule did not change at a step, '
          f'{referee.undecided} of them too near to a limit to be judged')  # fmt: skip
    print(f'{len(referee.problems)} decisions missing, late, unfounded or told twice')
    for problem in referee.problems:
        print(f'  {problem}')
    return 1 if referee.problems or not referee.decisions else 0
