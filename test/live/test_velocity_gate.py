"""A gate of commands: what it passes, and when it stops a robot without being asked."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.live.velocity_gate import LONGEST_UNDECIDED, Decision, VelocityGate

GO, HALF, STOP = Decision(1.0, ''), Decision(0.5, 'go slowly'), Decision(0.0, 'hands off')
COMMAND = np.array([1.0, 0.5, 0.0, 0.0, 0.0, -2.0])
TIMEOUT = 0.3


class Robot:
    """Hears what a gate passes."""

    def __init__(self, *, is_open=True):
        self.gate = VelocityGate(lambda twist, header: self.heard.append(twist), TIMEOUT)
        self.heard = []
        if is_open:
            self.gate.open()

    @property
    def velocity(self):
        """The last command (6,); at rest before any."""
        return self.heard[-1] if self.heard else np.zeros(6)

    def goes(self, scale):
        return self.velocity.tolist() == (COMMAND * scale).tolist()


def test_nothing_passes_before_the_rules_were_decided():
    robot = Robot()
    robot.gate.take(COMMAND, now=0.0)
    assert [each.any() for each in robot.heard] == [False]
    assert 'no cycle' in robot.gate.allowed(0.0).why
    robot.gate.decide(GO, now=0.1)
    assert robot.goes(0)
    robot.gate.take(COMMAND, now=0.2)
    assert robot.goes(1)


def test_a_command_is_scaled_in_all_its_parts():
    robot = Robot()
    robot.gate.decide(HALF, now=0.0)
    robot.gate.take(COMMAND, now=0.0)
    assert robot.goes(0.5)


def test_rest_is_sent_at_once_where_a_rule_stops_the_robot_and_less_where_one_slows_it():
    robot = Robot()
    robot.gate.decide(GO, now=0.0)
    robot.gate.take(COMMAND, now=0.0)
    robot.gate.decide(HALF, now=0.05)
    assert robot.goes(0.5)
    robot.gate.decide(STOP, now=0.1)
    assert robot.goes(0)
    assert robot.gate.stopped == 1
    robot.gate.take(COMMAND, now=0.15)
    assert robot.goes(0)
    sent = len(robot.heard)
    robot.gate.decide(GO, now=0.2)
    assert len(robot.heard) == sent  # a robot starts by a command, and not by a decision
    robot.gate.take(COMMAND, now=0.25)
    assert robot.goes(1)


def test_a_robot_that_stands_is_told_of_a_stop_too():
    robot = Robot()
    robot.gate.decide(GO, now=0.0)
    robot.gate.decide(STOP, now=0.1)
    assert len(robot.heard) == 1
    assert robot.goes(0)
    robot.gate.decide(STOP, now=0.2)
    assert len(robot.heard) == 1


def test_silence_of_commands_and_of_decisions_stops_the_robot():
    for command, decision, why in (
        (math.inf, 0.05, 'no command came'),
        (0.05, math.inf, 'nobody decided'),
    ):
        robot, now = Robot(), 0.0
        robot.gate.decide(GO, now)
        robot.gate.take(COMMAND, now)
        while now < 0.9:
            now += 0.05
            if decision < math.inf:
                robot.gate.decide(GO, now)
            if command < math.inf:
                robot.gate.take(COMMAND, now)
            robot.gate.look(now)
            is_due = now > (TIMEOUT if command == math.inf else LONGEST_UNDECIDED) + 1e-9
            assert robot.goes(0 if is_due else 1)
        assert why in robot.gate.allowed(now).why


def test_rest_is_repeated_for_a_while_after_a_stop_and_then_there_is_silence():
    robot = Robot()
    robot.gate.decide(GO, now=0.0)
    robot.gate.take(COMMAND, now=0.0)
    for k in range(100):
        robot.gate.look(now=1.0 + 0.05 * k)
    assert robot.goes(0)
    assert 5 < len(robot.heard) < 20


def test_a_closed_gate_stops_the_robot_and_one_that_is_opened_again_waits_for_a_decision():
    robot = Robot(is_open=False)
    robot.gate.decide(GO, now=0.0)
    robot.gate.take(COMMAND, now=0.0)
    assert robot.goes(0)
    robot.gate.open()
    robot.gate.decide(GO, now=0.0)
    robot.gate.take(COMMAND, now=0.0)
    assert robot.goes(1)
    robot.gate.close()
    assert robot.goes(0)
    robot.gate.take(COMMAND, now=0.1)
    robot.gate.open()
    robot.gate.take(COMMAND, now=0.1)
    assert robot.goes(0)


def test_a_command_that_has_to_be_proved_passes_by_the_decision_about_it():
    robot, other = Robot(), -COMMAND
    robot.gate.decide(GO, now=0.0, proved=robot.gate.command())
    robot.gate.take(COMMAND, now=0.01)
    assert robot.heard == []
    assert robot.gate.command().tolist() == COMMAND.tolist()
    robot.gate.decide(HALF, now=0.02, proved=robot.gate.command())
    assert robot.goes(0.5)
    robot.gate.take(other, now=0.03)
    assert robot.goes(0.5)
    robot.gate.decide(GO, now=0.04, proved=robot.gate.command())
    assert robot.goes(-1)
    robot.gate.take(np.zeros(6), now=0.05)  # rest needs no proof
    assert robot.goes(0)
    robot.gate.decide(GO, now=0.06, proved=other)
    assert robot.goes(0)
    robot.gate.take(COMMAND, now=0.07)
    robot.gate.decide(GO, now=0.08, proved=COMMAND)
    robot.gate.decide(STOP, now=0.09, proved=COMMAND)
    assert robot.goes(0)
    robot.gate.decide(GO, now=0.10, proved=COMMAND)
    assert robot.goes(1)
    robot.gate.look(now=0.5)
    assert robot.goes(0)


@pytest.mark.parametrize('number', [math.nan, math.inf, -math.inf])
def test_a_command_that_is_not_finite_stops_the_robot(number):
    robot = Robot()
    robot.gate.decide(GO, now=0.0)
    robot.gate.take(COMMAND, now=0.0)
    with pytest.raises(ArgumentError, match='must be finite'):
        robot.gate.take(np.array([number, 0, 0, 0, 0, 0]), now=0.1)
    assert robot.goes(0)


steps = st.one_of(
    st.tuples(st.just('take'), st.sampled_from([0.0, 1.0, -2.0])),
    st.tuples(st.just('decide'), st.floats(0.0, 1.0)),
    st.tuples(st.just('look'), st.none()),
    st.tuples(st.just('open'), st.none()),
    st.tuples(st.just('close'), st.none()),
)


@settings(deadline=None)
@given(st.lists(st.tuples(steps, st.sampled_from([0.0, 0.05, 0.2, 0.4, 0.7])), max_size=30))
def test_no_robot_is_faster_than_the_newest_decision_lets_the_newest_command_be(story):
    robot, now, is_open = Robot(is_open=False), 0.0, False
    command, heard, allowed, decided = 0.0, -math.inf, 0.0, -math.inf
    for (what, value), seconds in story:
        now += seconds
        if what == 'take':
            robot.gate.take(COMMAND * value, now)
            command, heard = value, now
        elif what == 'decide':
            robot.gate.decide(Decision(value, ''), now)
            allowed, decided = value, now
        elif what == 'look':
            robot.gate.look(now)
        else:
            getattr(robot.gate, what)()
            is_open = what == 'open'
            decided = -math.inf if is_open else decided
        if what in ('take', 'look'):
            is_silent = now - heard > TIMEOUT or now - decided > LONGEST_UNDECIDED
            limit = 0.0 if is_silent or not is_open else allowed
            assert (np.abs(robot.velocity) <= np.abs(COMMAND * command) * limit).all()
        if what == 'close':
            assert not robot.velocity.any()
