"""What the soak prints is what happened."""

from bench.ros.mix import Tally
from bench.ros.soak import Soak, report


def soaked(problems):
    tally = Tally(problems=problems)
    tally.calls.update({'get_pose': 7, 'save_scene': 3})
    tally.refusals.update({'get_pose: no such frame': 2})
    status = {'pose messages taken': '600', 'cycles': '599', 'pose messages refused': '5'}
    memory = [(1.0, 100.0), (2.0, 101.5), (3.0, 102.0)]
    return Soak(tally, hostile=6, player_lives=2, memory=memory, status=status)


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
        'p50 1.00, p99 2.00, p99.9 3.00, p100 4.50',
        '100.0 at the start, 101.5 half-way, 102.0 at the end',
        '1 answers that were not expected',
        'client_1: get_pose said False',
    ):
        assert words in text
