"""The mobile cell: no stop is late against the truth, with every sensor well and with faults."""

import sys
from pathlib import Path

import numpy as np
import pytest

FOLDER = Path(__file__).parents[2] / 'examples' / 'mobile_cell'


@pytest.fixture(scope='module')
def cell():
    sys.path.insert(0, str(FOLDER))
    try:
        import cell
    finally:
        sys.path.remove(str(FOLDER))
    return cell


def test_no_stop_is_late_and_the_robot_moves(cell):
    run = cell.Run().go(8.0)
    assert run.late == run.touched == []
    assert run.true_stops > 5, 'the referee had something to judge'
    assert 0 < run.stopped < run.steps
    assert 1.0 < run.gone < 8.0
    entered = {rule for rules in run.whys for rule in rules}
    assert {'person', 'obstacle'} <= entered <= {'person', 'obstacle', 'can stop'}


def test_the_gate_slows_the_base_to_what_is_proved(cell):
    run, slowed = cell.Run(), []
    decide = run.cell.decide

    def watched(command):
        entered = decide(command)
        passed = np.linalg.norm(run.cell.passed) / np.linalg.norm(command)
        if 0.0 < passed < 0.98 and not entered:
            slowed.append(passed)
        return entered

    run.cell.decide = watched
    run.go(8.0)
    assert slowed, 'no share between rest and the whole command was passed'


SENSORS = 'front', 'rear', 'camera', 'tracker'
FAULTS = [f'{sensor} {fault}' for sensor in SENSORS for fault in ('dies', 'is late')]
FAULTS += [f'{sensor} sees only the robot' for sensor in SENSORS[:3]] + ['tracker alternates']


@pytest.mark.parametrize('fault', FAULTS)
def test_a_fault_stops_the_robot(cell, fault):
    run = cell.Run(fault).go(1.6, fault_at=0.8)
    assert run.late == []
    assert run.true_stops > 0, 'the referee demanded no stop'


@pytest.mark.parametrize('sensor', SENSORS[:3])
def test_two_drivers_of_a_sensor_hide_nothing(cell, sensor):
    run = cell.Run(f'{sensor} alternates').go(4.0, fault_at=0.8)
    assert run.late == []
    assert run.stopped < run.steps


def test_every_fault_of_the_example_is_tried(cell):
    tried = [*FAULTS, *(f'{sensor} alternates' for sensor in SENSORS[:3])]
    assert sorted(cell.FAULTS) == sorted(tried)


def test_the_referee_sees_a_stop_that_is_late(cell, monkeypatch):
    """A node that decides nothing is late as soon as a body is near."""

    def pass_all(it, command):
        it.passed = command
        return {}

    monkeypatch.setattr(cell.Cell, 'decide', pass_all)
    assert cell.Run().go(8.0).late
