"""What the soak prints is what happened."""

from collections import Counter

import pytest

from bench.ros.driver import Soak
from bench.ros.mix import Tally
from bench.ros.soak import medians_by_minute, report, slope


def soaked(problems):
    tally = Tally(problems=problems)
    tally.calls.update({'get_pose': 7, 'save_scene': 3})
    tally.refusals.update({'get_pose: no such frame': 2})
    status = {'pose messages taken': '600', 'cycles': '599', 'pose messages refused': '5'}
    status |= {'service calls answered': '17', 'service calls not answered': '1'}
    memory = [(1.0, 100.0), (2.0, 101.5), (3.0, 102.0)]
    faults = Counter(burst=2, killed_clients=1)
    return Soak(tally, faults=faults, hostile=6, player_lives=2, memory=memory, status=status)


def test_a_report_tells_counts_delays_memory_and_problems(capsys):
    measured = {'results': 590, 'delay_ms': [1.0, 2.0, 3.0, 4.5]}
    report(soaked(['client_1: get_pose said False']), measured, 0.5)
    text = capsys.readouterr().out
    for words in (
        '590 results',
        '600 pose messages taken, 599 cycles',
        '6 hostile messages, 5 refused',
        '10 calls of 2 services',
        '2 get_pose: no such frame',
        '3 faults: 2 burst, 1 killed clients',
        '17 calls answered by the node, 1 not answered',
        'p50 1.00, p99 2.00, p99.9 3.00, p100 4.50',
        '100.0 at the start, 101.5 half-way, 102.0 at the end',
        'median of each minute: 101.5; in the second half it grew by +30.00 a minute',
        '1 answers that were not expected',
        'client_1: get_pose said False',
    ):
        assert words in text


def test_memory_is_told_for_each_minute_and_its_growth():
    flat = [(second, 100.0) for second in range(120)]
    assert medians_by_minute(flat) == [100.0, 100.0]
    assert slope(flat) == 0.0
    leak = [(second, 100.0 + second / 60.0) for second in range(150)]
    assert medians_by_minute(leak) == pytest.approx([100.5, 101.5, 102.25], abs=0.02)
    assert slope(leak) == pytest.approx(1.0)
    assert slope([(1.0, 5.0)]) == 0.0
